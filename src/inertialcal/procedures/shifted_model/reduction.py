"""Shift of each axis over flights, and what follows from it: rows, curves, remarks and the new model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...sensors.model.sensor_model import SensorModel
from .curves import curves
from .fit import Fit, fitted
from .model import DRIFT, SHIFT, SLOPE, AxisShift, shifted, shifts_of
from .plan import Plan
from .readings import Readings, flights_of, ground_bias, instant
from .remarks import remarks_of
from .rows import FOR_LINE, rows
from .shown import flights_table

FOR_TREND = 4  # flights from which on the new model has a drift
SPREAD = 1.0  # [degC] of temperatures, beside age, that a change with temperature is estimated from


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given.
    shifts : mapping of str to AxisShift
        By axis that has flips.
    date : int
        That the new model is for [ns].
    later : Readings
        Flights that are predicted.
    remarks : tuple of Remark
        Findings.
    """

    plan: Plan
    readings: Readings
    shifts: Mapping[str, AxisShift]
    date: int
    later: Readings
    remarks: tuple[Remark, ...]

    @property
    def estimate(self) -> Estimate:
        """Shift of each axis at the mean temperature of its flips, drift and change with temperature where they are."""
        return shifts_of(self)

    def model(self, date: int | None = None) -> SensorModel:
        """Return the new model, for a date [ns]."""
        return shifted(self, self.date if date is None else date)

    def rows(self) -> Sequence[Row]:
        """Rows of ``results.json``, SI."""
        return rows(self)

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, how many remarks."""
        caption = f"shifted ground model: {len(self.readings)} flips in {self.readings.runs} flight(s)"
        found = estimate_table([row.to_dict() for row in self.rows() if row.case.plain], caption)
        return (*found, flights_table(self), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Shift the ground model by the flips.

    Raises
    ------
    DataError
        ``too_few_flights`` where a drift is asked for that they do not tell; ``wrong_value`` for a date before them;
        ``models_differ`` for a ground model whose axes refer to different temperatures.
    PlanError
        As ``readings.flights_of``.
    """
    used, later = flights_of(plan, readings)
    reference = used.ground.reference_temperature
    if reference is not None and np.ptp(reference) > 0.0:
        what = "the axes of the ground model refer to different temperatures"
        raise DataError(what, do="Fit them about one reference temperature", code="models_differ")
    last = max(one.time for one in used.flips)
    date = last if plan.date is None else instant(plan.date, "date")
    if date < min(one.time for one in used.flips):
        what = f"date {plan.date}: before the first flight"
        raise DataError(what, do="Give a date from the first flight on", code="wrong_value")
    shifts = {axis: _shift_of(plan, used, axis) for axis in used.axes}
    found = Result(plan, used, shifts, date, later, ())
    return replace(found, remarks=(*readings.remarks, *remarks_of(found)))


def _shift_of(plan: Plan, readings: Readings, axis: str) -> AxisShift:
    flips = tuple(one for one in readings.flips if one.axis == axis)
    flights = list(dict.fromkeys(one.flight for one in flips))
    temperature = np.array([one.temperature for one in flips])
    at = readings.ground.axes.index(axis)
    ground = ground_bias(readings.ground, temperature, plan.bias_of)[:, at]
    times = np.array([one.time for one in flips], dtype=np.int64)
    group = np.array([flights.index(one.flight) for one in flips])
    time = int(np.mean(times - times[0])) + int(times[0])
    T = float(np.mean(temperature))
    age = (times - time) / SECOND
    trend = _has_trend(plan, len(flights), axis, flips[-1].where)
    within, why = _tells_slope(plan, temperature, age if trend else None, group)
    names = (SHIFT, *((DRIFT,) if trend else ()), *(() if why else (SLOPE,)))

    def fit(names: Sequence[str]) -> Fit:
        columns = {SHIFT: np.ones(len(flips)), DRIFT: age, SLOPE: temperature - T}
        between = len(names) - (SLOPE in names and within)
        shift = np.array([one.bias for one in flips]) - ground
        u = np.array([one.u for one in flips])
        return fitted(np.column_stack([columns[name] for name in names]), shift, u, group, between,
                      plan.launches == "kept", plan.launch_scatter)  # fmt: skip

    found = fit(names)
    line = _drift(found, names)
    if line is None and len(flights) >= FOR_LINE and len(flights) - (len(names) + 1 - (SLOPE in names and within)) > 0:
        longer = (SHIFT, DRIFT, *names[1:])
        line = _drift(fit(longer), longer)
    return AxisShift(axis, flips, ground, found, names, time, T, why, line)


def _has_trend(plan: Plan, flights: int, axis: str, where: str) -> bool:
    if plan.trend == "line" and flights < FOR_LINE:
        what = f"{axis}: {flights} flight(s), but a drift is asked for"
        why = f"nothing is left over to say how well it is known before there are {FOR_LINE}"
        raise DataError(what, where, why, 'Wait for more flights, or set trend = "none"', "too_few_flights")
    return plan.trend == "line" or (plan.trend == "auto" and flights >= FOR_TREND)


def _tells_slope(plan: Plan, temperature: Array, age: Array | None, group: Array) -> tuple[bool, str]:
    """Return whether flips within flights tell the change with temperature, and why nothing does; empty where it is."""
    flights = int(group.max()) + 1
    if plan.slope == "none":
        return False, "left out by the plan"
    every = np.eye(flights)[group.astype(int)]
    inside = temperature - every @ (every.T @ temperature / every.sum(axis=0))
    if math.sqrt(float(np.mean(inside**2))) >= SPREAD:
        return True, ""
    columns = (
        np.ones((len(temperature), 1))
        if age is None
        else np.column_stack([np.ones(len(age)), age / max(np.ptp(age), 1.0)])
    )
    left = temperature - columns @ np.linalg.lstsq(columns, temperature, rcond=None)[0]
    spread = math.sqrt(float(np.mean(left**2)))
    if spread < SPREAD:
        return False, f"temperatures of the flips spread by {spread:.2g} degC alone, beside their age"
    if flights - columns.shape[1] - 1 < 1:
        return False, "too few flights: their temperatures and their launches cannot be told apart"
    return False, ""


def _drift(fit: Fit, names: Sequence[str]) -> tuple[float, float, float] | None:
    if DRIFT not in names or not fit.dof:
        return None
    at = names.index(DRIFT)
    _, covariance = fit.predicted(np.eye(len(names))[[at]], ahead=False)
    return float(fit.coefficients[at]), math.sqrt(float(covariance[0, 0])), fit.dof
