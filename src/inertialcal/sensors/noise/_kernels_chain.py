"""Compiled chains of a fit, from the choice of terms to their intervals and limits: arrays in, arrays out, no checks.

A ``problem`` holds the Allan variances of linear terms and lines of size 1, columns (k, p), those of Gauss-Markov noise
at correlation times, a table (g, k), the variances found, their weights and the averaging times, each (k,). Powers
(p + 1) are those of linear terms, lines and Gauss-Markov noise, whose correlation time is a position in the table.

What powers are multiplied with in a covariance, see ``fitting.spread``, is given of all linear terms and lines
(``plain``), and of the terms that are ``there`` beside Gauss-Markov noise at one position (``beside``). Where a chain
comes upon others it stops at that place, and is called once more from there, with what it lacks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import Indices, first_known, rotate, score_each, scored, searched
from ._kernels_limits import BY, end_from, hidden, interpolate, limit_from, ruled_out, stretch_at

Problem = tuple[Array, Array, Array, Array, Array]
Spread = tuple[Array, Indices, Indices, Indices, NDArray[np.bool_], Array, Array, Array]
Rules = tuple[float, float, float, float, float]  # PER_E, HIDDEN, SHAPE, SAME_TAU, SINGULAR of ``fitting``
LINEAR, WHITE, RAMP = 5, 1, 4  # linear terms, and places of two


@compiled
def fit_of(
    problem: Problem, wanted: NDArray[np.bool_], at: int, value: float, lo: float, hi: float, spacings: Array,
    powers: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill the powers of least cost of a choice of terms; return the position of the correlation time, and the cost.

    One of the powers is held ``at`` a value, none where that is -1.
    """
    columns, table, s, w, _ = problem
    k, p = columns.shape
    places = np.flatnonzero(wanted)
    D, v, position = np.zeros((k, len(places))), np.zeros(len(places)), 0.0
    held = int(np.searchsorted(places, at)) if at >= 0 else -1
    for j in range(len(places)):
        if places[j] < p:
            for t in range(k):
                D[t, j] = columns[t, places[j]]
    if wanted[p]:
        position, cost = searched(D, table, lo, hi, spacings if hi > lo else spacings[:1], s, w, held, value, v)
    else:
        cost = scored(D, s, w, held, value, v, False)
    powers[:] = 0.0
    for j in range(len(places)):
        powers[places[j]] = v[j]
    return position, cost


@compiled
def fill_residuals(problem: Problem, per_e: float, powers: Array, position: float, sigma: Array, out: Array) -> int:
    """Fill residuals, and behind them, in columns, their covariance: see ``fitting.goodness``, shape (k, 1 + k).

    Returned is how many unknowns the fit has.
    """
    columns, table, s, w, _ = problem
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
            size += w[t] / mean[t] ** 2 * D[t, i] ** 2
        for t in range(k):
            D[t, i] /= np.sqrt(size)  # powers of different terms differ by orders of magnitude
    for i in range(q):
        for t in range(k):
            A[i, q + t] = D[t, i] * w[t] / mean[t] ** 2
        for j in range(q):
            for t in range(k):
                A[i, j] += A[i, q + t] * D[t, j]
    solve(A)
    left, half = np.empty((k, k)), np.empty((k, k))
    for t in range(k):
        unit[t] = np.sqrt(sigma[t, t])
        ninth = sigma[t, t] / (9.0 * mean[t] ** 2)  # 2 / (9 edf)
        out[t, 0] = (np.cbrt(s[t] / mean[t]) - (1.0 - ninth)) / np.sqrt(ninth)
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


@compiled
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
def sum_of_squares(values: Array, covariance: Array, dof: int, small: float) -> tuple[float, int]:
    """Return the sum of squares in the metric of a covariance of that rank, and how many directions it is of.

    Values are left out whose variance is up to a ``small`` part of the largest, and directions in the same way.
    """
    k, largest = len(values), 0.0
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
    order = np.argsort(np.diag(A).copy(), kind="mergesort")
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
def unknowns_of(there: NDArray[np.bool_]) -> int:
    """Return how many unknowns the criterion counts of terms that are there; lines are none of them."""
    count = 2 * int(there[-1]) + int(there[RAMP])
    for i in range(LINEAR):
        count += int(there[i])
    return count


@compiled
def fill_ranked(
    problem: Problem, wanted: NDArray[np.bool_], every: NDArray[np.bool_], spacings: Array, price: float,
    nearer: float, powers: Array, positions: Array, costs: Array, criteria: Array,
) -> int:  # fmt: skip
    """Fill the different choices among those ``wanted`` (c, p), best first, as ``fitting.order`` has it.

    Each is tried with Gauss-Markov noise too, where that is one of ``every`` candidate. Returned is how many there are.
    """
    p, last = problem[0].shape[1], len(problem[1]) - 1.0
    own, least = np.zeros((len(wanted), p + 1)), np.empty(len(wanted))
    score_each(problem[0], problem[2], problem[3], wanted, own, least)
    place, count, v = np.full(2 << LINEAR, -1), 0, np.zeros(p + 1)
    for i in np.argsort(least, kind="mergesort"):
        count = _add(own[i], 0.0, least[i], place, count, powers, positions, costs, False)
    if every[p]:
        position, whole = fit_of(problem, every, -1, 0.0, 0.0, last, spacings, v)
        count = _add(v, position, whole, place, count, powers, positions, costs, True)
        best = np.inf
        for i in range(count):
            best = min(best, 2.0 * costs[i] + price * unknowns_of(powers[i] > 0.0))
        for i in range(len(wanted)):
            some = np.ones(p + 1, np.bool_)
            some[:p] = wanted[i]
            white = some[WHITE] or not every[WHITE]
            if white and 2.0 * whole + price * unknowns_of(some) < best + nearer:
                position, cost = fit_of(problem, some, -1, 0.0, 0.0, last, spacings, v)
                count = _add(v, position, cost, place, count, powers, positions, costs, True)
    for i in range(count):
        criteria[i] = 2.0 * costs[i] + price * unknowns_of(powers[i] > 0.0)
    order = np.argsort(criteria[:count], kind="mergesort")
    powers[:count], positions[:count], costs[:count] = powers[order], positions[order], costs[order]
    criteria[:count] = criteria[order]
    return count


@compiled
def _add(
    v: Array, position: float, cost: float, place: Indices, count: int, powers: Array, positions: Array, costs: Array,
    better: bool,
) -> int:  # fmt: skip
    """Put a fit behind others, unless one of the same terms is there; or in its place, where it is ``better``."""
    bits = int(v[-1] > 0.0) << LINEAR
    for i in range(LINEAR):
        bits |= int(v[i] > 0.0) << i
    at = place[bits]
    if bits == 0 or not cost < np.inf or (at >= 0 and not (better and cost < costs[at])):
        return count
    if at < 0:
        at = place[bits] = count
        count += 1
    powers[at], positions[at], costs[at] = v, position, cost
    return count


@compiled
def _stretch(
    problem: Problem, misfit: float, rules: Rules, plain: Spread, beside: Spread, beside_at: float,
    there: NDArray[np.bool_], powers: Array, position: float, at: int, timed: bool,
) -> tuple[bool, float]:  # fmt: skip
    """Return whether the covariance of powers is at hand, and then the stretch of one of them."""
    columns, table, _, w, tau = problem
    per_e, out_of_sight, shape, alike, least = rules
    spread = plain
    if powers[-1] > 0.0:
        spread = beside
        if position != beside_at or np.any((powers > 0.0) != there):
            return False, np.nan
    squares, row, column, run, found, lost, by, doubt = spread
    return True, stretch_at(
        columns, table, w, powers, position, at, timed, per_e, squares, row, column, run, found, lost, by, doubt,
        out_of_sight, shape, tau, alike, misfit, least,
    )  # fmt: skip


@compiled
def _limit(
    problem: Problem, misfit: float, rules: Rules, spacings: Array, closeness: tuple[float, float, float],
    plain: Spread, beside: Spread, beside_at: float, there: NDArray[np.bool_], lines: int, powers: Array,
    position: float, at: int, u: float, named: float, stretch: float, missed: bool, ended: Array,
) -> tuple[bool, float, float]:  # fmt: skip
    """Return whether all that is needed is at hand, the upper limit of a power (NaN for none) and the stretch there.

    ``ended`` (p + 2) is filled with the powers of least cost there, and their position.
    """
    columns, table, s, w, _ = problem
    nearby, rough, close = closeness
    p, wanted = columns.shape[1], powers > 0.0
    wanted[p - lines : p] = True
    wanted[at] = True
    near = nearby if at < p else 0.0
    x, best, least, short, place = ruled_out(
        columns, table, s, w, wanted, position, near, spacings, at, u, named, stretch, missed, rough, ended[: p + 1]
    )
    ended[p + 1] = place
    if np.isnan(x):
        return True, np.nan, stretch
    known, stretch = _stretch(
        problem, misfit, rules, plain, beside, beside_at, there, ended[: p + 1], place, at, at < p
    )  # fmt: skip
    if not known or not stretch > 0.0:  # nothing but a ramp is left, which does not scatter
        return known, np.nan, stretch
    x = limit_from(
        columns, table, s, w, wanted, position, near, spacings, at, u, best, least, short, missed, stretch, close
    )  # fmt: skip
    return True, best + x * u, stretch


@compiled
def fill_longer(edf: Array, doublings: int, roots: Array) -> None:
    """Fill the roots of half the degrees of freedom of records of 2^0 .. 2^doublings times the present one.

    Those go with length over tau; a record of each length has an octave more than the one before. Shape (25, k + 24),
    zero at averaging times that a record does not have.
    """
    k = len(edf)
    for n in range(doublings + 1):
        for t in range(k + doublings):
            back = min(t, n)
            roots[n, t] = np.sqrt(0.5 * edf[t - back] * 2.0 ** (n - back)) if t < k + n else 0.0


@compiled
def fill_limits(
    problem: Problem, misfit: float, rules: Rules, spacings: Array, closeness: tuple[float, float, float],
    plain: Spread, beside: Spread, beside_at: float, there: NDArray[np.bool_], lines: int, powers: Array,
    positions: Array, ats: Indices, sigma: Array, smallest: float, names: Array, rivals: Array, rival_at: Array,
    longest: Array, edf: Array, doublings: int, known: float, rounding: float, first: int, found: Array, ended: Array,
) -> int:  # fmt: skip
    """Fill limits of powers that are not there, and the record each needs, see ``fitting.limits``.

    A row of ``found`` (n, 4) is the limit, NaN for none, the doublings of the record, 1 where it holds next to the
    rival, and the stretch. ``names`` is by how much the criterion falls where each is named. A rival without a power is
    none. Every limit has two steps, the ``first`` of all is where to begin; returned is the one that cannot be done,
    because the covariance of the powers and position in ``ended`` is not at hand, or their number.
    """
    columns, table, _, w, _ = problem
    per_e, least = rules[0], rules[4]
    roots = np.empty((doublings + 1, len(edf) + doublings))
    fill_longer(edf, doublings, roots)
    for step in range(first, 2 * len(ats)):
        i = step // 2
        at, position, own = ats[i], positions[i], found[i]
        if step % 2 == 1 and np.isnan(own[0]):
            continue
        u, stretch = hidden(columns, table, w, powers, position, at, smallest, per_e, sigma, least)
        if step % 2 == 0:
            own[0], own[1], own[2], own[3] = np.nan, doublings + 1.0, 0.0, np.nan
            if np.isnan(u):  # the term has no part in any deviation, or all of one
                continue
            ready, own[0], own[3] = _limit(
                problem, misfit, rules, spacings, closeness, plain, beside, beside_at, there, lines, powers, position,
                at, u, u * np.sqrt(names[i] / stretch), stretch, True, ended,
            )  # fmt: skip
            if not ready:
                return step
            continue
        if np.any(rivals[i] > 0.0):
            ready, other, _ = _limit(
                problem, misfit, rules, spacings, closeness, plain, beside, beside_at, there, lines, rivals[i],
                rival_at[i], at, u, 0.0, own[3], False, ended,
            )  # fmt: skip
            if not ready:
                return step
            if other > own[0]:
                own[0], own[2] = other, 1.0
        shown, column = powers.copy(), 0
        shown[at] = own[0]
        for j in range(at):
            column += int(powers[j] > 0.0)
        own[1] = first_known(longest, shown, roots, column, known**2 / own[3], rounding)
    return 2 * len(ats)


@compiled
def fill_ends(
    problem: Problem, misfit: float, rules: Rules, spacings: Array, closeness: tuple[float, float, float],
    plain: Spread, beside: Spread, beside_at: float, there: NDArray[np.bool_], free: NDArray[np.bool_], powers: Array,
    position: float, cost: float, ats: Indices, stretches: Array, target: float, by: float, widest: float,
    first: int, found: Array, ended: Array,
) -> int:  # fmt: skip
    """Fill the ends of intervals of powers, with the terms free that are said, see ``fitting.limits``.

    A row of ``found`` (n, 2) is the lower end and the upper one, NaN where there is none. Each is a step, as above.
    """
    columns, table, s, w, _ = problem
    nearby, rough, close = closeness
    p, last, per_e = columns.shape[1], len(table) - 1.0, rules[0]
    v, best, least, absent = np.empty(p + 1), 0.0, 0.0, False
    lo, hi = max(position - nearby, 0.0), min(position + nearby, last)
    for step in range(first, 2 * len(ats)):
        i, upper = step // 2, step % 2 == 1
        at, start = ats[i], powers[ats[i]]
        if not upper or step == first:
            least = fit_of(problem, free, -1, 0.0, lo, hi, spacings, v)[1]
            best = v[at]
            if cost < least:
                least, best = cost, start
            others = free.copy()
            others[at] = False
            without = fit_of(problem, others, -1, 0.0, 0.0, last, spacings[:2], v)[1]
            absent = best <= 0.0 or 2.0 * (without - least) < target * stretches[i]
        found[i, step % 2] = np.nan
        if absent and not upper:
            continue
        ratio = np.log(best / start) if best > 0.0 else -widest
        begin, far, towards = (max(ratio, 0.0), widest, by) if upper else (min(ratio, 0.0), -widest, -by)
        x, place = end_from(
            columns, table, s, w, free, position, nearby, spacings, at, per_e, start, begin, least, towards,
            target * stretches[i], far, rough, ended[: p + 1],
        )  # fmt: skip
        ended[p + 1] = place
        if np.isnan(x):
            continue
        ready, stretch = _stretch(
            problem, misfit, rules, plain, beside, beside_at, there, ended[: p + 1], place, at, True
        )  # fmt: skip
        if not ready:
            return step
        x = end_from(
            columns, table, s, w, free, position, nearby, spacings, at, per_e, start, begin, least, towards,
            target * stretch, far, close, v,
        )[0]  # fmt: skip
        found[i, step % 2] = start * np.exp(begin + x)
    return 2 * len(ats)
