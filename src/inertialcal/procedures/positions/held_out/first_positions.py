"""Held-out positions: everything fitted on the first of them, and judged on those that come after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ..fit.gyro import problem_of
from ..fit.rotations import angles
from ..gravity import local_gravity
from ..plan import Plan
from ..readings import Readings


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Errors on positions that no fit has seen.

    Parameters
    ----------
    first : int
        Positions that were fitted.
    lengths : ndarray, shape (m - first,)
        Calibrated specific force at rest less gravity [m/s^2].
    angles : ndarray, shape (transitions,)
        From where the gyros carry gravity to where the accelerometers see it [rad].
    """

    first: int
    lengths: Array
    angles: Array

    @property
    def length_rms(self) -> float:
        """Root mean square of the lengths [m/s^2]."""
        return float(np.sqrt(np.mean(self.lengths**2)))

    @property
    def angle_rms(self) -> float:
        """Root mean square of the angles [rad]; NaN without transitions."""
        return float(np.sqrt(np.mean(self.angles**2))) if len(self.angles) else float("nan")


def held_out(plan: Plan, readings: Readings, first: int) -> HeldOut:
    """Fit the first positions, accelerometers, bias, g-sensitivity and matrix, and judge on the others.

    Parameters
    ----------
    plan : Plan
        As for the whole.
    readings : Readings
        All positions.
    first : int
        How many are fitted.

    Raises
    ------
    DataError
        ``too_few_positions`` if none is left; or as ``reduce``.
    """
    from ..reduction import reduce  # noqa: PLC0415 - judged is what reduce gives

    m = len(readings)
    if not 0 < first < m:
        raise DataError(f"{first} of {m} positions to fit: none is left to judge by", code="too_few_positions")
    result = reduce(plan, readings.take(0, first))
    rest = readings.take(first, m)
    sensor = result.acc.sensor
    lengths = np.linalg.norm(sensor.applied(rest.acc.mean), axis=1) - local_gravity(plan)
    if result.gyro is None or result.gyro.rotated is None or rest.gyro is None or not rest.transitions:
        return HeldOut(first, lengths, np.empty(0))
    gyro = result.gyro
    problem = problem_of(plan, rest, result.acc, gyro.rest, gyro.sensor.ideal, gyro.sensor.zero)
    return HeldOut(first, lengths, angles(problem, result.gyro.rotated.W))
