"""Compiled loops over the integrated signal: arrays in, preallocated arrays out, no checks.

Sums are of squared differences of the integrated signal ("phase") P, whose difference P[j + m] - P[j] is the sum of
the samples of one window. Where P holds int64, differences are exact, and only the squares are rounded.

Averaging factors go in rising order. All are taken over one block of starting points before the next: streams m apart
are then read from memory once and not once a factor. For long windows, blocks follow each other one window apart, not
side by side: where factors double, they share these blocks, and few of them are needed at a time. Two or four
factors that double share their streams even in registers. All cores take parts of the starting points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, reordered
from ..threads import LARGE, each_of

Whole = NDArray[np.int64]
BLOCK = 4096  # starting points: six streams of them lie in the nearest cache but one
NEAR = 32_768  # largest factor of blocks side by side: twice as many points lie in the nearest cache but one
RUN = 32  # samples that are summed from 0 on
PARTS = 8  # of the sums of a long record: the same whatever the number of cores


# The integrated signal


@compiled
def integrate(x: NDArray[Any], level: Any, phase: NDArray[Any]) -> None:
    """Fill ``phase``, one longer than ``x``, with the sums of all samples before each, less a level a sample.

    What rounding takes off the sum at the start of a run is carried to the next (Kahan), so that points far apart
    differ by what lies between them to the last digit of the larger.
    """
    base, carry = phase.dtype.type(0), phase.dtype.type(0)  # not phase[0] * 0: fresh memory may hold NaN
    phase[0] = base
    n = len(x)
    for start in range(0, n, RUN):
        total = phase.dtype.type(0)
        fours = (min(start + RUN, n) - start) // 4
        for k in range(fours):  # a sum waits for the one before it: four at a time wait once
            i = start + 4 * k
            a, b = x[i] - level, x[i + 2] - level
            ab, cd = a + (x[i + 1] - level), b + (x[i + 3] - level)
            phase[i + 1] = base + (total + a)
            phase[i + 2] = base + (total + ab)
            phase[i + 3] = base + (total + (ab + b))
            total += ab + cd
            phase[i + 4] = base + total
        for i in range(start + 4 * fours, min(start + RUN, n)):
            total += x[i] - level
            phase[i + 1] = base + total
        more = total + carry
        after = base + more
        carry = more - (after - base)
        base = after


@compiled
def integrate_present(
    x: NDArray[Any], present: NDArray[np.bool_], level: Any, phase: NDArray[Any], count: NDArray[np.int32]
) -> None:
    """Fill ``phase`` and ``count`` with the sums and numbers of the samples that are present."""
    total, carry, n = phase.dtype.type(0), phase.dtype.type(0), 0
    phase[0], count[0] = total, 0
    for i in range(len(x)):
        if present[i]:
            more = x[i] - level + carry
            after = total + more
            carry = more - (after - total)
            total = after
            n += 1
        phase[i + 1], count[i + 1] = total, n


@compiled
def largest_beside_line(p: NDArray[Any]) -> float:
    """Return the largest distance of P from the line through both of its ends."""
    n = len(p)
    slope = np.float64(p[n - 1] - p[0]) / max(1, n - 1)
    least, most = 0.0, 0.0
    for i in range(n):
        here = np.float64(p[i] - p[0]) - slope * i
        least, most = min(least, here), max(most, here)
    return max(most, -least)


@compiled
def sum_again(p: NDArray[Any], scale: float, sums: Whole) -> None:
    """Fill ``sums``, one longer, with the sums of P before each point, in whole numbers that may run over.

    Whole numbers lose nothing however far a sum runs: as long as a difference of sums fits into int64, it is right
    even where the sums themselves ran over. Where ``scale`` is not 0, P is multiplied with it and rounded down, less
    the line through both of its ends, which no third difference sees.
    """
    total, n = np.int64(0), len(p)
    sums[0] = total
    if scale == 0.0:
        for i in range(n):
            total += np.int64(p[i])
            sums[i + 1] = total
        return
    slope = np.float64(p[n - 1] - p[0]) / max(1, n - 1)
    for i in range(n):
        total += np.int64(np.floor((np.float64(p[i] - p[0]) - slope * i) * scale))
        sums[i + 1] = total


@reordered
def _total(x: Array) -> float:
    total = 0.0
    for i in range(len(x)):
        total += x[i]
    return total


@reordered
def _moment(x: Array) -> float:
    total = 0.0
    for i in range(len(x)):
        total += i * x[i]
    return total


@reordered
def _product(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@compiled
def lag_one(
    p: NDArray[Any], m: int, many: int, size: int, apart: int, lost: float, small: float, most: int
) -> tuple[float, int]:
    """Return the lag-1 autocorrelation of averages of m samples, and how often they were differenced to make it small.

    ``many`` stretches of ``size`` averages side by side, that begin ``apart`` points apart; a line is taken off, and
    what it took from the autocorrelation, ``lost``, given back.
    """
    y, level = np.empty((many, size)), 0.0
    for k in range(many):
        own = p[k * apart :]
        for i in range(size):
            y[k, i] = np.float64(own[(i + 1) * m] - own[i * m])
        level += _total(y[k])
    level /= many * size
    middle = 0.5 * ((many - 1) * apart + (size - 1) * m)  # of the times k apart + i m, and their squares about it
    square = many * size * (apart * apart * (many * many - 1.0) + m * m * (size * size - 1.0)) / 12.0
    along = 0.0
    for k in range(many):
        for i in range(size):
            y[k, i] -= level
        along += m * _moment(y[k]) + (k * apart - middle) * _total(y[k])
    along /= square
    for k in range(many):
        for i in range(size):
            y[k, i] -= along * (k * apart + i * m - middle)
    times = 0
    while True:
        squares, products = 0.0, 0.0
        for k in range(many):
            own = y[k, : size - times]
            squares += _product(own, own)
            products += _product(own[1:], own)
        r = products / squares + (lost if times == 0 else 0.0) if squares > 0.0 else np.nan
        if not r >= small or times >= most:
            return r, times
        times += 1
        for k in range(many):
            for i in range(size - times):
                y[k, i] = y[k, i + 1] - y[k, i]


@compiled
def integrate_all(x: NDArray[Any], step: int, phase: NDArray[np.float64]) -> None:
    """Fill ``phase`` as `integrate` does, less the mean of every so manieth sample."""
    total, many = 0.0, 0
    first = np.float64(x[0])
    for i in range(0, len(x), step):
        total += np.float64(x[i]) - first
        many += 1
    integrate(x, first + total / many, phase)


@compiled
def fill_exponents(
    p: NDArray[Any], factors: Whole, places: Whole, lost: Array, small: float, known: Array, out: Array
) -> None:
    """Fill the exponent of the noise that averages tell at each factor; NaN where ``places`` (k, 3) are none.

    ``places``, ``lost``: as `lag_one` takes them; ``known`` (k, times, exponents): autocorrelation of averages that are
    differenced so often, in noise of exponent 2, 1, ... -2 times.
    """
    for k in range(len(factors)):
        out[k] = np.nan
        if places[k, 0] > 0:
            r, times = lag_one(
                p, factors[k], places[k, 0], places[k, 1], places[k, 2], lost[k], small, known.shape[1] - 1
            )
            out[k] = _exponent(r, known[k, times, : 2 * times + 3])


@compiled
def fill_octaves(
    x: Array, step: int, factors: Whole, places: Whole, lost: Array, small: float, known: Array, phase: Array,
    sums: Array, out: Array,
) -> bool:  # fmt: skip
    """Fill sums of squared second differences and exponents of one short channel; return whether all is finite.

    ``phase``, one longer than ``x``, is room; the others are as `integrate_all` and `fill_exponents` take them.
    """
    integrate_all(x, step, phase)
    if not np.isfinite(phase[len(x)]):
        return False
    sums[:] = 0.0
    _add_part(phase, factors, 2, 0, 1, sums)
    fill_exponents(phase, factors, places, lost, small, known, out)
    return True


@compiled
def _exponent(r: float, steps: Array) -> float:
    """Return the exponent of noise whose averages have a lag-1 autocorrelation, between those of whole exponents."""
    if np.isnan(r):
        return r
    for i in range(len(steps)):
        if r < steps[i]:
            return 2.0 - i + (steps[i] - r) / (steps[i] - steps[i - 1]) if i > 0 else 2.0
    return 3.0 - len(steps)


# Sums of squares


@reordered
def _one_second(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any]) -> float:
    """Return the sum of squares of (c - b) - (b - a), of three streams of P that start m apart."""
    total = 0.0
    for i in range(len(c)):
        d = np.float64(a[i] - 2 * b[i] + c[i])
        total += d * d
    return total


@reordered
def _two_seconds(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], e: NDArray[Any]) -> tuple[float, float]:
    """Return the same for m and 2 m, of streams that start 0, 1, 2 and 4 m apart."""
    one, two = 0.0, 0.0
    for i in range(len(e)):
        d = np.float64(a[i] - 2 * b[i] + c[i])
        one += d * d
        d = np.float64(a[i] - 2 * c[i] + e[i])
        two += d * d
    return one, two


@reordered
def _four_seconds(
    a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], e: NDArray[Any], g: NDArray[Any], h: NDArray[Any]
) -> tuple[float, float, float, float]:
    """Return the same for m, 2 m, 4 m and 8 m, of streams that start 0, 1, 2, 4, 8 and 16 m apart."""
    one, two, three, four = 0.0, 0.0, 0.0, 0.0
    for i in range(len(h)):
        d = np.float64(a[i] - 2 * b[i] + c[i])
        one += d * d
        d = np.float64(a[i] - 2 * c[i] + e[i])
        two += d * d
        d = np.float64(a[i] - 2 * e[i] + g[i])
        three += d * d
        d = np.float64(a[i] - 2 * g[i] + h[i])
        four += d * d
    return one, two, three, four


@reordered
def _one_third(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], e: NDArray[Any]) -> float:
    """Return the sum of squares of third differences, of four streams that start m apart."""
    total = 0.0
    for i in range(len(e)):
        d = np.float64(e[i] - a[i] + 3 * (b[i] - c[i]))
        total += d * d
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
        doubling = _doubling(factors, k)
        many = 1
        if doubling >= 4 and e + 16 * m <= n:
            many = 4
            s, t, u, v = _four_seconds(
                p[start:e],
                p[start + m : e + m],
                p[start + 2 * m : e + 2 * m],
                p[start + 4 * m : e + 4 * m],
                p[start + 8 * m : e + 8 * m],
                p[start + 16 * m : e + 16 * m],
            )
            out[k] += s
            out[k + 1] += t
            out[k + 2] += u
            out[k + 3] += v
        elif doubling >= 2 and e + 4 * m <= n:
            many = 2
            s, t = _two_seconds(
                p[start:e], p[start + m : e + m], p[start + 2 * m : e + 2 * m], p[start + 4 * m : e + 4 * m]
            )
            out[k] += s
            out[k + 1] += t
        else:
            out[k] += _one_second(p[start:e], p[start + m : e + m], p[start + 2 * m : e + 2 * m])
        k += many


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
    for k in range(len(factors)):
        m = factors[k]
        e = min(stop, len(p) - 3 * m)
        if e <= start:
            break
        out[k] += _one_third(
            p[start:e], p[start + m : e + m], p[start + 2 * m : e + 2 * m], p[start + 3 * m : e + 3 * m]
        )


def sum_overlapping(p: NDArray[Any], factors: Whole, order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over all starting points."""
    if len(p) < LARGE:
        out[:] = 0.0
        _add_part(p, factors, order, 0, 1, out)
        return
    parts = PARTS

    def part_of(part: int) -> Array:
        found = np.zeros(len(factors))
        _add_part(p, factors, order, part, parts, found)
        return found

    out[:] = sum(each_of(part_of, range(parts), len(p)))


@compiled
def _add_part(p: NDArray[Any], factors: Whole, order: int, part: int, parts: int, out: Array) -> None:
    """Add one of so many parts of these sums."""
    near = np.searchsorted(factors, NEAR + 1)
    if near > 0:
        starts = len(p) - order * factors[0]
        stop = starts * (part + 1) // parts
        for start in range(starts * part // parts, stop, BLOCK):
            _add(p, start, min(start + BLOCK, stop), factors[:near], order, out[:near])
    if near < len(factors):
        step = factors[near]
        block = max(BLOCK // 16, min(BLOCK, 2 * NEAR * step // len(p)))
        end = step * (part + 1) // parts
        for first in range(step * part // parts, end, block):
            for start in range(first, len(p) - order * step, step):
                _add(p, start, start + min(block, end - first), factors[near:], order, out[near:])


@compiled
def _add(p: NDArray[Any], start: int, stop: int, factors: Whole, order: int, out: Array) -> None:
    if order == 2:
        _add_seconds(p, start, stop, factors, out)
    else:
        _add_thirds(p, start, stop, factors, out)


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
