"""What drives the sensor, at the times of its samples: a sine of known period, or any applied sequence.

The drive of known period is ``sin(2 pi f (t - t_0) + phase)``, t_0 the first sample, of amplitude 1; in quadrature to
it is ``cos(...)``, a quarter of a period ahead. With an applied sequence (a mass that steps between positions, a table
that turns to and fro) the drive is the applied value of each sample less the middle of its range, in its own unit, and
the line found is reading over applied; it has a quadrature where it is itself a sine of the period, as the order
middle, near, middle, far is.

At half of the sampling frequency a line has one component only: its quadrature is zero at every sample.

Averaging. A sample that is the mean over a time ``a`` of a drive that goes on as a sine shows ``sin(pi f a) / (pi f
a)`` of it; of a drive that stands still during each sample it shows all.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...core.batches.summaries import median
from ...core.errors import DataError
from ...core.estimate import Array

SINE = 0.999  # part of the variance of an applied sequence from which it is a sine itself
NOTHING = 1e-6  # of its largest possible value, below which a component is zero at every sample


@dataclass(frozen=True, eq=False)
class Drive:
    """Drive at the times of the samples."""

    times: Array  # middle of each sample, ascending [s], shape (n,)
    in_phase: Array  # of unit amplitude, or in the unit that is applied, shape (n,)
    quadrature: Array | None  # a quarter of a period ahead, where the samples show it, shape (n,)
    frequency: float  # lowest of the drive [Hz]
    phase_known: bool  # whether the sign of what is in phase means anything

    @cached_property
    def apart(self) -> Array:
        """Time from sample to sample [s], shape (n - 1,)."""
        return np.diff(self.times)

    @cached_property
    def step(self) -> float:
        """Median time from sample to sample [s]."""
        return median(self.apart)

    @property
    def span(self) -> float:
        """Length of the record, the last sample included [s]."""
        return float(self.times[-1] - self.times[0]) + self.step

    @property
    def cycles(self) -> float:
        """Periods in the record."""
        return self.span * self.frequency


def sine_drive(times: ArrayLike, frequency: float, phase: float | None = None) -> Drive:
    """Return a sine of known period.

    Parameters
    ----------
    times : array_like, shape (n,)
        Middle of each sample, pauses between samples included [s].
    frequency : float
        Of the drive [Hz].
    phase : float, optional
        At the first sample [rad]; free if not said.

    Raises
    ------
    DataError
        ``nyquist``: the frequency is above half of the sampling frequency, or at it without a phase, or with one at
        which every sample falls on a zero.
    """
    t = _ascending(times)
    if not (np.isfinite(frequency) and frequency > 0.0):
        raise DataError(f"a drive of {frequency} Hz", do="Its period must be positive", code="bad_period")
    turns = (t - t[0]) * frequency
    angle = 2.0 * np.pi * (turns - np.floor(turns)) + (phase or 0.0)
    drive = Drive(t, np.sin(angle), np.cos(angle), frequency, phase is not None)
    return _visible_components(drive)


def applied_drive(times: ArrayLike, applied: ArrayLike, frequency: float) -> Drive:
    """Return an applied sequence as a drive.

    Parameters
    ----------
    times : array_like, shape (n,)
        Middle of each sample, pauses between samples included [s].
    applied : array_like, shape (n,)
        True input during each sample.
    frequency : float
        Lowest of the sequence [Hz].

    Raises
    ------
    DataError
        ``different_length``; ``no_drive`` if nothing varies or a value is missing; ``nyquist`` as `sine_drive`.
    """
    t, values = _ascending(times), np.asarray(applied, dtype=np.float64)
    if values.shape != t.shape:
        what = f"{len(t)} samples, {len(values)} applied values"
        do = "Give the schedule of this record, one row per sample"
        raise DataError(what, why="samples cannot be matched to applied values", do=do, code="different_length")
    centred = values - 0.5 * (values.max() + values.min())
    if not np.all(np.isfinite(values)) or not np.ptp(values) > NOTHING * np.abs(values).max(initial=0.0):
        what = "the applied sequence does not vary, or has a value missing"
        raise DataError(what, do="Give the applied input of every sample", code="no_drive")
    unit = sine_drive(t, frequency, 0.25 * np.pi)
    if unit.quadrature is None:
        return Drive(t, centred, None, frequency, phase_known=True)
    basis = np.column_stack([unit.in_phase, unit.quadrature, np.ones(len(t))])
    a, b, level = np.linalg.lstsq(basis, centred, rcond=None)[0]
    rest = centred - basis @ np.array([a, b, level])
    is_sine = float(np.var(rest)) < (1.0 - SINE) * float(np.var(centred))
    quadrature = a * unit.quadrature - b * unit.in_phase if is_sine else None
    if quadrature is not None and np.abs(quadrature).max() < NOTHING * np.abs(centred).max():
        quadrature = None  # two samples a period, some of them missing
    return Drive(t, centred, quadrature, frequency, phase_known=True)


def averaging_response(frequency: float, averaging: float) -> float:
    """Return what samples that are means over a time show of a sine, 0 to 1 of its amplitude.

    Parameters
    ----------
    frequency : float
        Of the sine, which goes on during each sample [Hz].
    averaging : float
        Time that each sample is the mean of [s].

    Raises
    ------
    DataError
        ``averaged_out`` if it is a whole number of periods.
    """
    part = float(np.sinc(frequency * averaging))
    if not abs(part) > NOTHING:
        what = f"samples of {averaging:.6g} s, a period of {1.0 / frequency:.6g} s"
        raise DataError(what, why="averaging removes it", code="averaged_out")
    return part


def _ascending(times: ArrayLike) -> Array:
    t = np.asarray(times, dtype=np.float64)
    if t.ndim != 1 or len(t) < 2 or not np.isfinite(t[[0, -1]]).all() or not np.all(t[1:] > t[:-1]):
        raise DataError(f"times of shape {t.shape}", do="Need two or more, finite and ascending [s]", code="bad_time")
    return t


def _visible_components(drive: Drive) -> Drive:
    """Return the drive without the quadrature where no sample shows it; refuse what samples cannot tell."""
    turn = drive.frequency * drive.step
    even = np.ptp(drive.apart) < 1e-3 * drive.step
    half_line = 0.5 / len(drive.times)
    if even and turn > 0.5 + half_line:
        what = f"a period of {1.0 / drive.frequency:.6g} s, samples every {drive.step:.6g} s"
        why = "the drive is above half the sampling frequency and would alias"
        raise DataError(what, why=why, do="Sample at least twice a period", code="nyquist")
    if not even or turn < 0.5 - half_line:
        return drive
    if not drive.phase_known or np.abs(drive.in_phase).max() < NOTHING:
        what = f"two samples a period of {1.0 / drive.frequency:.6g} s"
        why = "each falls on a zero" if drive.phase_known else "amplitude and phase cannot be separated"
        raise DataError(what, why=why, do="Give the schedule, or the phase: 90 deg if samples fall on the extremes",
                        code="nyquist")  # fmt: skip
    return Drive(drive.times, drive.in_phase, None, drive.frequency, phase_known=True)
