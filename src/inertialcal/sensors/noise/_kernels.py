"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...signals._kernels_lanes import LANES, eight, load, store, times
from ...statistics._kernels import compiled, inlined

MOST_STEPS, MOST_PIVOTS = 60, 100  # of Fisher scoring, of its equations
SHORTEST_STEP = 1e-3  # of Fisher scoring, below which it ends
CONVERGED = 1e-6  # gain of the cost below which it ends
NO_SLOPE, SINGULAR = 1e-12, 1e-13  # relative, what is taken for zero


@inlined
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
def _fill_equations(rows: Array, weighted: Array, rest: Array, A: Array, b: Array) -> None:
    """Fill D' W D and D' W rest, where D (``rows``) and W D have their columns filled up to whole eights."""
    wide, k = len(b), len(rest)
    for j in range(0, wide, LANES):
        total = eight(0.0)
        for t in range(k):
            total = total + times(load(weighted, t * wide + j), eight(rest[t]))
        store(b, j, total)
        for i in range(0, wide, 4):  # a sum waits for the one before it: four go side by side
            one, two, three, four = eight(0.0), eight(0.0), eight(0.0), eight(0.0)
            for t in range(k):
                row, at = load(rows, t * wide + j), t * wide + i
                one = one + times(eight(weighted[at]), row)
                two = two + times(eight(weighted[at + 1]), row)
                three = three + times(eight(weighted[at + 2]), row)
                four = four + times(eight(weighted[at + 3]), row)
            store(A, i * wide + j, one)
            store(A, (i + 1) * wide + j, two)
            store(A, (i + 2) * wide + j, three)
            store(A, (i + 3) * wide + j, four)


@compiled
def scored(D: Array, s: Array, w: Array, held: int, value: float, v: Array, warm: bool) -> float:
    """Fill v >= 0 of least cost for mu = D v, v[held] at its value (held -1 for none); return the cost.

    Fisher scoring: weighted least squares, weights w / mu^2, steps halved where the cost would rise. It starts from
    v where warm, else from the data.
    """
    k, p = D.shape
    wide, long = -(-p // LANES) * LANES, -(-k // LANES) * LANES
    A, T, b, new, mu = np.empty((wide, wide)), np.empty((p, p + 1)), np.empty(wide), np.empty(p), np.empty(long)
    rows, weighted, columns, rest = np.zeros(k * wide), np.zeros(k * wide), np.zeros(p * long), np.empty(k)
    for t in range(k):
        for i in range(p):
            rows[t * wide + i] = columns[i * long + t] = D[t, i]
        rest[t] = s[t] - (value * D[t, held] if held >= 0 else 0.0)
    if held >= 0:
        v[held] = value
    for t in range(k):
        mu[t] = 0.0
        for i in range(p):
            mu[t] += D[t, i] * v[i]
        warm = warm and mu[t] > 0.0
    if not warm:
        for t in range(k):
            mu[t] = s[t]
    cost = np.inf
    for _ in range(MOST_STEPS):
        for t in range(k):
            weight = eight(w[t] / (mu[t] * mu[t]))
            for i in range(t * wide, (t + 1) * wide, LANES):
                store(weighted, i, times(weight, load(rows, i)))
        _fill_equations(rows, weighted, rest, A.ravel(), b)
        nonnegative(A, b[:p], held, T, new)
        if held >= 0:
            new[held] = value
        step, trial = 2.0, np.inf
        while not trial < cost and step > SHORTEST_STEP:
            step *= 0.5
            for t in range(0, k, LANES):
                mean = eight(0.0)
                for i in range(p):
                    mean = mean + times(load(columns, i * long + t), eight(v[i] + step * (new[i] - v[i])))
                store(mu, t, mean)
            trial = 0.0
            for t in range(k):
                trial += w[t] * (np.log(mu[t]) + s[t] / mu[t]) if mu[t] > 0.0 else np.inf
        if not trial < cost:
            break
        for i in range(p):
            v[i] += step * (new[i] - v[i])
        gained, cost = cost - trial, trial
        if gained <= CONVERGED:
            break
    return float(cost)


@compiled
def searched(
    D: Array, table: Array, lo: float, hi: float, spacings: Array, s: Array, w: Array, held: int, value: float, v: Array
) -> tuple[float, float]:
    """Fill v of least cost, the last column of D interpolated in the table (cubic); return the best position, the cost.

    Positions from lo to hi are tried at the first spacing, then about the best at the next ones, and each time that
    where the parabola through the best and its neighbours is lowest.
    """
    k, p = D.shape
    powers, costs = np.zeros(p), np.empty(int((hi - lo) / spacings[0]) + 9)
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
            first = int(min(max(np.floor(position) - 1.0, 0.0), table.shape[0] - 4.0))
            x = position - first
            a, b = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0, x * (x - 2.0) * (x - 3.0) / 2.0
            c, d = -x * (x - 1.0) * (x - 3.0) / 2.0, x * (x - 1.0) * (x - 2.0) / 6.0
            for t in range(k):
                D[t, p - 1] = (
                    a * table[first, t] + b * table[first + 1, t] + c * table[first + 2, t] + d * table[first + 3, t]
                )
            costs[i] = scored(D, s, w, held, value, powers, warm)
            warm = True
            if costs[i] < costs[lowest]:
                lowest = i
            if costs[i] < least:
                best, least = position, costs[i]
                for j in range(p):
                    v[j] = powers[j]
    return best, least
