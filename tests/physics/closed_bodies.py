"""Bodies of closed form, and one turned and moved: what the attraction of cells is held against."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from inertialcal.core.estimate import Array


class Field(Protocol):
    """What attracts."""

    def field(self, points: Array) -> Array: ...


@dataclass(frozen=True)
class Point:
    """Mass in one place."""

    mass: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def field(self, points: Array) -> Array:
        away = np.array(self.centre) - points
        pull: Array = self.mass * away / np.linalg.norm(away, axis=1)[:, None] ** 3
        return pull


@dataclass(frozen=True, eq=False)
class Placed:
    """A body turned about the origin of its frame, and then moved."""

    body: Field
    shift: tuple[float, float, float]
    C_world_body: Array

    def field(self, points: Array) -> Array:
        C = self.C_world_body
        return self.body.field(np.ascontiguousarray((points - np.array(self.shift)) @ C)) @ C.T
