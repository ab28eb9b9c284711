"""Pulses that the accelerometer of the turned-mass rig counts in a run.

Readings are whole pulses of a gate. The field is that of the mass where it is, on the proof mass where that is, in
steps of a twentieth of a gate; the satellite's acceleration follows from where the centre of mass lies, by the
equations of Hill for a radial input axis::

    pulses/s = S (bias + gradient + lines of the orbit + attraction - recoil) + drift + noise
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.estimate import Array
from ..twin import DrawnError
from .setup import HOUR, UG, Bench

STEPS = 20  # of a gate
GLITCH = 60.0  # of a false reading [standard deviations]


@dataclass(frozen=True)
class Drawn:
    """True values, unknown to the reduction."""

    scale_factor: float  # [pulses/s/(m/s^2)]
    mass: float  # [kg]
    radius: float  # [m]
    satellite: float  # [kg]
    orbit: float  # rate [rad/s]
    offset: tuple[float, float, float]  # of the proof mass: along the input axis, across it, out of the plane [m]
    zero: float  # of the angle [rad]
    direction: float  # of the input axis [rad]
    errors: tuple[DrawnError, ...] = ()  # of the standards

    @property
    def recoil_arm(self) -> float:
        """Distance of the satellite from the common centre of mass [m]."""
        return self.mass * self.radius / (self.satellite + self.mass)


def turn_rate(bench: Bench, number: int) -> float:
    """Return the rate of turn of a run, counted from 0 [rad/s]."""
    return 2.0 * math.pi / (bench.periods[number] * HOUR)


def start_angle(number: int) -> float:
    """Return the angle of the mass when a run starts [rad]: runs do not start alike."""
    return math.radians(40.0 * number)


def begin_of(bench: Bench, number: int) -> float:
    """Return when a run starts on the clock of the programme [s]."""
    return number * (bench.length + bench.pause)


def felt(bench: Bench, drawn: Drawn, number: int, seconds: Array) -> Array:
    """Return what the turned mass makes the accelerometer read, attraction positive [m/s^2]."""
    w = 0.0 if bench.stalled == number else turn_rate(bench, number)
    phi = start_angle(number) + drawn.zero + w * seconds
    arm, speed, n = drawn.recoil_arm, drawn.recoil_arm * w, drawn.orbit
    apart = np.stack([drawn.radius * np.cos(phi), drawn.radius * np.sin(phi), np.zeros(len(phi))])
    apart -= np.array(drawn.offset)[:, np.newaxis]
    pull = GRAVITATIONAL_CONSTANT.value * drawn.mass * apart / np.sum(apart**2, axis=0) ** 1.5
    # the satellite goes round on the other side: up, ahead
    up, ahead = -arm * np.cos(phi), -arm * np.sin(phi)
    going_up, going_ahead = speed * np.sin(phi), -speed * np.cos(phi)
    force_up = -w * w * up - 2.0 * n * going_ahead - 3.0 * n * n * up
    force_ahead = -w * w * ahead + 2.0 * n * going_up
    towards = np.array([math.cos(drawn.direction), math.sin(drawn.direction)])
    return np.asarray(towards @ np.stack([pull[0] - force_up, pull[1] - force_ahead]))


def record(
    bench: Bench, drawn: Drawn, number: int, rng: np.random.Generator
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the gates of a run that were saved, and their pulses."""
    n = int(bench.length / bench.gate)
    fine = (np.arange(n * STEPS) + 0.5) * bench.gate / STEPS
    whole = begin_of(bench, number) + fine
    ambient: Array = np.full(len(fine), bench.bias_ug * UG + 3.0 * drawn.orbit**2 * bench.head)
    for k, size in enumerate(bench.lines, 1):
        ambient = ambient + size * np.cos(k * drawn.orbit * whole + rng.uniform(0.0, 2.0 * math.pi))
    mass = felt(bench, drawn, number, fine)
    rate = drawn.scale_factor * (ambient + mass).reshape(n, STEPS).mean(axis=1)
    t = np.linspace(-1.0, 1.0, n)
    rate += bench.cubic * np.polynomial.legendre.legval(t, [0.0, *rng.normal(0.0, 0.5, 3)])
    rate += np.cumsum(rng.normal(0.0, bench.walk, n)) + rng.normal(0.0, bench.white, n)
    if bench.disturbed is not None and bench.disturbed[0] == number:
        size = bench.disturbed[1] * GRAVITATIONAL_CONSTANT.value * drawn.mass / drawn.radius**2
        middle = (np.arange(n) + 0.5) * bench.gate
        rate += drawn.scale_factor * size * np.cos(turn_rate(bench, number) * middle + 1.0)
    if bench.jumped is not None and bench.jumped[0] == number:
        rate[3 * n // 5 :] += bench.jumped[1]
    if bench.glitches is not None and bench.glitches[0] == number:
        rate[rng.choice(np.arange(5, n - 5), bench.glitches[1], replace=False)] += GLITCH * bench.white
    pulses = np.diff(np.floor(np.concatenate([[rng.random()], rate * bench.gate]).cumsum())).astype(np.int64)
    saved = rng.random(n) >= bench.lost
    saved[[0, -1]] = True
    kept = np.flatnonzero(saved)
    return kept, pulses[kept]
