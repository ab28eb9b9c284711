"""Yield of a lot, and how many of its decisions are wrong.

The yield is the share of units that PASS; its interval is the exact one of a binomial (what the next such lot may
have). Whether a unit conforms is not known for sure: given the population N(mean, s^2) that it is drawn from and its
figure v with standard uncertainty u, its true value is normal with

    variance  1 / (1/s^2 + 1/u^2)      mean  (m/s^2 + v/u^2) times that              (JCGM 106:2012, 6.6)

so that each accepted unit has a probability to lie outside (consumer's risk) and each rejected one to lie inside
(producer's risk). ``wrong`` counts add these up over the units; their intervals hold what such a sum of chances
scatters, and how well the population is known. Over the lot they are the global risks of JCGM 106, clause 9.

What breaks this: a population that is far from normal near a limit; an uncertainty that is not honest (``gauge``).

References
----------
.. [1] JCGM 106:2012, clauses 6.6, 9.3 to 9.5.
.. [2] C. J. Clopper and E. S. Pearson, Biometrika 26 (1934) 404.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from ...core.results import Interval
from ..intervals import binomial_interval
from .scatter import DRAWS, P, Population

SOME = 64  # draws of the population that risks are worked out for
LEAST = 1e-100  # shape of a gamma, below which a count is none: squares of chances end at 1e-308


@dataclass(frozen=True)
class Share:
    """A count of units with its share and the interval of the share, 95 %."""

    count: int
    of: int
    interval: Interval

    @property
    def value(self) -> float:
        """The share."""
        return self.count / self.of if self.of else math.nan


@dataclass(frozen=True)
class Wrong:
    """How many units were decided wrongly: expected, and the interval of their number, 95 %."""

    expected: float
    interval: Interval


@dataclass(frozen=True)
class Risks:
    """Accepted although outside, and rejected (or not decided) although inside."""

    consumer: Wrong
    producer: Wrong


def share(count: int, of: int) -> Share:
    """Return a share of units with its interval."""
    low, high = binomial_interval(count, of, P) if of else (0.0, 1.0)
    return Share(count, of, Interval(low, high, P))


def risks(
    values: Array,
    u: Array,
    accepted: NDArray[np.bool_],
    found: Population,
    lower: float | None,
    upper: float | None,
) -> Risks:
    """Return how many decisions on a lot are wrong.

    Parameters
    ----------
    values, u : ndarray, shape (n,)
        Figure of each unit with its whole standard uncertainty.
    accepted : ndarray of bool, shape (n,)
        Which PASS.
    found : Population
        That they are drawn from.
    lower, upper : float or None
        Limits of true values.
    """
    low, high = -math.inf if lower is None else lower, math.inf if upper is None else upper
    means, scatters = found.draws()
    chosen = np.linspace(0, DRAWS - 1, SOME).astype(int)
    pairs = [(found.mean, found.scatter), *zip(means[chosen], scatters[chosen], strict=True)]
    outside = [_outside(values, u, float(mean), float(s), low, high) for mean, s in pairs]
    return Risks(
        _wrong([one[accepted] for one in outside]),
        _wrong([1.0 - one[~accepted] for one in outside]),
    )


def _outside(values: Array, u: Array, mean: float, s: float, low: float, high: float) -> Array:
    """Return the probability of each unit to lie outside limits."""
    both = s**2 + u**2
    some = np.where(both > 0.0, both, 1.0)
    variance = s**2 * u**2 / some
    middle = np.where(both > 0.0, (mean * u**2 + values * s**2) / some, values)
    root = np.sqrt(variance)
    with np.errstate(divide="ignore", invalid="ignore"):
        above = np.where(root > 0.0, special.ndtr((middle - high) / root), (middle > high).astype(float))
        below = np.where(root > 0.0, special.ndtr((low - middle) / root), (middle < low).astype(float))
    return np.asarray(above + below)


def _wrong(chances: list[Array]) -> Wrong:
    """Return expected number and interval of a sum of chances, the first as known best."""
    expected = [float(one.sum()) for one in chances]
    own = float((chances[0] * (1.0 - chances[0])).sum())
    spread = float(np.var(expected[1:]))
    whole = own + spread
    # a count with this mean and variance: a gamma, which holds rare ones as well as many
    shape = expected[0] * (expected[0] / whole) if whole else math.inf if expected[0] else 0.0
    if shape < LEAST:
        return Wrong(expected[0], Interval(0.0, float(round(max(expected), 2)), P))
    if math.isinf(shape):
        return Wrong(expected[0], Interval(expected[0], expected[0], P))
    low, high = (float(special.gammaincinv(shape, q)) * whole / expected[0] for q in ((1 - P) / 2, (1 + P) / 2))
    low, high = math.floor(low), math.ceil(high)
    return Wrong(expected[0], Interval(float(low), float(high), P))
