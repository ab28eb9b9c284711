"""Compiled covariance of Allan variances: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import Indices, add_differences


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
def fill_squares(
    pair: Indices, distance: Array, m1: Array, m2: Array, windows: Array, more: Array, cubic: Array, flicker: Array,
    sizes: Array, of: Indices, exponentials: Array, values: Array,
) -> None:  # fmt: skip
    """Fill what noises give together, see ``fitting.allan_covariance``: sums over the lags of each pair.

    ``sizes`` (q, 5) are those of the powers of a lag, linear, none, cubic and flicker, and of a ramp squared;
    ``exponentials`` those of the noise that each is ``of``, as `add_differences` takes them. Second differences of
    cube and flicker are given, or empty where no noise has them.
    """
    q, count = len(sizes), len(pair)
    s = np.zeros((q, count))
    for i in range(q):
        own = s[i]
        if sizes[i, 0] != 0.0 or sizes[i, 1] != 0.0 or np.any(of == i):
            add_differences(distance, m1, m2, more, sizes[i, 0], sizes[i, 1], exponentials[of == i], own)
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
