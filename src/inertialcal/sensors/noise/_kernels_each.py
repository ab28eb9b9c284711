"""Compiled loops of a fit over series of one sampling: arrays in, preallocated arrays out, no checks.

``shared`` are the columns, the table and the averaging times of ``_kernels_chain.Problem``; variances found and their
weights are of shape (n, k), a row each series. What powers are multiplied with in a covariance has a leading axis too,
of length 1 where all share it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import Indices, fill_spread
from ._kernels_chain import Rules, fill_ends, fill_limits, fill_ranked, fill_residuals, fit_of, sum_of_squares
from ._kernels_limits import fill_bread, interpolate

Shared = tuple[Array, Array, Array]
Found = tuple[Array, Array, Array]  # Variances, weights and misfits
Spreads = tuple[Array, Indices, Indices, Indices, NDArray[np.bool_], Array, Array, Array]


@compiled
def rank_each(
    shared: Shared, found: Found, wanted: NDArray[np.bool_], every: NDArray[np.bool_], spacings: Array, price: float,
    nearer: float, powers: Array, positions: Array, costs: Array, criteria: Array, counts: Indices,
) -> None:  # fmt: skip
    """Fill the different choices of each series, and how many there are."""
    columns, table, tau = shared
    for i in range(len(counts)):
        problem = (columns, table, found[0][i], found[1][i], tau)
        counts[i] = fill_ranked(
            problem, wanted, every, spacings, price, nearer, powers[i], positions[i], costs[i], criteria[i]
        )


@compiled
def fit_each(
    shared: Shared, found: Found, wanted: NDArray[np.bool_], spacings: Array, powers: Array, fitted: Array
) -> None:
    """Fill the powers of least cost of a choice of each series; position and cost go into rows of ``fitted``."""
    columns, table, tau = shared
    last = len(table) - 1.0
    for i in range(len(wanted)):
        problem = (columns, table, found[0][i], found[1][i], tau)
        fitted[i, 0], fitted[i, 1] = fit_of(problem, wanted[i], -1, 0.0, 0.0, last, spacings, powers[i])


@compiled
def know_each(
    shared: Shared, found: Found, rules: Rules, small: float, spreads: Spreads, powers: Array, positions: Array,
    sigma: Array, covariance: Array, naive: Array, tests: Array,
) -> None:  # fmt: skip
    """Fill the covariance of variances and of unknowns, see ``fitting.likelihood``, and the test of residuals.

    That is the sum of squares and its degrees of freedom, 0 where no averaging time is left over.
    """
    columns, table, tau = shared
    squares, row, column, run, banded, lost, by, doubt = spreads
    k, p = columns.shape
    per_e, out_of_sight, shape, alike, least = rules
    markov, residuals = np.empty(k), np.empty((k, 1 + k))
    for i in range(len(powers)):
        misfit, own = found[2][i], powers[i, :p].copy()
        left = np.zeros(k if misfit > 0.0 else 0)
        if powers[i, p] > 0.0:
            own = powers[i][powers[i] > 0.0]
            interpolate(table, positions[i], markov)
        for t in range(len(left)):
            for j in range(p):
                left[t] += misfit * powers[i, j] * columns[t, j]
            left[t] += misfit * powers[i, p] * markov[t] if powers[i, p] > 0.0 else 0.0
        fill_spread(
            own, squares[i % len(squares)], row, column, run, banded, lost[i % len(lost)], by[i % len(by)],
            doubt[i % len(doubt)], out_of_sight, shape, left, tau, alike, sigma[i],
        )  # fmt: skip
        fill_bread(
            columns, table, found[1][i], powers[i], positions[i], True, per_e, sigma[i], least, covariance[i], naive[i]
        )
        problem = (columns, table, found[0][i], found[1][i], tau)
        dof = k - fill_residuals(problem, per_e, powers[i], positions[i], sigma[i], residuals)
        tests[i] = 0.0
        if dof > 0:
            tests[i, 0], tests[i, 1] = sum_of_squares(residuals[:, 0].copy(), residuals[:, 1:].copy(), dof, small)


@compiled
def limit_each(
    at: Indices, steps: Indices, shared: Shared, found: Found, rules: Rules, spacings: Array,
    closeness: tuple[float, float, float], plain: Spreads, beside: Spreads, beside_at: Array,
    there: NDArray[np.bool_], lines: int, powers: Array, positions: Array, ats: Indices, sigma: Array,
    smallest: float, names: Array, rivals: Array, rival_at: Array, longest: Array, edf: Array, doublings: int,
    known: float, rounding: float, limits: Array, ended: Array,
) -> None:  # fmt: skip
    """Fill limits of series ``at`` these places from their steps on, and how far each came: ``fill_limits``."""
    columns, table, tau = shared
    for j in range(len(at)):
        i = at[j]
        problem = (columns, table, found[0][i], found[1][i], tau)
        squares, row, column, run, banded, lost, by, doubt = plain
        all_linear = (
            squares[i % len(squares)], row, column, run, banded, lost[i % len(lost)], by[i % len(by)],
            doubt[i % len(doubt)],
        )  # fmt: skip
        squares, row, column, run, banded, lost, by, doubt = beside
        some = (
            squares[j % len(squares)], row, column, run, banded, lost[j % len(lost)], by[j % len(by)],
            doubt[j % len(doubt)],
        )  # fmt: skip
        steps[i] = fill_limits(
            problem, found[2][i], rules, spacings, closeness, all_linear, some, beside_at[j], there, lines, powers[i],
            positions[i], ats, sigma[i], smallest, names, rivals[i], rival_at[i], longest[i], edf[i], doublings,
            known, rounding, steps[i], limits[i], ended[i],
        )  # fmt: skip


@compiled
def end_each(
    at: Indices, steps: Indices, shared: Shared, found: Found, rules: Rules, spacings: Array,
    closeness: tuple[float, float, float], plain: Spreads, beside: Spreads, beside_at: Array,
    there: NDArray[np.bool_], free: NDArray[np.bool_], powers: Array, fitted: Array, ats: Indices, stretches: Array,
    target: float, by_step: float, widest: float, ends: Array, ended: Array,
) -> None:  # fmt: skip
    """Fill ends of intervals in the same way: ``fill_ends``."""
    columns, table, tau = shared
    for j in range(len(at)):
        i = at[j]
        problem = (columns, table, found[0][i], found[1][i], tau)
        squares, row, column, run, banded, lost, by, doubt = plain
        all_linear = (
            squares[i % len(squares)], row, column, run, banded, lost[i % len(lost)], by[i % len(by)],
            doubt[i % len(doubt)],
        )  # fmt: skip
        squares, row, column, run, banded, lost, by, doubt = beside
        some = (
            squares[j % len(squares)], row, column, run, banded, lost[j % len(lost)], by[j % len(by)],
            doubt[j % len(doubt)],
        )  # fmt: skip
        steps[i] = fill_ends(
            problem, found[2][i], rules, spacings, closeness, all_linear, some, beside_at[j], there, free[i],
            powers[i], fitted[i, 0], fitted[i, 1], ats, stretches[i], target, by_step, widest, steps[i], ends[i],
            ended[i],
        )  # fmt: skip
