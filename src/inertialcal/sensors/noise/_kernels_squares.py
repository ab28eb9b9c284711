"""Compiled covariance of Allan variances: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import GROWTH, NEAR, Indices, panel

BRIEF = 0.05  # lag in correlation times below which an exponential less its first terms is summed as a series
GONE = 40.0  # the same from which nothing is left of it beside the other terms, to the last bit
MOST_GROWN = 690.0  # the same up to which exponentials of a sum are products

# Pair, distance and both averaging times of each lag, second differences there of the lag and of 1 at zero, how many
# windows lie so far apart, and what missing samples multiply the linear part by
Lags = tuple[Indices, Array, Array, Array, Array, Array, Array, Array]
# Averaging times and numbers of windows, those of each pair, and the reach of lags to be added, 0 for none
Pairs = tuple[Array, Array, Indices, Indices, float]


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
def _add_exponential(
    distance: Array, m1: Array, m2: Array, straight: Array, exponential: Array, out: Array
) -> None:  # fmt: skip
    """Add that of an exponential: its size, u and both of ``terms.exponential_gain``. Lags of a pair follow each other.

    Beyond all kinks it is one exponential. Nearer, what its first terms give is that of the lag, and none of constant
    and square.
    """
    size, u, gain, excess = exponential
    start = 0
    while start < len(distance):
        stop, one, other, longest = start, m1[start], m2[start], 0.0
        while stop < len(distance) and m1[stop] == one and m2[stop] == other:
            longest, stop = max(longest, distance[stop]), stop + 1
        both = one + other
        far = -size * gain * (np.expm1(-u * one) * np.expm1(-u * other)) ** 2
        grown = u * (longest + both) < MOST_GROWN
        by_one, by_other, by_both, between = np.exp(-u * np.array([one, other, both, other - one]))
        ahead = 4.0 - 2.0 * by_one - 2.0 * by_other + by_both + between
        for t in range(start, stop):
            d = distance[t]
            if d >= both:
                out[t] += far * np.exp(-u * (d - both)) if u * (d - both) < MOST_GROWN else 0.0
                continue
            if u * (d + both) < BRIEF:
                found = _brief(d, one, other, u)
            elif grown:
                here = np.exp(-u * d)
                back = 1.0 / here
                found = ahead * here + u * straight[t]
                found -= 2.0 * (by_one * back if d < one else here / by_one)
                found -= 2.0 * (by_other * back if d < other else here / by_other)
                found += by_both * back
                found += between * back if d < other - one else here / between
            else:
                found = 4.0 * _decayed(d, u) - 2.0 * (_decayed(d + one, u) + _decayed(d + other, u))
                found += _decayed(d + both, u) + _decayed(d + other - one, u) + u * straight[t]
                found -= 2.0 * (_decayed(d - one, u) + _decayed(d - other, u))
                found += _decayed(d - both, u) + _decayed(d - other + one, u)
            out[t] -= size * (gain * found + excess * straight[t])
        start = stop


@compiled
def fill_squares(
    lags: Lags, cubic: Array, flicker: Array, pairs: Pairs, sizes: Array, of: Indices, exponentials: Array,
    values: Array,
) -> None:  # fmt: skip
    """Fill what noises give together, see ``fitting.allan_covariance``: sums over the lags of each pair.

    ``sizes`` (q, 5) are those of the powers of a lag, linear, none, cubic and flicker, and of a ramp squared;
    ``exponentials`` those of the noise that each is ``of``, as `_add_exponential` takes them. Second differences of
    cube and flicker are given, or empty where no noise has them. Where lags end at the last kink of each pair, those
    beyond are added up to the reach that is given with the pairs.
    """
    pair, distance, m1, m2, straight, none, windows, more = lags
    q, count = len(sizes), len(pair)
    s = np.zeros((q, count))
    for i in range(q):
        own = s[i]
        for t in range(count):
            own[t] = sizes[i, 0] * (straight[t] * more[t] if len(more) > 1 else straight[t]) + sizes[i, 1] * none[t]
        for e in range(len(of)):
            if of[e] == i:
                _add_exponential(distance, m1, m2, straight, exponentials[e], own)
        for t in range(count if sizes[i, 2] != 0.0 else 0):
            own[t] += sizes[i, 2] * cubic[t]
        for t in range(count if sizes[i, 3] != 0.0 else 0):
            own[t] += sizes[i, 3] * flicker[t]
        for t in range(count):
            own[t] /= m1[t] * m2[t]
    values[:] = 0.0
    at = 0
    for i in range(q):
        for j in range(i + 1):
            half = 0.5 if i == j else 1.0
            one, other = sizes[i, 4], 0.0 if i == j else sizes[j, 4]
            for t in range(count):
                both = half * s[i, t] * s[j, t] + one * s[j, t] * m1[t] * m2[t]
                values[at, pair[t]] += windows[t] * (both + other * s[i, t] * m1[t] * m2[t])
            at += 1
    if len(of) > 0 and pairs[4] > 0.0:
        _add_far(pairs, sizes, of, exponentials, values)
    _, n, row, column, _ = pairs
    for t in range(len(row)):
        for i in range(len(values)):
            values[i, t] *= 2.0 / (n[row[t]] * n[column[t]])  # t and -t are alike


@compiled
def _add_far(pairs: Pairs, sizes: Array, of: Indices, exponentials: Array, values: Array) -> None:
    """Add the lags beyond all kinks, where nothing but exponentials is left."""
    m, n, row, column, reach = pairs
    distance, weight, q, e = np.empty(3), np.empty(3), len(sizes), len(of)
    s, far = np.zeros(q), np.empty(e)
    for p in range(len(row)):
        one, other = m[row[p]], m[column[p]]
        fewer, both, middle = min(n[row[p]], n[column[p]]), one + other, (n[row[p]] + n[column[p]]) / 2.0
        last = np.floor(max(min(middle - 1.0, reach + both), 0.0))
        for i in range(e):
            size, u, gain = exponentials[i, 0], exponentials[i, 1], exponentials[i, 2]
            far[i] = -size * gain * (np.expm1(-u * one) * np.expm1(-u * other)) ** 2 / (one * other)
        lo, done, count = both + 1.0, -1, 1
        distance[0], weight[0] = last, 1.0
        while last > both and (done < 0 or lo <= last - 1.0):
            if done >= 0:
                size = min(1.0 if done < NEAR else NEAR * GROWTH ** (done - NEAR), last - lo)
                count = panel(lo, size, distance, weight, 0)
                lo += size
            done += 1
            for t in range(count):
                s[:] = 0.0
                for i in range(e):
                    x = exponentials[i, 1] * (distance[t] - both)
                    s[of[i]] += far[i] * np.exp(-x) if x < MOST_GROWN else 0.0
                windows = weight[t] * max(min(fewer, middle - distance[t]), 0.0)
                at = 0
                for i in range(q):
                    for j in range(i + 1):
                        found = (0.5 if i == j else 1.0) * s[i] * s[j] + sizes[i, 4] * s[j] * one * other
                        found += 0.0 if i == j else sizes[j, 4] * s[i] * one * other
                        values[at, p] += windows * found
                        at += 1
