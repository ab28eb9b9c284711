"""The body of a source mass from what a user says of it: cubes by count or weight, or an inventory.

Cubes lie behind the plane at the stand-off, on a grid that is made large enough where none is given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....physics.attraction import Lattice
from ....physics.mass_shape import Bound, Gain, Grid, Pieces, best_cells, best_stack, largest_field, most_in_weight

WHOLE = 0.01  # of a cube, within which a larger one is a whole number of it long
WIDE = 0.65  # half width of the best body behind a plane over its reach: 0.62 where it touches
ROOM = 1.1  # a grid is that much larger than the best body
SMALLEST = 1e-4  # m, of a cube
HEAVIEST = 1e6  # kg, from which a length was given in metres that were centimetres
FAR = 10.0  # stand-off over the radius of the sphere of the mass, from which it does not attract
MOST_CELLS = 4_000_000  # of a grid


@dataclass(frozen=True, eq=False)
class MassBody:
    """A body, and the most that its mass could attract.

    Parameters
    ----------
    body : Lattice
        The proof mass at the origin, the input axis along x.
    grid : Grid
        Where cells could be.
    count : int
        Of cells that are filled.
    bound : Bound
        Of the same mass behind the plane.
    allowed : float
        Gain of as many free cells over that of an inventory less one; 0 for cells.
    """

    body: Lattice
    grid: Grid
    count: int
    bound: Bound
    allowed: float = 0.0

    @property
    def mass(self) -> float:
        """[kg]."""
        return self.count * self.grid.cell_mass

    @property
    def field(self) -> float:
        """At the proof mass along the input axis, for a gravitational constant of one [kg/m^2]."""
        return float(self.body.field(np.zeros((1, 3)))[0, 0])

    @property
    def gap(self) -> float:
        """By how much the bound is above it, relative."""
        return 1.0 - self.field / self.bound.field

    @property
    def size(self) -> Array:
        """Extent along x, y and z, shape (3,) [m]."""
        filled = np.nonzero(self.body.density)
        return np.array([float(np.ptp(at) + 1) * self.grid.edge for at in filled])


def body_of(
    cube: float, density: float, stand_off: float, count: int | None, mass: float | None,
    shape: tuple[int, int, int] | None, gain: Gain,
) -> MassBody:  # fmt: skip
    """Return the best body of equal cubes.

    Parameters
    ----------
    cube : float
        Edge [m].
    density : float
        [kg/m^3].
    stand_off : float
        From the proof mass to the nearest face [m].
    count : int, optional
        Of cubes.
    mass : float, optional
        That they may not exceed [kg].
    shape : tuple of int, optional
        Of the grid, along x, y, z.
    gain : Gain
        What is to be as large as possible.

    Raises
    ------
    UsageError
        If neither count nor mass is given.
    DataError
        If they contradict each other, cubes do not fit, or lengths cannot be meant.
    """
    one = _cell(cube, stand_off, density)
    if count is None and mass is None:
        raise UsageError("neither --count nor --mass is given", do="Say how many cubes, or what they may weigh")
    number = most_in_weight(one, float(mass or 0.0)) if count is None else count
    if number < 1:
        raise UsageError(f"count: {number}", do="One cube or more", code="wrong_value")
    _check_weight(number * one.cell_mass, number, mass)
    grid = _grid(one, number * one.cell_mass, shape)
    body = best_cells(grid, number, gain)
    return MassBody(body, grid, number, largest_field(number * grid.cell_mass, density, stand_off))


def stack_of(
    inventory: Sequence[tuple[int, float]], density: float, stand_off: float, mass: float | None,
    shape: tuple[int, int, int] | None, gain: Gain,
) -> MassBody:  # fmt: skip
    """Return the best body of cubes of several sizes.

    Parameters
    ----------
    inventory : sequence of (int, float)
        Count and edge of each size [m].
    density, stand_off, mass, shape, gain
        As `body_of`.

    Raises
    ------
    DataError
        As `body_of`; or if a size is no whole number of the smallest.
    """
    edge = min(length for _, length in inventory)
    pieces = tuple(Pieces(_multiple(length, edge), count) for count, length in inventory)
    cells = sum(one.count * one.cells**3 for one in pieces)
    one = _cell(edge, stand_off, density)
    _check_weight(cells * one.cell_mass, sum(piece.count for piece in pieces), mass)
    grid = _grid(one, cells * one.cell_mass, shape, max(piece.cells for piece in pieces))
    stack = best_stack(grid, pieces, gain)
    return MassBody(stack.body, grid, cells, largest_field(cells * grid.cell_mass, density, stand_off), stack.gap)


def _cell(edge: float, stand_off: float, density: float) -> Grid:
    """Return a grid of one cell; refuse cubes that nobody stacks."""
    if edge < SMALLEST:
        raise DataError(
            f"cubes of {edge:g} m: nobody stacks any below {SMALLEST:g} m",
            do="Look at the unit of the edge",
            code="absurd_length",
        )
    return Grid(edge, (1, 1, 1), stand_off, density)


def _multiple(length: float, edge: float) -> int:
    times = round(length / edge)
    if abs(length / edge - times) > WHOLE:
        raise DataError(
            f"cubes of {length:g} m are not a whole number of those of {edge:g} m",
            why="they are placed on one grid",
            do="Give edges of which each is a multiple of the smallest",
            code="no_multiple",
        )
    return times


def _check_weight(weight: float, count: int, mass: float | None) -> None:
    """Refuse what weighs more than allowed, or than any laboratory holds."""
    if mass is not None and weight > mass * (1.0 + 1e-9):
        raise DataError(
            f"{count} cubes weigh {weight:.6g} kg, more than the {mass:g} kg allowed",
            do="Allow the weight, or use fewer",
            code="does_not_fit",
        )
    if weight > HEAVIEST:
        raise DataError(
            f"{count} cubes weigh {weight:.3g} kg",
            why=f"no laboratory holds more than {HEAVIEST:g} kg",
            do="Look at the unit of the edges: cm, not m?",
            code="absurd_length",
        )


def _grid(one: Grid, weight: float, shape: tuple[int, int, int] | None, step: int = 1) -> Grid:
    """Return the grid, as given or large enough for the best body."""
    radius = (3.0 * weight / one.density / (4.0 * math.pi)) ** (1.0 / 3.0)
    if one.stand_off > FAR * radius:
        raise DataError(
            f"stand-off {one.stand_off:g} m: {one.stand_off / radius:.0f} times the radius of a sphere "
            f"of {weight:.4g} kg",
            why="at that distance it attracts next to nothing",
            do="Look at the unit: cm, not m?",
            code="absurd_length",
        )
    if shape is None:
        reach = largest_field(weight, one.density, one.stand_off).reach
        deep = math.ceil(ROOM * (reach - one.stand_off) / one.edge) + 2 * step
        half = math.ceil(ROOM * WIDE * reach / one.edge) + step
        shape = (deep - deep % -step, 2 * (half - half % -step), 2 * (half - half % -step))
    if math.prod(shape) > MOST_CELLS:
        raise DataError(
            f"a grid of {shape[0]} x {shape[1]} x {shape[2]} cells is more than {MOST_CELLS:g}",
            do="Take larger cubes, or fewer",
            code="too_large",
        )
    return Grid(one.edge, shape, one.stand_off, one.density)
