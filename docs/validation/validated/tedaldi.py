"""The calibration of Tedaldi, Pretto and Menegatti, written from the paper: a peer that shares nothing with ours.

D. Tedaldi, A. Pretto, E. Menegatti, "A robust and easy to implement method for IMU calibration without external
equipments", ICRA 2014. Its model: input = T K (reading - bias), T upper or full with a unit diagonal, K diagonal.
Rests are found by the variance in a window; accelerometers are fitted to the length of gravity, gyros to the directions
of gravity before and after each motion, integrated by Runge and Kutta's fourth order. There is no uncertainty in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]
WINDOW = 101  # samples, of the variance: 1 s
FIRST = 5000  # samples at rest at the beginning: 50 s
SHORTEST = 150  # samples of a rest
FACTOR = 6.0  # of the variance at rest


@dataclass(frozen=True)
class Fitted:
    """Scale factors [readings a unit] of the axes, and biases in readings."""

    acc: Array
    acc_bias: Array
    gyro: Array
    gyro_bias: Array
    rests: int


def rests_of(acc: Array) -> list[tuple[int, int]]:
    """Return the stretches at rest."""
    windows = np.lib.stride_tricks.sliding_window_view(acc, WINDOW, axis=0)
    spread = np.linalg.norm(windows.var(axis=2), axis=1)
    still = np.zeros(len(acc), dtype=bool)
    still[WINDOW // 2 : WINDOW // 2 + len(spread)] = spread < FACTOR * np.linalg.norm(acc[:FIRST].var(axis=0))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= SHORTEST]


def fitted(acc: Array, gyro: Array, interval: float, gravity: float, nominal: tuple[float, float]) -> Fitted:
    """Return the calibration of readings of shape (n, 3) each; ``nominal`` are scale factors to start from."""
    rests = rests_of(acc)
    means = np.array([acc[a:b].mean(axis=0) for a, b in rests])

    def force(p: Array, at: Array) -> Array:
        T = np.array([[1.0, -p[0], p[1]], [0.0, 1.0, -p[2]], [0.0, 0.0, 1.0]])
        return ((at - p[6:9]) / p[3:6]) @ T.T

    middle = 0.5 * (means.max(axis=0) + means.min(axis=0))
    start = np.concatenate([np.zeros(3), np.full(3, nominal[0]), middle])
    found = least_squares(
        lambda p: np.linalg.norm(force(p, means), axis=1) - gravity, start, x_scale=np.abs(start) + 1e-2
    )
    up = force(found.x, means)
    up /= np.linalg.norm(up, axis=1)[:, None]

    zero = gyro[rests[0][0] : rests[0][1]].mean(axis=0)
    moves = [gyro[b - 1 : a + 1] - zero for (_, b), (a, _) in pairwise(rests)]
    longest = max(map(len, moves))
    padded = np.array([np.pad(one, ((0, longest - len(one)), (0, 0))) for one in moves])  # at rest: turns no further

    def turned(p: Array) -> Array:
        T = np.array([[1.0, -p[0], p[1]], [p[2], 1.0, -p[3]], [-p[4], p[5], 1.0]])
        rates = (padded / p[6:9]) @ T.T
        u = up[:-1]
        for k in range(longest - 1):
            w0, w1 = rates[:, k], rates[:, k + 1]
            half = 0.5 * (w0 + w1)
            k1 = np.cross(u, w0)
            k2 = np.cross(u + 0.5 * interval * k1, half)
            k3 = np.cross(u + 0.5 * interval * k2, half)
            k4 = np.cross(u + interval * k3, w1)
            u = u + interval / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return (u - up[1:]).ravel()

    first = np.concatenate([np.zeros(6), np.full(3, nominal[1])])
    rotated = least_squares(turned, first, x_scale=np.abs(first) + 1e-2, diff_step=1e-6)
    return Fitted(found.x[3:6], found.x[6:9], rotated.x[6:9], zero, len(rests))
