"""A mass turned around an accelerometer in orbit: its attraction, and the recoil of the satellite.

The mass m goes round at the distance r with the signed rate W, positive in the sense of the orbit. The input axis lies
in the plane of the orbit; the angle phi of the mass is counted from it, positive in the same sense. The satellite of
mass M keeps its attitude to the local vertical, so the frame turns with the orbital rate n. Both bodies go round their
centre of mass: the satellite is displaced by ``xi = -a (cos phi, sin phi)``, with the recoil arm ``a = m r / (M + m)``,
and its specific force is, in the frame of the orbit [1]_::

    f = xi'' + 2 n x xi' - (3 n^2 xi_radial, 0, -n^2 xi_normal)

An accelerometer that counts attraction as positive reads the attraction less f, along its input axis::

    u(phi) = A sum_l l eps^(l - 1) P_l(cos phi) - a (W^2 + 2 n W + g) cos phi        A = G m / r^2

with eps the offset of the proof mass from the axis of rotation along the input axis, over r, and g = 3 n^2 for a radial
input axis, 0 for one along the track. Of an input axis across the orbit nothing is read to first order.

Assumed: a circular orbit, a mass that attracts as a point (a sphere), a rigid arm, a satellite that does not rock: the
attitude control holds it against the torque of the arm.

References
----------
.. [1] G. W. Hill, Am. J. Math. 1 (1878) 5; W. H. Clohessy and R. S. Wiltshire, J. Aerosp. Sci. 27 (1960) 653.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ..core.constants import GRAVITATIONAL_CONSTANT
from ..core.errors import DataError
from ..core.estimate import Array

InputAxis = Literal["radial", "along_track"]
PLACES = 128  # of a turn, from which harmonics are taken: offsets up to 0.7 of the distance to rounding
HIGHEST = 3  # harmonic of the turn that is used


def attraction(mass: float, radius: float) -> float:
    """Return the attraction A of the turned mass [m/s^2], from its mass [kg] and distance [m]."""
    return GRAVITATIONAL_CONSTANT.value * mass / radius**2


def recoil_arm(mass: float, radius: float, satellite: float) -> float:
    """Return the recoil arm m r / (M + m) [m]; ``satellite`` is M, all but the turned mass [kg]."""
    return mass * radius / (satellite + mass)


def recoil_rates(rate: Array | float, orbit: float, axis: InputAxis = "radial") -> tuple[Array, Array]:
    """Return what the recoil arm is multiplied by, along the input axis and across it [1/s^2].

    Parameters
    ----------
    rate, orbit : ndarray or float, float
        Signed rate of the turn, and that of the orbit [rad/s]; 0 far from any planet.
    axis : {"radial", "along_track"}
        The input axis.
    """
    w = np.asarray(rate, dtype=np.float64)
    common, tidal = w * w + 2.0 * orbit * w, 3.0 * orbit * orbit
    return (common + tidal, common) if axis == "radial" else (common, common + tidal)


def null_rates(
    mass: float, radius: float, satellite: float, orbit: float, axis: InputAxis = "radial"
) -> tuple[float, float]:
    """Return the rates of turn at which recoil and attraction cancel, in the sense of the orbit and against it [rad/s].

    Both are NaN where no rate does it.
    """
    wanted = attraction(mass, radius) / recoil_arm(mass, radius, satellite)
    under = orbit * orbit + wanted - (3.0 * orbit * orbit if axis == "radial" else 0.0)
    root = math.sqrt(under) if under >= 0.0 else math.nan
    return -orbit + root, -orbit - root


def harmonics(along: float, across: float) -> Array:
    """Return the harmonics of the attraction on an offset proof mass, over A.

    Parameters
    ----------
    along, across : float
        Offset from the axis of rotation along the input axis, and across it in the plane of the turn, over the
        distance of the mass.

    Returns
    -------
    ndarray, shape (2, HIGHEST + 1, 2)
        For the input axis and the one across: harmonics 0, 1, ... of the turn, as (cosine, sine).

    Raises
    ------
    DataError
        ``overlap`` if the proof mass lies where the mass passes.
    """
    if not math.hypot(along, across) < 1.0:
        what = f"an offset of {math.hypot(along, across):.3g} of the distance of the mass"
        raise DataError(what, why="the mass would hit the instrument", do="Check offset and radius", code="overlap")
    phi = 2.0 * np.pi * np.arange(PLACES) / PLACES
    apart = np.array([np.cos(phi) - along, np.sin(phi) - across])
    lines = np.fft.rfft(apart / np.sum(apart**2, axis=0) ** 1.5, axis=1)[:, : HIGHEST + 1] / PLACES
    lines[:, 1:] *= 2.0
    return np.stack([lines.real, -lines.imag], axis=2)
