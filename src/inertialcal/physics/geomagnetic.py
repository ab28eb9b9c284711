"""Field of the earth along an orbit: the International Geomagnetic Reference Field, in axes that do not turn.

The model is that of ``ppigrf`` (IGRF-14, degree 13), which the extra ``orbit`` brings. Positions are earth-fixed. The
axes do not turn: they are those of the earth at the first instant; the earth turns on about z at its rate. (Precession
and nutation turn them by less than 1e-6 rad a day.) Between knots a field along a smooth track is a cubic spline.

What a spacecraft meets beyond the model: the crust (10 to 20 nT rms at 500 km), currents in ionosphere and
magnetosphere (20 to 50 nT in quiet hours, hundreds in storms and above the aurora).

References
----------
.. [1] P. Alken et al., Earth Planets Space 73 (2021) 49: International Geomagnetic Reference Field, 13th generation.
.. [2] NIMA TR8350.2, World Geodetic System 1984, 3rd edition (2000), equation (4-14): geodetic to earth-fixed.
"""

from __future__ import annotations

import importlib
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array
from .earth import E2, OMEGA, A

FIRST, LAST = 1900, 2030  # years that the model holds for
KNOT = 10.0  # [s] between evaluations of the model: 76 km of a low orbit
LOWEST, HIGHEST = 6.3e6, 5e7  # from the centre of the earth, that a position may lie at [m]


def earth_fixed(latitude: Array, longitude: Array, height: Array) -> Array:
    """Return earth-fixed positions of geodetic ones, equation (4-14) of [2]_.

    Parameters
    ----------
    latitude, longitude : ndarray, shape (n,)
        Geodetic [rad].
    height : ndarray, shape (n,)
        Above the ellipsoid [m].

    Returns
    -------
    ndarray, shape (n, 3)
        [m].
    """
    across = A / np.sqrt(1.0 - E2 * np.sin(latitude) ** 2)
    level = (across + height) * np.cos(latitude)
    z = (across * (1.0 - E2) + height) * np.sin(latitude)
    return np.column_stack([level * np.cos(longitude), level * np.sin(longitude), z])


def field_along(times: Array, position: Array, start_ns: int, where: str = "") -> Array:
    """Return the field of the earth along a track.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Since the first instant, increasing [s].
    position : ndarray, shape (n, 3)
        Earth-fixed [m].
    start_ns : int
        First instant, UTC [ns since 1970].
    where : str
        File that it is from, for messages.

    Returns
    -------
    ndarray, shape (n, 3)
        In the earth's axes at the first instant, which do not turn with it [T].

    Raises
    ------
    DataError
        ``missing_extra`` without ppigrf; ``no_date`` outside of the years of the model; ``position`` where a position
        is no orbit of the earth.
    """
    radius = np.linalg.norm(position, axis=1)
    if not ((radius > LOWEST) & (radius < HIGHEST)).all():
        bad = int(np.argmin((radius > LOWEST) & (radius < HIGHEST)))
        what = f"sample {bad + 1}: a position {radius[bad] * 1e-3:.6g} km from the centre of the earth"
        raise DataError(
            what, where, do="Check columns and units of the position: earth-fixed, or geodetic", code="position"
        )
    date = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=start_ns / 1e3 + 5e5 * float(times[-1]))
    if not FIRST <= date.year < LAST:
        what = f"the record is of {date.year}; the model of the field holds from {FIRST} to {LAST}"
        raise DataError(what, where, do="Check the column of the time", code="no_date")
    try:
        model = importlib.import_module("ppigrf")
    except ImportError:
        what = "the field of the earth needs the package ppigrf, which is not installed"
        raise DataError(what, where, do="Type: pip install 'inertialcal[orbit]'", code="missing_extra") from None
    knots = _knots(times)
    fixed = _of_model(model.igrf_gc, position[knots], date.replace(tzinfo=None))
    turned = _about_z(fixed, OMEGA * times[knots])
    if len(knots) < 4:
        return np.column_stack([np.interp(times, times[knots], one) for one in turned.T])
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - starts slowly

    return np.asarray(CubicSpline(times[knots], turned)(times))


def _knots(times: Array) -> NDArray[np.intp]:
    """Return indices of samples about ``KNOT`` apart, the first and the last among them."""
    cell = np.floor((times - times[0]) / KNOT)
    first = np.flatnonzero(np.diff(cell, prepend=-1.0) > 0.0)
    return first if first[-1] == len(times) - 1 else np.append(first, np.intp(len(times) - 1))


def _of_model(igrf: object, position: Array, date: datetime) -> Array:
    """Return the field at earth-fixed positions, in earth-fixed axes [T]."""
    assert callable(igrf)  # noqa: S101 - a function of the package
    x, y, z = position.T
    radius = np.linalg.norm(position, axis=1)
    theta, phi = np.arccos(z / radius), np.arctan2(y, x)
    up, south, east = (np.ravel(one) * 1e-9 for one in igrf(radius * 1e-3, np.degrees(theta), np.degrees(phi), date))
    level = up * np.sin(theta) + south * np.cos(theta)
    return np.column_stack([
        level * np.cos(phi) - east * np.sin(phi),
        level * np.sin(phi) + east * np.cos(phi),
        up * np.cos(theta) - south * np.sin(theta),
    ])  # fmt: skip


def _about_z(vectors: Array, angle: Array) -> Array:
    """Return vectors of axes that have turned about z by an angle, in those that have not."""
    x, y, z = vectors.T
    return np.column_stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z])
