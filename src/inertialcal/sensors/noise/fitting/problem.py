"""Runs of one sensor axis stacked for a fit: what was found, its weight, and what each unit term gives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array, Numbers
from ....core.results import changed
from ....core.show.rounding import number
from ....core.units import factor
from ..expected import variance_of_phase
from ..terms import (
    BiasInstability,
    GaussMarkov,
    LinearTerm,
    Phase,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    exponential_gain,
    means_of_exponential,
    remainder,
    total_phase,
)
from .filtered import Band

LINEAR: tuple[type[LinearTerm], ...] = (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp)
GAUSS_MARKOV = GaussMarkov.name
PER_E = 8.0  # rows of the table of correlation times, a factor e
COMPLETE = 3.0  # `ends` of a complete record
SPACING = 1.9  # least ratio of neighbouring averaging times: closer ones repeat each other
LEAST_EDF = 1.5  # of a point that is used
LEAST_POINTS = 4
BEYOND = 2.0  # shortest averaging times, in the shortest correlation time of a sensor with a filter


@dataclass(frozen=True, eq=False)
class Problem:
    """Runs stacked."""

    runs: tuple[Run, ...]  # Of one sensor axis
    names: tuple[str, ...]  # Linear terms, lines last: columns of ``columns``
    columns: Array  # shape (k, p): Allan variance of each term with coefficient 1
    table: Array  # shape (g, k): Allan variance of Gauss-Markov noise of sigma 1, a row for each correlation time
    times: Array  # shape (g,): Those correlation times [s], evenly spaced in the logarithm
    lines: tuple[float, ...]  # Frequencies of lines [Hz]
    variance: Array  # shape (k,): Allan variances found
    weight: Array  # shape (k,): Half of the degrees of freedom
    misfit: float = 0.0  # Relative, of the Allan variances: what terms leave unexplained besides scatter

    @cached_property
    def tau(self) -> Array:
        """Averaging times, shape (k,) [s]."""
        return np.concatenate([run.tau for run in self.runs])

    @cached_property
    def data(self) -> Array:
        """Variances, weights and averaging times as ``_kernels_limits`` takes them, shape (3, k)."""
        return np.array([self.variance, self.weight, self.tau])

    @cached_property
    def length(self) -> float:
        """Length of the longest run [s]."""
        return max(run.length for run in self.runs)


Sampling = tuple[float, float, bytes, bytes, bytes | None]  # What the unit terms of a run without a band hang on
Taken = tuple[Sampling, bytes, Band | None, Band | None]  # With numbers of windows and what a filter leaves
Shared = tuple[tuple[str, ...], Array, Array, Array]  # Names, columns, table and times of ``Problem``


def problem_of(runs: Sequence[Run], lines: Sequence[float] = ()) -> Problem:
    """Return runs of one axis stacked, with the columns of all terms."""
    if any(run.band is not None for run in runs):
        names, columns, table, times = _columns_of(runs, tuple(lines))
    else:
        names, columns, table, times = _shared(tuple([run.taken[0] for run in runs]), tuple(lines))
    variance = np.concatenate([run.variance for run in runs])
    weight = np.concatenate([0.5 * run.edf for run in runs])
    return Problem(tuple(runs), names, columns, table, times, tuple(lines), variance, weight)


@lru_cache(16)  # records of one length share them
def _shared(samplings: tuple[Sampling, ...], lines: tuple[float, ...]) -> Shared:
    return _columns_of([_sampled(*one) for one in samplings], lines)


def _columns_of(runs: Sequence[Run], lines: tuple[float, ...]) -> Shared:
    of_lines = [np.concatenate([expected(Sinusoid(1.0, one), run) for run in runs]) for one in lines]
    names = tuple(term.name for term in LINEAR) + tuple(f"line_{i}" for i in range(len(lines)))
    columns = np.ascontiguousarray(np.column_stack([np.concatenate([linear_columns(run) for run in runs]), *of_lines]))
    shortest = min(run.interval if run.band is None else BEYOND * run.tau[0] for run in runs)
    longest = max(float(run.tau[-1]) for run in runs)
    count = max(int(np.ceil(PER_E * np.log(2.0 * longest / shortest))), 4)
    times = shortest * np.exp(np.arange(count) / PER_E)
    return names, columns, np.hstack([table_of(times, run) for run in runs]), times


def each_run(problem: Problem) -> tuple[Problem, ...]:
    """Return each run by itself, with the correlation times of all."""
    ends = np.cumsum([0, *(len(run.m) for run in problem.runs)])
    return tuple(
        replace(
            problem,
            runs=(run,),
            columns=problem.columns[a:b],
            table=np.ascontiguousarray(problem.table[:, a:b]),
            variance=problem.variance[a:b],
            weight=problem.weight[a:b],
        )
        for run, (a, b) in zip(problem.runs, pairwise(ends), strict=True)
    )


def with_misfit(problem: Problem, misfit: float) -> Problem:
    """Return the same runs, each Allan variance known no better than to a relative misfit."""
    return replace(problem, weight=1.0 / (1.0 / problem.weight + misfit**2), misfit=misfit)


def expected(term: Term, run: Run) -> Array:
    """Return the Allan variance that a term gives at the averaging times of a run, shape (k,).

    Where samples are missing, what is independent from sample to sample grows as windows have fewer of them, and errors
    of the running sum, which cancel inside of a window, do not at its gaps. What a filter takes is subtracted.
    """
    phase = total_phase((term,), run.interval, run.averaging)
    found = variance_of_phase(phase, run.m) + phase.linear / run.m * (run.inflation - 1.0)
    if run.band is not None:
        found = found - run.band.lost([phase], run.m)[0]
    return found if run.ends is None else found + phase.point / run.m**2 * (run.ends - COMPLETE)


def linear_columns(run: Run) -> Array:
    """Return what `expected` gives of each linear term with coefficient 1, shape (k, p); not to be changed."""
    if run.band is None:
        return _linear_columns(*_sampling(run))
    return np.column_stack([expected(term(1.0), run) for term in LINEAR])


def table_of(times: Array, run: Run) -> Array:
    """Return `exponentials_of` a run; not to be changed."""
    return exponentials_of(times, run) if run.band is not None else _table(times.tobytes(), *_sampling(run))


def _sampling(run: Run) -> Sampling:
    ends = None if run.ends is None else run.ends.tobytes()
    return run.interval, run.averaging, run.m.tobytes(), run.inflation.tobytes(), ends


def _sampled(interval: float, averaging: float, m: bytes, inflation: bytes, ends: bytes | None) -> Run:
    at = np.frombuffer(m)
    return Run(
        at, at, at, at, interval, averaging, np.frombuffer(inflation), None if ends is None else np.frombuffer(ends)
    )


@lru_cache(16)  # records of one length share them
def _linear_columns(interval: float, averaging: float, m: bytes, inflation: bytes, ends: bytes | None) -> Array:
    run = _sampled(interval, averaging, m, inflation, ends)
    return np.column_stack([expected(term(1.0), run) for term in LINEAR])


@lru_cache(16)
def _table(times: bytes, interval: float, averaging: float, m: bytes, inflation: bytes, ends: bytes | None) -> Array:
    return exponentials_of(np.frombuffer(times), _sampled(interval, averaging, m, inflation, ends))


def exponentials_of(times: Array, run: Run) -> Array:
    """Return what `expected` gives of Gauss-Markov noise of sigma 1, a row for each correlation time, shape (g, k)."""
    u = (run.interval / times)[:, None]
    point, linear, size = means_of_exponential(run.averaging / times[:, None], u)
    gain, excess = exponential_gain(u)

    def rest(lags: Array) -> Array:
        return np.asarray(size * (gain * remainder(u * lags) + excess * lags))

    together = 4.0 * rest(run.m) - rest(2.0 * run.m) + 3.0 * point
    found = together / run.m**2 + linear / run.m * run.inflation
    if run.band is not None:
        parts = zip(point[:, 0], linear[:, 0], size[:, 0], u[:, 0], strict=True)
        phases = [Phase(point=a, linear=b, exponentials=((c, d),)) for a, b, c, d in parts]
        found = found - run.band.lost(phases, run.m)
    return np.asarray(found)


class AllanLike(Protocol):
    """Overlapping Allan deviation over averaging times, as ``signals.allan`` gives it."""

    @property
    def m(self) -> Numbers:
        """Samples in a mean, shape (k,)."""

    @property
    def n(self) -> Numbers:
        """Terms averaged, shape (k,) or (k, axes)."""

    @property
    def deviation(self) -> Array:
        """Shape (k,) or (k, axes) [unit]."""

    @property
    def edf(self) -> Array:
        """Equivalent degrees of freedom, shape of the deviation."""

    @property
    def interval(self) -> float:
        """Time from sample to sample [s]."""

    @property
    def averaging(self) -> float | None:
        """Averaging time of a sample [s]; None when nobody said, and the interval is taken."""


@dataclass(frozen=True, eq=False)
class Run:
    """Overlapping Allan variances of one axis of one record."""

    m: Array  # shape (k,): Samples in a mean, ascending
    variance: Array  # shape (k,): Overlapping Allan variances [unit^2]
    n: Array  # shape (k,): Terms averaged
    edf: Array  # shape (k,): Equivalent degrees of freedom: twice the weight
    # Time from sample to sample, and that of one mean [s]
    interval: float
    averaging: float
    inflation: Array  # shape (k,): By how much missing samples raise the variance of white noise; 1 without gaps
    # shape (k,): Squared weights of errors of the integrated signal over 2 / m^2; default: 3, without gaps
    ends: Array | None = None
    band: Band | None = None  # What a filter of the sensor leaves of its noise
    unseen: Band | None = None  # What one might leave that the spectrum does not show, nor exclude

    @property
    def tau(self) -> Array:
        """Averaging times [s]."""
        return np.asarray(self.m * self.interval)

    @cached_property
    def taken(self) -> Taken:
        """What the covariance of its Allan variances hangs on, but for the noise."""
        return _sampling(self), self.n.tobytes(), self.band, self.unseen

    @cached_property
    def samples(self) -> float:
        """Samples that the record has room for."""
        return float(np.max(self.n + 2.0 * self.m - 1.0))

    @property
    def length(self) -> float:
        """Length of the record [s]."""
        return self.samples * self.interval


def run_that_took(taken: Taken) -> Run:
    """Return a run of such windows, without what was found, and not to be changed."""
    sampling, n, band, unseen = taken
    return replace(_sampled(*sampling), n=np.frombuffer(n), band=band, unseen=unseen)


def unit_of(curve: AllanLike | Run) -> str:
    """Return the unit that a curve says it has; empty where nobody said."""
    return str(getattr(curve, "unit", ""))


def run_of(curve: AllanLike | Run, axis: int | None = None, unit: str = "") -> Run:
    """Return what the fit takes of a curve.

    Raises
    ------
    DataError
        If the deviation is of another kind, in a unit of something else, the axis is not said, a constant channel has
        no noise, or fewer than four averaging times carry anything.
    """
    if isinstance(curve, Run):
        return _usable(curve)
    kind = getattr(curve, "kind", "overlapping")
    if kind != "overlapping":
        raise DataError(
            f"a curve of the {kind} deviation",
            why="weights and covariance of the fit are those of the overlapping Allan variance",
            do='Compute it with deviation="overlapping"',
            code="not_overlapping",
        )
    return _usable(_of_curve(curve, lambda given: _column(given, axis), unit))


def runs_of(curve: AllanLike, unit: str = "") -> list[Run | None]:
    """Return the same of each axis of a curve of complete records alike; None where `run_of` refuses it.

    What they have in common they share.
    """
    whole = _of_curve(curve, lambda given: np.asarray(given, dtype=np.float64), unit)
    found: list[Run | None] = []
    alike: dict[bytes, Run] = {}
    for good, variance, edf, n in zip(_good(whole).T, whole.variance.T, whole.edf.T, whole.n.T, strict=True):
        like = alike.get(good.tobytes())
        if like is not None:
            at = np.searchsorted(whole.m, like.m)
            found.append(replace(like, variance=variance[at], edf=edf[at]))
            continue
        inflation, ends = whole.inflation[:, 0], None if whole.ends is None else whole.ends[:, 0]
        own = replace(whole, variance=variance, n=n, edf=edf, inflation=inflation, ends=ends)
        try:
            alike[good.tobytes()] = _usable(own)
        except DataError:
            found.append(None)
        else:
            found.append(alike[good.tobytes()])
    return found


def _of_curve(curve: AllanLike, column: Callable[[Numbers], Array], unit: str) -> Run:
    """Return a curve as a run, its columns as they are taken, before what is usable in it is kept."""
    given = unit_of(curve)
    scale = factor(given, unit) if given and unit else 1.0
    variance = (scale * column(curve.deviation)) ** 2
    averaging = getattr(curve, "averaging", None)
    inflation = np.ones(variance.shape)
    raised = getattr(curve, "inflation", None)
    if raised is not None:  # of white noise by missing samples, divided out where the noise seems white
        inflation = column(raised)
        power = column(getattr(curve, "power", inflation))
        variance = np.where(power >= 0.0, variance * inflation, variance)
    ends = getattr(curve, "ends", None)
    return Run(
        np.asarray(curve.m, dtype=float),
        variance,
        column(curve.n),
        column(curve.edf),
        float(curve.interval),
        float(curve.interval if averaging is None else averaging),
        inflation,
        None if ends is None else column(ends),
    )


def inside(run: Run, band: Band) -> Run:
    """Return the averaging times that tell of the terms, not of a filter alone; all where it is not found.

    Raises
    ------
    DataError
        If fewer than four are there.
    """
    if not band.found:
        return changed(run, unseen=band)
    at = run.m >= band.first
    if np.count_nonzero(at) < LEAST_POINTS:
        corner = number(band.corner / run.interval, 3)
        raise DataError(
            f"{np.count_nonzero(at)} averaging time(s) above the filter of {corner} Hz, need {LEAST_POINTS}",
            why="shorter ones tell of the filter alone",
            do="Record for longer",
            code="too_short",
        )
    ends = None if run.ends is None else run.ends[at]
    return replace(
        run, m=run.m[at], variance=run.variance[at], n=run.n[at], edf=run.edf[at], inflation=run.inflation[at],
        ends=ends, band=band,
    )  # fmt: skip


def _column(given: Numbers, axis: int | None) -> Array:
    values = np.asarray(given, dtype=np.float64)
    if values.ndim == 1:
        return values
    if axis is None and values.shape[1] != 1:
        raise DataError(f"a curve of {values.shape[1]} axes", do="Say which: axis=0, 1, ...", code="axis")
    if axis is not None and not 0 <= axis < values.shape[1]:
        raise DataError(f"axis {axis} of a curve of {values.shape[1]}", do="The first is axis=0", code="axis")
    own: Array = values[:, axis or 0]
    return own


def _good(run: Run) -> NDArray[np.bool_]:
    """Return which variances carry something."""
    return np.isfinite(run.variance) & (run.variance > 0.0) & (run.edf >= LEAST_EDF) & (run.n >= 1.0)


def _usable(run: Run) -> Run:
    """Keep octaves with something in them."""
    there = run.variance[np.isfinite(run.variance)]
    if len(there) and not (there > 0.0).any():
        raise DataError(
            "the Allan deviation is zero throughout",
            why="a constant channel has no noise",
            do="Look whether the sensor is stuck, or its steps coarser than its noise",
            code="constant",
        )
    kept: list[int] = []
    m = run.m.tolist()
    for i in _good(run).nonzero()[0].tolist():
        if not kept or m[i] >= SPACING * m[kept[-1]]:
            kept.append(i)
    if len(kept) < LEAST_POINTS:
        raise DataError(
            f"{len(kept)} averaging time(s) with {LEAST_EDF:g} or more degrees of freedom, need {LEAST_POINTS}",
            why=f"{run.samples:.0f} samples cannot separate terms of noise",
            do="Record for longer",
            code="too_short",
        )
    if len(kept) == len(m):
        return run
    at = np.array(kept)
    ends = None if run.ends is None else run.ends[at]
    return Run(
        run.m[at], run.variance[at], run.n[at], run.edf[at], run.interval, run.averaging, run.inflation[at], ends
    )  # fmt: skip
