"""Recordings of a survey, ready for the reduction: control and responses on one clock, without a missing sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...signals.time.time_axis import analyse
from ...signals.vibration.rails import rails_of
from ..protocol import Source
from .plan import CONTROL

CLIPPED = 20  # samples piled up at an end of the range
JITTER = 0.01  # of the interval, that stamps may scatter by


@dataclass(frozen=True, eq=False)
class Shaken:
    """One recording on the shaker."""

    name: str
    where: str
    rate: float  # Samples a second [Hz]
    controls: Mapping[str, Array]  # By role, shape (n,) [m/s^2]
    responses: Mapping[str, Array]  # By axis, shape (n,) [SI]
    unit: str  # Of the responses

    @property
    def control(self) -> Array:
        """Mean of the control channels."""
        return np.asarray(np.mean(list(self.controls.values()), axis=0))


@dataclass(frozen=True, eq=False)
class Readings:
    """Recordings of a survey."""

    shaken: tuple[Shaken, ...]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one.control) for one in self.shaken)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(self.shaken)


def readings_from(sources: Sequence[Source]) -> Readings:
    """Return the recordings of all sources.

    Raises
    ------
    DataError
        ``no_control``, ``gaps``, ``no_time``: if a recording cannot be one of a survey.
    """
    found, remarks = [], list[Remark]()
    for source in sources:
        for _, recording in source.recordings():
            remarks += list(recording.remarks)
            one = _shaken(source, recording)
            remarks += _clipped(one)
            found.append(one)
    return Readings(tuple(found), tuple(remarks))


def _shaken(source: Source, recording: Recording) -> Shaken:
    controls = {role: recording.channel(role) for role in CONTROL if role in recording.names}
    axes = [axis for axis in AXES if axis in recording.names]
    if not controls:
        what = f"recordings.{source.name}: no channel control"
        why = "a response is told from the drive by what the control accelerometer reads"
        raise DataError(what, source.file, why, "Say control = { column, unit }", "no_control")
    rate = recording.sample_rate
    if rate is None:
        raise DataError(f"recordings.{source.name}: no time of its samples", source.file,
                        do="Give the sample rate, or a time column", code="no_time")  # fmt: skip
    if recording.time_ns is not None and len(recording) > 2:
        time = analyse(recording.time_ns)
        if time.lost:
            after = int(time.gaps.after[0])
            what = f"recordings.{source.name}: {time.lost} sample(s) lost, the first after {after / rate:.4g} s"
            why = "a sweep has no second reading of that frequency, and all later samples are out of step"
            raise DataError(what, recording.place(after), why, "Repeat the sweep", "gaps")
        span = float(recording.time_ns[-1] - recording.time_ns[0]) / SECOND
        rate = (len(recording) - 1) / span if span > 0.0 else rate
    values = {**{role: one.data for role, one in controls.items()},
              **{axis: recording.channel(axis).data for axis in axes}}  # fmt: skip
    arrays = {name: np.asarray(data, dtype=np.float64) for name, data in values.items()}
    for name, data in arrays.items():
        bad = np.flatnonzero(~np.isfinite(data))
        if len(bad):
            what = f"recordings.{source.name}: {name}: {len(bad)} sample(s) missing"
            why = "a sweep has no second reading of that frequency"
            raise DataError(what, recording.place(int(bad[0])), why, "Repeat the sweep", "gaps")
    responses = {axis: arrays[axis] for axis in axes}
    return Shaken(source.name, source.file, rate, {role: arrays[role] for role in controls}, responses,
                  source.facts.si)  # fmt: skip


def _clipped(one: Shaken) -> list[Remark]:
    """Return remarks on channels that stay at the end of their range."""
    found = []
    for name, values in {**one.controls, **one.responses}.items():
        ends = rails_of(values)
        if ends.samples >= CLIPPED:
            what = f"recording {one.name}: {name} stays at {ends.value:.4g}, {ends.samples} samples"
            do = "Use a wider range: a clipped channel shows less of the motion, and harmonics that are not there"
            found.append(Remark("saturated", "error", what, one.where, do=do, axis=name if name in AXES else "",
                                subject=name, recording=one.name))  # fmt: skip
    return found
