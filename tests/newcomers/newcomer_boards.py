"""An inertial board as people carry it about: at rest, and laid on its faces, with truths of its own equations.

``reading = (1 + error) f + bias`` for the accelerometer; a gyro at rest is white noise beside its
bias. Both sensors are in every recording, for that is what loggers write.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G = 9.80665  # m/s^2
ACC_ERRORS = np.array([0.011, -0.007, 0.004])
ACC_BIASES = np.array([0.12, -0.08, 0.15])  # m/s^2
GYRO_BIASES = np.radians([0.35, -0.21, 0.12])  # rad/s
GYRO_NOISE = np.radians(0.05)  # rad/s
ACC_NOISE = 0.02  # m/s^2
FACES = np.array([
    [0, 0, 1], [0, 0, -1], [0, 1, 0], [0, -1, 0], [1, 0, 0], [-1, 0, 0],
    [0, 1, 1], [0, -1, 1], [1, 0, 1], [-1, 0, -1], [1, -1, 0], [1, 1, 0],
], dtype=np.float64)  # fmt: skip
FACES /= np.linalg.norm(FACES, axis=1, keepdims=True)  # six faces, and six edges so that nothing rests on one reading


@dataclass(frozen=True)
class Board:
    """What a board recorded: seconds, rad/s and m/s^2, shape (n, 3), degC."""

    time: Array
    gyro: Array
    acc: Array
    temperature: Array
    sample_rate: float


def board_at_rest(seed: int = 5, sample_rate: float = 100.0, seconds: float = 60.0) -> Board:
    """Return a recording of a board on a bench, z up."""
    n = round(seconds * sample_rate)
    return board_of(np.tile(FACES[0], (n, 1)), np.zeros((n, 3)), sample_rate, seed)


def six_faces(seed: int = 6, sample_rate: float = 50.0, dwell: float = 4.0, turn: float = 1.6) -> Board:
    """Return a recording of a board that is laid on its faces and edges, turned by hand in between."""
    up, rates = [], []
    still, moving = round(dwell * sample_rate), round(turn * sample_rate)
    for face, after in zip(FACES, [*FACES[1:], None], strict=True):
        up.append(np.tile(face, (still, 1)))
        rates.append(np.zeros((still, 3)))
        if after is None:
            break
        angle = np.arccos(np.clip(face @ after, -1.0, 1.0))
        axis = np.cross(face, after) if np.pi - angle > 1e-6 else np.cross(face, np.roll(face, 1))
        axis /= np.linalg.norm(axis)
        at = np.pi * (np.arange(moving) + 0.5) / moving
        phase, rate = angle * (0.5 - 0.5 * np.cos(at)), angle * np.pi / (2.0 * turn) * np.sin(at)
        up.append(np.outer(np.cos(phase), face) + np.outer(np.sin(phase), np.cross(axis, face)))
        rates.append(-np.outer(rate, axis))
    return board_of(np.concatenate(up), np.concatenate(rates), sample_rate, seed)


def board_of(up: Array, rates: Array, sample_rate: float, seed: int) -> Board:
    """Return what a board reads whose up direction and rates are given, shapes (n, 3)."""
    rng = np.random.default_rng(seed)
    n = len(up)
    acc = (1.0 + ACC_ERRORS) * G * up + ACC_BIASES + ACC_NOISE * rng.standard_normal((n, 3))
    gyro = rates + GYRO_BIASES + GYRO_NOISE * rng.standard_normal((n, 3))
    temperature = np.full(n, 24.0) + 0.01 * rng.standard_normal(n)
    return Board(np.arange(n) / sample_rate, gyro, acc, temperature, sample_rate)
