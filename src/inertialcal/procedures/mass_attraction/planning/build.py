"""How a body of cubes is built: where each cube goes, in the order in which it is placed.

Places are those of the plan at position zero: the proof mass is the origin, x the input axis (the body lies on its
positive side), z points up. Cubes are numbered from the lowest layer up, in a layer from the proof mass outward, and
from -y to +y: a cube that carries another has the lower number. The body of the plan is the best one without regard to
weight: cubes that rest on less than their whole face need packing, and are named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.remarks import Remark
from ....core.show.rounding import items, number
from .drive import CM, MassBody

RESTS = 0.999  # of its lower face, below which a cube needs packing
DIGITS = 6  # of a length [cm] and of a mass [kg]


@dataclass(frozen=True, eq=False)
class Build:
    """Cubes in the order in which they are placed; arrays are of one length."""

    edge: Array  # [m], shape (n,)
    corner: Array  # with the smallest coordinates, from the proof mass [m], shape (n, 3)
    layer: NDArray[np.int64]  # of the lower face, as high as the smallest cube, from 1, shape (n,)
    rests: Array  # part of the lower face that lies on other cubes, 1 in the lowest layer, shape (n,)
    density: float  # [kg/m^3]
    step: float  # edge of the smallest cube [m]

    def __len__(self) -> int:
        """Return the number of cubes."""
        return len(self.edge)

    @property
    def centre(self) -> Array:
        """Middle of each cube [m], shape (n, 3)."""
        return np.asarray(self.corner + 0.5 * self.edge[:, None])

    @property
    def mass(self) -> Array:
        """Of each cube [kg], shape (n,)."""
        return np.asarray(self.density * self.edge**3)

    @property
    def packed(self) -> NDArray[np.bool_]:
        """Which cubes do not rest on their whole lower face, shape (n,)."""
        return self.rests < RESTS

    @cached_property
    def layers(self) -> tuple[NDArray[np.int64], ...]:
        """Places in the list of the cubes in each layer, as high as the smallest cube, from the lowest."""
        low, high = self.corner[:, 2], self.corner[:, 2] + self.edge
        heights = np.arange(round((high.max() - low.min()) / self.step)) * self.step + low.min()
        middle = heights + 0.5 * self.step
        return tuple(np.flatnonzero((low < at) & (high > at)) for at in middle)

    def totals(self) -> list[tuple[float, int, float, float]]:
        """Return edge [m], number, mass of a cube and of all of them [kg], of each size from the largest."""
        sizes = sorted(set(np.round(self.edge, 12).tolist()), reverse=True)
        found = []
        for size in sizes:
            these = np.abs(self.edge - size) < 1e-9
            found.append((size, int(these.sum()), self.density * size**3, float(self.mass[these].sum())))
        return found

    def csv(self, notes: Sequence[str] = ()) -> str:
        """Return the list of all cubes as CSV, lengths in cm from the proof mass."""
        totals = [
            f"# {items(count, 'cube')} of {number(CM * size, DIGITS)} cm: {number(each, DIGITS)} kg each,"
            f" {number(every, DIGITS)} kg"
            for size, count, each, every in self.totals()
        ]
        low, high = self.corner.min(axis=0), (self.corner + self.edge[:, None]).max(axis=0)
        extent = " x ".join(number(CM * side, DIGITS) for side in high - low)
        head = [
            "# cubes of the source mass, in the order in which they are placed",
            "# origin: proof mass, body at position zero; x: input axis, away from the proof mass; z: up",
            *totals,
            f"# all: {items(len(self), 'cube')}, {number(float(self.mass.sum()), DIGITS)} kg, {extent} cm (x, y, z)",
            *(f"# {note}" for note in notes),
            "# rests_on: part of the lower face that lies on other cubes, or on the base; pack what is below 100 %",
            "cube,layer,edge [cm],mass [kg],x_corner [cm],y_corner [cm],z_corner [cm],"
            "x_centre [cm],y_centre [cm],z_centre [cm],rests_on [%]",
        ]
        columns = np.column_stack([CM * self.corner, CM * self.centre])
        rows = [
            ",".join(
                [str(at + 1), str(self.layer[at]), _text(CM * self.edge[at]), _text(self.mass[at]),
                 *map(_text, columns[at]), f"{100.0 * self.rests[at]:.0f}"]
            )
            for at in range(len(self))
        ]  # fmt: skip
        return "\n".join([*head, *rows]) + "\n"

    def remarks(self) -> list[Remark]:
        """Return how many cubes need packing."""
        count = int(np.count_nonzero(self.packed))
        if not count:
            return []
        first = int(np.flatnonzero(self.packed)[0]) + 1
        what = f"{count} of {len(self)} cubes do not rest on their whole lower face, the first is cube {first}"
        return [Remark("packing", "warning", what, do="Pack below them: they are marked in list and drawing")]


def build_of(body: MassBody) -> Build:
    """Return the cubes of a body, in the order in which they are placed."""
    edge = body.grid.edge
    cells = np.concatenate([first for _, first in body.pieces])
    sizes = np.concatenate([np.full(len(first), size) for size, first in body.pieces])
    order = np.lexsort((cells[:, 1], cells[:, 0], cells[:, 2]))
    cells, sizes = cells[order], sizes[order]
    filled = body.body.density > 0.0
    rests = np.ones(len(cells))
    lowest = int(cells[:, 2].min())
    for at, ((x, y, z), size) in enumerate(zip(cells.tolist(), sizes.tolist(), strict=True)):
        if z > lowest:
            rests[at] = filled[x : x + size, y : y + size, z - 1].mean()
    corner = np.array(body.body.lower) + edge * cells
    return Build(edge * sizes, corner, 1 + cells[:, 2] - lowest, rests, body.grid.density, edge)


def _text(value: float) -> str:
    """Return a length or a mass without a tail of zeros."""
    text = f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


__all__ = ["Build", "build_of"]
