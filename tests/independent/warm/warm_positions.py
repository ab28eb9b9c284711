"""Accelerometers laid on six faces at several temperatures: numpy alone, nothing of the package.

The unit reads ``A(T) f + b(T)`` with A and b straight lines in temperature, and ``curve`` bends the bias. Each set is
one temperature, on the way up or down. Faces are off alike whenever they are used, the fixture by one tilt, drawn anew
at each set where it is mounted anew; each laying has its own error. What the thermometer says is off by ``offset``, and
ahead of the sensors by ``lag`` in the direction of the change; the temperature drifts by ``drift`` while a set is laid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G = 9.81
FACES = np.vstack([np.eye(3), -np.eye(3)])
TEMPERATURES = (-20.0, 0.0, 20.0, 40.0, 60.0, 50.0, 30.0, 10.0, -10.0)  # [degC], up and down again
REFERENCE = 20.0


@dataclass(frozen=True)
class Bench:
    """Sizes of what goes wrong, SI."""

    temperatures: tuple[float, ...] = TEMPERATURES
    rounds: int = 2
    u_gravity: float = 3e-4
    u_mounting: float = 1e-3  # [rad]
    u_face: float = 1e-3  # [rad]
    u_laying: float = 2e-4  # [rad]
    between: float = 1e-3
    noise: float = 2e-4  # of a mean
    remounted: bool = False
    u_offset: float = 0.0  # [degC]
    lag: float = 0.0  # [degC]
    drift: float = 0.0  # [degC]
    curve: float = 0.0  # of the bias [m/s^2/degC^2]


@dataclass(frozen=True)
class Laid:
    """Mean readings, a row a position."""

    mean: Array  # (m, 3)
    direction: Array  # (m, 3): as meant
    temperature: Array  # (m,): as the thermometer says
    recording: tuple[int, ...]
    truth: dict[str, float]  # by name, at the reference temperature


def laid(bench: Bench, seed: int) -> Laid:
    """Return the readings of all sets."""
    rng = np.random.default_rng(seed)
    A0 = np.eye(3) + 0.01 * rng.normal(size=(3, 3))
    A1 = 2e-5 * rng.normal(size=(3, 3))
    b0, b1 = 0.2 * rng.normal(size=3), 1e-3 * rng.normal(size=3)
    gravity = G + bench.u_gravity * rng.normal()
    offset = bench.u_offset * rng.normal()
    faces = bench.u_face * rng.normal(size=(6, 3))
    mounting = bench.u_mounting * rng.normal(size=3)
    rows, said, meant, number = [], [], [], []
    before = bench.temperatures[0] - 1.0
    for k, T in enumerate(bench.temperatures):
        if bench.remounted:
            mounting = bench.u_mounting * rng.normal(size=3)
        sense, before = np.sign(T - before), T
        order = np.tile(np.arange(6), bench.rounds)
        for i, face in enumerate(order):
            off = mounting + faces[face] + bench.u_laying * rng.normal(size=3)
            up = turned(off) @ FACES[face]
            now = T + bench.drift * (i / (len(order) - 1) - 0.5)
            felt = now - REFERENCE
            bias = b0 + b1 * felt + bench.curve * felt**2 + bench.between * rng.normal(size=3)
            rows.append((A0 + A1 * felt) @ (gravity * up) + bias + bench.noise * rng.normal(size=3))
            said.append(now + offset + bench.lag * sense)
            meant.append(FACES[face])
            number.append(k)
    truth: dict[str, float] = {}
    for i, a in enumerate("xyz"):
        truth[f"bias_{a}"], truth[f"bias_temperature_1_{a}"] = float(b0[i]), float(b1[i])
        for j, other in enumerate("xyz"):
            if i == j:
                truth[f"scale_factor_error_{a}"] = float(A0[i, i] - 1.0)
                truth[f"scale_factor_error_temperature_1_{a}"] = float(A1[i, i])
            else:
                truth[f"misalignment_{a}{other}"] = float(A0[i, j] / A0[i, i])
                truth[f"cross_axis_sensitivity_temperature_1_{a}{other}"] = float(A1[i, j])
    return Laid(np.array(rows), np.array(meant), np.array(said), tuple(number), truth)


def turned(by: Array) -> Array:
    """Return the rotation by a small vector [rad]."""
    size = float(np.linalg.norm(by))
    if size == 0.0:
        return np.eye(3)
    x, y, z = by / size
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(size) * K + (1.0 - np.cos(size)) * K @ K)
