"""Sensitivities of bias and scale factor: weighted least squares with an intercept a power-up.

Levels are weighed by what is known of their noise and by what they scatter beyond it. The covariance is that of the
scatter between power-ups (CR2, ``statistics.own_offsets``), with Student's t of its degrees of freedom: whatever slow
noise, warm-up or repeatability makes the levels of one power-up alike counts there once.

Assumed: power-ups are independent of each other; within one, the conditions were set without regard to the readings.
``u`` is the standard uncertainty of a coefficient between power-ups, with what standards, resolution and stated terms
add. Broken by: (1) a condition that always comes in the same order under a drift, as self-heating is: common to all
power-ups, it is taken for a sensitivity (remarks ``one_order``, ``path_dependent``, ``not_settled``); (2) a condition
that another one follows: refused (``conditions_together``); (3) a channel that is stuck, coarse or in a wrong unit
(``condition_constant``, Type B of the resolution, ``impossible_value``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import Key, Origin
from ...core.remarks import Remark
from ...core.results import Row
from ...statistics.own_offsets import OwnOffsets, fit_own_offsets
from .design import Column, Design, design_of, references_of, within
from .plan import PRESSURE, SUPPLY, TEMPERATURE, WARM_UP, Plan
from .readings import Readings
from .stated import Stated, stated_terms
from .warm_up import joint_warm_up
from .warm_up_model import WarmUpModel

FEW = 5  # power-ups, below which their scatter is badly known
SURE = 1e-4  # chance of a doubt where there is none
ORDERED = 0.9  # correlation of a condition with time, in all power-ups
GAINS = {SUPPLY: "supply_meter.voltage", PRESSURE: "pressure_gauge.pressure"}


@dataclass(frozen=True, eq=False)
class SensorFit:
    """What was found about one sensor."""

    design: Design
    columns: tuple[Column, ...]  # Those that were fitted, without the stated ones
    own: OwnOffsets | None  # None where nothing could be fitted
    stated: tuple[Stated, ...]

    @property
    def keys(self) -> tuple[Key, ...]:
        """Of the terms that are published, in the order of the columns."""
        refused = self.design.refused
        return tuple(one.key for one in self.columns if one.key is not None and one.key not in refused)

    @property
    def at(self) -> list[int]:
        """Number of the coefficient of each of these terms."""
        keys = self.keys
        return [1 + i for i, one in enumerate(self.columns) if one.key in keys]

    @property
    def runs(self) -> int:
        """Power-ups that the fit has."""
        return len(np.unique(self.design.runs))

    def coefficient(self, column: Column) -> float:
        """Return the coefficient of a column, fitted."""
        assert self.own is not None  # noqa: S101 - asked for columns that were fitted
        return float(self.own.coefficients[1 + self.columns.index(column)])


@dataclass(frozen=True, eq=False)
class Result:
    """Sensitivities of all sensors."""

    plan: Plan
    readings: Readings
    references: Mapping[str, float]
    sensors: Mapping[str, SensorFit]
    estimate: Estimate | None
    remarks: tuple[Remark, ...]
    warm_up: WarmUpModel | None = None  # Where it was asked for

    def rows(self) -> list[Row]:
        """Return a row a term that was asked for."""
        from .rows import rows  # noqa: PLC0415 - rows know the result

        return rows(self)

    def curves(self) -> list[Curve]:
        """Return readings against each condition, and what is left of them."""
        from .curves import curves  # noqa: PLC0415 - the same

        return curves(self)

    @cached_property
    def by_key(self) -> Mapping[Key, Stated]:
        """Stated terms by key."""
        return {one.key: one for fit in self.sensors.values() for one in fit.stated}


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return the sensitivities of all sensors.

    Raises
    ------
    DataError
        ``missing_condition``, ``impossible_value``; ``too_few_levels`` where no sensor leaves a scatter to judge by.
    """
    references = references_of(plan, readings)
    linear = readings.axes if set(plan.to) != {WARM_UP} else ()
    sensors = {axis: _fitted(plan, readings, design_of(plan, readings, axis, references)) for axis in linear}
    remarks = [*readings.remarks, *(_of_power_ups(readings) if linear else ())]
    for fit in sensors.values():
        remarks += [*fit.design.remarks, *_doubts(readings, fit)]
    estimates = [one for fit in sensors.values() if (one := _estimate(plan, readings, fit)) is not None]
    warm_up = joint_warm_up(plan, readings) if WARM_UP in plan.to else None
    if warm_up is not None:
        estimates += [] if warm_up.estimate is None else [warm_up.estimate]
        remarks += warm_up.remarks
    return Result(plan, readings, references, sensors, _side_by_side(estimates), tuple(remarks), warm_up)


def _fitted(plan: Plan, readings: Readings, design: Design) -> SensorFit:
    stated = stated_terms(plan, design)
    known = {one.key for one in stated}
    columns = tuple(one for one in design.columns if one.key not in known)
    y = design.readings - sum((one.value * one.column.values for one in stated), np.zeros(len(design.readings)))
    if not columns:
        return SensorFit(design, columns, None, stated)
    slopes = np.column_stack([one.values for one in columns])
    noise = np.square(readings.noise[design.axis][design.chosen])
    own = fit_own_offsets(slopes, y, design.runs, design.runs)
    if own is None:
        groups = len(np.unique(design.runs))
        what = f"{design.axis}: {len(y)} levels of {groups} power-ups for {len(columns)} terms and {groups} intercepts"
        do = "Record more levels, lower order, or interactions = false"
        raise DataError(what, why="no scatter is left to judge by", do=do, code="too_few_levels")
    if np.all(np.isfinite(noise)):
        beyond = max(own.mean_square - float(noise.mean()), 0.0)
        variances = noise + beyond
        if variances.min() > 0.0:
            weights = variances.mean() / variances
            own = fit_own_offsets(slopes, y, design.runs, design.runs, weights) or own
    return SensorFit(design, columns, own, stated)


def _estimate(plan: Plan, readings: Readings, fit: SensorFit) -> Estimate | None:
    """Return the published terms of one sensor with what is not known of each."""
    stated = [one for one in fit.stated if one.key not in fit.keys]
    keys = (*fit.keys, *(one.key for one in stated))
    if not keys:
        return None
    own, at, n = fit.own, fit.at, len(fit.keys)
    values = np.array([*([] if own is None else own.coefficients[at]), *(one.value for one in stated)])
    units = (*(one.unit for one in fit.columns if one.key in fit.keys), *(one.column.unit for one in stated))
    components = []
    if own is not None and n:
        covariance, dof = np.zeros((len(keys), len(keys))), np.full(len(keys), np.inf)
        covariance[:n, :n], dof[:n] = own.covariance[np.ix_(at, at)], own.dof[at]
        level = "run" if fit.runs > 1 else "level"
        what = "scatter between power-ups" if fit.runs > 1 else "scatter between levels"
        components.append(Component(Origin(what, level=level), "A", covariance, dof))
    for origin, changes, stated_as, names in _of_type_b(plan, readings, fit, stated):
        if changes.any():
            components.append(Component(origin, "B", changes.T @ changes, np.inf, "normal", stated_as, changes, names))
    return Estimate(keys, values, units, tuple(components))


def applies(influence: str, result: Result) -> bool:
    """Tell whether an influence can change a result."""
    columns = [one for fit in result.sensors.values() for one in fit.columns if one.key in fit.keys]
    if influence in GAINS.values():
        return any(GAINS.get(one.condition) == influence for one in columns)
    if influence == "rate_table.rate":
        return any(one.scale for one in columns)
    return influence == "thermometer.temperature" and any(one.warm for one in columns)


TypeB = tuple[Origin, Array, tuple[float, str] | None, tuple[str, ...]]


def _of_type_b(plan: Plan, readings: Readings, fit: SensorFit, stated: Sequence[Stated]) -> list[TypeB]:
    """Return origin, changes (s, k), size and unknowns of what is not seen in any scatter."""
    found: list[TypeB] = []
    k, n = len(fit.keys) + len(stated), len(fit.keys)
    for name, influence in plan.standards.items():
        changes = np.zeros((1, k))
        changes[0, :n] = _changes(fit, name)
        found.append((influence.origin(name), influence.u * changes, influence.stated, ()))
    if fit.own is not None:
        solve = fit.own.solve[fit.at]
        for one in fit.stated:
            changes = np.zeros((1, k))
            changes[0, :n] = -solve @ one.column.values * one.u
            changes[0, n:] = [one.u if other is one else 0.0 for other in stated]
            found.append((Origin(f"stated: {one.source}"), changes, (one.u, one.column.unit), ()))
        for name, step in readings.resolution.items():
            if step > 0.0 and name in plan.to:
                changes = np.zeros((0, k))
                made = _of_resolution(readings, fit, name, step, solve)
                changes = np.column_stack([made, np.zeros((len(made), k - n))])
                found.append((Origin(f"resolution of {name}"), changes, None, ()))
    else:
        for i, one in enumerate(stated):
            changes = np.zeros((1, k))
            changes[0, n + i] = one.u
            found.append((Origin(f"stated: {one.source}"), changes, (one.u, one.column.unit), ()))
    return found


def _changes(fit: SensorFit, influence: str) -> Array:
    """Return the change of each published term for a unit of an influence."""
    by_key = {one.key: one for one in fit.columns if one.key is not None}
    changes = np.zeros(len(fit.keys))
    for i, key in enumerate(fit.keys):
        own = by_key[key]
        value = fit.coefficient(own)
        if GAINS.get(own.condition) == influence or (influence == "converter.reference" and not own.scale):
            changes[i] = value
        elif influence == "rate_table.rate" and own.scale:
            changes[i] = -(1.0 + value) if own.condition == "applied" else -value
        elif influence == "thermometer.temperature":
            changes[i] = sum(_slopes(fit, own))
    return changes


def _slopes(fit: SensorFit, own: Column) -> list[float]:
    """Return how a term changes with the temperature that it is told for."""
    if own.condition == TEMPERATURE and not own.scale and own.key is not None:
        j = own.key.power + 1
        above = [one for one in fit.columns if one.condition == TEMPERATURE and not one.scale
                 and one.key is not None and one.key.power == j]  # fmt: skip
        return [j * fit.coefficient(one) for one in above]
    if own.warm:
        return []
    return [fit.coefficient(one) for one in fit.columns
            if one.warm and one.scale == own.scale and one.condition == own.condition]  # fmt: skip


def _of_resolution(readings: Readings, fit: SensorFit, name: str, step: float, solve: Array) -> Array:
    """Return what the rounding of each code that a condition was recorded as changes in the terms, shape (s, k)."""
    values = readings.conditions[name][fit.design.axis][fit.design.chosen]
    codes = np.round(values / step)
    slope = np.zeros(len(values))
    for one in (column for column in fit.columns if column.condition == name):
        slope += fit.coefficient(one) * (0.0 if one.slope is None else one.slope)
    size = step / np.sqrt(12.0)
    return np.array([-solve @ (slope * (codes == code)) * size for code in np.unique(codes)])


def _side_by_side(estimates: Sequence[Estimate]) -> Estimate | None:
    """Return estimates of several sensors as one; standards are common to them."""
    if not estimates:
        return None
    size = sum(len(one.keys) for one in estimates)
    shared: dict[tuple[Origin, str], list[tuple[int, Component]]] = {}
    start = 0
    for one in estimates:
        for component in one.components:
            shared.setdefault((component.origin, component.kind), []).append((start, component))
        start += len(one.keys)
    components = []
    for parts in shared.values():
        first = parts[0][1]
        covariance, dof = np.zeros((size, size)), np.full(size, np.inf)
        own = first.origin.standard != ""  # one unknown of all sensors; else each has its own
        changes = [np.zeros((0, size))]
        for place, part in parts:
            k = len(part.covariance)
            covariance[place : place + k, place : place + k] = part.covariance
            dof[place : place + k] = part.dof
            if part.changes is not None:
                made = np.zeros((len(part.changes), size))
                made[:, place : place + k] = part.changes
                changes.append(made)
        rows: Array | None = None
        if first.changes is not None:
            rows = np.sum(changes[1:], axis=0) if own else np.vstack(changes)
            covariance = rows.T @ rows
        components.append(replace(first, covariance=covariance, dof=dof, changes=rows))
    return Estimate(
        tuple(key for one in estimates for key in one.keys), np.concatenate([one.values for one in estimates]),
        tuple(unit for one in estimates for unit in one.units), tuple(components),
    )  # fmt: skip


# ---- what speaks against the figures --------------------------------------------------------------------------------


def _of_power_ups(readings: Readings) -> list[Remark]:
    count = len(readings.power_ups)
    if count >= FEW:
        return []
    if count < 2:
        what = "one power-up: nothing tells whether a sensitivity repeats; figures rest on the scatter between levels"
        return [Remark("few_runs", "warning", what, do="Record the same levels in 2 power-ups or more")]
    what = f"{count} power-ups: the scatter between them is badly known, intervals are wide"
    return [Remark("few_runs", "info", what, do=f"Record {FEW} or more for a narrower interval")]


def _doubts(readings: Readings, fit: SensorFit) -> list[Remark]:
    """Return remarks on readings that depend on the way to a level, or bend."""
    if fit.own is None:
        return []
    found: list[Remark] = []
    axis, design = fit.design.axis, fit.design
    time = readings.time[design.chosen]
    for one in (column for column in fit.columns if not column.warm and not column.scale and column.key is not None):
        if one.condition == TEMPERATURE or one.key in design.refused:
            continue
        ordered = np.lexsort((time, design.runs))
        steps = _steps(one.values, design.runs, ordered)
        if np.all(np.isfinite(time)):
            size = abs(_correlation(within(one.values, design.runs), within(time, design.runs)))
            if size > ORDERED:
                what = (
                    f"{one.condition} changes with time (r = {size:.2f}): a drift is taken for a sensitivity of {axis}"
                )
                do = "Take the levels up and down again"
                found.append(Remark("one_order", "warning", what, do=do, axis=axis, subject=one.condition))
            found += _added(fit, np.sign(steps), "path_dependent", one.condition,
                            "readings differ on the way up and down", "Wait longer, or add settle")  # fmt: skip
        found += _added(fit, one.values**2, "curved", one.condition, "the bias bends", "Take a narrower range")
        late = readings.settling[axis][design.chosen] * np.sign(steps)
        late = late[(steps != 0.0) & np.isfinite(late)]
        if len(late) > 2 and late.std() > 0.0:
            t = float(late.mean() / (late.std(ddof=1) / np.sqrt(len(late))))
            if 2.0 * float(special.stdtr(len(late) - 1, -abs(t))) < SURE:
                what = f"{axis} still settles after changes of {one.condition}: {_spoken(late.mean(), readings.unit)}"
                do = 'Leave the beginning out: --settle "60 s"'
                found.append(Remark("not_settled", "warning", f"{what} from the first half of a level to the second",
                                    do=do, axis=axis, subject=one.condition))  # fmt: skip
    return found


def _spoken(value: float, unit: str) -> str:
    return f"{value:.3g} {unit}"


def _steps(values: Array, runs: NDArray[np.str_], ordered: NDArray[np.intp]) -> Array:
    """Return by how much a condition changed before each level of its power-up; 0 for the first."""
    steps = np.zeros(len(values))
    same = runs[ordered][1:] == runs[ordered][:-1]
    steps[ordered[1:]] = np.where(same, np.diff(values[ordered]), 0.0)
    steps[np.abs(steps) < 0.05 * np.ptp(values)] = 0.0
    return steps


def _correlation(a: Array, b: Array) -> float:
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0.0 else 0.0


def _added(fit: SensorFit, column: Array, code: str, name: str, what: str, do: str) -> list[Remark]:
    """Return a remark where one more column explains more than chance."""
    own, design = fit.own, fit.design
    assert own is not None  # noqa: S101 - the caller looked
    fitted = within(np.column_stack([one.values for one in fit.columns]), design.runs)
    left = within(column, design.runs)
    unit = fitted / np.linalg.norm(fitted, axis=0)
    left = left - unit @ np.linalg.lstsq(unit, left, rcond=None)[0]
    size, spare = float(left @ left), own.spare - 1.0
    if size < 1e-6 * float(column @ column) or spare < 1.0:
        return []
    part = float(left @ own.local) ** 2 / size
    rest = (float(own.local @ own.local) - part) / spare
    if rest <= 0.0 or 2.0 * float(special.stdtr(spare, -np.sqrt(part / rest))) > SURE:
        return []
    effect = float(left @ own.local) / size * float(np.ptp(column))
    text = f"{design.axis}: {what} of {name}, by {effect:.3g} over its range"
    return [Remark(code, "warning", text, do=do, axis=design.axis, subject=name)]
