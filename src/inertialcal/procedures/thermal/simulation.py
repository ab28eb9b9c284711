"""Readings of a thermal test whose truth is known: power-ups, ramps both ways, noise slower than a ramp."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.polynomial import polynomial

from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from .fit.quantities import earth_along
from .plan import Plan
from .recordings import Readings, Sweep

DEG = float(np.radians(1.0))


@dataclass(frozen=True, eq=False)
class Truth:
    """Sensor, chamber and scatter; one axis an entry where an array has the shape (k,)."""

    # shape (order + 1, k): of the bias in powers of T - ``reference`` [rad/s/degC^j]: mean over power-ups, midway
    # between the paths
    coefficients: Array = field(
        default_factory=lambda: DEG * np.array([[0.03], [-3e-3], [1.6e-5], [-2e-7]])  # as Table 4, x
    )
    reference: float = 20.0  # [degC]
    set_points: tuple[float, ...] = (23.0, -30.0, 67.0, 23.0)  # Of the chamber, one after the other [degC]
    rates: tuple[float, ...] = (1.5 / 60.0, 0.75 / 60.0)  # Of its ramps, run after run in turn [degC/s]
    hold: float = 900.0  # At the first set-point [s]
    soak: float = 900.0  # At each of the others [s]
    runs: int = 5  # Power-ups
    interval: float = 10.0  # From sample to sample [s]
    white: float = 0.0018 * DEG  # Scatter of a sample [rad/s]
    walk: float = 2e-5 * DEG  # Random walk of the bias within a run [rad/s/sqrt(s)]
    run_std: float = 0.006 * DEG  # From power-up to power-up, of the bias [rad/s]
    slope_std: float = 1e-5 * DEG  # From power-up to power-up, of the slope [rad/s/degC]
    hysteresis: float = 0.003 * DEG  # What the bias has more when warming than when cooling [rad/s]
    lag: float = 15.0  # By which the bias is behind the thermometer [s]
    start_up: float = 0.02 * DEG  # What the bias has more at power-up [rad/s]
    start_up_time: float = 120.0  # Time constant of that [s]
    temperature_noise: float = 0.02  # Scatter of a sample of the thermometer [degC]
    axes: tuple[str, ...] = ("x",)  # Sensors

    def bias(self, temperature: Array | float) -> Array:
        """Return the true bias at temperatures, shape (..., k) [rad/s]."""
        away = np.asarray(temperature, dtype=float) - self.reference
        return np.asarray(np.moveaxis(polynomial.polyval(away, self.coefficients), 0, -1))


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return the sweeps of one test; the errors of the plan's standards are drawn once for the whole test.

    Parameters
    ----------
    plan : Plan
        Its standards and attitude say how large the errors of thermometer, converter and earth rate are.
    truth : Truth
        Sensor, chamber and scatter.
    rng : numpy.random.Generator
        All draws come from it.
    """
    thermometer = _draw(plan.standards.get("thermometer.temperature"), rng)
    gain = 1.0 + _draw(plan.standards.get("converter.reference"), rng)
    earth, unknown = earth_along(plan)
    for one in unknown.values():
        earth = earth + rng.standard_normal(len(one.patterns)) @ one.patterns
    earth = earth[[AXES.index(axis) for axis in truth.axes]]
    sweeps = []
    for number in range(truth.runs):
        time, T = _chamber(truth, truth.rates[number % len(truth.rates)])
        y = gain * (_run(truth, time, T, rng) + earth)
        seen = T + thermometer + rng.normal(0.0, truth.temperature_noise, len(T))
        name = f"run_{number + 1}"
        sweeps.append(
            Sweep(
                name,
                name,
                f"simulated {name}",
                time,
                dict.fromkeys(truth.axes, seen),
                {axis: y[:, i] for i, axis in enumerate(truth.axes)},
            )
        )
    return Readings(tuple(sweeps))


def _run(truth: Truth, time: Array, T: Array, rng: np.random.Generator) -> Array:
    """Bias of all sensors in one power-up with its noise, shape (n, k)."""
    n, k = len(time), len(truth.axes)
    felt = np.interp(time - truth.lag, time, T)
    way = _side(T)[:, None]
    y = truth.bias(felt) + 0.5 * truth.hysteresis * way + truth.start_up * np.exp(-time / truth.start_up_time)[:, None]
    y = y + rng.normal(0.0, truth.run_std, k)
    y = y + rng.normal(0.0, truth.slope_std, k) * (T - truth.reference)[:, None]
    steps = rng.normal(0.0, truth.walk * np.sqrt(truth.interval), (n, k))
    return np.asarray(y + np.cumsum(steps, axis=0) + rng.normal(0.0, truth.white, (n, k)))


def _chamber(truth: Truth, rate: float) -> tuple[Array, Array]:
    """Time since power-up [s] and temperature [degC] of one run."""
    knots, levels = [0.0, truth.hold], [truth.set_points[0]] * 2
    for before, after in pairwise(truth.set_points):
        knots += [knots[-1] + abs(after - before) / rate, knots[-1] + abs(after - before) / rate + truth.soak]
        levels += [after, after]
    time = np.arange(0.5 * truth.interval, knots[-1], truth.interval)
    return time, np.asarray(np.interp(time, knots, levels))


def _side(T: Array) -> Array:
    """1 where the temperature came by warming, -1 by cooling, 0 before it moved; steady keeps its side."""
    steps = np.sign(np.diff(T, prepend=T[0]))
    last = np.maximum.accumulate(np.where(steps != 0.0, np.arange(len(T)), 0))
    return np.asarray(steps[last])


def _draw(influence: Influence | None, rng: np.random.Generator) -> float:
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))
