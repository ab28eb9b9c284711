"""A temperature channel in a chamber with a reference thermometer: numpy alone, nothing of the package.

The chamber ramps down, up and down again, with stays; the sensor follows with a time constant. The channel reads its
own line, bent by a cubic, with an offset of its own for each power-up; the reference is off by one error for all.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LOW, HIGH, START = -20.0, 60.0, 20.0  # [degC]
STAY, RATE, STEP = 3600.0, 0.01, 20.0  # [s], [degC/s], [s] from sample to sample


@dataclass(frozen=True)
class Bench:
    """Sizes, in degC."""

    runs: int = 5
    slope: float = 1.012  # of the channel over the nominal one
    offset: float = 0.4  # of the channel in the middle of the range
    cubic: float = 0.0  # [degC/degC^3]
    between: float = 0.05  # of the offset, from power-up to power-up
    between_slope: float = 5e-4
    noise: float = 0.02
    u_reference: float = 0.2
    time_constant: float = 120.0  # [s]
    one_rate: bool = False


@dataclass(frozen=True)
class Swept:
    """One power-up: time [s], reference and channel [degC]."""

    time: Array
    reference: Array
    channel: Array


def swept(bench: Bench, seed: int) -> list[Swept]:
    """Return all power-ups."""
    rng = np.random.default_rng(seed)
    off = bench.u_reference * rng.normal()
    corners = [START, START, LOW, LOW, HIGH, HIGH, START, START]
    if bench.one_rate:
        corners = [LOW, HIGH]
    found = []
    for _ in range(bench.runs):
        times = [0.0]
        for before, after in pairwise(corners):
            times.append(times[-1] + (STAY if before == after else abs(after - before) / RATE))
        t = np.arange(0.0, times[-1], STEP)
        chamber = np.interp(t, times, corners)
        sensor = np.empty_like(chamber)
        sensor[0] = chamber[0]
        for i in range(1, len(t)):
            sensor[i] = sensor[i - 1] + (chamber[i] - sensor[i - 1]) * (1.0 - np.exp(-STEP / bench.time_constant))
        middle = 0.5 * (LOW + HIGH)
        away = sensor - middle
        slope = bench.slope + bench.between_slope * rng.normal()
        channel = middle + bench.offset + bench.between * rng.normal() + slope * away + bench.cubic * away**3
        noise = bench.noise * rng.normal(size=(2, len(t)))
        found.append(Swept(t, chamber + off + noise[0], channel + noise[1]))
    return found
