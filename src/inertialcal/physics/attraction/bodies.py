"""Bodies that attract: point, sphere, cuboid, several together, and one moved and turned.

A body tells its field for a gravitational constant of one, ``integral of density (r' - r) / |r' - r|^3`` [kg/m^2], and
the gradient of that [kg/m^3], at points of its frame [m]. What the constant is, is not the body's to say.

On the surface of a body the gradient jumps: there the mean of both sides is told, and on edges and vertices, where it
has none, it is whatever the finite part of the closed form gives.

References
----------
.. [1] Nagy, Geophysics 31 (1966) 362: the closed form of a cuboid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from . import _kernels

SPHERE = 4.0 * math.pi / 3.0
PAIRS = ((0, 5, 4), (5, 1, 3), (4, 3, 2))  # where xx, yy, zz, yz, xz, xy stand in the matrix


class Body(Protocol):
    """Anything that attracts."""

    @property
    def mass(self) -> float:
        """All of it [kg]."""

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [m], for a gravitational constant of one [kg/m^2]."""

    def gradient(self, points: Array) -> Array:
        """Return its gradient, shape (n, 3, 3), for a gravitational constant of one [kg/m^3]."""


@dataclass(frozen=True)
class Point:
    """Mass in one place.

    Parameters
    ----------
    mass : float
        [kg].
    centre : tuple of float
        [m].
    """

    mass: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        finite("mass", self.mass)
        finite("centre of the point mass", *self.centre)

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2].

        Raises
        ------
        DataError
            At the point itself.
        """
        away, r = _apart(points, self.centre)
        if not r.all():
            raise DataError("the field of a point mass has no value in its own place", code="inside_point")
        return self.mass * away / r[:, None] ** 3

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]."""
        away, r = _apart(points, self.centre)
        if not r.all():
            raise DataError("the gradient of a point mass has no value in its own place", code="inside_point")
        unit = away / r[:, None]
        return self.mass * (3.0 * unit[:, :, None] * unit[:, None, :] - np.eye(3)) / r[:, None, None] ** 3


@dataclass(frozen=True)
class Sphere:
    """Uniform sphere; inside, only what lies deeper attracts.

    Parameters
    ----------
    mass : float
        [kg].
    radius : float
        [m].
    centre : tuple of float
        [m].
    """

    mass: float
    radius: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        finite("mass", self.mass)
        finite("centre of the sphere", *self.centre)
        positive("radius", self.radius)

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2]."""
        away, r = _apart(points, self.centre)
        pull: Array = self.mass * away / np.maximum(r, self.radius)[:, None] ** 3
        return pull

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]; on the surface that of outside."""
        away, r = _apart(points, self.centre)
        wide = np.maximum(r, self.radius)
        unit = away / wide[:, None]
        outside = np.where(r >= self.radius, 3.0, 0.0)[:, None, None]
        slope: Array = (
            self.mass * (outside * unit[:, :, None] * unit[:, None, :] - np.eye(3)) / wide[:, None, None] ** 3
        )
        return slope


@dataclass(frozen=True)
class Prism:
    """Uniform cuboid with edges along the axes [1]_.

    Parameters
    ----------
    lower, upper : tuple of float
        Opposite vertices [m].
    density : float
        [kg/m^3].
    """

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    density: float

    def __post_init__(self) -> None:
        finite("density", self.density)
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            positive(f"extent of the prism along {axis}", high - low)

    @property
    def mass(self) -> float:
        """All of it [kg]."""
        return self.density * math.prod(high - low for low, high in zip(self.lower, self.upper, strict=True))

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2]."""
        return self._found(points, 0)[0]

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]."""
        return matrix(self._found(points, 6)[1])

    def _found(self, points: Array, slopes: int) -> tuple[Array, Array]:
        """Field and, unless ``slopes`` is zero, its gradient."""
        low, high = np.array([self.lower]), np.array([self.upper])
        field, slope = np.empty((len(points), 3)), np.empty((len(points), slopes))
        _kernels.cuboids(points, (low + high) / 2.0, high - low, np.array([self.density]), field, slope)
        return field, slope


@dataclass(frozen=True)
class Composite:
    """Several bodies together.

    Parameters
    ----------
    bodies : tuple of Body
        Their fields add; whether they overlap is not looked at.
    """

    bodies: tuple[Body, ...]

    @property
    def mass(self) -> float:
        """All of it [kg]."""
        return math.fsum(body.mass for body in self.bodies)

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2]."""
        return np.sum([body.field(points) for body in self.bodies], axis=0)  # type: ignore[no-any-return]

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]."""
        return np.sum([body.gradient(points) for body in self.bodies], axis=0)  # type: ignore[no-any-return]


@dataclass(frozen=True, eq=False)
class Placed:
    """A body turned about the origin of its frame, and then moved.

    Parameters
    ----------
    body : Body
        In its own frame.
    shift : tuple of float
        Where the origin of its frame comes to lie [m].
    C_world_body : ndarray, shape (3, 3), optional
        Takes directions of the body's frame to the world's; default: not turned.
    """

    body: Body
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    C_world_body: Array | None = None

    @property
    def mass(self) -> float:
        """All of it [kg]."""
        return self.body.mass

    def field(self, points: Array) -> Array:
        """Return the field at points of the world, shape (n, 3) [kg/m^2]."""
        C = self._turn()
        return self.body.field(np.ascontiguousarray((points - np.array(self.shift)) @ C)) @ C.T

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points of the world, shape (n, 3, 3) [kg/m^3]."""
        C = self._turn()
        found = self.body.gradient(np.ascontiguousarray((points - np.array(self.shift)) @ C))
        return np.einsum("ij,njk,lk->nil", C, found, C)  # type: ignore[no-any-return]

    def _turn(self) -> Array:
        """Return the matrix that turns."""
        return np.eye(3) if self.C_world_body is None else self.C_world_body


def positive(what: str, value: float) -> None:
    """Refuse what is not a finite number above zero.

    Raises
    ------
    DataError
        With its name and value.
    """
    finite(what, value)
    if not value > 0.0:
        raise DataError(f"{what} {value:g} is not above zero", code="no_extent")


def finite(what: str, *values: float) -> None:
    """Refuse what is not finite.

    Raises
    ------
    DataError
        With its name and value.
    """
    for value in values:
        if not math.isfinite(value):
            raise DataError(f"{what} {value:g} is not finite", code="not_finite")


def slipped(length: float, largest: float) -> str:
    """Return a hint where a length [m] looks as if it had been given in another unit, empty where it does not.

    Parameters
    ----------
    length : float
        As given.
    largest : float
        The most that it can be.
    """
    for unit, factor in (("cm", 1e-2), ("mm", 1e-3)):
        if 0.0 < length * factor <= largest:
            return f"If {length:g} {unit} was meant, give {length * factor:g} m."
    return ""


def matrix(slope: Array) -> Array:
    """Return symmetric matrices, shape (n, 3, 3), from xx, yy, zz, yz, xz, xy, shape (n, 6)."""
    return slope[:, np.array(PAIRS)]


def _apart(points: Array, centre: tuple[float, float, float]) -> tuple[Array, Array]:
    """Vectors from points to a centre, and their lengths, without loss for the smallest."""
    away = np.array(centre) - points
    return away, np.hypot(np.hypot(away[:, 0], away[:, 1]), away[:, 2])
