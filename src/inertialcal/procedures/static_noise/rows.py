"""Rows of a test of noise: each term with its interval, an upper limit, or the reason why there is none.

Conditions: none for the result, from all records together; ``"run NAME alone"`` for each of several records;
``"line at 9.97 Hz"`` for lines, whose figures come from the spectrum: it tells them better than the Allan deviation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, get_args

import numpy as np
from scipy import special

from ...core.estimate import Component, Estimate
from ...core.influence import Standards
from ...core.key import NO_REASON, At, Key, Kind, Member, Reason
from ...core.results import Interval, Row, Status, not_estimated
from ...core.units import FILE_UNIT, normalise
from ...sensors.noise.fitting.noise_fit import NoiseFit, TermEstimate, duration, rows_of
from ...sensors.noise.terms import (
    POWERS_OF_TIME,
    TERMS,
    GaussMarkov,
    RandomWalk,
    Sinusoid,
    parameter_unit,
    quantity_name,
    sample_unit,
    shown_units,
)
from ...statistics.intervals import t_interval
from .axis_noise import FAST, AxisNoise, doubt_of, fault_of, slow_fault_of
from .record import Recorded

if TYPE_CHECKING:
    from .reduction import Result

SCALE, CLOCK = "sensor.scale_factor", "clock.rate"
SOURCES = {SCALE: "scale factor of the sensor", CLOCK: "rate of the clock"}
TIME = quantity_name(GaussMarkov.name, "correlation_time", None)
SENSORS: tuple[Kind, ...] = get_args(Kind)
# By how much a figure changes, in proportion, where the clock is fast by one: intervals are then long.
POWERS_OF_CLOCK = {
    quantity_name(name, parameter, kind): float(POWERS_OF_TIME[name])
    for name, term in TERMS.items() if name in POWERS_OF_TIME
    for parameter in term.parameters for kind in (None, *SENSORS)
} | {TIME: 1.0, "line_frequency": -1.0}  # fmt: skip


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI, or in the unit of the file where the kind is not known."""
    for found in result.axes:
        yield from _of_axis(result, found)
        for record in found.records:
            yield from _lines(result, found.axis, record, len(result.readings) > 1)
            if record.own is not None:
                doubt = " and ".join(filter(None, (doubt_of(record.own), fault_of(record.run, found.axis))))
                own = _terms(result, record.own, found.axis, doubt, slow_fault_of(record.run, found.axis))
                alone = Member("run", record.run.name)
                yield from (replace(row, member=alone) for row in own if row.status == "estimated")


def _of_axis(result: Result, found: AxisNoise) -> Iterator[Row]:
    if found.fit is not None:
        yield from _terms(result, found.fit, found.axis, found.doubt, found.slow_fault, found.bands.said)
        return
    kind, unit = result.plan.kind, result.plan.unit
    why = Reason() if found.problem is None else Reason(found.problem.code, found.problem.what)
    for name, term in TERMS.items():
        if name == Sinusoid.name or name not in (result.plan.terms or TERMS):
            continue
        for parameter in term.parameters:
            shown = unit_of(name, parameter, kind, unit)
            key = Key(quantity_name(name, parameter, kind), found.axis)
            yield not_estimated(key, shown, why)


def _terms(result: Result, fit: NoiseFit, axis: str, doubt: str, slow: Reason, band: str = "") -> Iterator[Row]:
    """Yield the parameters of a fit, without those of lines; upper limits as values; each with what speaks against.

    Slow terms are not estimated where ``slow`` says that something feigns them.
    """
    reason = Reason("in_doubt", f"in doubt: {doubt}") if doubt else NO_REASON
    units, standards = quantity_units(result.plan.kind, result.plan.unit), result.plan.standards
    wide = bool(SOURCES.keys() & standards.keys())
    for term in fit.found:
        if term.name == Sinusoid.name:
            continue
        if slow and term.name not in FAST:
            words = term.words or tuple(one.name for one in term.parameters)
            yield from (not_estimated(key_of(word, axis), units[word], slow) for word in words)
            continue
        for one in term.parameters:
            inside = Reason("in_band", band) if band and term.name == RandomWalk.name else NO_REASON
            said = reason or inside or Reason("limits", term.reason)
            row = _row(key_of(one.name, axis), one.value, one.u, units[one.name], one.interval, "estimated", said)
            yield widened(row, standards) if wide else row
        if term.status != "estimated":
            for row in _missing(term, axis, units):
                yield widened(row, standards) if wide else row


@lru_cache(256)
def key_of(word: str, axis: str) -> Key:
    """Return the key of a quantity of an axis."""
    return Key(word, axis)


def _row(
    key: Key, value: float, u: float | None, unit: str, interval: Interval, status: Status, reason: Reason
) -> Row:  # fmt: skip
    """Return a row; of finite figures nothing is checked again."""
    if math.isfinite(value) and (u is None or math.isfinite(u)):
        return Row.of_own(key, value, u, unit, None, interval, reason, status=status)
    return Row(key, value, u, unit, None, interval, status, reason)


def _missing(term: TermEstimate, axis: str, units: Mapping[str, str]) -> Iterator[Row]:
    """Yield the upper limit of a term that was not found, with the record that would show it, or that there is none."""
    without, limit, others = term.reason, term.upper_limit, term.words
    if limit is not None:
        word, others = term.words[0], term.words[1:]
        interval, needed, said = Interval.of_own(0.0, limit, 0.95), term.record_needed, without
        if needed is not None and needed > term.record:
            said = f"{without}; {duration(needed)} would show it at this limit"
        yield _row(key_of(word, axis), limit, None, units[word], interval, "upper_limit", Reason("not_found", said))
    for word in others:
        yield not_estimated(key_of(word, axis), units[word], Reason("not_found", without))


def _lines(result: Result, axis: str, record: Recorded, several: bool) -> Iterator[Row]:
    """Yield amplitude and frequency of each line of a spectrum."""
    lines = record.spectral.lines
    unit = sample_unit(result.plan.kind, result.plan.unit) or FILE_UNIT
    for line in lines.found if lines is not None else ():
        if line.kind != "line":
            continue
        alone = Member("run", record.run.name) if several else None
        at = At("line", line.lowest or line.frequency, "Hz")
        for quantity, value, u, own in (
            ("line_amplitude", line.amplitude, line.u_amplitude, unit),
            ("line_frequency", line.frequency, line.u_frequency, "Hz"),
        ):
            key = Key(quantity, axis, power=line.times, at=at)
            row = Row(key, value, u, own, None, t_interval(value, u, float("inf")), member=alone)
            yield widened(row, result.plan.standards) if quantity == "line_frequency" else row


def unit_of(term: str, parameter: str, kind: Kind | None, file_unit: str) -> str:
    """Return the unit of a parameter inside: SI, or made of the unit of the file."""
    unit = sample_unit(kind, file_unit)
    if unit or parameter in {"correlation_time", "frequency"}:
        return parameter_unit(term, parameter, unit)
    bare = parameter_unit(term, parameter, "1")
    return FILE_UNIT if bare == "1" else f"{FILE_UNIT}{bare[1:]}" if bare.startswith("1/") else f"{FILE_UNIT}*{bare}"


@cache
def quantity_units(kind: Kind | None, file_unit: str) -> MappingProxyType[str, str]:
    """Return the unit inside of every quantity that noise terms have; lines are not among them."""
    return MappingProxyType(
        {
            quantity_name(name, parameter, kind): unit_of(name, parameter, kind, file_unit)
            for name, term in TERMS.items()
            if name != Sinusoid.name
            for parameter in term.parameters
        }
    )


def interval_at(result: Result, row: Row, p: float) -> Interval | None:
    """Return the interval of probability ``p`` of an estimated row, by the same profile of the fit."""
    if row.interval is not None and row.interval.p == p:
        return row.interval
    one = next((axis for axis in result.axes if axis.axis == row.axis), None)
    if one is None or one.fit is None:
        return None
    estimated = (own for term in one.fit.estimated_at(p) for own in term.parameters if own.name == row.quantity)
    own = next(estimated, None)
    if own is not None:
        shown = Row(Key(own.name, row.axis), own.value, own.u, own.unit, None, own.interval)
        return widened(shown, result.plan.standards).interval
    missing = (term for term in one.fit.found if term.status != "estimated")
    same = (other for other in rows_of(missing, one.fit.fit_warnings, row.axis) if other.quantity == row.quantity)
    other = next(same, None)
    return None if other is None else widened(other, result.plan.standards).interval


def changes_by(quantity: str, standards: Standards) -> dict[str, float]:
    """Return the relative change of a figure by one standard uncertainty of scale factor and clock, those stated."""
    powers = {SCALE: 0.0 if quantity in {TIME, "line_frequency"} else -1.0, CLOCK: POWERS_OF_CLOCK.get(quantity, 0.0)}
    return {name: power * standards[name].u for name, power in powers.items() if power and name in standards}


def widened(row: Row, standards: Standards) -> Row:
    """Return the row with what scale factor and clock add to its uncertainty and interval."""
    if not SOURCES.keys() & standards.keys():
        return row
    own = math.hypot(*changes_by(row.key.quantity, standards).values())
    if own == 0.0 or row.value is None:
        return row
    u = None if row.u is None else float(np.hypot(row.u, own * row.value))
    interval = _interval(row, own)
    value = interval.hi if row.status == "upper_limit" and interval is not None else row.value
    return replace(row, value=value, u=u, interval=interval)


def _interval(row: Row, own: float) -> Interval | None:
    interval, value = row.interval, row.value
    if interval is None or value is None:
        return interval
    more = float(special.ndtri(0.5 * (1.0 + interval.p))) * own

    def end(at: float | None) -> float | None:
        if at is None or at <= 0.0 or value <= 0.0:
            return at
        log = np.log(at / value)
        return float(value * np.exp(np.copysign(np.hypot(log, more), log if log else 1.0)))

    return Interval(end(interval.lo), end(interval.hi), interval.p)


def with_standards(estimate: Estimate, standards: Standards) -> Estimate:
    """Return the estimate with scale factor and clock as sources, each shared by all that feel it."""
    if not SOURCES.keys() & standards.keys():
        return estimate
    found = list(estimate.components)
    for name, said in SOURCES.items():
        relative = [changes_by(key.quantity, standards).get(name, 0.0) for key in estimate.keys]
        changes = np.array(relative) * estimate.values
        if np.any(changes):
            one = standards[name]
            covariance = np.outer(changes, changes)
            found.append(Component(
                one.origin(said), "B", covariance, one.dof, one.distribution, one.stated, changes[None]
            ))  # fmt: skip
    return replace(estimate, components=tuple(found))


@cache
def data_sheet_units(kind: Kind) -> MappingProxyType[str, str]:
    """Return the unit that each quantity of noise is shown in: ``angle_random_walk`` in ``deg/sqrt(h)``."""
    inside = quantity_units(kind, "")
    found = {}
    for name, term in TERMS.items():
        for parameter in term.parameters:
            quantity = quantity_name(name, parameter, kind)
            if quantity in inside:
                shown = shown_units(name, parameter, kind)
                found[quantity] = normalise(shown[0]) if shown else inside[quantity]
    return MappingProxyType(found)
