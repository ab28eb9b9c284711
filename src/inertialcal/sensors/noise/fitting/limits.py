"""Intervals and upper limits of noise terms by the profile of the cost, and the record that would show a missing term.

Terms are chosen first, and a record often shows flicker where a random walk is, or one of two: so an interval lets
the terms that were *not* chosen be there. It is the profile with white noise, flicker and a random walk all free, and
quantisation where it fits at all; intervals of the chosen terms alone hold the truth in 34 to 86 % where flicker meets
a walk, and N in 41 % where a rounded angle stays hidden. An interval holds the values at which the least cost over all
other unknowns rises by no more than ``stretch q / 2``: q is the point of chi-square with one degree of freedom,
``stretch`` the variance of the unknown over that for independent averaging times [1]_. The stretch is that of the terms
*at the end of the interval*: the more a slow term holds, the more neighbouring averaging times share. The interval is
unsymmetric where the cost is, and ends at zero where a term could be absent.

A term that is not shown is added with a held power. Its upper limit is where the cost has risen by the one-sided 95 %
point over its minimum, over all powers of the others: a rival chosen in its place may vanish. Where a choice with the
term in place of a rival is nearly as good, the limit in that choice (99.5 %) counts as well, and the larger is taken.
For Gauss-Markov noise it is the limit of sigma at the correlation time where it could hide best.

Choosing terms first has its price: where many records show a term, those that miss it are those in which it came out
small, so that a plain limit of 95 % holds in 77 to 91 % of *them*. So the limit allows for an estimate known to lie
below the size from which the term is named: the largest power p with
``P(estimate < found | p) >= 0.05 P(estimate < named from | p)`` [2]_; but not more than the power named in 99.5 % of
such records.

The record needed is that in which a term *at its upper limit* would have a power known to 25 %: the same averaging
times with the degrees of freedom of the longer record, and longer ones. An estimate: the planner computes the
uncertainty of a planned record exactly.

References
----------
.. [1] H. Geys, G. Molenberghs and L. M. Ryan, J. Am. Stat. Assoc. 94 (1999) 734: adjusted composite likelihood ratio.
.. [2] J. D. Lee, D. L. Sun, Y. Sun and J. E. Taylor, Ann. Stat. 44 (2016) 907: inference after a choice by the data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy import special

from ....core.estimate import Array
from ....core.results import Interval
from .._kernels import crossing_root, first_known
from .._kernels_limits import end_from, hidden, limit_from, ruled_out, stretch_at
from ..terms import Sinusoid
from .filtered import SHAPE
from .likelihood import (
    SINGULAR,
    SPACINGS,
    Fitted,
    Sandwich,
    covariance_of_runs,
    estimate,
    estimate_at,
    loop_of,
    places_of,
    sandwich,
    spread_at,
    time_at,
)
from .order import NAMES, PRICE, present, unknowns
from .problem import GAUSS_MARKOV, LINEAR, PER_E, Problem, Run, expected, exponentials_of, linear_columns
from .spread import HIDDEN, SAME_TAU

SMALLEST = 1e-9  # of the most that there is room for: a power that is not there
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at
NORMAL_BELOW = 0.1  # relative uncertainty, below which the logarithm of a value is taken as normal
WIDEST = 40.0  # of the logarithm of a power: beyond, there is no end
TOLERANCE = 0.01  # of the logarithm of an end, and of a limit in standard uncertainties
ROUGH = 0.1  # the same, where the stretch is taken
NEARBY = 16.0  # rows of the table of correlation times that are searched while another unknown is held
FIRST_STEP = 0.01  # of the logarithm of a power, towards an end
ROUNDING = 1e-15  # of the largest eigenvalue: directions that nothing tells of


def limit_and_record(
    problem: Problem, fitted: Fitted, at: int, sigma: Array, rival: Fitted | None = None
) -> tuple[float | None, float | None, Fitted]:
    """Return the one-sided 95 % upper limit of the power of a term that was not chosen [unit^2], and the record needed.

    Returns
    -------
    limit : float or None
        None where there is none.
    record : float or None
        Length of one record that shows a term of that power [s]; None beyond 2^24 times the present one.
    base : Fitted
        The choice that the limit holds next to: the one given, or its rival.
    """
    linear = at < len(problem.names)
    u, stretch = hidden(
        problem.columns, problem.table, problem.weight, fitted.powers, fitted.position, at, SMALLEST, PER_E, sigma,
        SINGULAR,
    )  # fmt: skip
    if np.isnan(u):  # the term has no part in any deviation, or all of one
        return None, None, fitted
    name = problem.names[at] if linear else GAUSS_MARKOV
    named = u * float(np.sqrt(PRICE * (unknowns((*NAMES[1:2], name)) - 1.0) / stretch))
    limit, stretch = _limit(problem, fitted, at, (u, stretch), named)
    if limit is None:
        return None, None, fitted
    base = fitted
    if rival is not None:
        other, _ = _limit(problem, rival, at, (u, stretch), None)
        if other is not None and other > limit:
            limit, base = other, rival
    return limit, record_needed(problem, fitted, at, limit, stretch), base


def _limit(
    problem: Problem, fitted: Fitted, at: int, scale: tuple[float, float], named: float | None
) -> tuple[float | None, float]:
    """Return the upper limit of a power next to the terms of a choice, and the stretch there."""
    (u, stretch), missed, linear = scale, named is not None, at < len(problem.names)
    wanted = fitted.powers > 0.0
    wanted[len(LINEAR) : -1] = wanted[at] = True
    near, powers = NEARBY if linear else 0.0, np.empty(len(wanted))
    loop = (problem.columns, problem.table, problem.variance, problem.weight, wanted, fitted.position, near, SPACINGS)
    x, best, least, short, position = ruled_out(*loop, at, u, named or 0.0, stretch, missed, ROUGH, powers)
    if np.isnan(x):
        return None, stretch
    stretch = stretch_of(problem, Fitted(powers, position, np.nan), at, linear)
    if not stretch > 0.0:  # nothing but a ramp is left, which does not scatter
        return None, stretch
    x = limit_from(*loop, at, u, best, least, short, missed, stretch, TOLERANCE)
    return (None if np.isnan(x) else best + x * u), stretch


@dataclass(frozen=True, eq=False)
class Held:
    """Least cost of a choice of terms with one of its powers held, or its correlation time where ``at`` is beyond."""

    problem: Problem
    names: tuple[str, ...]
    at: int
    within: tuple[float, float]  # Positions of the correlation time that are searched

    @property
    def places(self) -> list[int]:
        """Where the powers of the choice stand among all."""
        return places_of(self.problem, self.names)

    @cached_property
    def loop(self) -> tuple[Array, Array, float, float, Array, Array, Array, int]:
        """What loops take that find a root: see ``_kernels.limit_root``."""
        return loop_of(self.problem, self.names, self.at, self.within)

    def fit(self, value: float) -> Fitted:
        """Return the least cost with the power at a value, or the correlation time at a position."""
        if self.at > len(self.problem.names):
            return estimate_at(self.problem, self.names, value)
        return estimate(self.problem, self.names, self.at, value, 1, self.within)

    def crossing(
        self, start: float, first: float, least: float, step: float, target: float, furthest: float, tolerance: float
    ) -> float | None:
        """Return the distance from ``first`` at which twice the cost has risen by the target; None if it never does.

        Of the logarithm of a power over its start, or of the correlation time over that at a position.
        """
        found = crossing_root(*self.loop, PER_E, start, first, least, step, target, furthest, tolerance)
        return None if np.isnan(found) else found


def record_needed(problem: Problem, fitted: Fitted, at: int, power: float, stretch: float) -> float | None:
    """Return the length of one record that shows a term of that power [s]; None beyond 2^24 times the present one."""
    run, longest, columns, weight = longest_of(problem)
    powers = fitted.powers.copy()
    powers[at] = power
    lines = zip(problem.lines, powers[len(LINEAR) : -1].tolist(), strict=True)
    more = [expected(Sinusoid(1.0, frequency), longest) for frequency, size in lines if size > 0.0]
    if powers[-1] > 0.0:
        more += [*exponentials_of(np.array([time_at(problem, fitted.position)]), longest)]
    if more:
        columns = np.column_stack([columns, *more])
    kept = np.concatenate([powers[: len(LINEAR)], powers[len(LINEAR) :][powers[len(LINEAR) :] > 0.0]])
    doublings = first_known(columns, kept, weight, column_of(fitted, at), KNOWN**2 / stretch, ROUNDING)
    return run.length * 2.0**doublings if doublings <= DOUBLINGS else None


@lru_cache(2)
def longest_of(problem: Problem) -> tuple[Run, Run, Array, Array]:
    """Return the longest run, `longer_records` of it, and the columns of linear terms there; not to be changed."""
    run = max(problem.runs, key=lambda one: one.length)
    longest, weight = longer_records(run)
    return run, longest, linear_columns(longest), weight


def longer_records(run: Run) -> tuple[Run, Array]:
    """Return a record 2^24 times as long, and roots of half the degrees of freedom of records of 2^0 .. 2^24 times it.

    Those go with length over tau; a record of each length has an octave more than the one before. Shape (25, k + 24),
    zero at averaging times that a record does not have; not to be changed.
    """
    more = np.arange(DOUBLINGS + 1)
    m = np.concatenate([run.m, run.m[-1] * 2.0 ** more[1:]])
    ones = np.ones(len(m))
    inflation = np.concatenate([run.inflation, ones[:DOUBLINGS]])
    longest = Run(m, ones, ones, ones, run.interval, run.averaging, inflation, band=run.band)
    at, doublings = np.arange(len(m)), more[:, None]
    back = np.minimum(at, doublings)
    there = at < len(run.m) + doublings
    weight = 0.5 * run.edf[np.where(there, at - back, 0)] * 2.0 ** (doublings - back)
    return longest, np.sqrt(np.where(there, weight, 0.0))


def interval_of(problem: Problem, fitted: Fitted, at: int, bread: Sandwich, p: float) -> Interval:
    """Return the interval of a power [unit^2] or of the correlation time [s].

    A power ends at zero where its term could be absent; a time is open where the record does not bound it.
    """
    timed, column = at == len(fitted.powers), column_of(fitted, at)
    best = time_at(problem, fitted.position) if timed else float(fitted.powers[at])
    relative = float(bread.u[column]) / (1.0 if timed else best)
    if relative < NORMAL_BELOW:
        half = float(special.ndtri(0.5 * (1.0 + p))) * relative
        return Interval(best * np.exp(-half), best * np.exp(half), p)
    names, within, furthest = present(fitted), nearby(problem, fitted), (-WIDEST, WIDEST)
    held, start = Held(problem, names, at, within), best
    if timed:
        start = fitted.position
        furthest = (-fitted.position / PER_E, (len(problem.table) - 1.0 - fitted.position) / PER_E)
    target, step = float(special.chdtri(1.0, 1.0 - p)), min(2.0 * relative, 1.0)
    stretch = float(bread.stretch[column])
    lo, hi = (
        end_of(held, start, fitted.cost, stretch, target, float(np.copysign(step, far)), far)[0] for far in furthest
    )
    none = None if timed else 0.0
    return Interval(none if lo is None else best * np.exp(lo), None if hi is None else best * np.exp(hi), p)


def wide_interval(
    problem: Problem, fitted: Fitted, at: int, names: tuple[str, ...], stretch: float, p: float
) -> Interval:
    """Return the interval of a power with more terms free than were chosen; it holds what was estimated [unit^2]."""
    within = nearby(problem, fitted)
    least = estimate(problem, names, within=within)
    if fitted.cost < least.cost:
        least = fitted
    own = problem.names[at] if at < len(problem.names) else GAUSS_MARKOV
    without = estimate(problem, tuple(name for name in names if name != own), looks=1)
    start, best = float(fitted.powers[at]), float(least.powers[at])
    target = float(special.chdtri(1.0, 1.0 - p))
    wanted, powers = np.zeros(len(fitted.powers), dtype=bool), np.empty(len(fitted.powers))
    wanted[places_of(problem, names)] = True
    loop = (problem.columns, problem.table, problem.variance, problem.weight, wanted, fitted.position, NEARBY, SPACINGS)

    def end(first: float, furthest: float) -> float | None:
        given, step = (*loop, at, PER_E, start), math.copysign(FIRST_STEP, furthest)
        x, position = end_from(*given, first, least.cost, step, target * stretch, furthest, ROUGH, powers)
        if np.isnan(x):
            return None
        own = target * stretch_of(problem, Fitted(powers, position, np.nan), at)
        x, _ = end_from(*given, first, least.cost, step, own, furthest, TOLERANCE, powers)
        return None if np.isnan(x) else start * math.exp(first + x)

    ratio = float(np.log(best / start)) if best > 0.0 else -WIDEST
    absent = best <= 0.0 or 2.0 * (without.cost - least.cost) < target * stretch
    lo = None if absent else end(min(ratio, 0.0), -WIDEST)
    return Interval(lo or 0.0, end(max(ratio, 0.0), WIDEST), p)


def stretch_of(problem: Problem, fitted: Fitted, at: int, timed: bool = True) -> float:
    """Return the stretch of a power, with the covariance that the fitted terms imply."""
    return stretch_at(
        problem.columns, problem.table, problem.weight, fitted.powers, fitted.position, at, timed, PER_E,
        *spread_at(problem, fitted).arrays, HIDDEN, SHAPE, problem.tau, SAME_TAU, problem.misfit, SINGULAR,
    )  # fmt: skip


def end_of(
    held: Held, start: float, least: float, stretch: float, target: float, step: float, furthest: float
) -> tuple[float | None, float]:
    """Return the distance at which the cost has risen by the target, None if it never does, and the stretch there."""
    problem, at = held.problem, held.at

    def fit(x: float) -> Fitted:
        return held.fit(start + x * PER_E if at > len(problem.names) else start * float(np.exp(x)))

    nearest = fit(0.0).cost
    if 2.0 * (nearest - least) >= target * stretch:  # the search near the estimate does not reach the least
        least = nearest
    first = held.crossing(start, 0.0, least, step, target * stretch, furthest, ROUGH)
    if first is None:
        return None, stretch
    there = fit(first)
    if there.powers[min(at, len(there.powers) - 1)] <= 0.0:
        return first, stretch
    bread = sandwich(problem, there, covariance_of_runs(problem, there))
    stretch = float(bread.stretch[column_of(there, at)])
    step = first or step  # a rough root may be zero
    return held.crossing(start, 0.0, least, step, target * stretch, furthest, TOLERANCE), stretch


def column_of(fitted: Fitted, at: int) -> int:
    """Return where an unknown stands among those of ``slopes_of``."""
    return int(np.count_nonzero(fitted.powers[:at] > 0.0))


def nearby(problem: Problem, fitted: Fitted) -> tuple[float, float]:
    """Return the positions of the correlation time that are searched while another unknown is held."""
    last = len(problem.table) - 1.0
    return max(fitted.position - NEARBY, 0.0), min(fitted.position + NEARBY, last)
