"""Rows of a result of positions: every quantity with its uncertainty, or the reason why there is none.

The sensor of the key says whose: ``accelerometer`` or ``gyro``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.axes import AXES, Kind
from ...core.estimate import Array, Estimate
from ...core.key import Key, Reason
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

NO_LEVEL = Reason("not_repeated", "nothing was repeated that it could be told from")
NOT_SEEN = Reason("hardly_seen", "hardly seen above what is known of each: less than one degree of freedom")


def rows(result: Result) -> list[Row]:
    """Return all rows, SI, accelerometers first."""
    found = _of_sensor(result, "accelerometer", result.acc.sensor, result.estimates.get("accelerometer"))
    found.append(_between(Key("scatter_position", "", "accelerometer"), "m/s^2", result.acc))
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
        key = name._replace(sensor=kind)
        if estimate is not None and name in estimate.keys:
            found.append(_row(result, estimate, name, key))
        else:
            found.append(not_estimated(key, own, why.get(name, NO_LEVEL)))
    return found


def _row(result: Result, estimate: Estimate, name: Key, key: Key) -> Row:
    k = estimate.index(name)
    value, u, dof = float(estimate.values[k]), float(estimate.u[k]), float(estimate.dof[k])
    interval = t_interval(value, u, dof)
    finite = dof if np.isfinite(dof) else None
    reason = Reason("relative", "relative to the fixture") if missing(result) else Reason()
    return Row(key, value, u, estimate.units[k], finite, interval, reason=reason)


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


def _scatter(key: Key, unit: str, std: float | None, dof: float) -> Row:
    if std is None:
        return not_estimated(key, unit, NO_LEVEL)
    if dof < FEWEST:
        return not_estimated(key, unit, NOT_SEEN)
    u = std / float(np.sqrt(2.0 * dof))
    return Row(key, std, u, unit, dof, chi_square_interval(std, dof))


def _between(key: Key, unit: str, fit: Fitted | TwoLevels | None) -> Row:
    """Return the row of a scatter between readings; what is hardly seen may be zero, and its interval says so."""
    if fit is None:
        return not_estimated(key, unit, NO_LEVEL)
    row = _scatter(key, unit, fit.between, fit.between_dof)
    return row if row.value is None else replace(row, interval=Interval(*fit.between_interval))


def _gyro_scatter(result: Result) -> list[Row]:
    gyro = result.gyro
    assert gyro is not None  # noqa: S101 - the caller has looked
    found = []
    for k, axis in enumerate(AXES):
        of_rest = None if gyro.rest.fits is None else gyro.rest.fits[k]
        found.append(_between(Key("scatter_position", axis, "gyro"), "rad/s", of_rest))
    fit = None if gyro.rotated is None else gyro.rotated.found
    found.append(
        _between(Key("scatter_rotation", "", "gyro"), "rad", fit if fit is not None and fit.free > 0 else None)
    )
    used = used_angles(result)
    if len(used):
        rms = float(np.sqrt(np.mean(used**2)))
        free = 2 * len(used) - 9
        found.append(_scatter(Key("transition_error", "", "gyro"), "rad", rms if free > 0 else None, free))
    return found


def used_angles(result: Result) -> Array:
    """Return the errors of the transitions that are in the fit [rad]."""
    gyro = result.gyro
    if gyro is None or gyro.rotated is None:
        return np.empty(0)
    return np.asarray(gyro.angles[~gyro.rotated.outliers[: len(gyro.angles)]])
