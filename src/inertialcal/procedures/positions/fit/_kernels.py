"""Compiled loops over many triads: arrays in, preallocated arrays out, no checks.

No unit looks at another, and the sums of a unit are taken in the order of its positions: threads may share the
units, and the bits stay. Everything is in units of gravity, so that parameters and condition have no unit.

M is lower triangular: its row i has ``1 + s_i`` times (m_i0, ..., 1). With ``y = M^-1 (r - b)`` the residual is
``e = |y| - 1``, and with ``w = M^-T y / |y|``::

    de/ds_i = -w_i (r - b)_i / (1 + s_i)      de/dm_ij = -w_i (1 + s_i) y_j      de/db_i = -w_i
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....statistics._kernels import reordered

SIZE = 9  # parameters: s_0 s_1 s_2, m_10 m_20 m_21, b_0 b_1 b_2
STEPS = 60
SETTLED = 1e-11  # change of the parameters, relative to 1, that is taken without a look at what it changes
CLOSE = 1e-9  # from here on a step that no longer lowers the sum is rounding
LIGHT = 1e-9  # least damping, relative to the diagonal
DAMPED = 1e12  # damping at which no step is left to try


@reordered
def fit_norms(
    readings: Array,
    used: NDArray[np.bool_],
    start: Array,
    found: Array,
    inverse: Array,
    squares: Array,
    condition: Array,
    steps: NDArray[np.int64],
) -> None:
    """Fill the fit of |M^-1 (r - b)| = 1 for each unit.

    Parameters
    ----------
    readings : ndarray, shape (units, positions, 3)
        In units of gravity.
    used : ndarray, shape (units, positions)
        Positions that count. Told, not looked for: sums in any order fold a test for NaN away.
    start, found : ndarray, shape (units, 9)
        Parameters where the search starts, and where it ends.
    inverse : ndarray, shape (units, 9, 9)
        Inverse of the normal matrix; NaN where it has none.
    squares, condition : ndarray, shape (units,)
        Sum of squared residuals; condition of the Jacobian, from the 1-norms of the normal matrix and its inverse.
    steps : ndarray, shape (units,)
        Steps taken; -1 where the search did not settle.
    """
    most = readings.shape[1]
    r, rows = np.empty((3, most)), np.empty((SIZE + 1, most))
    normal, tried = np.empty((SIZE + 1, SIZE + 1)), np.empty((SIZE + 1, SIZE + 1))
    factor, step, new = np.empty((SIZE, SIZE)), np.empty(SIZE), np.empty(SIZE)
    for unit in range(len(readings)):
        count = _determined(readings[unit], used[unit], r)
        p = found[unit]
        for a in range(SIZE):
            new[a] = start[unit, a]
        total, size, damping, taken, settled = np.inf, np.inf, 0.0, 0, False
        while taken < STEPS and damping < DAMPED and not settled:
            taken += 1
            there = np.inf
            if min(new[0], new[1], new[2]) > -1.0:
                there = _sums(r, count, new, rows, tried)
            if there <= total:
                total = there
                for a in range(SIZE + 1):
                    for b in range(SIZE + 1):
                        normal[a, b] = tried[a, b]
                for a in range(SIZE):
                    p[a] = new[a]
                damping = 0.0 if damping < LIGHT else 0.1 * damping
            elif size < CLOSE:
                settled = True
                break
            else:
                damping = max(10.0 * damping, LIGHT)
            while damping < DAMPED and not _step(normal, damping, factor, step):
                damping = max(10.0 * damping, LIGHT)
            size = 0.0
            for i in range(SIZE):
                new[i] = p[i] + step[i]
                size = max(size, abs(step[i]))
            if size < SETTLED:
                settled = True
                for a in range(SIZE):
                    p[a] = new[a]
        steps[unit] = taken if settled else -1
        squares[unit] = total
        condition[unit] = _inverted(normal, factor, inverse[unit])


@reordered
def _determined(readings: Array, used: NDArray[np.bool_], r: Array) -> int:
    """Fill ``r``, (3, positions), with the readings of the positions that are used; return their number."""
    count = 0
    for k in range(len(readings)):
        if used[k]:
            for i in range(3):
                r[i, count] = readings[k, i]
            count += 1
    return count


@reordered
def _sums(r: Array, count: int, p: Array, j: Array, normal: Array) -> float:
    """Fill the normal matrix at p, as its lower half, with J'e as row 9; return the sum of e^2.

    ``j``, (10, positions), takes the columns of the Jacobian and the residuals: a loop over positions becomes vector
    instructions.
    """
    g0, g1, g2, m10, m20, m21 = 1.0 + p[0], 1.0 + p[1], 1.0 + p[2], p[3], p[4], p[5]
    i0, i1, i2 = 1.0 / g0, 1.0 / g1, 1.0 / g2
    for k in range(count):
        d0, d1, d2 = r[0, k] - p[6], r[1, k] - p[7], r[2, k] - p[8]
        y0 = d0 * i0
        y1 = d1 * i1 - m10 * y0
        y2 = d2 * i2 - m20 * y0 - m21 * y1
        norm = np.sqrt(y0 * y0 + y1 * y1 + y2 * y2)
        scale = 1.0 / norm if norm > 0.0 else 0.0
        v2 = y2 * scale
        v1 = y1 * scale - m21 * v2
        v0 = y0 * scale - m10 * v1 - m20 * v2
        w0, w1, w2 = v0 * i0, v1 * i1, v2 * i2
        j[0, k], j[1, k], j[2, k] = -w0 * d0 * i0, -w1 * d1 * i1, -w2 * d2 * i2
        j[3, k], j[4, k], j[5, k] = -v1 * y0, -v2 * y0, -v2 * y1
        j[6, k], j[7, k], j[8, k] = -w0, -w1, -w2
        j[9, k] = norm - 1.0
    for a in range(SIZE + 1):
        for b in range(a + 1):
            total = 0.0
            for k in range(count):
                total += j[a, k] * j[b, k]
            normal[a, b] = total
    return float(normal[SIZE, SIZE])


@reordered
def _step(normal: Array, damping: float, factor: Array, step: Array) -> bool:
    """Fill the step -(N + damping D) ^-1 J'e, D the diagonal of N; return False where N is not positive."""
    if not _cholesky(normal, damping, factor):
        return False
    for i in range(SIZE):
        total = -normal[SIZE, i]
        for k in range(i):
            total -= factor[i, k] * step[k]
        step[i] = total / factor[i, i]
    for i in range(SIZE - 1, -1, -1):
        total = step[i]
        for k in range(i + 1, SIZE):
            total -= factor[k, i] * step[k]
        step[i] = total / factor[i, i]
    return True


@reordered
def _cholesky(normal: Array, damping: float, factor: Array) -> bool:
    """Fill the lower factor of N + damping D; return False where a pivot is lost in rounding."""
    for i in range(SIZE):
        for j in range(i + 1):
            total = normal[i, j]
            if i == j:
                total += damping * normal[i, i]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i == j:
                if not total > 1e-14 * normal[i, i]:
                    return False
                factor[i, i] = np.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
    return True


@reordered
def _inverted(normal: Array, factor: Array, inverse: Array) -> float:
    """Fill the inverse of N; return the condition of J: infinite, and an inverse of NaN, where there is none."""
    if not _cholesky(normal, 0.0, factor):
        for i in range(SIZE):
            for k in range(SIZE):
                inverse[i, k] = np.nan
        return np.inf
    column = np.empty(SIZE)
    for c in range(SIZE):
        for i in range(c, SIZE):
            total = 1.0 if i == c else 0.0
            for k in range(c, i):
                total -= factor[i, k] * column[k]
            column[i] = total / factor[i, i]
        for i in range(SIZE - 1, c - 1, -1):
            total = column[i]
            for k in range(i + 1, SIZE):
                total -= factor[k, i] * inverse[k, c]
            inverse[i, c] = total / factor[i, i]
            inverse[c, i] = inverse[i, c]
    highest, highest_inverse = 0.0, 0.0
    for i in range(SIZE):
        total, total_inverse = 0.0, 0.0
        for k in range(SIZE):
            total += abs(normal[max(i, k), min(i, k)])
            total_inverse += abs(inverse[i, k])
        highest, highest_inverse = max(highest, total), max(highest_inverse, total_inverse)
    return float(np.sqrt(highest * highest_inverse))


@reordered
def apply_known(hat: Array, design: Array, readings: Array, found: Array, squares: Array) -> None:
    """Fill the straight lines of each sensor and unit through known inputs, and their squared residuals.

    Parameters
    ----------
    hat : ndarray, shape (4, positions)
        Pseudo-inverse of the design.
    design : ndarray, shape (positions, 4)
        1 and the input along x, y, z.
    readings : ndarray, shape (units, positions, 3)
    found : ndarray, shape (units, 3, 4)
    squares : ndarray, shape (units, 3)
    """
    for unit in range(len(readings)):
        for sensor in range(3):
            for a in range(4):
                total = 0.0
                for k in range(len(design)):
                    total += hat[a, k] * readings[unit, k, sensor]
                found[unit, sensor, a] = total
            line = found[unit, sensor]
            left = 0.0
            for k in range(len(design)):
                e = readings[unit, k, sensor]
                for a in range(4):
                    e -= line[a] * design[k, a]
                left += e * e
            squares[unit, sensor] = left
