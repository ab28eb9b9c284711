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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ....core.estimate import Array
from ....core.results import Interval
from .._kernels import POWER, SEEN, TIME, Indices, root_of
from .._kernels_each import end_each, limit_each
from ..terms import Sinusoid
from .filtered import Band
from .likelihood import (
    NEARBY,
    ROUGH,
    RULES,
    SPACINGS,
    TOLERANCE,
    Fitted,
    Sandwich,
    covariance_of_runs,
    estimate,
    estimate_at,
    sandwich,
    terms_wanted,
    time_at,
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
from .spread import Arrays, Triple
from .stack import Stack, complete

SMALLEST = 1e-9  # of the most that there is room for: a power that is not there
KNOWN = 0.25  # relative uncertainty of a power in the record needed
DOUBLINGS = 24  # of the record that are looked at
NORMAL_BELOW = 0.1  # relative uncertainty, below which the logarithm of a value is taken as normal
WIDEST = 40.0  # of the logarithm of a power: beyond, there is no end
FIRST_STEP = 0.01  # of the logarithm of a power, towards an end
ROUNDING = 1e-15  # of the largest eigenvalue: directions that nothing tells of
# By how much the criterion falls with each term besides white noise where it is named
NAMED_BY = tuple(PRICE * (unknowns((NAMES[1], name)) - 1.0) for name in (*NAMES, GAUSS_MARKOV))


class Missing(NamedTuple):
    """A term that was not chosen."""

    at: int  # Its place among the powers
    position: float  # Of the correlation time in the table
    rival: Fitted | None = None  # A choice with it that is nearly as good


Limit = tuple[float | None, float | None, bool]


def limits_and_records(
    problem: Problem, fitted: Fitted, missing: Sequence[Missing], sigma: Array
) -> list[Limit]:  # fmt: skip
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
    return limits_of_many(Stack((problem,)), [fitted], [missing], sigma[None])[0]


def limits_of_many(
    stack: Stack, fits: Sequence[Fitted], missing: Sequence[Sequence[Missing]], sigma: Array
) -> list[list[Limit]]:
    """Return the same of fits of the same terms, each of which misses the same; covariances of shape (n, k, k)."""
    problem, each, ats = stack.problems[0], range(len(stack)), np.array([one.at for one in missing[0]])
    none, count = np.zeros(len(fits[0].powers) + 1), len(problem.names)
    longest = max(range(len(problem.runs)), key=lambda i: problem.runs[i].length)
    runs = [one.runs[longest] for one in stack.problems]
    powers = np.array([one.powers for one in fits])
    positions = np.array([[one.position for one in of] for of in missing])
    given = [[one.rival for one in of] for of in missing]
    rivals = np.array([[none if one is None else [*one.powers, one.position] for one in of] for of in given])
    named = np.array([NAMED_BY[min(at, len(LINEAR))] for at in ats.tolist()])
    markov = np.flatnonzero(ats == count)
    likely, at = powers.copy(), positions[:, markov[0]] if len(markov) else np.array([one.position for one in fits])
    likely[:, -1] = 1.0 if len(markov) else powers[:, -1]
    columns = columns_of_longest(problem, runs[0], likely[0], at)
    roots, found = longer(np.array([one.edf for one in runs])), np.empty((len(stack), len(ats), 4))

    def fill(
        places: Indices, steps: Indices, plain: Arrays, beside: Triple, beside_at: Array, there: NDArray[np.bool_],
        ended: Array,
    ) -> None:  # fmt: skip
        limit_each(
            places, steps, *stack.shared, stack.misfits, RULES, SPACINGS, *plain, beside, beside_at, there,
            len(problem.lines), powers, positions, ats, sigma, SMALLEST, named, rivals, columns, roots, KNOWN, ROUNDING,
            found, ended,
        )  # fmt: skip

    complete(stack, fill, 2 * len(ats), likely, at)
    lengths, rows = [one.length for one in runs], found.tolist()
    return [
        [
            (None if math.isnan(limit) else limit, lengths[i] * 2.0**more if more <= DOUBLINGS else None, rival > 0.0)
            for limit, more, rival, _ in rows[i]
        ]
        for i in each
    ]


def longer(edf: Array) -> Array:
    """Return the roots of half the degrees of freedom of records of 2^0 .. 2^24 times the present one.

    Those go with length over tau; a record of each length has an octave more than the one before. Of edf (n, k) the
    shape is (n, 25, k + 24), zero at averaging times that a record does not have.
    """
    k, more = edf.shape[1], np.arange(DOUBLINGS + 1)[:, None]
    octave = np.arange(k + DOUBLINGS)
    back = np.minimum(octave, more)
    there = octave < k + more
    return np.asarray(np.sqrt(0.5 * edf[:, np.where(there, octave - back, 0)] * 2.0 ** (more - back)) * there)


@dataclass(frozen=True, eq=False)
class Held:
    """Least cost of a choice of terms with one of its powers held, or its correlation time where ``at`` is beyond."""

    problem: Problem
    names: tuple[str, ...]
    at: int
    within: tuple[float, float]  # Positions of the correlation time that are searched

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
        of, timed = self.problem, self.at > len(self.problem.names)
        wanted, powers = terms_wanted(self.names, len(of.lines)), np.empty(len(of.names) + 1)
        found = root_of(
            of.columns, of.table, of.data, wanted, self.at, *self.within, SPACINGS[:2], TIME if timed else POWER, start,
            PER_E if timed else first, least, step, target, furthest, 0.0, tolerance, powers,
            np.full(SEEN, np.nan),
        )  # fmt: skip
        return None if np.isnan(found) else found


def columns_of_longest(problem: Problem, run: Run, powers: Array, positions: Array) -> Array:
    """Return the Allan variance of each term of size 1 in a record 2^24 times as long as a run, (n, k + 24, p + 1).

    Gauss-Markov noise has a position for each of the n. It and lines have zeros where they take no part.
    """
    longest, linear = _longest(run.taken[0], run.band)
    columns = np.zeros((len(positions), len(longest.m), len(powers)))
    columns[:, :, : len(LINEAR)] = linear
    for i, frequency in enumerate(problem.lines):
        if powers[len(LINEAR) + i] > 0.0:
            columns[:, :, len(LINEAR) + i] = expected(Sinusoid(1.0, frequency), longest)
    if powers[-1] > 0.0:
        own, of = np.unique(positions, return_inverse=True)
        columns[:, :, -1] = exponentials_of(np.array([time_at(problem, one) for one in own.tolist()]), longest)[of]
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
        return Interval(*normal_ends(best, relative, p), p)
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


@lru_cache(64)
def normal_point(p: float) -> float:
    """Return how many standard deviations a normal interval of a probability reaches."""
    return float(special.ndtri(0.5 * (1.0 + p)))


def normal_ends(best: float, relative: float, p: float) -> tuple[float, float]:
    """Return the interval of a value whose logarithm is normal, with that standard uncertainty."""
    half = normal_point(p) * relative
    return best * math.exp(-half), best * math.exp(half)


def wide_intervals(
    problem: Problem, fitted: Fitted, ats: Sequence[int], names: tuple[str, ...], stretches: Sequence[float], p: float
) -> list[Interval]:
    """Return intervals of powers with more terms free than were chosen; they hold what was estimated [unit^2]."""
    found = wide_of_many(Stack((problem,)), [fitted], ats, [names], np.array([stretches]), p)[0]
    return [Interval(lo, hi, p) for lo, hi in found]


def wide_of_many(
    stack: Stack, fits: Sequence[Fitted], ats: Sequence[int], names: Sequence[tuple[str, ...]], stretches: Array,
    p: float,
) -> list[list[tuple[float, float | None]]]:  # fmt: skip
    """Return the ends of the same of fits of the same terms; stretches of shape (n, number of powers)."""
    target, found = float(special.chdtri(1.0, 1.0 - p)), np.empty((len(stack), len(ats), 2))
    at, lines = np.array(ats, np.int64), len(stack.problems[0].lines)
    free = np.array([terms_wanted(one, lines) for one in names])
    powers, fitted = np.array([one.powers for one in fits]), np.array([one[1:] for one in fits])
    stretches = np.ascontiguousarray(stretches)

    def fill(
        places: Indices, steps: Indices, plain: Arrays, beside: Triple, beside_at: Array, there: NDArray[np.bool_],
        ended: Array,
    ) -> None:  # fmt: skip
        end_each(
            places, steps, *stack.shared, stack.misfits, RULES, SPACINGS, *plain, beside, beside_at, there, free,
            powers, fitted, at, stretches, target, FIRST_STEP, WIDEST, found, ended,
        )  # fmt: skip

    complete(stack, fill, 2 * len(ats), powers, fitted[:, 0])
    return [
        [(0.0 if math.isnan(lo) else lo, None if math.isnan(hi) else hi) for lo, hi in own] for own in found.tolist()
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
