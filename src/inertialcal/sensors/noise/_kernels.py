"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled

MOST_STEPS, MOST_PIVOTS = 60, 100  # of Fisher scoring, of its equations
SHORTEST_STEP = 1e-3  # of Fisher scoring, below which it ends
CONVERGED = 1e-6  # gain of the cost below which it ends
NO_SLOPE, SINGULAR = 1e-12, 1e-13  # relative, what is taken for zero
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
    m: Array, n: Array, raised: Array, reach: float, sizes: Array, ramp: float, exponentials: Array, out: Array
) -> None:
    """Fill the covariance of Allan variances at m samples, ascending, of n terms each.

    ``raised`` is what missing samples multiply the linear size, second of ``sizes``, by.
    """
    shared = sizes.copy()
    for i in range(len(m)):
        for j in range(i, len(m)):
            shared[1] = sizes[1] * np.sqrt(raised[i] * raised[j])
            out[i, j] = covariance_of_pair(m[i], m[j], n[i], n[j], reach, shared, ramp, exponentials)
            out[j, i] = out[i, j]


@compiled
def nonnegative(A: Array, b: Array, held: int, T: Array, x: Array) -> None:
    """Fill x >= 0 with the minimum of x' A x / 2 - b' x, x[held] zero.

    Unknowns change places with their slopes one at a time, always the first that is out of order: a negative unknown,
    or a slope that would lower the cost (K. G. Murty, Math. Programming 7 (1974) 285). T is work space, a column wider.
    """
    p = len(b)
    for i in range(p):
        x[i] = 0.0  # 1 while it is an unknown, 0 while its slope is
        T[i, p] = b[i]
        for j in range(p):
            T[i, j] = A[i, j]
    for _ in range(MOST_PIVOTS):
        at = -1
        for i in range(p - 1, -1, -1):
            slope = T[i, p] > NO_SLOPE * abs(b[i]) and T[i, i] > SINGULAR * A[i, i]
            if i != held and (slope if x[i] == 0.0 else T[i, p] < 0.0):
                at = i
        if at < 0:
            break
        x[at] = 1.0 - x[at]
        pivot = 1.0 / T[at, at]
        for j in range(p + 1):
            T[at, j] *= pivot
        for i in range(p):
            if i != at:
                factor = T[i, at]
                for j in range(p + 1):
                    T[i, j] -= factor * T[at, j]
                T[i, at] = -factor * pivot
        T[at, at] = pivot
    for i in range(p):
        x[i] *= T[i, p]


@compiled
def cost_at(D: Array, v: Array, new: Array, step: float, s: Array, w: Array, mu: Array) -> float:
    """Fill mu with D at a step on the way from v to new; return the sum of w (ln mu + s / mu), infinite if mu <= 0."""
    total = 0.0
    for t in range(D.shape[0]):
        mean = 0.0
        for i in range(D.shape[1]):
            mean += D[t, i] * (v[i] + step * (new[i] - v[i]))
        mu[t] = mean
        total += w[t] * (np.log(mean) + s[t] / mean) if mean > 0.0 else np.inf
    return float(total)


@compiled
def fill_normal(D: Array, s: Array, w: Array, mu: Array, held: int, value: float, A: Array, b: Array) -> None:
    """Fill the normal equations A v = b of weights w / mu^2, column ``held`` taken off."""
    p = D.shape[1]
    for i in range(p):
        b[i] = 0.0
        for j in range(p):
            A[i, j] = 0.0
    for t in range(D.shape[0]):
        weight = w[t] / (mu[t] * mu[t])
        rest = s[t] - (value * D[t, held] if held >= 0 else 0.0)
        for i in range(p):
            weighted = weight * D[t, i]
            b[i] += weighted * rest
            for j in range(p):
                A[i, j] += weighted * D[t, j]


@compiled
def scored(D: Array, s: Array, w: Array, held: int, value: float, v: Array, warm: bool) -> float:
    """Fill v >= 0 of least cost for mu = D v, v[held] at its value (held -1 for none); return the cost.

    Fisher scoring: weighted least squares, weights w / mu^2, steps halved where the cost would rise. It starts from
    v where warm, else from the data.
    """
    p = D.shape[1]
    A, T, b, new, mu = np.empty((p, p)), np.empty((p, p + 1)), np.empty(p), np.empty(p), np.empty(len(s))
    if held >= 0:
        v[held] = value
    if not (warm and cost_at(D, v, v, 0.0, s, w, mu) < np.inf):
        for t in range(len(s)):
            mu[t] = s[t]
    cost = np.inf
    for _ in range(MOST_STEPS):
        fill_normal(D, s, w, mu, held, value, A, b)
        nonnegative(A, b, held, T, new)
        if held >= 0:
            new[held] = value
        step, trial = 2.0, np.inf
        while not trial < cost and step > SHORTEST_STEP:
            step *= 0.5
            trial = cost_at(D, v, new, step, s, w, mu)
        if not trial < cost:
            break
        for i in range(p):
            v[i] += step * (new[i] - v[i])
        gained, cost = cost - trial, trial
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
    D: Array, table: Array, lo: float, hi: float, spacings: Array, s: Array, w: Array, held: int, value: float, v: Array
) -> tuple[float, float]:
    """Fill v of least cost, the last column of D taken from the table at the best position; return that, and the cost.

    Positions from lo to hi are tried at the first spacing, then about the best at the next ones, and each time that
    where the parabola through the best and its neighbours is lowest.
    """
    k, p = D.shape
    column, powers, costs = np.empty(k), np.zeros(p), np.empty(int((hi - lo) / spacings[0]) + 9)
    best, least, warm = lo, np.inf, False
    for level in range(len(spacings)):
        start, count = lo, int(np.ceil((hi - lo) / spacings[0])) + 1
        if level > 0:
            start, count = best - 3.0 * spacings[level], 7
        lowest = 0
        for i in range(count + min(level, 1)):
            at = float(i)
            if i == count:
                middle = min(max(lowest, 1), count - 2)
                left, right = costs[middle - 1] - costs[middle], costs[middle + 1] - costs[middle]
                at = middle + 0.5 * (left - right) / (left + right) if left + right > 0.0 else lowest
            position = min(max(start + at * spacings[level], lo), hi)
            at_position(table, position, column)
            for t in range(k):
                D[t, p - 1] = column[t]
            costs[i] = scored(D, s, w, held, value, powers, warm)
            warm = True
            if costs[i] < costs[lowest]:
                lowest = i
            if costs[i] < least:
                best, least = position, costs[i]
                for j in range(p):
                    v[j] = powers[j]
    return best, least
