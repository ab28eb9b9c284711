"""Recordings of a unit at rest over temperature, as sweeps on the clock of their power-up.

Recordings with one run label are of one power-up; the first sample of the earliest of them is taken for the power-up
itself. Without labels every recording is a run of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...core.batches import batches, changed, extremes
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark

TEMPERATURE, PRESSURE, REFERENCE = "temperature", "pressure", "reference_temperature"
WARM = (TEMPERATURE, *(f"{TEMPERATURE}_{axis}" for axis in AXES))
REFERENCES = ("reference_voltage", "temperature_reference_voltage")  # channels of reference voltages, with their axis
FASTEST = 1.0  # [degC/s]: temperature-cycling chambers reach a quarter of it
SMALLEST_SWING = 5.0  # [degC], below which a fast change may be noise
STRETCHES = 200  # whose means a fast change is looked for in


@dataclass(frozen=True, eq=False)
class ThermalRecording:
    """A recording of a unit at rest while its temperature changed."""

    # Channels named by axis [SI]; ``temperature`` or ``temperature_x``, ... [degC]; ``reference_voltage_x``, ...
    # [V], ``pressure`` [Pa] where there are any.
    recording: Recording
    run: str = ""  # Power-up; empty where not given
    name: str = ""  # Of the recording


def readings_from(warmed: Sequence[ThermalRecording], unit: str = "rad/s") -> Readings:
    """Return the sweeps of the recordings of a test.

    Raises
    ------
    DataError
        ``no_recordings``; ``overlap`` if two are at the same time, which one unit cannot be.
    """
    if not warmed:
        raise DataError("no recordings", code="no_recordings")
    if any(one.run for one in warmed) and not all(one.run for one in warmed):
        without = next(one for one in warmed if not one.run)
        what = f"{_place(without)} does not name its run, others do"
        raise DataError(what, why="power-ups would be ambiguous", do="Name the run of all", code="mixed_runs")
    _check_apart(warmed)
    remarks = [remark for one in warmed for remark in one.recording.remarks]
    timed = {id(one): _is_timed(one.recording) for one in warmed}
    remarks += [_untimed(one) for one in warmed if not timed[id(one)]]
    ordered = sorted(warmed, key=lambda one: (_first(one), one.name))
    labels = [one.run or _place(one) for one in ordered]
    begin: dict[str, int] = {}
    for label, one in zip(labels, ordered, strict=True):
        begin.setdefault(label, _first(one))
    sweeps = [
        _sweep(one, label, begin[label] if timed[id(one)] else None) for label, one in zip(labels, ordered, strict=True)
    ]
    return Readings(tuple(sweeps), unit, tuple(remarks))


def _sweep(one: ThermalRecording, label: str, power_up: int | None) -> Sweep:
    """Return a recording on the time since power-up [ns], where that is known."""
    recording = one.recording
    outputs = {axis: _floats(recording, axis) for axis in AXES if axis in recording.names}
    temperature = {axis: found for axis in outputs if (found := _temperature(recording, axis)) is not None}
    references = {name: _by_axis(recording, name, outputs) for name in REFERENCES}
    time = None
    if power_up is not None and recording.time_ns is not None:
        time = changed(recording.time_ns, lambda part: (part - power_up).astype(np.float64) / SECOND)
    pressure = _floats(recording, PRESSURE) if PRESSURE in recording.names else None
    beside = _floats(recording, REFERENCE) if REFERENCE in recording.names else None
    kept = {name: by_axis for name, by_axis in references.items() if by_axis}
    return Sweep(one.name or _place(one), label, _place(one), time, temperature, outputs, kept, pressure, beside)


def _temperature(recording: Recording, axis: str) -> Array | None:
    """Temperature of one sensor: its own channel, else the one for all."""
    for name in (f"{TEMPERATURE}_{axis}", TEMPERATURE):
        if name in recording.names:
            return _floats(recording, name)
    return None


def _by_axis(recording: Recording, name: str, outputs: Mapping[str, Array]) -> dict[str, Array]:
    return {axis: _floats(recording, f"{name}_{axis}") for axis in outputs if f"{name}_{axis}" in recording.names}


def _floats(recording: Recording, name: str) -> Array:
    data = recording.channel(name).data
    return data if data.dtype == np.float64 else changed(data, lambda part: part.astype(np.float64))


def _place(one: ThermalRecording) -> str:
    return one.recording.source.path or one.name or "recording"


def _first(one: ThermalRecording) -> int:
    times = one.recording.time_ns
    return int(times[0]) if times is not None and len(times) else 0


def _is_timed(recording: Recording) -> bool:
    """Whether a recording has a time axis that its temperature can have followed."""
    seconds = recording.seconds
    if seconds is None:
        return False
    return all(_swing_rate(_floats(recording, c.name), seconds) <= FASTEST for c in recording.channels
               if c.name in WARM and c.data.dtype.kind in "fiu" and c.unit == "degC")  # fmt: skip


def _swing_rate(temperature: Array, seconds: Array) -> float:
    """Largest change over the time that it took [degC/s]; 0 for a small one."""
    size = max(1, len(seconds) // STRETCHES)
    count = len(seconds) // size
    level, at = (block_means(one, size)[:count] for one in (temperature, seconds))
    good = np.isfinite(level)
    if np.count_nonzero(good) < 2:
        return 0.0
    level, at = level[good], at[good]
    cold, warm = int(np.argmin(level)), int(np.argmax(level))
    swing, between = float(level[warm] - level[cold]), abs(float(at[warm] - at[cold]))
    if swing < SMALLEST_SWING:
        return 0.0
    return swing / between if between > 0.0 else np.inf


def block_means(x: Array, size: int) -> Array:
    """Return the means of blocks of so many samples, shape (n // size,); what is over is left out."""
    means = np.empty(len(x) // size)
    whole = x[: len(means) * size]
    for first, stop in batches(whole, whole=size):
        means[first // size : stop // size] = whole[first:stop].reshape(-1, size).mean(axis=1)
    return means


def _untimed(one: ThermalRecording) -> Remark:
    if one.recording.seconds is None:
        what = "no time: samples are taken in order; rates of the ramps, lag and start-up are not known"
        return Remark("no_time", "warning", what, _place(one), do="Name the time column, or give the sample rate")
    what = "the time axis is impossible: the temperature would change by more than 1 degC/s; it is not used"
    return Remark("time_axis_impossible", "warning", what, _place(one), do="Find out the true sample rate")


def _check_apart(warmed: Sequence[ThermalRecording]) -> None:
    """Refuse two recordings of one unit at the same time."""
    timed = [one for one in warmed if one.recording.epoch == "utc" and one.recording.time_ns is not None]
    spans = sorted(((_first(one), int(one.recording.time_ns[-1]), one) for one in timed  # type: ignore[index]
                    if len(one.recording)), key=lambda span: span[:2])  # fmt: skip
    for (_, stop, one), (start, _, other) in pairwise(spans):
        if start < stop:
            what = f"{_name(one)} and {_name(other)} overlap in time by {(stop - start) / SECOND:.6g} s"
            why = "one unit cannot be in two recordings at once"
            raise DataError(what, _place(other), why, "Mend the stamps, or leave one out", "overlap")


def _name(one: ThermalRecording) -> str:
    return one.name or _place(one)


@dataclass(frozen=True, eq=False)
class Sweep:
    """One recording of a unit at rest while its temperature changed."""

    name: str  # Of the recording
    run: str  # Power-up; empty where not given
    place: str  # File, for messages
    time: Array | None  # shape (n,): since power-up [s]; None where no time is known
    temperature: Mapping[str, Array]  # shape (n,): of each axis' sensor [degC]
    outputs: Mapping[str, Array]  # shape (n,): reading of each axis [rad/s] or [m/s^2]; NaN where missing
    # shape (n,): name of a reference voltage -> axis -> its volts [V]
    references: Mapping[str, Mapping[str, Array]] = field(default_factory=dict[str, Mapping[str, Array]])
    pressure: Array | None = None  # shape (n,): [Pa]
    reference: Array | None = None  # shape (n,): of a reference thermometer beside the sensors [degC]

    def __len__(self) -> int:
        return len(next(iter(self.outputs.values()))) if self.outputs else 0


@dataclass(frozen=True, eq=False)
class Readings:
    """Recordings of one unit."""

    sweeps: tuple[Sweep, ...]  # Those of a run in order of time
    unit: str = "rad/s"  # Of the readings
    remarks: tuple[Remark, ...] = ()  # What reading them brought up

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one) for one in self.sweeps)

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read, in order."""
        return tuple(axis for axis in AXES if any(axis in one.outputs for one in self.sweeps))

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Labels of the runs, in the order of their first recording."""
        return tuple(dict.fromkeys(one.run for one in self.sweeps))

    @property
    def runs(self) -> int:
        """Number of distinct runs; 0 where none is given."""
        return len([label for label in self.labels if label])

    @property
    def where(self) -> str:
        """Place of the first recording, for messages."""
        return self.sweeps[0].place if self.sweeps else ""


def span_of(readings: Readings, axis: str) -> tuple[float, float]:
    """Return the lowest and highest temperature of an axis' sensor [degC]; NaN where there is none."""
    values = [one.temperature[axis] for one in readings.sweeps if axis in one.temperature]
    ends = np.array([extremes(one, infinite=False) for one in values if len(one)]).reshape(-1, 2)
    return float(np.fmin.reduce(ends[:, 0], initial=np.nan)), float(np.fmax.reduce(ends[:, 1], initial=np.nan))
