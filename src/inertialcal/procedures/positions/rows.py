"""Rows of a result of positions: every quantity with its uncertainty, or the reason why there is none.

The condition says whose: ``accelerometer`` or ``gyro``. Of the published closed form beside them the test does.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.axes import AXES, Kind
from ...core.estimate import Array, Estimate
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import chi_square_interval, t_interval
from ...statistics.two_levels import TwoLevels
from .fit.accelerometer import Fitted
from .fit.levels import FEWEST
from .fit.linear_sensor import BIAS, G_SENSITIVITY, MATRIX, LinearSensor
from .gravity import local_gravity
from .plan import INFLUENCES
from .published import published_rows
from .quantities import SCALE, UNIT, reasons, units_of

if TYPE_CHECKING:
    from .reduction import Result

NO_LEVEL = "nothing was repeated that it could be told from"
NOT_SEEN = "hardly seen above what is known of each: less than one degree of freedom"


def rows(result: Result) -> list[Row]:
    """Return all rows, SI, accelerometers first."""
    found = _of_sensor(result, "accelerometer", result.acc.sensor, result.estimates.get("accelerometer"))
    found.append(_between("scatter_position", "", "m/s^2", result.acc, "accelerometer"))
    if result.gyro is not None:
        found += _of_sensor(result, "gyro", result.gyro.sensor, result.estimates.get("gyro"))
        found += _gyro_scatter(result)
    return found + published_rows(result.readings, local_gravity(result.plan))


def _of_sensor(result: Result, kind: Kind, sensor: LinearSensor, estimate: Estimate | None) -> list[Row]:
    unit = (
        result.readings.acc.unit
        if kind == "accelerometer" or result.readings.gyro is None
        else result.readings.gyro.unit
    )
    count = len(sensor.values)
    wanted = list(zip((*MATRIX, *BIAS, *G_SENSITIVITY)[:count], units_of(kind, count), strict=True))
    if unit != UNIT[kind]:
        wanted = [(name, f"{unit}/({UNIT[kind]})") for name in SCALE] + wanted
    why = reasons(sensor)
    found = []
    for name, own in wanted:
        quantity, axis = name.rsplit("_", 1)
        if estimate is not None and name in estimate.names:
            found.append(_row(result, estimate, name, quantity, axis, kind))
        else:
            found.append(not_estimated(quantity, axis, own, why.get(name, NO_LEVEL), kind))
    return found


def _row(result: Result, estimate: Estimate, name: str, quantity: str, axis: str, kind: str) -> Row:
    k = estimate.index(name)
    value, u, dof = float(estimate.values[k]), float(estimate.u[k]), float(estimate.dof[k])
    interval = t_interval(value, u, dof)
    finite = dof if np.isfinite(dof) else None
    reason = "relative to the fixture" if missing(result) else ""
    return Row(quantity, axis, value, u, estimate.units[k], finite, interval, reason=reason, condition=kind)


def missing(result: Result) -> list[str]:
    """Return the standards that this test is subject to and that are not stated."""
    readings, wanted = result.readings, ["gravity.value"]
    if result.acc.known:
        wanted += ["fixture.orientation", "fixture.mounting"]
    if readings.turns:
        wanted += ["turn.angle", "fixture.orientation", "fixture.mounting"]
    if readings.rotations and readings.gyro is not None:
        wanted.append("clock.rate")
    return [name for name in INFLUENCES if name in wanted and name not in result.plan.standards]


def _scatter(quantity: str, axis: str, unit: str, std: float | None, dof: float, condition: str) -> Row:
    if std is None:
        return not_estimated(quantity, axis, unit, NO_LEVEL, condition)
    if dof < FEWEST:
        return not_estimated(quantity, axis, unit, NOT_SEEN, condition)
    u = std / float(np.sqrt(2.0 * dof))
    return Row(quantity, axis, std, u, unit, dof, chi_square_interval(std, dof), condition=condition)


def _between(quantity: str, axis: str, unit: str, fit: Fitted | TwoLevels | None, condition: str) -> Row:
    """Return the row of a scatter between readings; what is hardly seen may be zero, and its interval says so."""
    if fit is None:
        return not_estimated(quantity, axis, unit, NO_LEVEL, condition)
    row = _scatter(quantity, axis, unit, fit.between, fit.between_dof, condition)
    return row if row.value is None else replace(row, interval=Interval(*fit.between_interval))


def _gyro_scatter(result: Result) -> list[Row]:
    gyro = result.gyro
    assert gyro is not None  # noqa: S101 - the caller has looked
    found = []
    for k, axis in enumerate(AXES):
        of_rest = None if gyro.rest.fits is None else gyro.rest.fits[k]
        found.append(_between("scatter_position", axis, "rad/s", of_rest, "gyro"))
    fit = None if gyro.rotated is None else gyro.rotated.found
    found.append(_between("scatter_rotation", "", "rad", fit if fit is not None and fit.free > 0 else None, "gyro"))
    used = used_angles(result)
    if len(used):
        rms = float(np.sqrt(np.mean(used**2)))
        free = 2 * len(used) - 9
        found.append(_scatter("transition_error", "", "rad", rms if free > 0 else None, free, "gyro"))
    return found


def used_angles(result: Result) -> Array:
    """Return the errors of the transitions that are in the fit [rad]."""
    gyro = result.gyro
    if gyro is None or gyro.rotated is None:
        return np.empty(0)
    return np.asarray(gyro.angles[~gyro.rotated.outliers[: len(gyro.angles)]])
