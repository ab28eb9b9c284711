"""Intervals of readings compensated for supply, pressure and warm-up hold the truth as often as they say.

Readings are drawn, and parameters fitted, by the formulas here, which share nothing with the package.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.sensitivity import ChannelReference
from inertialcal.sensors.model.uncertainty import compensated_uncertainty
from inertialcal.statistics.intervals import coverage_factor, covers

NOISE = 2e-5  # rad/s, of a reading
SHORT, LONG = 60, 1000
NAMES = {
    "bias_x": "rad/s",
    "scale_factor_error_x": "1",
    "bias_supply_x": "rad/s/V",
    "bias_supply_temperature_x": "rad/s/V/degC",
    "scale_factor_error_supply_x": "1/V",
    "bias_pressure_x": "rad/s/Pa",
    "bias_pressure_temperature_x": "rad/s/Pa/degC",
    "bias_warm_up_1_x": "rad/s",
    "warm_up_time_1": "s",
}
SIZES = np.array([1e-3, 0.01, 2e-3, 5e-5, 0.02, 5e-9, 1e-10, 2e-3, 100.0])
REFERENCES = {
    "supply": ChannelReference(5.0, "V", (4.85, 5.15)),
    "pressure": ChannelReference(1e5, "Pa", (0.0, 1.1e5)),
}


def read(parameters: Array, x: Array, at: dict[str, Array]) -> Array:
    """Readings [rad/s]."""
    bias, s, b_v, b_vt, s_v, p, p_t, w, tau = parameters
    volts, warmer, pascals = at["supply"] - 5.0, at["temperature"] - 25.0, at["pressure"] - 1e5
    k0 = bias + volts * (b_v + b_vt * warmer) + pascals * (p + p_t * warmer) + w * np.exp(-at["time"] / tau)
    return np.asarray(k0 + x * (1.0 + s + s_v * volts))


def drawn(rng: np.random.Generator, n: int) -> tuple[Array, dict[str, Array]]:
    """True rates and conditions."""
    at = {
        "supply": rng.choice([4.85, 5.0, 5.15], n),
        "temperature": rng.choice([-10.0, 25.0, 50.0], n),
        "pressure": rng.choice([0.0, 1e5], n),
        "time": rng.uniform(0.0, 1500.0, n),
    }
    return rng.uniform(-0.1, 0.1, n), at


def inside(seed: int) -> bool:
    """Whether the interval of a reading in new conditions holds its true rate; its own noise is not in the model's."""
    rng = np.random.default_rng(seed)
    true = rng.normal(0.0, 1.0, len(SIZES)) * SIZES
    true[-2:] = rng.uniform(1e-3, 4e-3), rng.uniform(200.0, 500.0)
    x, at = drawn(rng, 60)
    y = read(true, x, at) + rng.normal(0.0, NOISE, len(x))
    fit = least_squares(lambda q: (read(q * SIZES, x, at) - y) / NOISE, true / SIZES, method="lm")
    dof = len(x) - len(true)
    covariance = np.linalg.inv(fit.jac.T @ fit.jac) * (2.0 * fit.cost / dof) * np.outer(SIZES, SIZES)
    part = Component("scatter", "A", 0.5 * (covariance + covariance.T), float(dof))
    model = model_from(Estimate(tuple(NAMES), fit.x * SIZES, tuple(NAMES.values()), (part,)), "gyro", ("x",),
                       references=REFERENCES, reference_temperature=np.array([25.0]))  # fmt: skip
    new, here = drawn(rng, 1)
    channels = {"supply": here.pop("supply")}
    r = read(true, new, {**here, **channels})[:, np.newaxis]
    given = {"temperature": here["temperature"], "pressure": here["pressure"], "time": here["time"]}
    found = compensate(model, r, channels=channels, **given)
    u = compensated_uncertainty(model, r, channels=channels, **given)
    return bool(abs(found[0, 0] - new[0]) <= coverage_factor(dof) * u[0, 0])


def test_compensated_readings_over_conditions_are_covered() -> None:
    assert covers(sum(inside(seed) for seed in range(1, SHORT + 1)), SHORT)


@pytest.mark.slow
def test_compensated_readings_over_conditions_are_covered_long() -> None:
    assert covers(sum(inside(seed) for seed in range(1, LONG + 1)), LONG)
