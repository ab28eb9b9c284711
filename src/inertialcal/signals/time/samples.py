"""Samples: a signal on one clock, with what is known of each of its samples.

A signal is (n,) or (n, channels). A sample is good where every channel has a finite value and it is no
outlier. Gaps come from the time axis; without time, samples count as one interval apart.

Decimation for pictures: least and largest value per bin of time, so that every extreme survives.

Time is counted in sample intervals (the median step between stamps): each step is its nearest whole number of
intervals, one at least, so that jitter makes no gap and a slow clock none either. A bin holds the same number of
intervals as any other; one in which no sample lies is a gap and stays one. Where there are no more intervals than
bins, each sample stands alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, changed, empty, known_finite, made, near, zeros
from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND, Times
from .time_axis import AGAIN, TimeAxis, analyse, backward_steps

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

LONGEST_GAP = 10.0  # sample intervals: what happened in a longer gap nobody knows


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal with what is known of each sample, ready to be cut into dwells."""

    values: Array  # may hold NaN; column-major, so that a channel lies in one piece, shape (n, channels)
    finite: Flags  # whether every channel has a value, shape (n,)
    outlier: Flags  # samples to leave out, shape (n,)
    gap: Flags  # whether a gap lies between a sample and the one before it, shape (n,)
    time_ns: Times | None = None  # stamps [ns], shape (n,)
    sample_interval: float | None = None  # nominal time from sample to sample [s]

    @cached_property
    def ticks(self) -> Array:
        """Time since the first sample [sample intervals], shape (n,); the index where there is no time."""
        if self.time_ns is None or self.sample_interval is None:
            return made(len(self.values), np.float64, lambda first, stop: np.arange(first, stop, dtype=np.float64))
        start, interval = self.time_ns[0], self.sample_interval * SECOND
        return changed(self.time_ns, lambda part: (part - start) / interval)

    def duration(self, samples: int | None, seconds: float | None, default: int) -> int:
        """Return a length in samples from whichever of the two is given.

        Raises
        ------
        PlanError
            If both are given, or seconds where no sample interval is known.
        """
        if seconds is None:
            return default if samples is None else samples
        if samples is not None:
            raise PlanError(f"a length of {samples} samples and of {seconds:g} s given", do="Give one")
        if self.sample_interval is None:
            raise PlanError(
                f"a length of {seconds:g} s, but no sample interval",
                why="samples cannot be counted",
                do="Give sample_interval, time_ns, or a number of samples",
            )
        return max(1, round(seconds / self.sample_interval))


def samples_of(
    signal: Numbers,
    time_ns: Times | None = None,
    sample_interval: float | None = None,
    place: Callable[[int], str] = "sample {}".format,
) -> Samples:
    """Return a signal, (n,) or (n, channels), as Samples, its time looked through; ``place`` names one in messages.

    Raises
    ------
    DataError
        If the signal has another shape, or the time another length, or it runs backwards.
    """
    values = np.asfortranarray(signal, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(signal)}, need (n,) or (n, channels)")
    n = len(values)
    if sample_interval is not None and not sample_interval > 0.0:
        raise DataError(f"a sample interval of {sample_interval} s", do="It must be positive")
    gap = zeros(n, bool)
    if time_ns is not None:
        axis = _checked_axis(time_ns, n, place)
        gap[axis.gaps.after + 1] = True
        sample_interval = sample_interval or axis.interval
    return Samples(values, all_finite(values), zeros(n, bool), gap, time_ns, sample_interval)


def all_finite(values: Array) -> Flags:
    """Return where every channel has a value, shape (n,)."""
    if len(values) and all(known_finite(own) for own in values.T):
        return made(len(values), bool, lambda first, stop: np.ones(stop - first, bool))
    found = empty(len(values), bool)
    for first, stop in batches(found, values, size=near()):
        np.isfinite(values[first:stop, 0], out=found[first:stop])
        for own in values.T[1:]:
            found[first:stop] &= np.isfinite(own[first:stop])
    return found


def _checked_axis(time_ns: Times, n: int, place: Callable[[int], str]) -> TimeAxis:
    if time_ns.shape != (n,):
        raise DataError(f"{n} samples, time of shape {time_ns.shape}")
    axis = analyse(time_ns)
    if len(axis.backward):
        raise DataError(
            backward_steps(time_ns),
            where=place(int(axis.backward[0])),
            why="a stretch across it has no length",
            do=AGAIN,
            code="time_backwards",
        )
    return axis


@dataclass(frozen=True, eq=False)
class Bins:
    """A signal in bins of time."""

    # middle of the samples of each bin, since the first sample [s]; of a gap, between its neighbours, shape (b,)
    time: Array
    # lo, hi: least and largest finite value [unit of the signal]; NaN where there is none, shape (b, channels)
    lo: Array
    hi: Array


def min_max(signal: Numbers, time_ns: Times, bins: int = 600) -> Bins:
    """Return least and largest value of each channel per bin.

    Parameters
    ----------
    signal : ndarray, shape (n, channels)
        May hold NaN, which is left out.
    time_ns : ndarray of int64, shape (n,)
        Stamps, rising [ns].
    bins : int
        Most bins that may come out.

    Raises
    ------
    PlanError
        If ``bins`` is not positive.
    DataError
        If the shapes do not fit, there is no sample, or time runs backwards.
    """
    _check(signal, time_ns, bins)
    ticks = _ticks(time_ns)
    size = -(-(int(ticks[-1]) + 1) // bins)  # intervals in a bin, rounded up
    at = ticks // size
    starts = np.flatnonzero(np.diff(at, prepend=-1))
    filled = at[starts]
    lo = np.full((int(at[-1]) + 1, signal.shape[1]), np.nan)
    hi = lo.copy()
    for column in range(signal.shape[1]):  # one at a time: a recording may fill the memory
        values = np.array(signal[:, column], dtype=np.float64)
        values[~np.isfinite(values)] = np.nan
        lo[filled, column] = np.fmin.reduceat(values, starts)
        hi[filled, column] = np.fmax.reduceat(values, starts)
    stops = np.append(starts[1:], len(at)) - 1
    middle = 0.5 * ((time_ns[starts] - time_ns[0]) + (time_ns[stops] - time_ns[0])) / SECOND
    return Bins(np.interp(np.arange(len(lo)), filled, middle), lo, hi)


def _ticks(time_ns: Times) -> Times:
    """Time since the first sample in whole sample intervals, shape (n,); stamps that repeat count as one step."""
    steps = np.diff(time_ns)
    rising = steps[steps > 0]
    if not len(rising):
        return np.arange(len(time_ns), dtype=np.int64)
    whole = np.maximum(np.rint(steps / np.median(rising)), 1.0).astype(np.int64)
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(whole)])


def _check(signal: Numbers, time_ns: Times, bins: int) -> None:
    if bins < 1:
        raise PlanError(f"{bins} bins, need 1 or more")
    if np.ndim(signal) != 2 or time_ns.shape != (len(signal),):
        raise DataError(f"a signal of shape {np.shape(signal)} and time of shape {time_ns.shape}, need (n, channels)")
    if not len(time_ns):
        raise DataError("no samples to draw")
    if np.any(np.diff(time_ns) < 0):
        at = int(np.flatnonzero(np.diff(time_ns) < 0)[0])
        raise DataError(backward_steps(time_ns), f"sample {at + 1}", do=AGAIN, code="time_backwards")
