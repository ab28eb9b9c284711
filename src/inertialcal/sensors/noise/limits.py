"""Intervals of noise terms by the profile of the cost, upper limits of terms not shown, and the record that shows them.

An interval holds the values at which the least cost over all other unknowns rises by no more than ``stretch q / 2``,
q the point of chi-square with one degree of freedom, and ``stretch`` the variance of the unknown over that as if
averaging times were independent [1]_. The stretch is that of the terms *at the end of the interval*: the more a slow
term holds, the more neighbouring averaging times share. The interval is unsymmetric where the cost is, and ends at
zero where a term could be absent. Where the relative uncertainty is small the normal interval of the logarithm is the
same.

A term that is not shown is added with a held power; its upper limit is where the cost has risen by the one-sided 95 %
point over its least. The choice of terms comes first, and the limit does not allow for that: of a term that most
records show, those that miss it are those where it came out small. Of Gauss-Markov noise the limit is that of sigma at
the correlation time where it could hide best. The record needed is that in which a term *at its upper limit* would have
a power known to 25 %: the same averaging times with degrees of freedom as the longer record gives them, and longer
ones. An estimate: the planner computes the uncertainty of a planned record exactly.

References
----------
.. [1] H. Geys, G. Molenberghs and L. M. Ryan, J. Am. Stat. Assoc. 94 (1999) 734: adjusted composite likelihood ratio.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy import optimize, special

from ...core.estimate import Array
from ...core.results import Interval
from .likelihood import (
    Fitted,
    column_at,
    covariance_of_runs,
    estimate,
    estimate_at,
    mean_of,
    sandwich,
    terms_of,
    time_at,
)
from .order import present
from .problem import GAUSS_MARKOV, PER_E, Problem, expected
from .runs import Run
from .sandwich import Sandwich

ONE_SIDED = 0.95  # of an upper limit
NORMAL_BELOW = 0.1  # relative uncertainty, below which the logarithm of a value is taken as normal
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at
WIDEST = 40.0  # of the logarithm of a power: beyond, there is no end
FURTHEST = 1e6  # the same of a limit, in standard uncertainties
TOLERANCE = 0.01  # of the logarithm of an end, and of a limit in standard uncertainties
NEARBY = 16.0  # rows of the table of correlation times that are searched while another unknown is held
STEEP = 1e6  # rise of the cost that is not looked into

Held = Callable[[float], Fitted]  # least cost with one unknown held at a distance from its best


def crossing(rise: Callable[[float], float], step: float, target: float, furthest: float) -> float | None:
    """Return the distance from zero, on the side of ``step``, where a rising function reaches the target.

    None if it does not up to ``furthest``.
    """
    inside, outside = 0.0, step if abs(step) < abs(furthest) else furthest
    while rise(outside) < target:
        if abs(outside) >= abs(furthest):
            return None
        inside, outside = outside, 2.0 * outside if abs(2.0 * outside) < abs(furthest) else furthest

    def beyond(x: float) -> float:  # nearly straight, where the rise is a parabola
        return float(np.sqrt(np.clip(rise(x), 0.0, STEEP)) - np.sqrt(target))

    return float(optimize.brentq(beyond, inside, outside, xtol=TOLERANCE))


def interval_of(problem: Problem, fitted: Fitted, at: int, bread: Sandwich, p: float) -> Interval:
    """Return the interval of a power [unit^2] or of the correlation time [s].

    A power ends at zero where its term could be absent; a time is open where the record does not bound it.

    Parameters
    ----------
    problem, fitted : Problem, Fitted
        Runs, and the sizes of the terms.
    at : int
        Column of the power; one beyond the last for the correlation time.
    bread : Sandwich
        Of the fit.
    p : float
        Probability.
    """
    timed, column = at == len(fitted.powers), column_of(fitted, at)
    best = time_at(problem, fitted.position) if timed else float(fitted.powers[at])
    relative = float(bread.u[column]) / (1.0 if timed else best)
    if relative < NORMAL_BELOW:
        half = float(special.ndtri(0.5 * (1.0 + p))) * relative
        return Interval(best * np.exp(-half), best * np.exp(half), p)
    held = _time_held(problem, fitted) if timed else _power_held(problem, fitted, at, best)
    furthest = (-WIDEST, WIDEST)
    if timed:
        furthest = (-fitted.position / PER_E, (len(problem.table) - 1.0 - fitted.position) / PER_E)
    target, step = float(special.chdtri(1.0, 1.0 - p)), min(2.0 * relative, 1.0)
    lo, hi = (
        end_of(problem, held, at, fitted.cost, float(bread.stretch[column]), target, float(np.copysign(step, far)), far)
        for far in furthest
    )
    none = None if timed else 0.0
    return Interval(none if lo is None else best * np.exp(lo), None if hi is None else best * np.exp(hi), p)


def end_of(
    problem: Problem, held: Held, at: int, least: float, stretch: float, target: float, step: float, furthest: float
) -> float | None:  # fmt: skip
    """Return the distance at which the cost has risen by the target, stretched as it is there; None if it never does.

    Parameters
    ----------
    problem : Problem
        Runs.
    held : callable
        Least cost with the unknown held at a distance.
    at : int
        Column of the unknown.
    least, stretch, target : float
        Least cost and stretch at distance zero, and twice the rise that is looked for.
    step, furthest : float
        First distance that is tried, and the last.
    """

    def rise(x: float) -> float:
        return 2.0 * (held(x).cost - least)

    first = crossing(rise, step, target * stretch, furthest)
    if first is None:
        return None
    there = held(first)
    if there.powers[min(at, len(there.powers) - 1)] <= 0.0:
        return first
    bread = sandwich(problem, there, covariance_of_runs(problem, there))
    return crossing(rise, first, target * float(bread.stretch[column_of(there, at)]), furthest)


def column_of(fitted: Fitted, at: int) -> int:
    """Return where an unknown stands among those of ``slopes_of``."""
    return int(np.count_nonzero(fitted.powers[:at] > 0.0))


def _power_held(problem: Problem, fitted: Fitted, at: int, best: float) -> Held:
    names = present(problem, fitted)
    within = _nearby(problem, fitted)
    return lru_cache(lambda x: estimate(problem, names, at, best * float(np.exp(x)), 1, within))


def _time_held(problem: Problem, fitted: Fitted) -> Held:
    names = present(problem, fitted)
    return lru_cache(lambda x: estimate_at(problem, names, fitted.position + x * PER_E))


def _nearby(problem: Problem, fitted: Fitted) -> tuple[float, float]:
    last = len(problem.table) - 1.0
    return max(fitted.position - NEARBY, 0.0), min(fitted.position + NEARBY, last)


def limit_and_record(problem: Problem, fitted: Fitted, at: int, sigma: Array) -> tuple[float | None, float | None]:
    """Return the one-sided 95 % upper limit of the power of a term that was not chosen [unit^2], and the record needed.

    Parameters
    ----------
    problem, fitted : Problem, Fitted
        Runs, and the sizes of the terms chosen; of Gauss-Markov noise that was not chosen, ``position`` says which.
    at : int
        Column of the term.
    sigma : ndarray, shape (k, k)
        Covariance of the Allan variances.

    Returns
    -------
    limit : float or None
        None where there is none.
    record : float or None
        Length of one record that shows a term of that power [s]; None beyond 2^24 times the present one.
    """
    linear = at < len(problem.names)
    names = (*present(problem, fitted), problem.names[at] if linear else GAUSS_MARKOV)
    within = _nearby(problem, fitted) if linear else (fitted.position, fitted.position)
    least = estimate(problem, names, looks=1, within=within)
    best = float(least.powers[at])
    u, stretch = _of_added(problem, fitted, at, sigma)
    held = lru_cache(lambda x: estimate(problem, names, at, best + x * u, 1, within))
    point = float(special.ndtri(ONE_SIDED))
    x = end_of(problem, held, at, least.cost, stretch, point**2, point, FURTHEST)
    return (None, None) if x is None else (best + x * u, record_needed(problem, fitted, at, best + x * u, stretch))


def _of_added(problem: Problem, fitted: Fitted, at: int, sigma: Array) -> tuple[float, float]:
    """Return the standard uncertainty of a power that is added, and its stretch."""
    whole = np.column_stack([problem.columns, column_at(problem, fitted.position)])
    powers = fitted.powers.copy()
    powers[at] = 1e-9 * float(np.min(mean_of(problem, fitted) / whole[:, at]))
    added = sandwich(problem, replace(fitted, powers=powers), sigma, timed=at < len(problem.names))
    column = column_of(fitted, at)
    return float(added.u[column]), float(added.stretch[column])


def record_needed(problem: Problem, fitted: Fitted, at: int, power: float, stretch: float) -> float | None:
    """Return the length of one record that shows a term of that power [s]; None beyond 2^24 times the present one."""
    run = problem.runs[int(np.argmax([run.length for run in problem.runs]))]
    powers = fitted.powers.copy()
    powers[at] = power
    longest = _extended(run, DOUBLINGS)
    terms = terms_of(problem, replace(fitted, powers=powers))
    columns = np.column_stack([expected(term, longest) for term in terms])
    mu, column = columns.sum(axis=1), column_of(fitted, at)
    for doublings in range(DOUBLINGS + 1):
        k = len(run.m) + doublings
        D = columns[:k] / mu[:k, None] * np.sqrt(0.5 * _edf_of_longer(run, doublings))[:, None]
        scale = np.sqrt(np.sum(D**2, axis=0))
        variance = stretch * np.linalg.pinv((D / scale).T @ (D / scale))[column, column] / scale[column] ** 2
        if np.sqrt(variance) <= KNOWN:
            return run.length * 2.0**doublings
    return None


def _extended(run: Run, doublings: int) -> Run:
    """Return the run's averaging times, and as many octaves more."""
    m = np.concatenate([run.m, run.m[-1] * 2.0 ** np.arange(1, doublings + 1)])
    ones = np.ones(len(m))
    return Run(m, ones, ones, ones, run.interval, run.averaging, np.concatenate([run.inflation, ones[:doublings]]))


def _edf_of_longer(run: Run, doublings: int) -> Array:
    """Degrees of freedom at the averaging times of a record of 2^doublings the length: they go with length over tau."""
    edf = np.concatenate([run.edf, np.zeros(doublings)])
    for i in range(len(edf)):
        back = min(i, doublings)
        edf[i] = run.edf[i - back] * 2.0 ** (doublings - back)
    return edf
