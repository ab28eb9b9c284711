"""Body of a source mass: the best stack of cubes behind the plane at the stand-off, on one grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....physics.attraction.bodies import Lattice
from ....physics.mass_shape.bound import Bound, largest_field
from ....physics.mass_shape.cells import Gain, Grid, Pieces, best_cells, best_stack, most_in_weight
from .settings import Body

WHOLE = 0.01  # tolerance of a multiple of the smallest edge, in edges
WIDE = 0.65  # half width of the best body behind a plane over its reach: 0.62 where it touches
ROOM = 1.1  # size of the grid over that of the best body
SMALLEST = 1e-4  # edge [m]
HEAVIEST = 1e6  # kg: above, edges in centimetres were given as metres
FAR = 10.0  # stand-off over the radius of a sphere of the mass: beyond, the attraction is negligible
MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class MassBody:
    """A body, and the largest attraction that its mass could have."""

    body: Lattice  # With the proof mass at the origin and the input axis along x
    grid: Grid  # Places for cells
    count: int  # Number of filled cells
    bound: Bound  # For the same mass behind the plane
    allowed: float = 0.0  # Largest relative gain of free cells over cubes of several sizes; 0 for equal cubes

    @property
    def mass(self) -> float:
        """[kg]."""
        return self.count * self.grid.cell_mass

    @property
    def field(self) -> float:
        """Field at the proof mass along the input axis, for a gravitational constant of one [kg/m^2]."""
        return float(self.body.field(np.zeros((1, 3)))[0, 0])

    @property
    def gap(self) -> float:
        """Relative distance below the bound."""
        return 1.0 - self.field / self.bound.field

    @property
    def size(self) -> Array:
        """Extent along x, y and z, shape (3,) [m]."""
        filled = np.nonzero(self.body.density)
        return np.array([float(np.ptp(at) + 1) * self.grid.edge for at in filled])


def body_of(said: Body, gain: Gain) -> MassBody:
    """Return the body with the largest gain: equal cubes, or cubes of several sizes.

    Raises
    ------
    DataError
        If cubes do not fit the grid or the mass, edges are not multiples of the smallest, or a length is absurd.
    """
    pieces = said.cubes or ()
    edge = min((one.edge for one in pieces), default=said.cube or 0.0)
    if edge < SMALLEST:
        what, do = f"cubes of {edge:g} m: the smallest is {SMALLEST:g} m", "Check the unit of the edge"
        raise DataError(what, do=do, code="absurd_length")
    one = Grid(edge, (1, 1, 1), said.stand_off, said.density)
    if not pieces:
        number = most_in_weight(one, said.mass or 0.0) if said.count is None else said.count
        _check_weight(number * one.cell_mass, number, said.mass)
        grid = _grid(one, number, said.grid)
        body = best_cells(grid, number, gain)
        return MassBody(body, grid, number, largest_field(number * grid.cell_mass, said.density, said.stand_off))
    sizes = []
    for piece in pieces:
        times = round(piece.edge / edge)
        if abs(piece.edge / edge - times) > WHOLE:
            what = f"edges of {piece.edge:g} m are not a multiple of {edge:g} m"
            do = "Give edges that are multiples of the smallest"
            raise DataError(what, why="all cubes lie on one grid", do=do, code="no_multiple")
        sizes.append(Pieces(times, piece.count))
    cells = sum(piece.count * piece.cells**3 for piece in sizes)
    _check_weight(cells * one.cell_mass, sum(piece.count for piece in sizes), said.mass)
    grid = _grid(one, cells, said.grid, max(piece.cells for piece in sizes))
    stack = best_stack(grid, tuple(sizes), gain)
    bound = largest_field(cells * grid.cell_mass, said.density, said.stand_off)
    return MassBody(stack.body, grid, cells, bound, stack.gap)


def _check_weight(weight: float, count: int, mass: float | None) -> None:
    """Refuse what is heavier than allowed, or than any laboratory holds."""
    if mass is not None and weight > mass * (1.0 + 1e-9):
        what = f"{count} cubes weigh {weight:.6g} kg, more than the {mass:g} kg allowed"
        raise DataError(what, do="Allow more mass, or use fewer cubes", code="does_not_fit")
    if weight > HEAVIEST:
        why, do = f"no laboratory holds more than {HEAVIEST:g} kg", "Check the unit of the edges: cm, not m?"
        raise DataError(f"{count} cubes weigh {weight:.3g} kg", why=why, do=do, code="absurd_length")


def _grid(one: Grid, cells: int, shape: Sequence[int] | None, step: int = 1) -> Grid:
    """Return the grid, as given or large enough for the best body."""
    weight = cells * one.cell_mass
    radius = (3.0 * weight / one.density / (4.0 * math.pi)) ** (1.0 / 3.0)
    if one.stand_off > FAR * radius:
        what = (
            f"stand-off {one.stand_off:g} m: {one.stand_off / radius:.0f} times the radius of a sphere "
            f"of {weight:.4g} kg"
        )
        why, do = "the attraction is negligible at this distance", "Check the unit: cm, not m?"
        raise DataError(what, why=why, do=do, code="absurd_length")
    if shape is None:
        reach = largest_field(weight, one.density, one.stand_off).reach
        deep = math.ceil(ROOM * (reach - one.stand_off) / one.edge) + 2 * step
        half = math.ceil(ROOM * WIDE * reach / one.edge) + step
        sides = (deep - deep % -step, 2 * (half - half % -step), 2 * (half - half % -step))
    else:
        sides = (shape[2], shape[0], shape[1])  # along x, the input axis, then y and z
    if math.prod(sides) > MOST_CELLS:
        what = f"a grid of {sides[0]} x {sides[1]} x {sides[2]} cells: {MOST_CELLS:g} is the limit"
        raise DataError(what, do="Use larger cubes, or fewer", code="too_large")
    return Grid(one.edge, sides, one.stand_off, one.density)
