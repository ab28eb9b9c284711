"""Attraction of a proof mass that is no point: the mean of the field over it.

What moves a rigid proof mass is the mean of the field over its mass. A cylinder, solid or a shell, is summed by Gauss
and Legendre along its axis, by radius, and evenly about it.

To second order the mean differs from the value at the centre by [1]_::

    1/2 f_aa [ L^2 / 12 - (r_i^2 + r_o^2) / 4 ]

for each component f of the field, as it is harmonic; f_aa its second derivative along the axis. The bracket vanishes
for ``L^2 = 3 (r_i^2 + r_o^2)``, for a solid cylinder ``L = sqrt(3) R``: such a proof mass is a point to fourth order.

References
----------
.. [1] The moments of a cylinder about its centre are L^2 / 12 along and (r_i^2 + r_o^2) / 4 across; outside of all
   sources the Laplacian of each component is zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .bodies import Body, positive

ALONG, RADII, AROUND = 16, 6, 24
SURFACE = 1.0 - 1e-12  # of the outer radius: from where a shell is one radius


@dataclass(frozen=True)
class ProofMass:
    """Cylinder whose acceleration is measured.

    Raises
    ------
    DataError
        If a length is not above zero, the inner radius is above the outer, or the axis has no direction.
    """

    # length, radius: [m]
    length: float
    radius: float
    inner_radius: float = 0.0  # equal to the radius: a thin shell. Zero: solid [m]
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)  # direction

    def __post_init__(self) -> None:
        positive("length of the proof mass", self.length)
        positive("radius of the proof mass", self.radius)
        if not 0.0 <= self.inner_radius <= self.radius:
            raise DataError(
                f"inner radius {self.inner_radius:g} m is not between 0 and the radius, {self.radius:g} m",
                code="no_extent",
            )
        if not 0.0 < math.hypot(*self.axis) < math.inf:
            raise DataError(f"axis {self.axis} has no direction", code="no_direction")

    def points(self) -> tuple[Array, Array]:
        """Return places about its centre (n, 3) [m], and weights that sum to one, shape (n,)."""
        h, w_h = np.polynomial.legendre.leggauss(ALONG)
        s, w_s = _radii(self.inner_radius, self.radius)
        phi = (np.arange(AROUND) + 0.5) * 2.0 * math.pi / AROUND
        along, s, phi = np.meshgrid(self.length / 2.0 * h, s, phi, indexing="ij")
        weights = np.einsum("i,j,k->ijk", w_h / 2.0, w_s, np.full(AROUND, 1.0 / AROUND))
        axis = np.array(self.axis) / math.hypot(*self.axis)
        one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        one /= np.linalg.norm(one)
        frame = np.stack([axis, one, np.cross(axis, one)])
        places = np.stack([along.ravel(), (s * np.cos(phi)).ravel(), (s * np.sin(phi)).ravel()], axis=1) @ frame
        return np.ascontiguousarray(places), weights.ravel()

    @property
    def second_order(self) -> float:
        """The bracket of the rule, ``L^2 / 12 - (r_i^2 + r_o^2) / 4`` [m^2]; zero: a point to fourth order."""
        return self.length**2 / 12.0 - (self.inner_radius**2 + self.radius**2) / 4.0

    @property
    def pointlike_length(self) -> float:
        """Length that the same radii would need to act as a point [m]."""
        return math.sqrt(3.0 * (self.inner_radius**2 + self.radius**2))


def mean_field(body: Body, proof_mass: ProofMass, centres: Array) -> Array:
    """Return the field of a body, averaged over a proof mass.

    Parameters
    ----------
    body : Body
        What attracts.
    proof_mass : ProofMass
        What is attracted.
    centres : ndarray, shape (n, 3)
        Where its centre is [m].

    Returns
    -------
    ndarray, shape (n, 3)
        For a gravitational constant of one [kg/m^2].
    """
    places, weights = proof_mass.points()
    found = body.field(np.ascontiguousarray((centres[:, None, :] + places).reshape(-1, 3)))
    return np.einsum("nij,i->nj", found.reshape(len(centres), len(places), 3), weights)  # type: ignore[no-any-return]


def _radii(inner: float, outer: float) -> tuple[Array, Array]:
    """Radii of the rings, evenly in squared radius, and their weights."""
    if inner >= SURFACE * outer:
        return np.array([outer]), np.array([1.0])
    u, w = np.polynomial.legendre.leggauss(RADII)
    return np.sqrt(inner**2 + (outer**2 - inner**2) * (u + 1.0) / 2.0), w / 2.0
