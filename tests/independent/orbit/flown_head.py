"""Recordings of a head that is flipped in several flights: readings in ug, one temperature, UTC.

Shares no code with the package. The head reads ``M (a + shift) + K0(T)`` with a bias over temperature that a ground
model knows but for its errors; each flight adds what its launch shifts, and age a drift. The head turns about x by
half a turn and back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
YEAR = 365.25 * 86400.0
BEGIN = 1_550_000_000  # [s]
LENGTH, TURNS, TURN = 5400.0, (1700.0, 3500.0), 8.0  # [s]


@dataclass(frozen=True)
class FlownHead:
    """What is true: y and z of each flight along the axes of the head, ug."""

    matrix: Array  # shape (3, 3)
    bias: Array  # shape (3,): of the sensors, by the ground model, at 20 degC
    slope: Array  # shape (3,): the same [ug/degC]
    shift: Array  # shape (F, 3): along the axes of the head, flight by flight
    years: Array  # shape (F,)
    temperature: Array  # shape (F,)
    drift: Array  # shape (3,) [ug/year]


def head(rng: np.random.Generator, flights: int = 6, launch: float = 3.0) -> FlownHead:
    """Return a head that flies once a year."""
    matrix = np.eye(3) + rng.normal(0.0, 1e-3, (3, 3))
    years = np.arange(flights) + rng.uniform(-0.1, 0.1, flights)
    drift = rng.normal(0.0, 2.0, 3)
    shift = rng.normal(0.0, 20.0, 3) + np.outer(years, drift) + rng.normal(0.0, launch, (flights, 3))
    bias = rng.choice([-1.0, 1.0], 3) * rng.uniform(900.0, 1500.0, 3)
    return FlownHead(matrix, bias, rng.normal(0.0, 4.0, 3), shift, years, 20.0 + rng.normal(0.0, 3.0, flights), drift)


def recording(one: FlownHead, flight: int, rng: np.random.Generator, white: float = 3.0) -> tuple[Array, Array]:
    """Return times since 1970 [s], and x, y, z [ug] with the temperature [degC], shape (n, 4); one sample a second.

    ``white``: standard deviation of a sample.
    """
    t = np.arange(0.0, LENGTH)
    first = np.clip((t - TURNS[0]) / TURN, 0.0, 1.0)
    angle = np.pi * (first - np.clip((t - TURNS[1]) / TURN, 0.0, 1.0))
    ambient = rng.choice([-1.0, 1.0], 3) * rng.uniform(2.0, 5.0, 3)
    turned = np.column_stack([
        np.full(len(t), ambient[0]),
        np.cos(angle) * ambient[1] + np.sin(angle) * ambient[2],
        -np.sin(angle) * ambient[1] + np.cos(angle) * ambient[2],
    ])  # fmt: skip
    moving = ((first > 0.0) & (first < 1.0)) | ((t > TURNS[1]) & (t < TURNS[1] + TURN))
    turned[moving] += 10.0 * np.sin(np.linspace(0.0, 20.0, int(moving.sum())))[:, None]
    T = one.temperature[flight] + 0.05 * np.sin(2.0 * np.pi * t / 5400.0)
    felt = turned + one.shift[flight]
    read = felt @ one.matrix.T + one.bias + np.outer(T - 20.0, one.slope)
    read += rng.normal(0.0, white, read.shape) + 0.1 * np.cumsum(rng.normal(0.0, 0.01, read.shape), axis=0)
    return BEGIN + one.years[flight] * YEAR + t, np.column_stack([read, T + rng.normal(0.0, 0.01, len(t))])


def text(times: Array, values: Array) -> str:
    """Return a recording as a file has it."""
    rows = [f"{at:.3f},{x:.4f},{y:.4f},{z:.4f},{T:.3f}" for at, (x, y, z, T) in zip(times, values, strict=True)]
    return "\n".join(["unix_s,x [ug],y [ug],z [ug],temperature [degC]", *rows, ""])
