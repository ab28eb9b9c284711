"""Readings of a sensor on a shaker, and the acceleration of the control: on one clock, a recording a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.show.rounding import number

CONTROL, CONTROL_RMS = "control", "control_rms"
FEWEST = 200  # samples of a record
EXTREME, PILED = 8, 2.0  # samples at the end of a range, and how many times those next to it: clipped
NEXT = 0.1  # standard deviations that count as next to it


@dataclass(frozen=True, eq=False)
class Vibrated:
    """One run: readings by axis, shape (n,) [SI]; NaN where a sample is missing."""

    axes: Mapping[str, Array]
    control: Array  # Acceleration, or where ``rms`` its root mean square as a controller logs it [m/s^2]
    interval: float  # [s]
    rms: bool = False
    direction: str = ""  # Body axis that was vibrated along; empty where not known
    name: str = ""
    file: str = ""
    cut_off: float | None = None  # Of the sensor's low pass [Hz]
    power_up: str = ""


@dataclass(frozen=True, eq=False)
class Readings:
    """All runs of a test."""

    runs_of: tuple[Vibrated, ...]
    unit: str  # Of the axes, SI
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one.control) for one in self.runs_of)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(self.runs_of)


def vibrated(
    recording: Recording, name: str, file: str, direction: str, cut_off: float | None, power_up: str
) -> Vibrated:
    """Return one run.

    Raises
    ------
    DataError
        ``no_control``, ``no_time``, ``too_short``, ``gaps``.
    """
    names = [one for one in (CONTROL, CONTROL_RMS) if one in recording.names]
    if len(names) != 1:
        what = f"recordings.{name}: {'both control and control_rms' if names else 'no acceleration of the control'}"
        why = "nothing else says how strong the vibration was"
        do = 'Give one channel: control = { column = "COLUMN", unit = "g" }, or control_rms for a logged level'
        raise DataError(what, file, why, do, "no_control")
    interval = recording.sample_interval
    if interval is None or not interval > 0.0:
        do = "Give the sample rate: --sample-rate, or a time column: --time-column"
        raise DataError(f"recordings.{name}: no sample interval", file, "spectra need one", do, "no_time")
    axes = {axis: np.asarray(recording.channel(axis).data, dtype=float) for axis in AXES if axis in recording.names}
    control = np.asarray(recording.channel(names[0]).data, dtype=float)
    if len(control) < FEWEST:
        what = f"recordings.{name}: {len(control)} samples, need {FEWEST}"
        raise DataError(what, file, do="Record longer", code="too_short")
    missing = int(np.count_nonzero(~np.isfinite(control)))
    if missing:
        what = f"recordings.{name}: {missing} samples of the control are missing"
        why = "its level is not known there"
        do = "Record the control whole, or cut that out: windows of the test"
        raise DataError(what, file, why, do, "gaps")
    stamps = recording.time_ns
    if stamps is not None and len(stamps) > 2:
        steps = np.diff(stamps) * 1e-9
        longest = float(np.max(steps))
        if longest > 1.9 * float(np.median(steps)):
            what = f"recordings.{name}: a gap of {number(longest, 4)} s"
            why = "lines of a spectrum need even samples"
            raise DataError(what, file, why, "Record again, or cut the gap out: windows of the test", "gaps")
    return Vibrated(axes, control, interval, names[0] == CONTROL_RMS, direction, name, file, cut_off, power_up)


def clipped(values: Array) -> int:
    """Return how many samples stand at the ends of a range: many more than next to it; 0 where none seem to."""
    x = values[np.isfinite(values)]
    if len(x) < EXTREME:
        return 0
    sd, steps = float(np.std(x)), np.diff(np.unique(x))
    width = max(NEXT * sd, 1.5 * float(np.min(steps, initial=np.inf))) if len(steps) else 0.0
    found = 0
    for end, sign in ((float(np.max(x)), 1.0), (float(np.min(x)), -1.0)):
        at = int(np.count_nonzero(x == end))
        near = int(np.count_nonzero((sign * (end - x) > 0.0) & (sign * (end - x) <= width)))
        found += at if at >= EXTREME and at > PILED * near and abs(end - float(np.mean(x))) > sd else 0
    return found
