"""Positions and turns of an IMU laid by hand: what it is laid into, and turned by, and what is written down of it.

Directions are what points up, in body axes. Every face and turn is off by its own error, and all of them alike by that
of the mounting: a small rotation of the unit against the axes that are named.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.labelled import LabelledPart
from ..parts.campaign import drawn_error
from .motion import Leg, Part, turn_between
from .setup import Bench

FACES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
NAMES = ("x+", "x-", "y+", "y-", "z+", "z-")
Sequenced = tuple[Array, tuple[Leg, ...], dict[int, tuple[float, float, float]]]


def sequence(bench: Bench, mounting: Array, rng: np.random.Generator) -> Sequenced:
    """Return up at first, what is done in order of time, and the directions that are written down, by position."""
    return _ferraris(bench, mounting, rng) if bench.variant == "ferraris" else _tumble(bench, rng)


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


def _ferraris(bench: Bench, mounting: Array, rng: np.random.Generator) -> Sequenced:
    """Six faces, then a turn about each axis, that axis up, each laid anew and off by its errors."""
    faces = np.vstack([FACES[[name != bench.left_out for name in NAMES]]] * bench.rounds)
    meant = np.vstack([faces, *[np.eye(3)] * bench.rounds])
    ups = meant.copy()
    for k, one in enumerate(meant):
        away = np.array([drawn_error(bench.orientation, rng) for _ in range(3)])
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
