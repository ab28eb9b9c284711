"""Remarks on a shifted ground model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.remarks import Remark
from ...core.show.rounding import freedom, items, number, with_uncertainty
from ...core.units import factor
from ...statistics.intervals import coverage_factor
from .later import Predicted, predicted
from .model import DRIFT, SLOPE, AxisShift
from .plan import INFLUENCES
from .rows import FOR_LINE

if TYPE_CHECKING:
    from .reduction import Result

FEW = 5  # flights, below which their scatter is known badly


def remarks_of(result: Result) -> Iterator[Remark]:
    """Yield remarks on a result."""
    yield from _on_ground(result)
    for one in result.shifts.values():
        yield from _on_axis(result, one)
    yield from told(predicted(result, result.later))
    missing = [name for name in INFLUENCES if name not in result.plan.standards]
    if missing:
        what = f"{', '.join(missing)}: no uncertainty stated; what all flips share is not in the new model"
        yield Remark("relative_to_fixture", "warning", what, do="State them under [standards]")


def _on_ground(result: Result) -> Iterator[Remark]:
    ground, plan = result.readings.ground, result.plan
    if ground.estimate is None:
        what = (
            "the ground model has no covariance: away from the temperatures of the flips the new model is less certain"
        )
        do = "Give a ground model with its covariance, as the commands here write it"
        yield Remark("ground_without_covariance", "warning", f"{what} than it says", do=do)
    left = [axis for axis in ground.axes if axis not in result.shifts]
    if left:
        what = f"{', '.join(left)}: no flips; the new model keeps the bias of the ground model"
        yield Remark("axis_not_flipped", "warning", what, do="Turn the head about another axis, too")
    if ground.temperature_range is None:
        what = "the ground model says no range of temperature: whether it holds at the flips is not known"
        yield Remark("no_temperature_range", "warning", what, do="Give a ground model with its range")
    if plan.ground_date is None:
        what = "date of the ground model not given: whether the flips are younger is not known"
        yield Remark("no_ground_date", "info", what, do='Set ground_date, like "2020-05-01"')
    if not ground.item.serial:
        what = "the ground model names no serial: whether the flips are of that head is not known"
        yield Remark("serial_unknown", "info", what, do="Give a model file that names its unit")


def _on_axis(result: Result, one: AxisShift) -> Iterator[Remark]:
    fit, axis, plan = one.fit, one.axis, result.plan
    flights = fit.flights
    if flights == 1 and plan.launch_scatter is None:
        what = f"{axis}: one flight: what the next launch shifts is not known"
        yield Remark("one_flight", "info", what, do="Fly again, or state launch_scatter", axis=axis)
    elif flights < FEW and plan.launch_scatter is None:
        what = f"{axis}: {items(flights, 'flight')}: their scatter has {freedom(fit.dof)}"
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW} or more", axis=axis)
    if DRIFT not in one.names and flights > 1 and plan.trend == "auto":
        what = f"{axis}: {flights} flights: a drift cannot be told from launches; the new model has none"
        do = f'Set trend = "line" to have it all the same, from {FOR_LINE} flights on'
        yield Remark("drift_not_separated", "info", what, do=do, axis=axis)
    if DRIFT not in one.names and one.line is not None:
        value, u, dof = one.line
        if abs(value) > coverage_factor(dof) * u:
            what = f"{axis}: the flights drift by {number(value * factor('m/s^2', 'ug') * 31_557_600, 3)} ug a year, "
            yield Remark("drift_left_out", "warning", f"{what}which the new model has not", do='Set trend = "line"',
                         axis=axis)  # fmt: skip
    if SLOPE not in one.names and plan.shift_slope == 0.0:
        what = f"{axis}: whether the shift changes with temperature is not known ({one.no_slope})"
        do = "State shift_slope, or flip at other temperatures"
        yield Remark("shift_over_temperature", "warning", what, do=do, axis=axis)
    if fit.widened > 1.0:
        what = f"{axis}: flips of one flight differ by {number(fit.widened, 2)} times their uncertainties "
        what += f"(probability {fit.p_value:.2g}): these are taken as so much larger"
        yield Remark("flips_differ", "warning", what, do="Are they uncertainties of the mean, and is one flip wrong?",
                     axis=axis)  # fmt: skip
    chance = _accumulating(one)
    if chance is not None and chance < 0.01 and plan.launches == "fresh":
        what = f"{axis}: shifts of one flight resemble those of the flight before (probability {chance:.2g})"
        do = 'Launches add up, or the drift bends: set launches = "kept"'
        yield Remark("launches_add_up", "warning", what, do=do, axis=axis)


def _accumulating(one: AxisShift) -> float | None:
    """Return the probability of so smooth a row of flights, if each were shifted anew; None for fewer than six.

    Von Neumann's ratio of what the fit leaves, against draws of the same design.
    """
    fit = one.fit
    count = fit.flights
    if count < 6 or not fit.dof:
        return None
    mean = np.zeros((count, len(fit.group)))
    mean[fit.group, np.arange(len(fit.group))] = 1.0
    mean /= mean.sum(axis=1, keepdims=True)
    left = mean @ (np.eye(len(fit.group)) - fit.design @ fit.weights)
    root = np.linalg.cholesky(fit.covariance)
    draws = np.random.default_rng(1).normal(size=(len(fit.group), 2000))
    drawn = left @ root @ draws

    def ratio(
        values: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    ) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return np.asarray(np.sum(np.diff(values, axis=0) ** 2, axis=0) / np.sum(values**2, axis=0))

    own = float(ratio((left @ fit.shift)[:, None])[0])
    return float((np.count_nonzero(ratio(drawn) <= own) + 1) / (draws.shape[1] + 1))


def told(flights: Iterable[Predicted]) -> Iterator[Remark]:
    """Yield flights that were left out, with what they measured less what the new model predicts."""
    per = factor("m/s^2", "ug")
    for one in flights:
        if math.isnan(one.u):
            continue
        what = (
            f"{one.axis}: flight {one.flight} measured {with_uncertainty(one.error * per, one.u * per)} ug beyond what "
        )
        what += f"the new model predicts, and {number((one.measured - one.ground) * per, 4)} ug beyond the ground model"
        if one.inside:
            yield Remark("prediction_held", "info", what, axis=one.axis, subject=one.flight)
            continue
        do = "Something else has shifted it: look at that flight, and at launches and trend of the plan"
        yield Remark("prediction_missed", "warning", what, do=do, axis=one.axis, subject=one.flight)
