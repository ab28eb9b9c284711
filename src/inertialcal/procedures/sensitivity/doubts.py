"""What speaks against a sensitivity: few power-ups, readings that depend on the way to a level, drift, curvature."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.units import factor
from .design import NEAR, TOGETHER, Column, within
from .fit import SensorFit
from .plan import PRESSURE, PUMP, SUPPLY, TEMPERATURE, Plan
from .readings import Readings, ends

FEW = 5  # power-ups, below which their scatter is badly known
SURE = 1e-4  # chance of a doubt where there is none
MOVED = 2.0  # standard uncertainties, by which a drift that is left out moves a term
SAME = 0.05  # of the range of a condition: no step
ALIKE = 1.5  # ratio of two factors that are one, their noise left aside
IN_TORR = (680.0, 830.0)  # pressure of the air, 90 to 110 kPa [Torr]
RESOLUTION = "supply_meter.resolution"


def remarks_on_power_ups(plan: Plan, readings: Readings) -> list[Remark]:
    """Return remarks on power-ups without a condition that was asked for, and on too few others."""
    found: list[Remark] = []
    whole = set(readings.power_ups)
    for name in (one for one in plan.to if one in readings.conditions):
        known = np.any([np.isfinite(levels) for levels in readings.conditions[name].values()], axis=0)
        lacking = [run for run in readings.power_ups if not known[readings.run == run].any()]
        whole -= set(lacking)
        for run in lacking:
            what = f"power-up {run} has no {name}: its levels do not count"
            do = "Record it with the readings, or leave the power-up out"
            found.append(Remark("missing_condition", "warning", what, do=do, subject=f"{name} {run}"))
        found += _units(name, readings)
    if len(whole) >= FEW:
        return found
    if len(whole) < 2:
        what = "one power-up: nothing tells whether a sensitivity repeats; figures rest on the scatter between levels"
        return [*found, Remark("few_runs", "warning", what, do="Record the same levels in 2 power-ups or more")]
    what = f"{len(whole)} power-ups: the scatter between them is badly known, intervals are wide"
    return [*found, Remark("few_runs", "info", what, do=f"Record {FEW} or more for a narrower interval")]


def _units(name: str, readings: Readings) -> list[Remark]:
    """Return remarks on power-ups whose condition is that of the others times a factor, and on air in Torr."""
    if name == TEMPERATURE:
        return []
    columns: dict[str, list[Array]] = {}
    for one in readings.recorded:
        columns.setdefault(one.run or one.name, []).extend(one.conditions.get(name, {}).values())
    limits = {run: own for run, some in columns.items() if (own := ends(some))[0] > 0.0}
    if not limits:
        return []
    usual = np.median(np.array(list(limits.values())), axis=0)
    found = []
    for run, own in limits.items():
        low, high = np.array(own) / usual
        if not 1.0 / NEAR < high < NEAR and 1.0 / ALIKE < low / high < ALIKE:
            what = f"{name} of power-up {run} is {high:.3g} times that of the others, lowest and highest alike"
            do = "Check the unit of its column"
            found.append(Remark("unit_differs", "warning", what, do=do, subject=f"{name} {run}"))
    if name == PRESSURE and IN_TORR[0] < usual[1] < IN_TORR[1]:
        what = f"the highest pressure is {usual[1]:.3g} Pa: air has so many Torr, and about 100 000 Pa"
        do = f"Check the unit of its column: --unit {PRESSURE}=Torr"
        found.append(Remark("unit_differs", "warning", what, do=do, subject=name))
    return found


def doubts(plan: Plan, readings: Readings, fit: SensorFit) -> list[Remark]:
    """Return remarks on what the fit of one sensor does not allow for."""
    if fit.own is None:
        return []
    found: list[Remark] = []
    design, time = fit.design, readings.time[fit.design.chosen]
    timed = bool(np.all(np.isfinite(time)))
    for one in (column for column in fit.columns if not column.warm and not column.scale and column.key in fit.keys):
        steps = _steps(one.values, design.runs, np.lexsort((time, design.runs)))
        if timed:
            found += _drifts(plan, fit, one, time)
            found += _added(plan, readings, fit, np.sign(steps), one.condition, "path_dependent")
        found += _added(plan, readings, fit, one.values**2, one.condition, "curved")
        found += _settles(plan, readings, fit, one.condition, steps)
        stated = one.condition == SUPPLY and RESOLUTION in plan.standards
        if readings.scatter[one.condition] == 0.0 and one.condition != PUMP and not stated:
            what = f"{one.condition} repeats the same value at each level: set, not measured, or coarser than its noise"
            do = "Record what was measured"
            do += f", or state its error (standards.{RESOLUTION})" if one.condition == SUPPLY else ""
            found.append(Remark("set_values", "info", what, do=do, subject=one.condition))
    return found


def _spoken(plan: Plan, value: float, readings: Readings) -> str:
    unit = plan.unit or readings.unit
    return f"{value * factor(readings.unit, unit):.2g} {unit}"


def _steps(values: Array, runs: NDArray[np.str_], ordered: NDArray[np.intp]) -> Array:
    """Return by how much a condition changed before each level of its power-up; 0 for the first."""
    steps = np.zeros(len(values))
    same = runs[ordered][1:] == runs[ordered][:-1]
    steps[ordered[1:]] = np.where(same, np.diff(values[ordered]), 0.0)
    steps[np.abs(steps) < SAME * np.ptp(values)] = 0.0
    return steps


def _settles(plan: Plan, readings: Readings, fit: SensorFit, name: str, steps: Array) -> list[Remark]:
    """Return a remark where readings still follow a change in the second half of a level."""
    axis = fit.design.axis
    late = readings.settling[axis][fit.design.chosen] * np.sign(steps)
    late = late[(steps != 0.0) & np.isfinite(late)]
    if len(late) < 3 or not late.std() > 0.0:
        return []
    t = float(late.mean() / (late.std(ddof=1) / np.sqrt(len(late))))
    if 2.0 * float(special.stdtr(len(late) - 1, -abs(t))) > SURE:
        return []
    change = _spoken(plan, float(late.mean()), readings)
    what = f"{axis} still settles after changes of {name}: {change} from the first half of a level to the second"
    do = "Leave the beginning of each level out (settle), or record each level for longer"
    return [Remark("not_settled", "warning", what, do=do, axis=axis, subject=name)]


def _drifts(plan: Plan, fit: SensorFit, own: Column, time: Array) -> list[Remark]:
    """Return a remark where a drift with time that is left out moves a term."""
    design = fit.design
    assert fit.own is not None  # noqa: S101 - the caller looked
    columns = within(np.column_stack([*(one.values for one in fit.columns), time]), design.runs)
    sizes = np.linalg.norm(columns, axis=0)
    if not np.all(sizes > 0.0) or plan.drift:
        return []
    unit = columns / sizes
    do = "Take the levels up and down again, or record after the warm-up"
    if float(unit[:, fit.columns.index(own)] @ unit[:, -1]) ** 2 > TOGETHER:
        what = f"{own.condition} changes with time: a drift is taken for a sensitivity of {design.axis}"
        return [Remark("one_order", "warning", what, do=do, axis=design.axis, subject=own.condition)]
    solve, spare = np.linalg.pinv(unit), fit.own.spare - 1.0
    coefficients = solve @ fit.own.local
    left = fit.own.local - unit @ coefficients
    u = float(np.sqrt(left @ left / max(spare, 1.0) * (solve @ solve.T)[-1, -1]))
    at = fit.columns.index(own)
    shift = abs(coefficients[at] / sizes[at]) / float(np.sqrt(fit.own.covariance[1 + at, 1 + at]))
    sure = spare >= 1.0 and u > 0.0 and 2.0 * float(special.stdtr(spare, -abs(coefficients[-1] / u))) < SURE
    if not sure or shift < MOVED:
        return []
    what = f"{design.axis} drifts, which moves its sensitivity to {own.condition} by {shift:.1f} standard uncertainties"
    do = f"Fit the drift: --drift 1. Better: {do[0].lower()}{do[1:]}"
    return [Remark("one_order", "warning", what, do=do, axis=design.axis, subject=own.condition)]


WHAT = {
    "path_dependent": (
        "{} reads otherwise on the way up and down of {}",
        "Wait longer at each level, or leave its beginning out (settle)",
    ),
    "curved": ("the bias of {} is curved over {}", "Take a narrower range"),
}


def _added(plan: Plan, readings: Readings, fit: SensorFit, column: Array, name: str, code: str) -> list[Remark]:
    """Return a remark where one more column explains more than chance."""
    own, design = fit.own, fit.design
    assert own is not None  # noqa: S101 - the caller looked
    columns = within(np.column_stack([one.values for one in fit.columns]), design.runs)
    unit = columns / np.linalg.norm(columns, axis=0)
    left = within(column, design.runs)
    left = left - unit @ np.linalg.lstsq(unit, left, rcond=None)[0]
    size, spare = float(left @ left), own.spare - 1.0
    if size < (1.0 - TOGETHER) * float(column @ column) * SAME or spare < 1.0:
        return []
    part = float(left @ own.local) ** 2 / size
    rest = (float(own.local @ own.local) - part) / spare
    if rest <= 0.0 or 2.0 * float(special.stdtr(spare, -np.sqrt(part / rest))) > SURE:
        return []
    effect = _spoken(plan, abs(float(left @ own.local)) / size * float(np.ptp(left)), readings)
    text, do = WHAT[code]
    what = f"{text.format(design.axis, name)}, by {effect} over its range"
    return [Remark(code, "warning", what, do=do, axis=design.axis, subject=name)]


__all__ = ["doubts", "remarks_on_power_ups"]
