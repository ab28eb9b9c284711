"""Runs of a moved mass against each other, and each against itself: sign, gain, phase, jumps.

*Between runs.* Runs that respond unlike the others are found in two ways. The majority shows how much runs scatter
(``statistics.agreement``), whatever makes them. And no instrument changes its scale factor by ``MUCH`` from run to run:
a run that is so far off, and further than its noise explains, is named however few runs there are.

*Phase.* The quadrature of a run against the median of the others, by its noise: a part of the response, ``MUCH`` or
more, that comes at another time.

*Inside runs.* A response that changes, more jumps than can be subtracted, and what happens at the same dwell of every
run, as ``changes`` finds them: the scatter of the runs shows nothing of the latter.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...signals.sine.changes import critical
from ...statistics.agreement import FALSE_ALARM, disagreeing
from ..agreement import likely_cause
from .changes import MOST, Change, common_change, regression
from .joining import phases_ahead, quiet_runs
from .plan import Plan
from .readings import Readings, Run
from .response import Response, response_of_line
from .tilt import CLEAR, pad_tilt, tilt_used

PART = FALSE_ALARM / 3.0  # of each search between the runs
MUCH = 0.25  # part of a response
MEDIAN = 1.2533  # standard deviation of a median over that of the mean
CUT = "Leave the run out, or cut it there: a jump that comes with the schedule is taken for a response"


class Measured(NamedTuple):
    """A run or recording with its response along an axis, and its file."""

    name: str
    value: float
    u: float
    dof: float
    where: str
    response: Response | None = None
    run: Run | None = None


def agreement(plan: Plan, readings: Readings) -> list[Remark]:
    """Return where runs disagree with each other or with themselves."""
    found: list[tuple[Response, str, Run | None]] = [
        (response_of_line(line), line.where, None) for line in readings.lines
    ]
    for one in quiet_runs(readings.series):
        try:
            found.append((one.response(plan), one.run.where, one.run))
        except (DataError, PlanError):  # the reduction says why
            continue
    measured = [Measured(one.name, one.scale_factor, one.u_scale_factor, one.dof, where, one, run)
                for one, where, run in found]  # fmt: skip
    moved = [one for one in measured if one.response is not None and one.response.moved]
    return [
        *_between(plan, moved),
        *_within([one for one in measured if one.run is not None]),
        *_tilt_sign(plan, readings),
    ]


def _between(plan: Plan, moved: Sequence[Measured]) -> list[Remark]:
    """Return runs unlike the others; where they are, and the drives start at several phases, unlike those of theirs.

    A drift that repeats responds with another sign in runs whose drive starts at another phase.
    """

    def search(runs: Sequence[Measured]) -> list[Remark]:
        return [
            *unlike_others(runs, plan.axis, plan.nominal, "run"),
            *_phases([one.response for one in runs if one.response is not None], [one.where for one in runs]),
        ]

    remarks = search(moved)
    if not remarks:
        return remarks
    ahead = phases_ahead([one.response for one in moved if one.response is not None])
    if not np.any(ahead):
        return remarks
    alike = [[one for one, phase in zip(moved, ahead, strict=True) if phase == start] for start in np.unique(ahead)]
    return [remark for runs in alike for remark in search(runs)]


def _against(values: Array, u: Array, k: int) -> tuple[float, float]:
    """Return the median of all but the k-th value, and the standard uncertainty of their difference."""
    others = np.delete(values, k)
    rest = np.delete(u, k)
    return float(np.median(others)), float(np.hypot(u[k], MEDIAN * np.sqrt(np.mean(rest**2) / len(rest))))


def unlike_others(measured: Sequence[Measured], axis: str, nominal: float | None, kind: str) -> Iterator[Remark]:
    """Yield which runs, or recordings, respond unlike the others.

    Parameters
    ----------
    measured : sequence of Measured
        Made alike.
    axis : str
        That responds.
    nominal : float, optional
        Of the values, which decides where no majority agrees.
    kind : str
        What one is called: ``"run"``.
    """
    n = len(measured)
    values, u, dof = np.array([[m.value, m.u, m.dof] for m in measured]).T if n > 1 else np.empty((3, 0))
    if n < 2 or not np.all(u > 0.0):
        return
    apart = disagreeing(values, u, PART)
    limit = critical(PART / n, float(np.min(dof)))
    for k in range(n):
        middle, u_difference = _against(values, u, k)
        away = abs(values[k] - middle)
        apart[k] |= bool(away > limit * u_difference and away > MUCH * max(abs(middle), np.min(np.abs(values))))
    split = 2 * apart.sum() >= n
    middle = float(np.median(values if split else values[~apart]))
    if split and nominal:  # no majority: the data sheet knows the sign
        middle = nominal
    for k in np.flatnonzero(apart).tolist():
        one = measured[k]
        if middle == 0.0:
            what = f"{kind} {one.name} responds, the others do not"
            do = f"Check gain, schedule and input of this {kind}"
            yield Remark("gain_disagrees", "error", what, one.where, do=do, axis=axis, subject=one.name)
            continue
        ratio, noise = values[k] / middle, u[k] / abs(middle)
        cause = likely_cause({axis: ratio}, axis, max(MUCH, 4.0 * noise), applied="the response of the others")
        if cause is not None and cause.code in ("sign_disagrees", "unit_disagrees"):
            yield replace(cause.remark(f"{kind} {one.name}", one.where, axis), subject=one.name)
            continue
        if split and nominal and cause is None:
            continue
        what = f"{kind} {one.name} responds {number(ratio, 4)} times as much as the others"
        what += "; no majority agrees" if split else ""
        do = f"Check gain, schedule and input of this {kind}; leave it out if they are not those of the others"
        yield Remark("gain_disagrees", "error", what, one.where, do=do, axis=axis, subject=one.name)


def _phases(moved: Sequence[Response], where: Sequence[str]) -> Iterator[Remark]:
    known = [(one, place) for one, place in zip(moved, where, strict=True) if one.u_quadrature > 0.0]
    if len(known) < 2:
        return
    values = np.array([one.quadrature / one.applied for one, _ in known])
    u = np.array([one.u_quadrature / one.applied for one, _ in known])
    size = float(np.median([abs(one.scale_factor) for one, _ in known]))
    limit = critical(PART / len(known), float(min(one.dof for one, _ in known)))
    for k, (one, place) in enumerate(known):
        middle, u_difference = _against(values, u, k)
        if abs(values[k] - middle) > max(limit * u_difference, MUCH * size):
            turn = float(np.degrees(np.arctan2(values[k], one.scale_factor)))
            what = f"run {one.name} responds {number(turn, 3)} deg ahead of its schedule, unlike the others"
            do = "Check begin, the clock and the schedule of this run"
            yield Remark("recording_differs", "error", what, place, do=do, subject=one.name)


def _within(measured: Sequence[Measured]) -> Iterator[Remark]:
    """Yield the faults within runs that cannot be subtracted, then those at the same dwell of every run."""
    sound = []
    for one in measured:
        assert one.response is not None  # noqa: S101 - of a run with readings
        assert one.response.changes is not None  # noqa: S101
        assert one.run is not None  # noqa: S101
        changes = one.response.changes
        if changes.repairable:
            sound.append((one.run, one.response))
            continue
        last = changes.found[-1]
        if last.kind == "gain":
            yield _fault(last, f"run {one.name}", one.where, one.name)
            continue
        places = ", ".join(str(change.at + 1) for change in changes.found)
        what = f"run {one.name}: more than {MOST} jumps or false readings, at dwells {places}"
        yield Remark("jump", "error", what, one.where, do=CUT, subject=one.name, index=last.at)
    moved = [(run, response) for run, response in sound if run.moved]
    found = [one for _, response in moved for one in (response.changes.found if response.changes else ())]
    near = sorted({one.at for one in found if one.kind in ("jump", "kink")})
    quiet = len(moved) > 1 and bool(np.any(phases_ahead([response for _, response in moved])))
    series = [(run.schedule, response.series) for run, response in moved]
    common = common_change(series, near, len(moved) - 1.0 if quiet else None)
    if common is not None:
        yield _fault(common, "every run", sound[0][0].where, "")


def _fault(change: Change, subject: str, where: str, name: str) -> Remark:
    dwell = change.at + 1
    if change.kind == "gain":
        ratio = f" to {number(change.size, 3)} times what it was" if change.size else ""
        what = f"{subject}: the response changes{ratio}, near dwell {dwell}"
        do = "Check gain and range of the instrument, and whether the mass still moved as it should"
        return Remark("scale_changed", "error", what, where, do=do, subject=name, index=change.at)
    if change.kind == "slip":
        what = f"{subject}: from dwell {dwell} on the readings fit a mass off its schedule"
        do = "Find the lost dwell or move, and correct the schedule or its begin"
        return Remark("schedule_slip", "error", what, where, do=do, subject=name, index=change.at)
    place = (
        f"the reading of dwell {dwell} is off" if change.kind == "reading" else f"the level jumps before dwell {dwell}"
    )
    return Remark("jump", "error", f"{subject}: {place}", where, do=CUT, subject=name, index=change.at)


def _tilt_sign(plan: Plan, readings: Readings) -> Iterator[Remark]:
    """Yield an error if the tilt off the drive is felt with the other sign than the plan states."""
    weights = shares = 0.0
    for run in readings.series:
        if run.tilt is None or tilt_used(plan, run) != "known":
            continue
        found = regression(run.schedule, run.reading, pad_tilt(plan, run))
        if found is not None and found.u > 0.0:
            weights, shares = weights + found.u**-2, shares + found.value / found.u**2
    if weights and shares < -2.0 * CLEAR * np.sqrt(weights):
        what = f"tilt_sign = {plan.tilt_sign}: off the drive, the readings show the tilt with the other sign"
        do = f"Set tilt_sign = {-plan.tilt_sign}, if the scale factor of the chain is positive"
        yield Remark("tilt_sign_disagrees", "error", what, do=do)
