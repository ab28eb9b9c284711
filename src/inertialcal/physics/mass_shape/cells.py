"""The best body of cells on a grid: so many, or up to a weight.

Cells of one size and density are taken in the order of their gain, which is exactly optimal. Cells of equal gain are
taken in the order of the grid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice, finite, positive, slipped
from .gain import Gain

DENSEST = 23000.0  # kg/m^3: no metal is denser than osmium, 22,590
LARGEST_EDGE, LARGEST_STAND_OFF = 1.0, 5.0  # m: above, centimetres were given
LIGHTEST = 100.0  # kg/m^3, of balsa: below it a density was given in g/cm^3
PLAIN = Gain()


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
    worth = gain.of_cells(grid.lattice()).ravel()
    return grid.lattice(_largest(worth, count).reshape(grid.shape))


def _largest(worth: Array, count: int) -> Array:
    """Mark the largest; among equal ones the first."""
    least = np.partition(worth, len(worth) - count)[len(worth) - count]
    taken: Array = worth > least
    equal = np.flatnonzero(worth == least)
    taken[equal[: count - int(taken.sum())]] = True
    return taken
