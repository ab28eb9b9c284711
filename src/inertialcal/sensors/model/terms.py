"""Parameters of the sensor equation: the name, unit and place of every number in the terms of a model.

The matrix at the reference temperature is told in the field's words: ``scale_factor_error_x = M_xx - 1`` and
``misalignment_xz = M_xz / M_xx``. Its coefficients in temperature are plain entries of M_j:
``scale_factor_error_temperature_1_x``, ``cross_axis_sensitivity_temperature_1_xz`` (not divided by M_xx).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...core.key import Key
from ...core.units import normalise

FORCE_AXES = ("x", "y", "z")

# Shapes of the terms: k sensors, q powers of temperature, m warm-up exponentials, f force axes.
SHAPES: dict[str, tuple[str, ...]] = {
    "scale_factor": ("k",),
    "matrix": ("q", "k", "k"),
    "bias": ("k",),
    "bias_temperature": ("q", "k"),
    "bias_pressure": ("k",),
    "bias_warm_up": ("m", "k"),
    "warm_up_time": ("m",),
    "bias_temperature_rate": ("k",),
    "bias_hysteresis": ("k",),
    "bias_run_to_run": ("k",),
    "scale_factor_asymmetry": ("k",),
    "second_order": ("k",),
    "third_order": ("k",),
    "g_sensitivity": ("k", "f"),
    "reference_temperature": ("k",),
    "input_range": ("k", "2"),
}

# field of the model -> quantity and unit; U is the input unit, j counts powers or exponentials from 1.
PER_AXIS = {
    "bias": ("bias", "{U}"),
    "bias_pressure": ("bias_pressure", "{U}/Pa"),
    "bias_temperature_rate": ("bias_temperature_rate", "({U})/(degC/s)"),
    "bias_hysteresis": ("bias_hysteresis", "{U}"),
    "scale_factor_asymmetry": ("scale_factor_asymmetry", "1"),
    "second_order": ("second_order", "1/({U})"),
    "third_order": ("third_order", "1/({U})^2"),
}
PER_POWER = {
    "bias_temperature": ("bias_temperature", "{U}/degC"),
    "bias_warm_up": ("bias_warm_up", "{U}"),
}
COUNTED = {
    "bias_temperature": "bias_temperature", "bias_warm_up": "bias_warm_up", "warm_up_time": "bias_warm_up",
    "scale_factor_error_temperature": "matrix", "cross_axis_sensitivity_temperature": "matrix",
}  # terms of which there are several: whose number they have  # fmt: skip


@dataclass(frozen=True)
class Parameter:
    """One number of a model."""

    name: str  # ``"misalignment_xz"``
    # Its two parts: ``"misalignment"``, ``"xz"``
    quantity: str
    axis: str
    unit: str  # SI, and degC
    field: str  # Attribute of the model that holds it
    index: tuple[int, ...]  # Where in that array


def parameters(axes: Sequence[str], unit: str, arrays: Mapping[str, Array]) -> tuple[Parameter, ...]:
    """Return the parameters of the terms that are present.

    Parameters
    ----------
    axes : sequence of str, length k
        Names of the sensors.
    unit : str
        Input unit.
    arrays : mapping of ndarray
        Field of the model -> its array, present terms only.
    """
    found: list[Parameter] = []
    found += _matrix(axes, arrays["matrix"])
    for name, (quantity, form) in PER_AXIS.items():
        if name in arrays:
            found += [_parameter(quantity, a, form, unit, name, (i,)) for i, a in enumerate(axes)]
    for name, (quantity, form) in PER_POWER.items():
        for j in range(len(arrays.get(name, ()))):
            power = f"^{j + 1}" if j and name == "bias_temperature" else ""
            found += [
                _parameter(f"{quantity}_{j + 1}", a, form + power, unit, name, (j, i)) for i, a in enumerate(axes)
            ]
    for m in range(len(arrays.get("warm_up_time", ()))):
        found.append(_parameter(f"warm_up_time_{m + 1}", "", "s", unit, "warm_up_time", (m,)))
    if "g_sensitivity" in arrays:
        pairs = [(i, a, j, f) for i, a in enumerate(axes) for j, f in enumerate(FORCE_AXES)]
        found += [
            _parameter("g_sensitivity", a + f, "({U})/(m/s^2)", unit, "g_sensitivity", (i, j)) for i, a, j, f in pairs
        ]
    return tuple(found)


def _parameter(quantity: str, axis: str, form: str, unit: str, name: str, index: tuple[int, ...]) -> Parameter:
    full = f"{quantity}_{axis}" if axis else quantity
    return Parameter(full, quantity, axis, normalise(form.replace("{U}", unit)), name, index)


def _matrix(axes: Sequence[str], matrix: Array) -> list[Parameter]:
    found = []
    for j in range(len(matrix)):
        diagonal = "scale_factor_error" + (f"_temperature_{j}" if j else "")
        cross = f"cross_axis_sensitivity_temperature_{j}" if j else "misalignment"
        unit = f"1/degC^{j}" if j > 1 else "1/degC" if j else "1"
        for i, row in enumerate(axes):
            found.append(_parameter(diagonal, row, unit, "", "matrix", (j, i, i)))
        for i, row in enumerate(axes):
            for column_at, column in enumerate(axes):
                if i != column_at:
                    found.append(_parameter(cross, row + column, unit if j else "rad", "", "matrix", (j, i, column_at)))
    return found


def values(wanted: Iterable[Parameter], arrays: Mapping[str, Array]) -> Array:
    """Return the values of parameters, each in its unit."""
    return np.array([_value(one, arrays[one.field]) for one in wanted])


def _value(one: Parameter, array: Array) -> float:
    if one.field == "matrix" and one.index[0] == 0:
        _, row, column = one.index
        diagonal = float(array[0, row, row])
        return diagonal - 1.0 if row == column else float(array[0, row, column]) / diagonal
    return float(array[one.index])


def with_values(arrays: Mapping[str, Array], changes: Mapping[Parameter, float]) -> dict[str, Array]:
    """Return the arrays with some parameters set; the others keep their values.

    A misalignment is a ratio, so a new scale factor error takes its row of the matrix along.
    """
    new = {name: np.array(array) for name, array in arrays.items()}
    at_reference = {one: value for one, value in changes.items() if one.field == "matrix" and one.index[0] == 0}
    for one, value in changes.items():
        if one not in at_reference:
            new[one.field][one.index] = value
    scale_errors = {one.index[1]: value for one, value in at_reference.items() if one.index[1] == one.index[2]}
    for row, value in scale_errors.items():
        entries = new["matrix"][0, row]
        entries *= (1.0 + value) / entries[row]
        entries[row] = 1.0 + value
    for one, value in at_reference.items():
        _, row, column = one.index
        if row != column:
            new["matrix"][0, row, column] = value * new["matrix"][0, row, row]
    return new


def orders(keys: Iterable[Key]) -> dict[str, int]:
    """Highest power of temperature, or number of exponentials, of the counted terms among the keys.

    Returns
    -------
    dict of str to int
        ``matrix`` (0 when constant), ``bias_temperature`` and ``bias_warm_up``.
    """
    found = {"matrix": 0, "bias_temperature": 0, "bias_warm_up": 0}
    for key in keys:
        if key.quantity in COUNTED:
            found[COUNTED[key.quantity]] = max(found[COUNTED[key.quantity]], key.power)
    return found
