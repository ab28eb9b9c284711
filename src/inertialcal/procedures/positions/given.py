"""What a file of positions is taken for: accelerometers and gyros on one clock, or a table with a row a position.

The names and units of its channels decide. For a file without a header it is what the caller calls it
(``acc=FILE``), else its name, and its three columns are x, y, z. ``x+=FILE`` is one position, ``x_rot=FILE`` a turn.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import UsageError
from ...core.key import AXES, Kind
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.units import kind, normalise
from ...files.text.headers import bare_name, full_name, heading, is_applied, plain
from ..given import (
    EXAMPLE,
    KIND_OF_UNIT,
    RAW,
    UNITS_OF,
    Described,
    GivenFile,
    bare,
    chain_of_units,
    chain_said,
    named_columns,
    nameless_advice,
    own_clock,
    raw_units,
    reference_columns,
    sensor_said,
    spoken_unit,
)
from .orientations import LABELS, direction_of, orientation_list, turn_of

KINDS: Mapping[str, Kind] = {"acc": "accelerometer", "gyro": "gyro"}
ROLES = tuple(f"{sensor}_{axis}" for sensor in KINDS for axis in AXES)
REFERENCES = ("reference", *(f"reference_{axis}" for axis in AXES))
TEMPERATURE = "temperature"
IN_NAME = {"acc": "acc", "gyro": "gyr"}  # of a file without a header
LONGEST = 1_000  # rows; a longer file without time is no table of positions
SCATTER = re.compile(r"(^|_)(std|stdev|sd|sigma|scatter|u)(_|$)", re.IGNORECASE)
SAMPLES = re.compile(r"^(n|samples|n_samples|count)$", re.IGNORECASE)
PLAUSIBLE = {"m/s2": (9.0, 10.5), "g": (0.9, 1.1), "mg": (900.0, 1100.0)}  # median length of acceleration at rest


def split_label(given: str) -> tuple[str, str]:
    """Return the sensor, position or turn that a caller names a file by, and the file.

    Raises
    ------
    UsageError
        ``unknown_name`` for another name.
    """
    label, equals, path = given.partition("=")
    if not equals or Path(given).exists():
        return "", given
    label = label.strip()
    if label not in KINDS and direction_of(label) is None and turn_of(label) is None:
        do = "There are: acc=FILE, gyro=FILE, x+=FILE, x-=FILE, ..., x_rot=FILE"
        raise UsageError(f"{given}: {label!r} is not a sensor, position or turn", do=do, code="unknown_name")
    return label, path


def described(given: GivenFile) -> list[Described]:
    """Return what a file of positions is, sensor by sensor.

    Raises
    ------
    UsageError
        If it is not clear which channel is what, or in which unit.
    """
    given = _with_sensor(given)
    said, recording = given.said, given.recording
    known = (*ROLES, TEMPERATURE, *REFERENCES)
    wrong = [role for role in said.columns if role not in known]
    if wrong:
        do = f"There are: {', '.join(known)}"
        raise UsageError(f"column {wrong[0]!r}", do=do, code="unknown_name")
    entry = own_keys(given)
    is_table = is_table_of_positions(recording) and given.has_rows and "sections" not in entry and not given.label
    sensors, remarks = _channels(given, is_table)
    units = _units(given, sensors)
    named = named_columns(recording, said.columns)
    found = []
    for sensor, by_axis in sensors.items():
        columns = {f"{sensor}_{axis}": channel.name for axis, channel in by_axis.items()}
        chain = _chain(given, sensor, units[sensor])
        through = kind(units[sensor]) in raw_units(chain)
        unit = spoken_unit(KINDS[sensor], chain) if through else units[sensor]
        said_sensor = sensor_said(given, KINDS[sensor], AXES, unit, chain)
        if is_table:
            if entry:
                what = f"{given.name} is a table, a row a position: {', '.join(entry)} is for recordings"
                do = "Say how each row lay in a column: position, or x, y and z (up)"
                raise UsageError(what, do=do, code="wrong_value")
            rests = _rests(given, sensor, by_axis, units[sensor])
            found.append(Described({"rests": rests}, said_sensor, columns))
            continue
        channels = {axis: {"column": one.name, "unit": units[sensor]} for axis, one in by_axis.items()}
        warm = [c for c in recording.channels if c.quantity == TEMPERATURE and c.unit is not None]
        if len(warm) == 1:
            channels[TEMPERATURE] = {"column": warm[0].name, "unit": str(warm[0].unit)}
        voltages = reference_columns(given, chain, AXES, named) if through else {}
        channels |= {what: {"column": name, "unit": recording.channel(name).unit or "count"}
                     for what, name in voltages.items()}  # fmt: skip
        own = entry | own_clock(given, KINDS[sensor])
        found.append(Described({"channels": channels, **own}, said_sensor, columns, remarks=tuple(remarks)))
    return found


def _chain(given: GivenFile, sensor: str, unit: str) -> dict[str, Any]:
    """Return the chain of a sensor with readings in a unit; with a scale factor alone they stay in counts or volts."""
    chain = chain_said(given, KINDS[sensor])
    chain = chain if kind(unit) in RAW else chain_of_units(given, chain, [unit])
    alone = not chain.keys() - {"kind", "scale_factor"} and chain.get("kind") == "output"
    return chain | ({"kind": "none"} if alone else {})


def _with_sensor(given: GivenFile) -> GivenFile:
    """Return what was given with x, y and z of ``--column`` as those of the one sensor that was said."""
    words = {given.said.sensor, given.label} & {*KINDS, *KINDS.values()}
    groups = {one for one, word in KINDS.items() if {one, word} & words}
    if len(groups) != 1:
        return given
    (group,) = groups
    columns = {f"{group}_{what}" if what in AXES else what: name for what, name in given.said.columns.items()}
    return replace(given, said=replace(given.said, columns=columns))


def is_table_of_positions(recording: Recording) -> bool:
    """Whether a file without time is short enough to have a row a position."""
    return recording.time_ns is None and recording.sample_interval is None and len(recording) <= LONGEST


def applied_columns(channels: Sequence[Channel]) -> dict[str, Channel]:
    """Return the channels of a table that say what was applied along each axis; none where it does not say all three.

    They are called so (``gx_applied``, ``a_ref_x``, ``true_x``), or ``g_x``, ``g_y``, ``g_z`` beside readings.
    """
    fits = [c for c in channels if c.axis in AXES and (c.unit is None or kind(c.unit) == KIND_OF_UNIT["accelerometer"])]
    called = [c for c in fits if is_applied(c.name)]
    said = {c.axis: c for c in called}
    if not said and len([c for c in channels if c.axis in AXES]) > len(AXES):
        called = [c for c in fits if bare_name(c.name).lower() == f"g_{c.axis}"]
        said = {c.axis: c for c in called}
    return said if len(said) == len(called) == len(AXES) else {}


def own_keys(given: GivenFile) -> dict[str, Any]:
    """Return sections, orientations and angle of the turns as the caller gives them for a file.

    Raises
    ------
    UsageError
        If sections are given for a part of the recording.
    """
    own, entry = given.own, dict[str, Any]()
    by_file: Mapping[str, str] = own.get("sections") or {}
    sections = by_file.get(given.name) or by_file.get(Path(given.name).name) or bare(by_file)
    if sections and (given.said.start is not None or given.said.stop is not None):
        do = "Leave --from and --to out: the sections say which part is used"
        raise UsageError("sections, and a part of the recording", why="samples are counted from its start", do=do)
    if given.label and given.label not in KINDS:
        entry["sections"] = given.label
    elif sections:
        entry["sections"] = sections
    if own.get("orientations"):
        entry["orientations"] = orientation_list(own["orientations"])
    if own.get("turn"):
        entry["turn"] = str(own["turn"])
    return entry


def _channels(given: GivenFile, is_table: bool) -> tuple[dict[str, dict[str, Channel]], list[Remark]]:
    """Return the channels by sensor and axis: as said, else by their names, else in their order, which is remarked.

    Raises
    ------
    UsageError
        ``no_column`` where a sensor lacks an axis, or none is there.
    """
    recording, columns = given.recording, given.said.columns
    every = [c for c in recording.channels if not is_table or not (SCATTER.search(c.name) or SAMPLES.match(c.name))]
    applied = applied_columns(every) if is_table else {}
    every = [c for c in every if c not in applied.values()]
    wanted = [given.label] if given.label in KINDS else list(KINDS)
    if given.said.sensor is not None:
        wanted = [one for one in wanted if given.said.sensor in (one, KINDS[one])]
    found: dict[str, dict[str, Channel]] = {}
    remarks: list[Remark] = []
    for sensor in wanted:
        named = [c for c in every if c.quantity == sensor and c.axis in AXES]
        own = {str(c.axis): c for c in named} if len({c.axis for c in named}) == len(named) else {}
        roles = {role[-1]: name for role, name in columns.items() if role.startswith(f"{sensor}_")}
        roles = {axis: full_name(recording.names, name) or name for axis, name in roles.items()}
        for axis, name in roles.items():
            own = own if len(roles) < len(AXES) else {}
            if name not in recording.names:
                what = f"{sensor}_{axis}={name}: no channel {name!r} in {given.name}"
                raise UsageError(what, do=f"There are: {', '.join(recording.names)}", code="no_column")
        own |= {axis: recording.channel(name) for axis, name in roles.items()}
        lettered = [c for c in every if c.axis in AXES and not c.quantity]
        if applied and not own and sensor == "acc" and len({c.axis for c in lettered}) == len(lettered):
            own = {str(c.axis): c for c in lettered}  # ``out_x [V]`` beside what was applied
        if own:
            found[sensor] = {axis: own[axis] for axis in AXES if axis in own}
    if not found:
        bare = [c for c in every if c.quantity in ("", given.label) and c.data.dtype.kind in "iuf"]
        by_name = [one for one in wanted if IN_NAME[one] in Path(given.name).name.lower()]
        chosen = wanted if len(wanted) == 1 else by_name
        if len(bare) == len(AXES) and len(chosen) == 1:
            found[chosen[0]] = dict(zip(AXES, bare, strict=True))
            what = f"{', '.join(one.name for one in bare)} taken for x, y, z of the {KINDS[chosen[0]]}, in their order"
            do = f"Else add: {given.add('column', f'{chosen[0]}_x=COLUMN')}"
            remarks.append(Remark("axes_in_order", "info", what, given.name, do=do))
    missing = [f"{one}_{axis}" for one, by_axis in found.items() for axis in AXES if axis not in by_axis]
    if missing or not found:
        missing = missing or [f"acc_{axis}" for axis in AXES]
        what = f"{given.name}: cannot tell which column is {', '.join(missing)}; it has {', '.join(recording.names)}"
        nameless = nameless_advice(given, missing, KIND_OF_UNIT[KINDS[missing[0][:-2]]], {})
        do = nameless or f"Add: {given.add('column', f'{missing[0]}=COLUMN')}; or name the file: acc=FILE gyro=FILE"
        raise UsageError(what, do=do, code="no_column")
    return found, remarks


def _units(given: GivenFile, sensors: Mapping[str, Mapping[str, Channel]]) -> dict[str, str]:
    """Return the unit of each sensor: as said, else as the file says.

    Raises
    ------
    UsageError
        ``no_unit`` where there is none, or axes of one sensor differ; ``unit_mismatch`` for one of another kind.
    """
    found: dict[str, str] = {}
    missing: dict[str, list[str]] = {}
    for sensor, by_axis in sensors.items():
        said = given.said.units.get(sensor)
        units = {one.unit if said is None or one.unit_from == "flag" else said for one in by_axis.values()}
        unit = units.pop()
        if unit is None and not units and "count" in raw_units(chain_said(given, KINDS[sensor])):
            unit = "count"  # what the chain that was said begins with
        if units or unit is None:
            missing[sensor] = [one.name for one in by_axis.values()]
            continue
        own = KIND_OF_UNIT[KINDS[sensor]]
        if kind(unit) not in (own, "count", "voltage"):
            like = f"{given.add('unit', f'{sensor}={EXAMPLE[own]}')}, or {sensor}=count"
            article = "an accelerometer" if sensor == "acc" else "a gyro"
            what = f"{next(iter(by_axis.values())).name}: {unit!r} is not a unit of {article}"
            raise UsageError(what, do=f"Add: {like}", code="unit_mismatch")
        found[sensor] = normalise(unit)
    if missing:
        names = "; ".join(f"{', '.join(names)} of {sensor}" for sensor, names in missing.items())
        length, like = _length(sensors["acc"]) if "acc" in missing else (0.0, "")
        hint = f" (median |acc| is {length:.4g}{f': {like}?' if like else ''})" if length else ""
        what = f"{given.name}: no unit, or several: {names}{hint}"
        known = {sensor: like for sensor in missing if sensor == "acc" and like}
        do = " ".join(given.add("unit", f"{sensor}={known.get(sensor, 'UNIT')}") for sensor in missing)
        asked = ", ".join(UNITS_OF[KIND_OF_UNIT[KINDS[one]]] for one in missing if one not in known)
        raise UsageError(what, do=f"Add: {do}" + (f" (UNIT: {asked}, or count)" if asked else ""), code="no_unit")
    return found


def rests_of_table(given: GivenFile) -> dict[str, dict[str, Any]]:
    """Return the columns of a table, sensor by sensor, the unit ``?`` where it has none; nothing of any other file.

    It has accelerometers along three axes, and says how each row lay.
    """
    if not is_table_of_positions(given.recording):
        return {}
    try:
        sensors = _channels(given, is_table=True)[0]
    except UsageError:
        return {}
    found = dict[str, dict[str, Any]]()
    for sensor, by_axis in sensors.items():
        units = {one.unit for one in by_axis.values()}
        found[sensor] = _rests(given, sensor, by_axis, (units.pop() if len(units) == 1 else None) or "?")
    return found if {"direction", "orientation"} & found.get("acc", {}).keys() else {}


def _length(by_axis: Mapping[str, Channel]) -> tuple[float, str]:
    """Return how long the acceleration is, and which unit that may be."""
    x, y, z = (np.asarray(by_axis[axis].data, dtype=np.float64) for axis in AXES)
    length = float(np.nanmedian(np.sqrt(x**2 + y**2 + z**2)))
    return length, next((unit for unit, (low, high) in PLAUSIBLE.items() if low <= length <= high), "")


def _rests(given: GivenFile, sensor: str, by_axis: Mapping[str, Channel], unit: str) -> dict[str, Any]:
    """Return the columns of a table with a row a position."""
    table = given.table
    found: dict[str, Any] = {"reading": {axis: one.name for axis, one in by_axis.items()}, "unit": unit}
    spread = [name for name in table.names if SCATTER.search(name) or heading(name).quantity == "spread"]
    scatters = [name for name in spread if sensor in name.lower()]
    scatters = scatters or [name for name in spread if table.unit(name) == unit]  # ``Stabw. X [g]``
    own = {axis: [name for name in scatters if re.search(rf"(^|[^a-z]){axis}([^a-z]|$)", name.lower())]
           for axis in AXES}  # fmt: skip
    scatter = {axis: names[0] for axis, names in own.items() if len(names) == 1}
    samples = [name for name in table.names if SAMPLES.match(name)]
    lower = {plain(name).lower(): name for name in table.names}
    label = next((lower[name] for name in lower if name in LABELS), None)
    if scatter:
        found["scatter"] = scatter
    if len(samples) == 1:
        found["samples"] = samples[0]
    if applied := applied_columns([c for c in given.recording.channels if c not in by_axis.values()]):
        found["direction"] = {axis: applied[axis].name for axis in AXES}
    elif set(AXES) <= set(lower):
        found["direction"] = {axis: lower[axis] for axis in AXES}
    elif label is not None and all(direction_of(cell) is not None for cell in table.text(label)):
        found["orientation"] = label
    return found
