"""Thin circular ring: field and gradient by complete elliptic integrals.

A ring of radius a and mass m has at the distance r from its axis and the height z over its plane the potential [1]_::

    U = 2 m K / (pi p)      p^2 = (a + r)^2 + z^2,  q^2 = (a - r)^2 + z^2,  k^2 = 4 a r / p^2 = 1 - q^2 / p^2

and, outward and along the axis, the field::

    g_r = -2 m / (pi p) [ 2 a D / p^2 - (a - r) E / q^2 ]        g_z = -2 m z E / (pi p q^2)

with ``D = (K - E) / k^2``. The usual form of g_r has r in its denominator; with D for K it cancels, so that the axis is
no exception. For the same reason the tangential gradient, g_r / r, takes the slope of D to k^2::

    g_r / r = m / pi [ 16 a^2 D' / p^5 - 2 E / (p q^2) ]

E and D are Carlson's symmetric integrals of ``q^2 / p^2``, which keep their digits at the axis and at the ring [2]_. A
ring has no width: on its line the field has no value. One of some width is a `Cylinder` with an inner radius, which far
from its section goes over into the ring.

References
----------
.. [1] MacMillan, The Theory of the Potential, 1930, section 102.
.. [2] NIST Digital Library of Mathematical Functions, 19.25.1: K, E and D by R_F and R_D.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from .axial import about_axis, direction, symmetric_gradient
from .bodies import finite, positive

SERIES = 0.5  # k^2 below which the slope of D is summed as a hypergeometric series: its closed form cancels


@dataclass(frozen=True)
class Ring:
    """Mass on a circle.

    Parameters
    ----------
    mass : float
        [kg].
    radius : float
        [m].
    centre : tuple of float
        [m].
    axis : tuple of float
        Direction, of any length.

    Raises
    ------
    DataError
        If the radius is not above zero, or the axis has no direction.
    """

    mass: float
    radius: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        finite("mass", self.mass)
        finite("centre of the ring", *self.centre)
        positive("radius", self.radius)
        direction(self.axis)

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2].

        Raises
        ------
        DataError
            On the ring itself.
        """
        r, z, out, along = about_axis(points, self.centre, self.axis)
        p, q_2, y = self._distances(r, z)
        D, E = _integrals(y)
        a = self.radius
        g_r = -2.0 / p * (2.0 * a * D / p**2 - (a - r) * E / q_2)
        g_z = -2.0 * z * E / (p * q_2)
        pull: Array = self.mass / math.pi * (g_r[:, None] * out + g_z[:, None] * along)
        return pull

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3].

        Raises
        ------
        DataError
            On the ring itself.
        """
        r, z, out, along = about_axis(points, self.centre, self.axis)
        p, q_2, y = self._distances(r, z)
        D, E = _integrals(y)
        a, k_2, slope = self.radius, 1.0 - y, _slope(y, D, E)
        cube = 4.0 * E / (p * q_2)  # integral of d^-3, d the distance to the ring, over its angle
        fifth = 4.0 / p**5 * (2.0 * (1.0 + y) * E - y * (E + k_2 * D)) / (3.0 * y**2)  # of d^-5
        tangential = 32.0 * a**2 * slope / p**5 - cube
        axial = 3.0 * z**2 * fifth - cube
        mixed = -3.0 * z * ((a - r) * fifth - 8.0 * a / p**5 * (D + k_2 * slope / 1.5))
        parts = self.mass / (2.0 * math.pi) * np.stack([-tangential - axial, tangential, axial, mixed])
        return symmetric_gradient(parts, out, along)

    def _distances(self, r: Array, z: Array) -> tuple[Array, Array, Array]:
        """Farthest distance to the ring, square of the nearest, and the ratio of their squares."""
        p = np.hypot(self.radius + r, z)
        q = np.hypot(self.radius - r, z)
        if not q.all():
            raise DataError(
                "the field of a thin ring has no value on the ring itself",
                do="Take a cylinder with an inner radius.",
                code="inside_ring",
            )
        return p, q**2, (q / p) ** 2


def _integrals(y: Array) -> tuple[Array, Array]:
    """D and E, of 1 - k^2."""
    D = special.elliprd(0.0, y, 1.0) / 3.0
    return D, y * (D + special.elliprd(0.0, 1.0, y) / 3.0)


def _slope(y: Array, D: Array, E: Array) -> Array:
    """Slope of D to k^2."""
    m = 1.0 - y
    series = math.pi / 4.0 * 3.0 / 8.0 * special.hyp2f1(1.5, 2.5, 3.0, np.minimum(m, SERIES))
    safe = np.maximum(m, SERIES)
    K = E + m * D
    closed = ((E - y * K) / (2.0 * y) - (E - K) / 2.0 - (K - E)) / safe**2
    return np.asarray(np.where(m < SERIES, series, closed))
