"""What is found of a head, and what its figures rest on: weights, the motion of the body, biases of the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES, At, Key
from ...physics.motion.rigid import centripetal, cross, gradient
from .contrasts import Line, Weights, weights_for
from .readings import Readings

if TYPE_CHECKING:
    from .reduction import Result

CLEAR = 100.0  # power of the motion over that of the noise, from which slopes are estimated
RELATIVE, BIAS, SCALE, TURN = "relative_bias", "bias", "scale_factor_error", "misalignment"


@dataclass(frozen=True, eq=False)
class Calibrated:
    """What is found of one head."""

    name: str
    number: int  # among all, from 1
    weights: Weights
    told: bool  # whether its motion is known enough
    carried: Array  # shape (3,): axes along which motion carries slopes
    gap: Array  # shape (n, 3): reading less what the others tell, in its axes [m/s^2]
    told_by_others: Array  # shape (n, 3): what they tell [m/s^2]
    line: Line
    slopes: Array  # shape (3, 3): E, row = axis that reads; zero where not carried
    slopes_noise: Array  # shape (3,): change of E for one standard uncertainty of the others' noise, by column
    slopes_late: Array  # the same of clocks, which make the scale factor too small
    mean: Array  # shape (3,): relative bias [m/s^2]


def known_heads(readings: Readings) -> list[int]:
    """Return the numbers of calibrated heads, from 0."""
    return [i for i, one in enumerate(readings.tracks) if one.mounted.calibrated]


def weights_of(readings: Readings, at: int, known: Sequence[int]) -> Weights:
    """Return the weights of calibrated heads for another one."""
    mounted = [one.mounted for one in readings.tracks]
    u = max(mounted[i].position_u for i in known)
    return weights_for(np.array([mounted[i].position for i in known]), mounted[at].position, u)


def gap_of(readings: Readings, means: Array, gammas: Array | None, at: int, known: Sequence[int]) -> Array:
    """Return reading of a head less what others tell, in the body, shape (n, 3)."""
    weights = weights_of(readings, at, known)
    told = np.tensordot(weights.weights, means[list(known)], 1)
    turning_off = 0.0 if gammas is None else gammas @ weights.off
    return np.asarray(means[at] - told - turning_off)


def motion_size(result: Result) -> tuple[Array, float]:
    """Return the mean of Gamma as far as it is known, (3, 3), and a bound of what is not, of each entry [1/s^2]."""
    motion, readings = result.readings.motion, result.readings
    mean, unknown = np.zeros((3, 3)), 0.0
    if result.gammas is not None:
        mean = mean + result.gammas.mean(axis=0)
        unknown += 2.0 * float(np.sqrt(np.abs(np.trace(mean)))) * readings.gyro_bias_u
        unknown += readings.gyro_bias_u**2
    else:
        rate = np.zeros(3) if motion.rate is None else motion.rate
        speeding = np.zeros(3) if motion.acceleration is None else motion.acceleration
        mean = mean + centripetal(np.outer(rate, rate)) + cross(speeding)
        u = motion.rate_u or 0.0
        unknown += np.hypot(2.0 * float(np.linalg.norm(rate)) * u, 3.0 * u**2) + (motion.acceleration_u or 0.0)
    if motion.orbit is not None:
        if motion.vertical is not None:
            mean = mean - gradient(motion.orbit, motion.vertical)
        else:
            unknown += motion.orbit**2
    return mean, float(unknown)


def off_line_covariance(result: Result, off: Array) -> tuple[Array, Array]:
    """Return the mean of ``Gamma e`` beyond a gyro's, shape (3,), and the covariance of the whole, in the body."""
    motion, gyro = result.readings.motion, result.gammas
    length, along = float(off @ off), np.outer(off, off)
    across = length * np.eye(3) - along
    mean, covariance = np.zeros(3), np.zeros((3, 3))
    if gyro is None:
        rate = np.zeros(3) if motion.rate is None else motion.rate
        speeding = np.zeros(3) if motion.acceleration is None else motion.acceleration
        mean = centripetal(np.outer(rate, rate)) @ off + np.cross(speeding, off)
        w, a = motion.rate_u or 0.0, motion.acceleration_u or 0.0
        slope = np.outer(rate, off) + (rate @ off) * np.eye(3) - 2.0 * np.outer(off, rate)  # d(w x w x e)/dw
        covariance = slope @ slope.T * w**2 + w**4 * (8.0 * along + across) + a**2 * across
    else:
        u = result.readings.gyro_bias_u
        rates = result.readings.gyro.body if result.readings.gyro is not None else np.zeros((1, 3))
        rate = np.nanmean(rates, axis=0)
        slope = np.outer(rate, off) + (rate @ off) * np.eye(3) - 2.0 * np.outer(off, rate)
        covariance = slope @ slope.T * u**2 + u**4 * (8.0 * along + across)
    if motion.orbit is not None:
        n2 = motion.orbit**2
        if motion.vertical is None:
            covariance = covariance + n2**2 * (0.8 * along + 0.6 * across)  # over all directions of the vertical
        else:
            up, u = motion.vertical, motion.vertical_u
            mean = mean - gradient(motion.orbit, up) @ off
            slope = 3.0 * n2 * (np.outer(up, off) + (up @ off) * np.eye(3))
            tilts = np.eye(3) - np.outer(up, up)
            covariance = covariance + slope @ tilts @ slope.T * u**2
    return mean, covariance


def motion_told(result: Result) -> bool:
    """Whether the angular motion is known or bounded."""
    return result.gammas is not None or result.readings.motion.said


def on_line(result: Result, at: int, weights: Weights) -> bool:
    """Whether a head lies where the others tell without the motion, within what is known of the places."""
    mounted = [one.mounted for one in result.readings.tracks]
    known = known_heads(result.readings)
    squares = mounted[at].position_u ** 2 + sum(
        float(w) ** 2 * mounted[i].position_u ** 2 for w, i in zip(weights.weights, known, strict=True)
    )
    return float(np.linalg.norm(weights.off)) <= max(3.0 * float(np.sqrt(squares)), 1e-6)


def keys_of(result: Result, one: Calibrated) -> list[Key]:
    """Return what is estimated of a head."""
    place = At("head", float(one.number), "") if len(result.heads) > 1 else None
    axes = np.flatnonzero(one.carried).tolist()
    found = [Key(RELATIVE, axis, at=place) for axis in AXES]
    found += [Key(BIAS, axis, at=place) for axis in AXES] if result.absolute else []
    found += [Key(SCALE, AXES[m], at=place) for m in axes]
    found += [Key(TURN, f"{AXES[a]}{AXES[m]}", at=place) for m in axes for a in range(3) if a != m]
    return found


def others_bias(result: Result, at: int, weights: Weights) -> Array:
    """Return what the biases of calibrated heads add to what they tell, in the axes of a head, shape (3,) [m/s^2]."""
    tracks, known = result.readings.tracks, known_heads(result.readings)
    total = np.zeros(3)
    for w, i in zip(weights.weights, known, strict=True):
        mounted = tracks[i].mounted
        if result.absolute and mounted.bias is not None:
            total = total + w * mounted.orientation.T @ mounted.bias
    return np.asarray(tracks[at].mounted.orientation @ total)


def mean_acceleration(result: Result) -> tuple[Array, float]:
    """Return the mean acceleration of the body, shape (3,), and a bound of what is not known of it [m/s^2]."""
    tracks, known = result.readings.tracks, known_heads(result.readings)
    reads = [result.means[i].mean(axis=0) for i in known]
    if result.absolute:
        free = [read - tracks[i].mounted.orientation.T @ bias for read, i in zip(reads, known, strict=True)
                if (bias := tracks[i].mounted.bias) is not None]  # fmt: skip
        return np.mean(free, axis=0), 0.0
    bound = result.plan.ambient
    return np.zeros(3), float(max(np.linalg.norm(one) for one in reads)) if bound is None else bound
