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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ....core.estimate import Array
from ....core.results import Interval
from .._kernels import crossing_root
from .._kernels_chain import fill_ends, fill_limits
from ..terms import Sinusoid
from .filtered import SHAPE, Band
from .likelihood import (
    SINGULAR,
    SPACINGS,
    Fitted,
    Sandwich,
    covariance_of_runs,
    estimate,
    estimate_at,
    loop_of,
    sandwich,
    terms_wanted,
    time_at,
    unit_terms,
)
from .order import NAMES, PRICE, present, unknowns
from .problem import (
    GAUSS_MARKOV,
    LINEAR,
    PER_E,
    Problem,
    Run,
    Sampling,
    expected,
    exponentials_of,
    linear_columns,
    run_that_took,
)
from .spread import HIDDEN, SAME_TAU, Arrays, spread_of, spread_with

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
RULES = PER_E, HIDDEN, SHAPE, SAME_TAU, SINGULAR
CLOSENESS = NEARBY, ROUGH, TOLERANCE
# By how much the criterion falls with each term besides white noise where it is named
NAMED_BY = tuple(PRICE * (unknowns((NAMES[1], name)) - 1.0) for name in (*NAMES, GAUSS_MARKOV))


class Missing(NamedTuple):
    """A term that was not chosen."""

    at: int  # Its place among the powers
    position: float  # Of the correlation time in the table
    rival: Fitted | None = None  # A choice with it that is nearly as good


def limits_and_records(
    problem: Problem, fitted: Fitted, missing: Sequence[Missing], sigma: Array
) -> list[tuple[float | None, float | None, bool]]:
    """Return what is to be said of the powers of terms that were not chosen.

    Returns
    -------
    limit : float or None
        One-sided 95 % upper limit [unit^2]; None where there is none.
    record : float or None
        Length of one record that shows a term of that power [s]; None beyond 2^24 times the present one.
    beside_rival : bool
        Whether the limit holds next to the terms of the rival.
    """
    none, count = np.zeros(len(fitted.powers)), len(problem.names)
    run = max(problem.runs, key=lambda one: one.length) if len(problem.runs) > 1 else problem.runs[0]
    markov = [one for one in missing if one.at == count]
    position = markov[0].position if markov else fitted.position
    longest = columns_of_longest(problem, run, fitted, position if markov or fitted.powers[-1] > 0.0 else None)
    found = np.empty((len(missing), 4))
    ats, positions = np.array([one.at for one in missing]), np.array([one.position for one in missing])
    rivals = [none if one.rival is None else one.rival.powers for one in missing]
    rival_at = np.array([0.0 if one.rival is None else one.rival.position for one in missing])
    named = np.array([NAMED_BY[min(one.at, len(LINEAR))] for one in missing])

    def fill(plain: Arrays, beside: Arrays, beside_at: float, there: NDArray[np.bool_], first: int, to: Array) -> int:
        return fill_limits(
            problem.arrays, problem.misfit, RULES, SPACINGS, CLOSENESS, plain, beside, beside_at, there,
            len(problem.lines), fitted.powers, positions, ats, sigma, SMALLEST, named, np.array(rivals), rival_at,
            longest, run.edf, DOUBLINGS, KNOWN, ROUNDING, first, found, to,
        )  # fmt: skip

    likely = fitted
    if markov:
        powers = fitted.powers.copy()
        powers[-1] = 1.0
        likely = Fitted(powers, position, fitted.cost)
    complete(problem, fill, 2 * len(missing), likely)
    return [
        (None if math.isnan(limit) else limit, run.length * 2.0**more if more <= DOUBLINGS else None, rival > 0.0)
        for limit, more, rival, _ in found.tolist()
    ]


def complete(problem: Problem, fill: Callable[..., int], count: int, likely: Fitted) -> None:
    """Let a chain do all its steps, with the covariance of those powers beside Gauss-Markov noise that it meets.

    Those that it will meet first are ``likely``.
    """
    plain, ended, first = spread_of(problem.runs, problem.lines).arrays, np.empty(len(problem.names) + 2), 0
    beside, position, there = plain, np.nan, likely.powers > 0.0
    while first < count:
        if there[-1]:
            beside, position = spread_with(problem.runs, unit_terms(problem, likely)).arrays, likely.position
        first = fill(plain, beside, position, there, first, ended)
        likely = Fitted(ended[:-1].copy(), float(ended[-1]), np.nan)
        there = likely.powers > 0.0


@dataclass(frozen=True, eq=False)
class Held:
    """Least cost of a choice of terms with one of its powers held, or its correlation time where ``at`` is beyond."""

    problem: Problem
    names: tuple[str, ...]
    at: int
    within: tuple[float, float]  # Positions of the correlation time that are searched

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


def columns_of_longest(problem: Problem, run: Run, fitted: Fitted, position: float | None) -> Array:
    """Return the Allan variance of each term of size 1 in a record 2^24 times as long as a run, shape (k + 24, p + 1).

    Lines and Gauss-Markov noise have zeros where they take no part.
    """
    longest, linear = _longest(run.taken[0], run.band)
    columns = np.zeros((len(longest.m), len(fitted.powers)))
    columns[:, : len(LINEAR)] = linear
    for i, frequency in enumerate(problem.lines):
        if fitted.powers[len(LINEAR) + i] > 0.0:
            columns[:, len(LINEAR) + i] = expected(Sinusoid(1.0, frequency), longest)
    if position is not None:
        columns[:, -1] = exponentials_of(np.array([time_at(problem, position)]), longest)[0]
    return columns


@lru_cache(16)  # records of one length share it
def _longest(sampling: Sampling, band: Band | None) -> tuple[Run, Array]:
    """Return a record 2^24 times as long, and the columns of linear terms there; not to be changed."""
    run = run_that_took((sampling, b"", band, None))
    m = np.concatenate([run.m, run.m[-1] * 2.0 ** np.arange(1, DOUBLINGS + 1)])
    ones = np.ones(len(m))
    inflation = np.concatenate([run.inflation, ones[:DOUBLINGS]])
    longest = Run(m, ones, ones, ones, run.interval, run.averaging, inflation, band=run.band)
    return longest, linear_columns(longest)


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


def wide_intervals(
    problem: Problem, fitted: Fitted, ats: Sequence[int], names: tuple[str, ...], stretches: Sequence[float], p: float
) -> list[Interval]:
    """Return intervals of powers with more terms free than were chosen; they hold what was estimated [unit^2]."""
    target, found = float(special.chdtri(1.0, 1.0 - p)), np.empty((len(ats), 2))
    at, stretch, free = np.array(ats), np.array(stretches), terms_wanted(names, len(problem.lines))

    def fill(plain: Arrays, beside: Arrays, beside_at: float, there: NDArray[np.bool_], first: int, to: Array) -> int:
        return fill_ends(
            problem.arrays, problem.misfit, RULES, SPACINGS, CLOSENESS, plain, beside, beside_at, there, free,
            fitted.powers, fitted.position, fitted.cost, at, stretch, target, FIRST_STEP, WIDEST, first, found, to,
        )  # fmt: skip

    complete(problem, fill, 2 * len(ats), fitted)
    none = np.isnan(found).tolist()
    return [
        Interval(0.0 if low else lo, None if open_ else hi, p)
        for (lo, hi), (low, open_) in zip(found.tolist(), none, strict=True)
    ]


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
