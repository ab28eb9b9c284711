"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...signals._kernels_lanes import LANES, eight, load, store, times
from ...statistics._kernels import compiled, inlined

MOST_STEPS, MOST_PIVOTS = 60, 100  # of Fisher scoring, of its equations
SHORTEST_STEP = 1e-3  # of Fisher scoring, below which it ends
CONVERGED = 1e-6  # gain of the cost below which it ends
NO_STEP = 1e-13  # relative, of all unknowns: no part of such a step is tried
NO_SLOPE, SINGULAR = 1e-12, 1e-13  # relative, what is taken for zero
NEAR = 2  # distances from a kink that are summed one by one
GROWTH = 8.0  # lengths of neighbouring panels beyond
KINKS = 6  # of each pair, both ends among them
ONE_SIDED = 0.95  # of an upper limit
SURE = 2.5758293035489004  # a term of a size that is named in 99.5 % of records is not missed
FURTHEST = 2.0**19  # standard uncertainties: beyond, there is no limit
POWER, TIME, LIMIT, MISSED = range(4)  # what a root is looked for of, see `root_of`
STEEP = 1e6  # rise of the cost that is not looked into
MOST_ROOTS, EXACT = 200, 4.0 * float(np.finfo(float).eps)  # steps towards a root; relative, closer than which none goes
SEEN = 32  # steps towards what encloses a root that are kept for another one
MOST_SWEEPS, NO_ANGLE = 30, 1e-34  # of rotations; relative square of the elements that they leave
HALF_ROOT = float(np.sqrt(0.5))

Indices = NDArray[np.int64]


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
def _fill_equations(rows: Array, weighted: Array, rest: Array, p: int, A: Array, b: Array) -> None:
    """Fill p rows of D' W D and D' W rest, where D (``rows``) and W D have their columns filled up to whole eights."""
    wide, k = len(b), len(rest)
    for j in range(0, wide, LANES):
        total = eight(0.0)
        for t in range(k):
            total = total + times(load(weighted, t * wide + j), eight(rest[t]))
        store(b, j, total)
        for i in range(0, p, 4):  # a sum waits for the one before it: four go side by side
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
def scored(D: Array, data: Array, held: int, value: float, v: Array, warm: bool) -> float:
    """Fill v >= 0 of least cost for mu = D v, v[held] at its value (held -1 for none); return the cost.

    Fisher scoring: weighted least squares, weights w / mu^2, steps halved where the cost would rise. It starts from
    v where warm, else from the ``data``, whose rows are what was found, s, and the weights, w.
    """
    k, p = D.shape
    wide, long = -(-p // LANES) * LANES, -(-k // LANES) * LANES
    A, T, b, new, mu = np.empty((wide, wide)), np.empty((p, p + 1)), np.empty(wide), np.empty(p), np.empty(long)
    rows, weighted, columns, rest = np.zeros(k * wide), np.zeros(k * wide), np.zeros(p * long), np.empty(k)
    for t in range(k):
        for i in range(p):
            rows[t * wide + i] = columns[i * long + t] = D[t, i]
        rest[t] = data[0, t] - (value * D[t, held] if held >= 0 else 0.0)
    if held >= 0:
        v[held] = value
    for t in range(k):
        mu[t] = 0.0
        for i in range(p):
            mu[t] += D[t, i] * v[i]
        warm = warm and mu[t] > 0.0
    if not warm:
        for t in range(k):
            mu[t] = data[0, t]
    cost = np.inf
    for _ in range(MOST_STEPS):
        for t in range(k):
            weight = eight(data[1, t] / (mu[t] * mu[t]))
            for i in range(t * wide, (t + 1) * wide, LANES):
                store(weighted, i, times(weight, load(rows, i)))
        _fill_equations(rows, weighted, rest, p, A.ravel(), b)
        nonnegative(A, b[:p], held, T, new)
        if held >= 0:
            new[held] = value
        step, trial, there = 2.0, np.inf, True
        for i in range(p):
            there = there and abs(new[i] - v[i]) <= NO_STEP * new[i]
        while not trial < cost and step > SHORTEST_STEP and not (there and step < 2.0):
            step *= 0.5
            for t in range(0, k, LANES):
                mean = eight(0.0)
                for i in range(p):
                    mean = mean + times(load(columns, i * long + t), eight(v[i] + step * (new[i] - v[i])))
                store(mu, t, mean)
            trial = 0.0
            for t in range(k):
                trial += data[1, t] * (np.log(mu[t]) + data[0, t] / mu[t]) if mu[t] > 0.0 else np.inf
        if not trial < cost:
            break
        for i in range(p):
            v[i] += step * (new[i] - v[i])
        gained, cost = cost - trial, trial
        if gained <= CONVERGED:
            break
    return cost


@compiled
def fit_of(
    columns: Array, table: Array, data: Array, wanted: NDArray[np.bool_], at: int, value: float, lo: float, hi: float,
    spacings: Array, powers: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill the powers of least cost of a choice of terms; return the position of the correlation time, and the cost.

    One of the powers is held ``at`` a value, none where that is -1. Gauss-Markov noise, the last of all, is
    interpolated in the table (cubic). Positions from lo to hi are tried at the first spacing, then about the best at
    the next ones, and each time that where the parabola through the best and its neighbours is lowest.
    """
    k, p = columns.shape
    q, held = 0, -1
    D = np.zeros((k, p + 1))
    for i in range(p + 1):
        if wanted[i]:
            held = q if i == at else held
            for t in range(k if i < p else 0):
                D[t, q] = columns[t, i]
            q += 1
    D, v, tried = D[:, :q].copy(), np.zeros(q), np.zeros(q)
    looks = 0 if not wanted[p] else len(spacings) if hi > lo else 1
    every = int(np.ceil((hi - lo) / spacings[0])) + 1 if looks > 0 else 1
    costs = np.empty(every + 8)
    best, least, warm = lo if looks > 0 else 0.0, np.inf, False
    for level in range(max(looks, 1)):
        start, count, lowest = lo, every, 0
        if level > 0:
            start, count = best - 3.0 * spacings[level], 7
        for i in range(count + min(level, 1)):
            position = 0.0
            if looks > 0:
                place = float(i)
                if i == count:
                    middle = min(max(lowest, 1), count - 2)
                    left, right = costs[middle - 1] - costs[middle], costs[middle + 1] - costs[middle]
                    place = middle + 0.5 * (left - right) / (left + right) if left + right > 0.0 else float(lowest)
                position = min(max(start + place * spacings[level], lo), hi)
                first = int(min(max(np.floor(position) - 1.0, 0.0), table.shape[0] - 4.0))
                x = position - first
                a, b = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0, x * (x - 2.0) * (x - 3.0) / 2.0
                c, d = -x * (x - 1.0) * (x - 3.0) / 2.0, x * (x - 1.0) * (x - 2.0) / 6.0
                for t in range(k):
                    D[t, q - 1] = (
                        a * table[first, t] + b * table[first + 1, t] + c * table[first + 2, t]
                        + d * table[first + 3, t]
                    )  # fmt: skip
            costs[i] = cost = scored(D, data, held, value, tried, warm)
            warm = True
            if cost < costs[lowest]:
                lowest = i
            if cost < least or looks == 0:
                best, least = position, cost
                for j in range(q):
                    v[j] = tried[j]
    q = 0
    for i in range(p + 1):
        powers[i] = v[q] if wanted[i] else 0.0
        q += int(wanted[i])
    return best, least


@compiled
def lags_of(m1: Array, m2: Array, last: Array) -> tuple[Indices, Array, Array]:
    """Return pair, distance and weight of all that is summed, see ``fitting.allan_covariance``, each of shape (t,)."""
    levels = NEAR + 2 + int(np.log(max(last.max(), 1.0)) / np.log(GROWTH))
    room = len(m1) * (1 + (KINKS - 1) * (1 + 6 * levels))
    pair, distance, weight, n = np.empty(room, np.int64), np.empty(room), np.empty(room), 0
    kinks = np.zeros(KINKS)
    for i in range(len(m1)):
        kinks[1], kinks[2] = min(m1[i], m2[i] - m1[i]), max(m1[i], m2[i] - m1[i])
        kinks[3], kinks[4], kinks[5] = m2[i], m2[i] + m1[i], last[i]
        first = n
        distance[n], weight[n], n = 0.0, 0.5, n + 1
        for part in range(KINKS - 1):
            start, end = min(kinks[part], last[i]), min(kinks[part + 1], last[i])
            if not end > start:
                continue
            distance[n], weight[n], n = end, 1.0, n + 1
            both, lo, hi, done = part < KINKS - 2, start + 1.0, end - 1.0, 0  # a kink at either end; what is left
            while lo <= hi:
                length = 1.0 if done < NEAR else NEAR * GROWTH ** (done - NEAR)
                size = min(length, max(np.ceil((hi - lo + 1.0) / 2.0), 1.0) if both else hi - lo + 1.0)
                n = panel(lo, size, distance, weight, n)
                lo += size
                if both and lo <= hi:
                    size = min(size, hi - lo + 1.0)
                    n = panel(hi - size + 1.0, size, distance, weight, n)
                    hi -= size
                done += 1
        pair[first:n] = i
    return pair[:n].copy(), distance[:n].copy(), weight[:n].copy()


@compiled
def panel(lo: float, size: float, distance: Array, weight: Array, n: int) -> int:
    """Put the nodes of a panel behind the first n: those exact for polynomials of degree five, of a long one."""
    if size <= NEAR:
        for i in range(int(size)):
            distance[n + i], weight[n + i] = lo + i, 1.0
        return n + int(size)
    middle, outer = lo + 0.5 * (size - 1.0), (3.0 * size * size - 7.0) / 20.0
    ends, by = size * (size * size - 1.0) / (24.0 * outer), np.sqrt(outer)
    distance[n], distance[n + 1], distance[n + 2] = middle, middle - by, middle + by
    weight[n], weight[n + 1], weight[n + 2] = size - 2.0 * ends, ends, ends
    return n + 3


@compiled
def fill_spread(
    powers: Array, squares: Array, pairs: Indices, runs: Indices, parts: Array, doubt: Array, hidden: float,
    shape: float, left: Array, tau: Array, alike: float, sigma: Array,
) -> None:  # fmt: skip
    """Fill the covariance of the Allan variances of runs that powers of terms give, see ``fitting.spread``.

    What terms leave unexplained, ``left``, is common to averaging times that differ by no more than a share ``alike``;
    it is none where it begins with zero.
    """
    k, count, q = len(sigma), pairs.shape[1], len(powers)
    total, taken, more = np.zeros(count), np.zeros(k), np.ones(k)
    at = 0
    for i in range(q):
        for j in range(i + 1):
            both = powers[i] * powers[j]
            if both != 0.0:
                for t in range(count):
                    total[t] += both * squares[at, t]
            at += 1
    for t in range(k):
        for r in range(k):
            sigma[t, r] = 0.0
    for t in range(count):
        sigma[pairs[0, t], pairs[1, t]] = sigma[pairs[1, t], pairs[0, t]] = total[t]
    for t in range(k):
        deviation, of = np.sqrt(sigma[t, t]), runs[0, t]
        level = slope = 0.0
        for i in range(q):
            taken[t] += powers[i] * parts[i, t, 0]
            level += powers[i] * parts[i, t, 1]
            slope += powers[i] * parts[i, t, 2]
        if runs[1, t] == 0:
            taken[t] = min(taken[t], hidden * deviation)
            continue
        taken[t] *= shape
        square = level * level * doubt[of, 0, 0] + slope * slope * doubt[of, 1, 1]
        square += level * slope * (doubt[of, 0, 1] + doubt[of, 1, 0])
        if deviation > 0.0:  # none, where a ramp is all there is
            more[t] += np.sqrt(max(square, 0.0)) / deviation  # of the same noise
    for t in range(k):
        for r in range(k):
            if runs[0, t] == runs[0, r]:
                sigma[t, r] = sigma[t, r] * more[t] * more[r] + taken[t] * taken[r]
    for t in range(k if len(left) > 0 and left[0] > 0.0 else 0):
        for r in range(k):
            if abs(tau[r] - tau[t]) <= alike * tau[t]:
                sigma[t, r] += left[t] * left[r]


@inlined
def brent(state: Array, tolerance: float) -> bool:
    """Return whether a root is found at state[1]; if not, put the next place there, whose value goes into state[4].

    The method of Brent [1]_: ``state`` holds the place before, this one and that on the other side of the root, the
    values there, and the last two steps.

    References
    ----------
    .. [1] R. P. Brent, Algorithms for minimization without derivatives, 1973, chapter 4.
    """
    if state[3] != 0.0 and state[4] != 0.0 and (state[3] < 0.0) != (state[4] < 0.0):
        state[2], state[5] = state[0], state[3]
        state[6] = state[7] = state[1] - state[0]
    if abs(state[5]) < abs(state[4]):
        state[0], state[1], state[2] = state[1], state[2], state[1]
        state[3], state[4], state[5] = state[4], state[5], state[4]
    before, here, other, f_before, f_here, f_other = state[:6]
    delta = 0.5 * (tolerance + EXACT * abs(here))
    half = 0.5 * (other - here)
    if f_here == 0.0 or abs(half) < delta:
        return True
    step = last = half
    if abs(state[6]) > delta and abs(f_here) < abs(f_before):
        if before == other:
            new = -f_here * (here - before) / (f_here - f_before)
        else:
            one, two = (f_before - f_here) / (before - here), (f_other - f_here) / (other - here)
            new = -f_here * (f_other * two - f_before * one) / (two * one * (f_other - f_before))
        if 2.0 * abs(new) < min(abs(state[6]), 3.0 * abs(half) - delta):
            last, step = state[7], new
    state[0], state[3], state[6], state[7] = here, f_here, last, step
    state[1] = here + (step if abs(step) > delta else delta if half > 0.0 else -delta)
    return False


@inlined
def _beyond(rise: float, x: float, stretch: float, short: float, missed: bool) -> float:
    """Return how far a power lies beyond its upper limit, from the rise of the cost there."""
    far = np.sqrt(max(2.0 * rise, 0.0) / stretch)
    beyond = far - SURE
    if missed:
        lacks = far - short * far / x  # distance of the power from which it is named
        chance = math.erfc(far * HALF_ROOT) / math.erfc(lacks * HALF_ROOT)
        least = lacks - SURE
        other = 1.0 - ONE_SIDED - chance
        beyond = other if other > least else least
    return float(beyond)


@compiled
def root_of(
    columns: Array, table: Array, data: Array, wanted: NDArray[np.bool_], at: int, lo: float, hi: float,
    spacings: Array, way: int, start: float, by: float, least: float, step: float, target: float, furthest: float,
    short: float, tolerance: float, powers: Array, seen: Array,
) -> float:  # fmt: skip
    """Return the distance at which the cost has risen enough over the least one, NaN where it never does.

    There are these ways, see ``fitting.limits``:

    - `POWER`: the distance is that of the logarithm of a power over its ``start`` from ``by`` on, and twice the cost
      rises by the target;
    - `TIME`: the same of a position in the table, in units of ``by``;
    - `LIMIT`: it is that of a power from its start, in ``by``, the target is the stretch, and the power is ruled out;
    - `MISSED`: the same of a term of which ``short`` is what the power lacks of being named.

    ``powers`` is work space. ``seen`` (`SEEN`) are costs at steps until the root is enclosed, NaN where these are not
    known; they are filled in, and hold for another target or tolerance.
    """
    root, most, limit = np.sqrt(target), max(STEEP, 4.0 * target), way >= LIMIT
    near, x = (tolerance, step) if limit else (0.0, 0.0)
    state, inside, outside, below, above = np.zeros(8), 0.0, 0.0, 0.0, 0.0
    from_inside, from_outside, between, doubled = False, False, False, 0
    for _ in range(MOST_ROOTS):
        known = SEEN if between or (x == near and limit) else 0 if x == near else 1 + doubled
        cost = seen[known] if known < SEEN else np.nan
        if np.isnan(cost):
            value = start * np.exp(by + x) if way == POWER else start + x * by
            a, b = (value, value) if way == TIME else (lo, hi)
            cost = fit_of(columns, table, data, wanted, -1 if way == TIME else at, value, a, b, spacings, powers)[1]
            if known < SEEN:
                seen[known] = cost
        if limit:
            rise = _beyond(cost - least, x, target, short, way == MISSED)
        else:  # nearly straight, where the rise is a parabola
            rise = np.sqrt(min(max(2.0 * (cost - least), 0.0), most)) - root
        if between:
            state[4] = rise
        elif rise < 0.0:
            if abs(x) >= abs(furthest):
                return np.nan
            inside, below, from_inside = x, rise, True
        elif x == near:  # of a long record, the fit that is held at zero may lie above the free one
            return near
        else:
            outside, above, from_outside = x, rise, True
        if not between:
            if not from_outside:
                doubled += int(x != near)
                x = step if x == near else 2.0 * x
                x = x if abs(x) < abs(furthest) else furthest
                continue
            if not from_inside:
                x = near
                continue
            between = True
            state[0], state[1], state[3], state[4] = inside, outside, below, above
        if brent(state, tolerance):
            break
        x = state[1]
    return float(state[1])


@compiled
def rotate(A: Array, V: Array) -> None:
    """Leave the eigenvalues of a symmetric matrix on its diagonal, and turn columns of V into its eigenvectors.

    By rotations that make one pair of elements vanish at a time [1]_.

    References
    ----------
    .. [1] C. G. J. Jacobi, J. reine angew. Math. 30 (1846) 51.
    """
    q = len(A)
    for _ in range(MOST_SWEEPS):
        off = diagonal = 0.0
        for i in range(q):
            diagonal += A[i, i] * A[i, i]
            for j in range(i):
                off += A[i, j] * A[i, j]
        if not off > NO_ANGLE * diagonal:
            break
        for i in range(1, q):
            for j in range(i):
                if A[i, j] == 0.0:
                    continue
                angle = (A[i, i] - A[j, j]) / (2.0 * A[i, j])
                t = (1.0 if angle >= 0.0 else -1.0) / (abs(angle) + np.sqrt(angle * angle + 1.0))
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                for k in range(q):
                    one, other = A[k, j], A[k, i]
                    A[k, j], A[k, i] = c * one - s * other, s * one + c * other
                for k in range(q):
                    one, other = A[j, k], A[i, k]
                    A[j, k], A[i, k] = c * one - s * other, s * one + c * other
                    one, other = V[k, j], V[k, i]
                    V[k, j], V[k, i] = c * one - s * other, s * one + c * other


@compiled
def invert(A: Array, least: float) -> None:
    """Put the pseudo-inverse of a symmetric matrix in its place, without eigenvalues up to ``least`` of the largest."""
    q = len(A)
    V = np.eye(q)
    rotate(A, V)
    largest = 0.0
    for i in range(q):
        largest = max(largest, abs(A[i, i]))
    sizes = np.zeros(q)
    for i in range(q):
        if abs(A[i, i]) > least * largest:
            sizes[i] = 1.0 / A[i, i]
    for i in range(q):
        for j in range(q):
            total = 0.0
            for k in range(q):
                total += V[i, k] * sizes[k] * V[j, k]
            A[i, j] = total


@compiled
def fill_sandwich(D: Array, w: Array, sigma: Array, least: float, covariance: Array, naive: Array) -> None:
    """Fill the covariance of unknowns with slopes D, weights w and covariance sigma, and it for sigma = 1 / w."""
    k, q = D.shape
    scale, half = np.empty(q), np.empty((q, k))
    for i in range(q):
        for j in range(i + 1):
            total = 0.0
            for t in range(k):
                total += D[t, i] * w[t] * D[t, j]
            naive[i, j] = naive[j, i] = total
        scale[i] = 1.0 / np.sqrt(naive[i, i])  # powers of different terms differ by orders of magnitude
    for i in range(q):
        for j in range(q):
            naive[i, j] *= scale[i] * scale[j]
    invert(naive, least)
    for i in range(q):
        for j in range(q):
            naive[i, j] *= scale[i] * scale[j]
    for i in range(q):
        for t in range(k):
            half[i, t] = 0.0
            for j in range(q):
                half[i, t] += naive[i, j] * D[t, j] * w[t]
    for i in range(q):
        for j in range(i + 1):
            total = 0.0
            for t in range(k):
                row = 0.0
                for r in range(k):
                    row += sigma[t, r] * half[j, r]
                total += half[i, t] * row
            covariance[i, j] = covariance[j, i] = total


@inlined
def fill_known(
    columns: Array, powers: Array, timed: Array, w: Array, sigma: Array, least: float, covariance: Array, naive: Array
) -> None:  # fmt: skip
    """Fill the same of the unknowns of powers that are there, and of one more with slopes ``timed``, if it has any."""
    k, q = len(w), len(covariance)
    D, weights, mean, i = np.empty((k, q)), np.empty(k), np.zeros(k), 0
    for j in range(len(powers)):
        if powers[j] > 0.0:
            for t in range(k):
                D[t, i] = columns[t, j]
                mean[t] += powers[j] * columns[t, j]
            i += 1
    for t in range(k):
        if len(timed) > 0:
            D[t, q - 1] = timed[t]
        weights[t] = w[t] / (mean[t] * mean[t])
    fill_sandwich(D, weights, sigma, least, covariance, naive)


@inlined
def first_known(columns: Array, powers: Array, weight: Array, column: int, most: float, least: float) -> int:
    """Return the first row of roots of weights with which a power has no larger variance; their number where none has.

    ``columns`` are what powers of 1 add to the mean; ``column`` counts those that are there.
    """
    k, q, there = len(columns), 0, np.empty(len(powers), np.int64)
    for i in range(len(powers)):
        if powers[i] > 0.0:
            there[q] = i
            q += 1
    part, D, H, scale = np.empty((k, q)), np.empty((k, q)), np.empty((q, q)), np.empty(q)
    for t in range(k):
        mean = 0.0
        for i in range(q):
            part[t, i] = columns[t, there[i]] * powers[there[i]]
            mean += part[t, i]
        for i in range(q):
            part[t, i] /= mean
    for n in range(len(weight)):
        for i in range(q):
            scale[i] = 0.0
        for t in range(k):
            for i in range(q):
                D[t, i] = part[t, i] * weight[n, t]
                scale[i] += D[t, i] * D[t, i]
        for i in range(q):
            for j in range(i + 1):
                total = 0.0
                for t in range(k):
                    total += D[t, i] * D[t, j]
                H[i, j] = H[j, i] = total / np.sqrt(scale[i] * scale[j])
        invert(H, least)
        if H[column, column] <= most * scale[column]:
            return n
    return len(weight)
