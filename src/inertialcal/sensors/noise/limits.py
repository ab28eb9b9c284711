"""Upper limits of noise terms that a record does not show, and the record that would show them.

A term that is not shown is added with a held power; its upper limit is where the cost has risen by the one-sided 95 %
point over its least (``profile``). The choice of terms comes first, and the limit does not allow for that: of a term
that most records show, those that miss it are those where it came out small. Of Gauss-Markov noise the limit is that of
sigma at the correlation time where it could hide best.

The record needed is that in which a term *at its upper limit* would have a power known to 25 %: the same averaging
times with degrees of freedom as the longer record gives them, and longer ones. An estimate: the planner computes the
uncertainty of a planned record exactly.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy import special

from ...core.estimate import Array
from .likelihood import (
    Fitted,
    column_at,
    estimate,
    mean_of,
    sandwich,
    terms_of,
)
from .order import present
from .problem import GAUSS_MARKOV, Problem, expected
from .profile import column_of, end_of, nearby
from .runs import Run

ONE_SIDED = 0.95  # of an upper limit
FURTHEST = 1e6  # standard uncertainties: beyond, there is no limit
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at


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
    within = nearby(problem, fitted) if linear else (fitted.position, fitted.position)
    least = estimate(problem, names, looks=1, within=within)
    best = float(least.powers[at])
    u, stretch = _of_added(problem, fitted, at, sigma)
    held = lru_cache(lambda x: estimate(problem, names, at, best + x * u, 1, within))
    point = float(special.ndtri(ONE_SIDED))
    x, stretch = end_of(problem, held, at, least.cost, stretch, point**2, point, FURTHEST)
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
