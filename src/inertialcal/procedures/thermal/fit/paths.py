"""What differs between warming and cooling: path difference, hysteresis, thermal lag.

``path_difference`` is what the paths differ by, D of the law, mean over the temperatures that both have seen. It holds
whatever made them differ:

hysteresis
    the bias remembers which way the temperature came. It does not depend on how fast.
thermal lag
    the bias is behind the thermometer by a time: the difference is ``-2 lag P'(T) |dT/dt|``, in proportion to the rate.
drift
    the bias changes with time, and the paths are not at the same time.

One loop, warming and cooling once each, shows their sum and cannot say which it is: *unclear*. Two loops or more are
fitted together, with a drift linear in time of each run, the lag and the hysteresis::

    y = P(T) + s H(T) / 2 - lag P'(T) dT/dt + drift of the run * t + offset of the run

Where the design tells these apart (two rates of the ramps, or a stay at a steady temperature on a path, for the lag;
two loops for the drift), ``hysteresis`` is the mean of H: *yes* where its 95 % interval excludes zero, *no* where it
lies within ``no_hysteresis``, else *unclear*.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.clustered import clustered_contrasts
from ....statistics.intervals import ends, t_interval
from ....statistics.least_squares import fit
from .cells import Cells
from .law import Law, contrasts_of, design, gathered, lag_column, series_rows, series_rows_each

Word = Literal["yes", "no", "unclear"]

GRID = 41  # temperatures that a mean over the range is taken at
TWO_RATES = 1.5  # ratio of the rates of ramps that are two rates
MIXED = 400.0  # by how much the variance of the hysteresis may grow by the lag and the drift in the fit


class PathEffect(NamedTuple):
    """One figure of what differs between the paths."""

    value: float | None  # None where not estimated
    u: float | None = None  # None where not estimated
    dof: float | None = None  # None where not estimated
    reason: str = ""  # Why not

    @property
    def known(self) -> bool:
        """Whether there is a value with an uncertainty."""
        return self.value is not None and self.u is not None and self.dof is not None


TWO_RUNS = "needs two runs or more on each path"
ONE_PATH = PathEffect(None, reason="one path only was seen")


class Paths(NamedTuple):
    """What differs between warming and cooling."""

    difference: PathEffect  # Warming less cooling, mean over the range of both [unit of the readings]
    hysteresis: PathEffect  # The part of it that is neither lag nor drift [unit of the readings]
    lag: PathEffect  # [s]
    word: Word  # Whether there is hysteresis
    why: str  # In words
    loops: int  # Ramps of warming that a ramp of cooling of the same run goes with
    # Least and largest median rate of the ramps, without sign [degC/s]; empty where no time is known
    rates: tuple[float, ...]


class Separated(NamedTuple):
    """What differs between the paths whatever the drift, apart."""

    hysteresis: PathEffect
    lag: PathEffect
    loops: int


def find_differences(laws: Sequence[Law]) -> None:
    """Find what `paths_of` wants of several judged laws that lie midway between two paths, alike at once."""
    own = {(id(one.cells.once), one.path_order, one.domain): one for one in laws}
    for at in gathered(order for _, order, _ in own):
        alike = [[*own.values()][i] for i in at]
        domains, order = np.array([one.domain for one in alike]), alike[0].path_order
        low, high = np.array([one.cells.both or one.domain for one in alike]).T
        rows = series_rows_each(np.linspace(low, high, GRID, axis=-1), domains, order).mean(axis=1)
        for one, row in zip(alike, rows, strict=True):
            one.cells.once.keep(("mean over the paths", order, one.domain), row)
    rows = [_mean_over_paths(one, one.path_order) for one in laws]
    found = contrasts_of(laws, [row[None] for row in rows], paths=True)
    for law, row, (covariance, dof) in zip(laws, rows, found, strict=True):
        value, free = float(row @ law.path_fit.coefficients[law.order + 1 :]), float(dof[0])
        known = PathEffect(value, math.sqrt(covariance[0, 0]), free)
        law.scatter.once.keep("difference", known if free > 0.0 else PathEffect(value, reason=TWO_RUNS))


def paths_of(law: Law, apart: Separated, no_hysteresis: float | None = None) -> Paths:
    """Return what differs between the paths of one sensor."""
    rates = _rates(law.cells)
    if not law.midway:
        return Paths(ONE_PATH, ONE_PATH, ONE_PATH, "unclear", ONE_PATH.reason, apart.loops, rates)
    word, why = _told(apart.hysteresis, no_hysteresis)
    return Paths(_difference(law), apart.hysteresis, apart.lag, word, why, apart.loops, rates)


def separated(law: Law) -> Separated:
    """Return hysteresis and lag where the design tells them from each other and from drift."""
    loops = law.cells.loops
    return Separated(*(_separated(law, loops) if law.midway else (ONE_PATH, ONE_PATH)), loops)


def shared_grid(law: Law) -> Array:
    """Return temperatures over the range that both paths have seen, shape (GRID,) [degC]."""
    return np.linspace(*(law.cells.both or law.domain), GRID)


def _difference(law: Law) -> PathEffect:
    if "difference" not in law.scatter.once:
        find_differences([law])
    found: PathEffect = law.scatter.once["difference"]
    return found


def _mean_over_paths(law: Law, order: int) -> Array:
    """Return the row of a series whose combination is its mean over the range of both paths, shape (order + 1,)."""
    return law.cells.once(
        ("mean over the paths", order, law.domain),
        lambda: series_rows(shared_grid(law), law.domain, order).mean(axis=0),
    )


def _rates(cells: Cells) -> tuple[float, ...]:
    """Return the least and the largest median rate of the ramps: once where sensors share their rates."""
    if ("rates", id(cells.rate)) not in cells.once:
        find_rates([cells])
    found: tuple[float, ...] = cells.once["rates", id(cells.rate)][0]
    return found


def find_rates(cells: Sequence[Cells]) -> None:
    """Find the least and the largest median rate of the ramps of several sensors, for `paths_of`."""
    own = [*{(id(one.once), id(one.rate)): one for one in cells}.values()]
    if not own:
        return
    unit = np.repeat(np.arange(len(own)), [len(one) for one in own])
    ramp, rate = (np.concatenate(column) for column in zip(*((one.ramp, np.abs(one.rate)) for one in own), strict=True))
    key = unit * (int(ramp.max()) + 1) + ramp
    order = np.lexsort((rate, key))  # NaN last
    key, rate = key[order], rate[order]
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    n = np.add.reduceat(np.isfinite(rate), starts, dtype=np.int64)
    median = 0.5 * (rate[starts + np.maximum(n - 1, 0) // 2] + rate[starts + np.maximum(n, 1) // 2])
    of, median = unit[order][starts][n > 0], median[n > 0]
    least, most = np.full(len(own), np.inf), np.full(len(own), -np.inf)
    np.minimum.at(least, of, median)
    np.maximum.at(most, of, median)
    for one, low, high in zip(own, least.tolist(), most.tolist(), strict=True):
        one.once.keep(("rates", id(one.rate)), ((low, high) if low <= high else (), one.rate))


def _separated(law: Law, loops: int) -> tuple[PathEffect, PathEffect]:
    cells = law.cells
    reason = ""
    if not loops:
        reason = "no run shows warming and cooling: hysteresis, thermal lag and drift look the same; make loops"
    elif loops < 2:
        reason = "one loop: hysteresis, thermal lag and drift look the same; make a second one, at another rate"
    elif not np.isfinite(cells.rate).all() or not np.isfinite(cells.time).all():
        reason = "no time column: thermal lag and drift look like hysteresis"
    if reason:
        return PathEffect(None, reason=reason), PathEffect(None, reason=reason)
    columns, names, behind = _columns(law)
    root = np.sqrt(cells.weight)[:, None]
    row, lag = np.zeros(columns.shape[1]), np.eye(columns.shape[1])[behind]
    row[law.order + 1 : behind] = _mean_over_paths(law, behind - law.order - 2)
    try:
        found = fit(columns * root, cells.reading * root[:, 0], names=names)
    except DataError:
        return _not_told()

    def alone() -> float:
        return _grown(fit((columns * root)[:, :behind], cells.reading * root[:, 0]).transform, row[:behind])

    if _grown(found.transform, row) > MIXED * cells.once(("grown", law.order, behind), alone):
        return _not_told()
    rows = np.vstack([row, lag])
    covariance, dof = clustered_contrasts(found, law.scatter.members, rows)
    values = rows @ found.coefficients
    effects = [
        PathEffect(float(v), float(np.sqrt(c)), float(d)) if d > 0.0 else PathEffect(None, reason=ONE_RUN)
        for v, c, d in zip(values, np.diag(covariance), dof, strict=True)
    ]
    return effects[0], effects[1]


ONE_RUN = "needs two runs or more: one run does not show the scatter between runs"


def _not_told() -> tuple[PathEffect, PathEffect]:
    why = "the ramps do not tell hysteresis from thermal lag and drift: make loops at two rates"
    return PathEffect(None, reason=why), PathEffect(None, reason=why)


def _columns(law: Law) -> tuple[Array, list[str], int]:
    """Return the design of the module head, its names, and which is the lag: P, H, lag, then drift and offset of runs.

    H bends as much as the slope of P can, so that at one rate nothing passes for a lag.
    """
    cells, bent, runs = law.cells, max(law.path_order, law.order - 1), law.cells.runs

    def by_run() -> Array:
        number = cells.run_number
        each = np.eye(runs)[number]
        middle = np.bincount(number, cells.time) / np.bincount(number)
        scale = max(float(np.ptp(cells.time)), 1.0)
        return np.hstack([each * ((cells.time - middle[number]) / scale)[:, None], each[:, 1:]])

    own, drift = design(cells, law.order, bent), cells.once("drift and offset", by_run)
    columns = np.column_stack([own, lag_column(cells, law.coefficients), drift])
    names = [f"P{i}" for i in range(law.order + 1)] + [f"H{i}" for i in range(bent + 1)] + ["lag"]
    names += [f"drift {i}" for i in range(runs)] + [f"offset {i}" for i in range(1, runs)]
    return columns, names, law.order + bent + 2


def _grown(transform: Array, row: Array) -> float:
    """Variance of a combination for readings of variance one."""
    return float(np.sum((row @ transform) ** 2))


def _told(hysteresis: PathEffect, none: float | None) -> tuple[Word, str]:
    if hysteresis.value is None or hysteresis.u is None or hysteresis.dof is None:
        return "unclear", hysteresis.reason
    low, high = ends(t_interval(hysteresis.value, hysteresis.u, hysteresis.dof))
    if none is not None and -none <= low and high <= none:
        return "no", "its 95 % interval lies within what counts as none"
    if low > 0.0 or high < 0.0:
        return "yes", "its 95 % interval excludes zero, with lag and drift in the fit"
    return "unclear", "its 95 % interval holds zero"
