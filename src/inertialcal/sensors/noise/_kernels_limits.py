"""Compiled covariance of a fit and the root of a rise of its cost: arrays in, preallocated arrays out, no checks.

``columns`` (k, p) are Allan variances of linear terms and lines of size 1, lines last; rows of ``table`` (g, k) those
of Gauss-Markov noise; rows of ``data`` (3, k) the variances found, their weights and the averaging times; ``powers``
(p + 1) are all powers, that of Gauss-Markov noise last, whose correlation time lies at ``position`` in the table.
``wanted`` (p + 1) says which take part.

What powers are multiplied with in a covariance, see ``fitting.spread``, is the `Spread` of all linear terms and lines
(``plain``), or of the terms that are ``there`` beside Gauss-Markov noise at one position (``beside``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled, inlined
from ._kernels import LIMIT, SEEN, Indices, fill_known, fill_spread, fit_of, root_of

BY = 0.05  # rows of the table, to either side, for a slope
Spread = tuple[Array, Array, Array]  # Squares, what filters take with its slopes, and the covariance of these
# PER_E, HIDDEN, SHAPE, SAME_TAU, SINGULAR, NEARBY, ROUGH, TOLERANCE of ``fitting``
Rules = tuple[float, float, float, float, float, float, float, float]


@compiled
def interpolate(table: Array, position: float, out: Array) -> None:
    """Fill the row at a position of a table (cubic)."""
    first = int(min(max(np.floor(position) - 1.0, 0.0), table.shape[0] - 4.0))
    x = position - first
    a, b = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0, x * (x - 2.0) * (x - 3.0) / 2.0
    c, d = -x * (x - 1.0) * (x - 3.0) / 2.0, x * (x - 1.0) * (x - 2.0) / 6.0
    for t in range(len(out)):
        out[t] = a * table[first, t] + b * table[first + 1, t] + c * table[first + 2, t] + d * table[first + 3, t]


@compiled
def fill_bread(
    columns: Array, table: Array, w: Array, powers: Array, position: float, timed: bool, per_e: float, sigma: Array,
    least: float, covariance: Array, naive: Array,
) -> None:  # fmt: skip
    """Fill both of ``fitting.likelihood.Sandwich``: of powers that are there, and of a time, where it is fitted."""
    k, p = columns.shape
    every, slopes = np.empty((k, p + 1)), np.empty(0)
    for i in range(p):
        for t in range(k):
            every[t, i] = columns[t, i]
    if powers[p] > 0.0:
        rows = np.empty((3, k))
        for i in range(3):
            interpolate(table, position + (i - 1) * BY, rows[i])
        for t in range(k):
            every[t, p] = rows[1, t]
        if timed:
            slopes = np.empty(k)
            for t in range(k):
                slopes[t] = powers[p] * (rows[2, t] - rows[0, t]) / (2.0 * BY) * per_e
    fill_known(every, powers, slopes, w, sigma, least, covariance, naive)


@inlined
def fill_covariance(
    columns: Array, table: Array, data: Array, powers: Array, position: float, misfit: float, rules: Rules,
    pairs: Indices, runs: Indices, squares: Array, parts: Array, doubt: Array, sigma: Array,
) -> None:  # fmt: skip
    """Fill the covariance of the variances found that powers imply: see ``fitting.spread``."""
    k, p = columns.shape
    own, left, q, markov = np.empty(p + 1), np.zeros(k), 0, powers[p] > 0.0
    if markov:
        interpolate(table, position, left)
        for t in range(k):
            left[t] *= powers[p]
    for i in range(p + int(markov)):
        if powers[i] > 0.0 or not markov:
            own[q] = powers[i]
            q += 1
        for t in range(k if i < p else 0):
            left[t] += powers[i] * columns[t, i]
    for t in range(k):
        left[t] *= misfit
    fill_spread(
        own[:q], squares, pairs, runs, parts, doubt, rules[1], rules[2], left, data[2], rules[3], sigma
    )  # fmt: skip


@inlined
def known_at(
    columns: Array, table: Array, w: Array, powers: Array, position: float, timed: bool, per_e: float, sigma: Array,
    least: float, at: int,
) -> tuple[float, float]:  # fmt: skip
    """Return variance of a power, and what it would be if weights were the inverse of that of the variances found."""
    q, column = 0, 0
    for i in range(len(powers)):
        q += int(powers[i] > 0.0)
        column += int(powers[i] > 0.0 and i < at)
    q += int(timed and powers[-1] > 0.0)
    covariance, naive = np.empty((q, q)), np.empty((q, q))
    fill_bread(columns, table, w, powers, position, timed, per_e, sigma, least, covariance, naive)
    return covariance[column, column], naive[column, column]


@inlined
def hidden(
    columns: Array, table: Array, powers: Array, position: float, at: int, share: float, own: Array
) -> bool:  # fmt: skip
    """Fill powers with one that is not there, that share of the most there is room for; return whether there is any."""
    k, p = columns.shape
    row, room = np.empty(k), np.inf
    interpolate(table, position, row)
    for t in range(k):
        mean = powers[p] * row[t] if powers[p] > 0.0 else 0.0
        for i in range(p):
            mean += powers[i] * columns[t, i]
        ratio = mean / (columns[t, at] if at < p else row[t])
        room = ratio if ratio < room or np.isnan(ratio) else room
    for i in range(p + 1):
        own[i] = share * room if i == at else powers[i]
    return bool(0.0 < own[at] < np.inf)


@compiled
def ended_at(
    columns: Array, table: Array, data: Array, misfit: float, rules: Rules, spacings: Array, pairs: Indices,
    runs: Indices, plain: Spread, beside: Spread, beside_at: float, there: NDArray[np.bool_],
    wanted: NDArray[np.bool_], at: int, lo: float, hi: float, way: int, start: float, by: float, least: float,
    step: float, target: float, stretch: float, furthest: float, short: float, timed: bool, ended: Array,
) -> tuple[bool, float, float]:  # fmt: skip
    """Return whether all that is needed is at hand, the distance to a root (NaN for none) and the stretch there.

    The root is that of ``_kernels.root_of``, with the stretch of the terms at a rough one, where ``ended`` (p + 2) is
    filled with the powers of least cost and their position.
    """
    p = columns.shape[1]
    x, level, last, seen = 0.0, stretch, np.nan, np.full(SEEN, np.nan)
    for closely in range(2):
        x = root_of(
            columns, table, data, wanted, at, lo, hi, spacings[:2], way, start, by, least, step, target * level,
            furthest, short, rules[6 + closely], ended[: p + 1] if closely == 0 else np.empty(p + 1),
            seen,
        )  # fmt: skip
        if closely == 1 or np.isnan(x):
            break
        value = start + x * by if way >= LIMIT else start * np.exp(by + x)
        last = fit_of(columns, table, data, wanted, at, value, lo, hi, spacings[:2], ended[: p + 1])[0]
        ended[p + 1] = last
        squares, parts, doubt = plain
        if ended[p] > 0.0:
            squares, parts, doubt = beside
            if last != beside_at:
                return False, np.nan, np.nan
            for i in range(p + 1):
                if (ended[i] > 0.0) != there[i]:
                    return False, np.nan, np.nan
        sigma = np.empty((len(columns), len(columns)))
        own = ended[: p + 1]
        fill_covariance(columns, table, data, own, last, misfit, rules, pairs, runs, squares, parts, doubt, sigma)
        variance, naive = known_at(columns, table, data[1], own, last, timed, rules[0], sigma, rules[4], at)
        level = variance / naive
        if way >= LIMIT and not level > 0.0:  # nothing but a ramp is left, which does not scatter
            return True, np.nan, level
    return True, x, level
