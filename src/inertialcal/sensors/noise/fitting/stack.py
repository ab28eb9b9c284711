"""Series of one sampling fitted together: what a fit takes of all of them, stacked for loops over series."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels import Indices
from .._kernels_each import fit_each, know_each
from ..terms import GaussMarkov, Sinusoid, Term
from .likelihood import RULES, SPACINGS, Fitted, Sandwich, column_at, terms_wanted, time_at
from .problem import LINEAR, Problem
from .spread import Arrays, Spread, Triple, spread_of, spread_with, spreads_beside

Fill = Callable[[Indices, Indices, Arrays, Triple, Array, NDArray[np.bool_], Array], None]


@dataclass(frozen=True, eq=False)
class Stack:
    """Problems that share columns, table and numbers of windows."""

    problems: tuple[Problem, ...]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.problems)

    def take(self, at: Sequence[int]) -> Stack:
        """Return some of them."""
        return self if len(at) == len(self) else Stack(tuple([self.problems[i] for i in at]))

    @cached_property
    def shared(self) -> tuple[Array, Array, Array]:
        """Columns and table, and variances, weights and averaging times of each, shape (n, 3, k)."""
        one = self.problems[0]
        return one.columns, one.table, np.array([one.data for one in self.problems])

    @cached_property
    def misfits(self) -> Array:
        """Misfits, shape (n,)."""
        return np.array([one.misfit for one in self.problems])

    @cached_property
    def plain(self) -> Arrays:
        """What powers of linear terms and lines are multiplied with in a covariance."""
        return stacked([spread_of(one.runs, one.lines) for one in self.problems])

    def beside(self, there: NDArray[np.bool_], positions: Array) -> Arrays:
        """Return the same of the terms that are there beside Gauss-Markov noise, at a position of each series."""
        first = self.problems[0]
        terms: list[Term] = [term(1.0) for term, one in zip(LINEAR, there, strict=False) if one]
        terms += [Sinusoid(1.0, line) for line, one in zip(first.lines, there[len(LINEAR) : -1], strict=True) if one]
        times = [time_at(first, position) for position in positions.tolist()]
        if len(first.runs) == 1 and first.runs[0].band is None and not first.lines:
            return spreads_beside([one.runs[0] for one in self.problems], tuple(terms), np.array(times))
        return stacked(
            [
                spread_with(one.runs, (*terms, GaussMarkov(1.0, time)))
                for one, time in zip(self.problems, times, strict=True)
            ]
        )


def stacks(problems: Sequence[Problem]) -> list[list[int]]:
    """Return places of those that can be stacked."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, one in enumerate(problems):
        numbers = tuple([run.n.tobytes() for run in one.runs])
        alike.setdefault((id(one.columns), id(one.table), one.lines, numbers), []).append(i)
    return list(alike.values())


def stacked(spreads: Sequence[Spread]) -> Arrays:
    """Return spreads of one shape with a leading axis, of length 1 where all are the same."""
    first = spreads[0]

    def one_or_all(arrays: Sequence[Array]) -> Array:
        return arrays[0][None] if all(one is arrays[0] for one in arrays) else np.array(arrays)

    squares, parts, doubt = (
        one_or_all([getattr(one, name) for one in spreads]) for name in ("squares", "parts", "doubt")
    )
    return first.pairs, first.runs, (squares, parts, doubt)


def estimate_each(stack: Stack, wanted: Sequence[Sequence[str]], looks: int = 2) -> list[Fitted]:
    """Return the least cost of a choice of terms of each series, as ``likelihood.estimate``."""
    count = len(stack.problems[0].lines)
    some = np.array([terms_wanted(tuple(one), count) for one in wanted])
    powers, fitted = np.empty(some.shape), np.empty((len(some), 2))
    fit_each(*stack.shared, some, SPACINGS[: 1 + looks], powers, fitted)
    return [Fitted(own, *one) for own, one in zip(powers, fitted.tolist(), strict=True)]


def means_of(stack: Stack, fits: Sequence[Fitted]) -> Array:
    """Return the expected Allan variances of fits with the same terms, shape (n, k), as ``likelihood.mean_of``."""
    powers = np.array([one.powers for one in fits])
    found: Array = (powers[:, None, :-1] * stack.problems[0].columns).sum(axis=2)
    if powers[0, -1] > 0.0:
        found += powers[:, -1:] * [column_at(stack.problems[0], one.position) for one in fits]
    return found


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of the fits of series in which the same terms are there."""

    powers: Array  # shape (n, p + 1)
    fitted: Array  # shape (n, 2): Positions and costs
    sigma: Array  # shape (n, k, k): Covariance of the Allan variances
    covariance: Array  # shape (n, q, q): Both of ``Sandwich``
    naive: Array
    tests: Array  # shape (n, 2): Sum of squares of the residuals and its degrees of freedom, 0 for none

    def bread(self, i: int) -> Sandwich:
        """Return the covariance of the unknowns of one."""
        return Sandwich(self.covariance[i], self.naive[i])


def know(stack: Stack, fits: Sequence[Fitted], small: float) -> Known:
    """Return what is known of fits with the same terms."""
    powers, fitted = np.array([one.powers for one in fits]), np.array([one[1:] for one in fits])
    there = powers[0] > 0.0
    spreads = stack.beside(there, fitted[:, 0]) if there[-1] else stack.plain
    n, k, q = len(stack), len(stack.shared[0]), int(np.count_nonzero(there)) + int(there[-1])
    sigma, covariance, naive, tests = np.empty((n, k, k)), np.empty((n, q, q)), np.empty((n, q, q)), np.empty((n, 2))
    know_each(*stack.shared, stack.misfits, RULES, small, *spreads, powers, fitted, sigma, covariance, naive, tests)
    return Known(powers, fitted, sigma, covariance, naive, tests)


def complete(stack: Stack, fill: Fill, count: int, powers: Array, positions: Array) -> None:
    """Let chains of all series do all their steps, with what they meet beside Gauss-Markov noise.

    What they will meet first are ``powers`` and ``positions``; where one meets others it stops, and goes on with them.
    """
    steps, ended = np.zeros(len(stack), np.int64), np.empty((len(stack), powers.shape[1] + 1))
    ended[:, :-1], ended[:, -1] = powers, positions
    left = np.arange(len(stack))
    while len(left):
        there = ended[left, :-1] > 0.0
        patterns: dict[bytes, list[int]] = {}
        for i, one in zip(left.tolist(), there, strict=True):
            patterns.setdefault(one.tobytes(), []).append(i)
        for pattern, places in patterns.items():
            some, at = np.frombuffer(pattern, dtype=np.bool_).copy(), np.array(places)
            beside, beside_at = stack.plain[2], np.full(len(at), np.nan)
            if some[-1]:
                beside_at = ended[at, -1]
                beside = stack.take(places).beside(some, beside_at)[2]
            fill(at, steps, stack.plain, beside, beside_at, some, ended)
        left = np.flatnonzero(steps < count)
