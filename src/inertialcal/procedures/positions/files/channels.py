"""Channels of a test of positions: three accelerometers and three gyros on one clock, out of one file or several."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....core.axes import AXES
from ....core.errors import DataError, UsageError
from ....core.recording import SECOND, Channel, Recording
from ....core.remarks import Remark
from ....core.units import convert, kind, normalise

SENSORS = {"acc": ("acceleration", "m/s^2", "m/s2"), "gyro": ("angular_rate", "rad/s", "deg/s")}
ROLES = tuple(f"{sensor}_{axis}" for sensor in SENSORS for axis in AXES)
TEMPERATURE = "temperature"
IN_NAME = {"acc": re.compile(r"acc"), "gyro": re.compile(r"gyr")}  # of a file without a header
SAME_STAMP = 0.01  # of a sample interval, by which stamps of one clock may differ
PLAUSIBLE = {"m/s2": (9.0, 10.5), "g": (0.9, 1.1), "mg": (900.0, 1100.0)}  # median length of acceleration at rest


@dataclass(frozen=True, eq=False)
class Taken:
    """Channels by what they are.

    Parameters
    ----------
    recording : Recording
        Channels ``acc_x``, ..., ``gyro_z`` in SI, or in the unit of the output, and ``temperature`` [degC].
    columns : mapping of str to str
        Role -> name in the file.
    units : mapping of str to str
        ``"acc"``, ``"gyro"`` -> unit in the file.
    remarks : tuple of Remark
        What was inferred.
    """

    recording: Recording
    columns: Mapping[str, str]
    units: Mapping[str, str]
    remarks: tuple[Remark, ...] = ()

    @property
    def sensors(self) -> tuple[str, ...]:
        """``"acc"``, and ``"gyro"`` where there are gyros."""
        return tuple(self.units)


def taken(
    recordings: Sequence[Recording], sensors: Sequence[str], columns: Mapping[str, str], units: Mapping[str, str]
) -> Taken:
    """Return the channels of one file, or of two files of one clock.

    Parameters
    ----------
    recordings : sequence of Recording
        As read.
    sensors : sequence of str
        ``"acc"`` or ``"gyro"`` where a file is of these alone by what the user said, else ``""``.
    columns : mapping of str to str
        Role -> column, as the user said; empty where nothing was said.
    units : mapping of str to str
        Of ``acc``, ``gyro``, ``temperature`` or a column, as the user said.

    Raises
    ------
    UsageError
        If it is not clear which channel is what, or in which unit.
    DataError
        ``clocks_differ`` if two files are not of one clock; ``no_values``; ``too_few_samples``.
    """
    _check_roles(columns)
    _check_columns(columns, recordings)
    _check_length(recordings)
    found: dict[str, tuple[Recording, Channel]] = {}
    remarks: list[Remark] = []
    for recording, sensor in zip(recordings, sensors, strict=True):
        for role, channel in _roles(recording, sensor, columns, remarks).items():
            if role in found:
                paths = f"{found[role][0].source.path} and {recording.source.path}"
                raise UsageError(f"{paths} both have {role}", do="Give one of them", code="duplicate_id")
            found[role] = recording, channel
    if any(f"acc_{axis}" not in found for axis in AXES):
        raise _lacking(recordings, found)
    if any(role.startswith("gyro") for role in found) and any(f"gyro_{axis}" not in found for axis in AXES):
        raise _lacking(recordings, found)
    check_clock(recordings)
    spoken = _units(found, units)
    _check_values(found)
    made = [_in_si(role, channel, spoken[_sensor(role)]) for role, (_, channel) in sorted(found.items())]
    whole = replace(recordings[0], channels=tuple(made), remarks=_unique(recordings))
    several = len(recordings) > 1
    named = {
        role: f"{channel.name} of {Path(recording.source.path).name}" if several else channel.name
        for role, (recording, channel) in sorted(found.items())
    }
    return Taken(whole, named, {s: spoken[s] for s in SENSORS if s in spoken}, tuple(remarks))


def _check_roles(columns: Mapping[str, str]) -> None:
    wrong = [role for role in columns if role not in (*ROLES, TEMPERATURE)]
    if wrong:
        do = f"There are: {', '.join((*ROLES, TEMPERATURE))}"
        raise UsageError(f"column {wrong[0]!r}", do=do, code="unknown_name")


def _check_columns(columns: Mapping[str, str], recordings: Sequence[Recording]) -> None:
    known = [name for one in recordings for name in one.names]
    for role, name in columns.items():
        if name not in known:
            paths = ", ".join(one.source.path for one in recordings)
            raise UsageError(f"{role}={name}: no channel {name!r} in {paths}", do=f"There are: {', '.join(known)}",
                             code="no_column")  # fmt: skip


def _check_length(recordings: Sequence[Recording]) -> None:
    for one in recordings:
        if len(one) < 2:
            what = f"{len(one)} sample(s)"
            why = "positions are told by stretches at rest"
            raise DataError(what, one.source.path, why, "Record again, or name another file", "too_few_samples")


def _roles(recording: Recording, sensor: str, columns: Mapping[str, str], remarks: list[Remark]) -> dict[str, Channel]:
    """Return the channels of one file by role: as said, else by their names, else by the file."""
    said = {role: recording.channel(name) for role, name in columns.items() if name in recording.names}
    own: dict[str, Channel] = {}
    for one in SENSORS if not sensor else (sensor,):
        if any(_sensor(role) == one for role in said):
            continue
        named = [c for c in recording.channels if c.quantity == one and c.axis in AXES]
        if len({c.axis for c in named}) == len(named):
            own |= {f"{one}_{c.axis}": c for c in named}
    warm = [c for c in recording.channels if c.quantity == TEMPERATURE]
    own |= {TEMPERATURE: warm[0]} if len(warm) == 1 else {}
    if any(role != TEMPERATURE for role in (*own, *said)):
        return own | said
    return _in_order(recording, sensor, remarks) | said


def _in_order(recording: Recording, sensor: str, remarks: list[Remark]) -> dict[str, Channel]:
    """Return three channels without a name as x, y, z of the sensor that the user, or the name of the file, says."""
    bare = [c for c in recording.channels if c.quantity in ("", sensor) and c.data.dtype.kind in "iuf"]
    name = Path(recording.source.path).name.lower()
    by_name = [one for one, pattern in IN_NAME.items() if pattern.search(name)]
    one = sensor or (by_name[0] if len(by_name) == 1 else "")
    if len(bare) != len(AXES) or not one:
        return {}
    listed = ", ".join(channel.name for channel in bare)
    by = "as said" if sensor else "by the name of the file"
    what = f"{listed} taken for x, y, z of the {'gyros' if one == 'gyro' else 'accelerometers'} ({by}, in their order)"
    remarks.append(
        Remark("axes_in_order", "info", what, recording.source.path, do=f"Else say it: --column {one}_x=COLUMN")
    )
    return {f"{one}_{axis}": channel for axis, channel in zip(AXES, bare, strict=True)}


def _lacking(recordings: Sequence[Recording], found: Mapping[str, object]) -> UsageError:
    missing = [role for role in ROLES if role not in found and (role.startswith("acc") or _partly(found))]
    paths = ", ".join(one.source.path for one in recordings)
    have = ", ".join(name for one in recordings for name in one.names)
    what = f"{paths}: no channel is clearly {', '.join(missing)}; there are {have}"
    do = "Say it: --column acc_x=COLUMN --column acc_y=COLUMN ..., or acc=FILE gyro=FILE"
    return UsageError(what, why="gravity is what calibrates, and accelerometers feel it", do=do, code="no_column")


def _partly(found: Mapping[str, object]) -> bool:
    return any(role.startswith("gyro") for role in found)


def check_clock(recordings: Sequence[Recording]) -> None:
    """Refuse recordings whose samples are not taken at the same times.

    Raises
    ------
    DataError
        ``clocks_differ``.
    """
    first, *others = recordings
    for other in others:
        if len(first) != len(other) or (first.time_ns is None) != (other.time_ns is None) or _apart(first, other):
            what = f"{_span(first)}, {_span(other)}: not of one clock"
            why = "what the gyros turned by would be set beside positions of another time"
            do = "Record both on one clock, or bring them to the same stamps"
            raise DataError(what, other.source.path, why, do, "clocks_differ")


def _apart(one: Recording, other: Recording) -> bool:
    if one.time_ns is None or other.time_ns is None or not len(one):
        return False
    most = SAME_STAMP * (one.sample_interval or 0.0) * SECOND
    return bool(np.max(np.abs(one.time_ns - other.time_ns)) > most)


def _span(one: Recording) -> str:
    times = one.time_ns
    ends = "" if times is None or not len(times) else f" from {times[0] / SECOND:.12g} to {times[-1] / SECOND:.12g} s"
    return f"{Path(one.source.path).name}: {len(one)} samples{ends}"


def _check_values(found: Mapping[str, tuple[Recording, Channel]]) -> None:
    for role, (recording, channel) in found.items():
        if not np.isfinite(np.asarray(channel.data, dtype=np.float64)).any():
            what = f"{channel.name!r}, taken for {role}, holds no value"
            do = f"Say which column it is, --column {role}=COLUMN, or record again"
            raise DataError(what, recording.source.path, do=do, code="no_values")


def _units(found: Mapping[str, tuple[Recording, Channel]], said: Mapping[str, str]) -> dict[str, str]:
    """Return the unit of each sensor, and of the temperature: as said, else as the file says.

    Raises
    ------
    UsageError
        ``no_unit`` where nobody says it, or axes of one sensor differ; ``unit_mismatch`` for one of another kind.
    """
    spoken: dict[str, str] = {}
    missing: dict[str, list[str]] = {}
    for sensor in dict.fromkeys(map(_sensor, found)):
        own = {role: channel for role, (_, channel) in found.items() if _sensor(role) == sensor}
        units = {_unit_of(role, channel, sensor, said) for role, channel in own.items()}
        if None in units or len(units) > 1:
            missing[sensor] = [channel.name for channel in own.values()]
            continue
        unit = units.pop() or ""
        _check_kind(sensor, unit, next(iter(own.values())).name)
        spoken[sensor] = unit
    missing.pop(TEMPERATURE, None)
    if missing:
        raise _no_unit(found, missing)
    return spoken


def _unit_of(role: str, channel: Channel, sensor: str, said: Mapping[str, str]) -> str | None:
    given = said.get(role) or said.get(channel.name) or said.get(sensor)
    if given is None:
        return channel.unit
    try:
        return normalise(given)
    except DataError as error:
        problems = [replace(one, what=f"--unit {sensor}={given}: {one.what}") for one in error.problems]
        raise UsageError(problems) from None


def _check_kind(sensor: str, unit: str, name: str) -> None:
    wrong = {"acc": "angular_rate", "gyro": "acceleration", TEMPERATURE: ""}[sensor]
    if kind(unit) == wrong or (kind(unit) == TEMPERATURE and sensor != TEMPERATURE):
        like = SENSORS[sensor][2]
        what = f"{name}: {unit!r} is no unit of {'an accelerometer' if sensor == 'acc' else 'a gyro'}"
        raise UsageError(what, do=f"Say it: --unit {sensor}={like}, or {sensor}=count", code="unit_mismatch")


def _no_unit(found: Mapping[str, tuple[Recording, Channel]], missing: Mapping[str, Sequence[str]]) -> UsageError:
    names = "; ".join(f"{', '.join(names)} of {sensor}" for sensor, names in missing.items())
    hint = _hint(found) if "acc" in missing else ""
    path = next(iter(found.values()))[0].source.path
    do = " ".join(f"--unit {sensor}={SENSORS[sensor][2]}" for sensor in missing)
    counts = " ".join(f"--unit {sensor}=count" for sensor in missing)
    return UsageError(f"{path}: no unit, or several: {names}{hint}", do=f"Say it: {do}, or {counts}", code="no_unit")


def _hint(found: Mapping[str, tuple[Recording, Channel]]) -> str:
    axes = [np.asarray(found[f"acc_{axis}"][1].data, dtype=np.float64) for axis in AXES]
    if len({len(one) for one in axes}) > 1:
        return ""
    length = float(np.nanmedian(np.sqrt(axes[0] ** 2 + axes[1] ** 2 + axes[2] ** 2)))
    like = next((unit for unit, (low, high) in PLAUSIBLE.items() if low <= length <= high), "")
    return f" (median |acc| is {length:.4g}{': ' + like + '?' if like else ''})"


def _in_si(role: str, channel: Channel, unit: str) -> Channel:
    sensor = _sensor(role)
    data = np.asarray(channel.data, dtype=np.float64)
    if sensor == TEMPERATURE:
        return replace(channel, name=role, data=convert(data, unit, "degC"), unit="degC")
    wanted, si, _ = SENSORS[sensor]
    if kind(unit) != wanted:
        return replace(channel, name=role, data=data, unit=unit, axis=role[-1], quantity=sensor)
    return replace(channel, name=role, data=convert(data, unit, si), unit=si, axis=role[-1], quantity=sensor)


def _sensor(role: str) -> str:
    return role.partition("_")[0]


def _unique(recordings: Sequence[Recording]) -> tuple[Remark, ...]:
    return tuple(dict.fromkeys(remark for one in recordings for remark in one.remarks))
