"""What stands in the way of noise terms in one record of one axis: disturbances, which are left out, and drift.

Found by ``signals.record_quality``. A disturbed sample counts as missing; how many there are is said. Drift stays in:
how much of a warm-up to leave out is the user's to say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.estimate import Array
from ....core.remarks import Remark
from ....core.show.rounding import number
from ....core.units import factor
from ....sensors.noise.fitting.noise_fit import duration
from ....signals.codes import coarse_steps
from ....signals.record_quality import BadSegment, Drift, RecordQuality, record_quality
from ..plan import Plan
from ..readings import Run

LEVELS = {"gyro": ("rad/s", "deg/h"), "accelerometer": ("m/s^2", "ug")}  # inside, and as people say a drift of bias
FEWEST = 200  # samples from which a disturbance can be told
LISTED = 3  # stretches that are named


@dataclass(frozen=True, eq=False)
class Looked:
    """One record of one axis, looked through."""

    rates: Array  # shape (n,): SI; NaN where a sample is missing or left out
    bad: tuple[BadSegment, ...]  # Disturbances
    left_out: int  # Samples left out for them
    remarks: tuple[Remark, ...]  # What is suspicious


def looked_through(plan: Plan, run: Run, axis: str) -> Looked:
    """Return the samples of one axis as rates, without its disturbances.

    Parameters
    ----------
    plan : Plan
        Its ``disturbed`` says whether they are kept.
    run : Run
        The record.
    axis : str
        Which.
    """
    rates = run.rates(axis)
    if np.count_nonzero(np.isfinite(rates)) < FEWEST:
        return Looked(rates, (), 0, ())
    quality = record_quality(rates, run.interval)
    bad = tuple(one for one in quality.bad if one.axis == 0)
    left_out = 0
    if plan.disturbed == "leave_out":
        before = int(np.count_nonzero(np.isfinite(rates)))
        rates = quality.cleaned()[:, 0] if bad else rates
        left_out = before - int(np.count_nonzero(np.isfinite(rates)))
    remarks = [*_moving(quality, axis), *_disturbed(bad, run, axis, left_out)]
    remarks += [_drift(one, plan, run, axis) for one in quality.drifts if one.significant]
    remarks += coarse_steps(rates, axis)
    return Looked(rates, bad, left_out, tuple(remarks))


def _moving(quality: RecordQuality, axis: str) -> list[Remark]:
    if not quality.moving:
        return []
    what = f"{axis}: not at rest, or its level steps: terms of this record are those of the motion"
    return [Remark("not_at_rest", "warning", what, do="Record the sensor standing still, or choose a part at rest")]


def _disturbed(bad: tuple[BadSegment, ...], run: Run, axis: str, left_out: int) -> list[Remark]:
    if not bad:
        return []
    worst = max(one.peak for one in bad)
    spans = [f"{number(run.time(one.first), 6)} .. {number(run.time(one.last), 6)} s" for one in bad[:LISTED]]
    spans += ["..."] if len(bad) > LISTED else []
    fate = f"left out: {left_out} of {len(run)} samples" if left_out else "kept in"
    what = f"{axis}: disturbed at {', '.join(spans)}, by up to {number(worst, 3)} times the noise; {fate}"
    do = "" if left_out else "Leave them out, or record again undisturbed"
    return [Remark("disturbed", "warning", what, count=len(bad), do=do)]


def _drift(drift: Drift, plan: Plan, run: Run, axis: str) -> Remark:
    times, unit = 1.0, plan.unit or "file units"
    if plan.kind is not None:
        inside, unit = LEVELS[plan.kind]
        times = factor(inside, unit)
    return drift.remark(axis, times, unit, f"the first {duration(run.length / 3.0)}")
