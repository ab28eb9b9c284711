"""Upper limits of noise terms that a record does not show, and the record that would show them.

A term that is not shown is added with a held power; its upper limit is where the cost has risen by the one-sided 95 %
point over its least (``profile``), over all powers of the others: a rival that was chosen in its place may vanish.
Where a choice with the term in place of a rival is nearly as good, the limit in that choice counts as well, and the
larger of both is taken. Of Gauss-Markov noise the limit is that of sigma at the correlation time where it could hide
best.

The choice of terms comes first, and has its price: of a term that many records show, those that miss it are those where
it came out small, so that a plain limit of 95 % holds in 77 to 91 % of *them*. So the limit is that of an estimate
which is known to lie below the size from which the term is named: the largest power p with
``P(estimate < found | p) >= 0.05 P(estimate < named from | p)`` [1]_; and not more than the power that would be named
in 95 % of such records, since those that miss larger ones are less than 5 % in all.

The record needed is that in which a term *at its upper limit* would have a power known to 25 %: the same averaging
times with degrees of freedom as the longer record gives them, and longer ones. An estimate: the planner computes the
uncertainty of a planned record exactly.

References
----------
.. [1] J. D. Lee, D. L. Sun, Y. Sun and J. E. Taylor, Ann. Stat. 44 (2016) 907: inference after a choice by the data.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy import optimize, special

from ....core.estimate import Array
from ..runs import Run
from .likelihood import Fitted, column_at, covariance_of_runs, estimate, mean_of, sandwich, terms_of
from .order import NAMES, PRICE, present, unknowns
from .problem import GAUSS_MARKOV, Problem, expected
from .profile import ROUGH, TOLERANCE, column_of, nearby

ONE_SIDED = 0.95  # of an upper limit
POINT = float(special.ndtri(ONE_SIDED))
FURTHEST = 1e6  # standard uncertainties: beyond, there is no limit
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at


def limit_and_record(
    problem: Problem, fitted: Fitted, at: int, sigma: Array, rival: Fitted | None = None
) -> tuple[float | None, float | None]:
    """Return the one-sided 95 % upper limit of the power of a term that was not chosen [unit^2], and the record needed.

    Parameters
    ----------
    problem, fitted : Problem, Fitted
        Runs, and the sizes of the terms chosen; of Gauss-Markov noise that was not chosen, ``position`` says which.
    at : int
        Column of the term.
    sigma : ndarray, shape (k, k)
        Covariance of the Allan variances.
    rival : Fitted, optional
        A choice with the term that is nearly as good.

    Returns
    -------
    limit : float or None
        None where there is none.
    record : float or None
        Length of one record that shows a term of that power [s]; None beyond 2^24 times the present one.
    """
    u, stretch = _of_added(problem, fitted, at, sigma)
    name = problem.names[at] if at < len(problem.names) else GAUSS_MARKOV
    named = u * float(np.sqrt(PRICE * (unknowns((*NAMES[1:2], name)) - 1.0) / stretch))
    limit, stretch = _limit(problem, fitted, at, (u, stretch), named)
    if limit is None:
        return None, None
    if rival is not None:
        other, _ = _limit(problem, rival, at, (u, stretch), None)
        limit = limit if other is None else max(limit, other)
    return limit, record_needed(problem, fitted, at, limit, stretch)


def _limit(
    problem: Problem, fitted: Fitted, at: int, scale: tuple[float, float], named: float | None
) -> tuple[float | None, float]:
    """Return the upper limit of a power beside the terms of a choice, and the stretch there.

    Parameters
    ----------
    problem, fitted, at : Problem, Fitted, int
        As in `limit_and_record`.
    scale : (float, float)
        Standard uncertainty of a small power, and its stretch.
    named : float or None
        Power from which the term would have been chosen; None where that was not what kept it out.
    """
    (u, stretch), linear = scale, at < len(problem.names)
    name = problem.names[at] if linear else GAUSS_MARKOV
    names = tuple(dict.fromkeys((*present(problem, fitted), name)))
    within = nearby(problem, fitted) if linear else (fitted.position, fitted.position)
    least = estimate(problem, names, looks=1, within=within)
    best = float(least.powers[at])
    held = lru_cache(lambda x: estimate(problem, names, at, best + x * u, 1, within))
    short = 0.0 if named is None else max(named - best, 0.0) / u

    def beyond(x: float, stretch: float) -> float:
        far = float(np.sqrt(max(2.0 * (held(x).cost - least.cost), 0.0) / stretch))
        if named is None:
            return far - POINT
        missed = far - short * far / x  # distance of the power from which it is named
        chance = float(special.ndtr(-far) / special.ndtr(-missed))
        return max(missed - POINT, 1.0 - ONE_SIDED - chance)

    first = _zero(lambda x: beyond(x, stretch), ROUGH)
    if first is None:
        return None, stretch
    there = held(first)
    bread = sandwich(problem, there, covariance_of_runs(problem, there), timed=linear)
    stretch = float(bread.stretch[column_of(there, at)])
    x = _zero(lambda x: beyond(x, stretch), TOLERANCE)
    return (None if x is None else best + x * u), stretch


def _zero(function: Callable[[float], float], tolerance: float) -> float | None:
    """Return where a function that rises from below zero crosses it; None if it does not up to `FURTHEST`."""
    inside, outside = 0.0, 1.0
    while function(outside) < 0.0:
        inside, outside = outside, 2.0 * outside
        if outside > FURTHEST:
            return None
    if inside == 0.0:
        inside = tolerance
        if function(inside) >= 0.0:
            return inside
    return float(optimize.brentq(function, inside, outside, xtol=tolerance))


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
