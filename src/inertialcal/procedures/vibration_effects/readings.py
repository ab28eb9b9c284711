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
from ...signals.allan import on_grid
from ...signals.vibration.levels import mean_squares

CONTROL, CONTROL_RMS = "control", "control_rms"
FEWEST = 200  # samples of a record
GAP, MOST_PLACES = 1.9, 2.0  # intervals between samples that are a gap; places of a record for each sample
HALF = 0.5  # of the control, that must be there


@dataclass(frozen=True, eq=False)
class Vibrated:
    """One run: readings by axis, shape (n,) [SI]; NaN where a sample is missing."""

    axes: Mapping[str, Array]
    # Acceleration, or where ``rms`` its root mean square as a controller logs it; NaN where missing [m/s^2]
    control: Array
    interval: float  # [s]
    rms: bool = False
    direction: str = ""  # Body axis that was vibrated along; empty where not known
    name: str = ""
    file: str = ""
    cut_off: float | None = None  # Of the sensor's low pass [Hz]
    power_up: str = ""
    unit: str = "rad/s"  # Of the axes, SI


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
    recording: Recording, name: str, file: str, direction: str, cut_off: float | None, power_up: str,
    unit: str = "rad/s",
) -> Vibrated:  # fmt: skip
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
    axes_of = [axis for axis in AXES if axis in recording.names]
    values = np.asarray(recording.array([names[0], *axes_of]), dtype=float)
    if len(values) < FEWEST:
        what = f"recordings.{name}: {len(values)} samples, need {FEWEST}"
        raise DataError(what, file, do="Record longer", code="too_short")
    stamps = recording.time_ns
    if stamps is not None and len(stamps) > 2 and float(np.max(np.diff(stamps))) * 1e-9 > GAP * interval:
        places = round(float(stamps[-1] - stamps[0]) * 1e-9 / interval) + 1
        if places > MOST_PLACES * len(values):
            longest = number(float(np.max(np.diff(stamps))) * 1e-9, 4)
            what = f"recordings.{name}: a gap of {longest} s: more is missing than was recorded"
            do = "Make the parts before and after the gap two files, each with rest before and after its vibration"
            raise DataError(what, file, "bias and drift are not known across it", do, "gaps")
        placed, present = on_grid(values, stamps, interval)
        values = np.asarray(placed, dtype=float)
        values[~present] = np.nan
    control = values[:, 0]
    if np.count_nonzero(np.isfinite(control)) < max(FEWEST, HALF * len(control)):
        what = f"recordings.{name}: {int(np.count_nonzero(~np.isfinite(control)))} of {len(control)} samples of the "
        what += "control are missing"
        do = "Check the column of the control; it needs half of its samples at least"
        raise DataError(what, file, "how strong the vibration was is not known there", do, "gaps")
    axes = {axis: values[:, i + 1] for i, axis in enumerate(axes_of)}
    return Vibrated(axes, control, interval, names[0] == CONTROL_RMS, direction, name, file, cut_off, power_up, unit)


def block_means(values: Array, size: int) -> Array:
    """Return the means of blocks of ``size`` samples; NaN of those that have less than half of their samples."""
    parts = values[: len(values) // size * size].reshape(-1, size)
    there = np.isfinite(parts)
    count = there.sum(axis=1)
    total = np.where(there, parts, 0.0).sum(axis=1)
    return np.asarray(np.where(count >= HALF * size, total / np.maximum(count, 1), np.nan))


def block_squares(control: Array, size: int, rms: bool) -> Array:
    """Return the mean squares of a control by block: about the mean, its own bias at rest; of a logged level none."""
    return block_means(control**2, size) if rms else mean_squares(control, size)
