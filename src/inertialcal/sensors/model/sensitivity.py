"""How a reading moves with each parameter of the model: the derivatives of the sensor equation.

Every parameter but a warm-up time belongs to one sensor and moves the reading of that sensor alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from .equation import Columns, away_from_reference, curve, matrix_at
from .matrices import mixed
from .sensor_model import SensorModel
from .terms import Parameter


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
    moved[:, sensor] = DERIVATIVES[one.field](model, one.index, at)
    return moved


Index = tuple[int, ...]


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
