"""Rows of a thermal result: every quantity with its uncertainty, or the reason why there is none.

Conditions: none for coefficients; ``"-20 degC"`` for the bias at a temperature; ``"warming"`` or ``"cooling"`` where
the test has one path only; ``"textbook"`` for the textbook formula.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ...core.batches import batches, near
from ...core.batches.summaries import Moments
from ...core.estimate import Array, Estimate
from ...core.key import AXES, Key, Member, Method, Reason
from ...core.results import Row, not_estimated
from ...core.units import factor, normalise
from ...sensors.thermal import in_unit, over_voltage
from ...statistics.intervals import chi_square_interval, t_interval
from ...statistics.least_squares import Decomposed, decompose, fit
from ...statistics.polynomial import Polynomial
from .fit.cells import Series
from .fit.paths import PathEffect
from .fit.quantities import at_degrees, power_unit
from .fit.sensor import OfSensor
from .plan import INFLUENCES, Plan
from .thermometer import thermometer_rows

if TYPE_CHECKING:
    from .reduction import Result

ONE_RUN = Reason("one_run", "needs two runs or more: one run does not show the scatter between runs")
GRAVITY = Reason("gravity", "the reading at rest includes gravity along the axis")
BLOCKS = "from one run: excludes scatter between power-ups and drift slower than a sixth of a ramp"
SAME = Reason("no_scatter", "all runs have the same offset")
NOT_REPEATED = Reason("one_run", "one run: not repeated")
PATHS = Reason("paths_or_runs", "one run alone shows warming, or cooling: what the paths differ by looks the same")
LONG = Reason("warm_up_long", "the start-up takes longer than the stay at the first temperature: stay longer")
QUIET = "no transient after power-up above the noise"
RAMPS = "from one run: excludes scatter between power-ups"


def rows(result: Result) -> list[Row]:
    """Return all rows, sensor by sensor, SI."""
    found: list[Row] = []
    for axis in _axes(result):
        if axis not in result.sensors:
            found.append(not_estimated(Key("bias", axis), result.readings.unit, result.reasons[axis]))
            continue
        one = result.sensors[axis]
        found += _polynomial_rows(result, axis, one)
        found += _range_rows(axis, one)
        found += _path_rows(result, axis, one)
        found += _scatter_rows(result, axis, one)
        found += _start_up_rows(result, axis, one)
        found += _reference_rows(result, axis)
        found += thermometer_rows(result.plan, result.readings, axis)
        found += published_rows(result.plan, one.series, one.start_up.cut, result.readings.unit)
    return found


def _axes(result: Result) -> list[str]:
    return [axis for axis in AXES if axis in result.sensors or axis in result.reasons]


def estimate_row(estimate: Estimate, key: Key, reason: Reason) -> Row:
    """Return the row of a value of an estimate."""
    i = estimate.index(key)
    value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
    free = float(dof) if np.isfinite(dof) else None
    return Row(key, value, u, estimate.units[i], free, t_interval(value, u, dof), reason=reason)


def _polynomial_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    missing = [name for name in needed(result.plan) if name not in result.plan.standards]
    words = [_level_limits(one)] if one.law.level != "run" else []
    words += ["relative to the unit's own thermometer and converter"] if missing else []
    limits = Reason("limits", "; ".join(words))
    for asked in result.asked[axis]:
        for key, unit in zip(asked.keys, asked.units, strict=True):
            if result.estimate is not None and key in result.estimate.keys:
                yield estimate_row(result.estimate, key, limits)
            else:
                yield not_estimated(key, unit, _why_not(result, one))
    low, high = one.law.domain
    for temperature in result.plan.at or ():
        if not low <= temperature <= high:
            reason = Reason("outside", f"outside the range of the ramps, {low:.4g} to {high:.4g} degC")
            yield not_estimated(Key("bias", axis, at=at_degrees(temperature)), result.readings.unit, reason)
    if not one.law.midway:
        yield from _one_path_rows(result, axis, one)


def _one_path_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    """Rows of what holds on the path that was seen."""
    way = {1: "warming", -1: "cooling"}[one.cells.ways[0]]
    for asked in result.asked[axis]:
        if result.on_path is None or not asked.by_temperature:
            continue
        for key in asked.keys:
            if key in result.on_path.keys:
                row = estimate_row(result.on_path, key, Reason("limits", _level_limits(one)))
                yield replace(row, member=Member("path", way))


def _level_limits(one: OfSensor) -> str:
    return {"run": "", "ramp": RAMPS, "block": BLOCKS}[one.law.level]


def needed(plan: Plan) -> tuple[str, ...]:
    """Return the standards that every thermal test needs."""
    names = ["thermometer.temperature"]
    names += ["converter.reference"] if plan.scale_factor is not None else []
    return tuple(name for name in INFLUENCES if name in names)


def _why_not(result: Result, one: OfSensor) -> Reason:
    if result.readings.unit == "m/s^2":
        return GRAVITY
    if not one.law.midway:
        way = {1: "warming", -1: "cooling"}[one.cells.ways[0]]
        return Reason("one_path", f"{way} only: the bias midway between warming and cooling needs both")
    return ONE_RUN


def _range_rows(axis: str, one: OfSensor) -> Iterator[Row]:
    reason = Reason("range", "end of the temperature range of the polynomial, as read; no uncertainty")
    for name, value in zip(("temperature_lowest", "temperature_highest"), one.law.domain, strict=True):
        yield Row(Key(name, axis), value, None, "degC", status="not_estimated", reason=reason)


def _path_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    unit, paths = result.readings.unit, one.paths
    both = one.cells.both
    over = "" if both is None else f"warming minus cooling, mean from {both[0]:.4g} to {both[1]:.4g} degC"
    extra = "" if one.law.level == "run" else f"; {_level_limits(one)}"
    yield effect_row(Key("path_difference", axis), unit, paths.difference, Reason("limits", over + extra))
    told = Reason(paths.word, f"{paths.word}: {paths.why}")
    yield effect_row(Key("hysteresis", axis), unit, paths.hysteresis, told, f"{paths.word}: ")
    behind = Reason("limits", "delay of the bias behind the thermometer")
    yield effect_row(Key("thermal_lag", axis), "s", paths.lag, behind)


def effect_row(key: Key, unit: str, effect: PathEffect, told: Reason, word: str = "") -> Row:
    """Return the row of something that differs between the paths; its own reason, after a word, goes first."""
    if effect.value is None or effect.u is None or effect.dof is None:
        reason = Reason(told.code, f"{word}{effect.reason}")
        return Row(key, effect.value, None, unit, status="not_estimated", reason=reason)
    interval = t_interval(effect.value, effect.u, effect.dof)
    return Row(key, effect.value, effect.u, unit, effect.dof, interval, reason=told)


def _scatter_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    unit, cells = result.readings.unit, one.cells
    dof = float(np.sum(np.maximum(cells.samples - 2.0, 0.0)))
    std = float(np.sqrt(np.sum(np.maximum(cells.samples - 2.0, 0.0) * cells.scatter**2) / max(dof, 1.0)))
    yield _scatter_row("scatter_sample", axis, unit, std, dof, Reason("few_samples", "no cell has three samples"))
    name = "scatter_recording" if result.plan.run_level == "recording" else "scatter_run"
    offsets = one.run_offsets
    if len(offsets) < 2 or not (cells.paths_repeated or one.paths.loops):
        yield not_estimated(Key(name, axis), unit, NOT_REPEATED if len(offsets) < 2 else PATHS)
        return
    yield _scatter_row(name, axis, unit, float(np.std(offsets, ddof=1)), len(offsets) - 1.0, SAME)


def _scatter_row(name: str, axis: str, unit: str, std: float, dof: float, reason: Reason) -> Row:
    if dof < 1.0 or not std > 0.0:
        return not_estimated(Key(name, axis), unit, reason)
    return Row(Key(name, axis), std, std / float(np.sqrt(2.0 * dof)), unit, dof, chi_square_interval(std, dof))


def _start_up_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    start, unit = one.start_up, result.readings.unit
    found = start.found
    names = (("warm_up_change", unit), ("warm_up_time_constant", "s"))
    if found is None or not found.identified:
        reason = Reason("no_transient", start.reason if found is None else QUIET)
        yield from (not_estimated(Key(name, axis), its, reason) for name, its in names)
    elif not found.resolved:
        yield from (not_estimated(Key(name, axis), its, LONG) for name, its in names)
    else:
        values, us = (found.change, found.time_constant), np.sqrt(np.diag(found.covariance))
        for (name, its), value, u, dof in zip(names, values, us, found.dof, strict=True):
            known = dof > 0.0
            interval = t_interval(value, float(u), float(dof)) if known else None
            told = Reason("limits", "reading at power-up minus settled reading" if name == "warm_up_change" else "")
            yield Row(Key(name, axis), value, float(u) if known else None, its, float(dof) if known else None, interval,
                      "estimated" if known else "not_estimated", told if known else ONE_RUN)  # fmt: skip
    yield _cut_row(result, axis, one)


def _cut_row(result: Result, axis: str, one: OfSensor) -> Row:
    """Row of what is left out after a power-up, by the criterion or as the plan says."""
    start, found, key = one.start_up, one.start_up.found, Key("warm_up_time", axis)
    own = result.readings.unit
    unit = result.plan.unit or own
    least = start.settled * (factor(own, unit) if unit != own else 1.0)
    told = Reason("limits", f"until the start-up transient is below {least:.3g} {unit}")
    if result.plan.warm_up is not None:
        return Row(key, start.cut, None, "s", status="not_estimated", reason=Reason("by_plan", "as the plan says"))
    if found is None:
        return not_estimated(key, "s", Reason("no_transient", start.reason))
    if not found.identified or start.cut <= 0.0:
        return Row(key, 0.0, None, "s", status="not_estimated", reason=Reason("none_left_out", "nothing left out"))
    u, dof = found.u_settled_after(start.settled)
    if not (dof > 0.0 and found.resolved):
        return Row(key, start.cut, None, "s", status="not_estimated", reason=told)
    return Row(key, start.cut, u, "s", dof, t_interval(start.cut, u, dof), reason=told)


def _reference_rows(result: Result, axis: str) -> Iterator[Row]:
    for name, estimate in result.references.items():
        for key in (Key(name, axis), Key(f"{name}_temperature", axis, power=1)):
            if key in estimate.keys:
                yield estimate_row(estimate, key, Reason())


ORDER = 3
FEW = 1_000  # samples, to which the published fit is made as they are


@dataclass(frozen=True, eq=False)
class Published:
    """The fit as the thesis prints it."""

    polynomial: Polynomial  # Over volts [V], or degC
    residual_sum_of_squares: float  # [unit of the polynomial squared]
    adjusted_r_square: float  # (1)
    samples: int  # That it was fitted to
    volts: bool  # Whether it is in volts over volts


def published_fit(plan: Plan, series: Series, cut: float) -> Published | None:
    """Return the unweighted cubic through all samples after the start-up; None where there are too few."""
    axis = series.axis
    if series.complete:
        textbook = series.once(("textbook", cut), lambda: _textbook(series, cut))
        if textbook is not None:
            held, outputs = textbook.held(series.reading)
            return _published(plan, axis, held, outputs, textbook.domain, textbook.design)

    def parts() -> Iterator[tuple[Array, Array]]:
        for first, stop in batches(series.temperature, series.reading, series.time, size=near()):
            T, y, t = (one[first:stop] for one in (series.temperature, series.reading, series.time))
            used = np.isfinite(y) & np.isfinite(T) & ~(np.nan_to_num(t, nan=np.inf) < cut)
            yield T[used], y[used]

    distinct, temperatures, outputs = np.empty(0), Moments(), Moments()
    for T, y in parts():
        if len(distinct) <= ORDER + 1:
            distinct = np.unique(np.append(distinct, T))[: ORDER + 2]
        temperatures, outputs = temperatures.with_more(T), outputs.with_more(y)
    if len(distinct) <= ORDER + 1:
        return None
    domain = temperatures.low, temperatures.high
    held = np.empty((0, ORDER + 2))
    for T, y in parts():  # of more than a few, what an orthogonal transformation leaves: the same cubic and sum
        one = np.column_stack([_rows(T, domain), y])
        few = not len(held) and len(one) <= FEW
        held = one if few else np.asarray(np.linalg.qr(np.vstack([held, one]), mode="r"))
    return _published(plan, axis, held, outputs, domain)


@dataclass(frozen=True, eq=False)
class _Textbook:
    """What the cubics of sensors that share a thermometer have in common."""

    used: NDArray[np.bool_]  # shape (n,)
    domain: tuple[float, float]  # Of the temperature [degC]
    basis: Array  # shape (k, ORDER + 1): orthonormal columns
    rest: Array  # shape (ORDER + 1, ORDER + 1): what the columns of the cubic are of these

    @cached_property
    def design(self) -> Decomposed:
        """What an orthogonal transformation leaves of the cubic."""
        return decompose(np.vstack([self.rest, np.zeros(ORDER + 1)]), [f"column {i}" for i in range(ORDER + 1)])

    def held(self, reading: Array) -> tuple[Array, Moments]:
        """Return what an orthogonal transformation leaves of cubic and reading, and the moments of the reading."""
        y = reading[self.used]
        along = self.basis.T @ y
        left = y - self.basis @ along
        last = np.append(np.zeros(len(along)), np.sqrt(left @ left))
        return np.vstack([np.column_stack([self.rest, along]), last]), Moments().with_more(y)


def _textbook(series: Series, cut: float) -> _Textbook | None:
    """Return what is the same for all sensors of a thermometer; None of few samples, which are fitted as they are."""
    T = series.temperature
    used = np.isfinite(T) & ~(np.nan_to_num(series.time, nan=np.inf) < cut)
    T = T[used]
    if len(T) <= FEW or (len(np.unique(T[:FEW])) <= ORDER + 1 and len(np.unique(T)) <= ORDER + 1):
        return None
    domain = float(T.min()), float(T.max())
    return _Textbook(used, domain, *np.linalg.qr(_rows(T, domain)))


def _published(
    plan: Plan,
    axis: str,
    held: Array,
    outputs: Moments,
    domain: tuple[float, float],
    design: Decomposed | None = None,
) -> Published:
    """Return the cubic by what an orthogonal transformation leaves of it and the readings of a sensor."""
    found, n = fit(held[:, :-1], held[:, -1], decomposed=design), outputs.count
    rss, total, dof = float(found.residuals @ found.residuals), outputs.squares, n - ORDER - 1
    adjusted = 1.0 - (rss / dof) / (total / (n - 1)) if total > 0.0 else np.nan
    covariance = None if found.covariance is None else found.covariance * (found.dof / dof)
    polynomial = Polynomial(found.coefficients, covariance, float(dof), domain)
    channel, volts = (plan.thermometers or {}).get(axis), (plan.scale_factor or {}).get(axis)
    if channel is None or volts is None:
        return Published(polynomial, rss, adjusted, n, False)
    over = over_voltage(polynomial, channel.slope, channel.voltage, channel.temperature)
    return Published(in_unit(over, volts), rss * volts**2, adjusted, n, True)


def _rows(T: Array, domain: tuple[float, float]) -> Array:
    return np.asarray(chebyshev.chebvander((2.0 * T - domain[0] - domain[1]) / (domain[1] - domain[0]), ORDER))


def published_rows(plan: Plan, series: Series, cut: float, unit: str) -> list[Row]:
    """Return coefficients, residual sum of squares and adjusted R-square of the published way."""
    axis, found = series.axis, published_fit(plan, series, cut)
    if found is None:
        return [
            not_estimated(
                Key("residual_sum_of_squares", axis),
                normalise(f"({unit})^2"),
                Reason("few_samples", "too few samples for a cubic"),
                Method.TEXTBOOK,
            )
        ]
    own, by = ("V", "V") if found.volts else (unit, "degC")
    stem = "bias_voltage" if found.volts else "bias_temperature"
    reference = 0.0 if found.volts else plan.reference_temperature
    values, covariance = found.polynomial.monomials(reference)
    told = f"unweighted cubic through all {found.samples} samples; the uncertainty assumes they are independent"
    reason = Reason("limits", told)
    dof = found.polynomial.dof
    rows = []
    for j, value in enumerate(values):
        key = Key("bias", axis) if j == 0 and not found.volts else Key(stem, axis, power=j)
        u = None if covariance is None else float(np.sqrt(covariance[j, j]))
        interval = None if u is None else t_interval(float(value), u, dof)
        rows.append(
            Row(key, float(value), u, power_unit(own, by, j), dof, interval, reason=reason, method=Method.TEXTBOOK)
        )
    square = normalise(f"({own})^2")
    for name, value, its in (
        ("residual_sum_of_squares", found.residual_sum_of_squares, square),
        ("adjusted_r_square", found.adjusted_r_square, "1"),
    ):
        key = Key(name, axis)
        rows.append(Row(key, value, None, its, status="not_estimated", reason=reason, method=Method.TEXTBOOK))
    return rows
