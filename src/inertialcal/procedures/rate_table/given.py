"""What a file of a rate table is taken for: a table of dwells, or a recording of a table turned in steps.

Told by the names and units of its columns. Which axis was turned is never taken from the numbers; where it is not said,
the message names the axis that follows the table.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.units import convert, kind, normalise
from ...files import read_table
from ...files.info.describe import overridden
from ...files.info.table_columns import Guess, guess, guess_channels
from ...files.text.headers import bare_name, full_name
from ..given import (
    RAW,
    Described,
    GivenFile,
    bare,
    chain_of_units,
    chain_remarks,
    chain_said,
    named_columns,
    raw_advice,
    raw_units,
    reference_columns,
    sensor_said,
    spoken_unit,
    unit_advice,
)
from .recordings import APPLIED

SAMPLES_A_STEP = 3.0  # fewer samples between changes of the table's rate: not a recording of steps
SHORTEST_DWELL, MOST_DWELLS = 2.0, 500  # [s]; rows: what is sampled faster, and is longer, is no table of dwells
FOLLOWS = 0.9  # correlation with the table above which an axis is named as the one that follows


def described(given: GivenFile) -> Described:
    """Return what a file of a rate table is.

    Raises
    ------
    UsageError
        If it is not clear which column is what, in which unit, or which axis was turned.
    """
    given = replace(given, has_rows=given.has_rows and not Path(given.name).is_dir())  # a bag in a folder has none
    names = guess(given.table) if given.has_rows else guess_channels(given.recording.channels)
    given = _with_columns(given)
    applied = _full(given, given.own.get("applied")) or names.applied
    of_rows = any(given.own.get(name) for name in ("scatter", "run", "group"))
    if given.own.get("schedule"):
        return _recorded(given, None)
    if not given.has_rows or (not of_rows and _is_recording(given.recording, applied)):
        if applied not in given.recording.names:
            raise _no_rate(given)
        return _recorded(given, applied)
    return _table(given, names)


def _with_columns(given: GivenFile) -> GivenFile:
    """Return what was given with the columns of ``--column`` where its own options do not name them."""
    columns = given.said.columns
    own: dict[str, object] = {name: columns[name] for name in ("applied", "run", "group", "scatter") if name in columns}
    reading = {axis: columns[axis] for axis in AXES if axis in columns}
    own |= {"reading": reading} if reading else {}
    return replace(given, own={**own, **{name: value for name, value in given.own.items() if value}}) if own else given


def _full(given: GivenFile, name: str | None) -> str | None:
    """Return a column by its full name: it may be given without the unit in brackets."""
    names = given.table.names if given.has_rows else given.recording.names
    return None if name is None else full_name(names, name) or name


def _is_recording(recording: Recording, applied: str | None) -> bool:
    """Tell whether a file is a recording on a clock whose table rate goes in steps, not a row a dwell.

    Where no column says the rate of the table, by how often it was sampled.
    """
    if recording.sample_interval is None:
        return False
    if applied is None:
        return recording.sample_interval < SHORTEST_DWELL and len(recording) > MOST_DWELLS
    if applied not in recording.names:
        return False
    return goes_in_steps(np.asarray(recording.channel(applied).data, dtype=float))


def goes_in_steps(rate: Array) -> bool:
    """Tell whether the rate of a table, shape (n,), goes in steps over many samples."""
    known = rate[np.isfinite(rate)]
    return bool(len(rate) >= SAMPLES_A_STEP * (np.count_nonzero(np.diff(known) != 0.0) + 1))


def _table(given: GivenFile, names: Guess) -> Described:
    """Return a table of dwells: all that is missing is asked for at once."""
    own: dict[str, Any] = {name: _full(given, given.own.get(name)) for name in ("applied", "scatter", "run", "group")}
    reading_said = {axis: str(_full(given, one)) for axis, one in (given.own.get("reading") or {}).items()}
    said, turned = own | {"reading": reading_said}, given.plan.get("axis")
    if turned is not None and names.axis is not None:
        what = f"{given.name}: column {names.axis!r} and {given.add('axis', turned)} both give the axis that was turned"
        raise UsageError(what, do="Leave one out", code="wrong_value")
    reading = _reading(said.get("reading"), names)
    missing: list[tuple[str, str, str]] = []
    notes: list[str] = []
    raw = ""
    if said.get("applied") is None and names.applied is None:
        missing.append(("cannot tell which column is the applied rate", given.add("applied", "COLUMN"), "no_column"))
    only = [axis for axis, name in names.by_axis.items() if name == reading]
    axis = turned or (None if names.axis else only[0] if len(only) == 1 else None)
    if reading is None:
        listed = f"{len(names.readings)} columns can be the reading"
        have = f" ({', '.join(names.readings)})" if names.readings else f"; it has {', '.join(given.table.names)}"
        missing.append((f"{listed}{have}", given.add("reading", "COLUMN"), "no_column"))
    if axis is None and names.axis is None:
        missing.append(("axis not given", given.add("axis", "AXIS"), "no_axis"))
        notes.append("AXIS: x, y or z, the one that was turned")
    applied = said.get("applied") or names.applied
    unit, applied_unit, overruled = _units(given, names, applied, reading)
    if unit is None and reading is not None:
        missing.append(("unit of rate and reading not given", given.add("unit", "UNIT"), "no_unit"))
        notes.append("UNIT: deg/s, rad/s, V, count, ...")
    chain = chain_said(given, "gyro")
    chain = chain if unit is None else chain_of_units(given, chain, [unit], nominal=given.said.chain is None)
    if unit is not None and kind(unit) in RAW and kind(unit) not in raw_units(chain):
        missing.append(("counts and volts need the chain of the sensor", "", "no_unit"))
        raw = raw_advice(given, [unit], "deg/s")
    if missing or unit is None:
        raise _missing(given, missing, notes, raw)
    rows: dict[str, Any] = {
        "applied": applied, "reading": reading, "unit": normalise(unit),
        "scatter": said.get("scatter") or _scatter(names, reading),
        "run": said.get("run") or names.run, "group": said.get("group") or names.group,
        "samples": names.samples, "axis": None if turned else names.axis,
    }  # fmt: skip
    rows = {name: value for name, value in rows.items() if value is not None}
    counted = kind(rows["unit"]) in RAW
    spoken = spoken_unit("gyro", chain) if counted else rows["unit"]
    if kind(spoken) != "angular_rate":
        do = f"Add: {given.add('unit', 'deg/s')}"
        raise UsageError(f"unit {unit!r} is not a unit of angular rate", do=do, code="no_unit")
    if counted or normalise(applied_unit or spoken) != rows["unit"]:
        rows["applied_unit"] = normalise(applied_unit or spoken)
    shown = {f"{what} {key}".strip(): str(name) for what, value in rows.items()
             for key, name in (value.items() if isinstance(value, dict) else [("", value)])}  # fmt: skip
    plan = {"axis": axis} if axis else {}
    sensor = sensor_said(given, "gyro", AXES, spoken, chain)
    remarks = (*overruled, *chain_remarks(given, chain, [unit]))
    return Described({"rows": rows}, sensor, shown | plan, plan, remarks=remarks)


def _scatter(names: Guess, reading: str | dict[str, str] | None) -> str | dict[str, str] | None:
    """Return the column of the scatter of a reading, or that of each axis; None where it is not clear."""
    if isinstance(reading, dict):
        return names.scatter_by_axis if reading == names.by_axis and names.scatter_by_axis else None
    by_reading = {names.by_axis[axis]: name for axis, name in names.scatter_by_axis.items()}
    return names.scatter or by_reading.get(reading or "")


def _missing(
    given: GivenFile, missing: Sequence[tuple[str, str, str]], notes: Sequence[str] = (), raw: str = ""
) -> UsageError:
    """Return the error of a table that leaves things open: what, the option for it, the code; notes on options."""
    options = " ".join(dict.fromkeys(option for _, option, _ in missing if option))
    what = f"{given.name}: {'; '.join(what for what, _, _ in missing)}"
    said = f" ({'; '.join(notes)})" if notes else ""
    do = ". ".join([*([f"Add: {options}{said}"] if options else []), *([raw] if raw else [])])
    return UsageError(what, do=do, code=missing[0][2])


def _units(
    given: GivenFile, names: Guess, applied: str | None, reading: str | dict[str, str] | None
) -> tuple[str | None, str | None, tuple[Remark, ...]]:
    """Return the unit of readings, and that of the rate of the table: as said, by column or for all, else by the file.

    A unit that is said of no column is that of the readings; a rate of the table keeps the one of its header. With a
    remark on each column whose header states another unit.

    Raises
    ------
    UsageError
        If readings in one unit are said to be in another, and both are known.
    """
    columns = [*reading.values()] if isinstance(reading, dict) else [reading] if reading else []
    said, table = given.said.units, given.table
    own = {what: next((said[one] for one in said if one in (what, bare_name(what))), None)
           for what in (*columns, *([applied] if applied else []))}  # fmt: skip
    by_header = {table.unit(one) for one in columns if one in table.names}
    header = by_header.pop() if len(by_header) == 1 else None
    group = said.get("gyro") or said.get("reading")
    others = [one for key, one in said.items() if applied is None or key not in (applied, bare_name(applied))]
    unit = next((own[one] for one in columns if own[one]), None) or group or bare(said) or next(iter(others), None)
    if unit is not None and header is not None and kind(header) in RAW and kind(normalise(unit)) not in RAW:
        what = f"{given.name}: {columns[0]!r} is in {header} by its header, not in {unit}"
        do = raw_advice(given, [header], "deg/s")
        raise UsageError(what, "", "counts and volts need the chain of the sensor", do, "unit_mismatch")
    of_table = table.unit(applied) if applied in table.names else None
    stated = {one: unit for one in columns if unit} | {one: own[one] for one in (applied,) if one and own[one]}
    overruled = [(one, table.unit(one), normalise(text)) for one, text in stated.items() if one in table.names and text]
    remarks = overridden(overruled, given.name)
    return unit or names.unit or header, own.get(applied or "") or of_table, remarks


def _reading(said: Mapping[str, str] | None, names: Guess) -> str | dict[str, str] | None:
    """Return the column of the reading, or one an axis; None where it is not clear."""
    if said:
        by_axis = {axis: said[axis] for axis in AXES if axis in said}
        return by_axis or next(iter(said.values()))
    if len(names.by_axis) > 1:
        return dict(names.by_axis)
    return names.readings[0] if len(names.readings) == 1 or (names.by_axis and names.readings) else None


def _no_rate(given: GivenFile) -> UsageError:
    """Return the error of a recording of which no column says the rate of the table."""
    others = [one for one in given.recording.channels if one.quantity in ("", "gyro") and not one.axis]
    may_be = any(kind(one.unit or "deg/s") == "angular_rate" for one in others)
    what = f"{given.name}: no column says the rate of the table; it has {', '.join(given.recording.names)}"
    axis = [] if given.plan.get("axis") else [given.add("axis", "AXIS")]
    dwells = " ".join([given.add("schedule", "DWELLS.csv"), *axis])
    do = f"Add: {dwells} (a row a dwell: start, stop, rate [UNIT], on its clock)"
    do += f". If one of its columns says it: {given.add('applied', 'COLUMN')}" if may_be else ""
    return UsageError(what, "", "each dwell has a rate that is known", do, "no_column")


def _scheduled(given: GivenFile) -> dict[str, Any]:
    """Return the columns of the schedule that was given.

    Raises
    ------
    UsageError
        ``no_column`` or ``no_unit`` where it does not say start, stop, rate and the unit of the rate.
    """
    file = str(given.own["schedule"])
    table = read_table(file)
    named = {what: next((one for one in table.names if bare_name(one).lower() == what), None)
             for what in ("start", "stop", "rate", "recording")}  # fmt: skip
    rate = named["rate"]
    if missing := [what for what in ("start", "stop", "rate") if named[what] is None]:
        what = f"{file}: no column {', '.join(missing)}; it has {', '.join(table.names)}"
        raise UsageError(what, do="A row a dwell: start, stop, rate [deg/s]", code="no_column")
    unit = table.unit(rate or "")
    if unit is None or kind(unit) != "angular_rate":
        do = "Write the unit into its header: rate [deg/s]"
        raise UsageError(f"{file}: column {rate!r} without a unit of angular rate", do=do, code="no_unit")
    several = named["recording"] is not None and len(set(table.text(named["recording"]))) > 1
    found = {what: name for what, name in named.items() if name is not None and (what != "recording" or several)}
    return {"file": file, **found, "unit": unit}


def _recorded(given: GivenFile, applied: str | None) -> Described:
    """Return a recording of a stepped table, whose rate is a column of it, or stands in a schedule."""
    recording, axis = given.recording, given.plan.get("axis")
    schedule = {} if applied is not None else {"schedule": _scheduled(given)}
    by_axis = _channels(given, applied)
    if not by_axis:
        what = f"{given.name}: cannot tell which column is which axis of the gyro; it has {', '.join(recording.names)}"
        only = len(guess_channels(recording.channels).readings) == 1 and not axis
        what_axis = given.add("axis", "AXIS")
        do = f"Add: {what_axis}" if only else f"Add: {given.add('reading', 'x=COLUMN')}"
        raise UsageError(what, do=do, code="no_column")
    unit = bare(given.said.units)
    rates = {} if applied is None else {APPLIED: applied}
    own = {name: recording.channel(name).unit for name in (*rates.values(), *by_axis.values())}
    own = {name: unit if one is None else one for name, one in own.items()}
    chain = chain_of_units(given, chain_said(given, "gyro"), [own[name] for name in by_axis.values()])
    raw = raw_units(chain)
    own |= {name: "count" for name in by_axis.values() if own[name] is None and "count" in raw}
    wanted = dict.fromkeys(rates.values(), ("angular_rate",)) | dict.fromkeys(
        by_axis.values(), raw or ("angular_rate",)
    )
    if bad := [name for name, one in own.items() if one is None or kind(one) not in wanted[name]]:
        raise _without_rate(given, own, bad)
    turned = axis or (next(iter(by_axis)) if len(by_axis) == 1 else None)
    if turned is None:
        found = "" if applied is None else following_axis(recording, applied, by_axis)
        hint = f"; {applied!r} is followed by {found}" if found else ""
        do = f"Add: {given.add('axis', found or 'AXIS')}"
        raise UsageError(f"{given.name}: axis not given{hint}", do=do, code="no_axis")
    units = {name: str(one) for name, one in own.items()}
    references = reference_columns(given, chain, [*by_axis], named_columns(recording, given.said.columns))
    units |= {name: recording.channel(name).unit or "count" for name in references.values()}
    columns = {**rates, **by_axis, **references}
    channels = {what: {"column": name, "unit": normalise(units[name])} for what, name in columns.items()}
    spoken = spoken_unit("gyro", chain) if raw else units[next(iter(by_axis.values()))]
    sensor = sensor_said(given, "gyro", [*by_axis], normalise(spoken), chain)
    remarks = chain_remarks(given, chain, [units[name] for name in by_axis.values()])
    entry = {"channels": channels, "axis": turned} | schedule
    return Described(entry, sensor, columns | {"axis": turned}, remarks=remarks)


def _without_rate(given: GivenFile, units: Mapping[str, str | None], bad: Sequence[str]) -> UsageError:
    """Return the error of columns whose unit is missing, or is none of angular rate."""
    have = ", ".join(f"{name} ({units[name] or '?'})" for name in bad)
    raw = [units[name] for name in bad if kind(units[name] or "1") in RAW]
    unsaid = [
        given.recording.channel(name) for name in bad if units[name] is None or kind(units[name] or "1") not in RAW
    ]
    do = [raw_advice(given, raw, "deg/s")] if raw else []
    do += unit_advice(given, {"gyro": ("angular_rate", unsaid)}) if unsaid else []
    why = "counts and volts need the chain of the sensor" if raw else ""
    what = f"{given.name}: rate or reading without a unit of angular rate: {have}"
    return UsageError(what, "", why, ". ".join(do), "no_unit")


def _channels(given: GivenFile, applied: str | None) -> dict[str, str]:
    """Return the gyro's channels by axis, as said or by their names."""
    said: Mapping[str, str] = given.own.get("reading") or {
        axis: one for axis, one in given.said.columns.items() if axis in AXES
    }
    recording = given.recording
    if said:
        axis, said = given.plan.get("axis"), named_columns(recording, said)
        found = {name if name in AXES else axis or recording.channel(one).axis: one for name, one in said.items()}
    else:
        lettered = [c for c in recording.channels if c.name != applied and c.axis in AXES]
        rates = [c for c in lettered if c.quantity == "gyro"] or [c for c in lettered if not c.quantity]
        found = {c.axis: c.name for c in rates}
        if len(found) != len(rates):
            return {}
        only, axis = guess_channels(recording.channels).readings, given.plan.get("axis")
        if not found and len(only) == 1 and axis:  # the only other column is that of the axis that was turned
            found = {axis: only[0]}
    return {one: found[one] for one in AXES if one in found}


def following_axis(recording: Recording, applied: str, by_axis: Mapping[str, str]) -> str:
    """Return the axis that follows the table; empty where none clearly does."""
    readings = {axis: _in_si(recording, name) for axis, name in by_axis.items()}
    return following(_in_si(recording, applied), readings)


def following(rate: Array, readings: Mapping[str, Array]) -> str:
    """Return the axis whose readings, shape (n,), follow the rate of the table; empty where none clearly does."""
    found: list[tuple[float, float, str]] = []
    for axis, values in readings.items():
        use = np.isfinite(rate) & np.isfinite(values)
        if use.any() and np.ptp(rate[use]) > 0.0 and np.ptp(values[use]) > 0.0:
            found.append((abs(float(np.corrcoef(rate[use], values[use])[0, 1])), float(np.std(values[use])), axis))
    following = max((one for one in found if one[0] > FOLLOWS), key=lambda one: one[1], default=None)
    return "" if following is None else following[2]


def _in_si(recording: Recording, name: str) -> Any:
    channel = recording.channel(name)
    known = channel.unit is not None and kind(channel.unit) == "angular_rate"
    return convert(channel.data, channel.unit if known and channel.unit else "rad/s", "rad/s")
