"""From matrix and offset to the field's quantities, as Estimates, and to the model of the sensor equation.

``scale_factor_error_x = A_xx - 1``, ``misalignment_xz = A_xz / A_xx``, ``bias`` is the offset, ``scale_factor_x`` the
ideal scale factor times A_xx, where readings are not in SI. What is not told, and what the frame defines, is not in the
Estimate: it has a reason instead.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.axes import AXES, Kind
from ...core.estimate import Array, Component, Estimate
from ...core.key import Key, Reason
from ...core.units import normalise
from ...sensors.model.assemble import model_from
from ...sensors.model.sensor_model import SensorModel
from .fit.linear_sensor import BIAS, G_SENSITIVITY, MATRIX, LinearSensor, with_ideal

SCALE = tuple(Key("scale_factor", a) for a in AXES)
ROUNDING = 1e-12  # of the terms that make up a variance
UNIT: dict[str, str] = {"accelerometer": "m/s^2", "gyro": "rad/s"}


def units_of(kind: Kind, count: int) -> tuple[str, ...]:
    """Return the units of so many numbers, 12 or 21, in the order of ``linear_sensor``."""
    unit = UNIT[kind]
    matrix = tuple("1" if key.quantity == "scale_factor_error" else "rad" for key in MATRIX)
    return (*matrix, *(unit,) * 3, *(normalise(f"({unit})/(m/s^2)"),) * 9)[:count]


def quantities(sensor: LinearSensor) -> tuple[Array, Array]:
    """Return the quantities, in the order of the numbers, and their derivatives by these."""
    values, derivative = sensor.values.copy(), np.eye(len(sensor.values))
    for i in range(3):
        own = sensor.values[4 * i]
        values[4 * i] = own - 1.0
        for j in range(3):
            if j != i:
                at = 3 * i + j
                values[at] = sensor.values[at] / own
                derivative[at, at] = 1.0 / own
                derivative[at, 4 * i] = -values[at] / own
    return values, derivative


def estimate(sensor: LinearSensor, kind: Kind, output_unit: str) -> Estimate | None:
    """Return what is told of a sensor; None where nothing is.

    Parameters
    ----------
    sensor : LinearSensor
        As it was fitted, relative to its ideal scale factor and zero.
    kind : {"accelerometer", "gyro"}
        What it senses.
    output_unit : str
        Of the readings; where they are not in SI, scale factors in it come first.
    """
    values, derivative = quantities(sensor)
    names = [*MATRIX, *BIAS, *G_SENSITIVITY][: len(values)]
    units = list(units_of(kind, len(values)))
    if output_unit != UNIT[kind]:
        rows = np.zeros((3, len(values)))
        rows[np.arange(3), 4 * np.arange(3)] = sensor.ideal
        values = np.concatenate([sensor.ideal * np.diag(sensor.matrix), values])
        derivative = np.vstack([rows, derivative])
        names, units = [*SCALE, *names], [f"{output_unit}/({UNIT[kind]})"] * 3 + units
    why = reasons(sensor)
    told = [k for k, name in enumerate(names) if not why.get(name)]
    if not told or not sensor.sources:
        return None
    components = tuple(_components(sensor, derivative[told]))
    return Estimate(tuple(names[k] for k in told), values[told], tuple(normalise(units[k]) for k in told), components)


def reasons(sensor: LinearSensor) -> Mapping[Key, Reason]:
    """Return why a quantity is not estimated, by its key."""
    names = (*MATRIX, *BIAS, *G_SENSITIVITY)
    found = {names[k]: reason for k, reason in sensor.reasons.items()}
    for axis in AXES:
        reason = found.get(Key("scale_factor_error", axis))
        if reason:
            found[Key("scale_factor", axis)] = reason
            for other in AXES:
                if other != axis:
                    found.setdefault(Key("misalignment", axis + other), reason)
    return found


def _components(sensor: LinearSensor, derivative: Array) -> list[Component]:
    found = []
    for one in sensor.sources:
        whole = _propagated(derivative, one.covariance)
        dof = np.asarray(one.dof, dtype=float)
        if dof.ndim:  # of each number: of a quantity the least of those that it depends on
            uses = derivative != 0.0
            dof = np.array([dof[row].min() for row in uses])
        stated = None if one.influence is None else one.influence.stated
        distribution = "t" if one.influence is None else one.influence.distribution
        kind = "B" if one.kind == "B" else "A"
        own: Array | float = dof if dof.ndim else float(dof)
        found.append(Component(one.origin, kind, whole, own, distribution, stated))  # type: ignore[arg-type]
    return found


def _propagated(derivative: Array, covariance: Array) -> Array:
    """Return the covariance of the quantities; one that a source moves by rounding alone it does not move."""
    whole = derivative @ covariance @ derivative.T
    size = np.diag(np.abs(derivative) @ np.abs(covariance) @ np.abs(derivative).T)
    moved = np.diag(whole) > ROUNDING * size
    return np.asarray(np.where(np.outer(moved, moved), 0.5 * (whole + whole.T), 0.0))


def model(sensor: LinearSensor, kind: Kind, output_unit: str, input_range: Array) -> SensorModel | None:
    """Return the model for readings as they were recorded, their zero in the bias; None where nothing is told.

    Parameters
    ----------
    sensor, kind, output_unit
        As `estimate` takes them.
    input_range : ndarray, shape (3, 2)
        Least and largest input that was seen [input unit].
    """
    raw = with_ideal(sensor, sensor.ideal, np.zeros(3))
    found = estimate(raw, kind, output_unit)
    if found is None:
        return None
    kept = [key for key in found.keys if key not in SCALE]
    why = {str(key): reason.text for key, reason in reasons(raw).items() if key not in SCALE}
    return model_from(
        found.select(kept),
        kind,
        AXES,
        scale_factor=raw.ideal,
        output_unit=output_unit,
        input_range=input_range,
        not_estimated=why,
    )
