"""Curves of a test of positions: what every position and every rotation leaves.

``positions``, a row a static interval: the unit vector ``up_x``, ``up_y``, ``up_z`` of specific force in body axes, the
``residual`` along it with the position in the fit, ``deletion`` from the fit without it, positive where it reads too
much; of known orientations what is left across gravity too. ``transitions``, a row a rotation between two of them: the
angle from where the gyros carry gravity to where the accelerometers find it, and what it would be had g-sensitivity
been left out of the model.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from .fit.gyro import FittedGyro, fit_gyro
from .fit.rotations import across

if TYPE_CHECKING:
    from .reduction import Result


def curves(result: Result) -> list[Curve]:
    """Return the curves of ``results.json``, SI: positions, and transitions where there are rotations."""
    found = [positions_curve(result)]
    if result.gyro is not None and len(result.gyro.angles):
        found.append(transitions_curve(result, result.gyro))
    return found


def positions_curve(result: Result) -> Curve:
    """Return what every position leaves."""
    fitted, readings = result.acc, result.readings
    force = fitted.sensor.applied(readings.acc.mean)
    up = force / np.linalg.norm(force, axis=1)[:, None]
    columns = {"position": Column(np.arange(1.0, len(readings) + 1.0))}
    columns |= {f"up_{axis}": Column(up[:, i]) for i, axis in enumerate("xyz")}
    for name, values in (("residual", fitted.residuals), ("deletion", fitted.deletion)):
        columns[name] = Column(along(values, up), "m/s^2")
    if fitted.residuals.shape[1] == 3:
        level = np.einsum("kai,ki->ka", across(up), fitted.residuals)
        columns |= {f"residual_across_{i + 1}": Column(level[:, i], "m/s^2") for i in range(2)}
    between = np.nan if fitted.between is None else fitted.between
    columns["between"] = Column(np.full(len(readings), between), "m/s^2")
    columns["left_out"] = Column([bool(one) for one in fitted.outliers])
    columns["where"] = Column(list(readings.where) or [""] * len(readings))
    return Curve("positions", "", columns, sensor="accelerometer")


def along(values: Array, up: Array) -> Array:
    """Return residuals along gravity, shape (m,): of three components the part along it."""
    return np.asarray(values[:, 0] if values.shape[1] == 1 else np.sum(values * up, axis=1))


def transitions_curve(result: Result, gyro: FittedGyro) -> Curve:
    """Return what every rotation between two positions leaves; where the model has it, without g-sensitivity too."""
    k, transitions = len(gyro.angles), result.readings.transitions
    columns = {
        "rotation": Column(np.arange(1.0, k + 1.0)),
        "before": Column(np.array([one.before + 1.0 for one in transitions])),
        "after": Column(np.array([one.after + 1.0 for one in transitions])),
        "error": Column(gyro.angles, "rad"),
    }
    if gyro.rest.g_sensitivity is not None and gyro.rotated is not None:
        plan, sensor = replace(result.plan, g_sensitivity=False), gyro.sensor
        without = fit_gyro(plan, result.readings, result.acc, sensor.ideal, sensor.zero, gyro.rotated.W)
        columns["error_without"] = Column(without.angles, "rad")
    left_out = np.zeros(k, dtype=bool) if gyro.rotated is None else gyro.rotated.outliers[:k]
    columns["left_out"] = Column([bool(one) for one in left_out])
    return Curve("transitions", "", columns, sensor="gyro")
