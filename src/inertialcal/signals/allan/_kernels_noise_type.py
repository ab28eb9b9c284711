"""Compiled loops that tell the noise type from averages: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered
from ._kernels_edf import covariance_of_terms
from ._kernels_missing import mean_of

Whole = NDArray[np.int64]
LOOKED_AT = 2048  # averages that identify a noise type, to 0.02 in the lag-1 autocorrelation
STRETCH = 64  # neighbouring averages looked at together where there are more
STARTS = 4  # starting points that averages are taken from where there are few
LINE = 2.0  # by how much over their number a line lowers the lag-1 autocorrelation of white averages
SMALL_ENOUGH = 0.2  # lag-1 autocorrelation below which averages need no (further) difference
FEWEST = 30  # averages that identify a noise type (Riley and Greenhall)


@compiled
def identify(p: NDArray[Any], count: NDArray[np.int32], pointwise: bool, factors: Whole, most: int, out: Array) -> None:
    """Fill ``out`` with the exponent of each averaging factor by the lag-1 autocorrelation; NaN for too few averages.

    ``count`` may be empty: nothing is missing. ``most`` is how often averages are differenced at most.
    """
    spare, spare_kept, spare_at = np.empty(2 * LOOKED_AT), np.empty(2 * LOOKED_AT), np.empty(2 * LOOKED_AT)
    for k in range(len(factors)):
        m = factors[k]
        stretches, size, apart = _stretches((len(p) - 1) // m, m)
        n = stretches * (size + 1)
        y, kept, at = spare[:n], spare_kept[:n], spare_at[:n]
        found = _take_averages(p, count, pointwise, m, size, apart, y, kept, at)
        out[k] = np.nan
        shared = stretches if apart < m else 1  # starting points that the same averages were taken from
        if found + shared > FEWEST * shared:
            _remove_line(y, kept, at)
            d, r = _autocorrelation(y, kept, most, LINE / ((len(p) - 1) // m))
            out[k] = _exponent(d, r, m)


@compiled
def _stretches(averages: int, m: int) -> tuple[int, int, int]:
    """Return number of stretches of averages to look at, averages in each, and samples from one to the next.

    Of few averages the same again from other starting points, one average less each.
    """
    if averages > LOOKED_AT:
        many = LOOKED_AT // STRETCH
        return many, STRETCH, (averages - STRETCH) // (many - 1) * m
    many = min(STARTS, m, LOOKED_AT // max(1, averages))
    return (many, averages - 1, m // many) if many > 1 else (1, averages, 0)


@compiled
def _take_averages(
    p: NDArray[Any],
    count: NDArray[np.int32],
    pointwise: bool,
    m: int,
    size: int,
    apart: int,
    y: Array,
    kept: Array,
    at: Array,
) -> int:
    """Fill averages side by side, 1 for each that is kept, and where it starts; return how many are kept.

    The first two are 0 after each stretch, and where too much misses.
    """
    y[:], kept[:], at[:] = 0.0, 0.0, 0.0
    found = 0
    for first in range(0, len(y), size + 1):
        start = first // (size + 1) * apart
        one, one_kept, one_at = y[first : first + size], kept[first : first + size], at[first : first + size]
        for i in range(size):
            j = start + i * m
            one_at[i] = j
            if len(count) == 0:
                there, mean = True, 1.0 * (p[j + m] - p[j])
            elif pointwise:
                there = count[j + 1] > count[j] and count[j + m + 1] > count[j + m]
                mean = 1.0 * (p[j + m] - p[j])
            else:
                rate, inverse = mean_of(p, count, j, m)
                there, mean = inverse < np.inf, m * rate
            if there:
                one[i], one_kept[i] = mean, 1.0
                found += 1
    return found


@reordered
def _remove_line(y: Array, kept: Array, at: Array) -> None:
    """Take mean and slope over time off the averages."""
    n, sum_t, sum_y = 0.0, 0.0, 0.0
    for i in range(len(y)):
        n += kept[i]
        sum_t += kept[i] * at[i]
        sum_y += y[i]
    mean_t, mean_y, tt, ty = sum_t / n, sum_y / n, 0.0, 0.0
    for i in range(len(y)):
        t = kept[i] * (at[i] - mean_t)
        tt += t * t
        ty += t * (y[i] - mean_y)
    slope = ty / tt
    for i in range(len(y)):
        y[i] -= kept[i] * (mean_y + slope * (at[i] - mean_t))


@reordered
def _autocorrelation(y: Array, kept: Array, most: int, lost: float) -> tuple[int, float]:
    """Return how often averages were differenced until their lag-1 autocorrelation was small, and that, or NaN.

    ``lost`` is what taking a line off took from the autocorrelation.
    """
    d = 0
    while True:
        c0, c1 = y[-1] * y[-1], 0.0
        for i in range(len(y) - 1):
            c0 += y[i] * y[i]
            c1 += y[i] * y[i + 1]
        r = c1 / c0 + (lost if d == 0 else 0.0) if c0 > 0.0 else np.nan
        if not r >= SMALL_ENOUGH or d >= most:
            return d, r
        for i in range(len(y) - 1):
            kept[i] *= kept[i + 1]
            y[i] = kept[i] * (y[i + 1] - y[i])
        y[-1], kept[-1] = 0.0, 0.0
        d += 1


@compiled
def _exponent(d: int, r: float, m: int) -> float:
    """Exponent between those whose averages, differenced d times, have an autocorrelation just below and above r."""
    weights = _weights(d + 1)
    reddest = -2 * d
    before = 0.0
    for power in range(2, reddest - 1, -1):
        here = covariance_of_terms(1.0 * m, m, 2 - power, weights) / covariance_of_terms(0.0, m, 2 - power, weights)
        if r < here or np.isnan(r):
            return power + (here - r) / (here - before) if power < 2 else 2.0 + 0.0 * r
        before = here
    return 1.0 * reddest


@compiled
def _weights(d: int) -> Array:
    """Weights of the autocovariance of d-fold differences: (-1)^i times the binomial coefficient 2d over d + i."""
    weights = np.ones(2 * d + 1)
    for i in range(1, 2 * d + 1):
        weights[i] = -weights[i - 1] * (2 * d + 1 - i) / i
    return weights if d % 2 == 0 else -weights
