"""The best body from what there is: cubes of several sizes, each a whole number of cells long.

Sizes are placed from the largest to the smallest, each on the grid of its own size, in the order of gain among the
places that are free. That need not be optimal; how far it may be from it is told by the body of as many single cells,
which no inventory of the same material can beat.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice
from .cells import PLAIN, Grid, best_cells
from .gain import Gain


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
    worth = gain.of_cells(grid.lattice())
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
