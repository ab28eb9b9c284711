"""A requirement on the bias over temperature: judged at temperatures of the range, with a band that holds for all.

The range is what the condition takes in, between the temperatures that it names; an end that it leaves open is that of
the ramps. Outside of the ramps nothing is known: INCONCLUSIVE there, so that a range wider than the ramps never passes.
The band is the narrower of two that hold 95 % for all places together: Sidak's for the places that are judged, and
Scheffe's for a whole polynomial of that order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import special

from ..core.estimate import Array
from ..core.results import Interval
from ..procedures.thermal.fit.law import Law
from ..procedures.thermal.reduction import Plan, bias_at
from ..statistics.decision import decide
from ..statistics.intervals import band_factor
from .conditions import Condition

PLACES = 13  # temperatures over a range
LEVEL = 0.95


@dataclass(frozen=True)
class Place:
    """The bias at one temperature against the limits."""

    at: float
    value: float | None
    u: float | None
    interval: Interval | None
    status: str
    reason: str = ""


def judged_over(
    plan: Plan, law: Law, axis: str, unit: str, condition: Condition, lower: float | None, upper: float | None
) -> Iterator[Place]:
    """Yield the verdicts at the temperatures that a condition takes in.

    Parameters
    ----------
    plan, law, axis, unit
        Of the sensor that was reduced, and the unit of its readings.
    condition : Condition
        On ``temperature`` [degC].
    lower, upper : float or None
        Limits [unit].
    """
    at = temperatures_of(condition, law.domain)
    inside = (at >= law.domain[0]) & (at <= law.domain[1])
    low, high = law.domain
    for one in at[~inside]:
        reason = f"outside the range of the ramps, {low:.4g} to {high:.4g} degC"
        yield Place(float(one), None, None, None, "INCONCLUSIVE", reason)
    known = at[inside]
    found = bias_at(plan, law, axis, unit, known) if len(known) else None
    for i, one in enumerate(known):
        if found is None:
            yield Place(float(one), None, None, None, "INCONCLUSIVE", "the bias has no uncertainty there")
            continue
        value, u, dof = float(found.values[i]), float(found.u[i]), float(found.dof[i])
        verdict = decide(value, u, dof, lower, upper, _p(len(known), law.order + 1, dof))
        yield Place(float(one), value, u, verdict.interval, verdict.status, verdict.reason)


def temperatures_of(condition: Condition, ramps: tuple[float, float]) -> Array:
    """Return the temperatures that a condition takes in, in order [degC]."""
    named = [one.value for every in condition.alternatives for one in every if one.name == "temperature"]
    ends = [*named, *(-one for one in named if _sized(condition))]
    low, high = min([*ends, ramps[0]]), max([*ends, ramps[1]])
    every = np.unique(np.concatenate([np.linspace(low, high, 4 * PLACES + 1), ends]))
    taken = every[[condition.holds({"temperature": float(one), "rate": np.nan}) for one in every]]
    if not len(taken):
        return taken
    grid = np.linspace(taken[0], taken[-1], PLACES)
    return grid[[condition.holds({"temperature": float(one), "rate": np.nan}) for one in grid]]


def _sized(condition: Condition) -> bool:
    return any(one.size for every in condition.alternatives for one in every)


def _p(places: int, coefficients: int, dof: float) -> float:
    """Probability of the interval at one place, so that 95 % hold for all."""
    factor = min(band_factor(places, dof, LEVEL), band_factor(coefficients, dof, LEVEL, "scheffe"))
    below = special.ndtr(factor) if np.isinf(dof) else special.stdtr(dof, factor)
    return float(2.0 * below - 1.0)
