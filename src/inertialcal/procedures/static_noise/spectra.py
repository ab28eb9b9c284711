"""Spectrum and lines of one record of one axis; which lines take part in the fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...signals.allan import Allan
from ...signals.spectrum import Agreement, Line, Lines, Spectrum, compare_allan, find_lines, psd
from .plan import Plan

LONGEST = 2**17  # samples of a segment of Welch's method: lines are narrow enough, and long records cost little
PARTS = 8  # of a record, in the length of a segment
MOST_LINES = 6  # taken into a fit
TOLD = ("constant", "gaps")  # by the Allan deviation already
LISTED = 4  # lines that a remark names
SAME = 2.0  # spacings that a line may lie apart in two records


@dataclass(frozen=True, eq=False)
class Spectral:
    """What the spectrum of one record of one axis tells; None where it could not be made."""

    spectrum: Spectrum | None  # SI
    lines: Lines | None  # That stand out of its noise
    agreement: Agreement | None  # Whether the Allan deviation agrees with it
    remarks: tuple[Remark, ...]  # What is suspicious


def spectral(plan: Plan, rates: Array, interval: float, curve: Allan, axis: str) -> Spectral:
    """Return the spectrum of rates, its lines, and whether the Allan deviation agrees with it.

    Parameters
    ----------
    plan : Plan
        How it is estimated, and whether lines are looked for.
    rates : ndarray, shape (n,)
        SI; NaN where one is missing.
    interval : float
        From sample to sample [s].
    curve : Allan
        Overlapping Allan deviation of the same samples [SI].
    axis : str
        Its name.
    """
    try:
        spectrum = psd(rates, interval, plan.spectrum, segment=_segment(plan, len(rates), interval))
    except DataError as error:
        what = f"{axis}: no spectrum: {error.problems[0].what}"
        return Spectral(None, None, None, (Remark("no_spectrum", "info", what, do=error.problems[0].do, axis=axis),))
    remarks = [
        Remark(one.code, one.severity, f"{axis}: {one.what}", "", one.count, one.do, axis)
        for one in spectrum.remarks
        if one.code not in TOLD
    ]
    lines = find_lines(spectrum) if plan.lines else None
    agreement = compare_allan(spectrum, curve)
    remarks += [*_told(lines, axis), *_disagreement(agreement, axis)]
    return Spectral(spectrum, lines, agreement, tuple(remarks))


def _segment(plan: Plan, n: int, interval: float) -> int | None:
    if plan.segment is not None:
        return round(plan.segment / interval)
    return LONGEST if plan.spectrum == "welch" and n // PARTS > LONGEST else None


def _told(lines: Lines | None, axis: str) -> list[Remark]:
    """Return one remark on all lines of an axis, the strongest first."""
    if lines is None or not len(lines):
        return []
    found = sorted(lines.found, key=lambda line: -line.ratio)
    named = [
        f"{line.name}{'' if line.kind == 'line' else ' (broad)'}, {number(line.ratio, 3)} times the noise around it"
        for line in found[:LISTED]
    ]
    more = f"; {len(found) - LISTED} more" if len(found) > LISTED else ""
    what = f"{axis}: lines in the spectrum ({len(found)}): {'; '.join(named)}{more}"
    do = "Find the source: mains, fans, resonances; lines take part in the fit, broad peaks do not"
    return [Remark("lines", "warning", what, do=do, axis=axis)]


def _disagreement(agreement: Agreement, axis: str) -> list[Remark]:
    return [
        Remark(one.code, one.severity, one.what.replace("axis 0", axis, 1), do=one.do, axis=axis)
        for one in agreement.remarks
        if one.code != "allan_not_compared"
    ]


def lines_to_fit(found: Sequence[Spectral]) -> tuple[float, ...]:
    """Return the frequencies of the lines that bend an Allan deviation most, rising [Hz].

    Parameters
    ----------
    found : sequence of Spectral
        Spectra of the records of an axis.

    A line of amplitude A at f adds about A^2 to the Allan variance at 1 / (2 f), white noise of it adds f: so A^2 / f
    says how much of the curve is its.
    """
    weighed: list[tuple[float, Line, float]] = [
        (line.amplitude**2 / line.frequency, line, one.spectrum.spacing)
        for one in found
        if one.lines is not None and one.spectrum is not None
        for line in one.lines.found
        if line.kind == "line"
    ]
    chosen: list[float] = []
    for _, line, spacing in sorted(weighed, key=lambda one: -one[0]):
        if all(abs(line.frequency - other) > SAME * spacing for other in chosen) and len(chosen) < MOST_LINES:
            chosen.append(line.frequency)
    return tuple(sorted(chosen))
