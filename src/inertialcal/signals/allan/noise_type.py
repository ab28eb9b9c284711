"""The noise type from averages, by their lag-1 autocorrelation: arrays in, exponents out (see ``edf``).

A few thousand averages at each factor, however long the record: numpy takes less than a compiler to start.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Numbers
from ..time.samples import Flags
from .lags import neighbours
from .prefix import Phase

LOOKED_AT = 2048  # averages that identify a noise type, to 0.02 in the lag-1 autocorrelation
STRETCH = 64  # neighbouring averages looked at together where there are more
STARTS = 4  # starting points that averages are taken from where there are few
LINE = 2.0  # by how much over their number a line lowers the lag-1 autocorrelation of white averages
SMALL_ENOUGH = 0.2  # lag-1 autocorrelation below which averages need no (further) difference
FEWEST = 30  # averages that identify a noise type (Riley and Greenhall)
FILL = 2  # windows are used from 1 / FILL of their samples


def exponents(phase: Phase, factors: NDArray[np.int64], most: int) -> Array:
    """Return the exponent at each averaging factor, shape (k,); NaN for too few averages.

    ``most`` is how often averages are differenced at most.
    """
    out = np.full(len(factors), np.nan)
    for k, m in enumerate(factors.tolist()):
        averages = (len(phase.values) - 1) // m
        stretches, size, apart = _stretches(averages, m)
        at = np.arange(stretches)[:, None] * apart + np.arange(size) * m
        mean, there = _averages(phase, m, at)
        shared = stretches if apart < m else 1  # starting points that the same averages were taken from
        if np.count_nonzero(there) + shared > FEWEST * shared:
            y = _without_line(mean, there, at)
            out[k] = _exponent(*_autocorrelation(y, there, most, LINE / averages), m)
    return out


def _stretches(averages: int, m: int) -> tuple[int, int, int]:
    """Return number of stretches of averages to look at, averages in each, and samples from one to the next.

    Of few averages the same again from other starting points, one average less each.
    """
    if averages > LOOKED_AT:
        many = LOOKED_AT // STRETCH
        return many, STRETCH, (averages - STRETCH) // (many - 1) * m
    many = min(STARTS, m, LOOKED_AT // max(1, averages))
    return (many, averages - 1, m // many) if many > 1 else (1, averages, 0)


def _averages(phase: Phase, m: int, at: NDArray[np.int64]) -> tuple[Array, Flags]:
    """Return sums of m samples from each place on, raised where some are missing, and which are kept."""
    p, count = phase.values, phase.count
    rise: Numbers = p[at + m] - p[at]
    if phase.complete:
        return rise.astype(np.float64), np.ones(at.shape, dtype=bool)
    if phase.pointwise:
        return rise.astype(np.float64), (count[at + 1] > count[at]) & (count[at + m + 1] > count[at + m])
    held = count[at + m] - count[at]
    return m * (rise / np.maximum(held, 1)), held * FILL >= m


def _without_line(mean: Array, there: Flags, at: NDArray[np.int64]) -> Array:
    """Return the averages less their mean and slope over time; 0 where none is kept, and after each stretch."""
    y, t = np.zeros((len(mean), mean.shape[1] + 1)), at[there].astype(np.float64)
    kept = mean[there]
    t -= t.mean()
    kept -= kept.mean()
    y[:, :-1][there] = kept - (t @ kept) / (t @ t) * t
    return y.ravel()


def _autocorrelation(y: Array, there: Flags, most: int, lost: float) -> tuple[int, float]:
    """Return how often averages were differenced until their lag-1 autocorrelation was small, and that, or NaN.

    ``lost`` is what taking a line off took from the autocorrelation.
    """
    kept = np.column_stack([there, np.zeros(len(there), dtype=bool)]).ravel()
    d = 0
    while True:
        c0 = float(y @ y)
        r = float(y[:-1] @ y[1:]) / c0 + (lost if d == 0 else 0.0) if c0 > 0.0 else np.nan
        if not r >= SMALL_ENOUGH or d >= most:
            return d, r
        kept = np.append(kept[:-1] & kept[1:], False)
        y = np.append(np.where(kept[:-1], np.diff(y), 0.0), 0.0)
        d += 1


def _exponent(d: int, r: float, m: int) -> float:
    """Exponent between those whose averages, differenced d times, have an autocorrelation just below and above r."""
    reddest, before = -2 * d, 0.0
    for power in range(2, reddest - 1, -1):
        here = neighbours(m, power, d)
        if r < here or np.isnan(r):
            return power + (here - r) / (here - before) if power < 2 else 2.0 + 0.0 * r
        before = here
    return float(reddest)
