"""Noise of one axis: its curves, spectra and terms, from all records together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ...sensors.noise.fit import fit
from ...sensors.noise.noise_fit import NoiseFit
from ...signals.allan import Allan, allan
from ...signals.allan.deviations import Deviation
from .disturbances import Looked, looked_through
from .plan import Plan, Readings, Run
from .spectra import Spectral, lines_to_fit, spectral

FITTED: Deviation = "overlapping"  # that the terms are fitted to
INTERVAL = 0.95  # of the deviations
UNITS = {"gyro": "rad/s", "accelerometer": "m/s^2"}


@dataclass(frozen=True, eq=False)
class Recorded:
    """One record of one axis.

    Parameters
    ----------
    run : Run
        The record.
    looked : Looked
        Its disturbances.
    curve : Allan
        Overlapping Allan deviation at octaves, that the terms are fitted to [SI].
    shown : Allan
        The deviation that was asked for [SI].
    spectral : Spectral
        Its spectrum.
    own : NoiseFit or None
        Its own terms, where there are several records.
    """

    run: Run
    looked: Looked
    curve: Allan
    shown: Allan
    spectral: Spectral
    own: NoiseFit | None = None


@dataclass(frozen=True, eq=False)
class AxisNoise:
    """What the records tell of one axis.

    Parameters
    ----------
    axis : str
        Its name.
    records : tuple of Recorded
        Those that could be used.
    fit : NoiseFit or None
        Terms, from all records together; None with a reason.
    problem : Problem or None
        Why there are no terms.
    lines : tuple of float
        Frequencies of the lines in the fit [Hz].
    remarks : tuple of Remark
        What is suspicious.
    """

    axis: str
    records: tuple[Recorded, ...]
    fit: NoiseFit | None
    problem: Problem | None
    lines: tuple[float, ...]
    remarks: tuple[Remark, ...]

    @property
    def reason(self) -> str:
        """Why there are no terms."""
        return "" if self.problem is None else self.problem.what


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
    records: list[Recorded] = []
    remarks: list[Remark] = []
    problems: list[Problem] = []
    for run in readings.records:
        try:
            found = _recorded(plan, run, axis)
        except DataError as error:
            problems.append(error.problems[0])
            continue
        told = (*found.looked.remarks, *_curve_remarks(found))
        remarks += [one.at(run.name) if len(readings.records) > 1 else one for one in told]
        records.append(found)
    if not records:
        return AxisNoise(axis, (), None, problems[0], (), _no_terms(axis, problems[0]))
    lines = lines_to_fit([one.spectral for one in records])
    try:
        found_terms, lines = _with_lines(plan, records, lines)
    except DataError as error:
        problem = error.problems[0]
        return AxisNoise(axis, tuple(records), None, problem, lines, (*remarks, *_no_terms(axis, problem)))
    remarks += [Remark(one.code, one.severity, f"{axis}: {one.what}", "", 1, one.do) for one in found_terms.remarks]
    records = [_with_own(plan, one, lines, len(records)) for one in records]
    return AxisNoise(axis, tuple(records), found_terms, None, lines, (*remarks, *_tested(axis, found_terms)))


def _recorded(plan: Plan, run: Run, axis: str) -> Recorded:
    looked = looked_through(plan, run, axis)
    there = np.isfinite(looked.rates)
    curve = _allan(plan, run, axis, there, FITTED, "octave")
    wanted = plan.seconds or plan.taus
    alike = plan.deviation == FITTED and wanted == "octave"
    shown = curve if alike else _allan(plan, run, axis, there, plan.deviation, wanted)
    return Recorded(run, looked, curve, shown, spectral(plan, looked.rates, run.interval, curve, axis))


def _allan(
    plan: Plan,
    run: Run,
    axis: str,
    there: NDArray[np.bool_],
    deviation: Deviation,
    taus: str | Sequence[float],
) -> Allan:
    """Return a deviation, from the samples in the type of the file: whole numbers are summed exactly."""
    return allan(
        run.values[axis],
        run.interval,
        quantity=run.quantity,
        deviation=deviation,
        taus=taus,
        averaging=run.averaging,
        scale=run.scale[axis],
        present=None if there.all() else there,
        p=INTERVAL,
        names=(axis,),
        unit=UNITS[plan.kind] if plan.kind else plan.unit,
    )


def _curve_remarks(found: Recorded) -> list[Remark]:
    """Remarks of curves and spectrum, each once; samples that were left out on purpose are said to be so already."""
    told = dict.fromkeys((*found.curve.remarks, *found.shown.remarks, *found.spectral.remarks))
    missing = int(found.curve.missing[0]) > found.looked.left_out
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
