"""Readings of one channel with a known drive: times, values and drive of the present samples."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...physics.motion.schedule import Schedule
from ...signals.sine.drive import Drive, applied_drive, averaging_response, sine_drive
from ...signals.sine.fit import LineFit, design_of, fit_line

LONGEST = 1.01  # averaging over interval or period, from which it cannot be
HALF = 0.5  # of the samples, that may be missing
SEEN = 1e-3  # of an amplitude, from which averaging is remarked
WHOLE = 0.01  # of a period, by which a record may differ from whole cycles


@dataclass(frozen=True, eq=False)
class Driven:
    """One channel under a known drive."""

    channel: Channel  # As read
    drive: Drive  # At the present samples, in units of its amplitude
    readings: Array  # shape (n,): finite [unit of the channel]
    response: float = 1.0  # Part of the drive in the samples, which are means over a time
    applied: float | None = None  # Amplitude applied by a schedule [m/s^2]
    u_applied: float | None = None  # Its relative standard uncertainty
    loss: float = 0.0  # Part of the drive that the samples lack if they are means over their interval; 0 where known
    remarks: tuple[Remark, ...] = ()  # On gaps and cycles
    name: str = ""  # Of the recording
    where: str = ""  # Its file

    @cached_property
    def fit(self) -> LineFit:
        """Drive found in the readings, as ``signals.sine.fit`` finds it and refuses; taken once."""
        return fit_line(design_of(self.drive), self.readings)

    @property
    def unit(self) -> str:
        """Of the readings; empty where not known."""
        return self.channel.unit or ""


def driven_by_sine(recording: Recording, channel: Channel, period: float, phase: float | None) -> Driven:
    """Return a channel under a sine of known period [s], its samples at their own times.

    ``phase`` is that at the first sample of the record [rad]; None where it is free.

    Raises
    ------
    DataError
        ``no_time``, ``gaps`` if more than half is missing, ``bad_period``; as ``signals.sine.sine_drive``.
    """
    if not (np.isfinite(period) and period > 0.0):
        raise DataError(f"a period of {period:g} s", do="It must be positive", code="bad_period")
    times, there, remarks = _present(recording, channel)
    late = 2.0 * np.pi * float(times[there][0] - times[0]) / period
    drive = sine_drive(times[there], 1.0 / period, None if phase is None else phase + late)
    averaging = recording.averaging_time
    longest = min(drive.step, period)
    if averaging is not None and averaging > LONGEST * longest:
        what = f"averaging over {number(averaging, 6)} s, samples every {number(drive.step, 6)} s,"
        what += f" a period of {number(period, 6)} s"
        do = "A sample is the mean of less than its interval, and shows the drive if that is less than a period"
        raise DataError(what, recording.source.path, do=do, code="averaging_time")
    response = 1.0 if averaging is None else averaging_response(1.0 / period, averaging)
    remarks += _cycles(drive)
    loss = 0.0
    if averaging is None:
        loss = 1.0 - abs(averaging_response(drive.frequency, min(drive.step, 0.5 / drive.frequency)))
    elif response < 1.0 - SEEN:
        share, window = number(100.0 * (1.0 - response), 3), number(averaging, 4)
        what = f"samples are means over {window} s: they show {share} % less of the drive, which is corrected"
        remarks.append(Remark("averaging", "info", what))
    return Driven(channel, drive, _values(channel)[there], response, loss=loss, remarks=tuple(remarks))


def driven_by_schedule(recording: Recording, channel: Channel, schedule: Schedule, path: str | Path) -> Driven:
    """Return the means of a channel over the dwells of a schedule, read from ``path``, that begins with the record.

    Raises
    ------
    DataError
        ``different_length`` if schedule and record do not end together within a dwell and a move; ``gaps`` if more than
        half of the dwells have no reading; as ``signals.sine.applied_drive``.
    """
    times, there, _ = _present(recording, channel)
    step = float(np.median(np.diff(times)))
    own = times - times[0] + schedule.start[0] + 0.5 * min(step, schedule.dwell)  # middle of each sample, its clock
    end = float(own[-1] + 0.5 * min(step, schedule.dwell))
    if abs(end - float(schedule.stop[-1])) > schedule.step:
        what = f"the schedule {path} has {len(schedule)} dwells over {schedule.stop[-1] - schedule.start[0]:.6g} s,"
        what += f" the record lasts {end - schedule.start[0]:.6g} s"
        do = "Give the schedule of this record, or cut the record: --from, --to"
        raise DataError(what, recording.source.path, "they are not of one run", do, "different_length")
    dwell = np.searchsorted(schedule.start, own, side="right") - 1
    inside = there & (own < schedule.stop[dwell] + 1e-9 * step)
    counts = np.bincount(dwell[inside], minlength=len(schedule))
    sums = np.bincount(dwell[inside], _values(channel)[inside], minlength=len(schedule))
    taken = np.bincount(dwell[own < schedule.stop[dwell] + 1e-9 * step], minlength=len(schedule))
    read = counts >= np.maximum(HALF * taken, 1.0)
    remarks = [] if read.all() else [_missing(int(np.count_nonzero(~read)), len(read), "dwells")]
    middle = 0.5 * (schedule.applied.max() + schedule.applied.min())
    shape = (schedule.applied - middle) / schedule.amplitude
    drive = applied_drive(schedule.middle[read], shape[read], schedule.frequency)
    return Driven(channel, drive, sums[read] / counts[read], 1.0, schedule.amplitude, schedule.u_applied,
                  remarks=(*remarks, *_cycles(drive)))  # fmt: skip


def _values(channel: Channel) -> Array:
    return np.asarray(channel.data, dtype=np.float64)


def _present(recording: Recording, channel: Channel) -> tuple[Array, NDArray[np.bool_], list[Remark]]:
    """Return the times of all samples, which have a reading, and what is to be said of those that have none."""
    where = recording.source.path
    if channel.data.dtype.kind not in "iufb":
        raise DataError(f"column {channel.name!r} holds no numbers", where=where, code="wrong_column")
    times, there = recording.seconds, np.isfinite(_values(channel))
    if times is None and recording.sample_interval is not None:
        times = np.arange(len(recording), dtype=np.float64) * float(recording.sample_interval)
    if times is None or len(times) < 2:
        do = "Give the sample rate: --sample-rate, or a time column: --time-column"
        raise DataError("the file has no time", where=where, why="a period needs one", do=do, code="no_time")
    gone = int(np.count_nonzero(~there))
    if gone > HALF * len(there):
        what = f"{gone} of {len(there)} samples of {channel.name!r} are missing"
        why = "with so many gaps drift and drive cannot be separated"
        raise DataError(what, where=where, why=why, do="Record again", code="gaps")
    return times, there, [_missing(gone, len(there), "samples")] if gone else []


def _missing(gone: int, n: int, of: str) -> Remark:
    what = f"{gone} of {n} {of} have no reading: they are left out, the others keep their times"
    return Remark("gaps", "info", what, count=gone)


def _cycles(drive: Drive) -> list[Remark]:
    left = abs(drive.cycles - round(drive.cycles))
    if left <= WHOLE:
        return []
    what = f"the record has {number(drive.cycles, 5)} cycles, not a whole number: the fit does not need one"
    return [Remark("whole_cycles", "info", what, do="Fourier lines and moving means of this record would mix")]
