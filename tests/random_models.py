"""Random sensor models, inputs inside their range, and conditions, from a seed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import Kind
from inertialcal.sensors.model.equation import Conditions, by_name
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel
from inertialcal.sensors.model.terms import values

AXES = ("x", "y", "z", "w")


def random_model(seed: int, linear: bool = False, k: int | None = None, estimated: bool = False) -> SensorModel:
    """A model with a random choice of terms; errors of several percent of full scale."""
    rng = np.random.default_rng(seed)
    k = int(rng.integers(1, 5)) if k is None else k
    kind: Kind = "gyro" if rng.random() < 0.5 else "accelerometer"
    span = float(10.0 ** rng.uniform(-4, 2))
    given = dict(zip(range(12), rng.random(12) < 0.6, strict=True))
    matrix = rng.normal(0.0, 0.03, (int(rng.integers(1, 4)), k, k))
    matrix[1:] *= np.array([1e-2, 1e-4])[: len(matrix) - 1, None, None]
    matrix[0] += np.eye(k)

    def term(number: int, size: float, *shape: int) -> Array | None:
        drawn = rng.normal(0.0, size, shape)
        return drawn if given[number] else None

    warm_up = term(2, 0.05 * span, 2, k)
    curved = (term(6, 0.1, k), term(7, 0.03 / span, k), term(8, 0.03 / span**2, k))
    model = SensorModel(
        kind=kind,
        axes=AXES[:k],
        item=Item("maker", "part", f"serial {seed}"),
        scale_factor=rng.uniform(0.5, 2.0, k) * 10.0 ** rng.uniform(-3, 3),
        output_unit="V",
        matrix=matrix,
        bias=rng.normal(0.0, 0.1 * span, k),
        bias_temperature=term(0, 1e-4 * span, 3, k),
        bias_pressure=term(1, 1e-6 * span, k),
        bias_warm_up=warm_up,
        warm_up_time=None if warm_up is None else rng.uniform(100.0, 2000.0, 2),
        bias_temperature_rate=term(3, span, k),
        bias_hysteresis=term(4, 0.01 * span, k),
        g_sensitivity=term(5, 0.01 * span, k, 3),
        scale_factor_asymmetry=None if linear else curved[0],
        second_order=None if linear else curved[1],
        third_order=None if linear else curved[2],
        bias_run_to_run=np.abs(rng.normal(0.0, 0.01 * span, k)) if given[9] else None,
        reference_temperature=rng.uniform(0.0, 40.0, k),
        reference_pressure=101325.0,
        input_range=np.array([[-span, span]] * k),
        temperature_range=(-20.0, 60.0),
        pressure_range=(0.0, 2e5),
    )
    model = replace(model, sensitivities=sensitivities(k, span, np.random.default_rng([seed, 1])))
    return with_estimate(model, rng) if estimated else model


CHANNELS = {
    "supply": ("V", 5.0, (4.85, 5.15)),
    "reference": ("V", 2.5, None),
    "board_temperature": ("degC", 25.0, None),
    "pressure": ("Pa", 101325.0, None),
}


def sensitivities(k: int, span: float, rng: np.random.Generator) -> tuple[Sensitivity, ...]:
    """A random choice of channels, each with a random choice of parts, none of them large at the ends of its range."""
    found = []
    for channel, (unit, reference, between) in CHANNELS.items():
        width = {"V": 0.15, "degC": 45.0, "Pa": 1e5}[unit]
        sizes = {"bias": 0.05 * span, "bias_temperature": 1e-3 * span, "scale_factor": 0.02}
        drawn = {part: rng.normal(0.0, size / width, k) for part, size in sizes.items() if rng.random() < 0.5}
        if channel == "pressure":
            drawn.pop("bias", None)
        if drawn and rng.random() < 0.5:
            found.append(Sensitivity(channel, unit, reference, range=between, **drawn))
    return tuple(found)


def with_estimate(model: SensorModel, rng: np.random.Generator) -> SensorModel:
    """The model with a full random covariance, two components and finite degrees of freedom."""
    parameters = model.parameters
    size = 0.01 * np.abs(values(parameters, model.terms)) + 1e-6
    components = []
    for source, kind, dof in (("scatter", "A", rng.uniform(3, 9, len(size))), ("table rate", "B", np.inf)):
        root = rng.normal(0.0, 1.0, (len(size), len(size))) * size[:, np.newaxis]
        covariance = root @ root.T / len(size)
        components.append(Component(source, kind, 0.5 * (covariance + covariance.T), dof))  # type: ignore[arg-type]
    estimate = Estimate(
        tuple(one.name for one in parameters),
        values(parameters, model.terms),
        tuple(one.unit for one in parameters),
        tuple(components),
    )
    origin = {one.name: Provenance("rate_x", ("rt_x", "rt_x2")) for one in parameters}
    return replace(model, estimate=estimate, provenance=origin)


def inputs(model: SensorModel, seed: int, n: int = 50) -> Array:
    """Inputs over the whole validity range, its ends and zero among them, shape (n, k)."""
    rng = np.random.default_rng(seed)
    assert model.input_range is not None
    lo, hi = model.input_range.T
    x = rng.uniform(lo, hi, (n, len(model.axes)))
    x[0], x[1], x[2] = lo, hi, 0.0
    return x


def conditions(model: SensorModel, seed: int, n: int = 50) -> Conditions:
    """Conditions that change from row to row; temperature from sensor to sensor."""
    rng = np.random.default_rng(seed)
    return {
        "temperature": rng.uniform(-20.0, 60.0, (n, len(model.axes))),
        "pressure": rng.uniform(0.0, 2e5, n),
        "time": rng.uniform(0.0, 5000.0, n),
        "temperature_rate": rng.normal(0.0, 0.01, n),
        "specific_force": rng.normal(0.0, 10.0, (n, 3)),
        "channels": {
            "supply": rng.uniform(4.85, 5.15, n),
            "reference": rng.uniform(2.35, 2.65, n),
            "board_temperature": rng.uniform(-20.0, 60.0, n),
        },
    }


def at_row(given: Conditions, i: int) -> Conditions:
    """The conditions of one row of those that change from row to row."""
    own: dict[str, Any] = {name: np.asarray(value)[i : i + 1] for name, value in by_name(given).items()}
    channels = {name: own.pop(name) for name in given.get("channels", {})}
    return cast("Conditions", {**own, "channels": channels})
