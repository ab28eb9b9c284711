"""Power-ups of a gyro in a chamber that stands at one temperature, each from a starting temperature of its own.

What is read, with ``t`` since power-up and T the thermometer::

    y = settled bias of the power-up + slope (T - start) + bend (T - 20)^2
        + sum_j (a_j (1 + scatter) + b_j (start - 20)) exp(-t / tau_j)
        + walk + noise

Self-heating moves T by ``heating (1 - exp(-t / heating_time))``. Samples are written out one by one; nothing is shared
with the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..case import Array


@dataclass(frozen=True)
class Chamber:
    """Truth, in deg/s, degC, s; the axes have the amplitudes of their row."""

    amplitudes: tuple[tuple[float, ...], ...] = ((0.024,), (0.017,), (0.019,))  # of each axis, one a time
    times: tuple[float, ...] = (150.0,)
    by_start: float = 0.0  # of the first amplitude of each axis [deg/s/degC]
    starts: tuple[float, ...] = (20.0, 20.0, 20.0, 20.0, 20.0)  # degC, one a power-up
    length: float = 1800.0
    interval: float = 2.0
    noise: float = 0.004
    walk: float = 0.0  # deg/s / sqrt(s)
    turn_on: float = 0.005
    scatter: float = 0.0  # of the amplitude from power-up to power-up, relative
    slope: float = 0.0  # bias over temperature [deg/s/degC]
    bend: float = 0.0  # the same, of its square [deg/s/degC^2]
    heating: float = 0.0  # degC
    heating_time: float = 600.0
    thermometer: float = 0.02  # noise of a sample [degC]
    warm_restarts: tuple[int, ...] = ()  # power-ups whose unit was still warm: a tenth of the amplitude
    own_times: tuple[float, ...] = ()  # of each axis, in place of the first time
    late: float = 0.0  # power-up before the first sample [s]


def power_ups(seed: int, truth: Chamber) -> tuple[Array, Array, Array, Array]:
    """Return time since power-up, readings (n, k) [deg/s], number of the power-up, temperature (n, k) [degC]."""
    rng = np.random.default_rng([seed, 77])
    times: list[Array] = []
    readings: list[Array] = []
    numbers: list[Array] = []
    warmth: list[Array] = []
    for r, start in enumerate(truth.starts):
        t = truth.late + truth.interval * np.arange(round(truth.length / truth.interval))
        T = start + truth.heating * (1.0 - np.exp(-t / truth.heating_time))
        factor = (0.1 if r in truth.warm_restarts else 1.0) * (1.0 + truth.scatter * rng.standard_normal())
        columns = []
        for axis, amplitudes in enumerate(truth.amplitudes):
            y = rng.normal(0.0, truth.turn_on) + truth.slope * (T - start) + truth.bend * (T - 20.0) ** 2
            for j, (a, tau) in enumerate(zip(amplitudes, truth.times, strict=True)):
                size = a * factor + (truth.by_start * (start - 20.0) if j == 0 else 0.0)
                own = truth.own_times[axis] if truth.own_times and j == 0 else tau
                y = y + size * np.exp(-t / own)
            y = y + np.cumsum(rng.normal(0.0, truth.walk * np.sqrt(truth.interval), len(t)))
            columns.append(y + rng.normal(0.0, truth.noise, len(t)))
        times.append(np.asarray(t, dtype=np.float64))
        readings.append(np.column_stack(columns))
        numbers.append(np.full(len(t), r))
        read = T[:, None] + rng.normal(0.0, truth.thermometer, (len(t), len(truth.amplitudes)))
        warmth.append(read)
    return np.concatenate(times), np.concatenate(readings), np.concatenate(numbers), np.concatenate(warmth)


def starts(lowest: float, highest: float, count: int) -> tuple[float, ...]:
    """Return starting temperatures, evenly spread."""
    return tuple(np.linspace(lowest, highest, count).tolist())
