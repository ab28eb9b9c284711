"""Attitude of coordinate systems: matrices from roll, pitch and yaw, and vectors turned from one to another.

Conventions, for all of this module: right-handed systems, angles in radians. A system S lies in a reference system A
by turning from A about z (yaw), then about the new y (pitch), then about the newest x (roll) [1]_, so that::

    a_A = C_A_S a_S          C_A_S = R_z(yaw) R_y(pitch) R_x(roll)

``C_to_from`` takes components in ``from`` to components in ``to``: the vector stays, its axes change.

References
----------
.. [1] NASA Glenn, PIMS: coordinate systems in the headers of acceleration data (roll, pitch, yaw).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..core.errors import DataError
from ..core.estimate import Array


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Array:
    """Return C_reference_system of a system that lies in its reference by these angles.

    Parameters
    ----------
    roll, pitch, yaw : float
        About x, y and z [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        Takes components in the system to components in the reference; its columns are the axes of the system.

    Raises
    ------
    DataError
        If an angle is not finite.
    """
    angles = np.array([roll, pitch, yaw], dtype=np.float64)
    if not np.all(np.isfinite(angles)):
        raise DataError(f"roll, pitch, yaw = {roll:g}, {pitch:g}, {yaw:g} rad: need finite angles", code="not_finite")
    (s_x, s_y, s_z), (c_x, c_y, c_z) = np.sin(angles), np.cos(angles)
    R_x = np.array([[1.0, 0.0, 0.0], [0.0, c_x, -s_x], [0.0, s_x, c_x]])
    R_y = np.array([[c_y, 0.0, s_y], [0.0, 1.0, 0.0], [-s_y, 0.0, c_y]])
    R_z = np.array([[c_z, -s_z, 0.0], [s_z, c_z, 0.0], [0.0, 0.0, 1.0]])
    C_reference_system: Array = R_z @ R_y @ R_x
    return C_reference_system


def between(C_reference_to: ArrayLike, C_reference_from: ArrayLike) -> Array:
    """Return C_to_from of two systems that are known in one reference.

    Parameters
    ----------
    C_reference_to, C_reference_from : array_like, shape (3, 3)
        Each as ``from_roll_pitch_yaw`` gives it.

    Returns
    -------
    ndarray, shape (3, 3)
        Takes components in ``from`` to components in ``to``.
    """
    C_to_from: Array = np.asarray(C_reference_to, dtype=np.float64).T @ np.asarray(C_reference_from, dtype=np.float64)
    return C_to_from
