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

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.clustered import (
    Clustered,
    Members,
    clustered,
    clustered_contrasts,
    clustered_each,
    contrasts_each,
    members_of,
)
from ....statistics.intervals import coverage_factor
from ....statistics.least_squares import APART, Decomposed, Fit, decompose, fit, fit_each, times
from ....statistics.polynomial import Polynomial
from ....statistics.random_offsets import fit_numbered
from ._kernels_cells import fill_bases, fill_designs
from .cells import Cells, Indices, Once

Level = Literal["run", "ramp", "block"]

PATH_ORDER = 2  # of D
BLOCKS = 6  # stretches of a ramp
GROWN = 2.0  # times the variance of P that a lag in the fit may cost
ENOUGH = 3  # bins seen on both paths that an order of D needs


class Scatter(NamedTuple):
    """What the members of the highest level that was repeated disagree about; found when it is wanted."""

    cells: Cells
    order: int  # Of P
    fit: Fit
    path_fit: Fit
    once: Once  # Of combinations of P

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
        rows = np.eye(self.order + 1)
        return self.once(_named(rows), lambda: _contrasts(self.of_fit, rows, 0))

    @property
    def covariance(self) -> Array:
        """Covariance of the coefficients of P."""
        return self.once("covariance", lambda: self.each[0])

    @property
    def of_path_fit(self) -> Clustered:
        """Of D."""
        if self.path_fit is self.fit:
            return self.of_fit
        return self.once("path", lambda: clustered(self.path_fit, self.members))

    @property
    def _judged(self) -> tuple[Level, Indices, Clustered]:
        return self.once("judged", self._found)

    def _found(self) -> tuple[Level, Indices, Clustered]:
        for level, clusters in levels(self.cells):
            found = clustered(self.fit, members(self.cells, level, clusters))
            if level == "block" or np.all(_contrasts(found, np.eye(self.order + 1), 0)[1] > 0.0):
                return level, clusters, found
        raise AssertionError("blocks come last")


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

    @classmethod
    def of_own(cls, **fields: object) -> Law:
        """Return a law of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(fields)
        return found

    @cached_property
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

    @cached_property
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
        return self.scatter.once(_named(rows), lambda: _contrasts(self.scatter.of_fit, rows, 0))

    def know_contrasts(self, rows: Array, found: tuple[Array, Array]) -> None:
        """Remember what `contrasts` gives of some rows: part of what was found of more of them."""
        self.scatter.once.keep(_named(rows), found)

    def path_contrasts(self, rows: Array) -> tuple[Array, Array, Array]:
        """Values, covariance and degrees of freedom of combinations of D."""
        start, found = self.order + 1, self.scatter.of_path_fit
        covariance, dof = self.scatter.once(("path", *_named(rows)), lambda: _contrasts(found, rows, start))
        return rows @ self.path_fit.coefficients[start:], covariance, dof


def _named(rows: Array) -> tuple[object, ...]:
    return rows.shape, rows.tobytes()


def _contrasts(found: Clustered, rows: Array, start: int) -> tuple[Array, Array]:
    """Covariance and degrees of freedom of combinations of the coefficients from one on."""
    return found.contrasts(_whole(rows, found, start))


def _whole(rows: Array, found: Clustered, start: int) -> Array:
    whole = np.zeros((*rows.shape[:-1], found.fit.coefficients.size))
    whole[..., start : start + rows.shape[-1]] = rows
    return whole


def law_of(cells: Cells, order: int, alone: Fit | None = None) -> Law:
    """Return the law of a sensor with a polynomial of a given order; ``alone``: the fit without the lag, where known.

    Raises
    ------
    DataError
        If the cells are fewer than the coefficients, do not tell them apart, or show no scatter.
    """
    law = unjudged_law_of(cells, order, alone)
    _ = law.level  # refused here, not where it is wanted
    return law


def unjudged_law_of(cells: Cells, order: int, alone: Fit | None = None) -> Law:
    """Return the same for its values alone: its scatter is found when it is wanted."""
    found = unjudged_laws_of([cells], order, None if alone is None else [alone])[0]
    if isinstance(found, DataError):
        raise found
    return found


def unjudged_laws_of(cells: Sequence[Cells], order: int, alone: Sequence[Fit] | None = None) -> list[Law | DataError]:
    """Return such laws of several sensors, or why one has none; those with as many cells of one run are fitted at once.

    Of the sensors of a thermometer the design is the same, of others it has the same shape.
    """
    found: dict[int, Law | DataError] = {}
    for at in gathered(_shape(one) for one in cells):
        own = [cells[i] for i in at]
        fits = None if alone is None else [alone[i] for i in at]
        try:
            found.update(zip(at, _alike(own, order, fits), strict=True))
        except DataError as error:
            if len(at) == 1:
                found[at[0]] = error
                continue
            for i in at:  # one of them is refused
                found[i] = unjudged_laws_of([cells[i]], order, None if alone is None else [alone[i]])[0]
    return [found[i] for i in range(len(cells))]


def gathered(kinds: Iterable[Hashable]) -> list[list[int]]:
    """Return the numbers of what is of one kind, kind by kind."""
    found: dict[Hashable, list[int]] = {}
    for i, kind in enumerate(kinds):
        found.setdefault(kind, []).append(i)
    return list(found.values())


def _shape(cells: Cells) -> Hashable:
    """Return what designs of one shape have in common; cells of several runs are by themselves."""
    if cells.runs >= 2:
        return id(cells)
    return cells.once("shape", lambda: (len(cells), path_order_of(cells), cells.paths_repeated))


def _alike(cells: Sequence[Cells], order: int, alone: Sequence[Fit] | None) -> list[Law]:
    first, path_order = cells[0], path_order_of(cells[0])
    known: dict[tuple[int, int], _Designs] = {}
    if alone is None:
        names = [f"T_{k}" for k in range(order + 1)] + [f"D_{k}" for k in range(path_order + 1)]
        alone = _fitted(cells, order, path_order, names, known=known)
    if path_order < 0:
        of_p = alone
    elif first.paths_repeated:
        of_p = _with_lag(cells, alone, order, max(path_order, order - 1), known)
    else:
        of_p = _fitted(cells, order, -1)
    return [
        Law.of_own(cells=one, order=order, path_order=path_order, domain=one.range, fit=fitted, path_fit=plain,
                   scatter=Scatter(one, order, fitted, plain, Once()), higher=None)
        for one, fitted, plain in zip(cells, of_p, alone, strict=True)
    ]  # fmt: skip


def _fitted(
    cells: Sequence[Cells],
    order: int,
    path_order: int,
    names: Sequence[str] | None = None,
    lags: Array | None = None,
    known: dict[tuple[int, int], _Designs] | None = None,
) -> list[Fit]:
    """Return the fits of P and D, and of lags by their columns, shape (s, c), to cells of one shape.

    ``known``: designs that were decomposed before, by their orders.
    """
    if cells[0].runs >= 2:
        one = cells[0]
        columns = design(one, order, path_order)
        columns = columns if lags is None else np.column_stack([columns, lags[0]])
        return [fit_numbered(columns, one.reading, one.weight, one.run_number, names)]
    y = np.array([one.reading for one in cells]) * np.array([one.root for one in cells])
    if y.shape[1] <= order + path_order + 2 or not np.isfinite(y).all():  # said as any fit says it
        return [fit(design(one, order, path_order) * one.root[:, None], row, names=names)
                for one, row in zip(cells, y, strict=True)]  # fmt: skip
    known = {} if known is None else known
    if (order, path_order) not in known:
        known[order, path_order] = _decomposed(cells, order, path_order, names)
    decomposed, of = known[order, path_order]
    if lags is not None:
        decomposed = decomposed.with_columns(of, lags * np.array([one.root for one in cells]))
        of, names = np.arange(len(cells)), None
    labels = names or [f"column {i}" for i in range(decomposed.design.shape[2])]
    return fit_each(decomposed, of, y, labels)


_Designs = tuple[Decomposed, NDArray[np.intp]]  # of thermometers, and the number of that of each sensor


def _decomposed(cells: Sequence[Cells], order: int, path_order: int, names: Sequence[str] | None) -> _Designs:
    """Return the designs of P and D of cells of one shape, decomposed: once for those of one thermometer."""
    kinds = gathered(id(one.once) for one in cells)
    own = [cells[at[0]] for at in kinds]
    key, labels = ("decomposed", order, path_order), names or [f"column {i}" for i in range(order + path_order + 2)]

    def together() -> Decomposed:
        white = designs(own, order, path_order, np.array([one.root for one in own]))
        basis, (m, _, p) = white.copy(), white.shape
        transform, length = np.empty((m, p, p)), np.empty((m, p))
        if fill_bases(basis, transform, length) > APART:
            return Decomposed(white, basis, transform, length)
        return decompose(white, labels)  # which names what it cannot tell

    number = np.empty(len(cells), dtype=np.intp)
    for k, at in enumerate(kinds):
        number[at] = k
    return own[0].once(key, together) if len(own) == 1 else together(), number


def _with_lag(
    cells: Sequence[Cells],
    alone: Sequence[Fit],
    order: int,
    path_order: int,
    known: dict[tuple[int, int], _Designs] | None = None,
) -> list[Fit]:
    """Return fits with a thermal lag in them, where the cells tell it apart; else those without.

    Where warming and cooling went at different rates, or over different ranges, a lag does not cancel midway. It is in
    where it costs little, or where the runs agree that it is not zero.
    """
    timed = [i for i, one in enumerate(cells) if order and np.isfinite(one.rate).all()]
    chosen = list(alone)
    if not timed:
        return chosen
    lags = lag_columns([cells[i] for i in timed], np.array([alone[i].coefficients[: order + 1] for i in timed]))
    try:
        own = known if len(timed) == len(cells) else None
        found = _fitted([cells[i] for i in timed], order, path_order, lags=lags, known=own)
    except DataError:
        if len(cells) == 1:
            return chosen
        return [_with_lag([one], [plain], order, path_order)[0] for one, plain in zip(cells, alone, strict=True)]
    sizes = [np.sum(np.array([one.transform[: order + 1] for one in fits]) ** 2, axis=2)
             for fits in (found, [alone[i] for i in timed])]  # fmt: skip
    cheap = np.all(sizes[0] / sizes[1] < GROWN, axis=1)
    for i, one, keep in zip(timed, found, cheap.tolist(), strict=True):
        if keep or (cells[i].runs >= 2 and _resolved(one, cells[i])):
            chosen[i] = one
    return chosen


def _resolved(found: Fit, cells: Cells) -> bool:
    """Whether the runs agree that the lag of a fit, its last coefficient, is not zero."""
    row = np.eye(found.coefficients.size)[-1:]
    covariance, dof = clustered_contrasts(found, members(cells, "run", cells.run), row)
    return bool(
        dof[0] > 0.0 and abs(found.coefficients[-1]) > coverage_factor(float(dof[0])) * np.sqrt(covariance[0, 0])
    )


def lag_column(cells: Cells, coefficients: Array) -> Array:
    """Return what a lag of one second changes each cell by, with the slope of a first P, shape (c,)."""
    return np.asarray(lag_columns([cells], coefficients[None])[0])


def lag_columns(cells: Sequence[Cells], coefficients: Array) -> Array:
    """Return the same of several sensors: slopes by P of shape (s, order + 1); shape (s, c)."""
    ends, at = _ends(cells), _scaled_each(cells)
    slope = times(_rising(coefficients.shape[1] - 1).T, coefficients)
    rows = _series(at, slope.shape[1] - 1)
    rate = np.array([one.rate for one in cells])
    return np.asarray(-times(rows, slope) * (2.0 / (ends[:, 1:] - ends[:, :1])) * rate)


def judge(laws: Sequence[Law]) -> list[DataError | None]:
    """Find the scatter of laws, what is wanted of one alike at once; return why it is refused, law by law."""
    _find_blocks([one.cells for one in laws])
    first = [levels(one.cells)[0] for one in laws]
    kinds = gathered(
        (level, one.order, one.fit.basis.shape, one.path_fit.basis.shape, len(_starts(one, level, clusters)))
        for one, (level, clusters) in zip(laws, first, strict=True)
    )
    refused: list[DataError | None] = [None] * len(laws)
    for at in kinds:
        level, clusters = first[at[0]]
        own = [laws[i] for i in at]
        if len(_starts(own[0], level, clusters)) >= 2:
            by = [members(one.cells, *first[i]) for i, one in zip(at, own, strict=True)]
            ways = clustered_each([one.path_fit for one in own], by, [_design_of(one.cells) for one in own])
            found = ways
            if any(one.fit is not one.path_fit for one in own):
                found = clustered_each([one.fit for one in own], by)
            known = [True] * len(at) if level == "block" else _known(found, own[0].order)
            for i, one, mine, way, keep in zip(at, own, found, ways, known, strict=True):
                if keep:
                    one.scatter.once.keep("judged", (*first[i], mine))
                    one.scatter.once.keep("path", way)
        for i in at:
            try:
                _ = laws[i].level
            except DataError as error:
                refused[i] = error
    return refused


def _design_of(cells: Cells) -> Hashable:
    """Return what cells share whose designs are the same; those of several runs are whitened by their readings."""
    return id(cells.once) if cells.runs < 2 else (id(cells.once), cells.sensor)


def _starts(law: Law, level: Level, clusters: Indices) -> Indices:
    return members(law.cells, level, clusters).starts


def _known(found: Sequence[Clustered], order: int) -> list[bool]:
    """Whether the members of a level tell all of P, fit by fit."""
    rows = np.broadcast_to(_whole(np.eye(order + 1), found[0], 0), (len(found), order + 1, found[0].fit.basis.shape[1]))
    return [bool(one) for one in np.all(contrasts_each(found, rows)[1] > 0.0, axis=1)]


def contrasts_of(
    laws: Sequence[Law], rows: Sequence[Array], paths: bool = False, free: Sequence[int] | None = None
) -> list[tuple[Array, Array]]:
    """Return covariance and degrees of freedom of combinations of P, or of D, of judged laws, those alike at once.

    ``free``: of how many of the first rows of each the degrees of freedom are wanted; None for all.
    """
    every: dict[int, tuple[Array, Array]] = {}
    scatters = [one.scatter.of_path_fit if paths else one.scatter.of_fit for one in laws]
    starts = [one.order + 1 if paths else 0 for one in laws]
    counts = [len(one) for one in rows] if free is None else free
    for at in gathered((one.score.shape, own.shape, k, m)
                       for one, own, k, m in zip(scatters, rows, starts, counts, strict=True)):  # fmt: skip
        whole = _whole(np.array([rows[i] for i in at]), scatters[at[0]], starts[at[0]])
        covariance, dof = contrasts_each([scatters[i] for i in at], whole, counts[at[0]])
        every.update(zip(at, zip(covariance, dof, strict=True), strict=True))
    return [every[i] for i in range(len(laws))]


def path_order_of(cells: Cells) -> int:
    """Return the order of D that the bins seen on both paths carry; -1 with one path only."""
    shared = cells.shared_bins
    return min(PATH_ORDER, len(shared) // ENOUGH) if len(shared) else -1


def design(cells: Cells, order: int, path_order: int) -> Array:
    """Return what the cells see of P and D, shape (c, order + 1 + path_order + 1)."""
    return cells.once(("design", order, path_order), lambda: designs([cells], order, path_order)[0])


def designs(cells: Sequence[Cells], order: int, path_order: int, roots: Array | None = None) -> Array:
    """Return the same of several thermometers with as many cells, shape (u, c, order + 1 + path_order + 1).

    ``roots``, shape (u, c): what each row is multiplied by.
    """
    at, ends = _scaled_each(cells), _ends(cells)
    spread = np.array([one.spread for one in cells]) * (2.0 / (ends[:, 1:] - ends[:, :1])) ** 2
    out = np.empty((*at.shape, order + path_order + 2))
    path = np.array([one.path for one in cells], dtype=np.float64)
    fill_designs(at, spread, path, np.ones(at.shape) if roots is None else roots, order, path_order, out)
    return out


def _ends(cells: Sequence[Cells]) -> Array:
    """Return the ends of the temperatures that are used, shape (s, 2)."""
    return np.array([one.range for one in cells])


def _scaled_each(cells: Sequence[Cells]) -> Array:
    """Return the temperature of each cell from -1 to 1 over the range of its sensor, shape (s, c)."""
    low, high = _ends(cells).T[..., None]
    return np.asarray((2.0 * np.array([one.temperature for one in cells]) - low - high) / (high - low))


def series_each(cells: Sequence[Cells], order: int) -> Array:
    """Return the row of a series at the temperature of each cell of several sensors, shape (s, c, order + 1)."""
    return _series(_scaled_each(cells), order)


def slopes_of(laws: Sequence[Law]) -> Array:
    """Return what P of laws of one order rises by with the temperature, as such a series, shape (s, order + 1)."""
    order, ends = laws[0].order, np.array([one.domain for one in laws])
    slope = np.zeros((len(laws), order + 1))
    if order:
        slope[:, :-1] = times(_rising(order).T, np.array([one.coefficients for one in laws]))
    return np.asarray(slope * 2.0 / (ends[:, 1:] - ends[:, :1]))


@cache
def _rising(order: int) -> Array:
    """Return what first derivatives of the series are of the series, shape (order + 1, order)."""
    return np.asarray(chebyshev.chebder(np.eye(order + 1)).T)


def series_rows(temperature: ArrayLike, domain: tuple[float, float], order: int) -> Array:
    """Return the row of a series at each temperature, shape (m, order + 1)."""
    return np.atleast_2d(_series(_scaled(temperature, domain), order))


def series_rows_each(temperatures: Array, domains: Array, order: int) -> Array:
    """Return the rows of several series, at temperatures (u, m) each over its range, (u, 2): (u, m, order + 1)."""
    low, high = domains.T[..., None]
    return _series((2.0 * temperatures - low - high) / (high - low), order)


def _series(at: Array, order: int) -> Array:
    """Return Chebyshev polynomials up to an order, of temperatures from -1 to 1: shape (..., order + 1)."""
    rows: Array = np.empty((*at.shape, order + 1))
    rows[..., 0] = 1.0
    rows[..., 1:2] = at[..., None]
    for k in range(2, order + 1):
        rows[..., k] = 2.0 * at * rows[..., k - 1] - rows[..., k - 2]
    return rows


def _scaled(temperature: ArrayLike, domain: tuple[float, float]) -> Array:
    lo, hi = domain
    return np.asarray((2.0 * np.asarray(temperature, dtype=float) - lo - hi) / (hi - lo))


def levels(cells: Cells) -> Sequence[tuple[Level, Indices]]:
    """Levels that were repeated, the highest first; blocks always are."""
    return cells.once("levels", lambda: _levels(cells))


def _levels(cells: Cells) -> Sequence[tuple[Level, Indices]]:
    """Levels that were repeated, the highest first; blocks always are."""
    found: list[tuple[Level, Indices]] = []
    if cells.runs >= 2:
        found.append(("run", cells.run))
    elif _ramps_repeated(cells):
        found.append(("ramp", cells.ramp))
    return [*found, ("block", blocks(cells))]


def _ramps_repeated(cells: Cells) -> bool:
    """Whether each path was seen on two ramps or more."""
    fewest = 2 * len(cells.ways)
    return cells.ramps >= fewest and all(len(np.unique(cells.ramp[cells.path == way])) >= 2 for way in cells.ways)


def _find_blocks(cells: Sequence[Cells]) -> None:
    """Find levels and members of those thermometers where nothing was repeated, at once."""
    own = [one for one in {id(one.once): one for one in cells}.values()
           if "levels" not in one.once and one.runs < 2 and not _ramps_repeated(one)]  # fmt: skip
    if not own:
        return
    labels = [blocks(one) for one in own]
    first = np.cumsum([0, *map(len, labels)])
    unit = np.repeat(np.arange(len(own)), np.diff(first))
    flat = np.concatenate(labels)
    flat = unit * (int(flat.max()) + 1) + flat
    order = np.argsort(flat, kind="stable")
    starts = np.flatnonzero(np.diff(flat[order], prepend=-1))
    ends = np.searchsorted(starts, first)
    for i, (one, by) in enumerate(zip(own, labels, strict=True)):
        mine, its = order[first[i] : first[i + 1]] - first[i], starts[ends[i] : ends[i + 1]] - first[i]
        one.once.keep("levels", [("block", by)])
        one.once.keep(("members", "block"), Members(mine, its))


def members(cells: Cells, level: Level, clusters: Indices) -> Members:
    """Return cells by their member of a level, of labels shape (c,)."""
    return cells.once(("members", level), lambda: members_of(clusters))


def blocks(cells: Cells) -> Indices:
    """Return the stretch of its ramp that each cell lies in: ``BLOCKS`` over the range, numbered over all ramps."""
    lo, hi = cells.range
    at = np.clip(((cells.temperature - lo) / (hi - lo) * BLOCKS).astype(np.int64), 0, BLOCKS - 1)
    return np.asarray(cells.ramp * BLOCKS + at)
