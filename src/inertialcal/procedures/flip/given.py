"""The campaign entry of a file of a flip: a table of means, or a recording of a turned head with its windows.

Names and units of columns say which column is what. Windows are those of the caller, else found beside the turns that
the record shows; both become ``positions`` of the entry.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, UsageError
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.remarks import Remark
from ...core.times import elapsed_text, instant_text
from ...core.unit.magnitudes import check_readings
from ...core.units import convert_as_wide, factor, kind, normalise, parse_quantity
from ...files.info.describe import overridden
from ...files.pad.pairs import sensor_frame
from ...files.text.headers import bare_name
from ...files.text.table import Table
from ...files.time.window import Window as Between
from ...signals.segmentation.turn_windows import turn_windows
from ...signals.segmentation.turns import Turn
from ...signals.sense.limits import impossible
from ..archived import seconds_of, turns_of
from ..given import (
    RAW,
    Described,
    GivenFile,
    bare,
    chain_of_units,
    chain_remarks,
    chain_said,
    raw_advice,
    raw_units,
    sensor_said,
    spoken_unit,
)
from ..given import described as described_channels
from ..protocol import InputSpec
from .dwells.disturbances import stamped
from .dwells.quiet import Window
from .entry import Position
from .inputs import windows_of

PATTERNS = {
    "axis": r"^(axis|channel|sensor)$",
    "position": r"^(position|orientation|attitude|turned)$",
    "flip": r"^(flip|rotation|turn|time|time_id)$",
    "mean": r"(^|_)(mean|average|reading|acceleration|acc)(_|$)",
    "temperature": r"(^|_)(temp|temperature)(_|$)",
    "predicted": r"(^|_)predicted(_|$)",
}
OUTPUT = r"(^|_)(voltage|volts|output)(_|$)"  # a mean where no column is called one
WIDTH = re.compile(r"(?:^|_)half_width_(\d\d)(?:_|$)")
TABLES = {".csv", ".txt", ".tsv", ".gz"}
HALF_TURN = "180 deg"
ENOUGH = 10_000  # samples that show a level
MICRO = 0.01  # [g], below which a head in g is shown in ug
MOST = 8  # times in a message


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the entry and the sensor of a file.

    Raises
    ------
    UsageError
        If it is not clear which column is what, in which unit, or how the head was turned.
    """
    if is_means_file(given):
        if given.own.get("windows"):
            what = f"{given.name}: a table of means has no windows"
            raise UsageError(what, do="Leave them out", code="wrong_value")
        return _described_means(given)
    if given.own.get("positions") and not any(is_means_file(one) for one in given.together):
        what = f"{given.name}: positions are those of a table of means: this is a recording"
        raise UsageError(what, do=f"Add: {_windows_text(given)}", code="wrong_value")
    recording, frame = read_head(given)
    if recording.stamps is None:
        why = "windows are found on a clock"
        do = "Give the sample rate, or name the time column. A table of means has a row an axis and position: axis, "
        do += "position, mean [ug]"
        raise UsageError(f"{given.name}: no time", "", why, do, "no_time")
    base = described_channels(given, spec)
    channels = base.entry["channels"] | _other_channels(recording, base.entry["channels"])
    head = head_recording(recording, channels)
    positions, remarks = positions_of(given, head)
    entry = {**base.entry, "channels": channels, "positions": positions} | ({"frame": frame} if frame else {})
    thin = slice(None, None, 1 + len(head) // ENOUGH)
    levels = [head.channel(axis).data[thin] * factor("m/s^2", "g") for axis in base.sensor["axes"]]
    sensor = {**base.sensor, "unit": _shown(base.sensor["unit"], levels)}
    return Described(entry, sensor, base.columns, remarks=remarks)


def _described_means(given: GivenFile) -> Described:
    """Return the entry and the sensor of a table of means: in units of acceleration, or through the chain that is said.

    Raises
    ------
    UsageError
        As `described`; ``no_unit`` for counts or volts without what makes them readings; ``unit_mismatch``.
    """
    means, columns = means_columns(given)
    unit, header = means["unit"], given.table.unit(means["mean"])
    chain = chain_of_units(given, chain_said(given, "accelerometer"), [unit])
    raw = raw_units(chain)
    if kind(unit) not in (raw or ("acceleration",)):
        counted = kind(unit) in RAW
        what = f"means in {unit}" if counted else f"means in {unit}: not a unit of acceleration"
        why = "counts and volts need the chain of the sensor" if counted else ""
        do = (
            raw_advice(given, [unit], "g") if counted else "Correct the unit: g, ug, m/s2; V and count with their chain"
        )
        raise UsageError(what, given.name, why, do, "no_unit" if counted else "unit_mismatch")
    overruled = overridden([(means["mean"], header and normalise(header), unit)], given.name)
    remarks = (*overruled, *chain_remarks(given, chain, [unit]))
    axes = [axis for axis in AXES if axis in {one.lower() for one in given.table.text(means["axis"])}] or [*AXES]
    levels = [] if raw else [given.table.numbers(means["mean"]) * factor(unit, "g")]
    spoken = spoken_unit("accelerometer", chain) if raw else _shown(unit, levels)
    return Described({"means": means}, sensor_said(given, "accelerometer", axes, spoken, chain), columns,
                     remarks=remarks)  # fmt: skip


def like(given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[Remark, ...]]:
    """Return an entry of another campaign as it holds for this file: its own windows, where they lie in the record.

    Raises
    ------
    UsageError
        If they do not, and no turn of the head is found.
    """
    if "means" in entry:
        means = entry["means"]
        return {**entry, "means": {**means, "angles": {**means["angles"], **given.own.get("positions", {})}}}, ()
    head = head_recording(given.read(frame=entry.get("frame")), entry["channels"])
    stated = windows_of([Position.model_validate(one) for one in entry.get("positions", ())], head, given.name)
    if stated and not given.own.get("windows") and all(_touches(head, one) for one in stated):
        return dict(entry), ()
    positions, remarks = positions_of(given, head)
    return {**entry, "positions": positions}, remarks


def read_head(given: GivenFile) -> tuple[Recording, str | None]:
    """Return a recording and its frame: archive records are read in the axes of their sensor."""
    frame = given.said.frame or (sensor_frame(given.name) if given.has_rows else None)
    return given.read(frame=frame), frame


def head_recording(recording: Recording, channels: Mapping[str, Mapping[str, Any]]) -> Recording:
    """Return a recording with channels ``x``, ``y``, ``z`` of a head [m/s^2], those in counts as they are.

    Raises
    ------
    DataError
        ``impossible_value`` for a reading that no sensor gives.
    """
    made = []
    for axis in (one for one in AXES if one in channels):
        channel, unit = recording.channel(channels[axis]["column"]), channels[axis]["unit"]
        check_readings(channel.name, channel.data, channel.unit, recording.place)
        sensed = kind(unit) == "acceleration"
        data = convert_as_wide(channel.data, unit, "m/s^2") if sensed else channel.data
        out = impossible(data, "m/s^2" if sensed else None, axis, recording.place).flags
        data = np.where(out, np.nan, data) if out.any() else data
        made.append(Channel(axis, data, "m/s^2", channel.unit_from, axis))
    return stamped(replace(recording, channels=tuple(made)))


def _other_channels(recording: Recording, taken: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Return the channels of temperature and of recorded gains, where names and units are clear."""
    columns = {one["column"] for one in taken.values()}
    gains = {f"gain_{axis}" for axis in AXES if axis in taken} | {"gain"}
    found = {name: {"column": name, "unit": "1"} for name in recording.names if name in gains - columns}
    warm = {
        one.axis: {"column": one.name, "unit": one.unit}
        for one in recording.channels
        if one.quantity == "temperature" and one.unit and kind(one.unit) == "temperature" and one.name not in columns
    }
    if len(warm) == 1:
        return found | {"temperature": next(iter(warm.values()))}
    return found | {f"temperature_{axis}": one for axis, one in warm.items() if axis in taken}


def _shown(unit: str, values: Sequence[NDArray[Any]]) -> str:
    """Return the unit of the figures: ug for a head in g that feels next to nothing, as in orbit."""
    levels = [abs(float(np.median(one[np.isfinite(one)]))) for one in values if np.isfinite(one).any()]
    return "ug" if unit == "g" and levels and max(levels) < MICRO else unit


# ---- tables of means --------------------------------------------------------------------------------------------


def is_means_file(given: GivenFile) -> bool:
    """Tell whether a file is a table of means."""
    path = Path(given.name)
    return given.has_rows and path.suffix.lower() in TABLES and path.is_file() and is_table_of_means(given.table)


def is_table_of_means(table: Table) -> bool:
    """Tell whether a file is a table of means: a column of axes, and one of positions."""
    return _column(table.names, "axis") is not None and _column(table.names, "position") is not None


def means_columns(given: GivenFile) -> tuple[dict[str, Any], dict[str, str]]:
    """Return ``means`` of the entry of a table, and which column is what.

    Raises
    ------
    UsageError
        If a column, the unit or the angle of a position is not clear.
    """
    table, said = given.table, given.said.columns
    if strange := [what for what in said if what not in PATTERNS]:
        raise UsageError(f"column {strange[0]!r}", do=f"There are: {', '.join(PATTERNS)}", code="unknown_name")
    columns = {what: said.get(what) or _column(table.names, what) for what in PATTERNS}
    mean = columns["mean"]
    if mean is None:
        what = f"{given.name}: cannot tell which column is the mean; it has {', '.join(table.names)}"
        raise UsageError(what, do=f"Add: {given.add('column', 'mean=COLUMN')}", code="no_column")
    units = given.said.units
    named = {mean, bare_name(mean), "mean", "acc"}
    said_unit, header = next((units[one] for one in units if one in named), None) or bare(units), table.unit(mean)
    stated = said_unit or header
    if stated is None:
        what = f"{given.name}: unit of {mean!r} not given"
        raise UsageError(what, do=f"Add: {given.add('unit', 'ug')}; g, V, count, ... as it is", code="no_unit")
    if header is not None and kind(header) in RAW and kind(normalise(stated)) not in RAW:
        what = f"{given.name}: {mean!r} is in {header} by its header, not in {stated}"
        why = "counts and volts need the chain of the sensor"
        raise UsageError(what, "", why, raw_advice(given, [header], "g"), "unit_mismatch")
    angles = {}
    for position in dict.fromkeys(table.text(str(columns["position"]))):
        angles[position] = given.own.get("positions", {}).get(position, position)
        try:
            parse_quantity(angles[position]).to("rad")
        except DataError:
            do = f"Add: {given.add('position', f'{position}=ANGLE deg')}"
            raise UsageError(f"{given.name}: position {position!r} has no angle", do=do, code="no_angle") from None
    found = {what: name for what, name in columns.items() if name is not None}
    widths = {f"0.{match[1]}": name for name in table.names if (match := WIDTH.search(_key(name)))}
    means: dict[str, Any] = {**found, "unit": normalise(stated), "angles": angles}
    return means | ({"half_widths": widths} if widths else {}), found


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


def _column(names: Sequence[str], what: str) -> str | None:
    patterns = (PATTERNS[what], OUTPUT) if what == "mean" else (PATTERNS[what],)
    each = ([name for name in names if re.search(one, _key(name)) and not WIDTH.search(_key(name))] for one in patterns)
    found = next((names for names in each if names), [])
    return found[0] if len(found) == 1 else None


# ---- windows ----------------------------------------------------------------------------------------------------


def positions_of(given: GivenFile, head: Recording) -> tuple[list[dict[str, Any]], tuple[Remark, ...]]:
    """Return the positions of an entry: windows that the caller gave, else those beside the turns that are found.

    All windows of a recording are one flip, with the number of its file.

    Raises
    ------
    UsageError
        If a window cannot be read, or lies in no recording; if no turn is found.
    """
    remarks: tuple[Remark, ...] = ()
    if given.own.get("windows"):
        windows = _given_windows(given, head)
    else:
        angle = _angle(given, given.own.get("angle", HALF_TURN), "angle")
        windows, remarks = found_windows(head, angle, _windows_text(given), given.name)
    return position_rows(windows, head.epoch, str(given.number)), remarks


def position_rows(windows: Sequence[Window], epoch: str, flip: str) -> list[dict[str, Any]]:
    """Return windows as ``positions`` of an entry, on the clock of their recording."""
    at = instant_text if epoch == "utc" else lambda ns: float(f"{ns / SECOND:.9f}")
    return [
        {"start": at(one.start), "stop": at(one.stop), "angle": f"{np.degrees(one.angle):.12g} deg", "flip": flip}
        for one in windows
    ]


def _windows_text(given: GivenFile) -> str:
    text = '"START..STOP=0 deg"'
    return f"--window {text} --window ..." if given.options else f"windows=[{text}, ...]"


def _given_windows(given: GivenFile, head: Recording) -> list[Window]:
    """Return the windows of the caller that lie in a recording; each must lie in one of the call's."""
    texts = given.own["windows"]
    windows, lost = [], []
    for text in [texts] if isinstance(texts, str) else texts:
        span, _, angle = str(text).rpartition("=")
        start, dots, stop = (one.strip() for one in span.partition(".."))
        if not (dots and start and stop and angle):
            do = 'Like "006/00:47:00..006/00:55:00=0 deg"'
            raise UsageError(f"window {text!r}: write START..STOP=ANGLE", do=do, code="wrong_value")
        turned = _angle(given, angle.strip(), f"window {span.strip()}")
        own = _window(given, head, start, stop, turned)
        if _touches(head, own):
            windows.append(own)
        elif not any(
            _touches(other, _window(given, other, start, stop, turned))
            for other in (read_head(one)[0] for one in given.together if one is not given)
        ):
            lost.append(f"{start}..{stop}")
    if lost or not windows:
        what = f"window {lost[0]}: lies in no recording" if lost else f"{given.name}: no window lies in it"
        text = instant_text if head.epoch == "utc" else lambda at: f"{at / SECOND:.9g} s"
        time_ns = head.time_ns if head.time_ns is not None else np.zeros(1, dtype=np.int64)
        do = f"{given.name} runs from {text(int(time_ns[0]))} to {text(int(time_ns[-1]))}"
        raise UsageError(what, do=do, code="empty_window")
    return windows


def _window(given: GivenFile, head: Recording, start: str, stop: str, angle: float) -> Window:
    try:
        first, last = Between(start, stop, given.said.mission_start).bounds(head.epoch)
    except UsageError as error:
        problem = error.problems[0]
        lacks = problem.code == "no_mission_start"
        do = problem.do or (f"Add: {given.add('mission_start', 'TIME')}" if lacks else "")
        raise UsageError(f"window {start}..{stop}: {problem.what}", do=do, code="wrong_time") from None
    assert first is not None  # noqa: S101 - both were given
    assert last is not None  # noqa: S101
    return Window(first, last, angle)


def _angle(given: GivenFile, text: str, what: str) -> float:
    try:
        return float(parse_quantity(text).to("rad"))
    except DataError:
        do = f"Write a number with its unit, like {HALF_TURN}"
        raise UsageError(f"{what}: {text!r}", do=do, code="no_unit") from None


def _touches(recording: Recording, window: Window) -> bool:
    time_ns = recording.time_ns
    return time_ns is None or (window.start <= int(time_ns[-1]) and window.stop > int(time_ns[0]))


def found_windows(
    recording: Recording, angle: float, option: str = "windows", name: str = ""
) -> tuple[list[Window], tuple[Remark, ...]]:
    """Return the windows beside the turns that the record shows, and the remarks on them.

    The head starts at position 0 and each turn takes it to ``angle`` [rad] or back; all turns of a recording are one
    flip. Windows have the same length on both sides of a turn, and are no longer than a part of the record: the rest
    shows the noise. Two that overlap between their turns become one.

    Raises
    ------
    UsageError
        If no turn is found, or it is not certain which changes are turns.
    """
    seconds, turns = seconds_of(recording), turns_of(recording)
    pairs = turn_windows(turns)
    do = f"Give the windows, each with its angle: {option}"
    place = name or recording.source.path
    if turns.doubt:
        what = f"{place}: {turns.doubt}: {seen_turns(recording, turns.shifts)}"
        why = "the record does not say which of these are turns, and by what angle"
        raise UsageError(what, why=why, do=do, code="unclear_turns")
    if not pairs:
        what = f"{place}: no turn of the head found in {seconds:.4g} s"
        spikes = f"; {_spikes(recording, turns.others)} may be one" if turns.others else ""
        why = f"no axis clearly changes its level from one dwell to the next{spikes}"
        raise UsageError(what, why=why, do=do, code="no_turns")
    if not turns.certain:
        what = f"{place}: {seen_turns(recording, turns.turns)}; {_spikes(recording, turns.others)} may be one too"
        why = "if it is, positions and the sign of ambient acceleration are wrong from there on"
        raise UsageError(what, why=why, do=do, code="unclear_turns")
    windows: list[Window] = []
    for i, pair in enumerate(pairs):
        before, after = (0.0, angle) if i % 2 == 0 else (angle, 0.0)
        for one, at in ((pair.before, before), (pair.after, after)):
            if one is None:
                continue
            last = windows[-1] if windows else None
            if last is not None and one.start_ns <= last.stop and at == last.angle:
                windows[-1] = replace(last, stop=max(last.stop, one.stop_ns))
            else:
                windows.append(Window(one.start_ns, one.stop_ns, at))
    what = f"{seen_turns(recording, turns.turns)}: 0 deg before the first, then {np.degrees(angle):g} deg"
    what += " and 0 deg by turns" if len(pairs) > 1 else ""
    do = "If it started at the other position, which the record does not show, ambient acceleration has the other sign"
    found = Remark("turns_found", "info", what, do=f"{do}, and the bias the same")
    return windows, (*turns.remarks, *(problem for pair in pairs for problem in pair.problems), found)


def seen_turns(recording: Recording, turns: Sequence[Turn]) -> str:
    """Return how many turns are seen, and when, each with the uncertainty of its time."""
    several = "s" if len(turns) > 1 else ""
    unit = "change" if any(not one.clear for one in turns) else "turn"
    texts = [
        f"{_clock(recording, one.start_ns)} to {_clock(recording, one.stop_ns)}" if one.felt
        else f"{_clock(recording, one.middle_ns)} ± {max(one.u, 1.0):.0f} s"
        for one in turns[:MOST]
    ]  # fmt: skip
    more = f" and {len(turns) - MOST} more" if len(turns) > MOST else ""
    return f"{len(turns)} {unit}{several} found: {', '.join(texts)}{more}"


def _spikes(recording: Recording, others: Sequence[Turn]) -> str:
    times = ", ".join(_clock(recording, one.middle_ns) for one in others[:MOST])
    more = f" and {len(others) - MOST} more" if len(others) > MOST else ""
    return f"the {'spike' if len(others) == 1 else f'{len(others)} spikes'} at {times}{more}"


def _clock(recording: Recording, at: int) -> str:
    """Return an instant on the clock of the recording, to 0.1 s."""
    at = round(at, -8)
    if recording.epoch == "utc":
        return instant_text(at)
    return elapsed_text(at) if at >= 0 else f"{at / SECOND:.9g} s"
