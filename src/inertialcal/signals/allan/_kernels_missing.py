"""Compiled loops over records with missing samples: arrays in, preallocated arrays out, no checks.

``count`` holds how many samples there are before each point of the integrated signal P; of a signal that came
integrated (``pointwise``), how many points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from .gaps import FILL

Whole = NDArray[np.int64]


@compiled
def mean_of(p: NDArray[Any], count: NDArray[np.int32], j: int, m: int) -> tuple[float, float]:
    """Mean of a window, and the inverse of its number of samples; the latter is infinite where it is too empty."""
    n = count[j + m] - count[j]
    if n * FILL < m:
        return 0.0, np.inf
    return np.float64(p[j + m] - p[j]) / n, 1.0 / n


@compiled
def _windows(p: NDArray[Any], count: NDArray[np.int32], j: int, m: int, order: int) -> tuple[float, float]:
    """Difference of neighbouring windows in units of P, and how much white noise the missing samples add to it."""
    a, na = mean_of(p, count, j, m)
    b, nb = mean_of(p, count, j + m, m)
    if order == 2:
        return m * (b - a), m * (na + nb) / 2.0
    c, nc = mean_of(p, count, j + 2 * m, m)
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
def weights_of_ends(count: NDArray[np.int32], factors: Whole, overlapping: bool, ends: Array) -> None:
    """Fill m^2 / 2 of the mean of the squared weights that errors of the running sum have in a term of order 2.

    Samples on end add up to the difference of two points of that sum, so that a window weighs the error of each end of
    each of its stretches by one over its number of samples; where both windows meet in a stretch, the weights add.
    """
    starts = np.zeros(len(count), dtype=np.int32)  # stretches that begin before each point
    for i in range(len(count) - 1):
        begins = count[i + 1] > count[i] and (i == 0 or count[i] == count[i - 1])
        starts[i + 1] = starts[i] + (1 if begins else 0)
    for k in range(len(factors)):
        m = factors[k]
        added, n = 0.0, 0
        for j in range(0, len(count) - 2 * m, 1 if overlapping else m):
            a, b = count[j + m] - count[j], count[j + 2 * m] - count[j + m]
            if a * FILL < m or b * FILL < m:
                continue
            u, v = 1.0 / a, 1.0 / b
            added += 2.0 * (_stretches(count, starts, j, m) * u * u + _stretches(count, starts, j + m, m) * v * v)
            if count[j + m + 1] > count[j + m] and count[j + m] > count[j + m - 1]:
                added += 2.0 * u * v
            n += 1
        ends[k] = 0.5 * m * m * added / n if n > 0 else 3.0


@compiled
def _stretches(count: NDArray[np.int32], starts: NDArray[np.int32], j: int, m: int) -> int:
    """Stretches on end in the window of m samples at j."""
    open_at_start = j > 0 and count[j + 1] > count[j] and count[j] > count[j - 1]
    return int(starts[j + m] - starts[j]) + (1 if open_at_start else 0)


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
