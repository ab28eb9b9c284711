"""Compiled loops: arrays in, preallocated arrays out, no checks.

Sums are of squared differences of the integrated signal ("phase") P, whose difference P[j + m] - P[j] is the sum of
the samples of one window. Where P holds int64, differences are exact, and only the squares are rounded.

Averaging factors go in rising order. All are taken over one block of starting points before the next: streams m apart
are then read from memory once and not once a factor. For long windows, blocks follow each other one window apart, not
side by side: where factors double, they share these blocks, and few of them are needed at a time. Two or four
factors that double share their streams even in registers.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array

Whole = NDArray[np.int64]
BLOCK = 4096  # starting points: six streams of them lie in the nearest cache but one
NEAR = 32_768  # largest factor of blocks side by side: twice as many points lie in the nearest cache but one
SMALL = 512  # largest averaging factor whose modified deviation is summed over a block of its own
FILL = 2  # windows are used from 1 / FILL of their samples
LOOKED_AT = 2048  # averages that identify a noise type, to 0.02 in the lag-1 autocorrelation
STRETCH = 64  # neighbouring averages looked at together where there are more
STARTS = 4  # starting points that averages are taken from where there are few
LINE = 2.0  # by how much over their number a line lowers the lag-1 autocorrelation of white averages
SMALL_ENOUGH = 0.2  # lag-1 autocorrelation below which averages need no (further) difference
FEWEST = 30  # averages that identify a noise type (Riley and Greenhall)
LAGS = 32  # lags a window, of the autocorrelation behind the degrees of freedom ...
GRADE = 0.1  # ... and how much farther each from a whole window where it has logarithms there

compiled = numba.njit(cache=True, nogil=True, error_model="numpy")
summing = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


# The integrated signal


@compiled
def integrate(x: NDArray[Any], level: Any, phase: NDArray[Any]) -> None:
    """Fill ``phase``, one longer than ``x``, with the sums of all samples before each, less a level a sample."""
    total = phase[0] * 0
    phase[0] = total
    fours = len(x) // 4
    for k in range(fours):  # a sum waits for the one before it: four at a time wait once
        i = 4 * k
        a, b = x[i] - level, x[i + 2] - level
        ab, cd = a + (x[i + 1] - level), b + (x[i + 3] - level)
        phase[i + 1] = total + a
        phase[i + 2] = total + ab
        phase[i + 3] = total + (ab + b)
        total += ab + cd
        phase[i + 4] = total
    for i in range(4 * fours, len(x)):
        total += x[i] - level
        phase[i + 1] = total


@compiled
def integrate_present(
    x: NDArray[Any], present: NDArray[np.bool_], level: Any, phase: NDArray[Any], count: NDArray[np.int32]
) -> None:
    """Fill ``phase`` and ``count`` with the sums and numbers of the samples that are present."""
    total, n = phase[0] * 0, 0
    phase[0], count[0] = total, 0
    for i in range(len(x)):
        if present[i]:
            total += x[i] - level
            n += 1
        phase[i + 1], count[i + 1] = total, n


@compiled
def integrate_again(phase: NDArray[Any]) -> Any:
    """Replace each P by the sum of all before it; return the sum of all, which stands for the point after the last."""
    total = phase[0] * 0
    for i in range(len(phase)):
        here = phase[i]
        phase[i] = total
        total += here
    return total


# Sums of squares, complete records


@summing
def _second(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any]) -> float:
    total = 0.0
    for i in range(len(a)):
        d = np.float64(a[i] + c[i] - 2 * b[i])
        total += d * d
    return total


@summing
def _two_seconds(
    p0: NDArray[Any], p1: NDArray[Any], p2: NDArray[Any], p4: NDArray[Any]
) -> tuple[float, float]:
    s, t = 0.0, 0.0
    for i in range(len(p0)):
        d = np.float64(p0[i] + p2[i] - 2 * p1[i])
        s += d * d
        d = np.float64(p0[i] + p4[i] - 2 * p2[i])
        t += d * d
    return s, t


@summing
def _four_seconds(
    p0: NDArray[Any], p1: NDArray[Any], p2: NDArray[Any], p4: NDArray[Any], p8: NDArray[Any], p16: NDArray[Any]
) -> tuple[float, float, float, float]:
    s, t, u, v = 0.0, 0.0, 0.0, 0.0
    for i in range(len(p0)):
        d = np.float64(p0[i] + p2[i] - 2 * p1[i])
        s += d * d
        d = np.float64(p0[i] + p4[i] - 2 * p2[i])
        t += d * d
        d = np.float64(p0[i] + p8[i] - 2 * p4[i])
        u += d * d
        d = np.float64(p0[i] + p16[i] - 2 * p8[i])
        v += d * d
    return s, t, u, v


@summing
def _third(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], d: NDArray[Any]) -> float:
    total = 0.0
    for i in range(len(a)):
        e = np.float64(d[i] - a[i] + 3 * (b[i] - c[i]))
        total += e * e
    return total


@compiled
def _add_seconds(p: NDArray[Any], start: int, stop: int, factors: Whole, out: Array) -> None:
    """Add (P[j + 2m] - 2 P[j + m] + P[j])^2 for j from ``start`` to before ``stop``."""
    n = len(p)
    k = 0
    while k < len(factors):
        m = factors[k]
        e = min(stop, n - 2 * m)
        if e <= start:
            break
        p0, p1, p2 = p[start:e], p[start + m : e + m], p[start + 2 * m : e + 2 * m]
        doubling = _doubling(factors, k)
        if doubling >= 4 and e + 16 * m <= n:
            p4, p8, p16 = p[start + 4 * m : e + 4 * m], p[start + 8 * m : e + 8 * m], p[start + 16 * m : e + 16 * m]
            s, t, u, v = _four_seconds(p0, p1, p2, p4, p8, p16)
            out[k] += s
            out[k + 1] += t
            out[k + 2] += u
            out[k + 3] += v
            k += 4
        elif doubling >= 2 and e + 4 * m <= n:
            s, t = _two_seconds(p0, p1, p2, p[start + 4 * m : e + 4 * m])
            out[k] += s
            out[k + 1] += t
            k += 2
        else:
            out[k] += _second(p0, p1, p2)
            k += 1


@compiled
def _doubling(factors: Whole, k: int) -> int:
    """Return how many factors from the k-th on, up to 4, are each twice the one before."""
    many = 1
    while many < 4 and k + many < len(factors) and factors[k + many] == 2 * factors[k + many - 1]:
        many += 1
    return many


@compiled
def _add_thirds(p: NDArray[Any], start: int, stop: int, factors: Whole, out: Array) -> None:
    """Add (P[j + 3m] - 3 P[j + 2m] + 3 P[j + m] - P[j])^2 for j from ``start`` to before ``stop``."""
    n = len(p)
    for k in range(len(factors)):
        m = factors[k]
        e = min(stop, n - 3 * m)
        if e <= start:
            break
        out[k] += _third(p[start:e], p[start + m : e + m], p[start + 2 * m : e + 2 * m], p[start + 3 * m : e + 3 * m])


@compiled
def sum_overlapping(p: NDArray[Any], factors: Whole, order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over all starting points."""
    out[:] = 0.0
    near = np.searchsorted(factors, NEAR + 1)
    if near > 0:
        for start in range(0, len(p) - order * factors[0], BLOCK):
            _add(p, start, start + BLOCK, factors[:near], order, out[:near])
    if near < len(factors):
        step = factors[near]
        block = max(BLOCK // 16, min(BLOCK, 2 * NEAR * step // len(p)))
        for first in range(0, step, block):
            for start in range(first, len(p) - order * step, step):
                stop = start + min(block, step - first)
                _add(p, start, stop, factors[near:], order, out[near:])


@compiled
def _add(p: NDArray[Any], start: int, stop: int, factors: Whole, order: int, out: Array) -> None:
    if order == 2:
        _add_seconds(p, start, stop, factors, out)
    else:
        _add_thirds(p, start, stop, factors, out)


@compiled
def sum_local_thirds(p: NDArray[Any], factors: Whole, spare: NDArray[Any], out: Array) -> None:
    """Fill ``out`` with the sums of the squared third differences of the integral of P, from block to block anew.

    An integral over the whole record grows so large that it would have no digits left for short windows.
    """
    n = len(p)
    out[:] = 0.0
    if len(factors) == 0:
        return
    longest = factors[-1]
    for j in range(0, n + 1 - 3 * factors[0], BLOCK):
        size = min(BLOCK + 3 * longest, n + 1 - j)
        total = p[0] * 0
        for i in range(size - 1):
            spare[i] = total
            total += p[j + i] - p[j]
        spare[size - 1] = total
        for k in range(len(factors)):
            m = factors[k]
            e = min(BLOCK, n + 1 - 3 * m - j)
            if e <= 0:
                break
            out[k] += _third(spare[:e], spare[m : e + m], spare[2 * m : e + 2 * m], spare[3 * m : e + 3 * m])


@compiled
def sum_strides(p: NDArray[Any], factors: Whole, order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over windows that do not overlap."""
    n = len(p)
    for k in range(len(factors)):
        m = factors[k]
        total = 0.0
        for j in range(0, n - order * m, m):
            d = p[j + 2 * m] - 2 * p[j + m] + p[j]
            if order == 3:
                d = p[j + 3 * m] - 2 * p[j + 2 * m] + p[j + m] - d
            total += np.float64(d) * np.float64(d)
        out[k] = total


# Sums of squares, records with missing samples


@compiled
def _rate(p: NDArray[Any], count: NDArray[np.int32], j: int, m: int) -> tuple[float, float]:
    """Mean of a window, and the inverse of its number of samples; the latter is infinite where it is too empty."""
    n = count[j + m] - count[j]
    if n * FILL < m:
        return 0.0, np.inf
    return np.float64(p[j + m] - p[j]) / n, 1.0 / n


@compiled
def _windows(p: NDArray[Any], count: NDArray[np.int32], j: int, m: int, order: int) -> tuple[float, float]:
    """Difference of neighbouring windows in units of P, and how much white noise the missing samples add to it."""
    a, na = _rate(p, count, j, m)
    b, nb = _rate(p, count, j + m, m)
    if order == 2:
        return m * (b - a), m * (na + nb) / 2.0
    c, nc = _rate(p, count, j + 2 * m, m)
    return m * (c - 2.0 * b + a), m * (na + 4.0 * nb + nc) / 6.0


@compiled
def _points(p: NDArray[Any], count: NDArray[np.int32], j: int, m: int, order: int) -> tuple[float, float]:
    """Difference of points of an integrated signal, which are there or not."""
    for i in range(order + 1):
        if count[j + i * m + 1] == count[j + i * m]:
            return 0.0, np.inf
    d = np.float64(p[j + 2 * m] - 2 * p[j + m] + p[j])
    if order == 3:
        d = np.float64(p[j + 3 * m] - 2 * p[j + 2 * m] + p[j + m]) - d
    return d, 1.0


@compiled
def sum_present(
    p: NDArray[Any],
    count: NDArray[np.int32],
    pointwise: bool,
    factors: Whole,
    order: int,
    overlapping: bool,
    out: Array,
    terms: Whole,
    inflation: Array,
) -> None:
    """Fill sums of squares, the number of terms, and by how much missing samples raise the variance of white noise."""
    for k in range(len(factors)):
        m = factors[k]
        total, added, n = 0.0, 0.0, 0
        for j in range(0, len(p) - order * m, 1 if overlapping else m):
            d, more = _points(p, count, j, m, order) if pointwise else _windows(p, count, j, m, order)
            if more < np.inf:
                total += d * d
                added += more
                n += 1
        out[k], terms[k], inflation[k] = total, n, added / n if n > 0 else 1.0


@compiled
def sum_present_modified(
    p: NDArray[Any],
    count: NDArray[np.int32],
    pointwise: bool,
    factors: Whole,
    out: Array,
    terms: Whole,
    inflation: Array,
) -> None:
    """Fill the same for averages of m second differences, of which half must be there."""
    for k in range(len(factors)):
        m = factors[k]
        inside, more_inside, n_inside = 0.0, 0.0, 0
        total, added, n = 0.0, 0.0, 0
        for j in range(len(p) - 2 * m):
            d, more = _points(p, count, j, m, 2) if pointwise else _windows(p, count, j, m, 2)
            if more < np.inf:
                inside += d
                more_inside += more
                n_inside += 1
            if j >= m:
                d, more = _points(p, count, j - m, m, 2) if pointwise else _windows(p, count, j - m, m, 2)
                if more < np.inf:
                    inside -= d
                    more_inside -= more
                    n_inside -= 1
            if j >= m - 1 and n_inside > 0 and n_inside * FILL >= m:
                mean = m * inside / n_inside
                total += mean * mean
                added += more_inside / n_inside
                n += 1
        out[k], terms[k], inflation[k] = total, n, added / n if n > 0 else 1.0


# Noise type


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
                there, mean = True, np.float64(p[j + m] - p[j])
            elif pointwise:
                there = count[j + 1] > count[j] and count[j + m + 1] > count[j + m]
                mean = np.float64(p[j + m] - p[j])
            else:
                rate, inverse = _rate(p, count, j, m)
                there, mean = inverse < np.inf, m * rate
            if there:
                one[i], one_kept[i] = mean, 1.0
                found += 1
    return found


@summing
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


@summing
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
        here = _of_terms(1.0 * m, m, 2 - power, weights) / _of_terms(0.0, m, 2 - power, weights)
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


# Degrees of freedom


@compiled
def _digamma_half(k: float) -> float:
    """Digamma function of k + 1/2, k >= 0: recurrence up to 8, then its asymptotic series."""
    total = 0.0
    while k < 8.0:
        total -= 1.0 / (k + 0.5)
        k += 1.0
    q = 1.0 / (k * k)
    return total + math.log(k) + q * (1.0 / 24.0 - q * (7.0 / 960.0 - q * 31.0 / 8064.0))


@compiled
def _covariance(k: float, p: int) -> float:
    """Generalised autocovariance at lag k of noise with spectrum |2 sin(pi f)|^-p, but for a factor."""
    k = abs(k)
    if p == 0:
        return 1.0 if k == 0.0 else 0.0
    found = k if p % 2 == 0 else _digamma_half(k)
    shift = 0.0 if p % 2 == 0 else 0.5
    for i in range(1, (p - 1) // 2 + 1):
        found *= k * k - (i - shift) ** 2
    return found


@compiled
def _of_terms(lag: float, m: float, p: int, weights: Array) -> float:
    """Autocovariance of the terms at a lag, by the weights of the differences on both sides."""
    middle = len(weights) // 2
    total = 0.0
    for i in range(len(weights)):
        total += weights[i] * _covariance(lag + (i - middle) * m, p)
    return total


@compiled
def degrees_of_freedom(m: int, terms: float, stride: int, p: int, weights: Array, reach: int) -> float:
    """Return edf of the mean of squares of ``terms`` differences, ``stride`` samples apart.

    ``reach`` is how many windows apart differences still share noise. The sum over lags is a trapezoidal rule over
    1 / LAGS of a window, and finer beside whole windows where the autocovariance has logarithms there (p = 1).
    """
    at_0 = _of_terms(0.0, m, p, weights)
    length = terms * stride
    span = min(1.0 * reach * m, length)
    total, lag, before, gap = 0.0, 0.0, 1.0, 1.0 * m
    if p == 0:  # only whole windows share noise
        total = 0.5 * stride
        while lag + gap < span:
            lag += gap
            total += stride * (1.0 - lag / length) * (_of_terms(lag, m, p, weights) / at_0) ** 2
        return length / (2.0 * total)
    while lag < span:
        gap = max(1.0 * stride, m / LAGS)
        if p == 1:
            left = m - lag % m
            gap = max(1.0 * stride, min(left, math.floor(GRADE * min(lag % m, left))))
        lag += gap
        here = max(0.0, 1.0 - lag / length) * (_of_terms(lag, m, p, weights) / at_0) ** 2
        total += 0.5 * gap * (before + here)
        before = here
    return length / (2.0 * total)
