"""Sensitivities of bias and scale factor: weighted least squares with an intercept a power-up.

Levels are weighed by what is known of their noise and by what they scatter beyond it. The covariance is that of the
scatter between power-ups (CR2, ``statistics.own_offsets``), with Student's t of its degrees of freedom: whatever slow
noise, warm-up or repeatability makes the levels of one power-up alike counts there once.

Assumed: power-ups are independent of each other; within one, the conditions were set without regard to the readings.
``u`` is the standard uncertainty of a coefficient between power-ups, with what standards, resolution and stated terms
add. Broken by: (1) a condition that always comes in the same order under a drift, as self-heating is: common to all
power-ups, it is taken for a sensitivity (remarks ``one_order``, ``path_dependent``, ``not_settled``); (2) a condition
that another one follows: refused (``conditions_together``); (3) a channel that is stuck, coarse or in a wrong unit
(``not_varied``; ``set_values`` and Type B of the resolution; ``impossible_value``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Origin
from ...core.remarks import Remark
from ...core.results import Row
from ..corrections import components
from .design import Column, design_of, references_of
from .doubts import RESOLUTION, doubts, remarks_on_power_ups
from .fit import SensorFit, fitted
from .levels import PressureLevels, pressure_levels
from .plan import PRESSURE, SUPPLY, TEMPERATURE, WARM_UP, Plan
from .readings import ALIKE, Readings
from .stated import Stated
from .warm_up import joint_warm_up
from .warm_up_model import WarmUpModel

GAINS = {SUPPLY: "supply_meter.voltage", PRESSURE: "pressure_gauge.pressure"}


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
    levels: PressureLevels | None = None  # Where pressure was asked for and goes over a decade

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
    sensors = {axis: fitted(plan, readings, design_of(plan, readings, axis, references)) for axis in linear}
    remarks = [*readings.remarks, *(remarks_on_power_ups(plan, readings) if linear else ())]
    for fit in sensors.values():
        remarks += [*fit.design.remarks, *doubts(plan, readings, fit)]
    estimates = [one for fit in sensors.values() if (one := _estimate(plan, readings, fit)) is not None]
    warm_up = joint_warm_up(plan, readings) if WARM_UP in plan.to else None
    if warm_up is not None:
        estimates += [] if warm_up.estimate is None else [warm_up.estimate]
        remarks += warm_up.remarks
    levels = None
    if PRESSURE in plan.to and not any(one.corrections for one in readings.recorded):
        levels = pressure_levels(readings.recorded, readings.axes, readings.unit)
    remarks += [] if levels is None else levels.remarks
    estimate = _after(readings, sensors, _side_by_side(estimates))
    return Result(plan, readings, references, sensors, estimate, tuple(remarks), warm_up, levels)


def _after(readings: Readings, sensors: Mapping[str, SensorFit], estimate: Estimate | None) -> Estimate | None:
    """Return the terms with what is not known of the corrections of their readings."""
    if estimate is None or not readings.taken_off:
        return estimate
    gain = np.zeros((len(estimate.keys), len(readings), len(AXES)))
    for axis, fit in sensors.items():
        if fit.own is not None:
            for key, row in zip(fit.keys, fit.own.solve[fit.at], strict=True):
                gain[estimate.index(key), fit.design.chosen, AXES.index(axis)] = row
    more = components(readings.taken_off, estimate.keys, gain)
    return replace(estimate, components=(*estimate.components, *more))


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
    if influence == RESOLUTION:
        return any(one.condition == SUPPLY for one in columns) and result.readings.scatter[SUPPLY] == 0.0
    if influence == "rate_table.rate":
        return any(one.scale for one in columns)
    return influence == "thermometer.temperature" and any(one.warm for one in columns)


TypeB = tuple[Origin, Array, tuple[float, str] | None, tuple[str, ...]]


def _of_type_b(plan: Plan, readings: Readings, fit: SensorFit, stated: Sequence[Stated]) -> list[TypeB]:
    """Return origin, changes (s, k), size and unknowns of what is not seen in any scatter."""
    found: list[TypeB] = []
    k, n = len(fit.keys) + len(stated), len(fit.keys)
    for name, influence in plan.standards.items():
        if name == RESOLUTION and fit.own is not None and SUPPLY in readings.conditions:
            made = _of_resolution(readings, fit, influence.u, fit.own.solve[fit.at])
            names = tuple(f"level {i}" for i in range(1, len(made) + 1))
            changes = np.column_stack([made, np.zeros((len(made), k - n))])
            found.append((influence.origin(name), changes, influence.stated, names))
            continue
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


def _of_resolution(readings: Readings, fit: SensorFit, u: float, solve: Array) -> Array:
    """Return what an error ``u`` of each level of the supply, alike in all power-ups, changes in the terms (s, k)."""
    values = readings.conditions[SUPPLY][fit.design.axis][fit.design.chosen]
    span = float(np.ptp(values)) or 1.0
    levels = np.round((values - values.min()) / (ALIKE * span))
    slope = np.zeros(len(values))
    for one in (column for column in fit.columns if column.condition == SUPPLY):
        slope += fit.coefficient(one) * (0.0 if one.slope is None else one.slope)
    return np.array([-solve @ (slope * (levels == level)) * u for level in np.unique(levels)])


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
