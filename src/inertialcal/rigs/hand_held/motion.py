"""What an IMU feels that is laid by hand: still in one position after another, and turned from each to the next.

The body is still while it lies. In between it turns about an axis fixed in it, by an angle that rises as
``(phase - sin phase) / 2 pi`` from rest to rest, and is lifted and put down. Vectors fixed in space (up, the earth's
rate) are carried along in body axes: a turn by the vector ``v`` of the body takes ``a`` to ``exp(-[v]x) a``. Rates are
means over a sample interval, of an axis that stays in the body: their sum is the angle, exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.constants import EARTH_ROTATION_RATE
from ...core.estimate import Array
from ...core.key import AXES
from ...core.labelled import LabelledPart
from ..parts.campaign import drawn_error
from .setup import Bench

FACES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
NAMES = ("x+", "x-", "y+", "y-", "z+", "z-")


@dataclass(frozen=True)
class Part:
    """Samples [start, stop) of a position or a turn."""

    # samples
    start: int
    stop: int
    direction: tuple[float, float, float] | None = None  # up in a position, in body axes, as intended
    axis: tuple[float, float, float] | None = None  # axis of a turn by a known angle
    angle: float | None = None  # angle of that turn [rad]


@dataclass(frozen=True, eq=False)
class Motion:
    """True inputs, a row a sample."""

    rate: Array  # against inertial space, along the body axes, (n, 3) [rad/s]
    force: Array  # specific force along the body axes, (n, 3) [m/s2]
    parts: tuple[Part, ...]  # positions, and turns by known angles
    place: Array  # position of each sample, or the nearest one, (n,)


@dataclass(frozen=True, eq=False)
class Leg:
    """A dwell and the turn after it."""

    # [samples]; no turn after the last dwell
    dwell: int
    turn: int
    vector: Array  # rotation vector in the body, (3,) [rad]
    direction: tuple[float, float, float] | None = None  # up, as intended
    # axis and angle [rad] of the turn, as written in the protocol
    known: tuple[tuple[float, float, float], float] | None = None


def moved(legs: tuple[Leg, ...], up: Array, interval: float, gravity: float, latitude: float, lifts: Array) -> Motion:
    """Return what the body feels from the first position on.

    Parameters
    ----------
    legs : tuple of Leg
        In order of time.
    up : ndarray, shape (3,)
        Up in the first position, in body axes.
    interval : float
        From sample to sample [s].
    gravity : float
        [m/s2]
    latitude : float
        Geodetic [rad].
    lifts : ndarray, shape (legs, 3)
        Largest acceleration in each turn, along body axes [m/s2].
    """
    fixed = np.column_stack([up, _earth(up, latitude)])  # up and the earth's rate, in body axes
    rates, forces, parts, place, at = [], [], [], [], 0
    for number, (leg, lift) in enumerate(zip(legs, lifts, strict=True)):
        parts.append(Part(at, at + leg.dwell, leg.direction))
        rates.append(np.broadcast_to(fixed[:, 1], (leg.dwell, 3)))
        forces.append(np.broadcast_to(gravity * fixed[:, 0], (leg.dwell, 3)))
        at += leg.dwell
        if leg.turn:
            share = (np.arange(leg.turn + 1)) / leg.turn
            angle = share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)
            middle = 0.5 * (angle[1:] + angle[:-1])
            speed = np.diff(angle)[:, np.newaxis] / interval
            rates.append(speed * leg.vector + carried(fixed[:, 1], leg.vector, middle))
            hop = np.sin(4.0 * np.pi * (share[1:] - 0.5 / leg.turn)) * np.sin(np.pi * (share[1:] - 0.5 / leg.turn)) ** 2
            forces.append(gravity * carried(fixed[:, 0], leg.vector, middle) + hop[:, np.newaxis] * lift)
            if leg.known is not None:
                parts.append(Part(at, at + leg.turn, None, *leg.known))
            at += leg.turn
            fixed = np.column_stack([carried(one, leg.vector, np.ones(1))[0] for one in fixed.T])
        place.append(np.repeat([number, number + 1], [leg.dwell + leg.turn // 2, leg.turn - leg.turn // 2]))
    return Motion(np.vstack(rates), np.vstack(forces), tuple(parts), np.concatenate(place))


def _earth(up: Array, latitude: float) -> Array:
    """Return the earth's rate in body axes, north where it may be."""
    north = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    north = north / np.linalg.norm(north)
    return np.asarray(EARTH_ROTATION_RATE.value * (np.sin(latitude) * up + np.cos(latitude) * north))


def carried(fixed: Array, vector: Array, shares: Array) -> Array:
    """Return a vector fixed in space, seen from a body that has turned by shares of a vector, shape (n, 3)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.broadcast_to(fixed, (len(shares), 3))
    axis = vector / angle
    along = (axis @ fixed) * axis
    turned = angle * shares[:, np.newaxis]
    return np.asarray(along + np.cos(turned) * (fixed - along) - np.sin(turned) * np.cross(axis, fixed))


def turn_between(up: Array, then: Array, spin: float) -> Array:
    """Return a turn of the body that takes up to another direction in it, shape (3,) [rad].

    Parameters
    ----------
    up, then : ndarray, shape (3,)
        Up in the body, before and after.
    spin : float
        Turn about the vertical before the tilt [rad].
    """
    cross, cosine = np.cross(up, then), float(up @ then)
    side = cross if np.linalg.norm(cross) > 1e-9 else np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    tilt = -np.arctan2(np.linalg.norm(cross), cosine) * side / np.linalg.norm(side)
    return _vector(_quaternion(spin * up), _quaternion(tilt))


def _quaternion(vector: Array) -> Array:
    half = 0.5 * float(np.linalg.norm(vector))
    return np.array([np.cos(half), *(0.5 * np.sinc(half / np.pi) * vector)])


def _vector(first: Array, second: Array) -> Array:
    """Return the vector of the turn by ``first`` and then, about axes that have turned along, by ``second``."""
    a, u, b, v = first[0], first[1:], second[0], second[1:]
    scalar, rest = a * b - u @ v, a * v + b * u + np.cross(u, v)
    size = float(np.linalg.norm(rest))
    return np.asarray(2.0 * np.arctan2(size, scalar) * rest / size) if size > 0.0 else np.zeros(3)


Sequenced = tuple[Array, tuple[Leg, ...], dict[int, tuple[float, float, float]]]


def sequence(bench: Bench, mounting: Array, faces: Array, rng: np.random.Generator) -> Sequenced:
    """Return up at first, what is done in order of time, and the directions that are written down, by position."""
    return _ferraris(bench, mounting, faces, rng) if bench.variant == "ferraris" else _tumble(bench, rng)


def labelled_parts(parts: Sequence[Part]) -> tuple[LabelledPart, ...]:
    """Return what is written down of positions and turns that are known."""
    found = []
    for part in parts:
        vector = part.direction if part.axis is None else part.axis
        if vector is not None:
            face = int(np.argmax(FACES @ np.array(vector)))
            label = NAMES[face] if part.axis is None else f"{AXES[face // 2]}_rot"
            found.append(LabelledPart(label, part.start, part.stop, angle=part.angle))
    return tuple(found)


def _samples(bench: Bench, seconds: float, rng: np.random.Generator) -> int:
    return round(seconds * (1.0 + 0.5 * rng.random()) * bench.sample_rate)


def _tumble(bench: Bench, rng: np.random.Generator) -> Sequenced:
    """Many directions, spread over the sphere, in an order that turns much, with a hand's scatter."""
    ups = _scattered(_spread(bench.positions, bench.flat), bench.spread, rng)
    legs = []
    for k, up in enumerate(ups):
        dwell = _samples(bench, bench.first if k == 0 else bench.dwell, rng)
        last = k == len(ups) - 1
        vector = np.zeros(3) if last else turn_between(up, ups[k + 1], float(rng.uniform(-1.0, 1.0)))
        legs.append(Leg(dwell, 0 if last else _samples(bench, bench.turn, rng), vector))
    return ups[0], tuple(legs), {}


def _spread(n: int, flat: bool) -> Array:
    """Return n directions on the sphere, or around one circle, neighbours in time far apart."""
    k = np.arange(n) + 0.5
    height = np.zeros(n) if flat else 1.0 - 2.0 * k / n
    around = 2.0 * np.pi * k / n if flat else np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - height**2)
    order = np.argsort((np.arange(n) * 0.381966) % 1.0, kind="stable")
    return np.column_stack([ring * np.cos(around), ring * np.sin(around), height])[order]


def _scattered(directions: Array, spread: float, rng: np.random.Generator) -> Array:
    """Return directions turned by small angles about axes across them."""
    away = spread * rng.normal(size=directions.shape)
    found = directions + np.cross(away, directions)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _ferraris(bench: Bench, mounting: Array, off: Array, rng: np.random.Generator) -> Sequenced:
    """Six faces, then a turn about each axis, that axis up: each face off by its error, and by that of the laying."""
    faces = np.vstack([FACES[[name != bench.left_out for name in NAMES]]] * bench.rounds)
    meant = np.vstack([faces, *[np.eye(3)] * bench.rounds])
    ups = meant.copy()
    for k, one in enumerate(meant):
        away = off[int(np.argmax(FACES @ one))] + bench.repeatability * rng.normal(size=3)
        ups[k] = one + np.cross(away + mounting, one)
        ups[k] /= np.linalg.norm(ups[k])
    legs = []
    for k, up in enumerate(ups):
        dwell = _samples(bench, bench.first if k == 0 else bench.dwell, rng)
        if k < len(faces):
            vector = turn_between(up, ups[k + 1], float(rng.uniform(-1.0, 1.0)))
            legs.append(Leg(dwell, _samples(bench, bench.turn, rng), vector))
            continue
        axis = (float(meant[k][0]), float(meant[k][1]), float(meant[k][2]))
        full = 2.0 * np.pi * (-1.0) ** ((k - len(faces)) // 3)
        vector = (full + drawn_error(bench.angle, rng)) * up
        legs.append(Leg(dwell, _samples(bench, 4.0 * bench.turn, rng), vector, known=(axis, bench.sense * full)))
        after = ups[k + 1] if k + 1 < len(ups) else up
        move = turn_between(up, after, 0.0)
        legs.append(Leg(_samples(bench, bench.dwell, rng), _samples(bench, bench.turn, rng), move))
    legs.append(Leg(_samples(bench, bench.dwell, rng), 0, np.zeros(3)))
    if bench.misnamed:
        faces[[3, 4]] = faces[[4, 3]]
    return ups[0], tuple(legs), {k: (float(d[0]), float(d[1]), float(d[2])) for k, d in enumerate(faces)}
