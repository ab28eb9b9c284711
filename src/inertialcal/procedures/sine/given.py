"""The campaign entry of a recording under a known drive: its channels, and the schedule of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.recording import Channel
from ...core.units import kind, normalise
from ...files.text.headers import bare_name
from ..given import KIND_OF_UNIT, Described, GivenFile, chain_said, raw_units, sensor_said
from ..given import described as described_by_unit
from ..protocol import InputSpec

SENSORS = ("gyro", "acc")  # quantities of channels


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the channels of a file under a drive: those of a sensor, those named, or the only one.

    Raises
    ------
    UsageError
        If neither or both of period and schedule are given, or it is not clear which channel is meant.
    """
    period, schedule = given.plan.get("period"), given.own.get("schedule")
    if (period is None) == (schedule is None):
        both = "both are given" if period else "neither is given"
        do = f"Give one: {given.add('period', 'PERIOD s')}, or {given.add('schedule', 'FILE')}"
        raise UsageError(f"period and schedule: {both}", do=do, code="wrong_value")
    if schedule is not None and given.plan.get("phase") is not None:
        raise UsageError("phase and schedule", why="the schedule has the phase", do="Leave the phase out")
    of_sensor = [one for one in given.recording.channels if one.axis in AXES and one.quantity in SENSORS and one.unit]
    counted = bool(raw_units(chain_said(given)))
    if counted or (of_sensor and not given.said.columns):
        found = described_by_unit(given, spec)
    else:
        found = _of_channels(given, _named(given))
    drive = {} if schedule is None else {"drive": {"schedule": str(schedule)}}
    return replace(found, entry=found.entry | drive)


def _named(given: GivenFile) -> dict[str, Channel]:
    """Return the channels that were named, by axis, or the only one of the file as x."""
    recording, columns = given.recording, given.said.columns
    if wrong := [what for what, name in columns.items() if what not in (*AXES, name)]:
        raise UsageError(f"column {wrong[0]!r}", do=f"There are: {', '.join(AXES)}", code="unknown_name")
    free = iter(axis for axis in AXES if axis not in columns)
    own = {bare_name(one.name): one.name for one in recording.channels}  # of a header with units
    named = {
        what if what in AXES else next(free): recording.channel(own.get(name, name)) for what, name in columns.items()
    }
    numbers = [one for one in recording.channels if one.data.dtype.kind in "iufb"]
    if not named and len(numbers) != 1:
        what = f"{given.name}: {len(numbers)} columns of numbers: {', '.join(recording.names)}"
        do = f"Add: {given.add('column', 'x=COLUMN')}"
        raise UsageError(what, why="cannot tell which is under the drive", do=do, code="no_column")
    return named or {"x": numbers[0]}


def _of_channels(given: GivenFile, channels: Mapping[str, Channel]) -> Described:
    """Return channels of one unit as a sensor, in the unit of the file."""
    units = {axis: one.unit or "" for axis, one in channels.items()}
    unit = next(iter(units.values()))
    kinds = {name: one for one, name in KIND_OF_UNIT.items()}
    sensor = kinds.get(kind(unit), "other") if unit else "other"
    entry: dict[str, Any] = {
        axis: {"column": one.name} | ({"unit": normalise(units[axis])} if units[axis] else {})
        for axis, one in channels.items()
    }
    of_sensor = sensor_said(given, "gyro", [*channels], normalise(unit) if unit else "") | {"kind": sensor}
    return Described({"channels": entry}, of_sensor, {axis: one.name for axis, one in channels.items()})
