"""Recordings of a drive against each other, and each against itself: sign, gain, jumps.

Recordings with a schedule know what was applied: their responses along one axis must agree, as runs of a moved mass do
(``mass_attraction.agreement``). Inside each recording the level must not jump, and the response must stay
(``signals.sine.changes``); both are looked for where a response stands out of the noise.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...signals.sine.changes import cycle_amplitudes, jumps, response_changes
from ...signals.sine.fit import LineFit
from ...statistics.agreement import FALSE_ALARM
from ..mass_attraction.agreement import MUCH, Measured, unlike_others
from .inputs import Driven
from .plan import Plan
from .reduction import Readings

PART = FALSE_ALARM / 4.0  # of each search
SPARSE = 4  # times as long as its readings, from which a recording is not laid on a grid
LEAST_JUMP = 0.5  # responses, from which a jump matters
STANDS_OUT = 8.0  # standard uncertainties of a response that is looked into


def agreement(plan: Plan, readings: Readings) -> list[Remark]:
    """Return where recordings of a drive disagree with each other or with themselves."""
    fitted: list[tuple[Driven, LineFit]] = []
    for one in readings.driven:
        try:
            fitted.append((one, one.fit))
        except (DataError, PlanError):  # the reduction says why
            continue
    found: list[Remark] = []
    for axis in dict.fromkeys(one.channel.axis for one, _ in fitted):
        alike = [
            Measured(one.name, float(fit.in_phase[0]) / one.applied, float(fit.u_in_phase[0]) / one.applied,
                     float(fit.dof[0]),                     one.where)
            for one, fit in fitted if one.channel.axis == axis and one.applied
        ]  # fmt: skip
        found += unlike_others(alike, axis, None, "recording")
    clear = [(one, fit) for one, fit in fitted if _size(fit) > STANDS_OUT * float(fit.u_in_phase[0])]
    return [*found, *(remark for one, fit in clear for remark in _inside(one, fit, PART / len(clear)))]


def _size(fit: LineFit) -> float:
    return float(np.hypot(fit.in_phase[0], 0.0 if fit.quadrature is None else fit.quadrature[0]))


def _inside(one: Driven, fit: LineFit, chance: float) -> Iterator[Remark]:
    """Yield jumps and changes of the response in a recording."""
    line, drift = fit.fitted()
    drive, name = fit.design.drive, f"recording {one.name}: {one.channel.name}"
    grid = np.rint((drive.times - drive.times[0]) / drive.step).astype(np.int64)
    grid = grid if grid[-1] < SPARSE * len(grid) else np.arange(len(grid))
    rest: Array = np.full(int(grid[-1]) + 1, np.nan)
    rest[grid] = one.readings - line
    jump = jumps([rest], chance)[0]
    if jump is not None and abs(jump.size) > LEAST_JUMP * _size(fit):
        what = f"{name}: the level jumps by {number(abs(jump.size) / _size(fit), 2)} times the response"
        place = f"{one.where}: {drive.times[0] + jump.at * drive.step:.6g} s"
        do = "Cut the recording there: a jump is taken for a part of the response"
        yield Remark("jump", "error", what, place, do=do, axis=one.channel.axis, subject=one.name)
    cycle = np.floor((drive.times - drive.times[0]) * drive.frequency + 1e-9).astype(np.int64)
    each, first = cycle_amplitudes(one.readings - drift, line, cycle)
    change = response_changes([each], chance)[0]
    if change is not None and abs(change.after - change.before) > MUCH * min(abs(change.before), abs(change.after)):
        ratio = number(change.after / change.before, 3) if change.before else "-"
        what = f"{name}: the response becomes {ratio} times what it was"
        place = f"{one.where}: {drive.times[first[change.at]]:.6g} s"
        do = "Check gain and range, and whether the drive stayed as it should"
        yield Remark("scale_changed", "error", what, place, do=do, axis=one.channel.axis, subject=one.name)
