"""What a file is taken for: sensors at rest, by the names and units of its channels.

Channels of one kind are one sensor with a test of its own. Nothing is guessed: without a unit of angular rate or
acceleration everything is in the unit of the file, and an angle or a velocity may be what each sample adds or their
sum, which only the user knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...core.errors import DataError, UsageError
from ...core.key import AXES
from ...core.recording import Channel
from ...core.remarks import Remark
from ...core.units import divide, kind, normalise, parse_quantity, si_unit
from ...files.info.channel_survey import unit_hints
from ..given import (
    KIND_OF_UNIT,
    Described,
    GivenFile,
    bare,
    chain_said,
    described,
    named_columns,
    own_clock,
    sensor_said,
    without_effect,
)
from ..protocol import InputSpec

SENSED = {"gyro": "gyro", "acc": "accelerometer", "": ""}  # quantities of channels that may be a sensor's
GROUPS = {"accelerometer": "acc", "accel": "acc"}  # words that people use for a group of channels
RATES = {"rad/s": "gyro", "m/s^2": "accelerometer"}  # kind of sensor by the SI unit of its readings
ADDED = {"rad": "gyro", "m/s": "accelerometer"}  # and of what they add up to
KINDS = ("angular_rate", "angle", "acceleration")
SPOKEN = {"gyro": "deg/s", "accelerometer": "m/s^2", "other": ""}  # unit shown of what was read in another one
LIKE = {"gyro": "deg/s, rad/s", "acc": "m/s2, g"}  # units of a group, where its numbers suggest none


@dataclass(frozen=True)
class _Taken:
    """A channel of a sensor: kind of the sensor, unit that readings are shown in, what its entry says."""

    channel: Channel
    kind: str
    unit: str
    entry: dict[str, Any]

    @property
    def group(self) -> tuple[str, str, str]:
        """The same for all channels of one sensor."""
        own = "" if self.kind != "other" else self.unit or self.channel.quantity
        return self.kind, own, self.entry.get("quantity", "")


def described_sensors(given: GivenFile, inputs: InputSpec) -> list[Described]:
    """Return the sensors of a file, each with channels x, y, z and a test of its own.

    Raises
    ------
    DataError
        If no channel can be a sensor's (``no_channel``), or a named one is not there (``wrong_column``).
    UsageError
        If it is not clear what samples of an angle or velocity are (``no_quantity``), or a setting does not fit the
        unit (``unit_mismatch``).
    """
    if chain_said(given).keys() - {"kind", "scale_factor"}:
        return [described(given, inputs)]
    chosen, remarks = _chosen(given)
    scales = _scale_factors(given, chosen)
    taken = [_taken(given, one, scales.get(one.name)) for one in chosen]
    remarks += _without_unit(given, taken)
    groups: dict[tuple[str, str, str], list[_Taken]] = {}
    for one in taken:
        groups.setdefault(one.group, []).append(one)
    found: list[Described] = []
    for members in groups.values():
        for part in _triads(given, members):
            name = _name(part, found)
            channels = {axis: one.entry for axis, one in part.items()}
            first = next(iter(part.values()))
            chain: dict[str, object] = {}  # each channel has its own scale factor
            sensor = sensor_said(given, "gyro", [*part], first.unit, chain) | {"kind": first.kind}
            columns = {
                f"{name} {axis}" if len(taken) > len(AXES) else axis: one.channel.name for axis, one in part.items()
            }
            own = own_clock(given, first.kind)
            found.append(Described({"channels": channels, **own}, sensor, columns, test=name))
    return [replace(found[0], remarks=tuple(remarks)), *found[1:]]


def _chosen(given: GivenFile) -> tuple[list[Channel], list[Remark]]:
    """Return the channels named, or those that can be a sensor's."""
    recording, columns = given.recording, given.said.columns
    if columns:
        if wrong := [axis for axis, name in columns.items() if axis not in AXES and axis != name]:
            raise UsageError(f"column {wrong[0]!r}", do=f"There are: {', '.join(AXES)}", code="unknown_name")
        columns = named_columns(recording, columns)
        named = [(axis, recording.channel(name)) for axis, name in columns.items()]
        return [replace(one, axis=axis) if axis in AXES else one for axis, one in named], []
    numbers = [one for one in recording.channels if one.data.dtype.kind in "iuf" and one.quantity in SENSED]
    sure = [one for one in numbers if one.quantity or (one.unit is not None and kind(one.unit) in KINDS)]
    chosen = sure or numbers
    if given.said.sensor is not None:
        group = GROUPS.get(given.said.sensor, given.said.sensor)
        chosen = [one for one in chosen if one.quantity == group]
    if not chosen:
        what = "no channel can be a gyro's or an accelerometer's"
        do = f"Add: {given.add('column', 'COLUMN')}. The file has: {', '.join(recording.names) or 'none'}"
        raise DataError(what, given.name, do=do, code="no_channel")
    unused = [one.name for one in numbers if one not in chosen]
    if not unused:
        return chosen, []
    what = f"columns not used, kind unknown: {', '.join(unused)}"
    return chosen, [Remark("not_taken", "info", what, do=f"Name the ones you want: {given.add('column', 'COLUMN')}")]


def _scale_factors(given: GivenFile, chosen: Sequence[Channel]) -> dict[str, str]:
    """Return the scale factor of each channel that has one: its own goes before that of its group."""
    stated = given.own.get("scale_factor") or {}
    found = dict.fromkeys([one.name for one in chosen], bare(stated)) if bare(stated) else {}
    for named in (False, True):
        for key, text in stated.items():
            channels = [one.name for one in chosen if one.name == key]
            group = [one.name for one in chosen if one.quantity == GROUPS.get(key, key)]
            if key != text and not channels and not group:
                do = f"There are: {', '.join(one.name for one in chosen)}"
                raise UsageError(f"{given.name}: scale factor: no channel or group {key!r}", do=do, code="wrong_column")
            found |= dict.fromkeys(channels if named else group, text)
    return {name: text for name, text in found.items() if text}


def _taken(given: GivenFile, channel: Channel, scale_factor: str | None) -> _Taken:
    """Return a channel with the kind of its sensor, by its unit."""
    unit, quantity, where = channel.unit or "", given.own.get("quantity"), f"{given.name}: {channel.name!r}"
    meant = unit
    if scale_factor is not None:
        if kind(unit or "1") in KIND_OF_UNIT.values():
            raise without_effect(given, "scale_factor", unit)
        meant = divide(unit or "count", parse_quantity(scale_factor).unit)
        if si_unit(meant) not in {*RATES, *ADDED} or parse_quantity(scale_factor).unit == "1":
            what = f"{where} is in {unit or 'counts'}: a scale factor of {scale_factor!r} does not make it a rate"
            raise UsageError(what, do='Write output over input: "131 count/(deg/s)"', code="unit_mismatch")
    si = si_unit(meant) if meant else ""
    entry: dict[str, Any] = {"column": channel.name}
    if unit or scale_factor is not None:
        entry["unit"] = normalise(unit or "count")
    if si in RATES and quantity in ("increment", "angle"):
        what = f"{where} is in {unit}: a rate, not an {quantity}"
        raise UsageError(what, do="Leave --quantity out, or correct the unit", code="unit_mismatch")
    if si in ADDED and quantity not in ("increment", "angle"):
        what = f"{where} is in {unit}: is a sample an increment, or the integral?"
        ways = given.add("quantity", "increment"), given.add("quantity", "angle")
        do = f"Add: {ways[0]} (what each sample adds) or {ways[1]} (the integral)"
        raise UsageError(what, why="both have the same unit, but different noise", do=do, code="no_quantity")
    sensor = RATES.get(si) or ADDED.get(si) or "other"
    if quantity in ("increment", "angle"):
        entry["quantity"] = quantity
    if scale_factor is not None:
        entry["scale_factor"] = scale_factor
    shown = (
        normalise(unit) if unit and (sensor == "other" or (si in RATES and scale_factor is None)) else SPOKEN[sensor]
    )
    return _Taken(channel, sensor, shown, entry)


def _triads(given: GivenFile, members: Sequence[_Taken]) -> Iterator[dict[str, _Taken]]:
    """Yield channels by axis: their own axes, or x, y, z in the order of the file, three at a time."""
    axes = [one.channel.axis for one in members]
    if all(axis in AXES for axis in axes) and len(set(axes)) == len(axes):
        yield {axis: one for axis in AXES for one in members if one.channel.axis == axis}
        return
    for first in range(0, len(members), len(AXES)):
        yield dict(zip(AXES, members[first : first + len(AXES)], strict=False))


def _name(part: dict[str, _Taken], others: Sequence[Described]) -> str:
    """Return the name of a sensor and its test: its kind, or what its channels are called, numbered where needed."""
    first = next(iter(part.values()))
    stem = first.kind if first.kind != "other" else SENSED.get(first.channel.quantity) or "sensor"
    used = {one.test for one in others}
    return next(name for name in (stem, *(f"{stem}_{i}" for i in range(2, len(used) + 3))) if name not in used)


def _without_unit(given: GivenFile, taken: Sequence[_Taken]) -> list[Remark]:
    """Say which channels have no unit, with what their numbers suggest, and what was taken for a rate."""
    remarks = []
    missing = [one.channel for one in taken if one.kind == "other" and not one.unit]
    if missing:
        part = replace(given.recording, channels=tuple(missing))
        hints = unit_hints(part)
        seen = {hint.target: hint for hint in hints if hint.unit}
        options = [
            f"{given.add('unit', f'{one}={seen[one].unit}')} ({seen[one].reason})"
            if one in seen
            else f"{given.add('unit', f'{one}=UNIT')} (UNIT: {LIKE.get(one, 'deg/s, m/s2')}, ...)"
            for one in dict.fromkeys(one.quantity or one.name for one in missing)
        ]
        what = f"unit not given, figures are in that of the file: {', '.join(one.name for one in missing)}"
        remarks.append(Remark("no_unit", "warning", what, given.name, do=f"Add: {', '.join(options)}"))
    rates = [one.channel.name for one in taken if one.kind == "other" and "quantity" not in one.entry]
    if rates and given.own.get("quantity") is None:
        what = f"{', '.join(rates)}: samples taken as readings of a rate"
        do = f"If they add up to it, or are its integral: {given.add('quantity', 'increment')} or angle"
        remarks.append(Remark("taken_as_rate", "info", what, do=do))
    return remarks
