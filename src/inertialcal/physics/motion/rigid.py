"""What places of a rigid body feel.

A rigid body has at the place r the specific force::

    f(r) = f(0) + Gamma r          Gamma = [alpha x] + [omega x][omega x] - G

with its angular rate omega and acceleration alpha, and the gradient of gravity ``G = n^2 (3 u u' - 1)`` in a circular
orbit of the rate n, u the vertical [1]_.

References
----------
.. [1] M. H. Kaplan, Modern Spacecraft Dynamics and Control (1976), 5.2 (gravity gradient).
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array


def cross(vectors: Array) -> Array:
    """Return matrices of vector products, shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def centripetal(outer: Array) -> Array:
    """Return [omega x][omega x] of mean products of rates ``omega omega'``, shape (..., 3, 3)."""
    return np.asarray(outer - np.trace(outer, axis1=-2, axis2=-1)[..., None, None] * np.eye(3))


def gradient(rate: float, vertical: Array) -> Array:
    """Return the gradient of gravity in a circular orbit, shape (3, 3) [1/s^2]."""
    return np.asarray(rate**2 * (3.0 * np.outer(vertical, vertical) - np.eye(3)))
