"""Decimation for pictures: least and largest value per bin of time, so that every extreme survives.

Time is counted in sample intervals (the median step between stamps): each step is its nearest whole number of
intervals, one at least, so that jitter makes no gap and a slow clock none either. A bin holds the same number of
intervals as any other; one in which no sample lies is a gap and stays one. Where there are no more intervals than
bins, each sample stands alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ...core.recording import SECOND, Times


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
        raise DataError("time runs backwards", f"sample {at}", do="Sort the record", code="time_backwards")
