"""Tilt of the pad in the readings of one run."""

from __future__ import annotations

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import PlanError
from ...core.estimate import Array
from ...signals.sine.fit import contrasts_of
from .line import line_design
from .plan import Plan
from .readings import Run

G = STANDARD_GRAVITY.value


HALF = 0.5  # of the dwells of a run, that need a tilt


def without_tilt(plan: Plan, run: Run, tilt: Array | None, mode: str) -> tuple[Array, float, float]:
    """Return the readings less the share of the tilt, its coefficient and the uncertainty of it [count/s/rad]."""
    if tilt is None:
        return run.reading, np.nan, 0.0
    if mode == "known":
        p = (plan.nominal or 0.0) * G
        return run.reading - p * tilt, p, 0.0
    both = np.column_stack([run.reading, tilt / np.nanstd(tilt)])
    there = np.isfinite(both).all(axis=1)
    x, y = np.concatenate(contrasts_of(line_design(run.schedule, there), both[there])[0]).T
    p = float(x @ y / (y @ y))
    residual = float(np.sum((x - p * y) ** 2)) / max(len(x) - 1, 1)
    scale = float(np.nanstd(tilt))
    return run.reading - p / scale * tilt, p / scale, float(np.sqrt(residual / (y @ y))) / scale


def pad_tilt(plan: Plan, run: Run) -> Array:
    """Return the tilt of the pad about its mean, with the sign that is felt, mercury subtracted [rad].

    Raises
    ------
    PlanError
        If plan and schedule both state the tilt of the mercury.
    """
    tilt, schedule = run.tilt, run.schedule
    assert tilt is not None  # noqa: S101 - checked before
    if schedule.mercury is not None and plan.mercury and run.moved:
        what = f"{run.name}: plan.mercury, and a column mercury in the schedule"
        raise PlanError(what, why="it would be subtracted once only", do="Keep one of them", code="contradiction")
    if run.moved:
        computed = plan.mercury * (schedule.applied - schedule.applied.mean()) / schedule.amplitude
        tilt = tilt - (computed if schedule.mercury is None else schedule.mercury)
    middle = np.nanmean(tilt) if np.isfinite(tilt).any() else 0.0
    return np.asarray(plan.tilt_sign * (tilt - middle))


def tilt_used(plan: Plan, run: Run) -> str:
    """Return how the tilt of a run is used: not at all if half of its dwells or more lack one."""
    if plan.tilt == "ignored" or run.tilt is None:
        return "ignored"
    wanted = np.isfinite(run.reading)
    have = np.isfinite(run.tilt) & wanted
    if have.sum() <= HALF * wanted.sum() or not np.ptp(run.tilt[have]) > 0.0:
        return "ignored"
    return "ignored" if plan.tilt == "known" and not plan.nominal else plan.tilt
