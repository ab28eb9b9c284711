"""Standard uncertainty of a compensated reading, from the covariance of the model.

The reading fixes ``r = K0 + g(M x) + G f``. A small change of a parameter theta at a fixed reading moves x by
``dx/dtheta = -M^-1 diag(1/g'(u)) dr/dtheta`` (implicit function theorem), with dr/dtheta from the equation itself:
the Jacobian is analytic, one column a parameter. The bias from power-up to power-up, which compensation cannot
know, enters as an independent variance of each sensor. Noise of the reading, and the uncertainty of the
conditions given (temperature, ...), are not in it.

References
----------
.. [1] JCGM 100:2008 (GUM), clauses 5.1 and 5.2; JCGM 102:2011 for several outputs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from .compensate import compensate, empty_impossible, pieces
from .equation import Columns, Conditions, away_from_reference, condition_columns, curve, inverted, matrix_at, mixed
from .sensor_model import SensorModel
from .terms import Parameter

Index = tuple[int, ...]


def compensated_uncertainty(model: SensorModel, readings: Array, **conditions: Unpack[Conditions]) -> Array:
    """Return the standard uncertainty of compensated readings.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        As for ``compensate`` [input unit].
    **conditions
        See ``equation.Conditions``.

    Returns
    -------
    ndarray, shape (n, k)
        [input unit]. Parameters that the estimate does not hold count as exact: `without_uncertainty` names them.

    Raises
    ------
    DataError
        ``no_covariance`` if the model carries none; and as ``compensate``.
    """
    estimate = estimate_of(model)
    x = compensate(model, readings, **conditions)
    columns = condition_columns(model, len(x), conditions)
    by_name = {one.name: one for one in model.parameters}
    held = [by_name[name] for name in estimate.names]
    covariance = estimate.covariance
    out = np.empty(x.shape)
    for part, here in pieces(columns, len(x)):
        with np.errstate(over="ignore", invalid="ignore"):  # a polynomial far away from its data
            at = point(model, x[part], here)
            to_input = inverted(at.matrix) / at.slope[:, np.newaxis, :]
            moved = to_input @ np.stack([reading_by(model, one, at) for one in held], axis=2)
            variance = np.einsum("nkp,nkp->nk", moved @ covariance, moved)
            if model.bias_run_to_run is not None:
                variance = variance + to_input**2 @ model.bias_run_to_run**2
            out[part] = np.sqrt(np.maximum(variance, 0.0))
        empty_impossible(out[part])
    return out


def estimate_of(model: SensorModel) -> Estimate:
    """Return the parameters with their covariance.

    Raises
    ------
    DataError
        ``no_covariance`` if the model carries none.
    """
    if model.estimate is None:
        raise DataError(
            "the model carries no covariance",
            why="the uncertainty of a compensated reading comes from it",
            do="Use a model that a campaign has estimated",
            code="no_covariance",
        )
    return model.estimate


def without_uncertainty(model: SensorModel) -> tuple[str, ...]:
    """Names of the parameters that no covariance covers."""
    held = set() if model.estimate is None else set(model.estimate.names)
    return tuple(one.name for one in model.parameters if one.name not in held)


@dataclass(frozen=True, eq=False)
class Point:
    """Where the derivatives are taken: n inputs x and u = M x, slopes g'(u), M, and the conditions.

    Shapes: x, u, slope (n, k); matrix (1 or n, k, k); away, T - T_ref, (1 or n, k), zero without temperature.
    """

    x: Array
    u: Array
    slope: Array
    matrix: Array
    away: Array
    columns: Columns

    def condition(self, name: str, sensor: int) -> Array:
        """Condition of one sensor, its own column or the common one, shape (1 or n,)."""
        column = self.columns[name]
        return column[:, sensor if column.shape[1] > 1 else 0]


def point(model: SensorModel, x: Array, columns: Columns) -> Point:
    """Return the point at true inputs x, shape (n, k)."""
    matrix = matrix_at(model, columns)
    u = mixed(matrix, x)
    away = np.zeros((1, len(model.axes)))
    if "temperature" in columns:
        away = away_from_reference(model, columns)
    return Point(x, u, curve(model).slope(u), matrix, away, columns)


def reading_by(model: SensorModel, one: Parameter, at: Point) -> Array:
    """Return dr/dtheta of all sensors at fixed input.

    Returns
    -------
    ndarray, shape (n, k)
        [input unit / unit of the parameter].
    """
    moved = np.zeros(at.x.shape)
    if one.field == "warm_up_time":
        moved += _warm_up_time(model, one.index, at)
        return moved
    sensor = one.index[-2] if one.field in {"matrix", "g_sensitivity"} else one.index[-1]
    if one.channel:
        moved[:, sensor] = _sensitivity(model, one, at)
        return moved
    moved[:, sensor] = DERIVATIVES[one.field](model, one.index, at)
    return moved


def _matrix(model: SensorModel, index: Index, at: Point) -> Array:
    """dr/dM-entry = g' du/dM-entry; a scale factor error takes the misalignments of its row along."""
    power, row, column = index
    entries = model.matrix[0, row]
    if power:
        felt_more = at.away[:, row] ** power * at.x[:, column]
    elif row == column:
        felt_more = at.x @ (entries / entries[row])
    else:
        felt_more = entries[row] * at.x[:, column]
    return np.asarray(at.slope[:, row] * felt_more)


def _warm_up_time(model: SensorModel, index: Index, at: Point) -> Array:
    assert model.bias_warm_up is not None and model.warm_up_time is not None  # noqa: S101, PT018 - for the type checker
    tau, time = model.warm_up_time[index[0]], at.columns["time"]
    return np.asarray(model.bias_warm_up[index[0]] * np.exp(-time / tau) * time / tau**2)


def _warm_up(model: SensorModel, index: Index, at: Point) -> Array:
    assert model.warm_up_time is not None  # noqa: S101 - for the type checker
    return np.asarray(np.exp(-at.columns["time"][:, 0] / model.warm_up_time[index[0]]))


def _pressure(model: SensorModel, _: Index, at: Point) -> Array:
    assert model.reference_pressure is not None  # noqa: S101 - for the type checker
    return at.columns["pressure"][:, 0] - model.reference_pressure


def _sensitivity(model: SensorModel, one: Parameter, at: Point) -> Array:
    """Return dr/dtheta of one sensor, of a part of its sensitivity to a channel."""
    sensor = one.index[0]
    reference = next(other.reference for other in model.sensitivities if other.channel == one.channel)
    away = at.columns[one.channel][:, 0] - reference
    if one.part == "scale_factor":
        return np.asarray(at.slope[:, sensor] * away * at.x[:, sensor])
    return away * at.away[:, sensor] if one.part == "bias_temperature" else away


DERIVATIVES: dict[str, Callable[[SensorModel, Index, Point], Array | float]] = {
    "matrix": _matrix,
    "bias": lambda _, index, at: 1.0,
    "bias_temperature": lambda _, index, at: at.away[:, index[1]] ** (index[0] + 1),
    "bias_pressure": _pressure,
    "bias_warm_up": _warm_up,
    "bias_temperature_rate": lambda _, index, at: at.condition("temperature_rate", index[0]),
    "bias_hysteresis": lambda _, index, at: np.sign(at.condition("temperature_rate", index[0])),
    "scale_factor_asymmetry": lambda _, index, at: 0.5 * np.abs(at.u[:, index[0]]),
    "second_order": lambda _, index, at: at.u[:, index[0]] ** 2,
    "third_order": lambda _, index, at: at.u[:, index[0]] ** 3,
    "g_sensitivity": lambda _, index, at: at.columns["specific_force"][:, index[1]],
}
