"""A mass that turns around an accelerometer in orbit, told in an inertial frame: no equations of a turning one.

The common centre of mass of satellite and mass falls around the earth on a circle. The satellite is on the other side:
what its accelerometers feel is its acceleration less the gravity of the earth where it is, both exact, turned into the
frame of the local vertical. Plane figures are complex numbers: real is up, imaginary ahead. What is counted::

    pulses = whole pulses of a gate of  S (bias + what the orbit does + attraction - felt) + drift + noise
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BIG_G, EARTH = 6.67430e-11, 3.986004418e14
GATE, FINE = 100.0, 12  # [s], steps of a gate


@dataclass(frozen=True)
class Bench:
    """Truth of the instrument and its test, SI; ``stated`` figures are what the laboratory says."""

    scale_factor: float = 1.04e6
    mass: float = 4.0
    radius: float = 0.2
    satellite: float = 1000.0
    distance: float = 6_931_008.8  # from the middle of the earth
    offset: complex = 0.0  # of the proof mass from the axis
    height: float = 0.0  # of it over the plane
    zero: float = 0.0  # of the angle
    direction: float = 0.0  # of the input axis
    noise: float = 3e-3  # white, of a gate [pulses/s]
    walk: float = 0.0  # step of a random walk
    lines: float = 0.0  # of the orbit, at its rate; half of it at twice that [m/s^2]
    whole: bool = True  # whether pulses are whole ones
    drift: float = 0.0  # range of a smooth drift over a run [pulses/s]

    @property
    def orbit(self) -> float:
        """Rate of the orbit: that of a circle about a point."""
        return math.sqrt(EARTH / self.distance**3)

    @property
    def arm(self) -> float:
        """Recoil arm."""
        return self.mass * self.radius / (self.mass + self.satellite)


@dataclass(frozen=True)
class Turned:
    """One run as it was recorded."""

    period: float  # signed [s]
    length: float  # [s]
    angle: float  # at the start, as the programme says
    times: Array  # middles of the gates [s]
    reading: Array  # [pulses/s]


def felt(bench: Bench, period: float, phi: Any) -> Array:
    """Return what the accelerometer reads of attraction and recoil at true angles of the mass, along its input axis."""
    w, n = 2.0 * math.pi / period, bench.orbit
    place = bench.radius * np.exp(1j * phi) - bench.offset
    pull = BIG_G * bench.mass * place / (np.abs(place) ** 2 + bench.height**2) ** 1.5
    behind = -bench.arm * np.exp(1j * phi)  # of the satellite from the common centre of mass
    moved = -((w + n) ** 2) * behind  # its inertial acceleration, seen along the local vertical
    # gravity at R + d less that at R: -(R + d) / |R + d|^3 + 1 / R^2, without the loss of digits of the difference
    d = behind / bench.distance
    size = np.expm1(-1.5 * np.log1p(2.0 * d.real + np.abs(d) ** 2))
    gravity = -(EARTH / bench.distance**2) * (size + d * (1.0 + size))
    own = moved - gravity
    axis = np.exp(-1j * bench.direction)
    return np.asarray(((pull - own) * axis).real)


def run(bench: Bench, period: float, length: float, angle: float, rng: np.random.Generator) -> Turned:
    """Return one run."""
    n = int(length / GATE)
    fine = (np.arange(n * FINE) + 0.5) * GATE / FINE
    phi = angle + bench.zero + 2.0 * math.pi / period * fine
    ambient: Array = np.full(n * FINE, 17e-6 * 9.80665 + 3.6e-6)
    for k in (1, 2):
        ambient = ambient + bench.lines / k * np.cos(k * bench.orbit * fine + rng.uniform(0.0, 2.0 * math.pi))
    rate = bench.scale_factor * (ambient + felt(bench, period, phi)).reshape(n, FINE).mean(axis=1)
    x = np.linspace(0.0, 1.0, n)
    if bench.drift:
        rate = rate + bench.drift * (rng.uniform(-1, 1) * np.exp(-4.0 * x) + rng.uniform(-1, 1) * (x - 0.4) ** 3)
    rate = rate + np.cumsum(bench.walk * rng.standard_normal(n)) + bench.noise * rng.standard_normal(n)
    phase = np.cumsum(np.concatenate([[rng.random()], rate * GATE]))
    phase = np.floor(phase) if bench.whole else phase
    return Turned(period, length, angle, (np.arange(n, dtype=np.float64) + 0.5) * GATE, np.diff(phase) / GATE)


def whole_test(bench: Bench, periods: tuple[float, ...], length: float, rng: np.random.Generator) -> list[Turned]:
    """Return all runs of a test, which start at angles of their own."""
    return [run(bench, period, length, 0.9 * k, rng) for k, period in enumerate(periods)]


def drawn(bench: Bench, rng: np.random.Generator) -> Bench:
    """Return a bench whose errors of standards and mounting are drawn: 1 g, 0.1 mm, 1 mm, 1 deg, 0.1 % of the rate."""
    offset = complex(*rng.normal(0.0, 3e-3, 2))
    return replace(
        bench, mass=bench.mass + rng.normal(0.0, 1e-3), radius=bench.radius + rng.normal(0.0, 1e-4), offset=offset,
        height=rng.normal(0.0, 1e-3), zero=rng.normal(0.0, 0.02), direction=rng.normal(0.0, math.radians(1.0)),
        distance=bench.distance * (1.0 + rng.normal(0.0, 1e-3) * 2.0 / 3.0),
    )  # fmt: skip
