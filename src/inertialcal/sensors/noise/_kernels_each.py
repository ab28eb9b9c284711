"""Compiled loops of a fit over series of one sampling: arrays in, preallocated arrays out, no checks.

``data`` (n, 3, k) is that of ``_kernels_limits`` of each series. What powers are multiplied with in a covariance has a
leading axis too, of length 1 where all share it. Where a chain comes upon powers beside Gauss-Markov noise whose
covariance is not at hand, it stops at that step, and is called once more from there, with what it lacks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import FURTHEST, LIMIT, MISSED, POWER, Indices, first_known, fit_of
from ._kernels_chain import fill_ranked, fill_residuals, sum_of_squares
from ._kernels_limits import Rules, Spread, ended_at, fill_bread, fill_covariance, hidden, known_at


@compiled
def rank_each(
    columns: Array, table: Array, data: Array, wanted: NDArray[np.bool_], every: NDArray[np.bool_], spacings: Array,
    price: float, nearer: float, powers: Array, fits: Array, counts: Indices,
) -> None:  # fmt: skip
    """Fill the different choices of each series: position, cost and criterion of each in ``fits`` (n, 3, c)."""
    for i in range(len(counts)):
        counts[i] = fill_ranked(
            columns, table, data[i], wanted, every, spacings, price, nearer, powers[i], fits[i, 0], fits[i, 1],
            fits[i, 2],
        )  # fmt: skip


@compiled
def fit_each(
    columns: Array, table: Array, data: Array, wanted: NDArray[np.bool_], spacings: Array, powers: Array, fitted: Array
) -> None:
    """Fill the powers of least cost of a choice of each series; position and cost go into rows of ``fitted``."""
    last = len(table) - 1.0
    for i in range(len(wanted)):
        fitted[i, 0], fitted[i, 1] = fit_of(
            columns, table, data[i], wanted[i], -1, 0.0, 0.0, last, spacings, powers[i]
        )  # fmt: skip


@compiled
def know_each(
    columns: Array, table: Array, data: Array, misfits: Array, rules: Rules, small: float, pairs: Indices,
    runs: Indices, spreads: Spread, powers: Array, fitted: Array, sigma: Array, covariance: Array, naive: Array,
    tests: Array,
) -> None:  # fmt: skip
    """Fill the covariance of variances and of unknowns, see ``fitting.likelihood``, and the test of residuals.

    That is the sum of squares and its degrees of freedom, 0 where no averaging time is left over.
    """
    k, (squares, parts, doubt) = len(columns), spreads
    residuals = np.empty((k, 1 + k))
    for i in range(len(powers)):
        own, at = powers[i], fitted[i, 0]
        fill_covariance(
            columns, table, data[i], own, at, misfits[i], rules, pairs, runs, squares[i % len(squares)],
            parts[i % len(parts)], doubt[i % len(doubt)], sigma[i],
        )  # fmt: skip
        fill_bread(columns, table, data[i, 1], own, at, True, rules[0], sigma[i], rules[4], covariance[i], naive[i])
        dof = k - fill_residuals(columns, table, data[i], rules[0], own, at, sigma[i], residuals)
        tests[i] = 0.0
        if dof > 0:
            tests[i, 0], tests[i, 1] = sum_of_squares(residuals, dof, small)


@compiled
def limit_each(
    at: Indices, steps: Indices, columns: Array, table: Array, data: Array, misfits: Array, rules: Rules,
    spacings: Array, pairs: Indices, runs: Indices, plain: Spread, beside: Spread, beside_at: Array,
    there: NDArray[np.bool_], lines: int, powers: Array, positions: Array, ats: Indices, sigma: Array,
    smallest: float, names: Array, rivals: Array, longest: Array, roots: Array, known: float, rounding: float,
    limits: Array, ended: Array,
) -> None:  # fmt: skip
    """Fill limits of powers that are not there, and the record each needs, see ``fitting.limits``.

    They are filled of series ``at`` these places from their steps on, of which every limit has two; how far each series
    came is filled as well. A row of ``limits`` (n, m, 4) is the limit, NaN for none, the doublings of the record, 1
    where it holds next to the rival, and the stretch. ``names`` is by how much the criterion falls where each is named.
    A rival is powers and their position, none without a power. ``roots`` are the roots of half the degrees of freedom
    of records of 2^0, 2^1, ... times the present one, at averaging times at which ``longest`` are columns.
    """
    p, last = columns.shape[1], len(table) - 1.0
    own, v = np.empty(p + 1), np.empty(p + 1)
    for j in range(len(at)):
        s = at[j]
        shared = plain[0][s % len(plain[0])], plain[1][s % len(plain[1])], plain[2][s % len(plain[2])]
        some = beside[0][j % len(beside[0])], beside[1][j % len(beside[1])], beside[2][j % len(beside[2])]
        for step in range(steps[s], 2 * len(ats)):
            steps[s] = step
            i, missed = step // 2, step % 2 == 0
            place, limit, position = ats[i], limits[s, i], positions[s, i]
            if missed:
                limit[0], limit[1], limit[2], limit[3] = np.nan, float(len(roots[s])), 0.0, np.nan
            elif np.isnan(limit[0]):
                continue
            if not hidden(columns, table, powers[s], position, place, smallest, own):
                continue
            variance, naive = known_at(
                columns, table, data[s, 1], own, position, place < p, rules[0], sigma[s], rules[4], place
            )  # fmt: skip
            u, stretch = np.sqrt(variance), variance / naive
            named, source = u * np.sqrt(names[i] / stretch), powers[s]
            if not missed:
                source, position, stretch = rivals[s, i, : p + 1], rivals[s, i, p + 1], limit[3]
            wanted, rival = source > 0.0, missed
            for r in range(p + 1):
                rival = rival or wanted[r]
                wanted[r] = wanted[r] or r == place or p - lines <= r < p
            if rival:
                near = rules[5] if place < p else 0.0
                lo, hi = position, position
                if place < p:
                    lo, hi = max(position - near, 0.0), min(position + near, last)
                least = fit_of(columns, table, data[s], wanted, -1, 0.0, lo, hi, spacings[:2], v)[1]
                best = v[place]
                ready, x, stretch = ended_at(
                    columns, table, data[s], misfits[s], rules, spacings, pairs, runs, shared, some, beside_at[j],
                    there, wanted, place, lo, hi, MISSED if missed else LIMIT, best, u, least, 1.0, 1.0, stretch,
                    FURTHEST, max(named - best, 0.0) / u, place < p, ended[s],
                )  # fmt: skip
                if not ready:
                    break
                if missed:
                    limit[0], limit[3] = best + x * u, stretch
                elif best + x * u > limit[0]:
                    limit[0], limit[2] = best + x * u, 1.0
            if not missed:
                column = 0
                for r in range(p + 1):
                    own[r] = limit[0] if r == place else powers[s, r]
                    column += int(r < place and own[r] > 0.0)
                limit[1] = first_known(longest[s], own, roots[s], column, known * known / limit[3], rounding)
        else:
            steps[s] = 2 * len(ats)


@compiled
def end_each(
    at: Indices, steps: Indices, columns: Array, table: Array, data: Array, misfits: Array, rules: Rules,
    spacings: Array, pairs: Indices, runs: Indices, plain: Spread, beside: Spread, beside_at: Array,
    there: NDArray[np.bool_], free: NDArray[np.bool_], powers: Array, fitted: Array, ats: Indices, stretches: Array,
    target: float, by_step: float, widest: float, ends: Array, ended: Array,
) -> None:  # fmt: skip
    """Fill the ends of intervals of powers, with the terms free that are said, see ``fitting.limits``.

    A row of ``ends`` (n, m, 2) is the lower end and the upper one, NaN where there is none. Each is a step, as above.
    """
    p, last = columns.shape[1], len(table) - 1.0
    v, best, least, absent = np.empty(p + 1), 0.0, 0.0, False
    for j in range(len(at)):
        s = at[j]
        shared = plain[0][s % len(plain[0])], plain[1][s % len(plain[1])], plain[2][s % len(plain[2])]
        some = beside[0][j % len(beside[0])], beside[1][j % len(beside[1])], beside[2][j % len(beside[2])]
        lo, hi = max(fitted[s, 0] - rules[5], 0.0), min(fitted[s, 0] + rules[5], last)
        first = steps[s]
        for step in range(first, 2 * len(ats)):
            steps[s] = step
            i, upper = step // 2, step % 2 == 1
            place, start = ats[i], powers[s, ats[i]]
            if not upper or step == first:
                others = free[s].copy()
                least = fit_of(columns, table, data[s], others, -1, 0.0, lo, hi, spacings, v)[1]
                best = v[place]
                if fitted[s, 1] < least:
                    least, best = fitted[s, 1], start
                others[place] = False
                without = fit_of(columns, table, data[s], others, -1, 0.0, 0.0, last, spacings[:2], v)[1]
                absent = best <= 0.0 or 2.0 * (without - least) < target * stretches[s, i]
            ends[s, i, step % 2] = np.nan
            if absent and not upper:
                continue
            ratio = np.log(best / start) if best > 0.0 else -widest
            begin, sign = (max(ratio, 0.0), 1.0) if upper else (min(ratio, 0.0), -1.0)
            ready, x, _ = ended_at(
                columns, table, data[s], misfits[s], rules, spacings, pairs, runs, shared, some, beside_at[j], there,
                free[s], place, lo, hi, POWER, start, begin, least, sign * by_step, target, stretches[s, i],
                sign * widest, 0.0, True, ended[s],
            )  # fmt: skip
            if not ready:
                break
            ends[s, i, step % 2] = start * np.exp(begin + x)
        else:
            steps[s] = 2 * len(ats)
