"""Intervals of noise terms by the profile of the cost.

An interval holds the values at which the least cost over all other unknowns rises by no more than ``stretch q / 2``,
q the point of chi-square with one degree of freedom, and ``stretch`` the variance of the unknown over that as if
averaging times were independent [1]_. The stretch is that of the terms *at the end of the interval*: the more a slow
term holds, the more neighbouring averaging times share. The interval is unsymmetric where the cost is, and ends at
zero where a term could be absent. Where the relative uncertainty is small the normal interval of the logarithm is the
same.

References
----------
.. [1] H. Geys, G. Molenberghs and L. M. Ryan, J. Am. Stat. Assoc. 94 (1999) 734: adjusted composite likelihood ratio.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy import optimize, special

from ....core.results import Interval
from .likelihood import Fitted, covariance_of_runs, estimate, estimate_at, sandwich, time_at
from .order import present
from .problem import PER_E, Problem
from .sandwich import Sandwich

NORMAL_BELOW = 0.1  # relative uncertainty, below which the logarithm of a value is taken as normal
WIDEST = 40.0  # of the logarithm of a power: beyond, there is no end
TOLERANCE = 0.01  # of the logarithm of an end, and of a limit in standard uncertainties
ROUGH = 0.1  # the same, where the stretch is taken
NEARBY = 16.0  # rows of the table of correlation times that are searched while another unknown is held
STEEP = 1e6  # rise of the cost that is not looked into

Held = Callable[[float], Fitted]  # least cost with one unknown held at a distance from its best


def crossing(
    rise: Callable[[float], float], step: float, target: float, furthest: float, tolerance: float = TOLERANCE
) -> float | None:
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

    return float(optimize.brentq(beyond, inside, outside, xtol=tolerance))


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
    stretch = float(bread.stretch[column])
    lo, hi = (
        end_of(problem, held, at, fitted.cost, stretch, target, float(np.copysign(step, far)), far)[0]
        for far in furthest
    )
    none = None if timed else 0.0
    return Interval(none if lo is None else best * np.exp(lo), None if hi is None else best * np.exp(hi), p)


def end_of(
    problem: Problem, held: Held, at: int, least: float, stretch: float, target: float, step: float, furthest: float
) -> tuple[float | None, float]:
    """Return the distance at which the cost has risen by the target, None if it never does, and the stretch there.

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

    first = crossing(rise, step, target * stretch, furthest, ROUGH)
    if first is None:
        return None, stretch
    there = held(first)
    if there.powers[min(at, len(there.powers) - 1)] <= 0.0:
        return first, stretch
    bread = sandwich(problem, there, covariance_of_runs(problem, there))
    stretch = float(bread.stretch[column_of(there, at)])
    return crossing(rise, first, target * stretch, furthest), stretch


def column_of(fitted: Fitted, at: int) -> int:
    """Return where an unknown stands among those of ``slopes_of``."""
    return int(np.count_nonzero(fitted.powers[:at] > 0.0))


def _power_held(problem: Problem, fitted: Fitted, at: int, best: float) -> Held:
    names = present(problem, fitted)
    within = nearby(problem, fitted)
    return lru_cache(lambda x: estimate(problem, names, at, best * float(np.exp(x)), 1, within))


def _time_held(problem: Problem, fitted: Fitted) -> Held:
    names = present(problem, fitted)
    return lru_cache(lambda x: estimate_at(problem, names, fitted.position + x * PER_E))


def nearby(problem: Problem, fitted: Fitted) -> tuple[float, float]:
    """Return the positions of the correlation time that are searched while another unknown is held."""
    last = len(problem.table) - 1.0
    return max(fitted.position - NEARBY, 0.0), min(fitted.position + NEARBY, last)
