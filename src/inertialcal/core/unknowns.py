"""Unknowns: errors of one origin, and what one standard uncertainty of each of them changes.

What a correction takes off the readings of several recordings has the same errors in all of them: more dwells do not
average them. Where the reading at rest was subtracted they have dropped out. Equal origins are the same unknowns, so
that the sum of what was taken off and what is left knows how both go together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .estimate import Array
from .key import Key, Origin

Chosen = NDArray[np.bool_] | NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Independent unknowns of one origin, and what one standard uncertainty of each of them changes.

    Parameters
    ----------
    origin : Origin
        Where they come from.
    kind : {"A", "B"}
        Observed scatter, or other knowledge.
    changes : ndarray, shape (s, n, 3)
        What was taken off the reading of the x, y and z sensor in each dwell [rad/s].
    keys : tuple of Key
        Parameters of the law that was taken off: bias of x, its first coefficient over temperature, ...
    law : ndarray, shape (s, m)
        The same of those parameters [SI].
    dof : ndarray, shape (3,)
        Degrees of freedom, by sensor.
    distribution, stated, unknowns
        As ``Component`` has them.
    """

    origin: Origin
    kind: Literal["A", "B"]
    changes: Array
    keys: tuple[Key, ...]
    law: Array
    dof: Array
    distribution: str = "normal"
    stated: tuple[float, str] | None = None
    unknowns: tuple[str, ...] = ()

    def take(self, keep: Chosen) -> Unknowns:
        """Return the same of some of the dwells."""
        return replace(self, changes=self.changes[:, keep])

    def over(self, dwells: int) -> Unknowns:
        """Return the same of so many dwells, where there is one so far."""
        return replace(self, changes=np.repeat(self.changes[:, :1], dwells, axis=1))

    def of_sensor(self, sensor: str) -> Array:
        """Return the changes of one sensor, shape (s, n)."""
        return np.asarray(self.changes[:, :, "xyz".index(sensor)])


def joined(parts: Sequence[Mapping[Origin, Unknowns]], lengths: Sequence[int]) -> dict[Origin, Unknowns]:
    """Return what was taken off several sets of dwells as one; equal origins are the same unknowns."""
    found = {}
    for origin in dict.fromkeys(origin for part in parts for origin in part):
        one = next(part[origin] for part in parts if origin in part)
        blank = np.zeros((len(one.changes), 1, 3))
        columns = [
            part[origin].changes if origin in part else np.repeat(blank, n, axis=1)
            for part, n in zip(parts, lengths, strict=True)
        ]
        found[origin] = replace(one, changes=np.concatenate(columns, axis=1))
    return found
