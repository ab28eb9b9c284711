"""The sensor equation forward: from the true input and the conditions to the reading.

Signs, units and the order of the matrix are those of ``sensors.model``. Conditions are given as numbers (the
same for all rows), as arrays of shape (n,) (one a row) or, for temperature and its rate, (n, k) (one a sensor).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypedDict, Unpack

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .nonlinearity import Curve
from .sensitivity import quantity_of
from .sensor_model import SensorModel

PER_SENSOR = {"temperature", "temperature_rate"}  # conditions that may differ from sensor to sensor

# Which term needs which condition.
NEEDS = {
    "bias_temperature": "temperature",
    "bias_pressure": "pressure",
    "bias_warm_up": "time",
    "bias_temperature_rate": "temperature_rate",
    "bias_hysteresis": "temperature_rate",
    "g_sensitivity": "specific_force",
}
Columns = Mapping[str, Array]


class Conditions(TypedDict, total=False):
    """What else the reading depends on; only what the terms of the model need must be given.

    Attributes
    ----------
    temperature : float or ndarray, shape (n,) or (n, k)
        [degC]
    pressure : float or ndarray, shape (n,)
        [Pa]
    time : float or ndarray, shape (n,)
        Since power-up [s].
    temperature_rate : float or ndarray, shape (n,) or (n, k)
        dT/dt, positive when warming [degC/s].
    specific_force : ndarray, shape (3,) or (n, 3)
        f along the body axes x, y, z [m/s2].
    channels : mapping of str to (float or ndarray, shape (n,))
        Channels that the model has sensitivities to, by name, each in the unit that its `Sensitivity` says.
    """

    temperature: Array | float
    pressure: Array | float
    time: Array | float
    temperature_rate: Array | float
    specific_force: Array
    channels: Mapping[str, Array | float]


def predict(model: SensorModel, applied: Array, **conditions: Unpack[Conditions]) -> Array:
    """Return the readings that a sensor with this model gives, without noise.

    Parameters
    ----------
    applied : ndarray, shape (n, k)
        True input along the axes [input unit].
    **conditions
        See `Conditions`.

    Returns
    -------
    ndarray, shape (n, k)
        r = v / S0 [input unit].

    Raises
    ------
    DataError
        If a shape does not fit, or a condition is missing that a term needs (``missing_condition``).
    """
    x = rows(model, applied, "applied")
    columns = condition_columns(model, len(x), conditions)
    u = mixed(matrix_at(model, columns), x)
    return offset(model, columns) + curve(model).reading(u)


def rows(model: SensorModel, values: Array, what: str) -> Array:
    """Values as float64 rows of k.

    Raises
    ------
    DataError
        If they are not of shape (n, k); one sensor may have (n,).
    """
    array = np.asarray(values, dtype=float)
    k = len(model.axes)
    if array.ndim == 1 and k == 1:
        array = array[:, np.newaxis]
    if array.ndim != 2 or array.shape[1] != k:
        raise DataError(
            f"{what}: shape {np.shape(values)}, need (n, {k})", do=f"Give a column for each of {', '.join(model.axes)}"
        )
    return array


def condition_columns(model: SensorModel, n: int, conditions: Conditions) -> dict[str, Array]:
    """Conditions as arrays of shape (1 or n, 1 or k or 3); those that no term needs are left out.

    Raises
    ------
    DataError
        ``missing_condition``, or a shape that does not fit n rows.
    """
    given = by_name(conditions)
    columns = {}
    for name, term in needed(model).items():
        value = given.get(name)
        if value is None:
            raise DataError(
                f"no {name.replace('_', ' ')} given",
                why=f"the model has the term {term}",
                do=f"Give {name}, or a model without this term",
                code="missing_condition",
            )
        columns[name] = _column(np.asarray(value, dtype=float), n, name, len(model.axes))
    return columns


def by_name(conditions: Conditions) -> dict[str, object]:
    """Return all conditions by name, other channels with them."""
    own = {name: value for name, value in conditions.items() if name != "channels"}
    return {**conditions.get("channels", {}), **own}


def needed(model: SensorModel) -> dict[str, str]:
    """Conditions that the terms of a model need, each with the first term that needs it."""
    found = {"temperature": "matrix (in temperature)"} if model.matrix.shape[0] > 1 else {}
    for term, name in NEEDS.items():
        if getattr(model, term) is not None:
            found.setdefault(name, term)
    for one in model.sensitivities:
        for part in one.parts:
            found.setdefault(one.channel, quantity_of(part, one.channel))
            if part == "bias_temperature":
                found.setdefault("temperature", quantity_of(part, one.channel))
    return found


def _column(value: Array, n: int, name: str, k: int) -> Array:
    if name == "specific_force":
        wide = value[np.newaxis] if value.ndim == 1 else value
        widths = {3}
    else:
        wide = value.reshape(-1, 1) if value.ndim < 2 else value
        widths = {1, k} if name in PER_SENSOR else {1}
    if wide.ndim != 2 or wide.shape[0] not in {1, n} or wide.shape[1] not in widths:
        raise DataError(f"{name}: shape {value.shape} does not fit {n} reading(s) of {k} sensor(s)")
    return wide


def matrix_at(model: SensorModel, columns: Columns) -> Array:
    """M at the conditions, shape (1 or n, k, k); each row of M at the temperature of its sensor."""
    total: Array = model.matrix[-1:]
    if model.matrix.shape[0] > 1:
        away = away_from_reference(model, columns)[:, :, np.newaxis]
        for coefficient in model.matrix[-2::-1]:
            total = total * away + coefficient
    for one in model.sensitivities:
        if one.scale_factor is not None:
            change = (columns[one.channel] - one.reference) * one.scale_factor
            total = total + change[:, :, np.newaxis] * np.eye(len(model.axes))
    return total


def offset(model: SensorModel, columns: Columns) -> Array:
    """K0 + G f at the conditions, shape (1 or n, k) [input unit]."""
    total = model.bias[np.newaxis]
    if model.bias_temperature is not None:
        away = away_from_reference(model, columns)
        bent = np.zeros((1, 1))
        for coefficient in model.bias_temperature[::-1]:
            bent = (bent + coefficient) * away
        total = total + bent
    if model.bias_pressure is not None and model.reference_pressure is not None:
        total = total + model.bias_pressure * (columns["pressure"] - model.reference_pressure)
    if model.bias_warm_up is not None and model.warm_up_time is not None:
        total = total + mixed(model.bias_warm_up.T[np.newaxis], np.exp(-columns["time"] / model.warm_up_time))
    if model.bias_temperature_rate is not None:
        total = total + model.bias_temperature_rate * columns["temperature_rate"]
    if model.bias_hysteresis is not None:
        total = total + model.bias_hysteresis * np.sign(columns["temperature_rate"])
    if model.g_sensitivity is not None:
        total = total + mixed(model.g_sensitivity[np.newaxis], columns["specific_force"])
    return _by_channels(model, columns, total)


def _by_channels(model: SensorModel, columns: Columns, total: Array) -> Array:
    """Return a bias with its changes with other channels added."""
    for one in model.sensitivities:
        away = columns[one.channel] - one.reference
        if one.bias is not None:
            total = total + one.bias * away
        if one.bias_temperature is not None:
            total = total + one.bias_temperature * away * away_from_reference(model, columns)
    return total


def away_from_reference(model: SensorModel, columns: Columns) -> Array:
    """T - T_ref, shape (1 or n, k) [degC]."""
    away: Array = columns["temperature"] - model.terms["reference_temperature"]
    return away


def curve(model: SensorModel) -> Curve:
    """Return the nonlinearity of the sensors; absent terms are zero."""
    zero = np.zeros(len(model.axes))
    terms = (model.scale_factor_asymmetry, model.second_order, model.third_order)
    return Curve(*(zero if term is None else term for term in terms))


def mixed(matrix: Array, x: Array) -> Array:
    """Return rows of x times a matrix, shape (n, k), summed in the order of the columns (not left to a BLAS).

    So the last digit of a row depends neither on the rows around it nor on the number of threads. An entry of
    zero takes nothing from x, not even a missing reading.

    Parameters
    ----------
    matrix : ndarray, shape (1 or n, k, l)
        One for all rows, or one a row.
    x : ndarray, shape (n, l)
        One row a reading.
    """
    out = np.empty((max(len(matrix), len(x)), matrix.shape[1]))
    columns = np.ascontiguousarray(x.T)
    for i, row in enumerate(np.any(matrix != 0.0, axis=0)):
        total = np.zeros(len(out))
        for j in np.flatnonzero(row):
            total += matrix[:, i, j] * np.where(matrix[:, i, j] != 0.0, columns[j], 0.0)
        out[:, i] = total
    return out


def inverted(matrix: Array) -> Array:
    """Return the inverses of matrices, shape (n, k, k).

    Three by three, by cofactors over the determinant: 20 times faster than one factorisation a matrix, and as good
    for matrices like these, near a diagonal one.

    Raises
    ------
    DataError
        ``not_invertible`` if one is singular.
    """
    try:
        return _by_cofactors(matrix) if matrix.shape[1:] == (3, 3) else np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        raise DataError(
            "the matrix of the model is singular at a temperature of the data", code="not_invertible"
        ) from None


def _by_cofactors(matrix: Array) -> Array:
    rows = [matrix[:, i, :].T for i in range(3)]
    cofactors = np.stack([_cross(rows[(i + 1) % 3], rows[(i + 2) % 3]) for i in range(3)])  # (row, column, n)
    determinant = (rows[0] * cofactors[0]).sum(axis=0)
    if np.any(determinant == 0.0):
        raise np.linalg.LinAlgError
    return np.asarray((cofactors / determinant).transpose(2, 1, 0))


def _cross(a: Array, b: Array) -> Array:
    """Vector products of columns, shape (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
