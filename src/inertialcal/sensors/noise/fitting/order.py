"""Which terms a record shows: the choice of least criterion among all.

The criterion is ``2 cost + 10.8 q`` with q unknowns. The price of an unknown is the 99.9 % point of chi-square with one
degree of freedom; because neighbouring averaging times repeat each other and the cost counts them as independent, and
because there are many candidates, it amounts to that fewer than one in twenty records of white noise show any other
term (simulated, 1,000 to 200,000 samples). A ramp is one path of many that a random walk takes, and counts as two
unknowns: it is named only where it beats a walk clearly.

All choices of the linear terms are tried, each with white noise also with one Gauss-Markov term. A choice in which a
coefficient comes out as zero is the smaller one. Terms that look alike under this sampling (quantisation and white
noise where there is dead time) are not both candidates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ..terms import Quantization, RandomWalk, RateRamp
from .likelihood import Fitted, estimate, estimate_each
from .problem import GAUSS_MARKOV, LINEAR, Problem

PRICE = 10.83  # of one unknown: 99.9 % point of chi-square with one degree of freedom
PLAUSIBLE = 2.0 * PRICE  # worse by less than this, a choice may well be the true one
NEARER = PRICE - 2.0  # the same with one of `SUPPLE`
ALIKE = 1e-6  # relative difference of what terms give that look alike
RAMP_COUNTS = 1  # unknowns that a ramp counts beyond its own

NAMES = tuple(term.name for term in LINEAR)
BITS = 2 ** np.arange(len(NAMES))
SUPPLE = frozenset({RateRamp.name, GAUSS_MARKOV})  # give much of what a walk gives: an unknown more fits any record


@dataclass(frozen=True)
class Choice:
    """One choice of terms."""

    terms: tuple[str, ...]  # Their names
    criterion: float  # Less is better; differences alone mean something
    fitted: Fitted  # Their sizes


@cache
def choices(candidates: tuple[str, ...]) -> tuple[tuple[tuple[str, ...], ...], NDArray[np.bool_]]:
    """Return all choices of linear candidates, the smallest first, and which of all each holds, shape (c, 5)."""
    linear = tuple(name for name in NAMES if name in candidates)
    found = tuple(some for size in range(1, len(linear) + 1) for some in combinations(linear, size))
    return found, np.array([[name in some for name in NAMES] for some in found]).reshape(-1, len(NAMES))


def ranked(problem: Problem, candidates: tuple[str, ...]) -> tuple[Choice, ...]:
    """Return the different choices, best first.

    With Gauss-Markov noise, those are left out that could not be nearly best: no choice has less cost than all terms.
    """
    linear, wanted_each = choices(candidates)
    powers, costs = estimate_each(problem, wanted_each)
    names = named_each(powers)
    fits: dict[tuple[str, ...], Fitted] = {}
    for i in np.argsort(costs, kind="stable").tolist():
        if names[i] and names[i] not in fits and costs[i] < np.inf:
            fits[names[i]] = Fitted(powers[i], 0.0, float(costs[i]))

    def add(fitted: Fitted) -> Fitted:
        there = present(fitted)
        if there and np.isfinite(fitted.cost) and (there not in fits or fitted.cost < fits[there].cost):
            fits[there] = fitted
        return fitted

    if GAUSS_MARKOV in candidates:
        every = add(estimate(problem, candidates, looks=1))
        best = min(criterion(there, fitted) for there, fitted in fits.items())
        for some in linear:
            wanted = (*some, GAUSS_MARKOV)
            plain = RandomWalk.name in some or RandomWalk.name not in candidates
            if plain and 2.0 * every.cost + PRICE * unknowns(wanted) < best + NEARER:
                add(estimate(problem, wanted, looks=1))
    found = [Choice(there, criterion(there, fitted), fitted) for there, fitted in fits.items()]
    return tuple(sorted(found, key=lambda choice: choice.criterion))


@cache
def unknowns(terms: tuple[str, ...]) -> int:
    """Return how many unknowns the criterion counts."""
    return len(terms) + (GAUSS_MARKOV in terms) + RAMP_COUNTS * (RateRamp.name in terms)


def present(fitted: Fitted) -> tuple[str, ...]:
    """Return the names of terms with a positive power; lines are not among them."""
    return named_each(fitted.powers[None])[0]


def named_each(powers: Array) -> list[tuple[str, ...]]:
    """Return the same of rows of powers, shape (c, p + 1)."""
    there = powers > 0.0
    bits = there[:, : len(NAMES)] @ BITS + there[:, -1] * 2 ** len(NAMES)
    return [_named(each) for each in bits.tolist()]


@cache
def _named(bits: int) -> tuple[str, ...]:
    return tuple(name for i, name in enumerate((*NAMES, GAUSS_MARKOV)) if bits >> i & 1)


def criterion(terms: tuple[str, ...], fitted: Fitted) -> float:
    """Return the criterion of a choice: less is better; differences alone mean something."""
    return 2.0 * fitted.cost + PRICE * unknowns(terms)


def separable(problem: Problem, candidates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the candidates without quantisation, where it looks like white noise or like a filter's pole."""
    if any(run.band is not None for run in problem.runs):
        return tuple(name for name in candidates if name != Quantization.name) or candidates
    rounding, white = (problem.columns[:, NAMES.index(term.name)] for term in (Quantization, RandomWalk))
    share = white / white[0]
    alike = bool((np.abs(rounding / rounding[0] - share) <= ALIKE * share).all())
    both = {Quantization.name, RandomWalk.name} <= set(candidates)
    return tuple(name for name in candidates if not (alike and both and name == Quantization.name))
