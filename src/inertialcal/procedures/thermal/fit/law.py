"""The law of one sensor: its bias over temperature, midway between the paths, fitted to cells.

::

    y = P(T) + s D(T) / 2 + offset of the run + error         s: 1 warming, -1 cooling

P is the polynomial that is wanted, D the difference of the paths: quadratic, or less where few bins were seen on both.
Both are Chebyshev series over the range of the cells. What a cell with a finite spread of temperature sees of them is
their mean over it, to second order. With one path only there is no D, and P holds on that path.

Where one run alone saw a path, no other tells D from the offset of that run. P is fitted without D then: it lies
between the paths, and all that the runs differ by counts as scatter between them. Whatever part of it D is, the
interval holds at least as often as it says: a difference of the paths makes the scatter larger, never smaller.

Scatter, and what the covariance is made of, from the highest level that was repeated:

run
    what the power-ups disagree about (CR2, Satterthwaite degrees of freedom): offsets, slopes, drift, all of it.
ramp
    one run, two ramps or more on each path: what the ramps disagree about.
block
    else: six stretches of each ramp. Noise and drift that are slower than a stretch are not in it.

It is assumed that power-ups are alike and independent, and that P, D, the lag and the start-up are the same in all.
What all runs share no scatter shows: three such ways in which real tests break this, each simulated (five runs, 100
seeds). A term of P that was not chosen: the slope's interval held 53 %, with ``higher`` 94 %. A lag of 300 s where the
paths went at different rates: slope 77 %, with the lag in the fit 98 %. A start-up longer than the stay before the
first ramp (3600 s, 1800 s): slope 55 %, lag 17 %; it has the remark ``warm_up_long``.

Where a combination rests on one run, or ramp, alone, it has no degrees of freedom at that level: the level below is
taken where it can tell all of P, else the value stays without uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.clustered import (
    Clustered,
    Members,
    Shares,
    clustered,
    clustered_contrasts,
    members_of,
    with_shares,
)
from ....statistics.intervals import coverage_factor
from ....statistics.least_squares import Fit, decompose, fit
from ....statistics.polynomial import Polynomial
from ....statistics.random_offsets import fit_numbered
from .cells import Cells, Indices, Once

Level = Literal["run", "ramp", "block"]

PATH_ORDER = 2  # of D
BLOCKS = 6  # stretches of a ramp
GROWN = 2.0  # times the variance of P that a lag in the fit may cost
ENOUGH = 3  # bins seen on both paths that an order of D needs


@dataclass(frozen=True, eq=False)
class Scatter:
    """What the members of the highest level that was repeated disagree about; found when it is wanted."""

    cells: Cells
    order: int  # Of P
    fit: Fit
    path_fit: Fit
    once: Once = field(default_factory=Once)  # Of combinations of P

    @property
    def level(self) -> Level:
        """Highest level that was repeated and tells all of P."""
        return self._judged[0]

    @property
    def clusters(self) -> Indices:
        """Member of the level that each cell belongs to, shape (c,)."""
        return self._judged[1]

    @property
    def members(self) -> Members:
        """Cells by their member of the level."""
        return members(self.cells, self.level, self.clusters)

    @property
    def of_fit(self) -> Clustered:
        """Of P."""
        return self._judged[2]

    @property
    def each(self) -> tuple[Array, Array]:
        """Covariance of the coefficients of P, and degrees of freedom of each; dof 0: not known."""
        return _contrasts(self.of_fit, np.eye(self.order + 1), 0)

    @cached_property
    def of_path_fit(self) -> Clustered:
        """Of D."""
        return self.of_fit if self.path_fit is self.fit else self._clustered(self.path_fit, self.level, self.clusters)

    @cached_property
    def _judged(self) -> tuple[Level, Indices, Clustered]:
        for level, clusters in _levels(self.cells):
            found = self._clustered(self.fit, level, clusters)
            if level == "block" or np.all(_contrasts(found, np.eye(self.order + 1), 0)[1] > 0.0):
                return level, clusters, found
        raise AssertionError("blocks come last")

    def _clustered(self, fit: Fit, level: Level, clusters: Indices) -> Clustered:
        own = members(self.cells, level, clusters)
        if self.cells.runs > 1 or fit is not self.path_fit or len(own.starts) < 2:
            return clustered(fit, own)
        return with_shares(fit, self.cells.once(("shares", level, self.order), lambda: Shares(own, fit.basis)))


@dataclass(frozen=True, eq=False)
class Law:
    """Fit of one sensor."""

    cells: Cells  # That it was fitted to
    order: int  # Of P
    path_order: int  # Of D; -1 where there is none
    domain: tuple[float, float]  # Temperatures where P holds [degC]
    # Coefficients of P, then of D [unit of the readings] and the lag where they are in; of whitened cells
    fit: Fit
    path_fit: Fit  # The same with D, without the lag: its D is what the paths differ by, whatever the cause
    scatter: Scatter  # What P and D are judged by
    higher: Law | None = None  # With a P of an order that was not chosen, to see what the choice changes

    @property
    def coefficients(self) -> Array:
        """Of P, shape (order + 1,)."""
        return self.fit.coefficients[: self.order + 1]

    @property
    def polynomial(self) -> Polynomial:
        """P with its covariance; its dof are those of the coefficient with the fewest."""
        covariance, dof = self.scatter.each
        return Polynomial(self.coefficients, covariance, float(dof.min()), self.domain)

    @property
    def level(self) -> Level:
        """Highest level that was repeated and tells all of P."""
        return self.scatter.level

    @property
    def clusters(self) -> Indices:
        """Member of the level that each cell belongs to, shape (c,)."""
        return self.scatter.clusters

    @property
    def midway(self) -> bool:
        """Whether P lies midway between two paths."""
        return self.path_order >= 0

    def basis(self, temperature: ArrayLike) -> Array:
        """Return the row of P at each temperature, shape (m, order + 1)."""
        return series_rows(temperature, self.domain, self.order)

    def path_basis(self, temperature: ArrayLike) -> Array:
        """Return the row of D at each temperature, shape (m, path_order + 1)."""
        return series_rows(temperature, self.domain, self.path_order)

    def changed(self, temperature: ArrayLike) -> Array:
        """Return P of the higher order less this P at each temperature, shape (m,); zero where the order was given."""
        if self.higher is None:
            return np.zeros(np.size(temperature))
        high = self.higher
        return np.asarray(high.basis(temperature) @ high.coefficients - self.basis(temperature) @ self.coefficients)

    def contrasts(self, rows: Array) -> tuple[Array, Array]:
        """Covariance and degrees of freedom of combinations of P, shapes (m, m) and (m,); dof 0: not known."""
        found = self.scatter.of_fit
        return self.scatter.once((rows.shape, rows.tobytes()), lambda: _contrasts(found, rows, 0))

    def path_contrasts(self, rows: Array) -> tuple[Array, Array, Array]:
        """Values, covariance and degrees of freedom of combinations of D."""
        covariance, dof = _contrasts(self.scatter.of_path_fit, rows, self.order + 1)
        return rows @ self.path_fit.coefficients[self.order + 1 :], covariance, dof


def _contrasts(found: Clustered, rows: Array, start: int) -> tuple[Array, Array]:
    """Covariance and degrees of freedom of combinations of the coefficients from one on."""
    whole = np.zeros((len(rows), found.fit.coefficients.size))
    whole[:, start : start + rows.shape[1]] = rows
    return found.contrasts(whole)


def law_of(cells: Cells, order: int, alone: Fit | None = None) -> Law:
    """Return the law of a sensor with a polynomial of a given order; ``alone``: the fit without the lag, where known.

    Raises
    ------
    DataError
        If the cells are fewer than the coefficients, do not tell them apart, or show no scatter.
    """
    return judged(unjudged_law_of(cells, order, alone))


def judged(law: Law) -> Law:
    """Return a law whose scatter is known: refused here, not where it is wanted."""
    _ = law.level
    return law


def unjudged_law_of(cells: Cells, order: int, alone: Fit | None = None) -> Law:
    """Return the same for its values alone: its scatter is found when it is wanted."""
    path_order = path_order_of(cells)
    domain = cells.range
    if alone is None:
        names = [f"T_{k}" for k in range(order + 1)] + [f"D_{k}" for k in range(path_order + 1)]
        alone = _fitted(cells, order, path_order, domain, names)
    if path_order < 0:
        of_p = alone
    elif cells.paths_repeated:
        of_p = _with_lag(cells, alone, order, max(path_order, order - 1), domain)
    else:
        of_p = _fitted(cells, order, -1, domain)
    return Law(cells, order, path_order, domain, of_p, alone, Scatter(cells, order, of_p, alone))


def _fitted(
    cells: Cells,
    order: int,
    path_order: int,
    domain: tuple[float, float],
    names: Sequence[str] | None = None,
    lag: Array | None = None,
) -> Fit:
    """Return the fit of P and D, and of a lag by its column; of one run with a decomposition that all sensors share."""
    columns = design(cells, order, path_order, domain)
    if cells.runs >= 2:
        columns = columns if lag is None else np.column_stack([columns, lag])
        return fit_numbered(columns, cells.reading, cells.weight, cells.run_number, names)
    root = cells.once("root", lambda: np.sqrt(cells.weight))
    white = columns * root[:, None]
    if len(white) <= white.shape[1]:  # too few cells, said as any fit says it
        return fit(white, cells.reading * root, names=names)
    labels = names or [f"column {i}" for i in range(white.shape[1])]
    whole = cells.once(("decomposed", order, path_order, domain), lambda: decompose(white, labels))
    if lag is not None:
        whole, names = whole.with_column(lag * root), None
    return fit(whole.design, cells.reading * root, names=names, decomposed=whole)


def _with_lag(cells: Cells, alone: Fit, order: int, path_order: int, domain: tuple[float, float]) -> Fit:
    """Return the fit with a thermal lag in it, where the cells tell it apart; else that without.

    Where warming and cooling went at different rates, or over different ranges, a lag does not cancel midway. It is in
    where it costs little, or where the runs agree that it is not zero.
    """
    if order == 0 or not np.isfinite(cells.rate).all():
        return alone
    lag = lag_column(cells, alone.coefficients[: order + 1], domain)
    try:
        found = _fitted(cells, order, path_order, domain, lag=lag)
    except DataError:
        return alone
    grown = np.sum(found.transform[: order + 1] ** 2, axis=1) / np.sum(alone.transform[: order + 1] ** 2, axis=1)
    if np.all(grown < GROWN):
        return found
    if cells.runs < 2:
        return alone
    covariance, dof = clustered_contrasts(found, members(cells, "run", cells.run), np.eye(found.coefficients.size)[-1:])
    resolved = dof[0] > 0.0 and abs(found.coefficients[-1]) > coverage_factor(float(dof[0])) * np.sqrt(covariance[0, 0])
    return found if resolved else alone


def lag_column(cells: Cells, coefficients: Array, domain: tuple[float, float]) -> Array:
    """Return what a lag of one second changes each cell by, with the slope of a first P, shape (c,)."""
    at = cells.once(("scaled", domain), lambda: _scaled(cells.temperature, domain))
    slope = chebyshev.chebval(at, chebyshev.chebder(coefficients))
    return np.asarray(-slope * 2.0 / (domain[1] - domain[0]) * cells.rate)


def path_order_of(cells: Cells) -> int:
    """Return the order of D that the bins seen on both paths carry; -1 with one path only."""
    shared = cells.shared_bins
    return min(PATH_ORDER, len(shared) // ENOUGH) if len(shared) else -1


def design(cells: Cells, order: int, path_order: int, domain: tuple[float, float]) -> Array:
    """Return what the cells see of P and D, shape (c, order + 1 + path_order + 1)."""

    def found() -> Array:
        rows = _mean_rows(cells, max(order, path_order), domain)
        paths = 0.5 * cells.path[:, None] * rows[:, : path_order + 1]
        return np.hstack([rows[:, : order + 1], paths])

    return cells.once(("design", order, path_order, domain), found)


def _mean_rows(cells: Cells, order: int, domain: tuple[float, float]) -> Array:
    """Chebyshev rows, mean over the spread of each cell to second order."""
    s = _scaled(cells.temperature, domain)
    rows = chebyshev.chebvander(s, order)
    if order < 2:
        return np.asarray(rows)
    spread = cells.spread * (2.0 / (domain[1] - domain[0])) ** 2
    return np.asarray(rows + 0.5 * spread[:, None] * (rows[:, : order - 1] @ _bent(order)))


@cache
def _bent(order: int) -> Array:
    """Return what second derivatives of the series are of the series, shape (order - 1, order + 1)."""
    return np.asarray(chebyshev.chebder(np.eye(order + 1), 2))


def series_rows(temperature: ArrayLike, domain: tuple[float, float], order: int) -> Array:
    """Return the row of a series at each temperature, shape (m, order + 1)."""
    return np.atleast_2d(chebyshev.chebvander(_scaled(temperature, domain), order))


def _scaled(temperature: ArrayLike, domain: tuple[float, float]) -> Array:
    lo, hi = domain
    return np.asarray((2.0 * np.asarray(temperature, dtype=float) - lo - hi) / (hi - lo))


def _levels(cells: Cells) -> Sequence[tuple[Level, Indices]]:
    """Levels that were repeated, the highest first; blocks always are."""
    found: list[tuple[Level, Indices]] = []
    if cells.runs >= 2:
        found.append(("run", cells.run))
    elif all(len(np.unique(cells.ramp[cells.path == way])) >= 2 for way in cells.ways):
        found.append(("ramp", cells.ramp))
    return [*found, ("block", blocks(cells))]


def members(cells: Cells, level: Level, clusters: Indices) -> Members:
    """Return cells by their member of a level, of labels shape (c,)."""
    return cells.once(("members", level), lambda: members_of(clusters))


def blocks(cells: Cells) -> Indices:
    """Return the stretch of its ramp that each cell lies in: ``BLOCKS`` over the range, numbered over all ramps."""
    lo, hi = cells.range
    at = np.clip(((cells.temperature - lo) / (hi - lo) * BLOCKS).astype(np.int64), 0, BLOCKS - 1)
    return np.asarray(cells.ramp * BLOCKS + at)
