"""Start-up of the unit in a thermal test: found while the temperature is still that of the start.

What a unit does after power-up and what it does over temperature look alike while the temperature moves. So the
transient is looked for before it does: from power-up until the temperature leaves its noise for good, with what the
polynomial of a first reduction says of small changes taken off. The cut is the time after which less than
``settled`` is left of it, the same for all power-ups of the test; by default a tenth of the scatter of a sample, which
is of the size of what a mean over some minutes can show.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....core.batches import batches, taken
from ....core.errors import DataError
from ....core.estimate import Array
from ....sensors.warm_up import FEWEST, WarmUp, find_warm_up
from ..plan import Plan
from ._kernels_cells import count_still
from .cells import Cells, Indices, Series
from .law import Law

SHARE = 0.1  # of the scatter of a sample that counts as settled
STILL = 0.1  # of the turn-over distance: the temperature is still that of the start
NOISE = 3.0  # of its scatter there, that it stays within
SHORTEST = 120.0  # steady part that shows a start-up [s]
MEANS = 120  # of the steady part after a power-up
NOTHING, NO_RUN = np.zeros(0), np.zeros(0, dtype=np.int64)
STEADY = "the temperature changes from power-up on: its effect looks like a start-up transient"


class StartUp(NamedTuple):
    """What a thermal test shows of the start-up of one sensor."""

    found: WarmUp | None  # The transient
    reason: str  # Why there is none
    settled: float  # Tolerance [unit of the readings]
    cut: float  # Left out after each power-up [s]
    time: Array  # shape (m,): of the means that it was found in, since power-up [s]
    residual: Array  # shape (m,): those means less the polynomial [unit of the readings]
    run: Indices  # shape (m,): number of the run


def start_up_of(plan: Plan, series: Series, cells: Cells, law: Callable[[], Law]) -> StartUp:
    """Return the start-up of one sensor, and how long to leave out after a power-up.

    Parameters
    ----------
    plan : Plan
        With what counts as settled, and what is left out by it.
    series : Series
        All samples.
    cells : Cells
        Their means.
    law : callable
        What gives the first law of the sensor; called only where the temperature is steady after a power-up.
    """
    settled = plan.settled if plan.settled is not None else SHARE * cells.deviation
    time, residual, run = _steady_means(series, law)
    found, reason = None, ""
    if not series.once("timed", lambda: bool(np.isfinite(series.time).any())):
        reason = "no time is known"
    elif len(time) == 0:
        reason = STEADY
    else:
        try:
            found = find_warm_up(time, residual, run)
        except DataError as error:
            reason = error.problems[0].what
    cut = plan.warm_up
    if cut is None:
        cut = found.settled_after(settled) if found is not None and settled > 0.0 else 0.0
    return StartUp(found, reason, settled, cut, time, residual, run)


def _steady_means(series: Series, first: Callable[[], Law]) -> tuple[Array, Array, Indices]:
    """Means over the steady part after each power-up, of what the polynomial leaves; none where it is too short."""
    times, residuals, runs = [], [], []
    if series.short and series.once("moves", lambda: not any(len(_still(series, run)) for run in {*series.runs})):
        return NOTHING, NOTHING, NO_RUN
    for number in sorted({*series.runs}):
        at = _steady_part(series, number)
        if len(at) < FEWEST:
            continue
        law = first()
        left = _at(series.reading, at) - law.basis(np.clip(_at(series.temperature, at), *law.domain)) @ law.coefficients
        size = -(-len(at) // MEANS)
        starts = np.arange(0, len(at) - size + 1, size)
        whole = len(starts) * size
        times.append(_at(series.time, at)[:whole].reshape(-1, size).mean(axis=1))
        residuals.append(left[:whole].reshape(-1, size).mean(axis=1))
        runs.append(np.full(len(starts), number))
    if not times:
        return NOTHING, NOTHING, NO_RUN
    return np.concatenate(times), np.concatenate(residuals), np.concatenate(runs)


def _steady_part(series: Series, run: int) -> Indices:
    """Return the samples of a run until its temperature leaves that of the start, in order of time."""
    steady = _still(series, run)
    return _long(series, steady[np.isfinite(_at(series.reading, steady))]) if len(steady) else steady


def _still(series: Series, run: int) -> Indices:
    """Return the same by the temperature alone; none where it is too short."""

    def found() -> Indices:
        return _long(series, _still_part(series, run))

    return series.once(("still", run), found) if series.short else found()


def _long(series: Series, part: Indices) -> Indices:
    return part if len(part) >= FEWEST and np.ptp(_at(series.time, part)) >= SHORTEST else part[:0]


def _still_part(series: Series, run: int) -> Indices:
    """Return the same by the temperature alone."""
    if series.short:
        parts = series.of_run(run)
        temperature, time = (_row(one, parts) for one in series.columns[:2])
        known = np.empty(len(time), dtype=np.int64)
        count = count_still(time, temperature, STILL * series.turn_over, NOISE, known)
        if count >= 0:
            known = known[:count]
            return known + parts[0].start if len(parts) == 1 else _numbered(parts)[known]
    ordered = _in_order(series, run)
    few = max(sum(len(own) for own in ordered()) // 1000, 1)
    first = np.empty(0)
    for own in ordered():
        first = np.append(first, series.temperature[own[: few - len(first)]])
        if len(first) == few:
            break
    level, begun = first.mean() if len(first) else np.nan, [np.empty(0, dtype=np.int64)]
    for own in ordered():
        gone = np.flatnonzero(np.abs(series.temperature[own] - level) > STILL * series.turn_over)
        begun.append(own[: gone[0]] if len(gone) else own)
        if len(gone):
            break
    steady = np.concatenate(begun)
    if not len(steady):
        return steady
    warm = _at(series.temperature, steady)
    half = warm[: max(len(steady) // 2, 1)]
    at_rest = np.flatnonzero(np.abs(warm - half.mean()) <= NOISE * half.std())
    return steady[: at_rest[-1] + 1] if len(at_rest) else steady[:0]


def _row(x: Array, parts: Sequence[slice]) -> Array:
    """Return some parts of a row end to end, shape (n,): one alone is not copied."""
    return x[parts[0]] if len(parts) == 1 else np.concatenate([x[one] for one in parts])


def _numbered(parts: Sequence[slice]) -> Indices:
    return np.concatenate([np.arange(one.start, one.stop) for one in parts])


def _in_order(series: Series, run: int) -> Callable[[], Iterable[Indices]]:
    """Return what gives the samples of a run whose time and temperature are known, in order of time, piece by piece."""
    last = -np.inf
    for own in _known(series, run):
        time = series.time[own]
        if len(own) and (time[0] < last or np.any(np.diff(time) < 0.0)):  # all of them are to be put in order
            every = np.concatenate(list(_known(series, run)))
            ordered = every[np.argsort(series.time[every], kind="stable")]
            return lambda: [ordered]
        last = time[-1] if len(own) else last
    return lambda: _known(series, run)


def _known(series: Series, run: int) -> Iterator[Indices]:
    for own in series.of_run(run):
        t, T = series.time[own], series.temperature[own]
        for first, stop in batches(t, T):
            known = np.isfinite(t[first:stop]) & np.isfinite(T[first:stop])
            yield own.start + first + np.flatnonzero(known)


def _at(x: Array, at: Indices) -> Array:
    """Return some samples, shape (k,); of a stored record they are in order."""
    return taken(x, at) if np.all(np.diff(at) > 0) else np.asarray(x[at])
