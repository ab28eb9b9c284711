"""Rows of a test of noise: each term with its interval, an upper limit, or the reason why there is none.

Conditions: none for the result, from all records together; ``"run NAME alone"`` for each of several records;
``"line at 9.97 Hz"`` for lines, whose figures come from the spectrum: it tells them better than the Allan deviation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from ...core.axes import Kind
from ...core.key import At, Key, Member, Reason
from ...core.results import Interval, Row, not_estimated
from ...sensors.noise.fitting.noise_fit import NoiseFit, TermEstimate, duration
from ...sensors.noise.terms import TERMS, Sinusoid, parameter_unit, quantity_name, sample_unit
from ...statistics.intervals import t_interval
from .axis_noise import AxisNoise, Recorded
from .doubts import doubt_of
from .scale import widened

if TYPE_CHECKING:
    from .reduction import Result

FILE_UNIT = "file unit"  # of samples whose unit nobody said


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI, or in the unit of the file where the kind is not known.

    Parameters
    ----------
    result : Result
        Of the test.
    """
    for found in result.axes:
        yield from _of_axis(result, found)
        for record in found.records:
            yield from _lines(result, found.axis, record, len(result.readings) > 1)
            if record.own is not None:
                own = _terms(result, record.own, found.axis, doubt_of(record.own))
                alone = Member("run", record.run.name)
                yield from (replace(row, member=alone) for row in own if row.status == "estimated")


def _of_axis(result: Result, found: AxisNoise) -> Iterator[Row]:
    if found.fit is not None:
        yield from _terms(result, found.fit, found.axis, found.doubt)
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


def _terms(result: Result, fit: NoiseFit, axis: str, doubt: str) -> Iterator[Row]:
    """Yield the parameters of a fit, without those of lines; upper limits as values; each with what speaks against."""
    reason = Reason("in_doubt", f"in doubt: {doubt}") if doubt else Reason()
    units = quantity_units(result.plan.kind, result.plan.unit)
    for term in fit.found:
        if term.name == Sinusoid.name:
            continue
        for one in term.parameters:
            said = reason or Reason("limits", term.reason)
            row = Row(Key(one.name, axis), one.value, one.u, units[one.name], None, one.interval, reason=said)
            scaled = one.name != "gauss_markov_correlation_time"
            yield widened(row, result.plan.standards) if scaled else row
        if term.status != "estimated":
            yield from _missing(result, term, axis, units)


def _missing(result: Result, term: TermEstimate, axis: str, units: Mapping[str, str]) -> Iterator[Row]:
    """Yield the upper limit of a term that was not found, or that there is none."""
    reason, limit = Reason("not_found", _why(term)), term.upper_limit
    others = term.words
    if limit is not None:
        word, others = term.words[0], term.words[1:]
        interval = Interval(0.0, limit, 0.95)
        row = Row(Key(word, axis), limit, None, units[word], None, interval, "upper_limit", reason)
        yield widened(row, result.plan.standards)
    without = Reason("not_found", term.reason)
    yield from (not_estimated(Key(word, axis), units[word], without) for word in others)


def _why(term: TermEstimate) -> str:
    """Say why a term was not found, and which record would show it."""
    if term.record_needed is None or term.record_needed <= term.record:
        return term.reason
    return f"{term.reason}; {duration(term.record_needed)} would show it at this limit"


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
            yield Row(key, value, u, own, None, t_interval(value, u, float("inf")), member=alone)


def unit_of(term: str, parameter: str, kind: Kind | None, file_unit: str) -> str:
    """Return the unit of a parameter inside: SI, or made of the unit of the file.

    Parameters
    ----------
    term, parameter : str
        Of ``sensors.noise.terms``.
    kind : {"gyro", "accelerometer"} or None
        Of the sensor.
    file_unit : str
        Of the samples where the kind is None; empty where nobody said.
    """
    unit = sample_unit(kind, file_unit)
    if unit or parameter in {"correlation_time", "frequency"}:
        return parameter_unit(term, parameter, unit)
    bare = parameter_unit(term, parameter, "1")
    return FILE_UNIT if bare == "1" else f"{FILE_UNIT}{bare[1:]}" if bare.startswith("1/") else f"{FILE_UNIT}*{bare}"


def quantity_units(kind: Kind | None, file_unit: str) -> dict[str, str]:
    """Return the unit inside of every quantity that noise terms have; lines are not among them.

    Parameters
    ----------
    kind : {"gyro", "accelerometer"} or None
        Of the sensor.
    file_unit : str
        Of the samples where the kind is None; empty where nobody said.
    """
    return {
        quantity_name(name, parameter, kind): unit_of(name, parameter, kind, file_unit)
        for name, term in TERMS.items()
        if name != Sinusoid.name
        for parameter in term.parameters
    }
