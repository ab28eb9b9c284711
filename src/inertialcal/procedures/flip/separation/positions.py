"""Positions of a turned head, and what its axes read of ambient acceleration there.

The head is turned by the angle theta, right-handed, about one of its own axes a. Ambient acceleration g, given along
the head's axes at position 0, is read along its axes after the turn as ``C g``, where ``C_turned_0 = exp(-theta [a])``
takes it from the one to the other: about x::

    y: cos(theta) g_y + sin(theta) g_z          z: -sin(theta) g_y + cos(theta) g_z

A half turn changes the sign of both and leaves x alone [1]_.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, eq. (1)-(7).
"""

from __future__ import annotations

import numpy as np

from ....core.axes import AXES
from ....core.estimate import Array

ROUNDING = 1e-9  # of a sine: half turns written in degrees, or as 3.141592653589793
SAME = 1e-6  # [rad] positions nearer than this are one


def rotation(axis: str, angle: Array) -> Array:
    """Return C_turned_0 of each dwell, shape (n, 3, 3).

    Parameters
    ----------
    axis : str
        Of the turn.
    angle : ndarray, shape (n,)
        [rad].
    """
    along = np.eye(3)[AXES.index(axis)]
    rest = np.eye(3) - np.outer(along, along)
    return np.asarray(
        np.outer(along, along) + _clean(np.cos(angle))[:, None, None] * rest
        - _clean(np.sin(angle))[:, None, None] * cross(along)
    )  # fmt: skip


def slope(axis: str, angle: Array) -> Array:
    """Return the derivative of C_turned_0 with respect to the angle, shape (n, 3, 3)."""
    return np.asarray(-cross(np.eye(3)[AXES.index(axis)]) @ rotation(axis, angle))


def tilted(axis: str, angle: Array, small: Array) -> Array:
    """Return the change of C_turned_0 where the axis really turned about is off by a small rotation, shape (n, 3, 3).

    Parameters
    ----------
    axis, angle
        As stated.
    small : ndarray, shape (3,)
        Rotation vector that takes the axis named to that turned about [rad].
    """
    C = rotation(axis, angle)
    return np.asarray(cross(small) @ C - C @ cross(small))


def cross(vector: Array) -> Array:
    """Return the matrix of a cross product, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def directions(angle: Array) -> Array:
    """Return what of a fixed direction the positions tell apart: no, one or two columns, shape (n, 0..2).

    Two columns are cosine and sine. One, where all positions lie on a line, is the coordinate along it, from its
    middle, so that a half turn gives +1 and -1; it is positive at the end that is nearer position 0.
    """
    points = np.column_stack([_clean(np.cos(angle)), _clean(np.sin(angle))])
    if not len(points):
        return np.zeros((0, 0))
    spread, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1:]
    rank = int(np.sum(spread > SAME))
    if rank != 1:
        return points[:, :rank]
    along = axes[0] if axes[0, 0] > ROUNDING or (abs(axes[0, 0]) <= ROUNDING and axes[0, 1] > 0.0) else -axes[0]
    coordinate = points @ along
    return np.asarray(coordinate - 0.5 * (coordinate.max() + coordinate.min()))[:, None]


def _clean(values: Array) -> Array:
    return np.where(np.abs(values) < ROUNDING, 0.0, values)
