"""Sweeps for tests of the thermal procedure: one axis, closed forms, no noise unless asked for."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from inertialcal.core.estimate import Array
from inertialcal.procedures.thermal.reduction import Attitude, Plan, Readings, Sweep

KNOWN = Attitude(0.3, 0.0, 0.5, 0.0)  # an attitude without doubt
LATITUDE = 0.64
RATE = 0.02  # [degC/s]


def plan(**settings: object) -> Plan:
    """Return a plan in which earth rate is known."""
    return Plan(**({"attitude": KNOWN, "latitude": LATITUDE} | settings))  # type: ignore[arg-type]


def path(*points: float, interval: float = 20.0, rate: float = RATE, hold: float = 0.0) -> tuple[Array, Array]:
    """Time [s] and temperature [degC] along straight lines of one rate, after a hold at the first point."""
    knots, levels = [0.0, hold], [points[0], points[0]]
    for before, after in pairwise(points):
        knots.append(knots[-1] + abs(after - before) / rate)
        levels.append(after)
    time = np.arange(0.5 * interval, knots[-1], interval)
    return time, np.asarray(np.interp(time, knots, levels))


def way(temperature: Array) -> Array:
    """1 where it warmed, -1 where it cooled; steady keeps its side."""
    steps = np.sign(np.diff(temperature, prepend=temperature[0]))
    last = np.maximum.accumulate(np.where(steps != 0.0, np.arange(len(temperature)), 0))
    return np.asarray(steps[last])


def sweep(run: str, time: Array, temperature: Array, reading: Array, name: str = "") -> Sweep:
    """Return one recording of the x sensor."""
    return Sweep(name or run, run, f"{name or run}.csv", time, {"x": temperature}, {"x": reading})


def readings(
    law: Callable[[Array], Array],
    runs: int = 5,
    points: tuple[float, ...] = (23.0, -30.0, 67.0, 23.0),
    gap: float = 0.0,
    noise: float = 0.0,
    offset: float = 0.0,
    seed: int = 1,
) -> Readings:
    """Return runs of a law with a gap between the paths, an offset of each run, and white noise."""
    rng = np.random.default_rng(seed)
    sweeps = []
    for number in range(runs):
        t, T = path(*points)
        y = law(T) + 0.5 * gap * way(T) + rng.normal(0.0, offset) + rng.normal(0.0, noise, T.size)
        sweeps.append(sweep(f"run{number + 1}", t, T, y))
    return Readings(tuple(sweeps))
