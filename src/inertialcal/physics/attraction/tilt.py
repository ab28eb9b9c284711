"""Tilt of a level surface by what attracts: the liquid of a tilt meter with two pools, or a bubble.

A liquid at rest is square to gravity and attraction together. Its height over the level is ``h = U / g``, with the
potential U of the attraction, so that between two pools a distance L apart it leans by [1]_::

    (h_2 - h_1) / L = (U_2 - U_1) / (g L) = mean of the attraction along the line between the pools / g

Positive is higher at the second pool: liquid is drawn toward what attracts. Terms of the square of the tilt, and the
attraction along gravity against g, are left out: 1e-8 of it. That the ground leans under the load is not in it.

References
----------
.. [1] Reinel, NASA TM X-53857, 1969, Appendix C: pools of mercury 1 m apart, 0.680, 0.595 and 0.496e-8 rad. Where they
   stood is not in the data at hand; with two unknowns for that, they follow to 0.8 %, not to their digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError
from ...core.estimate import Array
from .bodies import Body, G, positive

PANELS, NODES = 12, 16  # of the line between the pools, and of each
FLAT = 1e-6  # of the distance: by how much pools may differ in height


def surface_tilt(
    body: Body,
    shifts: ArrayLike,
    pools: ArrayLike,
    gravity: float = STANDARD_GRAVITY.value,
    gravitational_constant: float = G,
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> Array:
    """Return how much a liquid leans between two pools, for each position of a body.

    Parameters
    ----------
    body : Body
        What attracts, unshifted.
    shifts : array_like, shape (n, 3)
        Of the body [m].
    pools : array_like, shape (2, 3)
        Middles of both surfaces, in the frame of the body unshifted [m].
    gravity : float
        [m/s^2].
    gravitational_constant : float
        [m^3/s^2/kg].
    up : tuple of float
        Against gravity, of any length.

    Returns
    -------
    ndarray, shape (n,)
        Positive: higher at the second pool [rad].

    Raises
    ------
    DataError
        If shifts or pools are no triples of finite numbers, the pools are one place or differ in height, or gravity is
        not above zero.
    """
    positive("gravity", gravity)
    ends, moved = _triples(pools, "pools"), _triples(shifts, "shifts")
    line = _line(ends, np.array(up, dtype=float))
    at, weights = _along()
    places = (ends[0] + at[:, None] * line - moved[:, None, :]).reshape(-1, 3)
    found = gravitational_constant * body.field(np.ascontiguousarray(places)).reshape(len(moved), len(at), 3)
    mean: Array = np.einsum("nij,i,j->n", found, weights, line / np.linalg.norm(line))
    return mean / gravity


def _along() -> tuple[Array, Array]:
    """Places between 0 and 1, and weights that sum to one."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    starts = np.arange(PANELS)[:, None]
    return ((starts + (nodes + 1.0) / 2.0) / PANELS).ravel(), np.tile(weights / (2.0 * PANELS), PANELS)


def _line(ends: Array, up: Array) -> Array:
    """From the first pool to the second."""
    if len(ends) != 2:
        raise DataError(f"{len(ends)} pools: need 2 for a tilt", code="no_pools")
    line: Array = ends[1] - ends[0]
    length, height = float(np.linalg.norm(line)), float(np.linalg.norm(up))
    if length == 0.0 or height == 0.0:
        raise DataError(
            f"pools {length:g} m apart and a direction up of length {height:g}: both must be above zero",
            do="Give the middles of both surfaces.",
            code="no_pools",
        )
    rise = abs(float(line @ up)) / height
    if rise > FLAT * length:
        raise DataError(
            f"pools {length:g} m apart differ by {rise:g} m in height",
            why="connected pools are level",
            do="Give both at the height of the surface.",
            code="not_level",
        )
    return line


def _triples(given: ArrayLike, name: str) -> Array:
    """Rows of three finite numbers."""
    rows = np.atleast_2d(np.asarray(given, dtype=float))
    if rows.ndim != 2 or rows.shape[1] != len("xyz") or not np.isfinite(rows).all():
        raise DataError(f"{name} of shape {rows.shape} are not rows of three finite numbers [m]", code="no_points")
    return rows
