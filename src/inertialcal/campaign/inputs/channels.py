"""A recording of channels, as a campaign describes it: read, timed, through the chain, into body axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...core.batches import batches, changed, empty, kept
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.show.rounding import number
from ...core.times import LATEST
from ...core.units import convert, convert_as_wide, kind, multiply, parse_quantity, si_unit
from ...sensors.chain.converter import Chain
from ...sensors.ground.correction import PREDICTED
from ...sensors.model.on_recordings import apply_chain
from ...signals.time.samples import Flags
from ...signals.time.time_axis import steps_of
from ..file.recordings import OF_CHAIN, ROLES, ChannelEntry, Clock, RecordingEntry
from ..file.schema import Test
from ..file.sensors import Sensor
from .chains import build_chain, in_input_units, recorded_chain
from .ground import ChainModel, after_model

TEMPERATURE, GAIN = "temperature", "gain"
NO_CHAIN = {name: role for name, role in ROLES.items() if name not in OF_CHAIN}  # channels that are in units already
TAKEN = frozenset(  # names of channels that mean something
    {
        *(name for what in (TEMPERATURE, GAIN) for name in (what, *(f"{what}_{axis}" for axis in AXES))),
        *(PREDICTED + axis for axis in AXES),
        *(what for what, role in NO_CHAIN.items() if role.kind),
    }
)
SAME_INTERVAL = 0.1  # relative difference of stated and seen interval that skipped saves explain
LONGEST = 1.01  # averaging over the interval, from which a sample would hold some of the next


def chain_of(entry: RecordingEntry, sensor: Sensor) -> Chain | None:
    """Return the chain of the axes that a recording has; None where they are in units already, or there is none."""
    axes = tuple(axis for axis in sensor.axes if axis in (entry.channels or {}))
    units = [(entry.channels or {})[axis].unit for axis in axes]
    if not axes or sensor.chain.kind == "none" or in_input_units(sensor, units):
        return None
    return recorded_chain(build_chain(sensor, axes), units)


def in_body_axes(
    recording: Recording,
    name: str,
    entry: RecordingEntry,
    sensor: Sensor,
    chain: Chain | None,
    model: ChainModel | None = None,
    keep_bias: bool = False,
    as_wide: bool = False,
) -> Recording:
    """Return the readings of a recording in body axes, SI, time in the middle of each average.

    Parameters
    ----------
    recording : Recording
        As its file has it.
    name, entry : str, RecordingEntry
        Of it, with ``channels``.
    sensor : Sensor
        Whose mounting applies.
    chain : Chain or None
        Of the axes that it has, as `chain_of` gives it.
    model : ChainModel, optional
        Of the ground, that applies.
    keep_bias : bool
        Whether the bias that a ground model predicts stays in.
    as_wide : bool
        Whether readings of 32 bits stay 32 bits wide.

    Returns
    -------
    Recording
        Channels ``x``, ``y``, ``z`` [SI] as far as they are there, those of roles [SI], then the others as they are;
        with a ground model ``predicted_x``, ... [SI].

    Raises
    ------
    DataError
        If a column is missing, the stamps are not as far apart as stated, or as the chain says.
    """
    channels = entry.channels or {}
    recording = _timed(recording, entry.clock or Clock())
    recording = _with_units(recording, {one.column: one.unit for one in channels.values()})
    axes = tuple(axis for axis in sensor.axes if axis in channels)
    if not axes:
        raise DataError(f"recordings.{name}: no channel x, y or z", code="wrong_column")
    columns = {what: one.column for what, one in channels.items()}
    recording = _declared(recording, columns)
    warm = {what: columns[what] for what, one in channels.items()
            if what not in (*NO_CHAIN, *axes) and one.unit and kind(one.unit) == TEMPERATURE}  # fmt: skip
    amplified = _gain_columns(columns, axes)
    recording = _in_si(recording, amplified, "1") if amplified else recording
    if chain is None:
        recording = _readings(recording, {axis: channels[axis] for axis in axes}, sensor, as_wide)
    else:
        used = {k: v for k, v in columns.items() if k not in NO_CHAIN and k not in warm and not k.startswith(GAIN)}
        recording = apply_chain(chain, recording, used, _gains(recording, chain))
    for what, role in NO_CHAIN.items():
        if what in columns:
            unit = role.unit if role.kind else si_unit(sensor.unit)
            recording = _in_si(recording, {what: columns[what]}, unit)
    if warm:
        recording = _in_si(recording, warm, "degC")
    if model is not None:
        recording = after_model(recording, entry, model, keep_bias, name)
    return _in_body(recording, sensor, axes)


def _with_units(recording: Recording, units: dict[str, str]) -> Recording:
    """Return the recording with the units that the campaign states, by column."""
    stated = {recording.channel(column).name: unit for column, unit in units.items()}
    channels = [
        one.changed(unit=stated[one.name] or None, unit_from="campaign") if one.name in stated else one
        for one in recording.channels
    ]
    return recording.changed(channels=tuple(channels))


def _declared(recording: Recording, columns: dict[str, str]) -> Recording:
    """Leave out columns that the campaign does not name but whose names would be taken for temperature or gain."""
    unsaid = TAKEN.intersection(recording.names).difference(columns.values())
    return recording.changed(channels=tuple([c for c in recording.channels if c.name not in unsaid]))


def _gain_columns(columns: dict[str, str], axes: tuple[str, ...]) -> dict[str, str]:
    """Return the columns of recorded gains by axis: one for all axes stands for each."""
    found = {f"{GAIN}_{axis}": columns.get(f"{GAIN}_{axis}", columns.get(GAIN, "")) for axis in axes}
    return {name: column for name, column in found.items() if column}


def _gains(recording: Recording, chain: Chain) -> Array | None:
    """Return the gain of each axis over time, shape (n, k), where one was recorded; None where none was."""
    names = [f"{GAIN}_{axis}" for axis in chain.axes]
    if not any(name in recording.names for name in names):
        return None
    found = np.array(np.broadcast_to(chain.gain, (len(recording), len(names))), dtype=float)
    for i, name in enumerate(names):
        if name in recording.names:
            found[:, i] = recording.channel(name).data
    return found


def _timed(recording: Recording, clock: Clock) -> Recording:
    """Move the stamps to the middle of their averaging windows."""
    seen = recording.sample_interval
    if clock.interval and seen and not _is_interval(clock.interval, recording, seen):
        what = f"clock.interval is {clock.interval:g} s, but the stamps are {seen:g} s apart"
        raise DataError(what, recording.source.path, do="Correct clock.interval, or the stamps", code="clock_disagrees")
    interval = clock.interval or seen
    averaging = clock.averaging if clock.averaging is not None else recording.averaging_time
    if averaging is not None and not 0.0 <= averaging <= LATEST:
        what = f"clock.averaging is {averaging:g} s: need 0 s to {LATEST:g} s"
        raise DataError(what, recording.source.path, do="Correct clock.averaging", code="averaging_time")
    if averaging is not None and interval and averaging > LONGEST * interval:
        what = f"averaging over {number(averaging, 6)} s, but samples are {number(interval, 6)} s apart"
        do = f'Give what a sample is the mean of, at most its interval: --averaging "{number(interval, 6)} s"'
        raise DataError(what, recording.source.path, do=do, code="averaging_time")
    if (interval, averaging) != (recording.sample_interval, recording.averaging_time):
        recording = replace(recording, sample_interval=interval, averaging_time=averaging)
    shift = {"start": 0.5, "middle": 0.0, "end": -0.5}[clock.stamp] * (averaging or 0.0)
    if recording.time_ns is None or shift == 0.0:
        return recording
    moved = round(shift * SECOND)
    return replace(recording, time_ns=changed(recording.time_ns, lambda part: part + moved, np.int64))


def _is_interval(stated: float, recording: Recording, seen: float) -> bool:
    """Return whether a stated interval is that of the stamps: of all, or of most where dwells alone were recorded.

    Such a record looks like packets: long steps between many short ones. What was stated tells them apart.
    """
    steps = [] if recording.time_ns is None else [steps_of(recording.time_ns).median() / SECOND]
    return any(abs(stated / one - 1.0) <= SAME_INTERVAL for one in (seen, *steps) if one)


def _in_si(recording: Recording, columns: dict[str, str], unit: str, as_wide: bool = False) -> Recording:
    """Rename the columns, in SI; the others stay as they are."""
    made = []
    for name, column in columns.items():
        channel = recording.channel(column)
        given, turn = channel.unit or unit, convert_as_wide if as_wide else convert
        values = channel.data
        if values.dtype != np.float64 or given != unit:
            kind_of = turn(values[:0], given, unit).dtype
            values = changed(values, partial(turn, from_unit=given, to_unit=unit), kind_of)
        made.append(Channel(name, values, unit, channel.unit_from, name if name in AXES else ""))
    used = {*columns.values(), *columns}
    return recording.changed(channels=(*made, *[one for one in recording.channels if one.name not in used]))


def _readings(recording: Recording, entries: Mapping[str, ChannelEntry], sensor: Sensor, as_wide: bool) -> Recording:
    """Rename the columns of axes, in SI; increments and their sum stay so, other sensors in the unit of the file."""
    columns = {axis: one.column for axis, one in entries.items()}
    if sensor.kind == "other":
        made = [replace(recording.channel(column), name=axis, axis=axis) for axis, column in columns.items()]
        others = [channel for channel in recording.channels if channel.name not in {*columns.values(), *columns}]
        return replace(recording, channels=(*made, *others))
    scaled = {}
    for one in entries.values():
        if one.scale_factor is not None:
            given = recording.channel(one.column)
            times = abs(parse_quantity(one.scale_factor).value)
            values = changed(given.data, lambda part, times=times: part / times)  # type: ignore[misc]
            scaled[given.name] = replace(given, data=values, unit=one.reading_unit)
    if scaled:
        recording = recording.changed(channels=tuple(scaled.get(one.name, one) for one in recording.channels))
    added = {one.quantity for one in entries.values()}
    if len(added) > 1:
        what = "channels x, y, z: some are rates, others increments or their sum"
        raise DataError(what, recording.source.path, do="Give each its own sensor", code="wrong_value")
    si = si_unit(sensor.unit)
    return _in_si(recording, columns, multiply(si, "s") if added != {None} else si, as_wide)


def _in_body(recording: Recording, sensor: Sensor, axes: tuple[str, ...]) -> Recording:
    """Turn the readings from sensor axes into body axes: ``mounting`` is sensor from body, so its transpose."""
    if sensor.mounting is None:
        return recording
    mounting = np.array(sensor.mounting)
    wanted = [i for i, axis in enumerate(AXES) if axis not in axes]
    if np.any(np.abs(mounting[wanted]) @ np.abs(mounting.T)[:, [AXES.index(a) for a in axes]] > 1e-9):
        raise DataError("mounting mixes axes that were not recorded", recording.source.path, code="wrong_column")
    made = _turned(recording, mounting, axes, "")
    if all(PREDICTED + axis in recording.names for axis in axes):
        made |= _turned(recording, mounting, axes, PREDICTED)
    channels = tuple(replace(c, data=made[c.name]) if c.name in made else c for c in recording.channels)
    return replace(recording, channels=channels)


def _turned(recording: Recording, mounting: Array, axes: tuple[str, ...], prefix: str) -> dict[str, Array]:
    """Return channels of the sensor axes along those of the body, by name."""
    sensed = {AXES.index(axis): recording.channel(prefix + axis).data for axis in axes}
    body = {prefix + axis: empty(len(recording), np.float64) for axis in axes}
    for first, stop in batches(*sensed.values(), *body.values()):
        part = np.zeros((stop - first, 3))
        for column, data in sensed.items():
            part[:, column] = data[first:stop]
        turned = part @ mounting
        for axis in axes:
            body[prefix + axis][first:stop] = turned[:, AXES.index(axis)]
    return body


def one_factor(entry: RecordingEntry, sensor: Sensor, chain: Chain | None) -> bool:
    """Return whether one factor makes the axes of `in_body_axes` of those that are stored, without a ground model."""
    if chain is not None or sensor.mounting is not None or sensor.kind == "other":
        return False
    own = [one for axis, one in (entry.channels or {}).items() if axis in sensor.axes]
    units = {one.unit for one in own}
    return all(one.scale_factor is None for one in own) and len(units) == 1 and kind(units.pop() or "1") != TEMPERATURE


def in_windows(recording: Recording, windows: Sequence[tuple[int, int]] | None) -> Flags | None:
    """Return which samples lie in windows; None where there are no windows, or no time in UTC."""
    if not windows or recording.time_ns is None or recording.epoch != "utc":
        return None
    keep = np.zeros(len(recording), dtype=bool)
    for start, stop in windows:
        keep |= (recording.time_ns >= start) & (recording.time_ns < stop)
    return keep


def windowed(recording: Recording, test: Test) -> Recording:
    """Return the samples inside the windows of a test; all where it has none.

    Raises
    ------
    DataError
        If the recording has no time in UTC (``no_time``), or no sample lies in them (``nothing_left``).
    """
    if not test.windows:
        return recording
    if recording.time_ns is None or recording.epoch != "utc":
        what = f"test {test.id!r}: windows are asked for, but the recording has no time in UTC"
        raise DataError(what, recording.source.path, code="no_time")
    keep = in_windows(recording, test.windows)
    assert keep is not None  # noqa: S101 - it has time
    if not keep.any():
        raise DataError(f"test {test.id!r}: no sample is in its windows", recording.source.path, code="nothing_left")
    channels = tuple([channel.changed(data=kept(channel.data, keep)) for channel in recording.channels])
    return recording.changed(channels=channels, time_ns=kept(recording.time_ns, keep))
