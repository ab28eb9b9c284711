"""Rate of a satellite in a circular orbit about the earth.

With the radius r = R + h of an altitude h over a sphere of the earth's mean radius R = (2 a + b) / 3::

    n = sqrt(GM / r^3)

An altitude over the ellipsoid may be meant: then r lies between b + h and a + h, with equal chances; that spread is the
standard uncertainty of n, 0.13 % at 560 km. The flattening moves n itself by less (J2: 0.1 %).

References
----------
.. [1] NIMA TR8350.2, World Geodetic System 1984, 3rd edition (2000), Tables 3.1 and 3.5 (mean radius of the semi-axes).
"""

from __future__ import annotations

import math

import numpy as np

from ..core.constants import EARTH_ROTATION_RATE, WGS84_FLATTENING, WGS84_GM, WGS84_SEMI_MAJOR_AXIS
from ..core.errors import DataError
from ..core.estimate import Array, Component, Estimate

A = WGS84_SEMI_MAJOR_AXIS.value  # [m]
B = A * (1.0 - WGS84_FLATTENING.value)  # [m]
MEAN_RADIUS = (2.0 * A + B) / 3.0  # [m]


def orbital_rate(altitude: float) -> Estimate:
    """Return the angular rate of a circular orbit.

    Parameters
    ----------
    altitude : float
        Above the mean earth [m].

    Returns
    -------
    Estimate
        ``orbital_rate`` [rad/s].

    Raises
    ------
    DataError
        ``altitude`` if it is not above ground.
    """
    if not (math.isfinite(altitude) and altitude > 0.0):
        raise DataError(f"altitude {altitude:g} m: need a height above ground", do='Like "560 km"', code="altitude")
    radius = MEAN_RADIUS + altitude
    rate = math.sqrt(WGS84_GM.value / radius**3)
    u = 1.5 * rate / radius * (A - B) / math.sqrt(12.0)
    spread = Component("radius of the earth under the orbit", "B", np.array([[u**2]]), distribution="rectangular")
    return Estimate(("orbital_rate",), np.array([rate]), ("rad/s",), (spread,))


def circular_track(altitude: float, inclination: float, time: Array, node: float = 0.0, start: float = 0.0) -> Array:
    """Return earth-fixed positions of a circular orbit.

    Parameters
    ----------
    altitude : float
        Above the mean earth [m].
    inclination : float
        Of the orbit [rad].
    time : ndarray, shape (n,)
        [s].
    node, start : float
        Longitude of the ascending node at time 0; angle from it to the satellite then [rad].

    Returns
    -------
    ndarray, shape (n, 3)
        [m].
    """
    along = start + orbital_rate(altitude).value("orbital_rate") * time
    turned = node - EARTH_ROTATION_RATE.value * time
    x, y, z = np.cos(along), np.sin(along) * math.cos(inclination), np.sin(along) * math.sin(inclination)
    c, s = np.cos(turned), np.sin(turned)
    return np.asarray((MEAN_RADIUS + altitude) * np.column_stack([x * c - y * s, x * s + y * c, z]))
