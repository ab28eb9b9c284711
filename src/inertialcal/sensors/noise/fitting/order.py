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

from functools import cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels_each import rank_each
from ..terms import Quantization, RandomWalk, RateRamp
from .likelihood import SPACINGS, Fitted, terms_wanted
from .problem import GAUSS_MARKOV, LINEAR, Problem
from .stack import Stack

PRICE = 10.83  # of one unknown: 99.9 % point of chi-square with one degree of freedom
PLAUSIBLE = 2.0 * PRICE  # worse by less than this, a choice may well be the true one
NEARER = PRICE - 2.0  # the same with one of `SUPPLE`
ALIKE = 1e-6  # relative difference of what terms give that look alike
RAMP_COUNTS = 1  # unknowns that a ramp counts beyond its own

NAMES = tuple(term.name for term in LINEAR)
BITS = 2 ** np.arange(len(NAMES))
MOST = 2 ** (len(NAMES) + 1)  # choices, each with Gauss-Markov noise and without
SUPPLE = frozenset({RateRamp.name, GAUSS_MARKOV})  # give much of what a walk gives: an unknown more fits any record


class Choice(NamedTuple):
    """One choice of terms."""

    terms: tuple[str, ...]  # Their names
    criterion: float  # Less is better; differences alone mean something
    # Their sizes
    powers: Array
    position: float
    cost: float

    @property
    def fitted(self) -> Fitted:
        """Their sizes."""
        return Fitted(*self[2:])


@cache
def choices(candidates: tuple[str, ...], lines: int) -> NDArray[np.bool_]:
    """Return which terms each choice of linear candidates holds, the smallest first, with lines, shape (c, p + 1)."""
    linear = tuple(name for name in NAMES if name in candidates)
    found = (some for size in range(1, len(linear) + 1) for some in combinations(linear, size))
    return np.array([terms_wanted(some, lines) for some in found]).reshape(-1, len(NAMES) + lines + 1)


def ranked(stack: Stack, candidates: tuple[str, ...]) -> list[tuple[Choice, ...]]:
    """Return the different choices of each series, best first.

    With Gauss-Markov noise, those are left out that could not be nearly best: no choice has less cost than all terms.
    """
    first = stack.problems[0]
    n, lines = len(stack), len(first.lines)
    powers, fits, counts = np.empty((n, MOST, len(first.names) + 1)), np.empty((n, 3, MOST)), np.empty(n, np.int64)
    rank_each(
        *stack.shared, choices(candidates, lines), terms_wanted(candidates, lines), SPACINGS[:2], PRICE, NEARER, powers,
        fits, counts,
    )  # fmt: skip
    positions, costs, criteria = fits.transpose(1, 0, 2).tolist()
    each = zip(counts.tolist(), criteria, powers, positions, costs, strict=True)
    bits = _bits(powers)
    return [
        tuple(map(Choice, map(_named, row[:count]), own[:count], rows, at, cost))
        for row, (count, own, rows, at, cost) in zip(bits, each, strict=True)
    ]


@cache
def unknowns(terms: tuple[str, ...]) -> int:
    """Return how many unknowns the criterion counts."""
    return len(terms) + (GAUSS_MARKOV in terms) + RAMP_COUNTS * (RateRamp.name in terms)


def present(fitted: Fitted) -> tuple[str, ...]:
    """Return the names of terms with a positive power; lines are not among them."""
    return _named(_bits(fitted.powers[None, None])[0][0])


def _bits(powers: Array) -> list[list[int]]:
    """Return which terms are there, as bits of `_named`, of powers of shape (n, c, p + 1)."""
    there = powers > 0.0
    found: list[list[int]] = (there[..., : len(NAMES)] @ BITS + there[..., -1] * 2 ** len(NAMES)).tolist()
    return found


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
