"""Bodies that attract: one cuboid, and many equal cells.

A body gives its field for a gravitational constant of one, ``integral of density (r' - r) / |r' - r|^3`` [kg/m^2], and
the gradient of that [kg/m^3], at points of its frame [m]; the constant is the caller's, because a document is repeated
with its own (Reinel's is 6.5e-4 less than today's). The field is the acceleration of a free body: it points to what
attracts, and an accelerometer held at rest reads the opposite. On the surface of a body the gradient jumps: it is the
mean of both sides there, and on edges and vertices, where it has no value, the finite part of the closed form.

The closed form of a cuboid [1]_ is a sum over its vertices. Neighbours share theirs, so that a body on a lattice is a
sum over the vertices of the lattice, each weighted with the mixed third difference of density there: an eighth of the
evaluations, and none inside uniform material, where the difference is exactly zero. Only the corners and edges of the
staircase that bounds the body are left.

Far away the vertices cancel: their sum is wrong by the rounding of one term, about ``eps R``, over a result that falls
as ``1 / R^2``. Where that may pass 5e-13 of the smallest that the magnitudes of all cells' attractions can add up to,
cells are summed one by one, in closed form near and by Gauss and Legendre far (module ``_kernels``).

References
----------
.. [1] Nagy, Geophysics 31 (1966) 362: the closed form of a cuboid.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from os import cpu_count
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.errors import DataError
from ...core.estimate import Array
from . import _kernels, _kernels_prisms, _kernels_vertices

G = GRAVITATIONAL_CONSTANT.value  # [m^3/s^2/kg]
PAIRS = ((0, 5, 4), (5, 1, 3), (4, 3, 2))  # where xx, yy, zz, yz, xz, xy stand in the matrix
ROUNDED = 8.0 * np.finfo(float).eps  # of one vertex's term, with its logarithms
ALLOWED = 5e-13  # of the sum of the magnitudes of all cells' attractions
SMALL = 100_000  # vertices times points up to which one processor is quicker than two
EXACT = 8  # vertices that a cell takes for itself
PARTS = 4  # slices a processor

T = TypeVar("T")


class Body(Protocol):
    """Anything that attracts."""

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [m], for a gravitational constant of one [kg/m^2]."""


@dataclass(frozen=True)
class Prism:
    """Uniform cuboid with edges along the axes [1]_."""

    # lower, upper: opposite vertices [m]
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    density: float  # [kg/m^3]

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
        field = np.empty((len(points), 3))

        def part(rows: slice) -> None:
            _kernels_prisms.prisms(points[rows], *self._shape, field[rows])

        _spread(part, len(points), EXACT)
        return field

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]."""
        slope = np.empty((len(points), 6))
        _kernels.cuboids(points, *self._shape, np.empty((len(points), 3)), slope)
        return matrix(slope)

    @property
    def _shape(self) -> tuple[Array, Array, Array]:
        """Centre, edges and density, one row each."""
        low, high = np.array([self.lower]), np.array([self.upper])
        return (low + high) / 2.0, high - low, np.array([self.density])


@dataclass(frozen=True, eq=False)
class Lattice:
    """Body of equal cuboid cells.

    Raises
    ------
    DataError
        If the density is not a lattice of finite numbers, or an edge is not above zero.
    """

    density: Array  # of each cell; zero where there is none [kg/m^3], shape (nx, ny, nz)
    edges: tuple[float, float, float]  # of a cell [m]
    lower: tuple[float, float, float] = (0.0, 0.0, 0.0)  # vertex of the first cell, with the smallest coordinates [m]

    def __post_init__(self) -> None:
        if self.density.ndim != len("xyz") or not np.isfinite(self.density).all():
            raise DataError(
                f"density of shape {self.density.shape} is not a lattice of finite numbers: need nx x ny x nz",
                code="no_lattice",
            )
        finite("lower vertex of the lattice", *self.lower)
        for axis, edge in zip("xyz", self.edges, strict=True):
            positive(f"edge of a cell along {axis}", edge)

    @property
    def mass(self) -> float:
        """All of it [kg]."""
        return math.fsum(self.density.ravel()) * math.prod(self.edges)

    @cached_property
    def vertices(self) -> tuple[Array, Array]:
        """Places (3, m) [m] and weights (m,) [kg/m^3] of the vertices whose weight is not zero."""
        weight = np.pad(self.density.astype(float), 1)
        for axis in range(3):
            weight = -np.diff(weight, axis=axis)
        at = np.nonzero(weight)
        places = np.stack([self.lower[i] + at[i] * self.edges[i] for i in range(3)])
        return np.ascontiguousarray(places), weight[at]

    @cached_property
    def cells(self) -> tuple[Array, Array]:
        """Centres (n, 3) [m] and densities (n,) [kg/m^3] of the cells that are not empty."""
        at = np.nonzero(self.density)
        centres = np.stack([self.lower[i] + (at[i] + 0.5) * self.edges[i] for i in range(3)], axis=1)
        return np.ascontiguousarray(centres), self.density[at].astype(float)

    @cached_property
    def _reach(self) -> float:
        """Farthest offset [m] up to which the sum over vertices is right."""
        weight = math.sqrt(float(np.sum(self.vertices[1] ** 2)))
        all_of_it = float(np.sum(np.abs(self.cells[1]))) * math.prod(self.edges)
        return 0.0 if weight == 0.0 else float(np.cbrt(ALLOWED * all_of_it / (ROUNDED * weight)))

    def field(self, points: Array) -> Array:
        """Return the field at points, shape (n, 3) [kg/m^2]; rightly on faces, edges and vertices too."""
        places, weight = self.vertices
        field = np.zeros((len(points), 3))
        if not len(weight):
            return field

        def part(rows: slice) -> int:
            return int(
                _kernels_vertices.vertices(points[rows], places, weight, self._corners, self._reach, field[rows])
            )

        if sum(_spread(part, len(points), len(weight))):
            self._one_by_one(points, np.isnan(field[:, 0]), field, np.empty((len(points), 0)))
        return field

    def gradient(self, points: Array) -> Array:
        """Return the gradient at points, shape (n, 3, 3) [kg/m^3]."""
        slope = np.zeros((len(points), 6))
        if not len(self.vertices[1]):
            return matrix(slope)
        near = self._near(points)
        rows = np.flatnonzero(near)

        def part(some: slice) -> None:
            for i in rows[some]:
                _kernels.vertices_gradient(points[i], *self.vertices, slope[i])

        _spread(part, len(rows), len(self.vertices[1]))
        self._one_by_one(points, ~near, np.empty((len(points), 3)), slope)
        return matrix(slope)

    def each(self, point: Array) -> Array:
        """Return the field of each cell, empty or not, as if its density were one, shape (nx, ny, nz, 3) [m].

        Parameters
        ----------
        point : ndarray, shape (3,)
            Where [m].
        """
        grids = np.meshgrid(
            *(self.lower[i] + (np.arange(self.density.shape[i]) + 0.5) * self.edges[i] for i in range(3)),
            indexing="ij",
        )
        centres = np.stack([grid.ravel() for grid in grids], axis=1)
        field = np.empty_like(centres)
        edges = np.array(self.edges)

        def part(rows: slice) -> None:
            _kernels.each(point, centres[rows], edges, field[rows])

        _spread(part, len(centres), EXACT)
        return field.reshape(*self.density.shape, 3)

    @cached_property
    def _corners(self) -> Array:
        """Smallest and largest coordinates of the body, shape (2, 3) [m]."""
        return np.stack([self.vertices[0].min(axis=1), self.vertices[0].max(axis=1)])

    def _near(self, points: Array) -> NDArray[np.bool_]:
        """Whether vertices may be summed: the farthest corner of the body is within reach."""
        low, high = self._corners
        farthest = np.maximum(np.abs(low - points), np.abs(high - points))
        return np.asarray(np.linalg.norm(farthest, axis=1) <= self._reach)

    def _one_by_one(self, points: Array, which: NDArray[np.bool_], field: Array, slope: Array) -> None:
        """Fill the rows of points that are far with the sum over cells."""
        far = np.flatnonzero(which)
        centres, density = self.cells
        edges = np.broadcast_to(np.array(self.edges), centres.shape)

        def part(some: slice) -> None:
            for i in far[some]:
                rows = slice(i, i + 1)
                _kernels.cuboids(points[rows], centres, edges, density, field[rows], slope[rows])

        _spread(part, len(far), EXACT * len(density))


def _spread(work: Callable[[slice], T], count: int, terms: int) -> list[T]:
    """Do a work on slices of so many things of so many terms; side by side where that pays, as starting threads costs.

    What comes out does not depend on how many there are: things do not meet.
    """
    if count <= 1 or count * terms <= SMALL:
        return [work(slice(0, count))]
    size = -(-count // (PARTS * (cpu_count() or 1)))
    slices = [slice(start, min(start + size, count)) for start in range(0, count, size)]
    with ThreadPoolExecutor(cpu_count()) as pool:
        return list(pool.map(work, slices))


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
