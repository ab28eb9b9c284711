"""Rows of a rate-table result: every quantity with its uncertainty, or the reason why there is none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...core.estimate import Array, Estimate
from ...core.key import NO_REASON, Key, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import chi_square_interval, t_interval, t_intervals_each
from ...statistics.least_squares import times
from .fit.linearity import Deviations, deviations_each, linearity_row
from .fit.quantities import CURVATURES, UNITS, is_silent
from .fit.regression import Level, Line
from .plan import INFLUENCES, Plan
from .readings import Readings

if TYPE_CHECKING:
    from .reduction import Result

RESIDUAL = "residual_bias"  # what is left of the bias after the reading at rest was subtracted
REFERENCED = Reason("referenced", "the reading at rest was subtracted")
SILENT = Reason("no_response", "the sensor does not read the rate about its own axis: only its bias is estimated")
LEVELS = ("sample", "dwell", "run")


def rows(result: Result) -> list[Row]:
    """Return all rows, sensor by sensor, SI."""
    return rows_many([result])[0]


def rows_many(results: Sequence[Result]) -> list[list[Row]]:
    """Return the same of each of several results at once."""
    kinds = (Method.RESULT, Method.ALL_READINGS)
    wanted = [(one, each, kind) for one in results
              for each, kind in zip((one.estimate, one.all_readings), kinds, strict=True)]  # fmt: skip
    figures, fits = iter(_rows_of_each(wanted)), _published(results)
    known = [line for own in fits for line in own.values() if line is not None]
    intervals = iter(t_intervals_each([(one.values, one.u, np.full(2, one.dof)) for one in known]))
    published = [{sensor: [] if line is None else next(intervals) for sensor, line in own.items()} for own in fits]
    curved = [{sensor: (line, one.full[sensor]) for sensor, line in one.straight.items()
               if sensor in line.axes and not is_silent(line)} for one in results]  # fmt: skip
    away = iter(deviations_each([pair for own in curved for pair in own.values()]))
    return [
        _rows(one, next(figures), next(figures), lines, ends, {sensor: next(away) for sensor in own})
        for one, lines, ends, own in zip(results, fits, published, curved, strict=True)
    ]


def _rows(
    result: Result, figures: Mapping[Key, Row], every: Mapping[Key, Row],
    published: Mapping[str, _Straight | None], intervals: Mapping[str, Sequence[Interval]],
    away: Mapping[str, Deviations | None],
) -> list[Row]:  # fmt: skip
    found: list[Row] = []
    for sensor in list(dict.fromkeys([*result.readings.sensors, *result.readings.outputs])):
        found += _of_sensor(result, sensor, result.estimate, figures, Method.RESULT)
        if sensor in result.lines:
            straight = result.straight[sensor]
            if is_silent(straight):
                found.append(not_estimated(Key("linearity_error", sensor), "%", SILENT))
            else:
                found.append(linearity_row(sensor, away.get(sensor)))
            found += _scatter_rows(result, sensor)
            if result.all_readings is not None:
                found += _of_sensor(result, sensor, result.all_readings, every, Method.ALL_READINGS)
            if sensor in published:
                found += _published_rows(result.plan, sensor, published[sensor], intervals[sensor])
    return found


def _of_sensor(
    result: Result, sensor: str, estimate: Estimate | None, own: Mapping[Key, Row], method: Method
) -> list[Row]:
    """Rows of the quantities that a rate table gives for one sensor, estimated, as ``own`` has them, or not."""
    found = []
    for key, unit in _wanted(result, sensor):
        if key.quantity == "bias" and result.plan.zero_reference:
            found.append(not_estimated(key, unit, REFERENCED, method))
        elif key.quantity == RESIDUAL and (bias := Key("bias", key.axis)) in own:
            found.append(own[bias].changed(key=key))
        elif key.quantity == "scale_factor":
            found.append(_scale_factor_row(result, sensor, estimate, method))
        elif key in own:
            found.append(own[key])
        else:
            found.append(not_estimated(key, unit, _why_not(result, sensor, key.quantity, key.axis[1:]), method))
    return found


def _wanted(result: Result, sensor: str) -> Sequence[tuple[Key, str]]:
    there = sensor in result.readings.outputs or bool(np.any(result.readings.axis == sensor))
    plan = result.plan
    return _keys(sensor, there, plan.zero_reference, plan.scale_factor is not None, result.readings.turned.axes)


@lru_cache(maxsize=256)  # the same of all units of a lot
def _keys(
    sensor: str, there: bool, referenced: bool, in_volts: bool, axes: tuple[str, ...]
) -> Sequence[tuple[Key, str]]:  # fmt: skip
    """Return keys and units of the quantities of a sensor, there or not."""
    wanted = []
    if there:
        wanted.append((Key("bias", sensor), "rad/s"))
        if referenced:
            wanted.append((Key(RESIDUAL, sensor), "rad/s"))
        if in_volts:
            wanted.append((Key("scale_factor", sensor), "V/(rad/s)"))
        wanted += [(Key("scale_factor_error", sensor), "1"), (Key("scale_factor_asymmetry", sensor), "1")]
        wanted += [(Key(quantity, sensor), UNITS[quantity]) for quantity in CURVATURES.values()]
    for axis in axes:
        if axis != sensor:
            wanted += [
                (Key("cross_axis_sensitivity", f"{sensor}{axis}"), "1"),
                (Key("misalignment", f"{sensor}{axis}"), "rad"),
            ]
    return tuple(wanted)


def _rows_of_each(wanted: Sequence[tuple[Result, Estimate | None, Method]]) -> list[dict[Key, Row]]:
    """Return the rows of the values of each of several estimates, none of None."""
    known = [one for _, one, _ in wanted if one is not None]
    intervals = iter(t_intervals_each([(one.values, one.u, one.dof) for one in known]))
    found: list[dict[Key, Row]] = []
    for result, one, method in wanted:
        own, limits = {}, result.limits
        if one is not None:
            dof = [_dof(free) for free in one.dof.tolist()]
            columns = zip(one.keys, one.values.tolist(), one.u.tolist(), one.units, dof, next(intervals), strict=True)
            own = {key: Row.of_own(key, value, u, unit, free, ends, limits, method)
                   for key, value, u, unit, free, ends in columns}  # fmt: skip
        found.append(own)
    return found


def _scale_factor_row(result: Result, sensor: str, estimate: Estimate | None, method: Method) -> Row:
    """Return the scale factor in volts: the ideal one times (1 + scale factor error)."""
    ideal, error = (result.plan.scale_factor or {}).get(sensor), Key("scale_factor_error", sensor)
    key = Key("scale_factor", sensor)
    if ideal is None or estimate is None or error not in estimate.keys:
        return not_estimated(key, "V/(rad/s)", _why_not(result, sensor, "scale_factor_error"), method)
    i = estimate.index(error)
    value, u, dof = (
        ideal * (1.0 + float(estimate.values[i])),
        abs(ideal) * float(estimate.u[i]),
        float(estimate.dof[i]),
    )
    interval = t_interval(value, u, dof)
    shared, curvature = estimate.shared(error, ideal), estimate.curvature(error, ideal)
    return Row(
        key, value, u, "V/(rad/s)", _dof(dof), interval, reason=result.limits, method=method, shared=shared,
        curvature=curvature,
    )  # fmt: skip


def applies(name: str, plan: Plan, readings: Readings) -> bool:
    """Tell whether an influence can change a result of these readings."""
    if name == "rate_table.mounting":
        return any(readings.turned.axes != (sensor,) for sensor in readings.outputs)
    return name != "converter.reference" or plan.scale_factor is not None


def limits(plan: Plan, readings: Readings) -> Reason:
    """Return what limits every figure of a test; nothing where all standards are stated."""
    missing = [name for name in INFLUENCES if name not in plan.standards and applies(name, plan, readings)]
    return Reason("relative", "relative to the fixture") if missing else Reason()


def _why_not(result: Result, sensor: str, quantity: str, axis: str = "") -> Reason:
    readings = result.readings
    turned = [axis] if axis else list(readings.turned.axes)
    read = np.isfinite(readings.outputs[sensor]) if sensor in readings.outputs else np.zeros(len(readings), dtype=bool)
    if not np.any(read & np.isin(readings.axis, turned)):
        return Reason("not_read", f"no readings of the {sensor} sensor while {', '.join(turned)} turned")
    if sensor in result.reasons:
        return result.reasons[sensor]
    terms = {quantity: name for name, quantity in CURVATURES.items()}
    if quantity != "bias" and is_silent(result.lines[sensor]):
        return SILENT
    if quantity in terms and terms[quantity] in result.no_curvature[sensor] and sensor in result.lines[sensor].axes:
        return result.no_curvature[sensor][terms[quantity]]
    return _why_not_by(result.plan, result.lines[sensor], sensor, quantity)


def _why_not_by(plan: Plan, one: Line, sensor: str, quantity: str) -> Reason:
    if sensor not in one.axes and quantity != "bias":
        return Reason("not_turned", f"not turned about {sensor} in this test")
    if one.covariance is not None and np.any(one.dof == 0.0):
        return Reason("one_run", "needs two runs or more: one run does not show the scatter between runs")
    if quantity == "scale_factor_asymmetry":
        few = Reason("few_rates", "needs both senses of rotation and three rates or more")
        return few if plan.asymmetry else Reason("by_plan", "asymmetry = false in the plan")
    return Reason("not_repeated", "scatter neither repeated nor given")


def _scatter_rows(result: Result, sensor: str) -> list[Row]:
    recordings = result.plan.run_level == "recording"
    found = []
    for level in result.lines[sensor].levels:
        name = "recording" if level.name == "run" and recordings else level.name
        found.append(_scatter_row(sensor, name, level))
    if recordings:
        told = "each recording is a run: the table does not say which ones began with a power-up"
        found.append(not_estimated(Key("scatter_run", sensor), "rad/s", Reason("runs_unknown", told)))
    return found


def _scatter_row(sensor: str, name: str, level: Level) -> Row:
    key = Key(f"scatter_{name}", sensor)
    if level.std is None:
        return not_estimated(key, "rad/s", Reason("not_repeated", level.reason))
    if not math.isfinite(level.dof):
        reason = Reason("given", f"no uncertainty: {level.reason}")
        return Row(key, level.std, None, "rad/s", status="not_estimated", reason=reason)
    u = level.std / math.sqrt(2.0 * level.dof)
    interval = chi_square_interval(level.std, level.dof)
    if not math.isfinite(u):
        return Row(key, level.std, float(u), "rad/s", level.dof, interval)
    return Row.of_own(key, level.std, float(u), "rad/s", level.dof, interval, NO_REASON)


def _dof(dof: float) -> float | None:
    return float(dof) if math.isfinite(dof) else None


class _Straight(NamedTuple):
    """The published fit of a sensor turned about its own axis: slope and intercept."""

    values: Array
    u: Array
    dof: float
    dwells: int


def _published(results: Sequence[Result]) -> list[dict[str, _Straight | None]]:
    """Return the published fit of each sensor that was turned about its own axis; None of too few dwells.

    In volts where the plan has an ideal scale factor, else in the unit of the readings. Those turned alike are fitted
    at once.
    """
    found: list[dict[str, _Straight | None]] = [{} for _ in results]
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, one in enumerate(results):
        ideal = one.plan.scale_factor or {}
        for sensor in one.lines:
            read = np.isfinite(one.readings.outputs[sensor])
            missing = b"" if read.all() else read.tobytes()
            alike.setdefault((id(one.readings.turned), sensor, ideal.get(sensor), missing), []).append(i)
    for (_, name, *_), at in alike.items():
        sensor, plan, readings = str(name), results[at[0]].plan, results[at[0]].readings
        own = readings.axis == sensor
        if not own.any():
            continue
        own &= np.isfinite(readings.outputs[sensor])
        x = readings.applied[own]
        if len(x) < 3 or np.all(x == x[0]):
            for i in at:
                found[i][sensor] = None
            continue
        volts = None if plan.scale_factor is None else plan.scale_factor.get(sensor)
        y = np.array([results[i].readings.outputs[sensor][own] for i in at]) * (1.0 if volts is None else volts)
        line, dof = readings.turned.straight(own), len(x) - 2.0
        values = line.coefficients(y)
        left = y - times(line.design, values)
        u = np.sqrt((left**2).sum(axis=1)[:, None] / dof * (line.transform**2).sum(axis=1))
        for i, one_line, its in zip(at, values, u, strict=True):
            found[i][sensor] = _Straight(one_line, its, dof, y.shape[1])
    return found


def _published_rows(plan: Plan, sensor: str, one: _Straight | None, intervals: Sequence[Interval]) -> list[Row]:
    volts = None if plan.scale_factor is None else plan.scale_factor.get(sensor)
    units = ("V/(rad/s)", "V") if volts is not None else ("1", "rad/s")
    keys = (Key("scale_factor", sensor), Key("intercept", sensor))
    if one is None:
        reason = Reason("few_dwells", "needs three dwells or more at two rates or more")
        return [not_estimated(key, unit, reason, Method.TEXTBOOK) for key, unit in zip(keys, units, strict=True)]
    told = f"unweighted line through all {one.dwells} dwells; the uncertainty assumes they are independent"
    reason, columns = Reason("limits", told), (one.values.tolist(), one.u.tolist())
    return [
        Row.of_own(key, value, u, unit, one.dof, ends, reason, Method.TEXTBOOK)
        if math.isfinite(value) and math.isfinite(u)
        else Row(key, value, u, unit, one.dof, ends, reason=reason, method=Method.TEXTBOOK)
        for key, value, u, unit, ends in zip(keys, *columns, units, intervals, strict=True)
    ]


__all__ = ["LEVELS", "Interval", "rows", "rows_many"]
