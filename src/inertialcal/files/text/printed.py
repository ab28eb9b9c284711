"""Lines as boards and terminals print them, made rows of a table: stamps of a serial monitor, labels, check sums.

``12:03:14.123 -> 1.0,2.0`` (Arduino's serial monitor), ``gx:1.0 gy:2.0`` (its plotter, sketches of sensor libraries),
``$VNIMU,...*5A`` (sentences with a check sum, as NMEA 0183 has them), ``0.01 sec`` (durations of a MATLAB timetable);
rows beside or above which an oscilloscope wrote its settings.

References
----------
.. [1] VectorNav VN-100 user manual, register 54: magnetic field [Gauss], acceleration, angular rate, temperature [C],
   pressure [kPa].
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import xor

from ...core.errors import DataError
from ...core.remarks import Remark
from .settings_head import settings_above_channels, settings_beside

LOOKED_AT = 50  # lines that tell whether a text is printed so
LONGEST = 2000  # characters of a line
_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
STAMPED = re.compile(r"\s*([0-9]{1,2}:[0-9]{2}:[0-9]{2}(?:\.[0-9]{1,9})?)\s*->\s?(.*)")
PAIR = re.compile(rf"([A-Za-z_][\w.]*)[ \t]*[:=][ \t]*({_NUMBER})(?=[\s,;|]|$)")
WORD = re.compile(r"[A-Za-z_][\w.]*[ \t]*[:=]")  # above some pairs: CALIBRATION: Sys=3 Gyro=3
CELLS = re.compile(rf"{_NUMBER}(?:(?:\s*[,;\t]\s*|\s+){_NUMBER})*")
SENTENCE = re.compile(r"\$(\w+),(.*)\*([0-9A-Fa-f]{2})\s*")
DURATION = re.compile(rf"({_NUMBER}) (sec|min|hr|days)(?=[,;\t])")
UNIT = {"sec": "s", "min": "min", "hr": "h", "days": "d"}
OF_AXES = [f"{what}_{axis} [{unit}]" for what, unit in (("mag", "gauss"), ("acc", "m/s^2"), ("gyro", "rad/s"))
           for axis in "xyz"]  # fmt: skip
FIELDS = {"VNIMU": (*OF_AXES, "temperature [degC]", "pressure [kPa]")}
# A multimeter's reading: ``+2.50392122E+00VDC``
METERED = re.compile(rf"\s*({_NUMBER}) ?([A-Za-z%°µΩ#]*)\s*")
NUMBERED = "RDNG#"  # unit that a multimeter gives the number of its reading
TRACES, VALUES = "trace_names", "trace_values"  # words of dSPACE ControlDesk
Row = tuple[tuple[str, ...], list[str]]  # names, cells


@dataclass(frozen=True)
class Printed:
    """A text whose lines were made rows of a table with commas, each where it was."""

    text: str
    names: tuple[str, ...]  # One a column; empty where the header of the text names them
    units: tuple[str, ...]  # One a column; empty where the names say them
    remarks: tuple[Remark, ...]


def as_table(text: str, where: str) -> Printed | None:
    """Return a text as a table where its lines are printed in one of these ways; None elsewhere.

    Raises
    ------
    DataError
        ``ragged_row``, if a line between the rows is none.
    """
    if f"\n{VALUES}" in text[: LOOKED_AT * LONGEST]:
        return _traces(text)
    if (above := _with_settings(text, where)) is not None:
        return above
    lines = text[: LOOKED_AT * LONGEST].split("\n")[:LOOKED_AT]
    start = [one for one in lines if one.strip() and len(one) < LONGEST]
    if sum(one.startswith("$") for one in start) * 2 > len(start):
        return _sentences(text, where)
    if len(start) > 1 and all(DURATION.match(one) for one in start[1:]):
        return _durations(text)
    if start and (metered := _metered(text, start)) is not None:
        return metered
    return _printed_rows(text, start, where)


def _with_settings(text: str, where: str) -> Printed | None:
    if (beside := settings_beside(text)) is not None:
        remark = Remark("preamble", "info", "settings beside the first rows ignored: 'Record Length' ...", where=where)
        return Printed(*beside, (remark,))
    above = settings_above_channels(text)
    return None if above is None else Printed(*above, ())


def _printed_rows(text: str, start: Sequence[str], where: str) -> Printed | None:
    rows = [row for one in start if (row := _row(one))]
    return _printed(text, rows[-1][0], where) if 2 * len(rows) > len(start) > 1 else None


def _row(line: str) -> Row | None:
    """Return names and cells of a printed line; None of one that is not printed so."""
    stamped = STAMPED.fullmatch(line)
    body = line if stamped is None else stamped[2]
    pairs = _pairs(body)
    if pairs and not WORD.sub("", PAIR.sub("", body)).strip(" \t,;|\r"):
        names, cells = tuple(name for name, _ in pairs), [value for _, value in pairs]
    elif stamped is not None and CELLS.fullmatch(body.strip()):
        cells = re.split(r"\s*[,;\t]\s*|\s+", body.strip())
        names = tuple("" for _ in cells)
    else:
        return None
    return (names, cells) if stamped is None else (("time", *names), [stamped[1], *cells])


def _pairs(body: str) -> list[tuple[str, str]]:
    """Return names and numbers of a line; a word above some of them stands before their names: ``Accel.x``."""
    if "=" not in body and ":" not in body:
        return []
    found, above, at = list[tuple[str, str]](), "", 0
    for one in PAIR.finditer(body):
        words = WORD.findall(body[at : one.start()])
        above, at = words[-1].rstrip(" \t:=") if words else above, one.end()
        found.append((f"{above}.{one[1]}" if above else one[1], one[2]))
    return found


def _printed(text: str, names: tuple[str, ...], where: str) -> Printed | None:
    made, notes, begun, header = list[str](), list[str](), False, tuple[str, ...]()
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        row = _row(line) if line.strip() else None
        if row is not None and row[0] == names:
            begun = True
            made.append(",".join(row[1]))
        elif not line.strip() or (begun and number == len(lines)):  # the last may be cut off
            made.append("")
        elif not begun:
            header = _header(line, names)
            notes += [] if header else [line]
            made.append("")
        else:
            what, why = f"this line is not like the others: {line.strip()[:40]!r}", "a message of the board?"
            raise DataError(what, f"{where}:{number}", why, "Delete the line", "ragged_row")
    names = header or names
    what = f"lines as a board prints them: columns {', '.join(name or '(no name)' for name in names)}"
    remarks = [Remark("printed_lines", "info", what[:120], where=where)]
    if notes:
        what = f"{len(notes)} line(s) before the table ignored: {notes[0].strip()[:60]!r} ..."
        remarks.append(Remark("preamble", "info", what, where=where))
    return Printed("\n".join(made), names, (), tuple(remarks))


def _header(line: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names that a board printed above rows of numbers alone; empty where the line is none."""
    stamped = STAMPED.fullmatch(line)
    if stamped is None or any(names[1:]):
        return ()
    cells = re.split(r"\s*[,;\t]\s*", stamped[2].strip())
    words = all(re.search("[A-Za-z]", cell) for cell in cells)
    return ("time", *cells) if words and len(cells) == len(names) - 1 else ()


def _metered(text: str, start: Sequence[str]) -> Printed | None:
    """Return readings of a multimeter, each with its unit behind it and no header, as numbers; None elsewhere."""
    first = [METERED.fullmatch(cell) for cell in start[0].split(",")]
    said = [one[2] for one in first if one is not None]
    if len(said) != len(first) or not any(said):
        return None
    made = []
    for line in text.split("\n"):
        cells = [METERED.fullmatch(cell) for cell in line.split(",")]
        if line.strip() and [one[2] for one in cells if one is not None] != said:
            return None
        made.append(",".join(one[1] for one in cells if one is not None) if line.strip() else "")
    names = tuple("reading number" if unit == NUMBERED else "" for unit in said)
    return Printed("\n".join(made), names, tuple("" if unit == NUMBERED else unit for unit in said), ())


def _traces(text: str) -> Printed | None:
    """Return an export of dSPACE ControlDesk as a table: a word stands before names, units and values."""
    words: dict[str, list[str]] = {}
    lines = text.split("\n")
    for number, line in enumerate(lines):
        sign = next((one for one in ";,\t" if one in line), ";")
        word, *cells = (cell.strip(' "\r') for cell in line.split(sign))
        if word != VALUES:
            words[word] = cells
            continue
        names = words.get(TRACES, [])
        rows = [row.partition(sign)[2] for row in lines[number:]]
        if not names or len(rows) < 2 or sign not in lines[number + 1]:
            return None
        units = words.get("unit", [""] * len(names))
        return Printed("\n".join([""] * number + rows), tuple(names), tuple(units[: len(names)]), ())
    return None


def _sentences(text: str, where: str) -> Printed | None:
    """Return sentences of one kind as rows; those whose check sum is another are left out, counted."""
    made, wrong, kind, width = list[str](), list[int](), "", 0
    for number, line in enumerate(text.split("\n"), 1):
        found = SENTENCE.fullmatch(line)
        if found is None:
            if line.strip() and kind and number <= text.count("\n"):  # the last may be cut off
                wrong.append(number)
            made.append("")
            continue
        cells = found[2].split(",")
        if (kind or found[1]) != found[1] or (width or len(cells)) != len(cells):
            return None  # of several kinds
        kind, width = found[1], len(cells)
        if reduce(xor, f"{found[1]},{found[2]}".encode()) != int(found[3], 16):
            wrong.append(number)
            made.append("")
        else:
            made.append(",".join(cells))
    if not kind:
        return None
    remarks = [Remark("printed_lines", "info", f"sentences ${kind}, whose check sums are right", where=where)]
    if wrong:
        what = "sentences whose check sum is wrong, or that are not whole: left out"
        remarks.append(Remark("damaged_records", "warning", what, f"{where}:{wrong[0]}", len(wrong)))
    fields: Sequence[str] = FIELDS.get(kind, ())
    names = tuple(fields) if len(fields) == width else ("",) * width
    return Printed("\n".join(made), names, (), tuple(remarks))


def _durations(text: str) -> Printed | None:
    """Return a table whose first column is a duration with its unit as one of numbers; None where units differ."""
    head, *rows = text.split("\n")
    found = [DURATION.match(one) for one in rows]
    said = {one[2] for one in found if one is not None}
    if len(said) != 1 or any(one is None and row.strip() for one, row in zip(found, rows, strict=True)):
        return None
    made = [row if one is None else one[1] + row[one.end() :] for one, row in zip(found, rows, strict=True)]
    return Printed("\n".join([head, *made]), (), (UNIT[said.pop()],), ())
