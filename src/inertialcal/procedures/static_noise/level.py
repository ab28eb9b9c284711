"""Level of a sensor at rest: the mean of each power-up, and how far power-ups differ.

Of one test it is no figure: it holds the bias, and gravity or the rate of the earth along the axis. Its change from an
earlier test is that of the bias where the unit lay alike. Where it was laid anew, nothing says how the axis turned
against gravity or the axis of the earth: each laying then has a direction of its own, any being as likely, so that
the part along the axis has a standard deviation of ``g / sqrt(3)``, or ``omega / sqrt(3)``. Two tests that state one
mounting share it, and it cancels.

Recordings that name one ``run`` are one power-up, as are windows of one file; else each recording is one. The scatter
between power-ups is normal and needs two of them; noise that wanders within a power-up is in it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...core.constants import EARTH_ROTATION_RATE, STANDARD_GRAVITY
from ...core.influence import Influence
from ...core.key import Key, Reason
from ...core.results import Row
from ...statistics.intervals import t_interval
from ..protocol import Levels

if TYPE_CHECKING:
    from .readings import Run
    from .reduction import Result

BATCH = 2**20  # samples that are added up at once
ONE_POWER_UP = Reason("few_runs", "one power-up: how far power-ups differ was not observed")
ALONG = {
    "gyro": ("rad/s", "earth_rate", EARTH_ROTATION_RATE.value), "accelerometer": ("m/s^2", "gravity",
    STANDARD_GRAVITY.value),
}  # unit inside, and what a sensor at rest reads beside its bias  # fmt: skip


def levels(result: Result) -> Levels:
    """Return the mean level of each axis over its power-ups, SI; none where the kind of the sensor is not known."""
    if result.plan.kind is None:
        return Levels()
    unit, what, size = ALONG[result.plan.kind]
    name, laid = f"level.{what}", size / math.sqrt(3.0)
    rows = []
    for axis in result.readings.axes:
        means = _of_power_ups(result, axis)
        key, n = Key("level_at_rest", axis), len(means)
        if n > 1:
            value, scatter = float(np.mean(means)), float(np.std(means, ddof=1)) / math.sqrt(n)
            u = math.hypot(scatter, laid)
            dof = (n - 1.0) * (u / scatter) ** 4 if scatter else math.inf
            known = dof if math.isfinite(dof) else None
            rows.append(Row(key, value, u, unit, known, t_interval(value, u, dof), shared={name: laid}))
        elif n:
            rows.append(Row(key, float(means[0]), None, unit, status="not_estimated", reason=ONE_POWER_UP))
    return Levels(rows, {name: Influence(laid, unit, standard="level", quantity=what, redrawn_by="mounting")})


def _of_power_ups(result: Result, axis: str) -> list[float]:
    """Return the mean of each power-up: of its recordings, each counting alike."""
    found: dict[str, list[float]] = {}
    for run in result.readings.records:
        mean = _mean(run, axis)
        if mean is not None:
            found.setdefault(run.power_up or run.file or run.name, []).append(mean)
    return [float(np.mean(one)) for one in found.values()]


def _mean(run: Run, axis: str) -> float | None:
    """Return the mean of the samples of an axis that are there; None where there are none."""
    rates = run.rates(axis)
    sums, count = [], 0
    for first in range(0, len(rates), BATCH):
        part = rates[first : first + BATCH]
        part = part[np.isfinite(part)]
        sums.append(float(np.sum(part)))
        count += len(part)
    return math.fsum(sums) / count if count else None
