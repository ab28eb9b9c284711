"""Sensors and recordings of a campaign: files that are there, units that fit, what the chain needs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...core.errors import DataError, InertialcalError, Problem
from ...core.key import AXES
from ...core.schema.toml import At
from ...core.units import kind, parse_quantity
from ...files.pad.pairs import pairs_of
from ...procedures import loaded_procedures
from ..inputs.chains import build_chain, in_input_units, raw_kinds, scale_factors
from .recordings import ROLES, CommonKeys, own_keys
from .schema import CampaignFile
from .sensors import Sensor

# What is added up to the readings of a sensor: kinds of unit of increments and their sum.
ADDED = {"gyro": ("angle",), "accelerometer": ("velocity",), "other": ()}


def sensor_checks(name: str, sensor: Sensor, at: At) -> Iterator[Problem]:
    """Find a range or a chain of a sensor that cannot be read."""
    for text in sensor.range or []:
        try:
            parse_quantity(text).to(sensor.unit)
        except DataError as error:
            what = f"sensors.{name}.range: {error.problems[0].what}"
            yield Problem(what, at("sensors", name, "range"), code="wrong_value")
    if sensor.chain.kind == "adc" and sensor.chain.scale_factor is None:
        what = f"sensors.{name}.chain: kind = {sensor.chain.kind!r} needs scale_factor"
        yield Problem(what, at("sensors", name, "chain"), code="missing_key")
        return
    try:
        build_chain(sensor) if sensor.chain.kind != "none" else scale_factors(sensor, tuple(sensor.axes))
    except InertialcalError as error:
        what = f"sensors.{name}.chain: {error.problems[0].what}"
        yield Problem(what, at("sensors", name, "chain"), do=error.problems[0].do, code="wrong_value")


def recording_checks(
    folder: Path | None, file: CampaignFile, name: str, entry: CommonKeys, at: At
) -> Iterator[Problem]:
    """Find a recording without sensor or file, or in units that do not fit."""
    if entry.sensor not in file.sensors:
        do = f"There are: {', '.join(file.sensors)}"
        where = at("recordings", name, "sensor")
        yield Problem(f"recordings.{name}: no sensor {entry.sensor!r}", where, do=do, code="unknown_name")
    yield from _file(folder, name, entry.file, at("recordings", name, "file"))
    for key, said in own_keys(entry):
        if key.file is not None:
            yield from _file(folder, name, key.file(said), at("recordings", name, key.name))
    sensor = file.sensors.get(entry.sensor)
    if sensor is not None:
        yield from (one for procedure in loaded_procedures() for one in procedure.check_entry(name, entry, sensor, at))
    clock = entry.clock
    if clock is not None and clock.stamp != "middle" and clock.averaging is None:
        what = f"recordings.{name}: stamp = {clock.stamp!r} needs averaging: by how much is the stamp off the middle?"
        yield Problem(what, at("recordings", name, "clock"), code="missing_key")
    if (
        clock is not None
        and clock.averaging is not None
        and clock.interval is not None
        and clock.averaging > clock.interval * 1.001
    ):
        what = f"recordings.{name}: averaging over {clock.averaging:g} s, but saved every {clock.interval:g} s"
        yield Problem(what, at("recordings", name, "clock"), code="wrong_value")
    if clock is not None and clock.interval is not None and clock.interval <= 0.0:
        what = f"recordings.{name}: interval is {clock.interval:g} s: need more than 0 s"
        yield Problem(what, at("recordings", name, "clock"), code="wrong_value")
    if sensor is not None:
        yield from _channel_units(name, entry, sensor, at)


def _file(folder: Path | None, name: str, given: str, where: str) -> Iterator[Problem]:
    if folder is None:
        return
    try:
        root = folder.resolve()
        path = (root / given).resolve()
        exists = path.is_file() or (path.is_dir() and bool(pairs_of(path)))  # a folder of archive records
    except DataError:  # one member of a pair is not there, which its reader tells
        return
    except (OSError, ValueError, RuntimeError):
        yield Problem(f"recordings.{name}: {given!r} is no file name", where, code="missing_file")
        return
    if not path.is_relative_to(root):
        why = "a campaign must be complete in its folder"
        do = "Copy the file into the campaign folder"
        yield Problem(f"recordings.{name}: {given!r} lies outside the campaign folder", where, why, do, "outside")
    elif not exists:
        yield Problem(f"recordings.{name}: file {given!r} does not exist", where, code="missing_file")


def _channel_units(name: str, entry: CommonKeys, sensor: Sensor, at: At) -> Iterator[Problem]:
    wanted = kind(sensor.unit) if sensor.unit else ""
    channels = entry.channels or {}
    counted = sensor.chain.kind != "none"
    counted = counted and not in_input_units(sensor, [one.unit for name, one in channels.items() if name in AXES])
    for channel, one in channels.items():
        where = at("recordings", name, "channels", channel)
        axis = channel.rpartition("_")[2]
        if axis in {"x", "y", "z"} and axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")
        need = ADDED[sensor.kind] if one.quantity and channel in AXES else _kinds(channel, sensor, wanted, counted)
        if sensor.kind == "other" and channel in AXES:
            continue
        if need and (not one.unit or kind(one.reading_unit) not in need):
            given = f"in {one.unit!r}" if one.unit else "without a unit"
            what = f"recordings.{name}: channel {channel} {given}, need a unit of {' or '.join(need)}"
            yield Problem(what, where, code="wrong_value")


def _kinds(channel: str, sensor: Sensor, wanted: str, counted: bool) -> tuple[str, ...]:
    """Return the kinds of unit that a channel may have, with a chain or without; none where it is not used."""
    raw = raw_kinds(sensor)
    if channel in ROLES:
        return (ROLES[channel].kind or wanted,)
    if channel.startswith("temperature"):
        return ("temperature", *raw) if counted else ("temperature",)
    if channel.startswith("gain"):
        return ("dimensionless",)
    if "_" in channel and not counted:
        return ()
    return raw if counted else (wanted,)
