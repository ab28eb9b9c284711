"""Mean reading of each axis over recordings, its uncertainty from the scatter between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from inertialcal.core.curve import Column, Curve
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Row
from inertialcal.procedures.model_terms import HeldOut
from inertialcal.statistics.closed_loop import AxisLoop
from inertialcal.statistics.intervals import t_interval

from .plan import Plan


@dataclass(frozen=True, eq=False)
class Readings:
    """Means of recordings: by axis, one a recording [unit]; how many samples were left out at the start."""

    means: Mapping[str, Array]
    unit: str
    skipped: int = 0
    remarks: tuple[Remark, ...] = ()

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(next(iter(self.means.values())))

    def __len__(self) -> int:
        """Return the number of recordings."""
        return self.runs


@dataclass(frozen=True, eq=False)
class Result:
    """The means, with their covariance."""

    plan: Plan
    readings: Readings
    estimate: Estimate
    remarks: tuple[Remark, ...]

    def rows(self) -> tuple[Row, ...]:
        """Return a row an axis."""
        one = self.estimate
        return tuple(
            Row(key, float(v), float(u), unit, float(dof), t_interval(float(v), float(u), float(dof)))
            for key, v, u, unit, dof in zip(one.keys, one.values, one.u, one.units, one.dof, strict=True)
        )

    def curves(self) -> list[Curve]:
        """Return the means of the recordings, an axis a curve, and their changes."""
        unit = self.readings.unit
        found = []
        for axis, means in self.readings.means.items():
            number = list(range(1, len(means) + 1))
            found.append(Curve("mean_readings", axis, {"recording": Column(number), "mean": Column(means, unit)}))
            steps = {"recording": Column(number[1:]), "step": Column(np.diff(means), unit)}
            found.append(Curve("mean_steps", axis, steps))
        return found


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return the mean of each axis.

    Raises
    ------
    DataError
        ``too_few_recordings``.
    """
    n = readings.runs
    if n < plan.fewest:
        raise DataError(f"{n} recording(s), need {plan.fewest}", code="too_few_recordings")
    values = np.array([means.mean() for means in readings.means.values()])
    u = np.array([means.std(ddof=1) / np.sqrt(n) for means in readings.means.values()])
    keys = tuple(Key("mean_reading", axis) for axis in readings.means)
    component = Component("scatter between recordings", "A", np.diag(u**2), float(n - 1))
    return Result(plan, readings, Estimate(keys, values, (readings.unit,) * len(keys), (component,)), readings.remarks)


def held_out(estimate: Estimate, held: Sequence[Readings]) -> HeldOut:
    """Return how much smaller the means of recordings held out are without those of an estimate."""
    loops = []
    for key, found, u in zip(estimate.keys, estimate.values, estimate.u, strict=True):
        raw = np.concatenate([one.means[key.axis] for one in held])
        left, n = raw - found, len(raw)
        gain = raw**2 - left**2
        of_mean = float(np.std(gain, ddof=1) / np.sqrt(n))
        before, after = (float(np.sqrt(np.mean(one**2))) for one in (raw, left))
        mean = float(np.mean(gain))
        unit = held[0].unit
        loops.append(AxisLoop(key.axis, n, n, before, after, mean, of_mean, n - 1.0, float(u) ** 2, unit))
    return HeldOut(tuple(loops))
