"""Rows of a shifted ground model: shifts, drift, launches, the bias of a flight to come.

Members ``run``: one flight each, with its shift from the ground model. Members ``held_out``: flights that were left
out, with what both models are off there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import NO_REASON, Key, Member, Reason
from ...core.results import Interval, Row, not_estimated
from ...core.show.rounding import number
from ...sensors.model.sensor_model import SensorModel
from ...statistics.intervals import chi_square_interval, t_interval
from .later import Predicted, predicted
from .model import DRIFT, SHIFT, SLOPE, UNIT, AxisShift, bias_at

if TYPE_CHECKING:
    from .reduction import Result

FOR_LINE = 3  # flights that a drift is estimated from
LAUNCH, NEXT = "launch_shift", "bias_next_flight"
ERROR, GROUND = "prediction_error", "ground_prediction_error"
ONE = Reason("one_flight", "one flight: what a launch shifts is not known")


def rows(result: Result) -> list[Row]:
    """Return all rows, SI."""
    found: list[Row] = []
    estimate, model = result.estimate, result.model()
    for axis, one in result.shifts.items():
        for key, value, u, dof in zip(estimate.keys, estimate.values, estimate.u, estimate.dof, strict=True):
            if key.axis == axis and key.quantity != DRIFT:
                unit = estimate.units[estimate.keys.index(key)]
                reason = (
                    Reason("limits", f"at {number(one.temperature, 4)} degC") if key.quantity == SHIFT else NO_REASON
                )
                found.append(_row(key, float(value), float(u), unit, float(dof), reason))
        found += [_drift(one), *_launch(result, one), _next(result, one, model)]
        if SLOPE not in one.names:
            found.append(not_estimated(Key(SLOPE, axis), f"{UNIT}/degC", Reason("temperatures", one.no_slope)))
        found += _of_flights(result, one)
    return [*found, *prediction_rows(predicted(result, result.later))]


def prediction_rows(flights: Iterable[Predicted]) -> Iterator[Row]:
    """Yield what was measured less what the new model, and the ground model, say of flights that were left out."""
    for each in flights:
        member = Member("held_out", f"flight {each.flight}")
        if math.isnan(each.u):
            yield not_estimated(Key(ERROR, each.axis), UNIT, ONE, member=member)
        else:
            yield _row(Key(ERROR, each.axis), each.error, each.u, UNIT, each.dof, member=member)
        yield _row(Key(GROUND, each.axis), each.measured - each.ground, each.u_flips, UNIT, math.inf,
                   Reason("limits", "u: of the flips alone"), member)  # fmt: skip


def _row(
    key: Key, value: float, u: float, unit: str, dof: float, reason: Reason = NO_REASON, member: Member | None = None
) -> Row:
    shown = dof if math.isfinite(dof) else None
    return Row(key, value, u, unit, shown, t_interval(value, u, dof), reason=reason, member=member)


def _drift(one: AxisShift) -> Row:
    key = Key(DRIFT, one.axis)
    if one.line is None:
        count = one.fit.flights
        why = (
            f"{count} flight(s), need {FOR_LINE} or more"
            if count < FOR_LINE
            else "flights and temperatures do not tell it"
        )
        return not_estimated(key, f"{UNIT}/s", Reason("too_few_flights", why))
    value, u, dof = one.line
    return _row(key, value, u, f"{UNIT}/s", dof, NO_REASON if DRIFT in one.names else Reason(
        "limits", "the new model has none"))  # fmt: skip


def _launch(result: Result, one: AxisShift) -> Iterator[Row]:
    """Yield the standard deviation of launches, its interval that of the scatter of the flights less their noise."""
    fit, key = one.fit, Key(LAUNCH, one.axis)
    if result.plan.launch_scatter is not None:
        yield Row(key, fit.tau, None, UNIT, status="not_estimated", reason=Reason("stated", "as stated"))
        return
    if not fit.dof:
        yield not_estimated(key, UNIT, ONE)
        return
    flips = np.array([flip.u * fit.widened for flip in one.flips])
    per_flight = [1.0 / float(np.sum(1.0 / flips[fit.group == at] ** 2)) for at in range(fit.flights)]
    noise = float(np.mean(per_flight))
    whole = math.sqrt(fit.tau**2 + noise) if fit.tau else math.sqrt(noise * min(fit.mean_square, 1.0))
    ends = chi_square_interval(whole, fit.dof)
    low, high = (math.sqrt(max(end**2 - noise, 0.0)) for end in (ends.lo or 0.0, ends.hi or 0.0))
    u = whole / math.sqrt(2.0 * fit.dof)
    yield Row(key, fit.tau, u, UNIT, fit.dof, Interval(low, high, 0.95), reason=Reason(
        "limits", "scatter of the flights less that of their flips"))  # fmt: skip


def _next(result: Result, one: AxisShift, model: SensorModel) -> Row:
    key = Key(NEXT, one.axis)
    value, u, dof = bias_at(model, result, one.axis, np.array([one.temperature]))
    if not one.fit.dof:
        return not_estimated(key, UNIT, ONE)
    reason = Reason("limits", f"of a flight to come, at {number(one.temperature, 4)} degC")
    return _row(
        key, value, math.hypot(u, one.launch(result.date, one.temperature)), UNIT, min(dof, one.fit.dof), reason
    )


def _of_flights(result: Result, one: AxisShift) -> Iterator[Row]:
    """Yield the shift of each flight from the ground model."""
    u = np.array([flip.u * one.fit.widened for flip in one.flips])
    names = list(dict.fromkeys(flip.flight for flip in one.flips))
    for at, name in enumerate(names):
        own = one.fit.group == at
        weights = 1.0 / u[own] ** 2
        total = float(weights.sum())
        member = Member("run", name)
        free = min(flip.dof for flip in np.array(one.flips, dtype=object)[own])
        mean = float(weights @ one.fit.shift[own]) / total
        yield _row(Key(SHIFT, one.axis), mean, 1.0 / math.sqrt(total), UNIT, free, member=member)
