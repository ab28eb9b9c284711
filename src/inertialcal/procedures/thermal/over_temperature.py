"""A requirement on the bias over temperature: judged at temperatures of the range, with a band that holds for all.

``bias`` is that at each temperature, ``bias_over_temperature`` the same less that at the reference temperature: zero
there, and not judged there. A data sheet's "deviation from 22 degC" is this, with that reference temperature.

The range is what the condition takes in, between the temperatures that it names; an end that it leaves open is that of
the ramps. Outside of the ramps nothing is known: INCONCLUSIVE there, so that a range wider than the ramps never passes.
The band is the narrower of two that hold 95 % for all places together: Sidak's for the places that are judged, and
Scheffe's for a whole polynomial of that order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.judging import LEVEL, Asked, Basis, Condition, Rule, Verdict
from ...core.results import Interval
from ...statistics.decision import decide
from ...statistics.guard_band import INTERVAL
from ...statistics.intervals import band_factor
from ..protocol import Tested
from .fit.law import Law
from .fit.quantities import bias_at, change_at
from .plan import Plan
from .recordings import Readings
from .reduction import Result

PLACES = 13  # temperatures over a range
CHANGE = "bias_over_temperature"
APART = 0.01  # [degC] from the reference temperature, where a change from there is judged


@dataclass(frozen=True)
class Place:
    """The bias at one temperature against the limits."""

    at: float
    value: float | None
    u: float | None
    interval: Interval | None
    status: str
    reason: str = ""
    basis: Basis = field(default_factory=Basis)


def judge_bias(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> Iterator[Verdict]:
    """Yield the verdicts on the bias at temperatures that the condition takes in, with a band that holds for all."""
    for one in tests:
        unit = one.result.readings.unit
        try:
            lower, upper = asked.limits(unit)
        except DataError:  # a limit of another kind, which the checks of the campaign file name
            continue
        for axis, sensor in one.result.sensors.items():
            if asked.axis in (None, axis):
                judged = judged_over(one.result.plan, sensor.law, axis, unit, asked.condition, lower, upper, asked.rule,
                                     change=asked.quantity == CHANGE)  # fmt: skip
                for place in judged:
                    yield Verdict(
                        asked.id, one.id, axis, place.at, "expected", place.value, place.u, unit,
                        place.interval, lower, upper, place.status, place.reason, "degC", basis=place.basis,
                    )  # fmt: skip


def judged_over(
    plan: Plan,
    law: Law,
    axis: str,
    unit: str,
    condition: Condition,
    lower: float | None,
    upper: float | None,
    rule: Rule = INTERVAL,
    change: bool = False,
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
    rule : Rule
        By which each place is decided.
    change : bool
        Whether the change from the reference temperature is judged, in place of the bias.
    """
    at, reference = temperatures_of(condition, law.domain), plan.reference_temperature
    if change:
        at = at[np.abs(at - reference) > APART]
    inside = (at >= law.domain[0]) & (at <= law.domain[1])
    low, high = law.domain
    for one in at[~inside]:
        reason = f"outside the range of the ramps, {low:.4g} to {high:.4g} degC"
        yield Place(float(one), None, None, None, "INCONCLUSIVE", reason)
    known = at[inside]
    reason = "the bias has no uncertainty there"
    if change and not low <= reference <= high:
        reason = f"the reference temperature, {reference:g} degC, is outside the range of the ramps"
        found = None
    else:
        found = (change_at if change else bias_at)(plan, law, axis, unit, known) if len(known) else None
    for i, one in enumerate(known):
        if found is None:
            yield Place(float(one), None, None, None, "INCONCLUSIVE", reason)
            continue
        value, u, dof = float(found.values[i]), float(found.u[i]), float(found.dof[i])
        verdict = decide(value, u, dof, lower, upper, _p(len(known), law.order + 1, dof), rule)
        yield Place(float(one), value, u, verdict.interval, verdict.status, verdict.reason, verdict.basis)


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
