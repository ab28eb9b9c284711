"""One record of one axis at rest: its Allan deviations, spectrum and disturbances.

Disturbances are found by ``signals.record_quality``. A disturbed sample counts as missing; a remark gives how many.
Drift stays in: how much of a warm-up to leave out is the user's choice. Records that are alike are looked through and
analysed side by side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.batches import count, every, finite, is_stored, known_finite
from ...core.errors import DataError, InertialcalError, Problem
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor
from ...sensors.noise.fitting.filtered import Band
from ...sensors.noise.fitting.noise_fit import NoiseFit, duration
from ...sensors.noise.fitting.problem import Run as NoiseRun
from ...sensors.noise.fitting.problem import runs_of
from ...sensors.noise.terms import sample_unit
from ...signals.allan import Allan, allan, allan_alike
from ...signals.codes import coarse_steps, surely_fine
from ...signals.names import Deviation
from ...signals.record_quality import RecordQuality, qualities_alike, record_quality
from ...signals.screening.resolution import Resolution
from ...signals.segmentation.stillness import Disturbance
from ...signals.spectrum.allan_check import Agreement, compare_allan
from ...signals.spectrum.density import Spectrum
from ...signals.spectrum.lines import Lines, find_lines, lines_apart
from ...signals.spectrum.psd import psd, psd_alike
from ...signals.threads import side_by_side
from .plan import Plan
from .readings import Run

if TYPE_CHECKING:
    from .band import Bands

FITTED: Deviation = "overlapping"  # that the terms are fitted to
INTERVAL = 0.95  # of the deviations
UNITS = {"gyro": "rad/s", "accelerometer": "m/s^2"}
LEVELS = {"gyro": ("rad/s", "deg/h"), "accelerometer": ("m/s^2", "ug")}  # inside, and as people say a drift of bias
FEWEST = 200  # samples from which disturbances are looked for
LISTED = 3  # stretches that are named
LONGEST = 2**17  # samples of a segment of Welch's method: lines are narrow enough, and long records cost little
PARTS = 8  # of a record, in the length of a segment
TOLD = ("constant", "gaps")  # by the Allan deviation already


@dataclass(frozen=True, eq=False)
class Recorded:
    """One record of one axis."""

    run: Run  # The record
    looked: Looked  # Its disturbances
    curve: Allan  # Overlapping Allan deviation at octaves, that the terms are fitted to [SI]
    shown: Allan  # The deviation to show [SI]
    spectral: Spectral  # Its spectrum
    own: NoiseFit | None = None  # Its own terms, where there are several records
    ahead: Fitted | None = None  # Its terms as they were fitted before it was looked through, if it was
    band: Band | None = None  # What a filter leaves of its noise
    unseen: Band | None = None  # What one might leave that the spectrum does not show, nor excludes
    taken: NoiseRun | None = None  # What the fit takes of its curve, where it is known


@dataclass(frozen=True, eq=False)
class Fitted:
    """Terms of records of one axis, or why there are none."""

    records: tuple[Recorded, ...]  # Each with its band
    bands: Bands  # What a filter of the sensor leaves of their noise
    lines: tuple[float, ...]  # Frequencies of the lines in the fit [Hz]
    fit: NoiseFit | None = None  # The terms
    problem: Problem | None = None  # Why there are none


@dataclass(frozen=True, eq=False)
class Looked:
    """One record of one axis, looked through."""

    rates: Array  # shape (n,): SI; NaN where a sample is missing or left out
    disturbed: tuple[Disturbance, ...]  # In order
    left_out: int  # Samples left out for them
    remarks: tuple[Remark, ...]  # What is suspicious
    whole: bool  # Whether no rate is missing
    cleaned: bool = False  # Whether some are left out that the record has


@dataclass(frozen=True, eq=False)
class Spectral:
    """What the spectrum of one record of one axis tells; None where it could not be made."""

    spectrum: Spectrum | None  # SI
    lines: Lines | None  # That stand out of its noise
    agreement: Agreement | None  # Whether the Allan deviation agrees with it
    remarks: tuple[Remark, ...]  # What is suspicious


def recorded_alike(asked: Sequence[tuple[Plan, Run, str]]) -> list[Recorded | None]:
    """Return records of axes looked through and analysed, those that are alike side by side.

    None of those that are like no other: too short, or too long, or with samples missing, or shown in another way.
    """
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, (plan, run, axis) in enumerate(asked):
        if _is_plain(plan, run, axis):
            analysis = plan.kind, unit_of(plan), plan.lines, plan.spectrum, plan.segment
            alike.setdefault((len(run), run.interval, run.averaging, *analysis), []).append(i)
    found: list[Recorded | None] = [None] * len(asked)
    for places in alike.values():
        with suppress(InertialcalError):  # each then says it by itself
            for i, one in zip(places, _analysed_alike([asked[i] for i in places]), strict=True):
                found[i] = one
    return found


def _is_plain(plan: Plan, run: Run, axis: str) -> bool:
    """Return whether the rates of an axis are those of the record, and the deviation shown is that of the fit."""
    values = run.values[axis]
    plain = values.dtype == np.float64 and values.flags.c_contiguous and not is_stored(values)
    all_there = run.quantity == "rate" and run.present.get(axis) is None
    return plain and all_there and plan.deviation == FITTED and plan.taus == "octave" and not plan.tau


def _analysed_alike(asked: Sequence[tuple[Plan, Run, str]]) -> list[Recorded | None]:
    """Return records of one length, of rates in the unit of their sensor; None of those that are not sound."""
    plan, run, _ = asked[0]
    found: list[Recorded | None] = [None] * len(asked)
    series = [run.values[axis] for _, run, axis in asked]
    names = [axis for _, _, axis in asked]
    curves, sound = allan_alike(
        series, run.interval, averaging=run.averaging, p=INTERVAL, names=names, unit=unit_of(plan)
    )
    if curves is None:
        return found
    series = [series[i] for i in sound]
    segment = _segment(plan, len(run), run.interval)
    spectra = psd_alike(series, run.interval, plan.spectrum, segment=segment)
    if spectra.remarks:  # of one of them
        return found
    lines: Sequence[Lines | None] = lines_apart(spectra) if plan.lines else [None] * len(series)
    agreements = compare_allan(spectra, curves).apart()
    qualities = qualities_alike(series, run.interval)
    taken = runs_of(curves, sample_unit(plan.kind, plan.unit))
    apart = zip(sound, series, curves.apart(), taken, spectra.apart(), lines, agreements, qualities, strict=True)
    for i, rates, curve, usable, spectrum, own, agreement, quality in apart:
        plan, run, axis = asked[i]
        if quality.disturbances:
            continue
        looked = _looked(plan, run, rates, axis, len(rates), quality, surely_fine(rates))
        run.curves[axis, curve.unit] = curve
        said = _spectral(spectrum, own, agreement, axis, resolution_of_rates(run, axis))
        found[i] = Recorded(run, looked, curve, curve, said, taken=usable)
    return found


def analysed(plan: Plan, run: Run, axis: str, looked: Looked | None, rates: Array) -> Recorded:
    """Return the deviations and the spectrum of a record; of all its samples, where it is not yet looked through."""
    looked = Looked(rates, (), 0, (), False) if looked is None else looked
    there = None if looked.whole else finite(rates)
    curve = fitted(plan, run, axis, there, looked.cleaned)
    alike = plan.deviation == FITTED and plan.taus == "octave" and not plan.tau
    chosen, remarks = (curve, ()) if alike else shown(plan, run, axis, there)
    found = spectral(plan, _spectrum(plan, rates, run.interval), curve, axis, resolution_of_rates(run, axis))
    found = replace(found, remarks=(*remarks, *found.remarks)) if remarks else found
    return Recorded(run, looked, curve, chosen, found)


def _segment(plan: Plan, n: int, interval: float) -> int | None:
    """Return the samples of a segment of the spectrum of so many; None for an eighth of them."""
    if plan.segment is not None:
        return round(plan.segment / interval)
    return LONGEST if plan.spectrum == "welch" and n // PARTS > LONGEST else None


def _spectrum(plan: Plan, rates: Array, interval: float) -> Spectrum | DataError:
    """Return the spectrum of a record, or why there is none."""
    try:
        return psd(rates, interval, plan.spectrum, segment=_segment(plan, len(rates), interval))
    except DataError as error:
        return error


def fitted(plan: Plan, run: Run, axis: str, there: NDArray[np.bool_] | None, cleaned: bool = False) -> Allan:
    """Return the deviation at octaves that terms are fitted to [SI], of the samples that are ``there``; None for all.

    That of all samples that the record has, not ``cleaned``, is kept with it.
    """
    key = axis, unit_of(plan)
    if cleaned or key not in run.curves:
        found = _allan(plan, run, axis, there, FITTED, "octave")
        if cleaned:
            return found
        run.curves[key] = found
    return run.curves[key]


def shown(plan: Plan, run: Run, axis: str, there: NDArray[np.bool_] | None) -> tuple[Allan, tuple[Remark, ...]]:
    """Return the deviation to show; at octaves where none of the wanted averaging times fits."""
    try:
        return _allan(plan, run, axis, there, plan.deviation, plan.tau or plan.taus), ()
    except DataError as error:
        if not plan.tau:
            raise
        what = f"{axis}: {error.problems[0].what}: octaves are shown"
    found = _allan(plan, run, axis, there, plan.deviation, "octave")
    return found, (Remark("taus_not_shown", "warning", what, do="Ask for shorter ones, or record longer"),)


def _allan(
    plan: Plan,
    run: Run,
    axis: str,
    there: NDArray[np.bool_] | None,
    deviation: Deviation,
    taus: str | Sequence[float],
) -> Allan:
    """Return a deviation; whole numbers, of a sensor in the unit of its file, are summed exactly."""
    return allan(
        run.values[axis],
        run.interval,
        quantity=run.quantity,
        deviation=deviation,
        taus=taus,
        averaging=run.averaging,
        present=None if there is None or every(there, np.all) else there,
        p=INTERVAL,
        names=(axis,),
        unit=unit_of(plan),
    )


def unit_of(plan: Plan) -> str:
    """Return the unit of the deviations."""
    return UNITS[plan.kind] if plan.kind else plan.unit


def looked_through(plan: Plan, run: Run, rates: Array, axis: str) -> Looked:
    """Return the samples of one axis as rates, shape (n,), without its disturbances."""
    left_out = run.bad.get(axis, {}).get("disturbed", 0) if run.screened else 0
    before = len(rates) if known_finite(rates) else count(rates, np.isfinite)
    if before < FEWEST:
        return Looked(rates, (*_far(run, axis),), left_out, (), before == len(rates))
    return _looked(plan, run, rates, axis, before, record_quality(rates, run.interval))


def _looked(
    plan: Plan, run: Run, rates: Array, axis: str, before: int, quality: RecordQuality, fine: bool = False
) -> Looked:
    """Return the same of a record of known quality, ``before`` of whose samples are there.

    ``fine``: its steps are known to be.
    """
    left_out = run.bad.get(axis, {}).get("disturbed", 0) if run.screened else 0
    cleaned = run.screened and plan.disturbed == "leave_out" and bool(quality.disturbances)
    if cleaned:
        rates = quality.cleaned()
        left_out += before - count(rates, np.isfinite)
    remarks = []
    if not quality.at_rest:
        what = f"{axis}: not at rest, or its level steps: these terms are those of the motion"
        do = "Record the sensor standing still, or choose a part at rest"
        remarks.append(Remark("not_at_rest", "warning", what, do=do))
    disturbed = tuple(sorted((*_far(run, axis), *quality.disturbances), key=lambda one: one.first))
    if disturbed:
        spans = [f"{number(run.time(one.first), 6)} .. {number(run.time(one.last), 6)} s" for one in disturbed[:LISTED]]
        spans += ["..."] if len(disturbed) > LISTED else []
        worst = number(max(one.peak for one in disturbed), 3)
        fate = f"excluded: {left_out} of {len(run)} samples" if left_out else "kept in"
        what = f"{axis}: disturbed at {', '.join(spans)}, by up to {worst} times the noise; {fate}"
        do = "" if left_out else "Exclude them, or record again undisturbed"
        remarks.append(Remark("disturbed", "warning", what, count=len(disturbed), do=do))
    drifts = [one for one in quality.drifts if one.significant]
    if drifts:
        times, unit = 1.0, plan.unit or "file units"
        if plan.kind is not None:
            inside, unit = LEVELS[plan.kind]
            times = factor(inside, unit)
        remarks += [one.remark(axis, times, unit, f"the first {duration(run.length / 3.0)}") for one in drifts]
    remarks += () if fine else coarse_steps(rates, axis)
    whole = not cleaned and before == len(rates)
    return Looked(rates, disturbed, left_out, tuple(remarks), whole, cleaned)


def _far(run: Run, axis: str) -> Iterator[Disturbance]:
    """Yield the disturbances that the screening found."""
    found = run.found.get(axis, ())
    if "disturbed" in found:
        one = run.found[axis]["disturbed"]
        for (first, last), size in zip(one.places.tolist(), one.size.tolist(), strict=True):
            yield Disturbance(first, last, abs(size))


def resolution_of_rates(run: Run, axis: str) -> Resolution:
    """Return the resolution of the rates of an axis; 0 where it is not known."""
    found = run.resolution.get(axis, Resolution(0.0, 0.0))
    times = 1.0 if run.quantity == "rate" else 1.0 / run.interval
    return Resolution(found.step * times, found.swing * times)


def _meaningful(lines: Lines, spectrum: Spectrum, resolution: Resolution) -> Lines:
    """Return the lines that the numbers of a record can carry."""
    if not len(lines):
        return lines
    at = [int(np.argmin(np.abs(spectrum.frequency - line.frequency))) for line in lines.found]
    around = [float(spectrum.density[i, 0]) / line.ratio for i, line in zip(at, lines.found, strict=True)]
    hidden = resolution.hides([line.amplitude for line in lines.found], around, spectrum.interval)
    marked = lines.marked.copy()
    for line in (line for line, none in zip(lines.found, hidden.tolist(), strict=True) if none):
        reach = 0.5 * line.width + 2.0 * spectrum.lobe * spectrum.spacing
        marked[np.abs(spectrum.frequency - line.frequency) < reach] = False
    return replace(lines, found=tuple(one for one, none in zip(lines.found, hidden.tolist(), strict=True) if not none),
                   marked=marked)  # fmt: skip


def spectral(plan: Plan, spectrum: Spectrum | DataError, curve: Allan, axis: str, resolution: Resolution) -> Spectral:
    """Return a spectrum of rates, its lines, and whether the Allan deviation agrees with it."""
    if isinstance(spectrum, DataError):
        problem = spectrum.problems[0]
        what = f"{axis}: no spectrum: {problem.what}"
        return Spectral(None, None, None, (Remark("no_spectrum", "info", what, do=problem.do, axis=axis),))
    every, agreement = side_by_side(
        lambda: find_lines(spectrum) if plan.lines else None, lambda: compare_allan(spectrum, curve), spectrum.used
    )
    return _spectral(spectrum, every, agreement, axis, resolution)


def _spectral(
    spectrum: Spectrum, every: Lines | None, agreement: Agreement, axis: str, resolution: Resolution
) -> Spectral:
    """Return what is told by a spectrum, all its lines, and how the Allan deviation agrees with it."""
    remarks = [
        Remark(one.code, one.severity, f"{axis}: {one.what}", "", one.count, one.do, axis)
        for one in spectrum.remarks
        if one.code not in TOLD
    ]
    lines = None if every is None else _meaningful(every, spectrum, resolution)
    if every is not None and lines is not None and len(lines) < len(every):
        count = len(every) - len(lines)
        what = f"{axis}: {count} line{'s' * (count > 1)} of the spectrum below the resolution of the record: not listed"
        remarks.append(Remark("lines_below_resolution", "info", what, axis=axis))
    remarks += [
        Remark(one.code, one.severity, one.what.replace("axis 0", axis, 1), do=one.do, axis=axis)
        for one in agreement.remarks
        if one.code != "allan_not_compared"
    ]
    return Spectral(spectrum, lines, agreement, tuple(remarks))
