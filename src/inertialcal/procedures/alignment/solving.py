"""Attitude from mean specific forces and rates: levelling, gyrocompassing, and how each figure changes with each input.

Conventions: level axes are north, east, down. With the unit's x forward, y to the right and z down, ``C_level_body =
R_z(heading) R_y(pitch) R_x(roll)``; a unit whose z points up is first turned by 180 deg about x, so that all angles
mean the same: heading is the azimuth of x from north over east, pitch how far x points above the horizon, roll is
positive with the right side down.

At rest the specific force is f = -g: down is -f / abs(f) (roll, pitch). With the rates turned level (heading 0), each
position k whose heading is that of the first and ``turn_k`` reads ::

    w_k = L_k' [ R(turn_k) c ; -W sin(latitude) ] + b        c = W cos(latitude) (cos heading, -sin heading)

One position: b is left out, ``c`` is the level rate (TRIAD: gravity first [1]_). More: least squares for c and b, in
which a constant bias cancels [2]_. What is left, along the vertical and of the length of c, is what noise, drift and
unknown biases do: 2 values of one position, 3 m - 4 of m.

References
----------
.. [1] M. D. Shuster, S. D. Oh, J. Guidance and Control 4 (1981) 70 (TRIAD).
.. [2] D. H. Titterton, J. L. Weston, Strapdown Inertial Navigation Technology (2004), 10.3 and 10.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...core.estimate import Array
from ...physics.attitude import from_roll_pitch_yaw
from ...physics.earth import OMEGA

FLIP = np.array([1.0, -1.0, -1.0])  # between a unit whose z points up and one whose z points down
STEPS = {"acc": 1e-5, "gyro": 1e-4 * OMEGA, "turns": 1e-5, "latitude": 1e-5, "mounting": 1e-5, "deflection": 1e-6}


@dataclass(frozen=True, eq=False)
class Inputs:
    """What the figures are made of."""

    acc: Array  # shape (m, 3): mean specific force [m/s^2]
    gyro: Array  # shape (m, 3): mean rate [rad/s]
    turns: Array  # shape (m,): by how much the heading is larger than in the first position [rad]
    latitude: float  # geodetic [rad]
    gravity: float  # [m/s^2]
    up: bool = False  # whether z points up
    mounting: Array | None = None  # shape (3,): small turn of the case against the triads [rad]
    deflection: Array | None = None  # shape (2,): of the plumb line, north and east [rad]


@dataclass(frozen=True, eq=False)
class Solution:
    """What the inputs give."""

    roll: Array  # shape (m,) [rad]
    pitch: Array  # shape (m,) [rad]
    heading: Array  # shape (m,): of the first from -pi to pi, of the others by the turns [rad]
    level: Array  # shape (2,): c, level rate along x and across it, heading 0 [rad/s]
    bias: Array  # shape (3,) in body axes; of one position all along the vertical [rad/s]
    vertical: float  # of one position: rate about the vertical beyond that of the earth, clockwise [rad/s]
    left: float  # sum of squares of what is left [rad^2/s^2]
    dof: int
    spread: Array  # shape (2,): variances of the level rate along and across the heading, for that of a reading of 1

    @property
    def rate(self) -> float:
        """Level part of the rate of the earth as it is read [rad/s]."""
        return float(np.hypot(*self.level))

    @property
    def scatter(self) -> float:
        """Standard deviation of the mean of one axis in one position, as what is left shows it [rad/s]."""
        return math.sqrt(self.left / self.dof)


def levelled(force: Array) -> tuple[float, float]:
    """Return roll and pitch from a specific force, shape (3,), x forward and z down [rad]."""
    x, y, z = -force / np.linalg.norm(force)
    return math.atan2(y, z), -math.asin(min(max(float(x), -1.0), 1.0))


def turned_level(angle: float) -> Array:
    """Return what a larger heading makes of the level rate of heading 0, shape (2, 2)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, s], [-s, c]])


def solve(given: Inputs) -> Solution:
    """Return attitude, rates and biases."""
    flip = FLIP if given.up else np.ones(3)
    case = np.eye(3) if given.mounting is None else np.eye(3) + _cross(given.mounting)
    angles, levels = [], []
    for force in given.acc:
        angles.append(levelled((case @ force) * flip))
        levels.append(from_roll_pitch_yaw(*angles[-1], 0.0))
    rates = (given.gyro @ case.T) * flip
    found = _level(given, levels, rates)
    first = math.atan2(-found.level[1], found.level[0])
    roll, pitch = np.array(angles).T
    heading = first + given.turns
    if given.deflection is not None:  # in first order; of the heading it is Laplace's equation
        north, east = given.deflection
        heading = heading + math.tan(given.latitude) * east
        pitch = pitch - north * np.cos(heading) - east * np.sin(heading)
        roll = roll - north * np.sin(heading) + east * np.cos(heading)
    return replace(found, roll=roll, pitch=pitch, heading=heading, bias=found.bias * flip)


def _level(given: Inputs, levels: list[Array], rates: Array) -> Solution:
    """Return level rate and biases, x forward and z down."""
    down = -OMEGA * math.sin(given.latitude)
    horizontal, nothing = OMEGA * math.cos(given.latitude), np.zeros(len(rates))
    if len(rates) == 1:
        x, y, z = levels[0] @ rates[0]
        beyond = float(z - down)
        left = beyond**2 + (math.hypot(x, y) - horizontal) ** 2
        bias = levels[0].T @ np.array([0.0, 0.0, beyond])
        return Solution(nothing, nothing, nothing, np.array([x, y]), bias, beyond, left, 2, np.ones(2))
    design, values = [], []
    for level, rate, turn in zip(levels, rates, given.turns.tolist(), strict=True):
        design.append(np.hstack([level.T[:, :2] @ turned_level(turn), np.eye(3)]))
        values.append(rate - level.T[:, 2] * down)
    matrix, vector = np.vstack(design), np.concatenate(values)
    inverse = np.linalg.pinv(matrix.T @ matrix, rcond=1e-12, hermitian=True)
    solution = inverse @ (matrix.T @ vector)
    rest, level = vector - matrix @ solution, solution[:2]
    along = level / max(float(np.linalg.norm(level)), 1e-300)
    across = np.array([-along[1], along[0]])
    spread = np.array([along @ inverse[:2, :2] @ along, across @ inverse[:2, :2] @ across])
    radial = (float(np.linalg.norm(level)) - horizontal) ** 2 / max(float(spread[0]), 1e-300)
    return Solution(nothing, nothing, nothing, level, solution[2:], 0.0, float(rest @ rest) + radial,
                    3 * len(rates) - 4, spread)  # fmt: skip


def figures(given: Inputs) -> Array:
    """Return all figures as one vector: roll, pitch, heading of each position, bias, vertical, rate, latitude, excess.

    Returns
    -------
    ndarray, shape (3 m + 7,)
        Angles [rad], three biases and that about the vertical [rad/s], level rate [rad/s], latitude by it, and by how
        much the specific force is larger than gravity [m/s^2].
    """
    found = solve(given)
    size = float(np.mean(np.linalg.norm(given.acc, axis=1))) - given.gravity
    each = np.column_stack([found.roll, found.pitch, found.heading]).ravel()
    return np.concatenate([each, found.bias, [found.vertical, found.rate, latitude_of(given, found), size]])


def latitude_of(given: Inputs, found: Solution) -> float:
    """Return the latitude that the rates tell: by the angle to gravity, or by the level rate alone [rad].

    Of one position it is the angle between the rate and the level plane; of several the rate about the vertical is not
    known without the latitude, and the level rate tells its size.
    """
    if len(given.acc) == 1:
        return math.atan2(OMEGA * math.sin(given.latitude) - found.vertical, found.rate)
    return math.copysign(math.acos(min(found.rate / OMEGA, 1.0)), given.latitude)


def changes(given: Inputs) -> dict[str, Array]:
    """Return by how much each figure changes with each input, shape (figures, size of the input) by name."""
    given = replace(
        given,
        mounting=np.zeros(3) if given.mounting is None else given.mounting,
        deflection=np.zeros(2) if given.deflection is None else given.deflection,
    )
    found = {}

    def at(name: str, value: Array) -> Array:
        if name == "latitude":
            return figures(replace(given, latitude=float(value[0])))
        arrays: dict[str, Array] = {name: value}
        return figures(replace(given, **arrays))  # type: ignore[arg-type]

    for name, step in STEPS.items():
        value = np.atleast_1d(np.asarray(getattr(given, name), dtype=float))
        columns = []
        for number in range(value.size):
            ends = []
            for sign in (1.0, -1.0):
                moved = value.copy()
                moved.flat[number] += sign * step
                ends.append(at(name, moved))
            columns.append(_wrapped(ends[0] - ends[1], len(given.acc)) / (2.0 * step))
        found[name] = np.array(columns).T
    return found


def _wrapped(difference: Array, positions: int) -> Array:
    """Return differences of figures, those of angles within half a turn."""
    found = difference.copy()
    found[: 3 * positions] = np.remainder(found[: 3 * positions] + math.pi, 2.0 * math.pi) - math.pi
    return found


def attitude(roll: float, pitch: float, heading: float, up: bool) -> Array:
    """Return the matrix that takes body axes to north, east, down, shape (3, 3)."""
    C_level_body = from_roll_pitch_yaw(roll, pitch, heading)
    return np.asarray(C_level_body * (FLIP if up else np.ones(3)))


def quaternion(matrix: Array) -> Array:
    """Return the quaternion (w, x, y, z), w not negative, of a rotation matrix."""
    m = matrix
    each = np.array([1.0 + m[0, 0] + m[1, 1] + m[2, 2], 1.0 + m[0, 0] - m[1, 1] - m[2, 2],
                     1.0 - m[0, 0] + m[1, 1] - m[2, 2], 1.0 - m[0, 0] - m[1, 1] + m[2, 2]])  # fmt: skip
    w, x, y, z = 0.5 * np.sqrt(np.maximum(each, 0.0))
    at = int(np.argmax(each))
    if at == 0:
        x, y, z = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / (4.0 * w)
    elif at == 1:
        w, y, z = np.array([m[2, 1] - m[1, 2], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]]) / (4.0 * x)
    elif at == 2:
        w, x, z = np.array([m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], m[2, 1] + m[1, 2]]) / (4.0 * y)
    else:
        w, x, y = np.array([m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2]]) / (4.0 * z)
    found = np.array([w, x, y, z])
    return np.asarray(found if w >= 0.0 else -found)


def _cross(vector: Array) -> Array:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
