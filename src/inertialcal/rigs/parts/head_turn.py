"""A triaxial head that is turned: its angle over time, what it then feels of a fixed vector, what the turn adds.

Turns are right-handed about a direction fixed in the head and in space. A vector fixed in space has, along the axes of
the head at position 0, the components g; after a turn by the angle about the unit vector e it has ``exp(-angle [e]) g``
along the axes of the head as it then is. About x, half a turn takes (g_x, g_y, g_z) to (g_x, -g_y, -g_z).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array


@dataclass(frozen=True, eq=False)
class Course:
    """Angle of the head over time [rad], its rate [rad/s] and acceleration [rad/s^2], shape (n,) each."""

    angle: Array
    rate: Array
    acceleration: Array


def course(seconds: Array, starts: Array, angles: Array, turn_time: float) -> Course:
    """Return the course of a head that rests at 0, and goes to an angle in half a cosine at each start.

    Parameters
    ----------
    seconds : ndarray, shape (n,)
        Ascending [s].
    starts, angles : ndarray, shape (q,)
        When each turn begins [s], and the angle that it ends at [rad].
    turn_time : float
        Of each turn [s].
    """
    found = Course(*(np.zeros(len(seconds)) for _ in range(3)))
    before = 0.0
    for start, after in zip(starts, angles, strict=True):
        a, b = np.searchsorted(seconds, (start, start + turn_time))
        phase = np.pi * (seconds[a:b] - start) / turn_time
        swing, speed = 0.5 * (after - before), np.pi / turn_time
        found.angle[a:b] = before + swing * (1.0 - np.cos(phase))
        found.rate[a:b] = swing * speed * np.sin(phase)
        found.acceleration[a:b] = swing * speed**2 * np.cos(phase)
        found.angle[b:] = after
        before = float(after)
    return found


def felt(fixed: Array, angle: Array, along: Array) -> Array:
    """Return a vector fixed in space along the axes of the turned head, shape (n, 3).

    Parameters
    ----------
    fixed : ndarray, shape (n, 3) or (3,)
        Along the axes of the head at position 0.
    angle : ndarray, shape (n,)
        [rad]
    along : ndarray, shape (3,)
        Unit vector about which it is turned.
    """
    kept = np.multiply.outer(fixed @ along, along)
    across = fixed - kept
    side = np.cross(np.broadcast_to(fixed, (len(fixed) if fixed.ndim > 1 else 1, 3)), along)
    return np.asarray(kept + np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * side)


def swung(motion: Course, along: Array, arm: Array) -> Array:
    """Return the acceleration of a point of the head while it turns, along its own axes, shape (n, 3) [m/s^2].

    Parameters
    ----------
    motion : Course
        Of the head.
    along, arm : ndarray, shape (3,)
        Unit vector about which it is turned; from there to the point [m].
    """
    tangential = np.multiply.outer(motion.acceleration, np.cross(along, arm))
    return np.asarray(tangential + np.multiply.outer(motion.rate**2, np.cross(along, np.cross(along, arm))))
