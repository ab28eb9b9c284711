"""Estimate of noise terms from overlapping Allan variances, and its covariance.

Assumed: the noise is normal and a sum of independent terms (``terms``); bumps and warm-up are already removed. Each
Allan variance s is taken as gamma distributed about its expectation mu with edf degrees of freedom, and averaging times
as independent: the cost is sum of (edf / 2) (ln mu + s / mu). Its minimum is unbiased to first order whatever the
weights, because each s is. mu is linear in the squared coefficients, which are not negative (Fisher scoring with an
active set); correlation times are searched over the whole record.

The correlation of averaging times enters the covariance, in sandwich form [1]_. With D the slopes of mu, W the weights
edf / (2 mu^2) and Sigma the covariance of the Allan variances that the fitted terms imply::

    H = D' W D,    J = D' W Sigma W D,    covariance = H^-1 J H^-1

Taken as independent, intervals of nominal 95 % cover 72 to 84 %. Several runs are stacked: common terms, independent
noise.

Sigma is that of ``spread``.

References
----------
.. [1] C. Varin, N. Reid and D. Firth, Statistica Sinica 21 (2011) 5: composite likelihood, Godambe information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from .._kernels import fill_sandwich, fit_of
from .._kernels_limits import fill_bread, interpolate
from ..terms import GaussMarkov, Sinusoid, Term
from .filtered import SHAPE
from .problem import GAUSS_MARKOV, LINEAR, PER_E, Problem
from .spread import HIDDEN, NONE, SAME_TAU, Spread, spread_of, spread_with

SPACINGS = np.array([5.0, 1.67, 0.3])  # rows between correlation times that are tried, ever closer about the best
SINGULAR = 1e-12  # of the largest eigenvalue: directions that nothing tells of
NEARBY = 16.0  # rows of the table of correlation times that are searched while another unknown is held
TOLERANCE = 0.01  # of the logarithm of an end, and of a limit in standard uncertainties
ROUGH = 0.1  # the same, where the stretch is taken
RULES = PER_E, HIDDEN, SHAPE, SAME_TAU, SINGULAR, NEARBY, ROUGH, TOLERANCE  # what loops take of these


class Fitted(NamedTuple):
    """Least cost of one choice of terms."""

    powers: Array  # shape (p + 1,): Squared coefficients; that of Gauss-Markov noise is sigma^2, last
    position: float  # Of the correlation time in the table
    cost: float  # Sum of weight (ln mu + s / mu)


def estimate(
    problem: Problem,
    wanted: Sequence[str],
    held: int = -1,
    value: float = 0.0,
    looks: int = 2,
    within: tuple[float, float] | None = None,
) -> Fitted:
    """Return the least cost of a choice of terms; lines are always part of it."""
    lo, hi = (0.0, len(problem.table) - 1.0) if within is None else within
    powers = np.empty(len(problem.names) + 1)
    some = terms_wanted(tuple(wanted), len(problem.lines))
    position, cost = fit_of(
        problem.columns, problem.table, problem.data, some, held, value, lo, hi, SPACINGS[: 1 + looks], powers
    )
    return Fitted(powers, position, cost)


@lru_cache(64)  # few, again and again
def terms_wanted(wanted: tuple[str, ...], lines: int) -> NDArray[np.bool_]:
    """Return which of all terms take part, shape (p + 1,), lines among them, not to be changed."""
    names = [*(term.name for term in LINEAR), *[None] * lines, GAUSS_MARKOV]
    return np.array([name is None or name in wanted for name in names])


def estimate_at(problem: Problem, wanted: Sequence[str], position: float) -> Fitted:
    """Return the least cost at one correlation time."""
    return estimate(problem, wanted, within=(position, position))


def column_at(problem: Problem, position: float) -> Array:
    """Return the Allan variance of Gauss-Markov noise of sigma 1 at a position of the table, shape (k,)."""
    found = np.empty(problem.table.shape[1])
    interpolate(problem.table, position, found)
    return found


def time_at(problem: Problem, position: float) -> float:
    """Return the correlation time at a position of the table [s]."""
    return float(problem.times[0] * np.exp(position / PER_E))


def mean_of(problem: Problem, fitted: Fitted) -> Array:
    """Return the expected Allan variances, shape (k,)."""
    linear = np.asarray(problem.columns @ fitted.powers[:-1])
    return linear + fitted.powers[-1] * column_at(problem, fitted.position) if fitted.powers[-1] > 0.0 else linear


def terms_of(problem: Problem, fitted: Fitted) -> tuple[Term, ...]:
    """Return the terms with a positive coefficient."""
    return _terms(problem, fitted, np.sqrt(fitted.powers).tolist())


def unit_terms(problem: Problem, fitted: Fitted) -> tuple[Term, ...]:
    """Return the same with coefficients of 1."""
    return _terms(problem, fitted, [float(power > 0.0) for power in fitted.powers.tolist()])


def _terms(problem: Problem, fitted: Fitted, sizes: Sequence[float]) -> tuple[Term, ...]:
    found: list[Term] = [term(size) for term, size in zip(LINEAR, sizes, strict=False) if size > 0.0]
    lines = zip(problem.lines, sizes[len(LINEAR) : -1], strict=True)
    found += [Sinusoid(size, frequency) for frequency, size in lines if size > 0.0]
    if sizes[-1] > 0.0:
        found.append(GaussMarkov(sizes[-1], time_at(problem, fitted.position)))
    return tuple(found)


def slopes_of(problem: Problem, fitted: Fitted, timed: bool = True) -> Array:
    """Return the slopes of the expected Allan variances, shape (k, q).

    The q unknowns are the positive powers, and ln of the correlation time where there is one that was fitted
    (``timed``).
    """
    there = fitted.powers > 0.0
    if not there[-1]:
        return np.asarray(problem.columns[:, there[:-1]])
    columns = np.column_stack([problem.columns, column_at(problem, fitted.position)])[:, there]
    if not timed:
        return np.asarray(columns)
    return np.column_stack([columns, slopes_of_time(problem, fitted)])


def slopes_of_time(problem: Problem, fitted: Fitted) -> Array:
    """Return the slopes of the expected Allan variances by the logarithm of the correlation time, shape (k,)."""
    by = column_at(problem, fitted.position + 0.05) - column_at(problem, fitted.position - 0.05)
    return np.asarray(fitted.powers[-1] * by / 0.1 * PER_E)


def covariance_of_runs(problem: Problem, fitted: Fitted) -> Array:
    """Return the covariance of all Allan variances that fitted terms imply, shape (k, k).

    Runs are independent of each other but for the misfit, which is that of the sensor at an averaging time.
    """
    powers = fitted.powers[fitted.powers > 0.0] if fitted.powers[-1] > 0.0 else fitted.powers[:-1]
    left = problem.misfit * mean_of(problem, fitted) if problem.misfit > 0.0 else NONE
    return spread_at(problem, fitted).covariance(powers, left, problem.tau)


def spread_at(problem: Problem, fitted: Fitted) -> Spread:
    """Return what powers are multiplied with: of all linear terms, or of those there beside Gauss-Markov noise."""
    if fitted.powers[-1] > 0.0:
        return spread_with(problem.runs, unit_terms(problem, fitted))
    return spread_of(problem.runs, problem.lines)


def sandwich(problem: Problem, fitted: Fitted, sigma: Array, timed: bool = True) -> Sandwich:
    """Return the covariance of the unknowns of `slopes_of`, from that of the Allan variances."""
    q = int(np.count_nonzero(fitted.powers)) + (timed and fitted.powers[-1] > 0.0)
    covariance, naive = np.empty((q, q)), np.empty((q, q))
    fill_bread(
        problem.columns, problem.table, problem.weight, fitted.powers, fitted.position, timed, PER_E, sigma, SINGULAR,
        covariance, naive,
    )  # fmt: skip
    return Sandwich(covariance, naive)


@dataclass(frozen=True, eq=False)
class Sandwich:
    """Covariance of the unknowns, and what it would be if W were the inverse of Sigma, each shape (q, q)."""

    covariance: Array
    naive: Array

    def at(self, i: int) -> tuple[float, float]:
        """Return standard uncertainty and stretch of one unknown."""
        variance = float(self.covariance[i, i])
        return float(np.sqrt(variance)), variance / float(self.naive[i, i])

    @property
    def stretch(self) -> Array:
        """Variance over that as if W were the inverse of Sigma, shape (q,)."""
        return np.asarray(self.covariance.diagonal() / self.naive.diagonal())

    @property
    def u(self) -> Array:
        """Standard uncertainties, shape (q,)."""
        return np.sqrt(self.covariance.diagonal())


def sandwich_of(D: Array, weights: Array, sigma: Array) -> Sandwich:
    """Return the covariance of the unknowns; see the module head."""
    shape = D.shape[1], D.shape[1]
    covariance, naive = np.empty(shape), np.empty(shape)
    fill_sandwich(np.ascontiguousarray(D), weights, np.ascontiguousarray(sigma), SINGULAR, covariance, naive)
    return Sandwich(covariance, naive)
