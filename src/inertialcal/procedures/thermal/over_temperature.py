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
from ...sensors.model.sensor_model import SensorModel
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
LEAST_RUNS = 2  # power-ups that tell how they differ
ONE_POWER_UP = "one power-up is held out: how another one differs was not observed"
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
                    yield _verdict(asked, one.id, axis, place, unit, (lower, upper))


def judge_less(
    asked: Asked, one: Tested[Plan, Readings, Result], model: SensorModel
) -> Iterator[tuple[Verdict, Verdict | None]]:
    """Yield the verdicts on the bias of a test held out less that of a model, each with that on the bias as read.

    The test has its own scatter of power-ups and its own errors of standards, in full: those of the model show in what
    is left. One power-up does not tell how another differs: INCONCLUSIVE.

    Raises
    ------
    DataError
        If the limits are of another kind.
    """
    unit = one.result.readings.unit
    limits = asked.limits(unit)
    for axis, sensor in one.result.sensors.items():
        if asked.axis not in (None, axis):
            continue
        plan, law, over = one.result.plan, sensor.law, asked.condition
        raw = {place.at: place for place in judged_over(plan, law, axis, unit, over, *limits, asked.rule)}
        if axis not in model.axes or one.readings.runs < LEAST_RUNS:
            why = ONE_POWER_UP if axis in model.axes else f"the model has no axis {axis}"
            left = [Place(at, None, None, None, "INCONCLUSIVE", why) for at in raw]
        else:
            left = list(judged_over(plan, law, axis, unit, over, *limits, asked.rule, less=model))
        for place in left:
            yield (
                _verdict(asked, one.id, axis, place, unit, limits),
                _verdict(asked, one.id, axis, raw[place.at], unit, limits),
            )


def _verdict(
    asked: Asked, test: str, axis: str, place: Place, unit: str, limits: tuple[float | None, float | None]
) -> Verdict:
    return Verdict(
        asked.id, test, axis, place.at, "expected", place.value, place.u, unit, place.interval, *limits, place.status,
        place.reason, "degC", basis=place.basis,
    )  # fmt: skip


def bias_of(model: SensorModel, axis: str, temperature: Array) -> Array:
    """Return the bias that a model takes off at temperatures [degC], shape (n,) [unit of the model]."""
    at = model.axes.index(axis)
    powers = [] if model.bias_temperature is None else list(model.bias_temperature[:, at])
    reference = 0.0 if model.reference_temperature is None else float(model.reference_temperature[at])
    columns = np.vander(temperature - reference, 1 + len(powers), increasing=True)
    return np.asarray(columns @ np.array([model.bias[at], *powers]))


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
    less: SensorModel | None = None,
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
    less : SensorModel, optional
        Whose bias is taken off; nothing is known outside of its temperatures.
    """
    at, reference = temperatures_of(condition, law.domain), plan.reference_temperature
    if change:
        at = at[np.abs(at - reference) > APART]
    low, high = law.domain
    beyond = f"outside the range of the ramps, {low:.4g} to {high:.4g} degC"
    if less is not None and less.temperature_range is not None:
        of_model = less.temperature_range
        if of_model[0] > low or of_model[1] < high:
            low, high = max(low, of_model[0]), min(high, of_model[1])
            beyond = f"outside the temperatures of the ramps and of the model, {low:.4g} to {high:.4g} degC"
    inside = (at >= low) & (at <= high)
    for one in at[~inside]:
        reason = beyond
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
        off = 0.0 if less is None else float(bias_of(less, axis, known[i : i + 1])[0])
        value, u, dof = float(found.values[i]) - off, float(found.u[i]), float(found.dof[i])
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
