"""Acceleration in a station: noise with a spectrum in closed form, lines, a slow part that follows the orbit.

Imports nothing of the package. Noise is that of an autoregression of first order, whose spectrum is known, so that the
power in any band is an integral; axes share a part of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.signal import lfilter

Array = NDArray[np.float64]
UG = 9.80665e-6  # [m/s^2]


@dataclass(frozen=True)
class Station:
    """What is in a record."""

    rate: float = 20.0  # [Hz]
    seconds: float = 2000.0
    sizes: tuple[float, float, float] = (20.0, 30.0, 12.0)  # standard deviation of the noise of each axis [ug]
    colour: float = 0.6  # of the autoregression
    shared: float = 0.5  # part of the power of each axis that is common
    tones: tuple[tuple[int, float, float], ...] = (
        (0, 2.5, 15.0),
        (2, 5.03, 40.0),
    )  # axis, frequency [Hz], amplitude [ug]
    slow: tuple[float, float, float] = (0.4, -0.3, 0.8)  # [ug]
    orbital: float = 0.3  # amplitude on each axis [ug]
    period: float = 5556.0  # [s]
    bias: tuple[float, float, float] = (20.0, -35.0, 8.0)  # as the flip found it [ug]
    bias_u: float = 0.2  # [ug]


@dataclass(frozen=True, eq=False)
class Recorded:
    """A record, and what is true."""

    station: Station
    time: Array  # shape (n,) [s]
    values: Array  # shape (n, 3) [m/s^2]
    slow: Array  # shape (3,): mean of the slow part over the record [m/s^2]
    slow_part: Array = field(default_factory=lambda: np.empty((0, 3)))  # shape (n, 3) [m/s^2]

    def power(self, axis: int, low: float, high: float) -> float:
        """Return the power of an axis between two frequencies [(m/s^2)^2]."""
        s = self.station
        drive = s.sizes[axis] ** 2 * (1.0 - s.colour**2)

        def density(f: float) -> float:
            turn = 2.0 * math.pi * f / s.rate
            return 2.0 * drive / s.rate / (1.0 - 2.0 * s.colour * math.cos(turn) + s.colour**2)

        found = quad(density, low, high, epsabs=0.0, epsrel=1e-10)[0]
        found += sum(0.5 * size**2 for on, f, size in s.tones if on == axis and low <= f < high)
        return float(found) * UG**2

    def write(self, path: Path, unit: str = "ug", scale: float = 1.0 / UG) -> Path:
        """Write the record as CSV."""
        rows = np.column_stack([self.time, self.values * scale])
        head = ",".join(["t [s]", *(f"acc_{axis} [{unit}]" for axis in "xyz")])
        np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.9g")
        return path


def recorded(rng: np.random.Generator, station: Station | None = None) -> Recorded:
    """Return a record: phases of lines and of the orbit are drawn, and the error of the bias."""
    s = station or Station()
    n = round(s.rate * s.seconds)
    time = np.arange(n) / s.rate
    warm = 200
    drive = rng.normal(size=(n + warm, 3)) * math.sqrt(1.0 - s.shared)
    drive += rng.normal(size=(n + warm, 1)) * math.sqrt(s.shared)
    noise = lfilter([math.sqrt(1.0 - s.colour**2)], [1.0, -s.colour], drive, axis=0)[warm:]
    values = noise * np.array(s.sizes)
    for axis, frequency, size in s.tones:
        values[:, axis] += size * np.sin(2.0 * math.pi * frequency * time + rng.uniform(0.0, 2.0 * math.pi))
    phases = rng.uniform(0.0, 2.0 * math.pi, 3)
    slow = np.array(s.slow) + s.orbital * np.sin(2.0 * math.pi * time[:, None] / s.period + phases)
    values = values + slow + np.array(s.bias) + rng.normal(0.0, s.bias_u, 3)
    return Recorded(s, time, values * UG, slow.mean(axis=0) * UG, slow * UG)
