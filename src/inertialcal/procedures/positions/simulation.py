"""Simulated readings of a test of positions: a sensor whose truth is known, laid by hand.

Rotations are smooth turns about a fixed axis, from rest to rest, that take the direction up of one position to that of
the next; the angle of a transition may go on past it about the vertical. Gyros are sampled at points in time, so that
the integration of samples has its own, small, error, as it has with a real sensor. The vertical part of the earth rate
acts always, its horizontal part at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core.constants import EARTH_ROTATION_RATE
from ...core.estimate import Array
from .plan import Plan
from .readings import Readings, Rotation, Triad, local_gravity


@dataclass(frozen=True, eq=False)
class Truth:
    """A unit and how it is handled."""

    # shape (3, 3): row: sensor; column: axis of the body [1]
    acc_matrix: Array = field(default_factory=lambda: np.eye(3))
    # shape (3, 3): row: sensor; column: axis of the body [1]
    gyro_matrix: Array = field(default_factory=lambda: np.eye(3))
    acc_bias: Array = field(default_factory=lambda: np.zeros(3))  # shape (3,): [m/s^2]
    gyro_bias: Array = field(default_factory=lambda: np.zeros(3))  # shape (3,): [rad/s]
    g_sensitivity: Array = field(default_factory=lambda: np.zeros((3, 3)))  # shape (3, 3): [(rad/s)/(m/s^2)]
    # shape (m, 3): specific force over gravity in each position
    directions: Array = field(default_factory=lambda: spread(24))
    acc_noise: float = 0.01  # Of a sample [m/s^2]
    gyro_noise: float = 1e-3  # Of a sample [rad/s]
    acc_between: float = 1e-3  # Scatter between positions [m/s^2]
    gyro_between: float = 5e-5  # Scatter between positions [rad/s]
    angle_between: float = 1e-3  # Scatter between rotations, of where a rotation ends or of a known turn [rad]
    samples: int = 500  # Of a static interval
    sample_interval: float = 0.04  # [s]
    duration: float = 2.0  # Of a rotation [s]
    # shape (t, 3): known turns as angle times axis [rad]; without them the rotations are transitions
    turns: Array | None = None
    known: bool = False  # Whether the readings know the directions
    sine_of_latitude: float | None = None  # Of the place, for the earth rate; anywhere between -1 and 1 by default


def spread(m: int) -> Array:
    """Return m unit vectors spread over the sphere along a spiral, in an order that turns about all axes, (m, 3)."""
    k = np.arange(m)
    z = 1.0 - (2.0 * k + 1.0) / m
    angle = np.pi * (3.0 - np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z**2)
    found = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), z])
    return np.asarray(found[(k * 7) % m] if m % 7 else found[::-1])


FACES = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return the readings of one test; errors of the plan's standards are drawn.

    ``gravity.value``, ``fixture.mounting`` and ``clock.rate`` are drawn once, ``fixture.orientation`` for each face and
    each axis, the same in all its positions or turns, ``fixture.repeatability`` for each position, ``turn.angle`` for
    each turn.
    """
    g = local_gravity(plan) + _draw(plan, "gravity.value", rng)
    mounting = _small(np.array([_draw(plan, "fixture.mounting", rng) for _ in range(3)]))
    clock = 1.0 + _draw(plan, "clock.rate", rng)
    lain = truth.directions
    faces = {tuple(np.round(one, 6)): _three(plan, "fixture.orientation", rng) for one in lain}
    away = [faces[tuple(np.round(one, 6))] + _three(plan, "fixture.repeatability", rng) for one in lain]
    if truth.known:
        tilts = [_small(a - (a @ one) * one) for a, one in zip(away, lain, strict=True)]
        lain = np.array([mounting @ tilt @ one for tilt, one in zip(tilts, lain, strict=True)])
    force = g * lain
    m = len(force)
    acc_mean = force @ truth.acc_matrix.T + truth.acc_bias + rng.normal(0.0, truth.acc_between, (m, 3))
    sine = rng.uniform(-1.0, 1.0) if truth.sine_of_latitude is None else truth.sine_of_latitude
    G_at_rest = truth.g_sensitivity + truth.gyro_matrix * EARTH_ROTATION_RATE.value * sine / g
    gyro_mean = force @ G_at_rest.T + truth.gyro_bias + rng.normal(0.0, truth.gyro_between, (m, 3))
    if truth.turns is None:
        vectors = [_between(lain[k], lain[k + 1]) for k in range(m - 1)]
        starts = lain[:-1]
    else:
        ways = [one / np.linalg.norm(one) for one in truth.turns]
        lines = [tuple(np.round(np.outer(one, one).ravel(), 6)) for one in ways]  # the same there and back
        axes = {line: _three(plan, "fixture.orientation", rng) for line in lines}
        vectors = [_turned(plan, one, axes[line], mounting, rng) for one, line in zip(truth.turns, lines, strict=True)]
        starts = np.array([one / np.linalg.norm(one) for one in truth.turns])
    gyro_mean = gyro_mean + _level_earth_rate(truth, lain, vectors, sine, rng) @ truth.gyro_matrix.T
    acc = _triad(acc_mean, truth.acc_noise, truth.samples, "m/s^2", rng)
    gyro = _triad(gyro_mean, truth.gyro_noise, truth.samples, "rad/s", rng)
    rotations = [
        _rotation(truth, vector, start, g, clock, k, G_at_rest, rng)
        for k, (vector, start) in enumerate(zip(vectors, starts, strict=True))
    ]
    where = tuple(f"simulated position {k + 1}" for k in range(m))
    return Readings(acc, gyro, tuple(rotations), truth.directions if truth.known else None, where=where)


def _level_earth_rate(
    truth: Truth, up: Array, vectors: Sequence[Array], sine: float, rng: np.random.Generator
) -> Array:
    """Return the horizontal part of the earth rate along the body axes, shape (m, 3).

    The first position has any heading, and transitions carry it; where turns are made apart, each has its own.
    """
    heading = np.cross(up, rng.normal(size=up.shape))
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    if truth.turns is None:
        for k, vector in enumerate(vectors):
            angle = float(np.linalg.norm(vector))
            axis = vector / angle if angle > 0.0 else up[k]
            heading[k + 1] = _carried(heading[k], axis, np.array([angle]))[0]
    return np.asarray(EARTH_ROTATION_RATE.value * np.sqrt(1.0 - sine**2) * heading)


def _three(plan: Plan, name: str, rng: np.random.Generator) -> Array:
    return np.array([_draw(plan, name, rng) for _ in range(3)])


def _turned(plan: Plan, vector: Array, away: Array, mounting: Array, rng: np.random.Generator) -> Array:
    angle = float(np.linalg.norm(vector))
    axis = vector / angle
    return np.asarray(
        (angle + _draw(plan, "turn.angle", rng)) * (mounting @ _small(away - (away @ axis) * axis) @ axis)
    )


def _between(start: Array, stop: Array) -> Array:
    """Return the rotation of the body that takes up from start to stop, as seen from the body: about their cross."""
    cross, cosine = np.cross(start, stop), float(start @ stop)
    sine = float(np.linalg.norm(cross))
    if sine < 1e-9:
        cross = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        angle = 0.0 if cosine > 0.0 else np.pi
        return np.asarray(-angle * cross / np.linalg.norm(cross))
    return np.asarray(-np.arctan2(sine, cosine) * cross / sine)


def _rotation(
    truth: Truth,
    vector: Array,
    start: Array,
    g: float,
    clock: float,
    k: int,
    G_at_rest: Array,
    rng: np.random.Generator,
) -> Rotation:
    """Sample a turn by a vector, its rate rising and falling as the square of a sine."""
    count = round(truth.duration / truth.sample_interval) + 1
    seconds = np.arange(count) * truth.sample_interval
    phase = 2.0 * np.pi * seconds / seconds[-1]
    shape = (1.0 - np.cos(phase)) / seconds[-1]
    share = (phase - np.sin(phase)) / (2.0 * np.pi)
    rate = shape[:, None] * vector
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    force = g * _carried(start, axis, angle * share)
    f_read = force @ truth.acc_matrix.T + truth.acc_bias + rng.normal(0.0, truth.acc_noise, force.shape)
    reading = rate @ truth.gyro_matrix.T + truth.gyro_bias + force @ G_at_rest.T
    reading = reading + rng.normal(0.0, truth.gyro_noise, reading.shape)
    reading = reading + shape[:, None] * (truth.gyro_matrix @ rng.normal(0.0, truth.angle_between, 3))
    turns = truth.turns
    known = (
        {} if turns is None else {"axis": turns[k] / np.linalg.norm(turns[k]), "angle": float(np.linalg.norm(turns[k]))}
    )
    ends = {"before": k, "after": k + 1} if turns is None else {}
    return Rotation(seconds * clock, reading, f_read, where=f"simulated rotation {k + 1}", **known, **ends)  # type: ignore[arg-type]


def _carried(up: Array, axis: Array, angles: Array) -> Array:
    """Return a vector fixed in space, seen from a body that turns about an axis by some angles, shape (k, 3)."""
    along = (up @ axis) * axis
    across, third = up - along, np.cross(axis, up)
    return np.asarray(along + np.cos(angles)[:, None] * across - np.sin(angles)[:, None] * third)


def _triad(mean: Array, noise: float, samples: int, unit: str, rng: np.random.Generator) -> Triad:
    drawn = mean + rng.normal(0.0, noise / np.sqrt(samples), mean.shape)
    scatter = noise * np.sqrt(rng.chisquare(samples - 1, mean.shape) / (samples - 1))
    return Triad(drawn, scatter, np.full(mean.shape, float(samples)), unit, np.full(len(mean), float(samples)))


def _draw(plan: Plan, name: str, rng: np.random.Generator) -> float:
    one = plan.standards.get(name)
    if one is None:
        return 0.0
    if one.distribution == "rectangular":
        half = one.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, one.u))


def _small(vector: Array) -> Array:
    """Return the matrix of a small rotation."""
    x, y, z = vector
    return np.asarray(np.eye(3) + np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
