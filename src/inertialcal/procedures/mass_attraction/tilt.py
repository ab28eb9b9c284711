"""Tilt of the pad: what the meter tells of it, and what it does to the readings of one run.

The pad tilts with the mass that moves on it, and an accelerometer feels a tilt ``theta`` as ``g theta``, with the scale
factor S that is sought. The line of the meter, in phase with the drive and less the computed tilt of its mercury, is
``tau``; a and A are what is applied and the response to it::

    S = A / (a + g tau)

- ``known``: this, with the sign of the meter as the plan states it (`tilt_sign`). The tilt off the drive is subtracted
  as well. Noise of the meter counts: it is in each dwell that is subtracted, and in tau.
- ``regressed``: the coefficient p of the meter in the readings comes from the tilt off the drive; in phase the tilt
  cannot be told from the signal. Noise of the meter draws p towards zero; p lies between that of the regression and
  that of the reverse one, and below S g. The middle is used; the range counts as an uncertainty that all runs share.
  Refused if p is not `CLEAR` standard uncertainties from zero: what the drive leaves of the tilt is noise of the meter,
  and shows not even its sign.
- ``ignored``: the response is to ``a + g tau`` with an unknown tau.

Data break it if the meter does not stand along the input axis (``known``: the tilt is taken for the whole of its angle;
``regressed`` allows for it), if its sign is the other one (an error, where the tilt off the drive shows it), and if the
mercury moves by more than the computed tilt (`tilt_meter.mercury`).
"""

from __future__ import annotations

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from .changes import regression
from .line import fit_line
from .plan import Plan
from .readings import Run

G = STANDARD_GRAVITY.value
HALF = 0.5  # of the dwells of a run, that need a tilt
CLEAR = 3.0  # standard uncertainties of the coefficient of a run from zero, that show its sign

EXTREME = 2.0  # standard uncertainties that the reverse coefficient is enlarged by


def without_tilt(plan: Plan, run: Run, tilt: Array | None, mode: str) -> tuple[Array, float, float, float]:
    """Return the readings less the share of the tilt, its coefficient, the uncertainty of it, and its range, halved.

    The latter two: from the noise of the run, and from that of the meter, the same in all runs; all [output unit/rad].

    Raises
    ------
    DataError
        ``tilt_not_regressed`` if the tilt off the drive is noise of its meter.
    """
    if tilt is None:
        return run.reading, np.nan, 0.0, 0.0
    if mode == "known":
        p = (plan.nominal or _felt(run, tilt, 1.0)) * G
        return run.reading - p * tilt, p, 0.0, 0.0
    found = regression(run.schedule, run.reading, tilt)
    if found is None or abs(found.value) < CLEAR * found.u:
        if not run.moved:
            return run.reading, 0.0, 0.0, 0.0
        what = f"{run.name}: off the drive, the readings do not show the tilt that the meter reads"
        why = "next to the tilt in phase with the mass, it reads little but its own noise"
        do = 'Set tilt = "known", with tilt_sign of the meter; or tilt = "ignored", with [standards.pad] tilt'
        raise DataError(what, run.where, why, do, "tilt_not_regressed")
    sign, size = float(np.sign(found.value)), abs(found.value)
    reverse = abs(found.reverse) * (1.0 + EXTREME * found.u / size)
    most = min(abs(_felt(run, tilt, sign)) * G, reverse) if run.moved else size
    middle, half = (0.5 * (size + most), 0.5 * (most - size)) if most > size else (size, 0.0)
    return run.reading - sign * middle * tilt, sign * middle, found.u, half


def _felt(run: Run, tilt: Array, sign: float) -> float:
    """Return the scale factor of a run if all of the tilt is felt, as an acceleration of this sign; 0 at rest."""
    if not run.moved:
        return 0.0
    there = np.isfinite(run.reading) & np.isfinite(tilt)
    x, tau = (fit_line(run.schedule, np.where(there, series, np.nan)).amplitude for series in (run.reading, tilt))
    return x / (run.schedule.amplitude + sign * G * tau)


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
    return plan.tilt
