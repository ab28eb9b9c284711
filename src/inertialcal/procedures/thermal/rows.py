"""Rows of a thermal result: every quantity with its uncertainty, or the reason why there is none.

Conditions: none for coefficients; ``"-20 degC"`` for the bias at a temperature; ``"warming"`` or ``"cooling"`` where
the test has one path only; ``"textbook"`` for the textbook formula.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...core.batches import batches, near
from ...core.batches.summaries import Moments
from ...core.estimate import Array, Estimate
from ...core.key import AXES, NO_REASON, Key, Member, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...core.units import factor, normalise
from ...sensors.thermal import in_unit, over_voltage
from ...statistics.intervals import chi_square_interval, t_interval, t_intervals, t_intervals_each
from ...statistics.least_squares import fit, times
from ...statistics.polynomial import Polynomial, powers_from_series_each
from .fit._kernels_cells import fill_cubic, fill_roots
from .fit.cells import Once, Series
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
LEVEL_LIMITS = {"run": "", "ramp": RAMPS, "block": BLOCKS}
RANGE = Reason("range", "end of the temperature range of the polynomial, as read; no uncertainty")
BEHIND = Reason("limits", "delay of the bias behind the thermometer")
FEW_SAMPLES = Reason("few_samples", "no cell has three samples")


@lru_cache(maxsize=1024)  # the same of all units of a lot
def _key(quantity: str, axis: str, at: float | None = None) -> Key:
    return Key(quantity, axis, at=None if at is None else at_degrees(at))


@lru_cache(maxsize=1024)
def _none(key: Key, unit: str, reason: Reason, method: Method = Method.RESULT) -> Row:
    """Return the row of what is not estimated: one for all units that have it."""
    return not_estimated(key, unit, reason, method)


def rows(result: Result) -> list[Row]:
    """Return all rows, sensor by sensor, SI."""
    return rows_many([result])[0]


def rows_many(results: Sequence[Result]) -> list[list[Row]]:
    """Return the same of each of several results at once."""
    limits = [{axis: _limits(one, each) for axis, each in one.sensors.items()} for one in results]
    figures = iter(estimate_rows_each([one.estimate for one in results], limits))
    single = iter(estimate_rows_each([one.on_path for one in results]))
    sensors = [each for one in results for each in one.sensors.values()]
    cubics = iter(published_each([(one.plan, each) for one in results for each in one.sensors.values()]))
    effects = iter(_effect_intervals(sensors))
    scatters = iter(_sample_scatters(sensors))
    return [
        _rows(
            one,
            next(figures),
            next(single),
            {axis: (next(effects), next(scatters), next(cubics)) for axis in one.sensors},
        )
        for one in results
    ]


def _rows(
    result: Result, own: Mapping[Key, Row], on_path: Mapping[Key, Row], known: Mapping[str, _Known]
) -> list[Row]:  # fmt: skip
    found: list[Row] = []
    for axis in _axes(result):
        if axis not in result.sensors:
            found.append(_none(_key("bias", axis), result.readings.unit, result.reasons[axis]))
            continue
        one = result.sensors[axis]
        intervals, scatter, cubic = known[axis]
        found += _polynomial_rows(result, axis, one, own)
        if not one.law.midway:
            found += _one_path_rows(result, axis, one, on_path)
        found += _range_rows(axis, one)
        found += _path_rows(result, axis, one, intervals)
        found += _scatter_rows(result, axis, one, *scatter)
        found += _start_up_rows(result, axis, one)
        found += _reference_rows(result, axis)
        found += thermometer_rows(result.plan, result.readings, axis)
        found += published_rows(result.plan, axis, cubic, result.readings.unit)
    return found


def _axes(result: Result) -> list[str]:
    return [axis for axis in AXES if axis in result.sensors or axis in result.reasons]


def estimate_rows(estimate: Estimate | None) -> dict[Key, Row]:
    """Return the rows of the values of an estimate, without a reason."""
    return estimate_rows_each([estimate])[0]


def estimate_rows_each(
    estimates: Sequence[Estimate | None], reasons: Sequence[Mapping[str, Reason]] | None = None
) -> list[dict[Key, Row]]:
    """Return the same of each of several estimates, none of None; with a reason of each axis."""
    known = [one for one in estimates if one is not None]
    intervals = iter(t_intervals_each([(one.values, one.u, one.dof) for one in known]))
    found: list[dict[Key, Row]] = []
    for i, one in enumerate(estimates):
        own, why = {}, {} if reasons is None else reasons[i]
        if one is not None:
            dof = [free if math.isfinite(free) else None for free in one.dof.tolist()]
            columns = zip(one.keys, one.values.tolist(), one.u.tolist(), one.units, dof, next(intervals), strict=True)
            own = {key: Row.of_own(key, value, u, unit, free, ends, why.get(key.axis, NO_REASON))
                   for key, value, u, unit, free, ends in columns}  # fmt: skip
        found.append(own)
    return found


def _polynomial_rows(result: Result, axis: str, one: OfSensor, own: Mapping[Key, Row]) -> Iterator[Row]:
    for asked in result.asked[axis]:
        for key, unit in zip(asked.keys, asked.units, strict=True):
            if key in own:
                yield own[key]
            else:
                yield _none(key, unit, _why_not(result, one))
    low, high = one.law.domain
    for temperature in result.plan.at or ():
        if not low <= temperature <= high:
            reason = Reason("outside", f"outside the range of the ramps, {low:.4g} to {high:.4g} degC")
            yield _none(_key("bias", axis, temperature), result.readings.unit, reason)


def _limits(result: Result, one: OfSensor) -> Reason:
    """Return what limits the figures of a sensor."""
    return _limits_of(_level_limits(one), any(name not in result.plan.standards for name in needed(result.plan)))


@cache
def _limits_of(level: str, missing: bool) -> Reason:
    words = (level, "relative to the unit's own thermometer and converter" if missing else "")
    return Reason("limits", "; ".join(filter(None, words)))


def _one_path_rows(result: Result, axis: str, one: OfSensor, on_path: Mapping[Key, Row]) -> Iterator[Row]:
    """Rows of what holds on the path that was seen."""
    way = Member("path", {1: "warming", -1: "cooling"}[one.cells.ways[0]])
    reason = Reason("limits", _level_limits(one))
    keys = [key for asked in result.asked[axis] if asked.by_temperature for key in asked.keys]
    return (on_path[key].changed(reason=reason, member=way) for key in keys if key in on_path)


def _level_limits(one: OfSensor) -> str:
    return LEVEL_LIMITS[one.law.level]


def needed(plan: Plan) -> tuple[str, ...]:
    """Return the standards that every thermal test needs."""
    return _needed(plan.scale_factor is not None)


@cache
def _needed(scaled: bool) -> tuple[str, ...]:
    names = ["thermometer.temperature"]
    names += ["converter.reference"] if scaled else []
    return tuple(name for name in INFLUENCES if name in names)


def _why_not(result: Result, one: OfSensor) -> Reason:
    if result.readings.unit == "m/s^2":
        return GRAVITY
    if not one.law.midway:
        way = {1: "warming", -1: "cooling"}[one.cells.ways[0]]
        return Reason("one_path", f"{way} only: the bias midway between warming and cooling needs both")
    return ONE_RUN


def _range_rows(axis: str, one: OfSensor) -> Iterator[Row]:
    for name, value in zip(("temperature_lowest", "temperature_highest"), one.law.domain, strict=True):
        yield Row.without(_key(name, axis), value, "degC", RANGE)


def _effects(one: OfSensor) -> tuple[PathEffect, PathEffect, PathEffect]:
    return one.paths.difference, one.paths.hysteresis, one.paths.lag


def _effect_intervals(sensors: Sequence[OfSensor]) -> list[list[Interval | None]]:
    """Return the intervals of what differs between the paths of each sensor."""
    figures = [(each.value, each.u, each.dof) for one in sensors for each in _effects(one) if each.known]
    values, u, dof = np.array(figures, dtype=float).reshape(-1, 3).T
    found = iter(t_intervals(values, u, dof))
    return [[next(found) if each.known else None for each in _effects(one)] for one in sensors]


def _path_rows(result: Result, axis: str, one: OfSensor, intervals: Sequence[Interval | None]) -> Iterator[Row]:
    unit, paths = result.readings.unit, one.paths
    both = one.cells.both
    over = "" if both is None else f"warming minus cooling, mean from {both[0]:.4g} to {both[1]:.4g} degC"
    extra = f"; {limits}" if (limits := _level_limits(one)) else ""
    told = Reason(paths.word, f"{paths.word}: {paths.why}")
    difference, hysteresis, lag = intervals
    yield _effect_row(_key("path_difference", axis), unit, paths.difference, difference, Reason("limits", over + extra))
    yield _effect_row(_key("hysteresis", axis), unit, paths.hysteresis, hysteresis, told, f"{paths.word}: ")
    yield _effect_row(_key("thermal_lag", axis), "s", paths.lag, lag, BEHIND)


def _effect_row(
    key: Key, unit: str, effect: PathEffect, interval: Interval | None, told: Reason, word: str = ""
) -> Row:  # fmt: skip
    """Return the row of something that differs between the paths; its own reason, after a word, goes first."""
    if effect.value is None:
        return _none(key, unit, Reason(told.code, f"{word}{effect.reason}"))
    if effect.u is None or effect.dof is None or interval is None:
        return Row.without(key, effect.value, unit, Reason(told.code, f"{word}{effect.reason}"))
    return Row.of_own(key, effect.value, effect.u, unit, effect.dof, interval, told)


def _sample_scatters(sensors: Sequence[OfSensor]) -> list[tuple[float, float]]:
    """Return the standard deviation of the samples of each sensor, and its degrees of freedom."""
    if not sensors:
        return []
    cells = [one.cells for one in sensors]
    starts = np.cumsum([0, *map(len, cells)])[:-1]
    free = np.maximum(np.concatenate([one.samples for one in cells]) - 2.0, 0.0)
    squares = np.concatenate([one.scatter for one in cells]) ** 2
    dof, total = (np.add.reduceat(one, starts) for one in (free, free * squares))
    std = np.sqrt(total / np.maximum(dof, 1.0))
    return list(zip(std.tolist(), dof.tolist(), strict=True))


def _scatter_rows(result: Result, axis: str, one: OfSensor, std: float, dof: float) -> Iterator[Row]:
    unit, cells = result.readings.unit, one.cells
    yield _scatter_row("scatter_sample", axis, unit, std, dof, FEW_SAMPLES)
    name = "scatter_recording" if result.plan.run_level == "recording" else "scatter_run"
    offsets = one.run_offsets
    if len(offsets) < 2 or not (cells.paths_repeated or one.paths.loops):
        yield _none(_key(name, axis), unit, NOT_REPEATED if len(offsets) < 2 else PATHS)
        return
    yield _scatter_row(name, axis, unit, float(np.std(offsets, ddof=1)), len(offsets) - 1.0, SAME)


def _scatter_row(name: str, axis: str, unit: str, std: float, dof: float, reason: Reason) -> Row:
    if dof < 1.0 or not std > 0.0:
        return _none(_key(name, axis), unit, reason)
    interval, u = chi_square_interval(std, dof), std / math.sqrt(2.0 * dof)
    return Row.of_own(_key(name, axis), std, u, unit, dof, interval, NO_REASON)


def _start_up_rows(result: Result, axis: str, one: OfSensor) -> Iterator[Row]:
    start, unit = one.start_up, result.readings.unit
    found = start.found
    names = (("warm_up_change", unit), ("warm_up_time_constant", "s"))
    if found is None or not found.identified:
        reason = Reason("no_transient", start.reason if found is None else QUIET)
        yield from (_none(_key(name, axis), its, reason) for name, its in names)
    elif not found.resolved:
        yield from (_none(_key(name, axis), its, LONG) for name, its in names)
    else:
        values, us = (found.change, found.time_constant), np.sqrt(np.diag(found.covariance))
        for (name, its), value, u, dof in zip(names, values, us, found.dof, strict=True):
            known = dof > 0.0
            interval = t_interval(value, float(u), float(dof)) if known else None
            told = Reason("limits", "reading at power-up minus settled reading" if name == "warm_up_change" else "")
            key, its_u, free = _key(name, axis), float(u) if known else None, float(dof) if known else None
            yield Row(key, value, its_u, its, free, interval,
                      "estimated" if known else "not_estimated", told if known else ONE_RUN)  # fmt: skip
    yield _cut_row(result, axis, one)


def _cut_row(result: Result, axis: str, one: OfSensor) -> Row:
    """Row of what is left out after a power-up, by the criterion or as the plan says."""
    start, found, key = one.start_up, one.start_up.found, _key("warm_up_time", axis)
    own = result.readings.unit
    unit = result.plan.unit or own
    if result.plan.warm_up is not None:
        return Row(key, start.cut, None, "s", status="not_estimated", reason=Reason("by_plan", "as the plan says"))
    if found is None:
        return _none(key, "s", Reason("no_transient", start.reason))
    if not found.identified or start.cut <= 0.0:
        return Row(key, 0.0, None, "s", status="not_estimated", reason=Reason("none_left_out", "nothing left out"))
    least = start.settled * (factor(own, unit) if unit != own else 1.0)
    told = Reason("limits", f"until the start-up transient is below {least:.3g} {unit}")
    u, dof = found.u_settled_after(start.settled)
    if not (dof > 0.0 and found.resolved):
        return Row(key, start.cut, None, "s", status="not_estimated", reason=told)
    return Row(key, start.cut, u, "s", dof, t_interval(start.cut, u, dof), reason=told)


def _reference_rows(result: Result, axis: str) -> Iterator[Row]:
    for name, estimate in result.references.items():
        own = estimate_rows(estimate)
        for key in (_key(name, axis), Key(f"{name}_temperature", axis, power=1)):
            if key in own:
                yield own[key]


ORDER = 3
FEW = 1_000  # samples, to which the published fit is made as they are
APART = 1e5  # largest entries of moments and of their inverse, up to which they tell the coefficients apart


class Published(NamedTuple):
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
        if ("textbook", cut) not in series.once:
            _find_cubics([(series, cut)])
        found: list[_Cubic] | None = series.once["textbook", cut]
        if found is not None:
            return _published(plan, axis, found[list(series.together).index(axis)])

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
        one = np.column_stack([_series(T, domain).T, y])
        few = not len(held) and len(one) <= FEW
        held = one if few else np.asarray(np.linalg.qr(np.vstack([held, one]), mode="r"))
    fitted = fit(held[:, :-1], held[:, -1])
    rss = float(fitted.residuals @ fitted.residuals)
    whole = None if fitted.covariance is None else fitted.covariance * fitted.dof
    return _published(plan, axis, _Cubic(fitted.coefficients, whole, rss, outputs.squares, outputs.count, domain))


class _Cubic(NamedTuple):
    """The cubic of one sensor."""

    coefficients: Array  # shape (ORDER + 1,): a Chebyshev series
    covariance: Array | None  # shape (ORDER + 1, ORDER + 1): of one degree of freedom
    rss: float  # Residual sum of squares
    total: float  # Sum of the squares of the readings about their mean
    samples: int
    domain: tuple[float, float]  # Of the temperature [degC]


def _find_cubics(given: Sequence[tuple[Series, float]]) -> None:
    """Find the cubics of all sensors of several thermometers, with the cut of each, that `published_fit` wants."""
    own = {(id(one.once), cut): (one, cut) for one, cut in given if one.complete and ("textbook", cut) not in one.once}
    kinds: dict[int, list[tuple[Once, float, Array]]] = {}
    for one, cut in own.values():
        columns = _used(one, cut)
        if columns is None:
            one.once.keep(("textbook", cut), None)
        else:
            kinds.setdefault(len(columns), []).append((one.once, cut, columns))
    for alike in kinds.values():
        for (once, cut, _), found in zip(alike, _cubics([columns for _, _, columns in alike]), strict=True):
            once.keep(("textbook", cut), found)


def _used(series: Series, cut: float) -> Array | None:
    """Return temperature, time and readings of the samples that count, (2 + k, n); None where they are too few.

    Few samples are fitted as they are.
    """
    columns = series.columns
    used = np.isfinite(columns[0]) & ~(columns[1] < cut)  # without a time it counts
    columns = columns if used.all() else np.compress(used, columns, axis=1)
    T = columns[0]
    few = len(T) <= FEW or (len({*T[:64].tolist()}) <= ORDER + 1 and len(np.unique(T)) <= ORDER + 1)
    return None if few else columns


def _cubics(columns: Sequence[Array]) -> list[list[_Cubic] | None]:
    """Return the cubics of the readings of several thermometers, (2 + k, n) each.

    None where the moments hardly tell the coefficients apart: they are to be found step by step.
    """
    units, k = len(columns), len(columns[0]) - 2
    ends = np.array([(one[0].min(), one[0].max()) for one in columns])
    middle, cubic = np.array([one[2:, 0] for one in columns]), np.zeros((units, k, ORDER + 1))
    powers, (first, last) = np.empty((units, 2 * ORDER + 1)), np.empty((2, units, k, ORDER + 2))
    for one, *own in zip(columns, ends, middle, cubic, powers, first, strict=True):
        fill_cubic(one, *own)
    at = np.arange(ORDER + 1)
    root = np.empty((units, ORDER + 1, ORDER + 1))
    square = np.empty(root.shape)  # of products of polynomials
    square[:] = 0.5 * (powers[:, at[:, None] + at] + powers[:, np.abs(at[:, None] - at)])
    fill_roots(square, root)
    told = np.abs(square).max(axis=(1, 2)) * np.sum(root**2, axis=(1, 2)) < APART
    root[~told] = 0.0
    inverse = root.swapaxes(1, 2) @ root
    with np.errstate(over="ignore", invalid="ignore"):
        cubic = first[..., :-1] @ inverse
        total = np.maximum(first[..., -1] - first[..., 0] ** 2 / powers[:, :1], 0.0)  # about the mean
    for one, *own in zip(columns, ends, middle, cubic, powers, last, strict=True):
        fill_cubic(one, *own)
    cubic += last[..., :-1] @ inverse  # what rounding left
    cubic[..., 0] += middle
    covariance = last[..., -1, None, None] * inverse[:, None]
    figures = zip(cubic, covariance, last[..., -1].tolist(), total.tolist(), strict=True)
    found: list[list[_Cubic] | None] = []
    for one, (low, high), keep, figure in zip(columns, ends.tolist(), told.tolist(), figures, strict=True):
        own = [_Cubic(*each, one.shape[1], (low, high)) for each in zip(*figure, strict=True)]
        found.append(own if keep else None)
    return found


def _published(plan: Plan, axis: str, cubic: _Cubic) -> Published:
    """Return the cubic of a sensor as the thesis prints it."""
    n, rss, dof = cubic.samples, cubic.rss, cubic.samples - ORDER - 1
    adjusted = 1.0 - (rss / dof) / (cubic.total / (n - 1)) if cubic.total > 0.0 else np.nan
    covariance = None if cubic.covariance is None else cubic.covariance / dof
    polynomial = Polynomial(cubic.coefficients, covariance, float(dof), cubic.domain)
    channel, volts = (plan.thermometers or {}).get(axis), (plan.scale_factor or {}).get(axis)
    if channel is None or volts is None:
        return Published(polynomial, rss, adjusted, n, False)
    over = over_voltage(polynomial, channel.slope, channel.voltage, channel.temperature)
    return Published(in_unit(over, volts), rss * volts**2, adjusted, n, True)


def _series(T: Array, domain: tuple[float, float]) -> Array:
    """Return Chebyshev polynomials of temperatures over a range, shape (ORDER + 1, n)."""
    x = (2.0 * T - domain[0] - domain[1]) / (domain[1] - domain[0])
    rows = np.empty((ORDER + 1, len(T)))
    rows[0], rows[1] = 1.0, x
    twice = 2.0 * x
    for k in range(2, ORDER + 1):
        np.subtract(np.multiply(twice, rows[k - 1], out=rows[k]), rows[k - 2], out=rows[k])
    return rows


class PublishedRows(NamedTuple):
    """The published fit as powers, with its intervals."""

    fit: Published | None
    values: Array  # shape (ORDER + 1,)
    u: Array | None
    intervals: Sequence[Interval | None]


_Known = tuple[Sequence[Interval | None], tuple[float, float], PublishedRows]


def published_each(sensors: Sequence[tuple[Plan, OfSensor]]) -> list[PublishedRows]:
    """Return the published fit of each of several sensors."""
    _find_cubics([(one.series, one.start_up.cut) for _, one in sensors])
    fits = [published_fit(plan, one.series, one.start_up.cut) for plan, one in sensors]
    held = [one.polynomial for one in fits if one is not None]
    about = [0.0 if one.volts else plan.reference_temperature
             for (plan, _), one in zip(sensors, fits, strict=True) if one is not None]  # fmt: skip
    domains = np.array([one.domain for one in held]).reshape(-1, 2)
    change = powers_from_series_each(ORDER, domains, about)
    values = times(change, np.array([one.coefficients for one in held]).reshape(-1, ORDER + 1))
    nothing = np.full(change.shape[1:], np.nan)
    spread = np.array([nothing if one.covariance is None else one.covariance for one in held]).reshape(change.shape)
    us = np.sqrt(np.diagonal(change @ spread @ change.swapaxes(1, 2), axis1=1, axis2=2))
    told = iter((row, None if one.covariance is None else u) for row, one, u in zip(values, held, us, strict=True))
    found = [(None, np.zeros(0), None) if one is None else (one, *next(told)) for one in fits]
    judged = [(values, u, np.full(len(u), one.polynomial.dof)) for one, values, u in found
              if one is not None and u is not None]  # fmt: skip
    intervals = iter(t_intervals_each(judged))
    return [PublishedRows(one, values, u, [None] * len(values) if u is None else next(intervals))
            for one, values, u in found]  # fmt: skip


def published_rows(plan: Plan, axis: str, known: PublishedRows, unit: str) -> list[Row]:
    """Return coefficients, residual sum of squares and adjusted R-square of the published way."""
    found = known.fit
    if found is None:
        key, reason = _key("residual_sum_of_squares", axis), Reason("few_samples", "too few samples for a cubic")
        return [_none(key, normalise(f"({unit})^2"), reason, Method.TEXTBOOK)]
    keys, units = _published_labels(axis, unit, found.volts)
    told = f"unweighted cubic through all {found.samples} samples; the uncertainty assumes they are independent"
    reason, dof = Reason("limits", told), found.polynomial.dof
    us = [None] * len(known.values) if known.u is None else known.u.tolist()
    rows = []
    for key, its, value, u, interval in zip(keys, units, known.values.tolist(), us, known.intervals, strict=False):
        if u is not None and interval is not None and math.isfinite(value) and math.isfinite(u):
            rows.append(Row.of_own(key, value, u, its, dof, interval, reason, Method.TEXTBOOK))
        else:
            rows.append(Row(key, value, u, its, dof, interval, reason=reason, method=Method.TEXTBOOK))
    for key, its, value in zip(
        keys[-2:], units[-2:], (found.residual_sum_of_squares, found.adjusted_r_square), strict=True
    ):
        rows.append(Row.without(key, value, its, reason, Method.TEXTBOOK))
    return rows


@lru_cache(maxsize=256)
def _published_labels(axis: str, unit: str, volts: bool) -> tuple[tuple[Key, ...], tuple[str, ...]]:
    """Return keys and units of the coefficients, the residual sum of squares and the adjusted R-square."""
    own, by = ("V", "V") if volts else (unit, "degC")
    stem = "bias_voltage" if volts else "bias_temperature"
    keys = [_key("bias", axis) if j == 0 and not volts else Key(stem, axis, power=j) for j in range(ORDER + 1)]
    units = [power_unit(own, by, j) for j in range(ORDER + 1)]
    named = (_key(name, axis) for name in ("residual_sum_of_squares", "adjusted_r_square"))
    return (*keys, *named), (*units, normalise(f"({own})^2"), "1")
