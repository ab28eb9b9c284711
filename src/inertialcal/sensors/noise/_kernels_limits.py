"""Compiled chains of an upper limit and of an end of an interval: arrays in, preallocated arrays out, no checks.

``columns`` (k, p) are Allan variances of linear terms and lines of size 1, lines from ``lines`` on; rows of ``table``
(g, k) those of Gauss-Markov noise; ``powers`` (p + 1) are all powers, that of Gauss-Markov noise last, whose
correlation time lies at ``position`` in the table. ``wanted`` (p + 1) says which take part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ._kernels import crossing_root, fill_known, fill_spread, held_cost, limit_root, scored, searched

BY = 0.05  # rows of the table, to either side, for a slope


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
        row, after = np.empty(k), np.empty(k)
        interpolate(table, position, row)
        for t in range(k):
            every[t, p] = row[t]
        if timed:
            interpolate(table, position + BY, after)
            interpolate(table, position - BY, row)
            slopes = np.empty(k)
            for t in range(k):
                slopes[t] = powers[p] * (after[t] - row[t]) / (2.0 * BY) * per_e
    fill_known(every, powers, slopes, w, sigma, least, covariance, naive)


@compiled
def known_at(
    columns: Array, table: Array, w: Array, powers: Array, position: float, timed: bool, per_e: float, sigma: Array,
    least: float, at: int,
) -> tuple[float, float]:  # fmt: skip
    """Return standard uncertainty and stretch of a power."""
    q, column = 0, 0
    for i in range(len(powers)):
        q += int(powers[i] > 0.0)
        column += int(powers[i] > 0.0 and i < at)
    q += int(timed and powers[-1] > 0.0)
    covariance, naive = np.empty((q, q)), np.empty((q, q))
    fill_bread(columns, table, w, powers, position, timed, per_e, sigma, least, covariance, naive)
    return float(np.sqrt(covariance[column, column])), float(covariance[column, column] / naive[column, column])


@compiled
def hidden(
    columns: Array, table: Array, w: Array, powers: Array, position: float, at: int, share: float, per_e: float,
    sigma: Array, least: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the same of a power that is not there, by that ``share`` of the most that there is room for; else NaN."""
    k, p = columns.shape
    own, row, room = powers.copy(), np.empty(k), np.inf
    interpolate(table, position, row)
    for t in range(k):
        mean = powers[p] * row[t] if powers[p] > 0.0 else 0.0
        for i in range(p):
            mean += powers[i] * columns[t, i]
        ratio = mean / (columns[t, at] if at < p else row[t])
        if np.isnan(ratio):
            return np.nan, np.nan
        room = min(room, ratio)
    own[at] = share * room
    if not 0.0 < own[at] < np.inf:
        return np.nan, np.nan
    return known_at(columns, table, w, own, position, at < p, per_e, sigma, least, at)


@compiled
def _chosen(
    columns: Array, table: Array, wanted: NDArray[np.bool_], position: float, near: float, spacings: Array
) -> tuple[NDArray[np.int64], Array, float, float, Array]:
    """Return places of the terms, their columns, positions of the time that are searched, and how closely."""
    k, p = columns.shape
    places = np.flatnonzero(wanted)
    D, last = np.zeros((k, len(places))), len(table) - 1.0
    for j in range(len(places)):
        if places[j] < p:
            for t in range(k):
                D[t, j] = columns[t, places[j]]
    lo, hi = (max(position - near, 0.0), min(position + near, last)) if near > 0.0 else (position, position)
    return places, D, lo, hi, spacings[: (2 if hi > lo else 1) if wanted[p] else 0]


@compiled
def ruled_out(
    columns: Array, table: Array, s: Array, w: Array, wanted: NDArray[np.bool_], position: float, near: float,
    spacings: Array, at: int, u: float, named: float, stretch: float, missed: bool, tolerance: float, powers: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Fill powers of least cost where one of them is ruled out, see ``_kernels.limit_root``.

    Returns are the distance from the best power in u (NaN for nowhere), the best, the least cost, what the best lacks
    of being named [u], and the position in the table where it is ruled out.
    """
    places, D, lo, hi, steps = _chosen(columns, table, wanted, position, near, spacings)
    held, v, there = int(np.searchsorted(places, at)), np.zeros(len(places)), 0.0
    if len(steps) == 0:
        least = scored(D, s, w, -1, 0.0, v, False)
    else:
        least = searched(D, table, lo, hi, steps, s, w, -1, 0.0, v)[1]
    best = v[held]
    short = max(named - best, 0.0) / u if missed else 0.0
    x = limit_root(D, table, lo, hi, steps, s, w, held, best, u, least, stretch, short, missed, tolerance)
    v[:] = 0.0
    if len(steps) == 0:
        scored(D, s, w, held, best + x * u, v, False)
    elif x >= 0.0:
        there = searched(D, table, lo, hi, steps, s, w, held, best + x * u, v)[0]
    powers[:] = 0.0
    for j in range(len(places)):
        powers[places[j]] = v[j]
    return x, best, least, short, there


@compiled
def stretch_at(
    columns: Array, table: Array, w: Array, powers: Array, position: float, at: int, timed: bool, per_e: float,
    squares: Array, row: NDArray[np.int64], column: NDArray[np.int64], run: NDArray[np.int64],
    found: NDArray[np.bool_], lost: Array, by: Array, doubt: Array, out_of_sight: float, shape: float,
    tau: Array, alike: float, misfit: float, least: float,
) -> float:  # fmt: skip
    """Return the stretch of a power, of the covariance that powers imply: see ``fitting.spread``."""
    k, p = columns.shape
    own, left, markov = powers[:p].copy(), np.zeros(k if misfit > 0.0 else 0), np.empty(k)
    if powers[p] > 0.0:
        own = powers[powers > 0.0]
        interpolate(table, position, markov)
    for t in range(len(left)):
        for i in range(p):
            left[t] += misfit * powers[i] * columns[t, i]
        left[t] += misfit * powers[p] * markov[t] if powers[p] > 0.0 else 0.0
    sigma = np.empty((k, k))
    fill_spread(
        own, squares, row, column, run, found, lost, by, doubt, out_of_sight, shape, left, tau, alike, sigma
    )  # fmt: skip
    return known_at(columns, table, w, powers, position, timed, per_e, sigma, least, at)[1]


@compiled
def limit_from(
    columns: Array, table: Array, s: Array, w: Array, wanted: NDArray[np.bool_], position: float, near: float,
    spacings: Array, at: int, u: float, best: float, least: float, short: float, missed: bool, stretch: float,
    tolerance: float,
) -> float:  # fmt: skip
    """Return the distance from the best power at which it is ruled out, with a stretch of its own [u]."""
    places, D, lo, hi, steps = _chosen(columns, table, wanted, position, near, spacings)
    held = int(np.searchsorted(places, at))
    return limit_root(D, table, lo, hi, steps, s, w, held, best, u, least, stretch, short, missed, tolerance)


@compiled
def end_from(
    columns: Array, table: Array, s: Array, w: Array, wanted: NDArray[np.bool_], position: float, near: float,
    spacings: Array, at: int, per_e: float, start: float, first: float, least: float, step: float, target: float,
    furthest: float, tolerance: float, powers: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill powers of least cost where twice the cost has risen by the target, see ``_kernels.crossing_root``.

    Returns are the distance from ``first``, zero where the cost has risen there, NaN where it never does, and the
    position in the table.
    """
    places, D, lo, hi, steps = _chosen(columns, table, wanted, position, near, spacings)
    held, v, x, there = int(np.searchsorted(places, at)), np.zeros(len(places)), 0.0, 0.0
    cost = held_cost(D, table, lo, hi, steps, s, w, held, start * np.exp(first), v)
    if not 2.0 * (cost - least) >= target:
        x = crossing_root(
            D, table, lo, hi, steps, s, w, held, per_e, start, first, least, step, target, furthest, tolerance
        )
    powers[:] = 0.0
    if not np.isnan(x):
        v[:] = 0.0
        if len(steps) == 0:
            scored(D, s, w, held, start * np.exp(first + x), v, False)
        else:
            there = searched(D, table, lo, hi, steps, s, w, held, start * np.exp(first + x), v)[0]
        for j in range(len(places)):
            powers[places[j]] = v[j]
    return x, there
