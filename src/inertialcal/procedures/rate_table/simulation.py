"""Readings of a rate-table test whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from .fit.earth_input import with_earth
from .plan import Plan
from .readings import Labels, Readings


@dataclass(frozen=True, eq=False)
class Truth:
    """Sensor, test and errors of the standards."""

    # shape (3, 3): m: row = sensor that reads, column = axis that turns (1)
    matrix: Array = field(default_factory=lambda: np.eye(3))
    bias: Array = field(default_factory=lambda: np.zeros(3))  # shape (3,): k0 [rad/s]
    asymmetry: Array = field(default_factory=lambda: np.zeros(3))  # shape (3,): k1' (1)
    # shape (r,): signed rates of each axis in each run [rad/s]
    rates: Array = field(default_factory=lambda: np.radians([-4.0, -2.0, -0.5, 0.5, 2.0, 4.0]))
    runs: int = 5  # Power-ups; each goes through all axes and rates
    sample_std: float = 7e-5  # Scatter of a sample within a dwell [rad/s]
    dwell_std: float = 2e-5  # Scatter of a dwell within a run [rad/s]
    run_bias_std: float = 3e-5  # Scatter of the bias from run to run [rad/s]
    run_scale_std: float = 1e-4  # Scatter of the scale factor from run to run (1)
    samples: int = 30  # Of a dwell
    axes: tuple[str, ...] = AXES  # Axes that are turned


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return the readings of one test; the errors of the plan's standards are drawn once for the whole test.

    Parameters
    ----------
    plan : Plan
        Its standards say how large the errors of table rate, mounting and converter reference are.
    truth : Truth
        Sensor and scatter.
    rng : numpy.random.Generator
        All draws come from it.
    """
    rate_error = draw(plan, "rate_table.rate", rng)
    gain_error = draw(plan, "converter.reference", rng)
    outputs, applied, axis, run = [], [], [], []
    turned = {name: turned_axis(plan, name, rng) for name in truth.axes}
    for number in range(truth.runs):
        offset = rng.normal(0.0, truth.run_bias_std, 3)
        scale = 1.0 + rng.normal(0.0, truth.run_scale_std, 3)
        for name in truth.axes:
            true_rates = truth.rates[:, None] * (1.0 + rate_error) * turned[name]
            u = scale * (true_rates @ truth.matrix.T)
            y = truth.bias + offset + u + 0.5 * truth.asymmetry * np.abs(u)
            y = y + rng.normal(0.0, truth.dwell_std, y.shape)
            y = y + rng.normal(0.0, truth.sample_std / np.sqrt(truth.samples), y.shape)
            outputs.append(y * (1.0 + gain_error))
            applied.append(truth.rates)
            axis += [name] * len(truth.rates)
            run += [str(number + 1)] * len(truth.rates)
    y = np.concatenate(outputs)
    y = y + _earth(plan, truth, np.concatenate(applied), np.array(axis), rng) * (1.0 + gain_error)
    scatter = truth.sample_std * np.sqrt(rng.chisquare(truth.samples - 1, y.shape) / (truth.samples - 1))
    return Readings(
        applied=np.concatenate(applied),
        axis=np.array(axis),
        outputs={name: y[:, i] for i, name in enumerate(AXES)},
        scatters={name: scatter[:, i] for i, name in enumerate(AXES)},
        samples=np.full(len(y), float(truth.samples)),
        run=np.array(run),
        where=tuple(f"simulated row {i + 1}" for i in range(len(y))),
        sensors=AXES,
    )


def _earth(plan: Plan, truth: Truth, applied: Array, axis: Labels, rng: np.random.Generator) -> Array:
    """Return what the sensors read of the earth's rotation, its unknown parts drawn, shape (n, 3)."""
    blank = with_earth(plan, Readings(applied, axis, {}))
    earth = np.zeros((len(applied), 3)) if blank.earth is None else blank.earth
    for patterns in blank.earth_sources.values():
        earth = earth + np.tensordot(_coefficients(len(patterns), rng), patterns, axes=1)
    return np.asarray(earth @ truth.matrix.T)


def _coefficients(count: int, rng: np.random.Generator) -> Array:
    """Draw how much of each pattern there is, each of variance one: a direction, a phase, or a normal error."""
    if count > 1:
        vector = rng.normal(size=count)
        return np.asarray(np.sqrt(count) * vector / np.linalg.norm(vector))
    return rng.normal(size=1)


def draw(plan: Plan, name: str, rng: np.random.Generator) -> float:
    """Return the error of a standard, drawn; 0 where none is stated."""
    influence = plan.standards.get(name)
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))


def turned_axis(plan: Plan, name: str, rng: np.random.Generator) -> Array:
    """Draw the unit vector really turned about, off the named axis by two small angles, shape (3,)."""
    vector = np.array([draw(plan, "rate_table.mounting", rng) for _ in AXES])
    vector[AXES.index(name)] = 0.0
    vector += np.eye(3)[AXES.index(name)]
    return np.asarray(vector / np.linalg.norm(vector))
