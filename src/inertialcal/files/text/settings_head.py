"""Heads of oscilloscopes and recorders: lines of settings above the numbers, known by their words.

``Sample Interval,1e-3``, ``Vertical Units,V``, ``"TraceName","CH1"`` (Tektronix, Keysight, LeCroy, Siglent, GW Instek,
Yokogawa), the start and step beside the names of columns (Rigol), settings beside the first rows (Tektronix TDS), or
``#CLOCK=10.0mS`` above the samples of each channel, one channel below the other (Hantek).
The table begins at its names, or at its numbers where it has none. Of the settings, the step of the samples is taken
where no column is the time, units and names where the table does not say them; all others are left out, counted.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

STEP = {"sampleinterval", "samplinginterval", "samplingperiod", "xinc", "xincrement", "hresolution", "increment"}
X_UNIT, Y_UNIT = {"horizontalunits", "xunits", "hunit"}, {"verticalunits", "yunits", "vunit"}
NAMES = {"source", "tracename"}
OTHERS = {
    "recordlength", "waveformtype", "pointformat", "horizontalscale", "verticalscale", "triggerpoint", "segments",
    "memorylength", "triggeraddress", "xorg", "xref", "hoffset", "blocksize", "blocknumber", "probeattenuation",
    "zeroindex", "waveformdata", "intpdistance",
}  # fmt: skip
BESIDE_OF = 3  # columns of settings left of a table
LECROY = "lecroy"  # how the first line begins
FEW, LONGEST = 2, 80  # lines of settings that tell such a head, and lines that it takes at most
WIDEST = 10_000  # characters of a line
NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
BESIDE = re.compile(r"\s*t(?:0|Inc)\s*=\s*([-+0-9.eE]+)\s*(?:s\s*)?", re.IGNORECASE)  # among the names of columns
TRACE = re.compile(r"((?:CH|MATH|REF|D)[0-9]{1,2})(V|A)", re.IGNORECASE)
OVER_X = re.compile(r"X\(((?:CH|MATH)[0-9]{0,2})\)", re.IGNORECASE)
MARKED = re.compile(r"#[ \t]*(CHANNEL|CLOCK|SIZE|UNITS?)[ \t]*[:=][ \t]*([^\r\n]*)", re.IGNORECASE)  # of Hantek
CLOCK = re.compile(rf"({NUMBER.pattern})[ \t]*([munp\u00b5]?)s", re.IGNORECASE)
PART = {"": 1.0, "m": 1e-3, "u": 1e-6, "\u00b5": 1e-6, "n": 1e-9, "p": 1e-12}
SPELLED = {"s": "s", "v": "V", "volt": "V", "volts": "V", "second": "s", "ampere": "A", "amp": "A"}


@dataclass(frozen=True)
class Settings:
    """What stands above a table."""

    lines: int  # of the head, the names of the columns not among them
    step: float | None  # of the samples [s]; None where the head does not say it
    names: tuple[str, ...] = ()  # of columns that the table does not name itself
    units: tuple[str, ...] = ()
    below: int = 0  # lines of names and units that ``names`` and ``units`` stand for


def settings_of(lines: Sequence[str]) -> Settings | None:
    """Return the settings above a table of numbers, whose lines are given; None where none stand there."""
    if len(lines) < FEW + 1 or max(map(len, lines)) > WIDEST:
        return None
    head = [[cell.strip().strip('"').strip() for cell in line.split(_sign(line))] for line in lines[: LONGEST + 2]]
    return _rigol(head) or _above(head)


def settings_beside(text: str) -> tuple[str, tuple[str, str], tuple[str, str]] | None:
    """Return a text without the settings that stand left of its first rows, names and units of its two columns."""
    if not text.startswith("Record Length,"):
        return None
    rows = [line.split(",") for line in text[: LONGEST * LONGEST].split("\n")[:LONGEST] if line.strip()][:-1]
    said = {_word(row[0]): row[1].strip() for row in rows if len(row) > 2 and row[0].strip()}
    if "sampleinterval" not in said or not all(len(row) >= BESIDE_OF + 2 for row in rows):
        return None
    if not all(NUMBER.fullmatch(row[k].strip()) for row in rows for k in (BESIDE_OF, BESIDE_OF + 1)):
        return None
    made = [",".join(line.split(",")[BESIDE_OF : BESIDE_OF + 2]) for line in text.split("\n")]
    units = [next((said[key] for key in said if key in known), "") for known in (X_UNIT, Y_UNIT)]
    x_unit, y_unit = (SPELLED.get(one.lower(), one) for one in units)
    return "\n".join(made), ("time", said.get("source") or "CH1"), (x_unit, y_unit)


def settings_above_channels(text: str) -> tuple[str, tuple[str, ...], tuple[str, ...]] | None:
    """Return a text of Hantek with a column a channel, its sample rate in a comment; names and units of its columns."""
    if not text.startswith("#"):
        return None
    head: list[dict[str, str]] = []
    channels: list[list[str]] = []
    lines = text.split("\n")
    begun = True  # a channel: its numbers come next
    for line in lines:
        marked = MARKED.match(line)
        if marked is None:
            if line.strip() and not line.startswith("#"):
                if not channels:
                    return None
                channels[-1].append(line.strip().rstrip(","))
                begun = True
            continue
        if begun:
            head.append({})
            channels.append([])
            begun = False
        head[-1][marked[1].upper()] = marked[2].strip().rstrip(",")
    clock = CLOCK.fullmatch(head[0].get("CLOCK", "")) if head else None
    if clock is None or not channels[0] or float(clock[1]) <= 0.0:
        return None
    width = [1 + one[0].count(",") if one else 1 for one in channels]
    rows = [",".join(cells) for cells in zip_longest(*channels, fillvalue="")]
    rate = 1.0 / (float(clock[1]) * PART[clock[2].lower()])
    first = next(i for i, line in enumerate(lines) if line.strip() and not line.startswith("#"))
    names = [one.get("CHANNEL") or f"CH{k + 1}" for k, one in enumerate(head)]
    units = [one.get("UNITS") or one.get("UNIT") or "" for one in head]
    if max(width) > 1:  # all channels side by side
        names, units = [f"CH{k + 1}" for k in range(width[0])], units[:1] * width[0]
    made = [f"# sample rate: {rate!r} Hz", *[""] * (first - 1), *rows]
    return "\n".join(made) + "\n", tuple(names), tuple(SPELLED.get(one.lower(), one) for one in units)


def _sign(line: str) -> str:
    return next((sign for sign in (",", ";", "\t") if sign in line), ",")


def _word(cell: str) -> str:
    return "".join(filter(str.isalpha, cell)).lower()


def _is_row(cells: Sequence[str]) -> bool:
    """Whether all cells that are filled are numbers, the first one among them."""
    return bool(NUMBER.fullmatch(cells[0])) and all(NUMBER.fullmatch(cell) for cell in cells if cell)


def _filled(cells: Sequence[str]) -> list[str]:
    """Return cells without the empty ones at their end."""
    return list(cells[: max((i + 1 for i, cell in enumerate(cells) if cell), default=0)])


def _step(cells: Sequence[str]) -> float | None:
    """Return the first number of a setting that is a step [s]."""
    found = next((one for cell in cells if (one := NUMBER.fullmatch(cell.rpartition(":")[2]))), None)
    return float(found[0]) if found is not None and float(found[0]) > 0.0 else None


def _rigol(head: Sequence[Sequence[str]]) -> Settings | None:
    """Return what stands in the line of names: ``X,CH1,Start,Increment`` over its numbers, ``CH1V,t0 = ..,tInc = ..``.

    Rows below are numbered, or have no time, or have one.
    """
    if len(head) < 3:
        return None
    names, width = _filled(head[0]), len(head[2])
    words = [one.lower() for one in names]
    if words[-2:] == ["start", "increment"] and len(head[1]) >= len(names):
        traces, units, step = names[1:-2], head[1][1 : len(names) - 2], _step([head[1][len(names) - 1]])
        if step is None or width <= len(traces) or not _is_row(head[2]):
            return None
        blank = [""] * (width - 1 - len(traces))
        spelled = [SPELLED.get(one.lower(), one) for one in units]
        return Settings(0, step, ("sequence", *traces, *blank), ("", *spelled, *blank), 2)
    over = [match[1] for one in names[1:] if (match := OVER_X.fullmatch(one))]
    if over and len(over) == len(names) - 1 == len(_filled(head[1])) - 1 and _is_row(head[2]):
        blank = [""] * (width - len(names))
        spelled = [SPELLED.get(one.lower(), one) for one in head[1][: len(names)]]
        return Settings(0, None, (names[0], *over, *blank), (*spelled, *blank), 2)
    own = [one for one in names if not BESIDE.fullmatch(one)]
    beside = [match for one in names if (match := BESIDE.fullmatch(one))]
    if len(beside) < FEW or not own or width < len(own) or not _is_row(head[1]):
        return None
    found = [TRACE.fullmatch(one) for one in own]
    rest = [""] * (width - len(own))
    called = [one if trace is None else trace[1] for one, trace in zip(own, found, strict=True)]
    units = ["" if trace is None else trace[2].upper() for trace in found]
    step = _step([beside[-1][1]]) if not words[0].startswith("time") else None
    return Settings(0, step, (*called, *rest), (*units, *rest), 1)


def _above(head: Sequence[Sequence[str]]) -> Settings | None:
    """Return settings that stand line by line above the table."""
    keys = [_word(cells[0]) for cells in head]
    is_lecroy = bool(keys) and keys[0].startswith(LECROY)
    known = [i for i, one in enumerate(keys) if one in STEP | X_UNIT | Y_UNIT | OTHERS]
    first = next((i for i, cells in enumerate(head[:-1]) if _is_row(cells) and len(head[i + 1]) == len(cells)), 0)
    known = [i for i in known if i < first]
    if not first or (len(known) < FEW and not (known and is_lecroy)) or not _is_row(head[first + 1]):
        return None
    said = {key: _filled(cells[1:]) for key, cells in zip(keys[:first], head[:first], strict=True)}
    width = len(_filled(head[first]))
    begin = _table(head, keys, first, width)
    step = next((one for key in said if key in STEP and (one := _step(said[key]))), None)
    x_unit = next((said[key][0] for key in said if key in X_UNIT and said[key]), "s" if is_lecroy else "")
    y_units = next((said[key] for key in said if key in Y_UNIT and said[key]), [])
    traces = next((said[key] for key in said if key in NAMES and said[key]), [])
    has_time = width == len(traces) + 1 if traces and begin == first else width > 1
    of_traces = width - has_time
    y_units = y_units * of_traces if len(y_units) == 1 else y_units
    names: list[str] = []
    if begin == first:
        traces = traces if len(traces) == of_traces else [f"CH{i + 1}" for i in range(of_traces)]
        names = [*(["time"] * has_time), *traces]
    units = [x_unit] * has_time + (y_units if len(y_units) == of_traces else [""] * of_traces)
    blank = [""] * (len(head[first]) - width)
    units = [SPELLED.get(one.lower(), one) for one in units]
    return Settings(begin, None if has_time else step, (*names, *blank) if names else (), (*units, *blank))


def _table(head: Sequence[Sequence[str]], keys: Sequence[str], first: int, width: int) -> int:
    """Return the line of the names of the columns, above their units if those stand there; else the first row."""
    found = first
    for i in range(first - 1, max(first - 3, 0), -1):
        cells = _filled(head[i])
        if len(cells) != width or any(NUMBER.fullmatch(cell) or not cell for cell in cells):
            break
        if keys[i] in STEP | X_UNIT | Y_UNIT | OTHERS or (keys[i] in NAMES and i == first - 1):
            break
        found = i
    return found
