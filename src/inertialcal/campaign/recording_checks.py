"""Sensors and recordings of a campaign: files that are there, units that fit, what the chain needs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..core.errors import DataError, InertialcalError, Problem
from ..core.units import kind, parse_quantity
from ..files.pad.pairs import pairs_of
from ..procedures.rate_table.entry import Rows
from .chains import build_chain, scale_factors
from .mass_checks import line_units
from .schema import CampaignFile
from .schema_recordings import RecordingEntry
from .schema_sensors import Sensor
from .toml_lines import At


def sensor_checks(name: str, sensor: Sensor, at: At) -> Iterator[Problem]:
    """Find a range or a chain of a sensor that cannot be read."""
    for text in sensor.range or []:
        try:
            parse_quantity(text).to(sensor.unit)
        except DataError as error:
            what = f"sensors.{name}.range: {error.problems[0].what}"
            yield Problem(what, at("sensors", name, "range"), code="wrong_value")
    if sensor.chain.kind != "none" and sensor.chain.scale_factor is None:
        what = f"sensors.{name}.chain: kind = {sensor.chain.kind!r} needs scale_factor"
        yield Problem(what, at("sensors", name, "chain"), code="missing_key")
        return
    try:
        build_chain(sensor) if sensor.chain.kind != "none" else scale_factors(sensor, tuple(sensor.axes))
    except InertialcalError as error:
        what = f"sensors.{name}.chain: {error.problems[0].what}"
        yield Problem(what, at("sensors", name, "chain"), do=error.problems[0].do, code="wrong_value")


def recording_checks(folder: Path, file: CampaignFile, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    """Find a recording without sensor or file, or in units that do not fit."""
    if entry.sensor not in file.sensors:
        do = f"There are: {', '.join(file.sensors)}"
        where = at("recordings", name, "sensor")
        yield Problem(f"recordings.{name}: no sensor {entry.sensor!r}", where, do=do, code="unknown_name")
    yield from _file(folder, name, entry.file, at("recordings", name, "file"))
    yield from _schedules(folder, name, entry, at)
    sensor = file.sensors.get(entry.sensor)
    if sensor is not None and entry.rows is not None and sensor.mounting is not None:
        what = f"recordings.{name}: the sensor has a mounting, which is for recordings of channels"
        do = "Give the table in body axes, and another sensor without mounting for it"
        yield Problem(what, at("recordings", name, "rows"), "the columns' axes would be ambiguous", do, "wrong_value")
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
    if sensor is not None:
        yield from _units(name, entry, sensor, at)


def _schedules(folder: Path, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    if entry.schedule is not None:
        yield from _file(folder, name, entry.schedule.file, at("recordings", name, "schedule"))
    if entry.mass is not None:
        yield from _file(folder, name, entry.mass.schedule, at("recordings", name, "mass"))


def _units(name: str, entry: RecordingEntry, sensor: Sensor, at: At) -> Iterator[Problem]:
    if entry.rows is not None:
        yield from _row_units(name, entry.rows, sensor, at)
    elif entry.means is not None:
        if kind(entry.means.unit) != kind(sensor.unit):
            what = f"recordings.{name}: means in {entry.means.unit!r}, need a unit of {kind(sensor.unit)}"
            yield Problem(what, at("recordings", name, "means"), code="wrong_value")
    elif entry.lines is not None:
        yield from line_units(name, entry.lines, at)
    else:
        yield from _channel_units(name, entry, sensor, at)


def _file(folder: Path, name: str, given: str, where: str) -> Iterator[Problem]:
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


def _channel_units(name: str, entry: RecordingEntry, sensor: Sensor, at: At) -> Iterator[Problem]:
    wanted = kind(sensor.unit)
    for channel, one in (entry.channels or {}).items():
        where = at("recordings", name, "channels", channel)
        axis = channel.rpartition("_")[2]
        if axis in {"x", "y", "z"} and axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")
        need = _kinds(channel, sensor, wanted)
        if need and kind(one.unit) not in need:
            what = f"recordings.{name}: channel {channel} in {one.unit!r}, need a unit of {' or '.join(need)}"
            yield Problem(what, where, code="wrong_value")


def _kinds(channel: str, sensor: Sensor, wanted: str) -> tuple[str, ...]:
    """Return the kinds of unit that a channel may have; none where it is not used."""
    counted = sensor.chain.kind != "none"
    if channel in ("temperature", "pressure"):
        return (channel,)
    if channel == "tilt":
        return ("angle",)
    if channel.startswith("temperature"):
        return ("temperature", "count") if counted else ("temperature",)
    if channel.startswith("gain"):
        return ("dimensionless",)
    if "_" in channel and not counted:
        return ()
    return (wanted,) if channel == "applied" or not counted else ("count",)


def _row_units(name: str, rows: Rows, sensor: Sensor, at: At) -> Iterator[Problem]:
    wanted = kind(sensor.unit)
    where = at("recordings", name, "rows")
    applied = rows.applied_unit or (sensor.unit if kind(rows.unit) in {"count", "voltage"} else rows.unit)
    if kind(applied) != wanted:
        yield Problem(f"recordings.{name}: applied in {applied!r}, need a unit of {wanted}", where, code="wrong_value")
    if kind(rows.unit) == "count" and sensor.chain.kind != "adc":
        yield Problem(f"recordings.{name}: counts, but the sensor's chain has no converter", where, code="wrong_value")
    elif kind(rows.unit) == "voltage" and sensor.chain.scale_factor is None:
        what = f"recordings.{name}: volts, but the sensor's chain has no scale_factor"
        yield Problem(what, where, code="wrong_value")
    elif kind(rows.unit) not in {"count", "voltage", wanted}:
        yield Problem(f"recordings.{name}: unit {rows.unit!r}, need a unit of {wanted}", where, code="wrong_value")
    for axis in [*(rows.reading if isinstance(rows.reading, dict) else ())]:
        if axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")
