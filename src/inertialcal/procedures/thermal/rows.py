"""Rows of a thermal result: every quantity with its uncertainty, or the reason why there is none.

Conditions: none for coefficients; ``"-20 degC"`` for the bias at a temperature; ``"warming"`` or ``"cooling"`` where
one path alone was seen; ``"as_published"`` for the document's own way.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Estimate
from ...core.results import Row, not_estimated
from ...statistics.intervals import chi_square_interval, t_interval
from .paths import PathEffect
from .plan import INFLUENCES, Plan
from .published import published_rows
from .quantities import at_text, name_of
from .sensor import OfSensor

if TYPE_CHECKING:
    from .reduction import Result

ONE_RUN = "it rests on what one run alone shows: how it differs between runs cannot be told"
GRAVITY = "the reading at rest holds what gravity adds along the axis"
BLOCKS = "from one run: what differs between power-ups, and drift slower than a sixth of a ramp, is not in it"
RAMPS = "from one run: what differs between power-ups is not in it"


def rows(result: Result) -> list[Row]:
    """Return all rows, sensor by sensor, SI."""
    found: list[Row] = []
    for axis in _axes(result):
        if axis not in result.sensors:
            found.append(not_estimated("bias", axis, result.readings.unit, result.reasons[axis]))
            continue
        one = result.sensors[axis]
        found += _polynomial_rows(result, axis, one)
        found += _range_rows(axis, one)
        found += _path_rows(result, axis, one)
        found += _scatter_rows(result, axis, one)
        found += _start_up_rows(result, axis, one)
        found += _reference_rows(result, axis)
        found += published_rows(result.plan, one.series, one.start_up.cut, result.readings.unit)
    return found


def _axes(result: Result) -> list[str]:
    return [axis for axis in AXES if axis in result.sensors or axis in result.reasons]


def estimate_row(estimate: Estimate, key: tuple[str, str, str], reason: str) -> Row:
    """Return the row of a value of an estimate."""
    i = estimate.index(name_of(*key))
    value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
    quantity, axis, condition = key
    told = float(dof) if np.isfinite(dof) else None
    return Row(
        quantity,
        axis,
        value,
        u,
        estimate.units[i],
        told,
        t_interval(value, u, dof),
        reason=reason,
        condition=condition,
    )


def _polynomial_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    limits = _limits(result, one)
    for asked in result.asked[axis]:
        for key, unit in zip(asked.keys, asked.units, strict=True):
            if result.estimate is not None and name_of(*key) in result.estimate.names:
                yield estimate_row(result.estimate, key, limits)
            else:
                yield not_estimated(key[0], axis, unit, _why_not(result, one), key[2])
    low, high = one.law.domain
    for temperature in result.plan.at or ():
        if not low <= temperature <= high:
            reason = f"outside the range of the ramps, {low:.4g} to {high:.4g} degC"
            yield not_estimated("bias", axis, result.readings.unit, reason, at_text(temperature))
    if not one.law.midway:
        yield from _one_path_rows(result, axis, one)


def _one_path_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    """Rows of what holds on the path that was seen."""
    way = {1: "warming", -1: "cooling"}[one.cells.ways[0]]
    for asked in result.asked[axis]:
        if result.on_path is None or not asked.by_temperature:
            continue
        for quantity, _, condition in asked.keys:
            name = name_of(quantity, axis, condition)
            if name in result.on_path.names:
                row = estimate_row(result.on_path, (quantity, axis, condition), _level_limits(one))
                yield Row(**{**vars(row), "condition": f"{way}, {condition}" if condition else way})


def _limits(result: Result, one: OfSensor) -> str:
    """Return what the uncertainty does not hold."""
    missing = [name for name in needed(result.plan) if name not in result.plan.standards]
    words = [_level_limits(one)] if one.law.level != "run" else []
    words += ["relative to the unit's own thermometer and converter"] if missing else []
    return "; ".join(words)


def _level_limits(one: OfSensor) -> str:
    return {"run": "", "ramp": RAMPS, "block": BLOCKS}[one.law.level]


def needed(plan: Plan) -> tuple[str, ...]:
    """Return the standards that every thermal test needs."""
    names = ["thermometer.temperature"]
    names += ["converter.reference"] if plan.scale_factor is not None else []
    return tuple(name for name in INFLUENCES if name in names)


def _why_not(result: Result, one: OfSensor) -> str:
    if result.readings.unit == "m/s^2":
        return GRAVITY
    if not one.law.midway:
        way = {1: "warming", -1: "cooling"}[one.cells.ways[0]]
        return f"only {way} was seen: midway between warming and cooling is not known"
    return ONE_RUN


def _range_rows(axis: str, one: OfSensor) -> Iterator[Row]:
    reason = "end of the range in which the polynomial holds: known as read, without an uncertainty"
    for name, value in zip(("temperature_lowest", "temperature_highest"), one.law.domain, strict=True):
        yield Row(name, axis, value, None, "degC", status="not_estimated", reason=reason)


def _path_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    unit, paths = result.readings.unit, one.paths
    both = one.cells.both
    over = "" if both is None else f"warming less cooling, mean from {both[0]:.4g} to {both[1]:.4g} degC"
    extra = "" if one.law.level == "run" else f"; {_level_limits(one)}"
    yield effect_row("path_difference", axis, unit, paths.difference, over + extra)
    yield effect_row("hysteresis", axis, unit, paths.hysteresis, f"{paths.word}: {paths.why}")
    yield effect_row("thermal_lag", axis, "s", paths.lag, "the bias is this much behind the thermometer")


def effect_row(quantity: str, axis: str, unit: str, effect: PathEffect, told: str) -> Row:
    """Return the row of something that differs between the paths; its own reason goes first."""
    if effect.value is None or effect.u is None or effect.dof is None:
        word = told.partition(":")[0] if quantity == "hysteresis" else ""
        reason = f"{word}: {effect.reason}" if word else effect.reason
        return Row(quantity, axis, effect.value, None, unit, status="not_estimated", reason=reason)
    interval = t_interval(effect.value, effect.u, effect.dof)
    return Row(quantity, axis, effect.value, effect.u, unit, effect.dof, interval, reason=told)


def _scatter_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    unit, cells = result.readings.unit, one.cells
    dof = float(np.sum(np.maximum(cells.samples - 2.0, 0.0)))
    std = float(np.sqrt(np.sum(np.maximum(cells.samples - 2.0, 0.0) * cells.scatter**2) / max(dof, 1.0)))
    yield _scatter_row("scatter_sample", axis, unit, std, dof, "no cell has three samples")
    name = "scatter_recording" if result.plan.run_level == "recording" else "scatter_run"
    offsets = one.run_offsets
    if len(offsets) < 2:
        reason = "one run: not repeated"
        yield not_estimated(name, axis, unit, reason)
        return
    yield _scatter_row(name, axis, unit, float(np.std(offsets, ddof=1)), len(offsets) - 1.0, "")


def _scatter_row(name: str, axis: str, unit: str, std: float, dof: float, reason: str) -> Row:
    if dof < 1.0 or not std > 0.0:
        return not_estimated(name, axis, unit, reason or "the runs do not differ at all")
    return Row(name, axis, std, std / float(np.sqrt(2.0 * dof)), unit, dof, chi_square_interval(std, dof))


def _start_up_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    start, unit = one.start_up, result.readings.unit
    found = start.found
    names = (("warm_up_change", unit), ("warm_up_time_constant", "s"))
    if found is None or not found.seen:
        reason = start.reason if found is None else "no transient after power-up stands out of the noise"
        yield from (not_estimated(name, axis, its, reason) for name, its in names)
    else:
        values, us = (found.change, found.time_constant), np.sqrt(np.diag(found.covariance))
        for (name, its), value, u, dof in zip(names, values, us, found.dof, strict=True):
            known = dof > 0.0
            interval = t_interval(value, float(u), float(dof)) if known else None
            told = "reading at power-up less settled" if name == "warm_up_change" else ""
            yield Row(name, axis, value, float(u) if known else None, its, float(dof) if known else None, interval,
                      "estimated" if known else "not_estimated", told if known else ONE_RUN)  # fmt: skip
    yield _cut_row(result, axis, one)


def _cut_row(result: Result, axis: str, one: OfSensor) -> Row:
    """Row of what is left out after a power-up, by the criterion or as the plan says."""
    start, found = one.start_up, one.start_up.found
    told = f"until less than {start.settled:.3g} {result.readings.unit} is left of the start-up"
    if result.plan.warm_up is not None:
        return Row("warm_up_time", axis, start.cut, None, "s", status="not_estimated", reason="as the plan says")
    if found is None:
        return not_estimated("warm_up_time", axis, "s", start.reason)
    if not found.seen or start.cut <= 0.0:
        return Row("warm_up_time", axis, 0.0, None, "s", status="not_estimated", reason="nothing left out")
    u, dof = found.u_settled_after(start.settled)
    if not dof > 0.0:
        return Row("warm_up_time", axis, start.cut, None, "s", status="not_estimated", reason=told)
    return Row("warm_up_time", axis, start.cut, u, "s", dof, t_interval(start.cut, u, dof), reason=told)


def _reference_rows(result: Result, axis: str) -> Iterator[Row]:
    for name, estimate in result.references.items():
        for key_name in estimate.names:
            quantity, _, own = key_name.rpartition("_")
            if own == axis and quantity in (name, f"{name}_temperature_1"):
                yield estimate_row(estimate, (quantity, axis, ""), "")
