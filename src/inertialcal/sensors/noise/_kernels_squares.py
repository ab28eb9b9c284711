"""Compiled covariance of Allan variances: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import GROWTH, NEAR, Indices, panel

BRIEF = 0.05  # lag in correlation times below which an exponential less its first terms is summed as a series
GONE = 40.0  # the same from which nothing is left of it beside the other terms, to the last bit
MOST_GROWN = 690.0  # the same up to which exponentials of a sum are products
FAR = 100  # most lags beyond the last kink: three of each length, which grow eightfold
ONE_OVER_LN_2 = 1.44269504088896338700e00
LN_2 = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # high and low part
SERIES = tuple(1.0 / math.factorial(order) for order in range(3, 14))

# Pair, distance and both averaging times of each lag, second differences there of the lag and of 1 at zero, how many
# windows lie so far apart, and what missing samples multiply the linear part by
Lags = tuple[Indices, Array, Array, Array, Array, Array, Array, Array]
Pairs = tuple[Array, Array, Indices, Indices]  # Averaging times and numbers of windows, and those of each pair


@compiled
def fill_pairs(
    m: Array, n: Array, reach: float, row: Indices, column: Indices, m1: Array, m2: Array, last: Array
) -> None:
    """Fill the pairs of averaging times, the shorter one first, and the distance up to which each is summed."""
    at = 0
    for i in range(len(m)):
        for j in range(i, len(m)):
            row[at], column[at], m1[at], m2[at] = i, j, m[i], m[j]
            last[at] = np.floor(max(min((n[i] + n[j]) / 2.0 - 1.0, reach + m[i] + m[j]), 0.0))
            at += 1


@compiled
def fill_windows(n: Array, row: Indices, column: Indices, pair: Indices, distance: Array, weight: Array) -> None:
    """Multiply the weight of each lag by how many windows lie so far apart."""
    for t in range(len(pair)):
        one, other = n[row[pair[t]]], n[column[pair[t]]]
        weight[t] *= max(min(one, other, (one + other) / 2.0 - distance[t]), 0.0)


@compiled
def fill_straight(distance: Array, m1: Array, m2: Array, straight: Array, none: Array) -> None:
    """Fill weighted second differences at each lag, see ``fitting.allan_covariance``: of the lag, and of 1 at zero."""
    straight[:] = none[:] = 0.0
    for a in range(-1, 2):
        for b in range(-1, 2):
            factor = (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b))
            for t in range(len(distance)):
                lag = distance[t] + b * m2[t] - a * m1[t]
                straight[t] += factor * abs(lag)
                none[t] += factor if lag == 0.0 else 0.0


@compiled
def _decayed(lag: float, u: float) -> float:
    """Return an exponential of a lag."""
    return float(np.exp(-u * abs(lag))) if u * abs(lag) < GONE else 0.0


@compiled
def _brief(d: float, m1: float, m2: float, u: float) -> float:
    """Return the second difference of an exponential less its first terms, of brief lags."""
    total = 0.0
    for a in range(-1, 2):
        for b in range(-1, 2):
            x = u * abs(d + b * m2 - a * m1)
            rest = -x * x * x * (1.0 - x * 0.25 * (1.0 - x * 0.2 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))) / 6.0
            total += (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b)) * rest
    return total


@compiled
def fill_exponentials(x: Array, bits: NDArray[np.int64], out: Array) -> None:
    """Fill the exponentials of numbers within `MOST_GROWN` of zero, to an ulp or two; ``bits`` is work space."""
    for t in range(len(x)):
        k = np.floor(x[t] * ONE_OVER_LN_2 + 0.5)
        r = (x[t] - k * LN_2[0]) - k * LN_2[1]
        low = 1.0 + r * (1.0 + r * (0.5 + r * (SERIES[0] + r * (SERIES[1] + r * (SERIES[2] + r * SERIES[3])))))
        high = SERIES[4] + r * (
            SERIES[5] + r * (SERIES[6] + r * (SERIES[7] + r * (SERIES[8] + r * (SERIES[9] + r * SERIES[10]))))
        )
        square = r * r * r
        out[t] = low + square * square * r * high
        bits[t] = (np.int64(k) + 1023) << 52
    powers = bits.view(np.float64)
    for t in range(len(x)):
        out[t] *= powers[t]


@compiled
def _add_exponential(
    d: Array, one: float, other: float, straight: Array, exponential: Array, x: Array, here: Array,
    bits: NDArray[np.int64], out: Array,
) -> None:  # fmt: skip
    """Add that of an exponential at lags of a pair: its size, u and both of ``terms.exponential_gain``.

    Beyond all kinks it is one exponential. Nearer, what its first terms give is that of the lag, and none of constant
    and square. The three arrays in the middle are work space.
    """
    size, u, gain, excess = exponential
    both, between, longest, count = one + other, other - one, 0.0, len(d)
    for t in range(count):
        longest = max(longest, d[t])
    if not u * (longest + both) < MOST_GROWN:
        for t in range(count):
            out[t] -= size * (gain * _alone(d[t], one, other, u, straight[t]) + excess * straight[t])
        return
    for t in range(count):
        x[t] = -u * d[t]
    fill_exponentials(x[:count], bits[:count], here)
    by_one, by_other, by_both, by_between = np.exp(-u * np.array([one, other, both, between]))
    less_one, less_other, less_both, less_between = np.exp(u * np.array([one, other, both, between]))
    ahead = 4.0 - 2.0 * by_one - 2.0 * by_other + by_both + by_between
    far = (np.expm1(-u * one) * np.expm1(-u * other)) ** 2 * less_both
    for t in range(count):
        now = here[t]
        back = 1.0 / now
        found = ahead * now + u * straight[t] + (by_both * back if d[t] < both else less_both * now)
        found -= 2.0 * (by_one * back if d[t] < one else less_one * now)
        found -= 2.0 * (by_other * back if d[t] < other else less_other * now)
        found += by_between * back if d[t] < between else less_between * now
        x[t] = found if d[t] < both else far * now
    for t in range(count if u * both < BRIEF else 0):
        if u * (d[t] + both) < BRIEF:
            x[t] = _brief(d[t], one, other, u)
    for t in range(count):
        out[t] -= size * (gain * x[t] + excess * straight[t])


@compiled
def _alone(d: float, one: float, other: float, u: float, straight: float) -> float:
    """Return the same of one lag, times no gain, where products of exponentials would be too large."""
    both = one + other
    if d >= both:
        beyond = u * (d - both)
        return float((np.expm1(-u * one) * np.expm1(-u * other)) ** 2 * np.exp(-beyond)) if beyond < GONE else 0.0
    found = 4.0 * _decayed(d, u) - 2.0 * (_decayed(d + one, u) + _decayed(d + other, u)) + u * straight
    found += _decayed(d + both, u) + _decayed(d + other - one, u)
    found -= 2.0 * (_decayed(d - one, u) + _decayed(d - other, u))
    return float(found + _decayed(d - both, u) + _decayed(d - other + one, u))


@compiled
def fill_squares(
    lags: Lags, cubic: Array, flicker: Array, pairs: Pairs, reach: Array, sizes: Array, of: Indices,
    exponentials: Array, values: Array,
) -> None:  # fmt: skip
    """Fill what noises of each series give together, see ``fitting.allan_covariance``: sums over the lags of each pair.

    ``sizes`` (n, q, 5) are those of the powers of a lag, linear, none, cubic and flicker, and of a ramp squared;
    ``exponentials`` (n, e, 4) those of the noise that each is ``of``, as `_add_exponential` takes them. Second
    differences of cube and flicker are given, or empty where no noise has them. Where lags end at the last kink of each
    pair, those beyond are added up to a ``reach``, 0 for none.
    """
    pair, distance, m1, m2, straight, none, windows, more = lags
    m, n, row, column = pairs
    q, count = sizes.shape[1], len(pair)
    s, products = np.zeros((q, count)), np.empty(count)
    x, here, bits = np.empty(count), np.empty(count), np.empty(count, np.int64)
    starts = np.searchsorted(pair, np.arange(len(row) + 1))
    for t in range(count):
        products[t] = m1[t] * m2[t]
    for series in range(len(sizes)):
        size, exponential = sizes[series], exponentials[series]
        for i in range(q):
            own = s[i]
            for t in range(count):
                own[t] = size[i, 0] * straight[t] * (more[t] if len(more) > 1 else 1.0) + size[i, 1] * none[t]
            for t in range(count if size[i, 2] != 0.0 else 0):
                own[t] += size[i, 2] * cubic[t]
            for t in range(count if size[i, 3] != 0.0 else 0):
                own[t] += size[i, 3] * flicker[t]
            for e in range(len(of)):
                for p in range(len(row) if of[e] == i else 0):
                    a, b = starts[p], starts[p + 1]
                    _add_exponential(
                        distance[a:b], m[row[p]], m[column[p]], straight[a:b], exponential[e], x, here, bits, own[a:b]
                    )
            for t in range(count):
                own[t] /= products[t]
        at = 0
        for i in range(q):
            for j in range(i + 1):
                half = 0.5 if i == j else 1.0
                one, other = size[i, 4], 0.0 if i == j else size[j, 4]
                for t in range(count):
                    x[t] = windows[t] * (half * s[i, t] * s[j, t] + (one * s[j, t] + other * s[i, t]) * products[t])
                for p in range(len(row)):
                    total = 0.0
                    for t in range(starts[p], starts[p + 1]):
                        total += x[t]
                    values[series, at, p] = total
                at += 1
        if len(of) > 0 and reach[series] > 0.0:
            _add_far(pairs, reach[series], size, of, exponential, values[series])
        for i in range(len(values[series])):
            for p in range(len(row)):
                values[series, i, p] *= 2.0 / (n[row[p]] * n[column[p]])  # t and -t are alike


@compiled
def _fill_beyond(longest: float, distance: Array, weight: Array) -> int:
    """Fill the lags beyond the last kink and their weights, and return how many there are."""
    lo, done, count = 1.0, 0, 1
    distance[0], weight[0] = longest, 1.0
    while lo <= longest - 1.0:
        size = min(1.0 if done < NEAR else NEAR * GROWTH ** (done - NEAR), longest - lo)
        count = panel(lo, size, distance, weight, count)
        lo, done = lo + size, done + 1
    return count


@compiled
def _add_far(pairs: Pairs, reach: float, sizes: Array, of: Indices, exponentials: Array, values: Array) -> None:
    """Add the lags beyond all kinks, where nothing but exponentials is left: those of most pairs are alike."""
    m, n, row, column = pairs
    e, known, count = len(of), -1.0, 0
    distance, weight, windows, decayed, far = (
        np.empty(FAR),
        np.empty(FAR),
        np.empty(FAR),
        np.empty((e, FAR)),
        np.empty(e),
    )
    for p in range(len(row)):
        one, other = m[row[p]], m[column[p]]
        fewer, both, middle = min(n[row[p]], n[column[p]]), one + other, (n[row[p]] + n[column[p]]) / 2.0
        longest = np.floor(max(min(middle - 1.0, reach + both), 0.0)) - both
        if not longest > 0.0:
            continue
        if longest != known:
            known, count = longest, _fill_beyond(longest, distance, weight)
            for i in range(e):
                for t in range(count):
                    decayed[i, t] = _decayed(distance[t], exponentials[i, 1])
        for t in range(count):
            windows[t] = weight[t] * max(min(fewer, middle - both - distance[t]), 0.0)
        for i in range(e):
            size, u, gain = exponentials[i, 0], exponentials[i, 1], exponentials[i, 2]
            far[i] = -size * gain * (np.expm1(-u * one) * np.expm1(-u * other)) ** 2 / (one * other)
            alone = 0.0
            for t in range(count):
                alone += windows[t] * decayed[i, t]
            for j in range(len(sizes)):  # a ramp
                values[_place(of[i], j), p] += sizes[j, 4] * far[i] * one * other * alone
            for j in range(i + 1):
                total = 0.0
                for t in range(count):
                    total += windows[t] * decayed[i, t] * decayed[j, t]
                half = 0.5 if i == j else 1.0
                values[_place(of[i], of[j]), p] += half * far[i] * far[j] * total


@compiled
def _place(i: int, j: int) -> int:
    """Return where two noises stand among all pairs of them."""
    return max(i, j) * (max(i, j) + 1) // 2 + min(i, j)
