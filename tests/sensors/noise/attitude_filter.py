"""A textbook attitude filter and twins of a gyro in use; nothing here is of the package.

The filter is a multiplicative extended Kalman filter: attitude and gyro bias, the error in the frame of the reference,
two known directions (star tracker, or gravity and magnetic field) as updates [1]_. Twins are gyros with their own
errors; rate and temperature are Ornstein-Uhlenbeck processes. All arrays have the twins first.

References
----------
.. [1] F. L. Markley and J. L. Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 2014, 6.2.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
DIRECTIONS = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
GRAVITY = 9.80665


@dataclass(frozen=True)
class Gyros:
    """Errors of gyros, n of them: what calibration left, an array an error."""

    matrix: Array  # (n, 3, 3): error of scale factors and misalignments
    force: Array  # (n, 3, 3): [(rad/s)/(m/s2)]
    powers: Array  # (n, q, 3): of the error of the bias in T - reference [rad/s/degC^j]
    turn_on: Array  # (n, 3) [rad/s]
    white: float  # N [rad/sqrt(s)]
    walk: float  # K [rad/s/sqrt(s)]


@dataclass(frozen=True)
class Flight:
    """How they are used."""

    duration: float  # [s]
    step: float  # [s]
    rate: float  # rms along each axis [rad/s]
    rate_time: float  # [s]
    middle: float  # of the temperature, from the reference [degC]
    spread: float  # standard deviation of the temperature [degC]
    temperature_time: float  # [s]
    update: float  # time from one update to the next [s]
    direction: float  # standard deviation of a measured direction [rad]


def rotations(vectors: Array) -> Array:
    """Rotation matrices of rotation vectors, (n, 3) -> (n, 3, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)
    x = cross(vectors)
    small = np.where(angle > 1e-12, angle, 1.0)
    a, b = (
        np.where(angle > 1e-12, np.sin(angle) / small, 1.0),
        np.where(angle > 1e-12, (1 - np.cos(angle)) / small**2, 0.5),
    )
    return np.asarray(np.eye(3) + a[:, None, None] * x + b[:, None, None] * (x @ x))


def cross(v: Array) -> Array:
    """Matrices of the vector product, (n, 3) -> (n, 3, 3)."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = v[:, 2], -v[:, 1], v[:, 0]
    return out


def updated(
    true: Array, estimated: Array, bias: Array, P: Array, noise: float, rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Return attitude, bias and covariance after both directions are seen with this standard deviation [rad]."""
    n = len(true)
    H, left = np.zeros((n, 6, 6)), np.empty((n, 6))
    for i, direction in enumerate(DIRECTIONS):
        rows = slice(3 * i, 3 * i + 3)
        seen = np.einsum("nji,j->ni", true, direction) + rng.normal(0.0, noise, (n, 3))
        left[:, rows] = seen - np.einsum("nji,j->ni", estimated, direction)
        H[:, rows, :3] = estimated.transpose(0, 2, 1) @ cross(np.tile(direction, (n, 1)))
    S = H @ P @ H.transpose(0, 2, 1) + np.eye(6) * noise**2
    K = np.linalg.solve(S, H @ P).transpose(0, 2, 1)
    change = np.einsum("nij,nj->ni", K, left)
    P = P - K @ S @ K.transpose(0, 2, 1)
    return rotations(change[:, :3]) @ estimated, bias + change[:, 3:], 0.5 * (P + P.transpose(0, 2, 1))


def nees(gyros: Gyros, flight: Flight, white: Array, drive: Array, start: Array, rng: np.random.Generator) -> Array:
    """Return the normalised squared errors of a filter with these settings before each update, (updates, twins).

    ``white`` (3,) N, ``drive`` (3,) of the walk of the bias and ``start`` (3,) sd of the bias, of the filter.
    """
    n, dt = len(gyros.matrix), flight.step
    true = estimated = np.tile(np.eye(3), (n, 1, 1))
    bias = np.zeros((n, 3))
    P = np.zeros((n, 6, 6))
    P[:, :3, :3] = np.eye(3) * 1e-3**2
    P[:, range(3, 6), range(3, 6)] = start**2
    estimated = rotations(rng.normal(0.0, 1e-3, (n, 3))) @ estimated
    rate = rng.normal(0.0, flight.rate, (n, 3))
    warm = rng.normal(0.0, flight.spread, n)
    walked = np.zeros((n, 3))
    keep, keep_warm = np.exp(-dt / flight.rate_time), np.exp(-dt / flight.temperature_time)
    orders = np.arange(gyros.powers.shape[1])
    every, found = round(flight.update / dt), []
    for k in range(round(flight.duration / dt)):
        rate = keep * rate + rng.normal(0.0, flight.rate * np.sqrt(1.0 - keep**2), (n, 3))
        warm = keep_warm * warm + rng.normal(0.0, flight.spread * np.sqrt(1.0 - keep_warm**2), n)
        walked = walked + rng.normal(0.0, gyros.walk * np.sqrt(dt), (n, 3))
        down = true.transpose(0, 2, 1)[:, :, 2] * GRAVITY  # what accelerometers at rest would read, in the body
        slow = gyros.turn_on + walked
        slow = slow + np.einsum("nq,nqi->ni", (flight.middle + warm)[:, None] ** orders, gyros.powers)
        error = slow + np.einsum("nij,nj->ni", gyros.matrix, rate) + np.einsum("nij,nj->ni", gyros.force, down)
        reading = rate + error + rng.normal(0.0, gyros.white / np.sqrt(dt), (n, 3))
        A = estimated * dt  # a bias error e turns the attitude, in the reference, by -A e
        cov_ab, cov_b = P[:, :3, 3:], P[:, 3:, 3:]
        moved = A @ cov_ab.transpose(0, 2, 1)
        new_aa = P[:, :3, :3] - moved - moved.transpose(0, 2, 1) + A @ cov_b @ A.transpose(0, 2, 1)
        new_aa += (estimated * (white**2 * dt + drive**2 * dt**3 / 3.0)) @ estimated.transpose(0, 2, 1)
        new_ab = cov_ab - A @ cov_b - 0.5 * A * (drive**2 * dt)
        P[:, :3, :3], P[:, :3, 3:], P[:, 3:, :3] = new_aa, new_ab, new_ab.transpose(0, 2, 1)
        P[:, range(3, 6), range(3, 6)] += drive**2 * dt
        true = true @ rotations(rate * dt)
        estimated = estimated @ rotations((reading - bias) * dt)
        if (k + 1) % every:
            continue
        apart = true @ estimated.transpose(0, 2, 1)  # true = rotation(error) estimated
        small = 0.5 * np.stack([apart[:, 2, 1] - apart[:, 1, 2], apart[:, 0, 2] - apart[:, 2, 0],
                                apart[:, 1, 0] - apart[:, 0, 1]], axis=1)  # fmt: skip
        whole = np.concatenate([small, slow - bias], axis=1)
        found.append(np.einsum("ni,ni->n", whole, np.linalg.solve(P, whole[:, :, None])[:, :, 0]))
        estimated, bias, P = updated(true, estimated, bias, P, flight.direction, rng)
    return np.array(found)


def band(n: int, states: int = 6, p: float = 0.95) -> tuple[float, float]:
    """Return the ends between which the mean of n normalised squared errors lies with probability p."""
    low, high = stats.chi2.ppf([0.5 - 0.5 * p, 0.5 + 0.5 * p], n * states) / n
    return float(low), float(high)
