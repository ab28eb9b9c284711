"""Which of several recordings of one sensor at rest are in another unit than the others, or have another sign.

Two figures of a recording are compared with the medians of the others: the density of its white noise, which hardly
changes from run to run, and its mean, where those of the others agree closely. What differs by the factor between two
units of the kind, or by a prefix, is in another unit; a mean that is minus that of the others has another sign. Noise
that differs by other factors is for the test of the fit (``runs_disagree``). Means of accelerometers are not compared:
they depend on the face that the unit lies on.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.estimate import Array
from ...core.remarks import Remark
from ...signals.screening.screen import noise_of
from ..agreement import Cause, unit_mistaken
from .plan import Plan
from .readings import Readings, Run

UNITS = {"gyro": "angular_rate", "accelerometer": "acceleration", None: ""}
FEWEST = 3  # recordings, of which the others agree
CLOSE = 0.02  # of their mean, that the means of the others scatter
SAME = 0.1  # of their mean, that minus a mean may differ from it
CLEAR = 10.0  # standard deviations of white noise in a mean


def agreement(plan: Plan, readings: Readings) -> Iterator[Remark]:
    """Yield a remark a recording that is in another unit than the others, or has another sign."""
    if len(readings) < 2:
        return
    noise = np.array([[_density(run, axis) for axis in readings.axes] for run in readings.records])
    mean = np.array([[_mean(run, axis) for axis in readings.axes] for run in readings.records])
    sure = np.array([CLEAR / np.sqrt(max(run.length, run.interval)) for run in readings.records])[:, None] * noise
    for i, run in enumerate(readings.records):
        others = np.arange(len(readings)) != i
        loud, level = _ratio(noise, i, others), _ratio(mean, i, others)
        steady = np.zeros(len(readings.axes), dtype=bool)
        if len(readings) >= FEWEST and plan.kind != "accelerometer":
            middle = np.abs(np.median(mean[others], axis=0))
            steady = (np.ptp(mean[others], axis=0) <= CLOSE * middle) & (np.abs(mean[i]) > sure[i]) & (middle > sure[i])
        for ratio, told, of in ((loud, np.isfinite(loud), "noise"), (level, steady & (level > 0.0), "mean")):
            unit = _unit(ratio[told], UNITS[plan.kind])
            if unit:
                axes = ", ".join(axis for axis, one in zip(readings.axes, told.tolist(), strict=True) if one)
                size = f"{float(np.median(ratio[told])):.3g} times that of the other recordings"
                cause = Cause(
                    "unit_disagrees", f"the {of} of {axes} is {size}: {unit}", "State the unit of this recording"
                )
                yield cause.remark(run.name, run.file)
                break
        turned = steady & (np.abs(level + 1.0) < SAME)
        if turned.any():
            axes = ", ".join(axis for axis, one in zip(readings.axes, turned.tolist(), strict=True) if one)
            what = f"the mean of {axes} is minus that of the other recordings: the sign is inverted"
            do = "Check the sign of the column and how the sensor was mounted"
            yield Cause("sign_disagrees", what, do).remark(run.name, run.file)


def _density(run: Run, axis: str) -> float:
    """Return the density of white noise of a record [SI sqrt(s)]; NaN where it is not known."""
    found = run.found.get(axis)
    noise = 0.0 if found is None else found.noise
    if found is not None and not found.findings and not noise:  # of a sound record it was not looked for
        noise = noise_of(run.values[axis])
    if not noise > 0.0:
        return float("nan")
    return noise * float(np.sqrt(run.interval)) / (1.0 if run.quantity == "rate" else run.interval)


def _mean(run: Run, axis: str) -> float:
    there = run.rates(axis)[run.there(axis)]
    return float(there.mean()) if len(there) else float("nan")


def _ratio(values: Array, i: int, others: Array) -> Array:
    """Return the figures of one record over the medians of the others, by axis; NaN where nothing tells."""
    middle = np.median(values[others], axis=0)
    return np.asarray(values[i] / np.where(np.abs(middle) > 0.0, middle, np.nan))


def _unit(ratio: Array, kind: str) -> str:
    """Return which unit all axes were mistaken for; empty for none."""
    found = {unit_mistaken(float(one), kind) for one in ratio}
    return found.pop() if len(found) == 1 else ""
