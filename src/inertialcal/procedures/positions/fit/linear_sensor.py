"""Three sensors as a matrix and an offset, with the sources of uncertainty of both: what the fits hand on.

In units of the input: ``reading = A x + b`` where a reading is (output - zero) / ideal scale factor. The twelve numbers
are in the order A_xx, A_xy, A_xz, A_yx, ..., A_zz, b_x, b_y, b_z; of the gyros nine more follow, G_xx, ..., G_zz.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.estimate import Array
from ....core.influence import Influence
from ....core.key import Key, Origin, Reason

PAIRS = tuple(a + b for a in AXES for b in AXES)
MATRIX = tuple(Key("scale_factor_error", p[0]) if p[0] == p[1] else Key("misalignment", p) for p in PAIRS)
BIAS = tuple(Key("bias", a) for a in AXES)
G_SENSITIVITY = tuple(Key("g_sensitivity", p) for p in PAIRS)


@dataclass(frozen=True, eq=False)
class Source:
    """One source of uncertainty of all the numbers at once: covariance, degrees of freedom, kind, what was stated."""

    name: str
    kind: str
    covariance: Array
    dof: Array | float = np.inf
    influence: Influence | None = None
    level: str = ""

    @property
    def origin(self) -> Origin:
        """Where it comes from."""
        return Origin(self.name, level=self.level) if self.influence is None else self.influence.origin(self.name)


@dataclass(frozen=True, eq=False)
class LinearSensor:
    """Matrix and offset of three sensors, relative to their ideal scale factor and zero.

    Parameters
    ----------
    values : ndarray, shape (12,) or (21,)
        In the order of the module head.
    sources : tuple of Source
        Their covariances add; in the same order.
    reasons : mapping of int to Reason
        Number -> why it is not estimated.
    ideal, zero : ndarray, shape (3,)
        Scale factor [unit of the readings/input unit] and reading for no input [unit of the readings].
    """

    values: Array
    sources: tuple[Source, ...]
    reasons: Mapping[int, Reason]
    ideal: Array
    zero: Array
    named: tuple[Key, ...] = field(default=(*MATRIX, *BIAS))

    @property
    def matrix(self) -> Array:
        """A, shape (3, 3)."""
        return self.values[:9].reshape(3, 3)

    @property
    def offset(self) -> Array:
        """b, shape (3,) [input unit]."""
        return self.values[9:12]

    @property
    def g_sensitivity(self) -> Array | None:
        """G, shape (3, 3), or None."""
        return self.values[12:].reshape(3, 3) if len(self.values) > 12 else None

    @property
    def covariance(self) -> Array:
        """Sum of the sources."""
        total = np.zeros((len(self.values), len(self.values)))
        for one in self.sources:
            total = total + one.covariance
        return total

    def normalised(self, output: Array) -> Array:
        """Return readings [input unit] of outputs, shape (n, 3)."""
        return np.asarray((output - self.zero) / self.ideal)

    def applied(self, output: Array) -> Array:
        """Return the inputs that give these outputs, g-sensitivity left aside, shape (n, 3)."""
        return np.asarray((self.normalised(output) - self.offset) @ np.linalg.inv(self.matrix).T)


def with_ideal(sensor: LinearSensor, ideal: Array, zero: Array) -> LinearSensor:
    """Return the same sensor relative to another ideal scale factor and zero."""
    ratio = sensor.ideal / ideal
    rows = np.concatenate([np.repeat(ratio, 3), ratio, np.repeat(ratio, 3)])[: len(sensor.values)]
    values = sensor.values * rows
    values[9:12] += (sensor.zero - zero) / ideal
    sources = tuple(replace(one, covariance=one.covariance * np.outer(rows, rows)) for one in sensor.sources)
    return replace(sensor, values=values, sources=sources, ideal=ideal, zero=zero)


def rounded_scale(sensor: LinearSensor, told: NDArray[np.bool_]) -> Array:
    """Return the scale factors found, rounded to two digits: a definition to refer to, shape (3,)."""
    found = np.abs(np.where(told, sensor.ideal * np.diag(sensor.matrix), sensor.ideal))
    power = 10.0 ** (np.floor(np.log10(found)) - 1.0)
    return np.asarray(np.round(found / power) * power)
