"""A gyro at rest in a vacuum chamber whose pressure stands at levels over decades, power-up after power-up.

What is read at a level::

    y = offset of the power-up + effect of the level + slope (T - 20) + drift t + noise

The pump, where it runs, makes the noise ``pump`` times as large. Pressure is read with 2 % of scatter, down to the
floor of its gauge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..case import Array

TORR = 133.322


@dataclass(frozen=True)
class Chamber:
    """Truth, in deg/s, Pa, s."""

    pressures: tuple[float, ...] = (1e-4, 1e-3, 1e-1, 1e3, 1e5)
    effects: tuple[float, ...] = (0.0, 0.0, 0.0, -0.02, -0.05)  # of each level, less the lowest
    order: tuple[int, ...] = (4, 3, 2, 1, 0, 2, 4)  # in which they come
    runs: int = 5
    dwell: float = 600.0
    interval: float = 1.0
    noise: float = 0.004
    pump: float = 1.0  # noise with the pump on, below 1 Pa, as a multiple
    walk: float = 0.0  # deg/s / sqrt(s)
    drift: float = 0.0  # deg/s/s
    turn_on: float = 0.008
    scatter: float = 2e-4  # of the effect of a level, from power-up to power-up
    slope: float = 0.0  # deg/s/degC
    warms: float = 0.0  # degC more at the lowest pressure than at the highest, by the logarithm
    floor: float = 0.0  # end of the gauge's scale [Pa]


def pumped(seed: int, truth: Chamber) -> list[dict[str, Array]]:
    """Return the recordings, a power-up each: time, x, pressure, temperature, pump."""
    rng = np.random.default_rng([seed, 51])
    found = []
    n = round(truth.dwell / truth.interval)
    lowest, highest = np.log10(min(truth.pressures)), np.log10(max(truth.pressures))
    for _ in range(truth.runs):
        effects = np.array(truth.effects) + rng.normal(0.0, truth.scatter, len(truth.effects))
        offset = rng.normal(0.01, truth.turn_on)
        level = np.repeat(truth.order, n)
        t = truth.interval * np.arange(len(level))
        p = np.array(truth.pressures)[level] * np.exp(rng.normal(0.0, 0.02, len(level)))
        pump = (np.array(truth.pressures)[level] < 1.0).astype(float)
        T = 20.0 + truth.warms * (highest - np.log10(np.array(truth.pressures)[level])) / (highest - lowest)
        noise = truth.noise * np.where(pump > 0.0, truth.pump, 1.0)
        y = offset + effects[level] + truth.slope * (T - 20.0) + truth.drift * t + rng.normal(0.0, noise)
        y = y + np.cumsum(rng.normal(0.0, truth.walk * np.sqrt(truth.interval), len(t)))
        read = T + rng.normal(0.0, 0.02, len(t))
        found.append({"time": t, "x": y, "pressure": np.maximum(p, truth.floor), "temperature": read, "pump": pump})
    return found
