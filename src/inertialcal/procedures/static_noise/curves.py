"""Curves of a test of noise, SI or in the unit of the file: what its figures show.

``allan``
    Deviation of one record of an axis at each averaging time, with its interval, and what the terms give there.
``allan_terms``
    Of an axis, on a fine grid of averaging times: the deviation of each term, and of all together.
``allan_line``
    The same of one line of an axis, with its frequency.
``spectrum``
    Means over bands of the density of one record of an axis, with intervals; each term, and all together, as a filter
    passes them; its corner.
``record_length``
    Of an axis, a row a term: how well the records tell it, and how long one would have to be.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.units import FILE_UNIT, divide, power
from ...sensors.noise.expected import Deviation, expected_variance, sampled_spectrum
from ...sensors.noise.fitting.noise_fit import NoiseFit
from ...sensors.noise.terms import RateRamp, Sinusoid, Term, sample_unit, total_phase
from ...signals.spectrum.density import Spectrum
from .axis_noise import AxisNoise
from .planning.record_length import reaches
from .record import INTERVAL, Recorded

if TYPE_CHECKING:
    from .reduction import Result

PER_OCTAVE, WITH_LINES = 4, 24  # averaging times of the drawn terms; with lines, which ring
PER_DECADE = 40  # bands of the drawn spectrum
WAYS: Mapping[str, Deviation] = {
    "overlapping": "allan", "non_overlapping": "allan", "modified": "modified", "hadamard": "hadamard",
    "overlapping_hadamard": "hadamard", "total": "allan", "modified_total": "modified", "hadamard_total": "hadamard",
}  # fmt: skip


def curves(result: Result) -> list[Curve]:
    """Return the curves of all axes and records."""
    found: list[Curve] = []
    for one in result.axes:
        found += [_allan(result, one, record) for record in one.records]
        if one.fit is not None:
            found += _terms(result, one, one.fit)
        found += [
            _spectrum(result, one, record, record.spectral.spectrum)
            for record in one.records
            if record.spectral.spectrum is not None
        ]
        if one.fit is not None:
            known = reaches(result.plan, one)
            wanted = [None if r.relative_error is None else result.plan.relative_error for r in known]
            columns = {
                "term": Column([reach.quantity for reach in known]),
                "relative_error": Column([reach.relative_error for reach in known], "1"),
                "wanted": Column(wanted, "1"),
                "record": Column([reach.record for reach in known], "s", shown="h"),
                "needed": Column([reach.needed for reach in known], "s", shown="h"),
            }
            found.append(Curve("record_length", one.axis, columns))
    return found


def _unit(result: Result) -> str:
    return sample_unit(result.plan.kind, result.plan.unit) or FILE_UNIT


def density_unit(unit: str) -> str:
    """Return the unit of a density of samples in a unit."""
    return f"({FILE_UNIT})^2/Hz" if unit == FILE_UNIT else divide(power(unit, 2), "Hz")


def _allan(result: Result, one: AxisNoise, record: Recorded) -> Curve:
    curve, unit = record.shown, _unit(result)
    expected = np.full(len(curve), np.nan)
    if one.fit is not None:
        expected = _deviation(result, one.fit.terms, curve.m.astype(np.float64), record)
    columns = {
        "tau": Column(curve.tau, "s"),
        "deviation": Column(curve.deviation[:, 0], unit),
        "lo": Column(curve.lo[:, 0], unit),
        "hi": Column(curve.hi[:, 0], unit),
        "edf": Column(curve.edf[:, 0]),
        "noise": Column(curve.power[:, 0]),
        "expected": Column(expected, unit),
    }
    if record.band is not None:
        columns["fitted_from"] = Column(np.full(len(expected), record.band.first * record.run.interval), "s")
    return Curve("allan", one.axis, columns, of=result.plan.deviation, recording=record.run.name)


def _deviation(result: Result, terms: tuple[Term, ...], m: Array, record: Recorded) -> Array:
    way = WAYS[result.plan.deviation]
    if not terms:
        return np.full(len(m), np.nan)
    variance = expected_variance(terms, m, record.run.interval, record.run.averaging, way)
    if record.band is not None and way == "allan":
        phase = total_phase(terms, record.run.interval, record.run.averaging)
        variance = variance - record.band.lost([phase], m)[0]
    return np.sqrt(np.maximum(variance, 0.0))  # rounding, where a line has a node


def _terms(result: Result, one: AxisNoise, fit: NoiseFit) -> list[Curve]:
    record, unit = one.records[0], _unit(result)
    first, last = float(record.shown.m[0]), float(record.shown.m[-1])
    density = WITH_LINES if any(isinstance(term, Sinusoid) for term in fit.terms) else PER_OCTAVE
    count = max(2, int(np.ceil(density * np.log2(last / first))) + 1)
    m = np.unique(np.rint(np.geomspace(first, last, count)))
    tau = Column(m * record.run.interval, "s")
    columns, lines = {"tau": tau}, []
    for term in one.terms:
        deviation = Column(_deviation(result, (term,), m, record), unit)
        if isinstance(term, Sinusoid):
            frequency = Column(np.full(len(m), term.frequency), "Hz")
            line = {"tau": tau, "deviation": deviation, "frequency": frequency}
            lines.append(Curve("allan_line", one.axis, line, of=result.plan.deviation))
        else:
            columns[_named(term, fit)] = deviation
    columns["all"] = Column(_deviation(result, fit.terms, m, record), unit)
    return [Curve("allan_terms", one.axis, columns, of=result.plan.deviation), *lines]


def _named(term: Term, fit: NoiseFit) -> str:
    """Return the field's word of a term."""
    found = fit.term(term.name)
    told = found.parameters if found is not None and term.parameters == ("coefficient",) else ()
    return told[0].name if told else term.name


def _spectrum(result: Result, one: AxisNoise, record: Recorded, spectrum: Spectrum) -> Curve:
    unit = density_unit(_unit(result))
    frequency, density, edf = spectrum.smoothed(PER_DECADE)
    tail = 0.5 * (1.0 - INTERVAL)
    lines, in_lines = record.spectral.lines, [False] * len(frequency)
    if lines is not None and lines.marked.any():  # bands that hold a part of a line
        marked = spectrum.frequency[lines.marked[:, 0]]
        edges = np.concatenate([[0.0], 0.5 * (frequency[1:] + frequency[:-1]), [np.inf]])
        in_lines = [bool(np.any((marked > a) & (marked <= b))) for a, b in pairwise(edges)]
    columns = {
        "frequency": Column(frequency, "Hz"),
        "density": Column(density[:, 0], unit),
        "lo": Column(density[:, 0] * edf / special.chdtri(edf, tail), unit),
        "hi": Column(density[:, 0] * edf / special.chdtri(edf, 1.0 - tail), unit),
        "line": Column(in_lines),
    }
    terms = () if one.fit is None else tuple(t for t in one.fit.terms if not isinstance(t, Sinusoid | RateRamp))
    if one.fit is not None and terms:
        run = record.run
        passed = np.ones(len(frequency))
        if record.band is not None:
            passed = record.band.passed_at(frequency * run.interval)
            columns["corner"] = Column(np.full(len(frequency), record.band.corner / run.interval), "Hz")
        for term in terms:
            density_of_term = sampled_spectrum((term,), frequency, run.interval, run.averaging)
            columns[_named(term, one.fit)] = Column(density_of_term * passed, unit)
        whole = sampled_spectrum(terms, frequency, run.interval, run.averaging) * passed
        columns["all"] = Column(whole, unit)
    return Curve("spectrum", one.axis, columns, of=result.plan.spectrum, recording=record.run.name)
