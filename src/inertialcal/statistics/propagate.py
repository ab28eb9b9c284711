"""Validation of a linear propagation of uncertainty by Monte Carlo (JCGM 101:2008, clause 8)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..core.errors import DataError
from ..core.estimate import Array, Estimate
from ..core.results import Interval
from .intervals import ends, t_interval


class MonteCarlo(NamedTuple):
    """What the draws gave.

    Parameters
    ----------
    estimate : Estimate
        Mean and covariance of the draws; dof infinite: the doubt about each u is in the draws.
    intervals : tuple of Interval
        One a value.
    samples : ndarray, shape (draws, m)
        The draws of the function.
    """

    estimate: Estimate
    intervals: tuple[Interval, ...]
    samples: Array


@dataclass(frozen=True)
class Comparison:
    """Validation of a linear propagation for one value (JCGM 101, 8.1)."""

    name: str  # which value
    delta: float  # numerical tolerance: half a unit of the last digit of u that counts
    # distance of the ends of the two intervals
    d_low: float
    d_high: float
    end_u: float  # standard uncertainty of the ends of the Monte Carlo interval from the number of draws (the larger)

    @property
    def validated(self) -> bool:
        """Both ends agree within the tolerance."""
        return max(self.d_low, self.d_high) <= self.delta

    @property
    def resolved(self) -> bool:
        """There were draws enough for the question: twice ``end_u`` is within the tolerance (7.9.4)."""
        return 2.0 * self.end_u <= self.delta


def compare(linear_estimate: Estimate, drawn: MonteCarlo, digits: int = 2, blocks: int = 20) -> tuple[Comparison, ...]:
    """Return the validation of a linear propagation by Monte Carlo, value by value (JCGM 101, clause 8).

    Parameters
    ----------
    linear_estimate : Estimate
        By the slopes of the function.
    drawn : MonteCarlo
        Of the same function, with intervals of equal tails.
    digits : int
        Significant digits of u that count: 1 or 2.
    blocks : int
        Parts that the draws are cut into to see how well they fix the ends.

    Raises
    ------
    DataError
        If names differ, or an uncertainty is zero.
    """
    if linear_estimate.names != drawn.estimate.names:
        raise DataError(f"values {linear_estimate.names} compared with {drawn.estimate.names}")
    found = []
    for i, name in enumerate(linear_estimate.names):
        u = float(linear_estimate.u[i])
        mine = t_interval(float(linear_estimate.values[i]), u, float(linear_estimate.dof[i]), drawn.intervals[i].p)
        distance = np.abs(np.subtract(ends(drawn.intervals[i]), ends(mine)))
        parts = np.array_split(drawn.samples[:, i], blocks)
        tails = [0.5 * (1.0 - mine.p), 0.5 * (1.0 + mine.p)]
        scatter = np.std([np.quantile(part, tails) for part in parts], axis=0, ddof=1) / math.sqrt(blocks)
        found.append(
            Comparison(name, tolerance(u, digits), float(distance[0]), float(distance[1]), float(scatter.max()))
        )
    return tuple(found)


def tolerance(u: float, digits: int = 2) -> float:
    """Return half a unit of the last significant digit of a standard uncertainty (JCGM 101, 7.9.2).

    Raises
    ------
    DataError
        If the uncertainty is not a positive number.

    Examples
    --------
    >>> tolerance(0.00035, digits=2)
    5e-06
    """
    if not (u > 0.0 and math.isfinite(u)):
        raise DataError(f"numerical tolerance of a standard uncertainty {u:g}", do="Need a positive number")
    exponent = int(f"{u:.{digits - 1}e}".split("e")[1]) - digits + 1
    return float(f"5e{exponent - 1}")
