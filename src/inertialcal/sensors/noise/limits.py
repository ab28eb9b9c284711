"""Intervals of noise terms by the profile of the cost, upper limits of terms not shown, and the record that shows them.

An interval holds the powers (squared coefficients) at which the least cost over all other unknowns rises by no more
than ``stretch q / 2``, q the point of chi-square with one degree of freedom, and ``stretch`` the variance found over
that as if averaging times were independent [1]_. It is unsymmetric where the cost is, and ends at zero where a term
could be absent. Where the relative uncertainty is small the normal interval of the logarithm is the same.

A term that is not shown is added with a held power; its upper limit is where the cost has risen by the one-sided 95 %
point over its least. The record needed is that in which a term *at its upper limit* would have a power known to 25 %:
the same averaging times with degrees of freedom as the longer record gives them, and longer ones. An estimate: the
planner computes the uncertainty of a planned record exactly.

References
----------
.. [1] H. Geys, G. Molenberghs and L. M. Ryan, J. Am. Stat. Assoc. 94 (1999) 734: adjusted composite likelihood ratio.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import special

from ...core.estimate import Array
from ...core.results import Interval
from .likelihood import (
    GAUSS_MARKOV,
    PER_E,
    Fitted,
    Problem,
    estimate,
    estimate_at,
    expected,
    mean_of,
    sandwich,
    terms_of,
    time_at,
)
from .runs import Run

ONE_SIDED = 0.95  # of an upper limit
NORMAL_BELOW = 0.08  # relative uncertainty of a power, below which its logarithm is taken as normal
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at
WIDEST = 40.0  # of the logarithm of a power: beyond, there is no limit
TOLERANCE = 0.003  # of the logarithm of a limit


def crossing(rise: Callable[[float], float], start: float, step: float, target: float) -> float | None:
    """Return where a rising function of the distance from ``start`` reaches the target; None if it never does."""
    inside, size = start, step
    outside = start + size
    while rise(outside) < target:
        inside, size = outside, 2.0 * size
        outside = start + size
        if abs(size) > WIDEST:
            return None
    while abs(outside - inside) > TOLERANCE:
        middle = 0.5 * (inside + outside)
        if rise(middle) < target:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


def power_interval(
    problem: Problem, terms: tuple[str, ...], fitted: Fitted, at: int, u: float, stretch: float, p: float
) -> Interval:
    """Return the interval of a power, column ``at`` [unit^2].

    Parameters
    ----------
    problem, terms, fitted : Problem, tuple of str, Fitted
        Runs, the terms chosen, and their sizes.
    at : int
        Column of the power.
    u, stretch : float
        Its standard uncertainty, and see the module head.
    p : float
        Probability.
    """
    best = float(fitted.powers[at])
    relative = u / best
    if relative < NORMAL_BELOW:
        half = float(special.ndtri(0.5 * (1.0 + p))) * relative
        return Interval(best * np.exp(-half), best * np.exp(half), p)

    def rise(log: float) -> float:
        held = estimate(problem, terms, at, best * float(np.exp(log)))
        return 2.0 * (held.cost - fitted.cost) / stretch

    target = float(special.chdtri(1.0, 1.0 - p))
    lo, hi = (crossing(rise, 0.0, sign * min(2.0 * relative, 1.0), target) for sign in (-1.0, 1.0))
    return Interval(0.0 if lo is None else best * np.exp(lo), None if hi is None else best * np.exp(hi), p)


def time_interval(
    problem: Problem, terms: tuple[str, ...], fitted: Fitted, relative: float, stretch: float, p: float
) -> Interval:
    """Return the interval of the correlation time [s]; open where the record does not bound it."""
    best = time_at(problem, fitted.position)
    if relative < NORMAL_BELOW:
        half = float(special.ndtri(0.5 * (1.0 + p))) * relative
        return Interval(best * np.exp(-half), best * np.exp(half), p)
    last = len(problem.table) - 1.0

    def rise(log: float) -> float:
        position = fitted.position + log * PER_E
        if not 0.0 <= position <= last:
            return np.inf
        return 2.0 * (estimate_at(problem, terms, position).cost - fitted.cost) / stretch

    target = float(special.chdtri(1.0, 1.0 - p))
    ends = [crossing(rise, 0.0, sign * min(2.0 * relative, 1.0), target) for sign in (-1.0, 1.0)]
    found = [None if end is None else best * float(np.exp(end)) for end in ends]
    beyond = [position * PER_E + fitted.position for position in (e for e in ends if e is not None)]
    lo = None if beyond and beyond[0] <= 0.05 else found[0]
    hi = None if beyond and beyond[-1] >= last - 0.05 else found[1]
    return Interval(lo, hi, p)


def upper_limit(problem: Problem, terms: tuple[str, ...], fitted: Fitted, at: int, sigma: Array) -> float | None:
    """Return the one-sided 95 % upper limit of the power of a term that was not chosen [unit^2].

    Parameters
    ----------
    problem, terms, fitted : Problem, tuple of str, Fitted
        Runs, the terms chosen, and their sizes.
    at : int
        Column of the term.
    sigma : ndarray, shape (k, k)
        Covariance of the Allan variances.
    """
    wanted = (*terms, problem.names[at])
    least = _at_correlation_time(problem, wanted, fitted, -1, 0.0)
    u, stretch = _of_added(problem, fitted, at, sigma)
    start = max(float(least.powers[at]), 1e-3 * u)

    def rise(log: float) -> float:
        held = _at_correlation_time(problem, wanted, fitted, at, start * float(np.exp(log)))
        return 2.0 * (held.cost - least.cost) / stretch

    target = float(special.ndtri(ONE_SIDED)) ** 2
    log = crossing(rise, 0.0, 0.5, target)
    return None if log is None else start * float(np.exp(log))


def _at_correlation_time(problem: Problem, wanted: tuple[str, ...], fitted: Fitted, at: int, value: float) -> Fitted:
    """Least cost with a power held, the correlation time as it was found."""
    return estimate(problem, wanted, at, value, within=(fitted.position, fitted.position))


def _of_added(problem: Problem, fitted: Fitted, at: int, sigma: Array) -> tuple[float, float]:
    """Return the standard uncertainty of a power that is added, and its stretch."""
    tiny = 1e-9 * float(np.min(mean_of(problem, fitted) / problem.columns[:, at]))
    powers = fitted.powers.copy()
    powers[at] = tiny
    added = sandwich(problem, replace(fitted, powers=powers), sigma)
    column = int(np.count_nonzero(powers[:at] > 0.0))
    return float(np.sqrt(added.covariance[column, column])), float(added.stretch[column])


def record_needed(problem: Problem, fitted: Fitted, at: int, power: float, sigma: Array) -> float | None:
    """Return the length of one record that shows a term of that power [s]; None beyond 2^24 times the present one."""
    stretch = _of_added(problem, fitted, at, sigma)[1]
    run = problem.runs[int(np.argmax([run.length for run in problem.runs]))]
    powers = fitted.powers.copy()
    powers[at] = power
    terms = terms_of(problem, replace(fitted, powers=powers))
    if problem.names[at] == GAUSS_MARKOV:
        return None
    longest = _extended(run, DOUBLINGS)
    columns = np.column_stack([expected(term, longest) for term in terms])
    column = int(np.count_nonzero(powers[:at] > 0.0))
    columns[:, column] /= power
    mu = columns.sum(axis=1) - columns[:, column] + power * columns[:, column]
    for doublings in range(DOUBLINGS + 1):
        k = len(run.m) + doublings
        weights = 0.5 * _edf_of_longer(run, doublings) / mu[:k] ** 2
        D = columns[:k] / np.sqrt(weights @ columns[:k] ** 2)
        H = (D.T * weights) @ D
        variance = stretch * float(np.linalg.pinv(H)[column, column]) / (weights @ columns[:k, column] ** 2)
        if np.sqrt(variance) <= KNOWN * power:
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
