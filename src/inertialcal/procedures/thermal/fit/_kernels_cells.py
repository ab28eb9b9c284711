"""Sums of the samples of a ramp in bins of temperature: compiled loops.

Rows of ``columns`` are temperature, time, all readings, and the rate where there is one, shape (2 + k, n).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import compiled

NONE = -1  # in place of a bin


@compiled
def find_bins(
    columns: Array, readings: int, path: NDArray[np.int8], ends: Array, cut: float, bins: NDArray[np.int64],
    left: NDArray[np.int64],
) -> None:  # fmt: skip
    """Find the bin of each sample, the first one from ``ends[0]`` on and ``ends[1]`` wide; count those in none by rule.

    No reading or temperature, before a time, on no path.
    """
    for i in range(columns.shape[1]):
        valid = np.isfinite(columns[0, i])
        for j in range(2, 2 + readings):
            valid = valid and np.isfinite(columns[j, i])
        rule = -1
        if not valid:
            rule = 0
        elif columns[1, i] < cut:
            rule = 1
        elif path[i] == 0:
            rule = 2
        if rule >= 0:
            left[rule] += 1
            bins[i] = NONE
        else:
            bins[i] = int((columns[0, i] - ends[0]) / ends[1])


@compiled
def add_sums(
    columns: Array, bounds: NDArray[np.int64], bins: NDArray[np.int64], count: Array, sums: Array
) -> None:  # fmt: skip
    """Add to the number of samples in each bin, (r, b), and to the sums of all rows, (r, 2 + k, b), ramp by ramp.

    Each ramp is from one of its two bounds, shape (r, 2), to before the other.
    """
    for ramp in range(len(bounds)):
        for i in range(bounds[ramp, 0], bounds[ramp, 1]):
            at = min(bins[i], count.shape[1] - 1)
            if at >= 0:
                count[ramp, at] += 1.0
                for j in range(columns.shape[0]):
                    sums[ramp, j, at] += columns[j, i]


@compiled
def add_squares(
    columns: Array, readings: int, bounds: NDArray[np.int64], bins: NDArray[np.int64], means: Array, squares: Array
) -> None:  # fmt: skip
    """Add to the sums of squares about the means, (r, 2 + k, b), by ramp and bin: shape (r, 3 + 2 readings, b).

    Of temperature, time, temperature with time, each reading, and temperature with each reading.
    """
    for ramp in range(len(bounds)):
        for i in range(bounds[ramp, 0], bounds[ramp, 1]):
            at = min(bins[i], means.shape[2] - 1)
            if at >= 0:
                warm, time = columns[0, i] - means[ramp, 0, at], columns[1, i] - means[ramp, 1, at]
                squares[ramp, 0, at] += warm * warm
                squares[ramp, 1, at] += time * time
                squares[ramp, 2, at] += warm * time
                for j in range(readings):
                    own = columns[2 + j, i] - means[ramp, 2 + j, at]
                    squares[ramp, 3 + j, at] += own * own
                    squares[ramp, 3 + readings + j, at] += warm * own


@compiled
def count_still(columns: Array, away: float, noise: float, known: NDArray[np.int64]) -> int:
    """Return how many samples pass before the temperature leaves that of the start for good; -1 where time goes back.

    Of columns of these, (2, n), what is known of both alone counts; which ones these are is filled in. What lies
    further away from the first thousandth than so much has left; so has what is no longer within so many standard
    deviations of the first half of the rest.
    """
    time, temperature, count, last = columns[0], columns[1], 0, -np.inf
    for i in range(len(time)):
        if np.isfinite(time[i]) and np.isfinite(temperature[i]):
            if time[i] < last:
                return -1
            last = time[i]
            known[count] = i
            count += 1
    few = max(count // 1000, 1)
    level = 0.0
    for j in range(min(few, count)):
        level += temperature[known[j]] / few
    still = 0
    while still < count and abs(temperature[known[still]] - level) <= away:
        still += 1
    half = max(still // 2, 1)
    mean, square = 0.0, 0.0
    for j in range(min(half, still)):
        mean += temperature[known[j]] / half
    for j in range(min(half, still)):
        square += (temperature[known[j]] - mean) ** 2 / half
    found = 0
    for j in range(still):
        if abs(temperature[known[j]] - mean) <= noise * np.sqrt(square):
            found = j + 1
    return found


@compiled
def fill_roots(squares: Array, roots: Array) -> None:
    """Fill in the inverses of the Cholesky factors of matrices, shape (m, p, p); infinite where one has none."""
    p = squares.shape[1]
    for m in range(len(squares)):
        factor, root = squares[m].copy(), roots[m]
        root[:] = 0.0
        for j in range(p):
            pivot = factor[j, j]
            for k in range(j):
                pivot -= factor[j, k] * factor[j, k]
            if not pivot > 0.0:
                root[:] = np.inf
                break
            factor[j, j] = np.sqrt(pivot)
            for i in range(j + 1, p):
                for k in range(j):
                    factor[i, j] -= factor[i, k] * factor[j, k]
                factor[i, j] /= factor[j, j]
            root[j, j] = 1.0 / factor[j, j]
            for i in range(j):  # the row of the inverse
                total = 0.0
                for k in range(i, j):
                    total += factor[j, k] * root[k, i]
                root[j, i] = -total / factor[j, j]


@compiled
def fill_bases(basis: Array, transform: Array, length: Array) -> float:
    """Turn columns of matrices, shape (m, n, p), into orthonormal ones, each less its part along those before, twice.

    ``columns @ transform``, (m, p, p), gives them; ``length``, (m, p), is filled in with the lengths of the columns.
    Returns the least share of a column that those before it leave; 0, the rest unfilled, where one is of no length.
    """
    n, p = basis.shape[1:]
    along, total, least = np.empty(p), np.empty(p), 1.0
    for m in range(len(basis)):
        own, turned = basis[m], transform[m]
        turned[:] = 0.0
        for j in range(p):
            square = 0.0
            for k in range(n):
                square += own[k, j] * own[k, j]
            length[m, j] = np.sqrt(square)
            total[:j] = 0.0
            for _ in range(2):
                along[:j] = 0.0
                for k in range(n):
                    for i in range(j):
                        along[i] += own[k, i] * own[k, j]
                square = 0.0
                for k in range(n):
                    left = own[k, j]
                    for i in range(j):
                        left -= along[i] * own[k, i]
                    own[k, j] = left
                    square += left * left
                for i in range(j):
                    total[i] += along[i]
            size = np.sqrt(square)
            if not size > 0.0:
                return 0.0
            least = min(least, size / length[m, j])
            for k in range(n):
                own[k, j] /= size
            turned[j, j] = 1.0 / size
            for i in range(j):
                part = 0.0
                for q in range(i, j):
                    part += turned[i, q] * total[q]
                turned[i, j] = -part / size
    return least
