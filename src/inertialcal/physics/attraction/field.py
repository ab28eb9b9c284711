"""Attraction of a body, with a gravitational constant.

Signs: the field is the acceleration of a free body [m/s^2]; it points to what attracts. An accelerometer that is held
at rest reads the opposite.

The constant is an argument, because a document is repeated with its own: Reinel's 6.67e-8 cm^3/(g s^2) is 6.5e-4 less
than today's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.errors import DataError
from ...core.estimate import Array
from .bodies import Body

G = GRAVITATIONAL_CONSTANT.value  # [m^3/s^2/kg]


def attraction(body: Body, points: ArrayLike, gravitational_constant: float = G) -> Array:
    """Return the attraction of a body.

    Parameters
    ----------
    body : Body
        What attracts.
    points : array_like, shape (..., 3)
        Where [m].
    gravitational_constant : float
        [m^3/s^2/kg].

    Returns
    -------
    ndarray, shape (..., 3)
        [m/s^2].

    Raises
    ------
    DataError
        If points are not triples of finite numbers, or lie in a point mass.
    """
    flat, shape = _triples(points)
    return gravitational_constant * body.field(flat).reshape(shape)


def attraction_gradient(body: Body, points: ArrayLike, gravitational_constant: float = G) -> Array:
    """Return the gradient of the attraction of a body, symmetric; outside of matter its trace is zero.

    Parameters
    ----------
    body : Body
        What attracts.
    points : array_like, shape (..., 3)
        Where [m].
    gravitational_constant : float
        [m^3/s^2/kg].

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Component by direction [1/s^2].

    Raises
    ------
    DataError
        If points are not triples of finite numbers, or lie in a point mass.
    """
    flat, shape = _triples(points)
    return gravitational_constant * body.gradient(flat).reshape(*shape, 3)


def _triples(points: ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """Points as rows, and the shape they came in."""
    given = np.asarray(points, dtype=float)
    if given.ndim == 0 or given.shape[-1] != len("xyz") or not np.isfinite(given).all():
        raise DataError(
            f"points of shape {given.shape} are not triples of finite numbers: x, y, z in metres are needed",
            code="no_points",
        )
    return np.ascontiguousarray(given.reshape(-1, 3)), given.shape
