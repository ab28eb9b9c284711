"""A moved mass with its doubts: what is known of pieces, places, stops, angles and the constant.

The amplitude of the drive is half the difference of the attraction along the input axis between two stops. All errors
are independent of each other, and stay the same from cycle to cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice, finite
from ..motion.clearance import refuse_overlap

OFF = 1e-9  # of a length of one


@dataclass(frozen=True)
class Doubts:
    """Standard uncertainties."""

    density: float = 0.0  # of the material, common to all pieces, relative
    piece_density: float = 0.0  # of each piece, relative
    piece_place: float = 0.0  # of each piece in the body, along each direction [m]
    # of the body against the proof mass, the same at both stops, along x, y and z [m]
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stop: float = 0.0  # of each stop along the travel [m]
    angle: float = 0.0  # of the body about each of x, y and z, through the origin of its frame [rad]
    gravitational_constant: float = GRAVITATIONAL_CONSTANT.u / GRAVITATIONAL_CONSTANT.value  # relative

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            finite(f"uncertainty {name}", *np.atleast_1d(value))
            if not np.all(np.asarray(value) >= 0.0):
                raise DataError(f"uncertainty {name} = {value} is below zero", code="no_uncertainty")
        for name in ("density", "piece_density", "gravitational_constant"):
            if getattr(self, name) >= 1.0:
                raise DataError(
                    f"uncertainty {name} = {getattr(self, name):g} is 100 % or more",
                    why="it is relative",
                    do=f"If {getattr(self, name):g} % was meant, give {getattr(self, name) / 100.0:g}.",
                    code="absurd_uncertainty",
                )


@dataclass(frozen=True, eq=False)
class Source:
    """A mass moved between two stops before a proof mass at the origin.

    Raises
    ------
    DataError
        If a direction is not of length one, a stop is not finite, both are one, or the mass lies in the origin at one.
    """

    body: Lattice  # at position zero; each cell is a piece
    direction: tuple[float, float, float]  # of the travel, of length one
    stops: tuple[float, float]  # positions of both ends [m]
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)  # input axis, of length one
    gravitational_constant: float = GRAVITATIONAL_CONSTANT.value  # [m^3/s^2/kg]

    def __post_init__(self) -> None:
        finite("stop", *self.stops)
        for name, way in (("direction", self.direction), ("axis", self.axis)):
            if abs(math.hypot(*way) - 1.0) > OFF:
                raise DataError(
                    f"{name} {way} is not of length one", do="Divide it by its length.", code="no_direction"
                )
        if self.stops[0] == self.stops[1]:
            raise DataError(f"both stops are at {self.stops[0]:g} m: the field does not change", code="no_travel")
        for stop in self.stops:
            refuse_overlap(self.body, self.direction, stop, stop, 0.0)

    @property
    def shifts(self) -> Array:
        """Of the body at both stops, shape (2, 3) [m]."""
        return np.outer(self.stops, self.direction)

    @property
    def amplitude(self) -> float:
        """Half the difference of the attraction along the axis [m/s^2]."""
        fields = self.body.field(-self.shifts) @ np.array(self.axis)
        return self.gravitational_constant * float(fields[0] - fields[1]) / 2.0
