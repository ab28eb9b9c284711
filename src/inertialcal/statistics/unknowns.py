"""What was taken off the readings before: a bias that another test found, as of temperature.

Its error is the same unknown in all dwells: more dwells do not average it. Where the reading at rest was subtracted it
has dropped out. The unknowns are those of that test, so that the sum of what was taken off and what is left of the
bias knows how both go together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from ..core.key import Key

Chosen = NDArray[np.bool_] | NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Independent unknowns of one source, and what one standard uncertainty of each of them changes.

    Parameters
    ----------
    patterns : ndarray, shape (s, n, 3)
        What was taken off the reading of the x, y and z sensor in each dwell [rad/s].
    keys : tuple of Key
        Parameters of the law that was taken off: bias of x, its first coefficient over temperature, ...
    law : ndarray, shape (s, m)
        The same of those parameters [SI].
    kind : {"A", "B"}
        Observed scatter, or other knowledge.
    dof : ndarray, shape (3,)
        Degrees of freedom, by sensor.
    distribution, stated
        As ``Component`` has them.
    """

    patterns: Array
    keys: tuple[Key, ...]
    law: Array
    kind: Literal["A", "B"]
    dof: Array
    distribution: str = "normal"
    stated: tuple[float, str] | None = None

    def take(self, keep: Chosen) -> Unknowns:
        """Return the same of some of the dwells."""
        return replace(self, patterns=self.patterns[:, keep])

    def over(self, dwells: int) -> Unknowns:
        """Return the same of so many dwells, where there is one so far."""
        return replace(self, patterns=np.repeat(self.patterns[:, :1], dwells, axis=1))

    def of_sensor(self, sensor: str) -> Array:
        """Return the patterns of one sensor, shape (s, n)."""
        return np.asarray(self.patterns[:, :, "xyz".index(sensor)])


def joined(parts: Sequence[Mapping[str, Unknowns]], lengths: Sequence[int]) -> dict[str, Unknowns]:
    """Return what was taken off several sets of dwells as one; a source of the same name is the same unknowns."""
    found = {}
    for name in dict.fromkeys(name for part in parts for name in part):
        one = next(part[name] for part in parts if name in part)
        blank = np.zeros((len(one.patterns), 1, 3))
        columns = [
            part[name].patterns if name in part else np.repeat(blank, n, axis=1)
            for part, n in zip(parts, lengths, strict=True)
        ]
        found[name] = replace(one, patterns=np.concatenate(columns, axis=1))
    return found
