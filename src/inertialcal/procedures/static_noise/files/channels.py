"""Which channels of a recording are a sensor at rest, and what their samples are: told by names and units.

Channels of one kind are reduced together: the axes of a gyro, those of an accelerometer. What nobody said stays unsaid:
without a unit of angular rate or acceleration everything is in the unit of the file, and an angle or a velocity may be
integrated or added up, which only the user knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ....core.axes import Kind
from ....core.errors import DataError, UsageError
from ....core.recording import Channel, Recording
from ....core.remarks import Remark
from ....core.units import divide, factor, kind, normalise, parse_quantity, si_unit
from ....files.info.channel_survey import survey_channel
from ....files.info.hints import unit_hints
from ....signals.names import Quantity

Said = Literal["rate", "increment", "angle", "counts"]
SAID: tuple[Said, ...] = ("rate", "increment", "angle", "counts")
SENSED = {"gyro": "gyro", "acc": "accelerometer", "": ""}  # quantities of channels that may be a sensor's
KINDS: dict[str, Kind] = {"angular_rate": "gyro", "angle": "gyro", "acceleration": "accelerometer"}
ADDED = {"angle": "rad", "velocity": "m/s"}  # what is added up, and its unit inside
RATES: dict[Kind, str] = {"gyro": "rad/s", "accelerometer": "m/s^2"}
LIKE = {"gyro": "deg/s", "acc": "m/s2"}  # unit of a group, where its numbers suggest none
SHOWN: dict[Kind, str] = {"gyro": "deg/s", "accelerometer": "m/s^2"}  # of what was read in another unit


@dataclass(frozen=True)
class Taken:
    """One channel of a sensor."""

    channel: str  # Its name in the file
    kind: Kind | None  # None where the unit is neither's
    unit: str  # That the samples are in; empty where nobody said
    quantity: Quantity  # What they are
    scale: float  # SI unit a unit of the samples; 1 without a kind


@dataclass(frozen=True)
class Group:
    """Channels that are reduced together."""

    name: str  # ``"gyro"``, ``"accelerometer"``, or what the unit or the names say
    kind: Kind | None  # Of the sensor
    unit: str  # That figures of the samples are shown in; empty where nobody said
    quantity: Quantity  # What the samples are
    axes: Mapping[str, Taken]  # By axis, or by the name of the channel where axes are not said or not distinct


def groups_of(
    recording: Recording,
    columns: Sequence[str] = (),
    quantity: Said | None = None,
    scale_factors: Mapping[str, str] | None = None,
) -> tuple[tuple[Group, ...], tuple[Remark, ...]]:
    """Return the sensors of a recording, and what there is to say of them.

    Parameters
    ----------
    recording : Recording
        As read.
    columns : sequence of str
        Channels to take; those that can be a gyro's or an accelerometer's if none is named.
    quantity : {"rate", "increment", "angle", "counts"}, optional
        What the samples are, where their unit does not say it; ``"counts"``: readings as the converter gave them.
    scale_factors : mapping of str to str, optional
        Ideal scale factor by channel or group: ``{"gyro": "131 count/(deg/s)"}``.

    Raises
    ------
    DataError
        If no channel can be a sensor's (``no_channel``), or a named one is not there (``wrong_column``).
    UsageError
        If it is not clear what samples of an angle or velocity are (``no_quantity``), or what was said does not fit the
        unit (``unit_mismatch``, ``wrong_value``).
    """
    if quantity is not None and quantity not in SAID:
        raise UsageError(f"quantity {quantity!r}", do=f"There are: {', '.join(SAID)}", code="wrong_value")
    chosen, remarks = _chosen(recording, columns)
    scales = _scales(scale_factors or {}, chosen, recording)
    taken = [(one, _taken(one, quantity, scales.get(one.name), recording)) for one in chosen]
    found: dict[tuple[Kind | None, str, Quantity], list[tuple[Channel, Taken]]] = {}
    for channel, one in taken:
        same = (one.kind, "" if one.kind else one.unit or channel.quantity, one.quantity)
        found.setdefault(same, []).append((channel, one))
    groups = tuple(_group(members, len(found)) for members in found.values())
    return groups, (*remarks, *_without_unit(recording, taken), *_unasked(taken, quantity))


def _chosen(recording: Recording, columns: Sequence[str]) -> tuple[list[Channel], list[Remark]]:
    """Return the channels of sensors: those named, or those that can be one's."""
    if columns:
        return [recording.channel(name) for name in dict.fromkeys(columns)], []
    numbers = [one for one in recording.channels if one.data.dtype.kind in "iuf" and one.quantity in SENSED]
    sure = [one for one in numbers if one.quantity or (one.unit is not None and kind(one.unit) in KINDS)]
    chosen = sure or numbers
    if not chosen:
        what = "no channel can be a gyro's or an accelerometer's"
        do = f"Name it: --column NAME. The file has: {', '.join(recording.names) or 'none'}"
        raise DataError(what, recording.source.path, do=do, code="no_channel")
    left = [one.name for one in numbers if one not in chosen]
    if not left:
        return chosen, []
    what = f"not taken, since nothing says what they are: {', '.join(left)}"
    return chosen, [Remark("not_taken", "info", what, do="Name what is wanted: --column NAME")]


def _scales(given: Mapping[str, str], chosen: Sequence[Channel], recording: Recording) -> dict[str, str]:
    """Return the scale factor of each channel that has one: one for a channel goes before that of its group."""
    found: dict[str, str] = {}
    for key, text in given.items():
        named = [one.name for one in chosen if one.name == key]
        group = {"accelerometer": "acc", "accel": "acc"}.get(key, key)
        names = named or [one.name for one in chosen if one.quantity == group]
        if not names:
            have = ", ".join(one.name for one in chosen)
            what = f"scale factor of {key!r}: there is no such channel or group"
            raise UsageError(f"{recording.source.path}: {what}", do=f"There are: {have}", code="wrong_column")
        for name in names:
            if named or name not in found:
                found[name] = text
    return found


def _taken(channel: Channel, said: Said | None, scale_factor: str | None, recording: Recording) -> Taken:
    where = f"{recording.source.path}: {channel.name!r}"
    if scale_factor is not None:
        return _scaled(channel, said, scale_factor, where)
    unit = channel.unit or ""
    if not unit or said == "counts":
        return _in_file_unit(channel.name, unit, said)
    return _known(channel.name, unit, said, where)


def _in_file_unit(name: str, unit: str, said: Said | None) -> Taken:
    """Return a channel that is neither a rate nor what adds up to one: in its own unit, a reading of a rate."""
    return Taken(name, None, unit, "rate" if said is None or said == "counts" else said, 1.0)


def _known(name: str, unit: str, said: Said | None, where: str) -> Taken:
    """Return a channel whose unit is that of a rate, or of what is added up."""
    si = si_unit(unit)
    if si in RATES.values():
        if said not in (None, "rate"):
            what = f"{where} is in {unit}: that is a rate, no {said}"
            raise UsageError(what, do="Leave --quantity out, or say the unit", code="unit_mismatch")
        return Taken(name, "gyro" if si == "rad/s" else "accelerometer", unit, "rate", factor(unit, si))
    if si in ADDED.values():
        if said is None or said in {"rate", "counts"}:
            what = f"{where} is in {unit}: an increment, or integrated?"
            why = "both have the same unit, and other noise"
            do = "Say it: --quantity increment (what was added in each sample) or --quantity angle (integrated)"
            raise UsageError(what, why=why, do=do, code="no_quantity")
        added: Quantity = "angle" if said == "angle" else "increment"
        return Taken(name, "gyro" if si == "rad" else "accelerometer", unit, added, factor(unit, si))
    return _in_file_unit(name, unit, said)


def _scaled(channel: Channel, said: Said | None, text: str, where: str) -> Taken:
    """Return a channel that a scale factor takes to a rate, or to what is added up."""
    given = parse_quantity(text)
    own = channel.unit or "count"
    meant = divide(own, given.unit)
    si = si_unit(meant)
    known = {*RATES.values(), *ADDED.values()}
    if si not in known or not given.value:
        what = f"{where} is in {channel.unit or 'counts'}: a scale factor of {text!r} makes no rate of it"
        raise UsageError(what, do='Write it like "131 count/(deg/s)", output over input', code="unit_mismatch")
    one = _known(channel.name, meant, said if said != "counts" else None, where)
    return replace(one, unit=own, scale=one.scale / abs(given.value))


def _group(members: Sequence[tuple[Channel, Taken]], count: int) -> Group:
    first = members[0][1]
    axes = [channel.axis for channel, _ in members]
    by_axis = all(axes) and len(set(axes)) == len(axes)
    named = {(channel.axis if by_axis else channel.name): one for channel, one in members}
    unit = _shown(first)
    quantity = members[0][0].quantity
    name = first.kind or SENSED.get(quantity, quantity) or (unit if count > 1 and unit else "sensor")
    return Group(name, first.kind, unit, first.quantity, named)


def _shown(one: Taken) -> str:
    """Return the unit that readings are shown in: that of the file, where it is one of a rate."""
    if one.kind is None:
        return one.unit
    return normalise(one.unit) if one.unit and si_unit(one.unit) == RATES[one.kind] else SHOWN[one.kind]


def _without_unit(recording: Recording, taken: Sequence[tuple[Channel, Taken]]) -> list[Remark]:
    """Say which channels have no unit, with what their numbers suggest."""
    bare = [channel for channel, one in taken if not one.unit and one.kind is None]
    if not bare:
        return []
    part = replace(recording, channels=tuple(bare))
    hints = unit_hints(part, [survey_channel(channel) for channel in bare])
    seen = {hint.target: hint for hint in hints if hint.unit}
    names = ", ".join(channel.name for channel in bare)
    what = f"{names}: nobody said the unit, so figures are in that of the file"
    targets = dict.fromkeys(channel.quantity or channel.name for channel in bare)
    told = [
        f"--unit {one}={seen[one].unit} ({seen[one].reason})"
        if one in seen
        else f"--unit {one}={LIKE.get(one, 'deg/s')}"
        for one in targets
    ]
    return [Remark("no_unit", "warning", what, recording.source.path, do=f"Say it, like {', '.join(told)}")]


def _unasked(taken: Sequence[tuple[Channel, Taken]], said: Said | None) -> list[Remark]:
    """Say what was taken for a rate, though no unit says so."""
    bare = [channel.name for channel, one in taken if one.kind is None and one.quantity == "rate"]
    if not bare or said is not None:
        return []
    what = f"{', '.join(bare)}: samples are taken as readings of a rate"
    do = "If they add up to it, or are its integral, say --quantity increment or angle"
    return [Remark("taken_as_rate", "info", what, do=do)]
