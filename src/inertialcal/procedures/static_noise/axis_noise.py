"""Noise of one axis: its curves, spectra and terms, from all records together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ...sensors.noise.fitting.estimator import fit
from ...sensors.noise.fitting.noise_fit import NoiseFit
from ...signals.allan import Allan
from .deviations import FITTED, fitted, shown
from .doubts import doubt_of, fault_of
from .plan import Plan
from .readings import Readings, Run
from .records.disturbances import Looked, looked_through
from .records.usable import check_usable
from .spectra import Spectral, lines_to_fit, spectral


@dataclass(frozen=True, eq=False)
class Recorded:
    """One record of one axis."""

    run: Run  # The record
    looked: Looked  # Its disturbances
    curve: Allan  # Overlapping Allan deviation at octaves, that the terms are fitted to [SI]
    shown: Allan  # The deviation that was asked for [SI]
    spectral: Spectral  # Its spectrum
    own: NoiseFit | None = None  # Its own terms, where there are several records


@dataclass(frozen=True, eq=False)
class AxisNoise:
    """What the records tell of one axis."""

    axis: str  # Its name
    records: tuple[Recorded, ...]  # Those that could be used
    fit: NoiseFit | None  # Terms, from all records together; None with a reason
    problem: Problem | None  # Why there are no terms
    lines: tuple[float, ...]  # Frequencies of the lines in the fit [Hz]
    remarks: tuple[Remark, ...]  # What is suspicious

    @property
    def reason(self) -> str:
        """Why there are no terms."""
        return "" if self.problem is None else self.problem.what

    @property
    def doubt(self) -> str:
        """Why figures of all records together may not hold; empty where nothing speaks against them."""
        faults = [fault_of(record.run, self.axis) for record in self.records]
        return next(filter(None, [doubt_of(self.fit), *faults]), "")


def noise_of(plan: Plan, readings: Readings, axis: str) -> AxisNoise:
    """Return the noise of one axis.

    Parameters
    ----------
    plan : Plan
        What is asked for.
    readings : Readings
        All records.
    axis : str
        Which.
    """
    records, problems, remarks = _each(plan, readings, axis)
    if not records:
        return AxisNoise(axis, (), None, problems[0], (), (*remarks, *_no_terms(axis, problems[0])))
    lines = lines_to_fit([one.spectral for one in records])
    try:
        found_terms, lines = _with_lines(plan, records, lines)
    except DataError as error:
        problem = error.problems[0]
        return AxisNoise(axis, tuple(records), None, problem, lines, (*remarks, *_no_terms(axis, problem)))
    remarks += [
        Remark(one.code, one.severity, f"{axis}: {one.what}", "", 1, one.do, axis) for one in found_terms.remarks
    ]
    records = [_with_own(plan, one, lines, len(records)) for one in records]
    return AxisNoise(axis, tuple(records), found_terms, None, lines, (*remarks, *_tested(axis, found_terms)))


def _each(plan: Plan, readings: Readings, axis: str) -> tuple[list[Recorded], list[Problem], list[Remark]]:
    """Return the records of an axis that terms can be told from, or else all; why others cannot; what is suspicious."""
    usable: list[Recorded] = []
    others: list[Recorded] = []
    problems: list[Problem] = []
    remarks: list[Remark] = []
    several = len(readings.records) > 1
    for run in readings.records:
        try:
            found = _recorded(plan, run, axis)
            others.append(found)
            check_usable(plan, found.curve)
        except DataError as error:
            problems.append(error.problems[0])
            remarks += [_not_used(axis, problems[-1], run)] if several else []
            continue
        usable.append(found)
    for found in usable or others:
        told = (*found.looked.remarks, *_curve_remarks(found))
        remarks += [one.at(found.run.name) if several else one for one in told]
    return usable or others, problems, remarks


def _recorded(plan: Plan, run: Run, axis: str) -> Recorded:
    looked = looked_through(plan, run, axis)
    there = np.isfinite(looked.rates)
    curve = fitted(plan, run, axis, there)
    alike = plan.deviation == FITTED and plan.taus == "octave" and not plan.seconds
    asked, told = (curve, ()) if alike else shown(plan, run, axis, there)
    found = spectral(plan, looked.rates, run.interval, curve, axis)
    return Recorded(run, looked, curve, asked, replace(found, remarks=(*told, *found.remarks)))


def _curve_remarks(found: Recorded) -> list[Remark]:
    """Remarks of curves and spectrum, each once; samples that were left out on purpose are said to be so already."""
    told = dict.fromkeys((*found.curve.remarks, *found.shown.remarks, *found.spectral.remarks))
    left_out = found.looked.left_out + found.run.left_out(found.curve.names[0])
    missing = int(found.curve.missing[0]) > left_out
    return [one for one in told if one.code != "gaps" or missing]


def _fitted(plan: Plan, records: Sequence[Recorded], lines: tuple[float, ...]) -> NoiseFit:
    terms = "auto" if plan.terms is None else tuple(plan.terms)
    curves = [one.curve for one in records]
    return fit(curves, plan.kind, terms=terms, lines=lines, axis=0, unit=plan.unit)


def _with_lines(
    plan: Plan, records: Sequence[Recorded], lines: tuple[float, ...]
) -> tuple[NoiseFit, tuple[float, ...]]:
    """Return the fit and the lines in it: none where terms chosen beside them are without noise."""
    try:
        return _fitted(plan, records, lines), lines
    except DataError as error:
        if error.problems[0].code != "no_noise" or not lines or plan.terms is not None:
            raise
    return _fitted(plan, records, ()), ()


def _with_own(plan: Plan, one: Recorded, lines: tuple[float, ...], several: int) -> Recorded:
    """Return the record with its own terms, where it is one of several."""
    if several < 2:
        return one
    try:
        own = _fitted(plan, [one], lines)
    except DataError:
        return one
    return Recorded(one.run, one.looked, one.curve, one.shown, one.spectral, own)


def _no_terms(axis: str, problem: Problem) -> tuple[Remark, ...]:
    """Say why there are no terms; that all samples are equal is said by the curve."""
    if problem.code == "constant":
        return ()
    return (Remark("no_terms", "warning", f"{axis}: no noise terms: {problem.what}", do=problem.do),)


def _tested(axis: str, found: NoiseFit) -> tuple[Remark, ...]:
    """Say what the tests gave that found nothing amiss."""
    ways = ((found.residual, "the terms explain the Allan deviation"), (found.agreement, "the records agree"))
    warned = {one.code for one in found.remarks}
    codes = ("terms_do_not_explain", "runs_disagree")
    return tuple(
        Remark(
            "tested",
            "info",
            f"{axis}: {what} (chi-square {test.statistic:.1f} with {test.dof} degrees of freedom, p = {test.p:.2g})",
        )
        for (test, what), code in zip(ways, codes, strict=True)
        if test is not None and code not in warned
    )


def _not_used(axis: str, problem: Problem, run: Run) -> Remark:
    what = f"{axis}: this record is not used: {problem.what}"
    return Remark("record_not_used", "warning", what, run.name, do=problem.do)
