"""Compiled chains of a fit, from the choice of terms to the tests of residuals: arrays in, arrays out, no checks.

What they take is that of ``_kernels_limits``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, inlined
from ._kernels import Indices, fit_of, rotate
from ._kernels_limits import BY, interpolate

LINEAR, WHITE, RAMP = 5, 1, 4  # linear terms, and places of two


@inlined
def sort(values: Array, order: Indices) -> None:
    """Fill the order of values, the least first; of equal ones the first."""
    for i in range(len(values)):
        j = i
        while j > 0 and values[order[j - 1]] > values[i]:
            order[j] = order[j - 1]
            j -= 1
        order[j] = i


@compiled
def fill_residuals(
    columns: Array, table: Array, data: Array, per_e: float, powers: Array, position: float, sigma: Array, out: Array
) -> int:
    """Fill residuals, and behind them, in columns, their covariance: see ``fitting.goodness``, shape (k, 1 + k).

    Returned is how many unknowns the fit has.
    """
    k, p = columns.shape
    D, mean, unit, q = np.empty((k, p + 2)), np.zeros(k), np.empty(k), 0
    row, after = np.empty(k), np.empty(k)
    for i in range(p):
        if powers[i] > 0.0:
            for t in range(k):
                D[t, q] = columns[t, i]
                mean[t] += powers[i] * columns[t, i]
            q += 1
    if powers[p] > 0.0:
        interpolate(table, position, row)
        for t in range(k):
            D[t, q] = row[t]
            mean[t] += powers[p] * row[t]
        interpolate(table, position + BY, after)
        interpolate(table, position - BY, row)
        for t in range(k):
            D[t, q + 1] = powers[p] * (after[t] - row[t]) / (2.0 * BY) * per_e
        q += 2
    A = np.zeros((q, q + k))  # of the equations, and their right sides
    for i in range(q):
        size = 0.0
        for t in range(k):
            size += data[1, t] / mean[t] ** 2 * D[t, i] ** 2
        for t in range(k):
            D[t, i] /= np.sqrt(size)  # powers of different terms differ by orders of magnitude
    for i in range(q):
        for t in range(k):
            A[i, q + t] = D[t, i] * data[1, t] / mean[t] ** 2
        for j in range(q):
            for t in range(k):
                A[i, j] += A[i, q + t] * D[t, j]
    solve(A)
    left, half = np.empty((k, k)), np.empty((k, k))
    for t in range(k):
        unit[t] = np.sqrt(sigma[t, t])
        ninth = sigma[t, t] / (9.0 * mean[t] ** 2)  # 2 / (9 edf)
        out[t, 0] = (np.cbrt(data[0, t] / mean[t]) - (1.0 - ninth)) / np.sqrt(ninth)
    for t in range(k):
        for r in range(k):
            taken = 0.0
            for i in range(q):
                taken += D[t, i] * A[i, q + r]
            left[t, r] = ((1.0 if t == r else 0.0) - taken) * unit[r] / unit[t]
    for t in range(k):
        for r in range(k):
            total = 0.0
            for j in range(k):
                total += left[t, j] * sigma[j, r] / (unit[j] * unit[r])
            half[t, r] = total
    for t in range(k):
        for r in range(k):
            total = 0.0
            for j in range(k):
                total += half[t, j] * left[r, j]
            out[t, 1 + r] = total
    return q


@inlined
def solve(A: Array) -> None:
    """Put the solutions of equations (q, q + n) in the place of their right sides, the last n columns."""
    q, wide = A.shape
    for i in range(q):
        best = i
        for j in range(i + 1, q):
            if abs(A[j, i]) > abs(A[best, i]):
                best = j
        for t in range(wide):
            A[i, t], A[best, t] = A[best, t], A[i, t]
        for j in range(i + 1, q):
            factor = A[j, i] / A[i, i]
            for t in range(i, wide):
                A[j, t] -= factor * A[i, t]
    for i in range(q - 1, -1, -1):
        for t in range(q, wide):
            for j in range(i + 1, q):
                A[i, t] -= A[i, j] * A[j, t]
            A[i, t] /= A[i, i]


@compiled
def sum_of_squares(found: Array, dof: int, small: float) -> tuple[float, int]:
    """Return the sum of squares in the metric of a covariance of that rank, and how many directions it is of.

    Values are the first column of what is found, their covariance is behind them.
    Those are left out whose variance is up to a ``small`` part of the largest, and directions in the same way.
    """
    k, largest, values, covariance = len(found), 0.0, found[:, 0], found[:, 1:]
    for t in range(k):
        largest = max(largest, covariance[t, t])
    free = np.empty(k, np.int64)
    n = 0
    for t in range(k):
        if covariance[t, t] > small * largest:
            free[n] = t
            n += 1
    A, V, scaled = np.empty((n, n)), np.eye(n), np.empty(n)
    for i in range(n):
        scale = 1.0 / np.sqrt(covariance[free[i], free[i]])
        scaled[i] = values[free[i]] * scale
        for j in range(n):
            A[i, j] = covariance[free[i], free[j]] * scale / np.sqrt(covariance[free[j], free[j]])
    for i in range(n):
        for j in range(i):
            A[i, j] = A[j, i] = A[i, j]
    rotate(A, V)
    sizes, order = np.empty(n), np.empty(n, np.int64)
    for i in range(n):
        sizes[i] = A[i, i]
    sort(sizes, order)
    total, kept = 0.0, 0
    for i in order[max(n - dof, 0) :]:
        if A[i, i] > small * A[order[-1], order[-1]]:
            along = 0.0
            for j in range(n):
                along += V[j, i] * scaled[j]
            total += along * along / A[i, i]
            kept += 1
    return total, kept


@compiled
def unknowns_of(powers: Array) -> int:
    """Return how many unknowns the criterion counts of powers that are there; lines are none of them."""
    count = 2 * int(powers[-1] > 0.0) + int(powers[RAMP] > 0.0)
    for i in range(LINEAR):
        count += int(powers[i] > 0.0)
    return count


@compiled
def _bits(there: NDArray[np.bool_]) -> int:
    """Return which terms are there, Gauss-Markov noise last, as bits; lines are none of them."""
    bits = int(there[-1]) << LINEAR
    for i in range(LINEAR):
        bits |= int(there[i]) << i
    return bits


@inlined
def fill_ranked(
    columns: Array, table: Array, data: Array, wanted: NDArray[np.bool_], every: NDArray[np.bool_], spacings: Array,
    price: float, nearer: float, powers: Array, positions: Array, costs: Array, criteria: Array,
) -> int:  # fmt: skip
    """Fill the different choices among those ``wanted`` (c, p + 1), best first, as ``fitting.order`` has it.

    Each is tried with Gauss-Markov noise too, where that is one of ``every`` candidate. Returned is how many there are.
    """
    p, last, many, most = columns.shape[1], len(table) - 1.0, len(wanted), len(criteria)
    own, least, order = np.empty((many, p + 1)), np.empty(many), np.empty(most, np.int64)
    within, held = np.empty(many, np.int64), np.empty(many, np.int64)
    for i in range(many - 1, -1, -1):  # the largest first: what holds all that is left of one gives the same
        within[i], least[i], repeated = _bits(wanted[i]), np.inf, False
        for j in range(i + 1, many):
            repeated = repeated or (least[j] < np.inf and held[j] & ~within[i] == 0 and within[i] & ~within[j] == 0)
        if not repeated:
            least[i] = fit_of(columns, table, data, wanted[i], -1, 0.0, 0.0, 0.0, spacings, own[i])[1]
            held[i] = _bits(own[i] > 0.0)
    place, count, whole, best = np.full(2 << LINEAR, -1), 0, 0.0, np.inf
    sort(least, order)
    for i in range(many):
        count = _add(own[order[i]], 0.0, least[order[i]], place, count, powers, positions, costs, False)
    some, v = every.copy(), np.zeros(p + 1)
    for i in range(-1, many if every[p] else -1):  # all, and each choice
        if i >= 0:
            unknowns = 2
            for j in range(p):
                some[j] = wanted[i, j]
                unknowns += int(some[j]) if j < LINEAR else 0
            unknowns += int(some[RAMP])
            white = some[WHITE] or not every[WHITE]
            if not white or not 2.0 * whole + price * unknowns < best + nearer:
                continue
        position, cost = fit_of(columns, table, data, some, -1, 0.0, 0.0, last, spacings, v)
        count = _add(v, position, cost, place, count, powers, positions, costs, True)
        if i < 0:
            whole = cost
            for j in range(count):
                best = min(best, 2.0 * costs[j] + price * unknowns_of(powers[j]))
    for i in range(count):
        criteria[i] = 2.0 * costs[i] + price * unknowns_of(powers[i])
    sort(criteria[:count], order)
    at = order[:count]
    powers[:count], positions[:count], costs[:count] = powers[at], positions[at], costs[at]
    criteria[:count] = criteria[at]
    return count


@compiled
def _add(
    v: Array, position: float, cost: float, place: Indices, count: int, powers: Array, positions: Array, costs: Array,
    better: bool,
) -> int:  # fmt: skip
    """Put a fit behind others, unless one of the same terms is there; or in its place, where it is ``better``."""
    bits = _bits(v > 0.0)
    at = place[bits]
    if bits == 0 or not cost < np.inf or (at >= 0 and not (better and cost < costs[at])):
        return count
    if at < 0:
        at = place[bits] = count
        count += 1
    powers[at], positions[at], costs[at] = v, position, cost
    return count
