"""Earth under a test bench: rate and gravity, seen along an axis and from a turning table.

Frames and signs, for all of this module:

* level frame: north, east, down (right-handed). Latitudes are geodetic unless they are named geocentric,
  positive north. Angles are in radians.
* The axis of a table points up when ``tilt`` is zero; ``tilt`` leans it toward ``azimuth``, which counts from
  north over east. A negative tilt leans it the other way.
* table frame: z is the axis; x, at table angle zero, is the level direction of ``azimuth`` tilted with the
  axis; y completes the right-handed set and stays level. ``C_table_level`` takes level to table.
* Table angle and rate are positive right-handed about the axis. A vector at rest in the level frame turns
  backwards in the table frame.

Gravity points down. An accelerometer at rest reads the specific force, minus gravity.

References
----------
.. [1] NIMA TR8350.2, World Geodetic System 1984, 3rd edition (2000), section 4 and Table 3.4.
.. [2] Heiskanen and Moritz, Physical Geodesy (1967), section 2-10: normal gravity at a height.
.. [3] Badescu, NPS thesis (2011), equations (13) and (14).
.. [4] JCGM 101:2008, 6.4.6: arc sine distribution, standard deviation the half-width over the root of two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.constants import (
    EARTH_ROTATION_RATE,
    NORMAL_GRAVITY_EQUATOR,
    SOMIGLIANA_CONSTANT,
    WGS84_FLATTENING,
    WGS84_GM,
    WGS84_SEMI_MAJOR_AXIS,
)
from ..core.errors import DataError
from ..core.estimate import Array, Component, Estimate

OMEGA = EARTH_ROTATION_RATE.value  # [rad/s]
A = WGS84_SEMI_MAJOR_AXIS.value  # [m]
F = WGS84_FLATTENING.value
E2 = F * (2.0 - F)  # first eccentricity squared
M = OMEGA**2 * A**3 * (1.0 - F) / WGS84_GM.value  # omega^2 a^2 b / GM of [1]_, section 4


def earth_rate(latitude: ArrayLike) -> Array:
    """Return the earth's rotation rate in the level frame.

    Parameters
    ----------
    latitude : array_like, shape (...)
        Geodetic [rad].

    Returns
    -------
    ndarray, shape (..., 3)
        North, east, down [rad/s].
    """
    phi = _latitude(latitude)
    return np.stack([OMEGA * np.cos(phi), np.zeros_like(phi), -OMEGA * np.sin(phi)], axis=-1)


def level_to_table(tilt: float, azimuth: float) -> Array:
    """Return the matrix that takes level to table coordinates at table angle zero, ``C_table_level``.

    Parameters
    ----------
    tilt : float
        Of the axis from the vertical, toward ``azimuth`` [rad].
    azimuth : float
        From north over east [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        Rows are the table's x, y, z in north, east, down.
    """
    ct, st, ca, sa = np.cos(tilt), np.sin(tilt), np.cos(azimuth), np.sin(azimuth)
    return np.array([[ct * ca, ct * sa, st], [sa, -ca, 0.0], [st * ca, st * sa, -ct]])


def earth_rate_along(latitude: ArrayLike, tilt: ArrayLike, azimuth: ArrayLike) -> Array:
    """Return the component of the earth's rate along an axis.

    Parameters
    ----------
    latitude, tilt, azimuth : array_like
        Geodetic; of the axis from the vertical; from north over east [rad]. They broadcast.

    Returns
    -------
    ndarray
        [rad/s].
    """
    phi = _latitude(latitude)
    level = np.cos(phi) * np.sin(tilt) * np.cos(azimuth)
    return np.asarray(OMEGA * (level + np.sin(phi) * np.cos(tilt)))


def earth_rate_sensitivities(latitude: float, tilt: float, azimuth: float) -> Array:
    """Return the derivatives of ``earth_rate_along`` by latitude, tilt and azimuth.

    Returns
    -------
    ndarray, shape (3,)
        [rad/s per rad].
    """
    phi = _latitude(latitude)
    by_latitude = -np.sin(phi) * np.sin(tilt) * np.cos(azimuth) + np.cos(phi) * np.cos(tilt)
    by_tilt = np.cos(phi) * np.cos(tilt) * np.cos(azimuth) - np.sin(phi) * np.sin(tilt)
    by_azimuth = -np.cos(phi) * np.sin(tilt) * np.sin(azimuth)
    return OMEGA * np.array([by_latitude, by_tilt, by_azimuth])


def axis_earth_rate(
    latitude: float,
    tilt: float,
    azimuth: float | None = None,
    *,
    u_latitude: float = 0.0,
    u_tilt: float = 0.0,
    u_azimuth: float = 0.0,
) -> Estimate:
    """Return the component of the earth's rate along an axis, with its Type B uncertainty.

    With the azimuth unknown, all directions are equally likely: the vertical part is the value, and the
    level part, of amplitude ``OMEGA cos(latitude) sin(tilt)``, has an arcsine distribution [4]_.

    Parameters
    ----------
    latitude, tilt : float
        Geodetic; of the axis from the vertical [rad].
    azimuth : float, optional
        From north over east [rad]; unknown if absent.
    u_latitude, u_tilt, u_azimuth : float
        Standard uncertainties [rad]; the last has no meaning where the azimuth is unknown.

    Returns
    -------
    Estimate
        ``earth_rate`` [rad/s], with a component a source.
    """
    if azimuth is None:
        value = float(earth_rate_along(latitude, tilt, 0.5 * np.pi))
        north = earth_rate_sensitivities(latitude, tilt, 0.0)
        south = earth_rate_sensitivities(latitude, tilt, np.pi)
        # Mean square over all azimuths of a derivative of the form p + q cos(azimuth): p^2 + q^2 / 2.
        mean_square = (0.5 * (north + south)) ** 2 + 0.5 * (0.5 * (north - south)) ** 2
        amplitude = OMEGA * np.cos(latitude) * np.sin(tilt)
        variances = [mean_square[0] * u_latitude**2, mean_square[1] * u_tilt**2, 0.5 * amplitude**2]
        last = ("azimuth unknown", "arcsine")
    else:
        value = float(earth_rate_along(latitude, tilt, azimuth))
        slopes = earth_rate_sensitivities(latitude, tilt, azimuth)
        variances = list((slopes * np.array([u_latitude, u_tilt, u_azimuth])) ** 2)
        last = ("azimuth", "normal")
    sources = (("latitude", "normal"), ("tilt", "normal"), last)
    components = tuple(
        Component(source, "B", np.array([[variance]]), distribution=distribution)
        for (source, distribution), variance in zip(sources, variances, strict=True)
    )
    return Estimate(("earth_rate",), np.array([value]), ("rad/s",), components)


def earth_rate_in_dwell(
    latitude: float, C_table_level: Array, start_angle: ArrayLike, angle_turned: ArrayLike
) -> Array:
    r"""Return the mean earth rate over dwells of a table that turns at a constant rate.

    The component along the axis stays; the one across it turns backwards in the table frame. Over the
    angle D from the angle s its mean is the exact integral::

        (2 / D) sin(D / 2) * component at the angle s + D / 2

    Parameters
    ----------
    latitude : float
        Geodetic [rad].
    C_table_level : ndarray, shape (3, 3)
        Table from level at table angle zero, from ``level_to_table``.
    start_angle, angle_turned : array_like, shape (...)
        Table angle at the start, and turned until the end; zero for a table at rest [rad].

    Returns
    -------
    ndarray, shape (..., 3)
        In the table frame [rad/s].
    """
    start, turned = np.broadcast_arrays(np.asarray(start_angle, dtype=float), np.asarray(angle_turned, dtype=float))
    x, y, z = C_table_level @ earth_rate(latitude)
    left = np.sinc(0.5 * turned / np.pi)
    middle = start + 0.5 * turned
    c, s = left * np.cos(middle), left * np.sin(middle)
    return np.stack([c * x + s * y, c * y - s * x, np.full_like(c, z)], axis=-1)


def geocentric_latitude(latitude: ArrayLike, height: ArrayLike = 0.0) -> Array:
    """Return the angle at the earth's centre between a place and the equator.

    Parameters
    ----------
    latitude : array_like
        Geodetic [rad].
    height : array_like
        Above the ellipsoid [m].

    Returns
    -------
    ndarray
        Geocentric latitude [rad].
    """
    phi = _latitude(latitude)
    normal = A / np.sqrt(1.0 - E2 * np.sin(phi) ** 2)  # radius of curvature in the prime vertical
    flat = 1.0 - E2 * normal / (normal + np.asarray(height, dtype=float))
    return np.asarray(np.arctan2(flat * np.sin(phi), np.cos(phi)))


def normal_gravity(latitude: ArrayLike, height: ArrayLike = 0.0) -> Array:
    """Return normal gravity by Somigliana's formula, at a height with the second-order free-air term [1]_ [2]_.

    It is what a smooth earth would give; local gravity differs by some 1e-3 m/s2 at most, commonly 3e-4.

    Parameters
    ----------
    latitude : array_like
        Geodetic [rad].
    height : array_like
        Above the ellipsoid, up to some 20 km [m].

    Returns
    -------
    ndarray
        [m/s2].
    """
    sine2 = np.sin(_latitude(latitude)) ** 2
    h = np.asarray(height, dtype=float)
    surface = NORMAL_GRAVITY_EQUATOR.value * (1.0 + SOMIGLIANA_CONSTANT.value * sine2) / np.sqrt(1.0 - E2 * sine2)
    return np.asarray(surface * (1.0 - 2.0 / A * (1.0 + F + M - 2.0 * F * sine2) * h + 3.0 * (h / A) ** 2))


def _latitude(latitude: ArrayLike) -> NDArray[np.float64]:
    phi = np.asarray(latitude, dtype=float)
    beyond = ~(np.abs(phi) <= 0.5 * np.pi)
    if beyond.any():
        raise DataError(
            f"latitude {phi[beyond].flat[0]:g} rad, need -pi/2 to pi/2",
            do="Latitudes are in radians",
            code="latitude",
        )
    return phi
