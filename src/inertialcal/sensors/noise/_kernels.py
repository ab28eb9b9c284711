"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array

compiled = numba.njit(cache=True, nogil=True, error_model="numpy")

MOST_STEPS, MOST_HALVINGS = 60, 12  # of Fisher scoring
CONVERGED = 1e-6  # gain of the cost below which it ends
NEAR = 2  # distances from a knot that are summed one by one
GROWTH = 8  # lengths of neighbouring panels beyond


@compiled
def second_differences(t: float, m1: float, m2: float, sizes: Array, exponentials: Array) -> float:
    """Return the covariance of differences of neighbouring means over m1 and m2 samples, their middles t apart.

    That is C of ``phase.Phase``, without lines, at nine lags; sizes are point, linear, cubic and flicker. Rows of
    ``exponentials`` are size, u, gain and excess (see ``phase.twice_summed_exponential``).
    """
    point, linear, cubic, flicker = sizes[0], 0.5 * sizes[1], sizes[2] / 12.0, 0.5 * sizes[3]
    total = 0.0
    for a in range(-1, 2):
        for b in range(-1, 2):
            j = abs(t + b * m2 - a * m1)
            if j == 0.0:
                found = point
            else:
                found = j * (cubic * j * j - linear)
                if flicker != 0.0:
                    found += flicker * j * j * np.log(j)
                for row in range(exponentials.shape[0]):
                    x = exponentials[row, 1] * j
                    if x < 0.05:
                        rest = -x * x * x * (1.0 - x * 0.25 * (1.0 - x * 0.2 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))) / 6.0
                    else:
                        rest = np.exp(-x) - 1.0 + x - 0.5 * x * x
                    found -= exponentials[row, 0] * (exponentials[row, 2] * rest + exponentials[row, 3] * j)
            total += (2.0 - 3.0 * abs(a)) * (2.0 - 3.0 * abs(b)) * found
    return float(total / (m1 * m2))


@compiled
def covariance_of_pair(
    m1: float, m2: float, n1: float, n2: float, reach: float, sizes: Array, ramp: float, exponentials: Array
) -> float:
    """Return the covariance of the means of n1 and n2 halved squares of differences, m1 <= m2.

    The sum over all distances t of pairs, half of it since t and -t are alike. Between knots, where the covariance has
    kinks, and away from them, panels of distances are summed by three nodes each.
    """
    last = np.floor(max(min((n1 + n2) / 2.0 - 1.0, reach + m1 + m2), 0.0))
    knots = np.array([0.0, min(m1, m2 - m1), max(m1, m2 - m1), m2, m2 + m1, last])
    total = 0.5 * _at_distance(0.0, m1, m2, n1, n2, sizes, ramp, exponentials)
    for i in range(1, len(knots)):
        start, end = min(knots[i - 1], last), min(knots[i], last)
        if end <= start:
            continue
        total += _at_distance(end, m1, m2, n1, n2, sizes, ramp, exponentials)
        lo, hi = start + 1.0, end - 1.0  # distances that are left
        both = i < len(knots) - 1  # a knot at either end
        done = 0
        while lo <= hi:
            size = 1.0 if done < NEAR else float(NEAR) * GROWTH ** (done - NEAR)
            size = min(size, max(np.ceil((hi - lo + 1.0) / 2.0), 1.0) if both else hi - lo + 1.0)
            total += _panel(lo, size, m1, m2, n1, n2, sizes, ramp, exponentials)
            lo += size
            if both and lo <= hi:
                size = min(size, hi - lo + 1.0)
                total += _panel(hi - size + 1.0, size, m1, m2, n1, n2, sizes, ramp, exponentials)
                hi -= size
            done += 1
    return float(2.0 * total / (n1 * n2))


@compiled
def _at_distance(
    t: float, m1: float, m2: float, n1: float, n2: float, sizes: Array, ramp: float, exponentials: Array
) -> float:
    """Return the number of pairs at a distance, times the covariance of their halved squares."""
    s = second_differences(t, m1, m2, sizes, exponentials)
    pairs = max(min(n1, n2, (n1 + n2) / 2.0 - t), 0.0)
    return float(pairs * (0.5 * s * s + ramp * ramp * m1 * m2 * s))


@compiled
def _panel(
    lo: float, size: float, m1: float, m2: float, n1: float, n2: float, sizes: Array, ramp: float, exponentials: Array
) -> float:
    """Sum over ``size`` whole distances from lo, by the three nodes that are exact for polynomials of degree five."""
    middle = lo + 0.5 * (size - 1.0)
    if size == 1.0:
        return _at_distance(middle, m1, m2, n1, n2, sizes, ramp, exponentials)
    if size == 2.0:
        one = _at_distance(lo, m1, m2, n1, n2, sizes, ramp, exponentials)
        return one + _at_distance(lo + 1.0, m1, m2, n1, n2, sizes, ramp, exponentials)
    square = size * size
    outer = (3.0 * square - 7.0) / 20.0
    weight = size * (square - 1.0) / (24.0 * outer)
    by = np.sqrt(outer)
    ends = _at_distance(middle - by, m1, m2, n1, n2, sizes, ramp, exponentials)
    ends += _at_distance(middle + by, m1, m2, n1, n2, sizes, ramp, exponentials)
    return weight * ends + (size - 2.0 * weight) * _at_distance(middle, m1, m2, n1, n2, sizes, ramp, exponentials)


@compiled
def fill_covariance(
    m: Array, n: Array, reach: float, sizes: Array, ramp: float, exponentials: Array, out: Array
) -> None:
    """Fill the covariance of Allan variances at m samples, ascending, of n terms each."""
    for i in range(len(m)):
        for j in range(i, len(m)):
            out[i, j] = covariance_of_pair(m[i], m[j], n[i], n[j], reach, sizes, ramp, exponentials)
            out[j, i] = out[i, j]


@compiled
def solve_positive(A: Array, b: Array, free: NDArray[np.bool_], x: Array) -> bool:
    """Fill x with the solution of A x = b on the free unknowns, zero elsewhere (Cholesky); False if singular."""
    p = len(b)
    L = np.zeros((p, p))
    for i in range(p):
        x[i] = 0.0
        if not free[i]:
            continue
        for j in range(i + 1):
            if not free[j]:
                continue
            rest = A[i, j]
            for k in range(j):
                if free[k]:
                    rest -= L[i, k] * L[j, k]
            if i == j:
                if rest <= 1e-13 * A[i, i]:
                    return False
                L[i, i] = np.sqrt(rest)
            else:
                L[i, j] = rest / L[j, j]
    y = np.zeros(p)
    for i in range(p):
        if free[i]:
            rest = b[i]
            for k in range(i):
                if free[k]:
                    rest -= L[i, k] * y[k]
            y[i] = rest / L[i, i]
    for i in range(p - 1, -1, -1):
        if free[i]:
            rest = y[i]
            for k in range(i + 1, p):
                if free[k]:
                    rest -= L[k, i] * x[k]
            x[i] = rest / L[i, i]
    return True


@compiled
def nonnegative(A: Array, b: Array, held: int, x: Array) -> None:
    """Fill x >= 0 with the minimum of x' A x / 2 - b' x, x[held] zero (Lawson and Hanson, active set)."""
    p = len(b)
    free = np.zeros(p, np.bool_)
    trial = np.zeros(p)
    for i in range(p):
        x[i] = 0.0
    for _ in range(3 * p + 3):
        best, at = 0.0, -1
        for i in range(p):
            if i != held and not free[i]:
                slope = b[i]
                for j in range(p):
                    slope -= A[i, j] * x[j]
                gain = slope / np.sqrt(A[i, i]) if A[i, i] > 0.0 else 0.0
                if gain > best:
                    best, at = gain, i
        if at < 0 or best <= 1e-12 * abs(b[at]) / np.sqrt(A[at, at]):
            return
        free[at] = True
        if not solve_positive(A, b, free, trial):
            free[at] = False
            return
        while True:
            step = 1.0
            for i in range(p):
                if free[i] and trial[i] <= 0.0:
                    step = min(step, x[i] / (x[i] - trial[i]) if x[i] > trial[i] else 0.0)
            for i in range(p):
                if free[i]:
                    x[i] += step * (trial[i] - x[i])
            if step == 1.0:
                break
            for i in range(p):
                if free[i] and trial[i] <= 0.0 and x[i] <= 1e-300 + 1e-14 * abs(trial[i]):
                    free[i] = False
                    x[i] = 0.0
            solve_positive(A, b, free, trial)


@compiled
def cost_of(mu: Array, s: Array, w: Array) -> float:
    """Return the sum of w (ln mu + s / mu); infinite where mu is not positive."""
    total = 0.0
    for i in range(len(s)):
        if not mu[i] > 0.0:
            return np.inf
        total += w[i] * (np.log(mu[i]) + s[i] / mu[i])
    return total


@compiled
def fill_mean(D: Array, v: Array, new: Array, step: float, mu: Array) -> None:
    """Fill mu with D at a step on the way from v to new."""
    for t in range(D.shape[0]):
        mu[t] = 0.0
        for i in range(D.shape[1]):
            mu[t] += D[t, i] * (v[i] + step * (new[i] - v[i]))


@compiled
def fill_normal(D: Array, s: Array, w: Array, mu: Array, held: int, value: float, A: Array, b: Array) -> None:
    """Fill the normal equations A v = b of weights w / mu^2, column ``held`` taken off."""
    k, p = D.shape
    A[:], b[:] = 0.0, 0.0
    for t in range(k):
        weight = w[t] / (mu[t] * mu[t])
        rest = s[t] - (value * D[t, held] if held >= 0 else 0.0)
        for i in range(p):
            weighted = weight * D[t, i]
            b[i] += weighted * rest
            for j in range(i + 1):
                A[i, j] += weighted * D[t, j]
    for i in range(p):
        for j in range(i):
            A[j, i] = A[i, j]


@compiled
def scored(D: Array, s: Array, w: Array, held: int, value: float, v: Array, warm: bool) -> float:
    """Fill v >= 0 of least cost for mu = D v, v[held] at its value (held -1 for none); return the cost.

    Fisher scoring: weighted least squares, weights w / mu^2, steps halved where the cost would rise. It starts from
    v where warm, else from the data.
    """
    p = D.shape[1]
    mu, A, b, new = s.copy(), np.zeros((p, p)), np.zeros(p), np.zeros(p)
    cost = np.inf
    if held >= 0:
        v[held] = value
    if warm:
        fill_mean(D, v, v, 0.0, mu)
        cost = cost_of(mu, s, w)
        if not np.isfinite(cost):
            mu[:] = s
    for _ in range(MOST_STEPS):
        fill_normal(D, s, w, mu, held, value, A, b)
        nonnegative(A, b, held, new)
        if held >= 0:
            new[held] = value
        step, trial = 1.0, np.inf
        for _ in range(MOST_HALVINGS):
            fill_mean(D, v, new, step, mu)
            trial = cost_of(mu, s, w)
            if trial <= cost:
                break
            step *= 0.5
        if not np.isfinite(trial):
            return np.inf
        gained = cost - trial
        if not gained > 0.0:
            break
        for i in range(p):
            v[i] += step * (new[i] - v[i])
        cost = trial
        if gained <= CONVERGED:
            break
    return float(cost)


@compiled
def at_position(table: Array, position: float, column: Array) -> None:
    """Fill a column by cubic interpolation between the rows of a table, evenly spaced in the logarithm."""
    first = int(min(max(np.floor(position) - 1.0, 0.0), table.shape[0] - 4.0))
    x = position - first
    a = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    b = x * (x - 2.0) * (x - 3.0) / 2.0
    c = -x * (x - 1.0) * (x - 3.0) / 2.0
    d = x * (x - 1.0) * (x - 2.0) / 6.0
    for t in range(table.shape[1]):
        column[t] = a * table[first, t] + b * table[first + 1, t] + c * table[first + 2, t] + d * table[first + 3, t]


@compiled
def searched(
    D: Array, table: Array, lo: float, hi: float, stride: float, s: Array, w: Array, held: int, value: float,
    v: Array, precision: float,
) -> tuple[float, float]:  # fmt: skip
    """Fill v of least cost, the last column taken from the table at the best position; return position and cost.

    The positions from lo to hi are tried one stride apart, then the best is bracketed and refined.
    """
    column = np.zeros(D.shape[0])
    best, best_cost = lo, np.inf
    trials = int(np.ceil((hi - lo) / stride)) + 1
    trial = np.zeros(len(v))
    for i in range(trials):
        position = min(lo + i * stride, hi)
        cost = _scored_at(position, D, table, column, s, w, held, value, trial, i > 0)
        if cost < best_cost:
            best, best_cost = position, cost
            v[:] = trial
    left, right = max(best - stride, lo), min(best + stride, hi)
    ratio = 0.6180339887498949
    trial[:] = v
    one, two = right - ratio * (right - left), left + ratio * (right - left)
    cost_one = _scored_at(one, D, table, column, s, w, held, value, trial, True)
    cost_two = _scored_at(two, D, table, column, s, w, held, value, trial, True)
    while right - left > precision:
        if cost_one < cost_two:
            right, two, cost_two = two, one, cost_one
            one = right - ratio * (right - left)
            cost_one = _scored_at(one, D, table, column, s, w, held, value, trial, True)
        else:
            left, one, cost_one = one, two, cost_two
            two = left + ratio * (right - left)
            cost_two = _scored_at(two, D, table, column, s, w, held, value, trial, True)
    best = 0.5 * (left + right)
    return best, _scored_at(best, D, table, column, s, w, held, value, v, False)


@compiled
def _scored_at(
    position: float, D: Array, table: Array, column: Array, s: Array, w: Array, held: int, value: float, v: Array, warm: bool,
) -> float:  # fmt: skip
    at_position(table, position, column)
    D[:, D.shape[1] - 1] = column
    return scored(D, s, w, held, value, v, warm)
