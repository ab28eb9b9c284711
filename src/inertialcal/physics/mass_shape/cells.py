"""The best body of cells on a grid: so many, or up to a weight.

Cells of one size and density are taken in the order of their gain, which is exactly optimal. Cells of equal gain are
taken in the order of the grid.

What a cell of material is worth: its attraction along an axis, or the change of it over a stroke.

Both are linear in the density of each cell, so that the best body of equal cells is that of the most valuable ones.

A body that is moved by s away from a point attracts it as a body at rest attracts the point moved by -s.

The best body from what there is: cubes of several sizes, each a whole number of cells long.

Sizes are placed from the largest to the smallest, each on the grid of its own size, in the order of gain among the
places that are free. That need not be optimal; how far it may be from it is told by the body of as many single cells,
which no inventory of the same material can beat.

How attraction grows with mass: the touching sphere and the best body side by side (Reinel, Figure 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice, finite, positive, slipped
from ..attraction.extended import ProofMass
from .bound import Keep, largest_field

DENSEST = 23000.0  # kg/m^3: no metal is denser than osmium, 22,590
LARGEST_EDGE, LARGEST_STAND_OFF = 1.0, 5.0  # m: above, centimetres were given
LIGHTEST = 100.0  # kg/m^3, of balsa: below it a density was given in g/cm^3
Direction = tuple[float, float, float]
HERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Gain:
    """What is to be as large as possible."""

    axis: Direction = (1.0, 0.0, 0.0)  # input axis of the instrument
    # weights of the positions, and how far the body is shifted there [m]: one of weight 1 for the attraction itself; 1
    # and -1 for its change over a stroke
    at: Sequence[tuple[float, Direction]] = field(default=((1.0, HERE),))
    proof_mass: ProofMass | None = None  # what is attracted; default: a point

    def worth_of_cells(self, grid: Lattice) -> Array:
        """Return what each cell adds if its density is one, shape (nx, ny, nz) [m].

        Parameters
        ----------
        grid : Lattice
            Where cells can be, with the point at the origin; its density is not looked at.

        Raises
        ------
        DataError
            If the cells would overlap the proof mass at one of the positions.
        """
        axis = self._unit()
        self._refuse_overlap(grid)
        return np.sum([w * (grid.each(place) @ axis) for w, place in self._places()], axis=0)  # type: ignore[no-any-return]

    def of(self, body: Lattice) -> float:
        """Return the gain of a body, for a gravitational constant of one [kg/m^2]."""
        places = self._places()
        fields = body.field(np.ascontiguousarray([place for _, place in places])) @ self._unit()
        return float(np.sum(np.array([w for w, _ in places]) * fields))

    def _refuse_overlap(self, grid: Lattice) -> None:
        """Refuse cells around a part of the proof mass, at any position."""
        low = np.array(grid.lower)
        high = low + np.array(grid.density.shape) * np.array(grid.edges)
        points = np.stack([place for _, place in self._places()])
        inside = ((points > low) & (points < high)).all(axis=1)
        if inside.any():
            x, y, z = points[int(np.argmax(inside))]
            raise DataError(
                f"the mass would overlap the instrument: the place ({x:.4g}, {y:.4g}, {z:.4g}) m of its proof mass, "
                f"as seen from the mass, is inside its cells",
                why="material around the proof mass does not pull it to either side",
                do="Raise the stand-off above half of the proof mass's extent, or shorten the shift toward it.",
                code="overlap",
            )

    def _unit(self) -> Array:
        """Axis of length one."""
        axis = np.array(self.axis, dtype=float)
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise DataError(f"axis {self.axis} has no direction", code="no_direction")
        return axis / length

    def _places(self) -> list[tuple[float, Array]]:
        """Weights and places at which the field counts."""
        points, shares = (np.zeros((1, 3)), np.ones(1)) if self.proof_mass is None else self.proof_mass.points()
        return [
            (w * share, point - np.array(shift))
            for w, shift in self.at
            for point, share in zip(points, shares, strict=True)
        ]


PLAIN = Gain()


def change(stroke: Direction, axis: Direction = (1.0, 0.0, 0.0), start: Direction = HERE) -> Gain:
    """Return the change of attraction when the body is shifted by ``stroke`` from ``start`` [m]."""
    end = tuple(a + b for a, b in zip(start, stroke, strict=True))
    return Gain(axis, ((1.0, start), (-1.0, end)))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Grid:
    """Where cells can be: a cuboid of cells, its face at a stand-off from the point, which is the origin.

    Raises
    ------
    DataError
        If a length is not above zero, the mass would overlap the point, or no material is that dense.
    """

    edge: float  # of a cell [m]
    shape: tuple[int, int, int]  # number of cells along x, y and z; y and z lie symmetrically about the x axis
    stand_off: float  # between the point and the face of the first cells, along x [m]
    density: float  # of the material [kg/m^3]

    def __post_init__(self) -> None:
        positive("edge of a cell", self.edge)
        finite("stand-off", self.stand_off)
        self._refuse_slips()
        if not self.stand_off > 0.0:
            raise DataError(
                f"stand-off {self.stand_off:g} m: the mass would overlap the instrument",
                why="material at the point of measurement does not pull it to either side",
                do="Give the distance from the proof mass to the nearest face of the mass.",
                code="overlap",
            )
        if not LIGHTEST <= self.density <= DENSEST:
            raise DataError(
                f"density {self.density:g} kg/m^3: materials lie between {LIGHTEST:g} and {DENSEST:g} kg/m^3",
                do="Lead is 11340 kg/m^3 (11.34 g/cm^3), tungsten 19300 kg/m^3.",
                code="absurd_density",
            )

    def _refuse_slips(self) -> None:
        """Refuse sizes that no laboratory has, and a grid without cells."""
        sizes = {"edge of a cell": (self.edge, LARGEST_EDGE), "stand-off": (self.stand_off, LARGEST_STAND_OFF)}
        for name, (size, largest) in sizes.items():
            if size > largest:
                raise DataError(
                    f"{name} {size:g} m: more than {largest:g} m is not a laboratory source mass",
                    why="lengths are in metres",
                    do=slipped(size, largest),
                    code="absurd_length",
                )
        if len(self.shape) != len("xyz") or min(self.shape) < 1:
            raise DataError(
                f"a grid of {' x '.join(str(n) for n in self.shape)} cells is empty",
                do="Give three numbers of one or more.",
                code="no_cells",
            )

    @property
    def cell_mass(self) -> float:
        """Of one cell [kg]."""
        return self.density * self.edge**3

    def lattice(self, chosen: Array | None = None) -> Lattice:
        """Return the lattice with the chosen cells filled; default: none."""
        n = self.shape
        lower = (self.stand_off, -n[1] * self.edge / 2.0, -n[2] * self.edge / 2.0)
        density = np.zeros(n) if chosen is None else self.density * chosen
        return Lattice(density, (self.edge,) * 3, lower)


def most_in_weight(grid: Grid, mass: float) -> int:
    """Return how many cells a weight allows.

    Raises
    ------
    DataError
        If not even one.
    """
    count = math.floor(mass / grid.cell_mass * (1.0 + 1e-12))
    if count < 1:
        raise DataError(
            f"{mass:g} kg is less than one cell, {grid.cell_mass:g} kg",
            do="Allow more, or cut smaller.",
            code="no_cell",
        )
    return count


def best_cells(grid: Grid, count: int, gain: Gain = PLAIN) -> Lattice:
    """Return the body of so many cells with the largest gain.

    Parameters
    ----------
    grid : Grid
        Where they can be.
    count : int
        How many.
    gain : Gain
        Default: attraction along x.

    Raises
    ------
    DataError
        If the grid does not hold that many.
    """
    places = math.prod(grid.shape)
    if not 1 <= count <= places:
        raise DataError(
            f"{count} cells do not fit into a grid of {grid.shape[0]} x {grid.shape[1]} x {grid.shape[2]} = {places}",
            do="Make the grid larger.",
            code="does_not_fit",
        )
    worth = gain.worth_of_cells(grid.lattice()).ravel()
    return grid.lattice(_largest(worth, count).reshape(grid.shape))


def _largest(worth: Array, count: int) -> Array:
    """Mark the largest; among equal ones the first."""
    least = np.partition(worth, len(worth) - count)[len(worth) - count]
    taken: Array = worth > least
    equal = np.flatnonzero(worth == least)
    taken[equal[: count - int(taken.sum())]] = True
    return taken


@dataclass(frozen=True)
class Pieces:
    """Cubes of one size."""

    cells: int  # length of an edge in cells of the grid
    count: int  # how many there are


@dataclass(frozen=True, eq=False)
class Stack:
    """A body from an inventory."""

    body: Lattice  # what was built
    places: tuple[Array, ...]  # for each size, first cells of its pieces, shape (count, 3)
    # gain, bound: of the body, and of as many single cells, for a gravitational constant of one [kg/m^2]
    gain: float
    bound: float

    @property
    def gap(self) -> float:
        """By how much a better use of the inventory could raise the gain at most, relative."""
        return self.bound / self.gain - 1.0


def best_stack(grid: Grid, inventory: tuple[Pieces, ...], gain: Gain = PLAIN) -> Stack:
    """Return the body that an inventory allows.

    Parameters
    ----------
    grid : Grid
        Where material can be; its edge is that of the smallest cube, or a whole fraction of it.
    inventory : tuple of Pieces
        What there is.
    gain : Gain
        Default: attraction along x.

    Raises
    ------
    DataError
        If the pieces do not fit.
    """
    _refuse_nothing(inventory)
    worth = gain.worth_of_cells(grid.lattice())
    taken = np.zeros(grid.shape, dtype=bool)
    places = []
    for pieces in sorted(inventory, key=lambda p: -p.cells):
        first = _placed(worth, taken, pieces)
        places.append(first)
        for x, y, z in first:
            taken[x : x + pieces.cells, y : y + pieces.cells, z : z + pieces.cells] = True
    body = grid.lattice(taken)
    return Stack(body, tuple(places), gain.of(body), gain.of(best_cells(grid, int(taken.sum()), gain)))


def _refuse_nothing(inventory: tuple[Pieces, ...]) -> None:
    """Refuse an inventory of nothing."""
    for pieces in inventory:
        if pieces.cells < 1 or pieces.count < 1:
            raise DataError(
                f"{pieces.count} cubes of {pieces.cells} cells: both numbers must be one or more",
                do="Leave out sizes with no cubes.",
                code="no_pieces",
            )
    if not inventory:
        raise DataError("the inventory has no pieces", do="Give one size or more.", code="no_pieces")


def _placed(worth: Array, taken: Array, pieces: Pieces) -> Array:
    """First cells of the best free places of one size, shape (count, 3)."""
    m = pieces.cells
    offsets = [
        0,
        *((n % (2 * m)) // 2 for n in worth.shape[1:]),
    ]  # the grid of large cubes is centred, as far as it can be
    blocks = [(n - o) // m for n, o in zip(worth.shape, offsets, strict=True)]
    inside = tuple(slice(o, o + b * m) for o, b in zip(offsets, blocks, strict=True))
    shape = tuple(v for b in blocks for v in (b, m))
    value = worth[inside].reshape(shape).sum(axis=(1, 3, 5))
    free = ~taken[inside].reshape(shape).any(axis=(1, 3, 5))
    if int(free.sum()) < pieces.count:
        raise DataError(
            f"{pieces.count} cubes of {m} cells do not fit: the grid has {int(free.sum())} free places for them",
            do="Make the grid larger, or use fewer.",
            code="does_not_fit",
        )
    order = np.argsort(np.where(free, -value, math.inf).ravel(), kind="stable")[: pieces.count]
    first: Array = np.stack(np.unravel_index(order, value.shape), axis=1) * m + np.array(offsets)
    return first


@dataclass(frozen=True, eq=False)
class Growth:
    """Fields for a gravitational constant of one."""

    mass: Array  # [kg], shape (n,)
    # sphere, best: [kg/m^2], shape (n,)
    sphere: Array
    best: Array


def growth(mass: ArrayLike, density: float, stand_off: float, keep: Keep = "plane") -> Growth:
    """Return the field of the sphere that touches the stand-off and of the best body, for each mass.

    Parameters
    ----------
    mass : array_like, shape (n,)
        [kg].
    density : float
        [kg/m^3].
    stand_off : float
        [m].
    keep : {"plane", "sphere"}
        Where material may be.

    Raises
    ------
    DataError
        As `largest_field`.
    """
    masses = np.atleast_1d(np.asarray(mass, dtype=float))
    bounds = [largest_field(float(m), density, stand_off, keep) for m in masses]
    return Growth(masses, np.array([b.sphere for b in bounds]), np.array([b.field for b in bounds]))
