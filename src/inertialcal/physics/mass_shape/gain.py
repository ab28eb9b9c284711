"""What a cell of material is worth: its attraction along an axis, or the change of it over a stroke.

Both are linear in the density of each cell, so that the best body of equal cells is that of the most valuable ones.

A body that is moved by s away from a point attracts it as a body at rest attracts the point moved by -s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice
from ..attraction.extended import ProofMass

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

    def of_cells(self, grid: Lattice) -> Array:
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


def change(stroke: Direction, axis: Direction = (1.0, 0.0, 0.0), start: Direction = HERE) -> Gain:
    """Return the change of attraction when the body is shifted by ``stroke`` from ``start`` [m]."""
    end = tuple(a + b for a, b in zip(start, stroke, strict=True))
    return Gain(axis, ((1.0, start), (-1.0, end)))  # type: ignore[arg-type]
