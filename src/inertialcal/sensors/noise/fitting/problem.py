"""Runs of one sensor axis stacked for a fit: what was found, its weight, and what each unit term gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ....core.estimate import Array
from ..allan_of_terms import variance_of_phase
from ..phase import exponential_gain, remainder
from ..runs import Run
from ..terms import (
    BiasInstability,
    GaussMarkov,
    LinearTerm,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    means_of_exponential,
    total_phase,
)

LINEAR: tuple[type[LinearTerm], ...] = (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp)
GAUSS_MARKOV = GaussMarkov.name
PER_E = 8.0  # rows of the table of correlation times, a factor e
COMPLETE = 3.0  # `ends` of a complete record


@dataclass(frozen=True, eq=False)
class Problem:
    """Runs stacked.

    Parameters
    ----------
    runs : tuple of Run
        Of one sensor axis.
    names : tuple of str
        Linear terms, lines last: columns of ``columns``.
    columns : ndarray, shape (k, p)
        Allan variance of each term with coefficient 1.
    table : ndarray, shape (g, k)
        Allan variance of Gauss-Markov noise of sigma 1, a row for each correlation time.
    times : ndarray, shape (g,)
        Those correlation times [s], evenly spaced in the logarithm.
    lines : tuple of float
        Frequencies of lines [Hz].
    variance : ndarray, shape (k,)
        Allan variances found.
    weight : ndarray, shape (k,)
        Half of the degrees of freedom.
    misfit : float
        Relative, of the Allan variances: what terms leave unexplained beside scatter.
    """

    runs: tuple[Run, ...]
    names: tuple[str, ...]
    columns: Array
    table: Array
    times: Array
    lines: tuple[float, ...]
    variance: Array
    weight: Array
    misfit: float = 0.0

    @property
    def tau(self) -> Array:
        """Averaging times, shape (k,) [s]."""
        return np.concatenate([run.tau for run in self.runs])

    @property
    def length(self) -> float:
        """Length of the longest run [s]."""
        return max(run.length for run in self.runs)


def problem_of(runs: Sequence[Run], lines: Sequence[float] = ()) -> Problem:
    """Return runs of one axis stacked, with the columns of all terms."""
    units: list[Term] = [term(1.0) for term in LINEAR]
    units += [Sinusoid(1.0, frequency) for frequency in lines]
    names = tuple(term.name for term in LINEAR) + tuple(f"line_{i}" for i in range(len(lines)))
    columns = np.column_stack([np.concatenate([expected(unit, run) for run in runs]) for unit in units])
    shortest = min(run.interval for run in runs)
    longest = max(float(run.tau[-1]) for run in runs)
    count = max(int(np.ceil(PER_E * np.log(2.0 * longest / shortest))), 4)
    times = shortest * np.exp(np.arange(count) / PER_E)
    table = np.hstack([exponentials_of(times, run) for run in runs])
    variance = np.concatenate([run.variance for run in runs])
    weight = np.concatenate([0.5 * run.edf for run in runs])
    return Problem(tuple(runs), names, columns, table, times, tuple(lines), variance, weight)


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
    """Return the same runs, each Allan variance known no better than to a relative misfit.

    Parameters
    ----------
    problem : Problem
        Without one.
    misfit : float
        Relative, of the Allan variances.
    """
    return replace(problem, weight=1.0 / (1.0 / problem.weight + misfit**2), misfit=misfit)


def expected(term: Term, run: Run) -> Array:
    """Return the Allan variance that a term gives at the averaging times of a run, shape (k,).

    Where samples are missing, what is independent from sample to sample grows as windows have fewer of them, and errors
    of the running sum, which cancel inside of a window, do not at its gaps.
    """
    phase = total_phase((term,), run.interval, run.averaging)
    found = variance_of_phase(phase, run.m) + phase.linear / run.m * (run.inflation - 1.0)
    return found if run.ends is None else found + phase.point / run.m**2 * (run.ends - COMPLETE)


def exponentials_of(times: Array, run: Run) -> Array:
    """Return what `expected` gives of Gauss-Markov noise of sigma 1, a row for each correlation time, shape (g, k)."""
    u = (run.interval / times)[:, None]
    point, linear, size = means_of_exponential(run.averaging / times[:, None], u)
    gain, excess = exponential_gain(u)

    def rest(lags: Array) -> Array:
        return np.asarray(size * (gain * remainder(u * lags) + excess * lags))

    together = 4.0 * rest(run.m) - rest(2.0 * run.m) + 3.0 * point
    return np.asarray(together / run.m**2 + linear / run.m * run.inflation)
