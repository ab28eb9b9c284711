"""Right circular cylinder, solid or hollow: field and gradient anywhere, on its surface too.

Near, the volume integral is reduced to one over the angle ``phi`` along the rim, with ``rho^2 = a^2 + r^2 -
2 a r cos phi`` and an end at height ``zeta`` over the point; along the axis and outward from it::

    g_z = [ integral (a^2 - a r cos phi) / (d + |zeta|) dphi ] of the near less the far end      d^2 = rho^2 + zeta^2
    g_r = [ integral a^2 r sin^2 phi / rho^2 * zeta / d dphi ] of the lower less the upper end

Both are bounded everywhere. Where the point comes close to the wall they bend sharply at ``phi = 0``: the angle is cut
in halves toward it, with Gauss and Legendre in each part, so that only the logarithm of the closeness costs. Far away,
where the two ends cancel, the volume is summed by Gauss and Legendre in height and squared radius, and evenly in angle.

A hollow cylinder is the outer one less the inner.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .axial import about_axis, direction, symmetric_gradient
from .bodies import finite, positive

FAR = 10.0  # half diagonals from the centre
HALVINGS, NODES = 48, 20  # of the angle, and of each part
HEIGHTS, RADII, ANGLES = 10, 6, 24  # of a far cylinder
PARTS = 4096  # points that are worked on at a time


@dataclass(frozen=True, eq=False)
class Cylinder:
    """Uniform cylinder about an axis; with an inner radius, a tube or a ring with a section.

    Parameters
    ----------
    mass : float
        [kg].
    radius, length : float
        [m].
    inner_radius : float
        Zero: solid [m].
    centre : tuple of float
        [m].
    axis : tuple of float
        Direction, of any length.

    Raises
    ------
    DataError
        If a length is not above zero, the inner radius is not below the outer, or the axis has no direction.
    """

    mass: float
    radius: float
    length: float
    inner_radius: float = 0.0
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        finite("mass", self.mass)
        finite("centre of the cylinder", *self.centre)
        positive("radius", self.radius)
        positive("length", self.length)
        if not 0.0 <= self.inner_radius < self.radius:
            raise DataError(
                f"inner radius {self.inner_radius:g} m is not between 0 and the radius, {self.radius:g} m",
                code="no_extent",
            )
        direction(self.axis)

    @property
    def density(self) -> float:
        """Of its material [kg/m^3]."""
        return self.mass / (math.pi * (self.radius**2 - self.inner_radius**2) * self.length)

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2]."""
        r, z, out, along = about_axis(points, self.centre, self.axis)
        g_r, g_z = self._summed(_field, r, z)
        pull: Array = g_r[:, None] * out + g_z[:, None] * along
        return pull

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]; on the surface the mean of both sides."""
        r, z, out, along = about_axis(points, self.centre, self.axis)
        return symmetric_gradient(self._summed(_gradient, r, z), out, along)

    def _summed(self, found: Callable[[float, float, Array, Array], Array], r: Array, z: Array) -> Array:
        """Outer less inner cylinder of this density, shape (components, n)."""
        parts = []
        for start in range(0, len(r), PARTS):
            rows = slice(start, start + PARTS)
            whole = found(self.radius, self.length, r[rows], z[rows])
            if self.inner_radius > 0.0:
                whole = whole - found(self.inner_radius, self.length, r[rows], z[rows])
            parts.append(whole)
        return self.density * np.concatenate(parts, axis=1)


@cache
def _angles() -> tuple[Array, Array]:
    """Angles from 0 to pi, denser and denser toward 0, and their weights (for the whole turn)."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    ends = np.concatenate([math.pi * 0.5 ** np.arange(HALVINGS), [0.0]])
    middles, halves = (ends[:-1] + ends[1:]) / 2.0, (ends[:-1] - ends[1:]) / 2.0
    return (middles[:, None] + halves[:, None] * nodes).ravel(), 2.0 * (halves[:, None] * weights).ravel()


def _rim(a: float, r: Array) -> tuple[Array, Array, Array, Array]:
    """Weights, rho^2, a^2 - a r cos phi and a^2 r sin^2 phi along the rim, without cancellation, shape (n, angles)."""
    phi, weight = _angles()
    s = np.sin(phi / 2.0) ** 2
    r = r[:, None]
    rho_2 = (a - r) ** 2 + 4.0 * a * r * s
    return weight, rho_2, a * (a - r) + 2.0 * a * r * s, a * a * r * np.sin(phi) ** 2


def _field(a: float, length: float, r: Array, z: Array) -> Array:
    """Outward and axial field of a solid cylinder of density one, shape (2, n)."""
    far = np.hypot(r, z) > FAR * math.hypot(a, length / 2.0)
    found = np.empty((2, len(r)))
    found[:, far] = _far_field(a, length, r[far], z[far])
    found[:, ~far] = _near_field(a, length, r[~far], z[~far])
    return found


def _near_field(a: float, length: float, r: Array, z: Array) -> Array:
    """From the rim."""
    weight, rho_2, disc, wall = _rim(a, r)
    out = np.zeros(len(r))
    up = np.zeros(len(r))
    for sign in (1.0, -1.0):  # upper end, lower end
        zeta = (sign * length / 2.0 - z)[:, None]
        d = np.sqrt(rho_2 + zeta**2)
        up -= sign * (disc / (d + np.abs(zeta))) @ weight
        out -= sign * (wall / rho_2 * (zeta / d)) @ weight
    return np.stack([out, up])


def _gradient(a: float, length: float, r: Array, z: Array) -> Array:
    """Radial, tangential, axial and mixed gradient of a solid cylinder of density one, shape (4, n)."""
    far = np.hypot(r, z) > FAR * math.hypot(a, length / 2.0)
    found = np.empty((4, len(r)))
    found[:, far] = _far_gradient(a, length, r[far], z[far])
    found[:, ~far] = _near_gradient(a, length, r[~far], z[~far])
    return found


def _near_gradient(a: float, length: float, r: Array, z: Array) -> Array:
    """From the rim: axial and mixed; tangential is outward over r, and the trace is that of the density."""
    weight, rho_2, disc, wall = _rim(a, r)
    zz, rz, over_r = np.zeros(len(r)), np.zeros(len(r)), np.zeros(len(r))
    phi, _ = _angles()
    for sign in (1.0, -1.0):
        zeta = (sign * length / 2.0 - z)[:, None]
        d = np.sqrt(rho_2 + zeta**2)
        zz -= sign * np.sign(zeta[:, 0]) * ((disc / (d * (d + np.abs(zeta)))) @ weight)
        rz += sign * ((wall / d**3) @ weight)
        over_r -= sign * ((a * a * np.sin(phi) ** 2 / rho_2 * (zeta / d)) @ weight)
    inside = _half_inside(r - a) * _half_inside(np.abs(z) - length / 2.0)
    rr = -zz - over_r - 4.0 * math.pi * inside
    return np.stack([rr, over_r, zz, rz])


def _half_inside(beyond: Array) -> Array:
    """One inside, a half on the surface, zero outside."""
    return 0.5 * (1.0 - np.sign(beyond))


@cache
def _volume() -> tuple[Array, Array, Array, Array]:
    """Heights, radii and angles of a cylinder of radius and half length one, and weights that sum to one."""
    h, w_h = np.polynomial.legendre.leggauss(HEIGHTS)
    u, w_u = np.polynomial.legendre.leggauss(RADII)
    phi = (np.arange(ANGLES) + 0.5) * 2.0 * math.pi / ANGLES
    heights, radii, angles = np.meshgrid(h, np.sqrt((u + 1.0) / 2.0), phi, indexing="ij")
    weights = np.einsum("i,j,k->ijk", w_h / 2.0, w_u / 2.0, np.full(ANGLES, 1.0 / ANGLES))
    return heights.ravel(), radii.ravel(), angles.ravel(), weights.ravel()


def _offsets(a: float, length: float, r: Array, z: Array) -> tuple[Array, Array, Array, Array]:
    """Offsets of the points of the volume: outward, aside, along; and their masses."""
    heights, radii, angles, weights = _volume()
    x = a * radii * np.cos(angles) - r[:, None]
    y = np.broadcast_to(a * radii * np.sin(angles), x.shape)
    return x, y, length / 2.0 * heights - z[:, None], weights * math.pi * a * a * length


def _far_field(a: float, length: float, r: Array, z: Array) -> Array:
    """From the volume."""
    x, y, h, mass = _offsets(a, length, r, z)
    w = mass / (x * x + y * y + h * h) ** 1.5
    return np.stack([np.sum(w * x, axis=1), np.sum(w * h, axis=1)])


def _far_gradient(a: float, length: float, r: Array, z: Array) -> Array:
    """From the volume."""
    x, y, h, mass = _offsets(a, length, r, z)
    d_2 = x * x + y * y + h * h
    w = mass / d_2**2.5
    return np.stack(
        [np.sum(w * part, axis=1) for part in (3 * x * x - d_2, 3 * y * y - d_2, 3 * h * h - d_2, 3 * x * h)]
    )
