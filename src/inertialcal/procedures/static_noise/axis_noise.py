"""Noise of one axis: its Allan deviations, spectra, disturbances and terms, from all records together.

Disturbances are found by ``signals.record_quality``. A disturbed sample counts as missing; a remark gives how many.
Drift stays in: how much of a warm-up to leave out is the user's choice.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from dataclasses import dataclass, field, replace
from threading import Event
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ...core.batches import count, every, finite, is_stored, known_finite
from ...core.errors import DataError, Problem
from ...core.estimate import Array
from ...core.key import Kind, Reason
from ...core.remarks import Remark
from ...core.show.rounding import freedom, number
from ...core.units import factor
from ...sensors.noise.fitting.estimator import fit
from ...sensors.noise.fitting.filtered import Band
from ...sensors.noise.fitting.noise_fit import DOUBTS, NoiseFit, duration
from ...sensors.noise.fitting.problem import run_of
from ...sensors.noise.terms import GaussMarkov, RateRandomWalk, Sinusoid, Term, quantity_name, sample_unit
from ...sensors.noise.to_filters import sensor_noise
from ...signals.allan import Allan, allan
from ...signals.codes import coarse_steps
from ...signals.names import Deviation
from ...signals.record_quality import record_quality
from ...signals.screening.resolution import Resolution, resolution_of
from ...signals.segmentation.stillness import Disturbance
from ...signals.spectrum.allan_check import Agreement, compare_allan
from ...signals.spectrum.density import Spectrum
from ...signals.spectrum.lines import Line, Lines, find_lines
from ...signals.spectrum.psd import psd
from ...signals.threads import pays, side_by_side
from .band import Bands, bands_of, inside_band
from .plan import Plan
from .readings import Readings, Run

FITTED: Deviation = "overlapping"  # that the terms are fitted to
INTERVAL = 0.95  # of the deviations
UNITS = {"gyro": "rad/s", "accelerometer": "m/s^2"}
CUT = 1e-3  # share of samples at the end of the range from which the noise that is left is no longer whole
KEPT = {
    "glitch": "glitches", "disturbed": "disturbances", "saturated": "saturated samples", "stuck": "stuck samples",
    "repeated": "repeated samples",
}  # fmt: skip
SPOILED = {
    "repeated_samples": "samples are saved twice, in place of the next",
    "noise_change": "the noise changes within the record",
}  # what changes all terms
SLOW = {
    "level_step": "a step of the level feigns slow terms",
    "slow_wave": "a slow wave feigns slow terms",
}  # what changes terms of long averaging times
FAST = ("quantization", "random_walk")  # terms that it does not
LEVELS = {"gyro": ("rad/s", "deg/h"), "accelerometer": ("m/s^2", "ug")}  # inside, and as people say a drift of bias
FEWEST = 200  # samples from which disturbances are looked for
LISTED = 3  # stretches that are named
LONGEST = 2**17  # samples of a segment of Welch's method: lines are narrow enough, and long records cost little
PARTS = 8  # of a record, in the length of a segment
MOST_LINES = 6  # taken into a fit
TOLD = ("constant", "gaps")  # by the Allan deviation already
LISTED_LINES = 4  # lines that a remark names
SAME = 2.0  # spacings that a line may lie apart in two records
SHORT = "too_short"  # code of a record whose deviations are shown without terms
NOISELESS = {"rate_ramp"}  # terms that scatter nothing


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


@dataclass(frozen=True, eq=False)
class Fitted:
    """Terms of records of one axis, or why there are none."""

    records: tuple[Recorded, ...]  # Each with its band
    bands: Bands  # What a filter of the sensor leaves of their noise
    lines: tuple[float, ...]  # Frequencies of the lines in the fit [Hz]
    fit: NoiseFit | None = None  # The terms
    problem: Problem | None = None  # Why there are none


@dataclass(frozen=True, eq=False)
class AxisNoise:
    """What the records tell of one axis."""

    axis: str  # Its name
    records: tuple[Recorded, ...]  # Those that could be used
    fit: NoiseFit | None  # Terms, from all records together; None with a reason
    problem: Problem | None  # Why there are no terms
    lines: tuple[float, ...]  # Frequencies of the lines in the fit [Hz]
    remarks: tuple[Remark, ...]  # What is suspicious
    bands: Bands = field(default_factory=Bands)  # What a filter of the sensor leaves of its noise

    @property
    def reason(self) -> str:
        """Why there are no terms."""
        return "" if self.problem is None else self.problem.what

    @property
    def terms(self) -> tuple[Term, ...]:
        """Terms that were found, SI; slow ones only where nothing feigns them."""
        found = () if self.fit is None else self.fit.terms
        return tuple(term for term in found if term.name in (*FAST, Sinusoid.name) or not self.slow_fault)

    @property
    def curve_alone(self) -> bool:
        """Whether the records have deviations, but are too short for terms."""
        return self.fit is None and self.problem is not None and self.problem.code == SHORT and bool(self.records)

    @property
    def alternatives(self) -> tuple[tuple[Term, ...], ...]:
        """Terms that were found, and those that may be true in their place, best first [SI]."""
        others = () if self.fit is None or self.slow_fault else self.fit.rivals
        return (self.terms, *(one.terms for one in others))

    @property
    def slow_fault(self) -> Reason:
        """Why slow terms of all records together are not to be told; empty where nothing speaks against them."""
        return next(filter(None, (slow_fault_of(record.run, self.axis) for record in self.records)), Reason())

    @property
    def doubt(self) -> str:
        """Why figures of all records together may not hold; empty where nothing speaks against them."""
        faults = [fault_of(record.run, self.axis) for record in self.records]
        return next(filter(None, [doubt_of(self.fit), *faults]), "")

    def for_filters(
        self, kind: Kind, horizon: float | None, take: Sequence[str]
    ) -> tuple[tuple[Term, ...], tuple[str, ...]]:
        """Return the terms that filters take, without lines, and what to say of them: see ``filters``.

        Parameters
        ----------
        kind : {"gyro", "accelerometer"}
            Which sensor it is an axis of.
        horizon : float, optional
            Averaging time at which a walk stands in for all that wanders [s].
        take : sequence of str
            Terms that are taken where the record cannot separate them from others; ``"upper_limit"``.
        """
        said: list[str] = []
        name = f"{kind} {self.axis}"
        white = tuple(term for term in self.terms if term.name in FAST)
        ways = [tuple(term for term in terms if term.name not in (*FAST, Sinusoid.name)) for terms in self.alternatives]

        def drive(terms: tuple[Term, ...]) -> float:
            return float(np.nan_to_num(sensor_noise(kind, [terms], horizon).drive[0], nan=0.0))

        def words(terms: tuple[Term, ...]) -> str:
            named = [
                "Gauss-Markov noise"
                if isinstance(term, GaussMarkov)
                else quantity_name(term.name, term.parameters[0], kind).replace("_", " ")
                for term in terms
            ]
            return " and ".join(named) or "white noise alone"

        wander = ways[0]
        if len(ways) > 1:
            wanted = [terms for terms in ways if any(term.name in take for term in terms)]
            wander = wanted[0] if wanted else max(ways, key=drive)
            why = "as wanted" if wanted else "the largest drive; --take NAME takes another"
            alike = " or ".join(words(terms) for terms in ways)
            said.append(f"{name}: the record does not tell which: {alike}; {words(wander)} taken, {why}")
        missed = None if self.fit is None else self.fit.term(RateRandomWalk.name)
        if drive(wander) == 0.0 and missed is not None and missed.upper_limit is not None and not self.slow_fault:
            limit = f"{name}: {missed.words[0].replace('_', ' ')} not found"
            if "upper_limit" in take:
                wander = (*wander, RateRandomWalk(missed.upper_limit))
                said.append(f"{limit}: its upper limit (95 %) stands in its place")
            else:
                said.append(
                    f"{limit}, below {missed.upper_limit:.3g} {missed.unit} (95 %); --take upper_limit writes that"
                )
        return (*white, *wander), tuple(said)


def noise_of(plan: Plan, readings: Readings, axis: str) -> AxisNoise:
    """Return the noise of one axis."""
    records, problems, remarks = _each(plan, readings, axis)
    if not records:
        return AxisNoise(axis, (), None, problems[0], (), (*remarks, *_no_terms(axis, problems[0])))
    waves = tuple(_waves(records, axis))
    ahead = records[0].ahead if len(readings.records) == 1 and not waves else None
    found = fit_records(plan, records, axis, waves) if ahead is None else ahead
    if ahead is not None:  # not yet looked through then
        records = [
            replace(one, looked=own.looked, run=own.run) for one, own in zip(ahead.records, records, strict=True)
        ]
    else:
        records = [*found.records]
    remarks += found.bands.remarks
    several = len(readings.records) > 1
    own_lines = [(one, remark) for one in records for remark in lines_remark(one.spectral.lines, axis)]
    remarks += [remark.at(one.run.name) if several else remark for one, remark in own_lines]
    if found.fit is None:
        assert found.problem is not None  # noqa: S101 - either is there
        remarks += _no_terms(axis, found.problem)
        return AxisNoise(axis, tuple(records), None, found.problem, found.lines, tuple(remarks), found.bands)
    remarks += [Remark(one.code, one.severity, f"{axis}: {one.what}", "", 1, one.do, axis) for one in found.fit.remarks]
    if len(records) > 1:
        records = [_with_own(plan, one, found.lines) for one in records]
    remarks += _tested(axis, found.fit)
    return AxisNoise(axis, tuple(records), found.fit, None, found.lines, tuple(remarks), found.bands)


def fit_records(plan: Plan, records: Sequence[Recorded], axis: str, waves: tuple[float, ...] = ()) -> Fitted:
    """Return the terms of records of one axis, whose slowest waves are given [Hz]."""
    bands = bands_of(plan, records, axis)
    inside = tuple(
        inside_band(replace(one, band=band, unseen=unseen))
        for one, band, unseen in zip(records, bands.each, bands.unseen, strict=True)
    )
    lines = tuple(sorted((*lines_to_fit([one.spectral for one in inside]), *waves)))
    try:
        try:
            return Fitted(inside, bands, lines, _fitted(plan, inside, lines))
        except DataError as error:  # the lines may leave the chosen terms without noise
            if error.problems[0].code != "no_noise" or not lines or plan.terms is not None:
                raise
            lines = ()
            return Fitted(inside, bands, lines, _fitted(plan, inside, lines))
    except DataError as error:
        return Fitted(inside, bands, lines, None, error.problems[0])


def _waves(records: Sequence[Recorded], axis: str) -> Iterator[float]:
    """Yield the frequency of the slowest wave of all records [Hz], where there is one: below the lines of spectra."""
    waves = [
        1.0 / (float(one.run.found[axis]["slow_wave"].value[0]) * one.run.interval)
        for one in records
        if "slow_wave" in one.run.found.get(axis, ())
    ]
    yield from sorted(waves)[:1]


def _each(plan: Plan, readings: Readings, axis: str) -> tuple[list[Recorded], list[Problem], list[Remark]]:
    """Return the records of an axis that can be fitted, or else all; why others cannot; what is suspicious."""
    usable: list[Recorded] = []
    others: list[Recorded] = []
    problems: list[Problem] = []
    remarks: list[Remark] = []
    several = len(readings.records) > 1
    for run in readings.records:
        try:
            found = _recorded(plan, run, axis)
            others.append(found)
            run_of(found.curve, 0, sample_unit(plan.kind, plan.unit))
        except DataError as error:
            problems.append(error.problems[0])
            if several:
                what = f"{axis}: record not used: {problems[-1].what}"
                remarks.append(Remark("record_not_used", "warning", what, run.name, do=problems[-1].do))
            continue
        usable.append(found)
    for found in usable or others:
        own = dict.fromkeys((*found.curve.remarks, *found.shown.remarks, *found.spectral.remarks))
        excluded = found.looked.left_out + found.run.left_out(axis)  # has remarks of its own
        gaps = int(found.curve.missing[0]) > excluded
        shown = (*found.looked.remarks, *(one for one in own if one.code != "gaps" or gaps))
        remarks += [one.at(found.run.name) if several else one for one in shown]
    return usable or others, problems, remarks


def _recorded(plan: Plan, run: Run, axis: str) -> Recorded:
    """Return a record looked through and analysed: side by side, where it is large and has shown nothing so far."""
    rates = run.rates(axis)
    if not pays(len(rates)) or is_stored(rates) or run.present.get(axis) is not None:
        looked = looked_through(plan, run, rates, axis)
        return _analysed(plan, run, axis, looked, looked.rates)
    with ThreadPoolExecutor(1) as pool:
        early = _early.get(run)
        found = None if early is None else early.found(plan, axis)
        if found is None:
            found = pool.submit(_analysed, plan, run, axis, None, rates)
        looked = looked_through(plan, run, rates, axis)
        known = None if looked.cleaned else found.result()
    if known is None:
        return _analysed(plan, run, axis, looked, looked.rates)
    return replace(known, looked=looked, run=run)


class Early:
    """What is worked out of a large record beside its screening, which finds nothing to be left out as a rule.

    The thread of it ends with `end`, or when nobody holds this any more, after what it is at.
    """

    def __init__(self, plan: Plan, run: Run, times: Mapping[str, float], whole: bool) -> None:
        """Begin, with ``times`` that samples of an axis are shown by; ``whole``: the deviations are not all."""
        self._plan, self._ended, self._pool = plan, Event(), ThreadPoolExecutor(1)
        own, go = {axis: replace(run) for axis in run.values}, copy_context().run
        self._steps = {axis: self._pool.submit(go, _resolution, one, axis, times[axis]) for axis, one in own.items()}
        self._curves = {axis: self._pool.submit(go, _curve, plan, one, axis) for axis, one in own.items()}
        self._found = {
            axis: self._pool.submit(go, _ahead, plan, one, axis, self._steps[axis], self._ended)
            for axis, one in own.items()
            if whole
        }
        self._pool.shutdown(wait=False)

    def __del__(self) -> None:
        """Let it end."""
        self._ended.set()

    def end(self) -> None:
        """Wait until it has ended."""
        self._ended.set()
        self._pool.shutdown(cancel_futures=True)

    def resolution(self, axis: str) -> Resolution | None:
        """Return the resolution of an axis; None where samples are missing."""
        return self._steps[axis].result()

    def given_to(self, run: Run) -> None:
        """Let what is found be used for a record once it is screened."""
        for axis, one in self._curves.items():
            curve = one.result() if run.present.get(axis) is None else None
            if curve is not None:
                run.curves[axis, unit_of(self._plan)] = curve
        if self._found:
            _early[run] = self

    def found(self, plan: Plan, axis: str) -> Future[Recorded | None] | None:
        """Return what is found of an axis, None where it shows a fault; nothing where another plan began it."""
        return self._found.get(axis) if plan == self._plan else None


_early: WeakKeyDictionary[Run, Early] = WeakKeyDictionary()


def end_early(run: Run) -> None:
    """Let nothing more be worked out of a record."""
    early = _early.pop(run, None)
    if early is not None:
        early.end()


def _resolution(run: Run, axis: str, times: float) -> Resolution | None:
    values = run.values[axis]
    whole = known_finite(values) or every(values, lambda part: np.isfinite(part).all())
    return resolution_of(values, times) if whole else None


def _curve(plan: Plan, run: Run, axis: str) -> Allan | None:
    """Return the deviation that terms are fitted to, of all samples; None where there is none."""
    with suppress(DataError):
        return fitted(plan, run, axis, None)
    return None


def _ahead(plan: Plan, run: Run, axis: str, resolution: Future[Resolution | None], ended: Event) -> Recorded | None:
    """Return a record with all that is found of it if it shows no fault; None where it shows one."""
    known, rates = resolution.result(), run.rates(axis)
    if known is None or ended.is_set() or not run.curves or is_stored(rates):
        return None
    curves, run = run.curves, replace(run, resolution={axis: known})
    run.curves.update(curves)
    try:
        found = _analysed(plan, run, axis, None, rates)
        run_of(found.curve, 0, sample_unit(plan.kind, plan.unit))
    except DataError:
        return None
    return None if ended.is_set() else replace(found, ahead=fit_records(plan, [found], axis))


def _analysed(plan: Plan, run: Run, axis: str, looked: Looked | None, rates: Array) -> Recorded:
    """Return the deviations and the spectrum of a record; of all its samples, where it is not yet looked through."""
    looked = Looked(rates, (), 0, (), False) if looked is None else looked
    there = None if looked.whole else finite(rates)
    curve = fitted(plan, run, axis, there, looked.cleaned)
    alike = plan.deviation == FITTED and plan.taus == "octave" and not plan.tau
    chosen, remarks = (curve, ()) if alike else shown(plan, run, axis, there)
    found = spectral(plan, _spectrum(plan, rates, run.interval), curve, axis, resolution_of_rates(run, axis))
    found = replace(found, remarks=(*remarks, *found.remarks)) if remarks else found
    return Recorded(run, looked, curve, chosen, found)


def _spectrum(plan: Plan, rates: Array, interval: float) -> Spectrum | DataError:
    """Return the spectrum of a record, or why there is none."""
    segment = LONGEST if plan.spectrum == "welch" and len(rates) // PARTS > LONGEST else None
    try:
        wanted = segment if plan.segment is None else round(plan.segment / interval)
        return psd(rates, interval, plan.spectrum, segment=wanted)
    except DataError as error:
        return error


def _fitted(plan: Plan, records: Sequence[Recorded], lines: tuple[float, ...]) -> NoiseFit:
    terms = "auto" if plan.terms is None else tuple(plan.terms)
    curves = [one.curve for one in records]
    bands = [one.band or one.unseen for one in records]
    return fit(curves, plan.kind, terms=terms, lines=lines, bands=bands, axis=0, unit=plan.unit)


def _with_own(plan: Plan, one: Recorded, lines: tuple[float, ...]) -> Recorded:
    """Return the record with the terms of it alone."""
    try:
        return replace(one, own=_fitted(plan, [one], lines))
    except DataError:
        return one


def _no_terms(axis: str, problem: Problem) -> tuple[Remark, ...]:
    """Say why there are no terms; that all samples are equal is said by the curve."""
    if problem.code == "constant":
        return ()
    return (Remark("no_terms", "warning", f"{axis}: no noise terms: {problem.what}", do=problem.do),)


def _tested(axis: str, found: NoiseFit) -> tuple[Remark, ...]:
    """Say what the tests gave that found nothing amiss."""
    ways = (
        ("terms_do_not_explain", found.residual, "the terms explain the Allan deviation"),
        ("runs_disagree", found.agreement, "the records agree"),
    )
    remarks = []
    for code, test, what in ways:
        if test is not None and code not in found.fit_warnings:
            chi = f"chi-square {test.statistic:.1f} with {freedom(test.dof)}, p = {test.p:.2g}"
            remarks.append(Remark("tested", "info", f"{axis}: {what} ({chi})"))
    return tuple(remarks)


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


def doubt_of(found: NoiseFit | None) -> str:
    """Return what a fit's own tests speak against it; empty where they do not."""
    return " and ".join(DOUBTS[code] for code in (found.fit_warnings if found is not None else ()))


def fault_of(run: Run, axis: str) -> str:
    """Return what the screening of a record speaks against its figures: what was kept in, cut, repeated or changed."""
    bad = run.bad.get(axis, {})
    kept = [] if run.screened else [KEPT[code] for code in bad if code in KEPT]
    if kept:
        return f"{' and '.join(kept)} were kept in"
    if bad.get("saturated", 0) > CUT * len(run):
        return "its noise is cut at the end of the range"
    found = run.found.get(axis, ())
    return next((said for code, said in SPOILED.items() if code in found), "")


def slow_fault_of(run: Run, axis: str) -> Reason:
    """Return why terms of long averaging times cannot be told from a record: a step or a wave feigns them."""
    found = run.found.get(axis, ())
    return next((Reason(code, said) for code, said in SLOW.items() if code in found), Reason())


@dataclass(frozen=True, eq=False)
class Looked:
    """One record of one axis, looked through."""

    rates: Array  # shape (n,): SI; NaN where a sample is missing or left out
    disturbed: tuple[Disturbance, ...]  # In order
    left_out: int  # Samples left out for them
    remarks: tuple[Remark, ...]  # What is suspicious
    whole: bool  # Whether no rate is missing
    cleaned: bool = False  # Whether some are left out that the record has


def looked_through(plan: Plan, run: Run, rates: Array, axis: str) -> Looked:
    """Return the samples of one axis as rates, shape (n,), without its disturbances."""
    left_out = run.bad.get(axis, {}).get("disturbed", 0) if run.screened else 0
    before = len(rates) if known_finite(rates) else count(rates, np.isfinite)
    if before < FEWEST:
        return Looked(rates, (*_far(run, axis),), left_out, (), before == len(rates))
    quality = record_quality(rates, run.interval)
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
    times, unit = 1.0, plan.unit or "file units"
    if plan.kind is not None:
        inside, unit = LEVELS[plan.kind]
        times = factor(inside, unit)
    third = f"the first {duration(run.length / 3.0)}"
    remarks += [one.remark(axis, times, unit, third) for one in quality.drifts if one.significant]
    remarks += coarse_steps(rates, axis)
    whole = not cleaned and before == len(rates)
    return Looked(rates, disturbed, left_out, tuple(remarks), whole, cleaned)


def _far(run: Run, axis: str) -> Iterator[Disturbance]:
    """Yield the disturbances that the screening found."""
    found = run.found.get(axis, ())
    if "disturbed" in found:
        one = run.found[axis]["disturbed"]
        for (first, last), size in zip(one.places.tolist(), one.size.tolist(), strict=True):
            yield Disturbance(first, last, abs(size))


@dataclass(frozen=True, eq=False)
class Spectral:
    """What the spectrum of one record of one axis tells; None where it could not be made."""

    spectrum: Spectrum | None  # SI
    lines: Lines | None  # That stand out of its noise
    agreement: Agreement | None  # Whether the Allan deviation agrees with it
    remarks: tuple[Remark, ...]  # What is suspicious


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
    remarks = [
        Remark(one.code, one.severity, f"{axis}: {one.what}", "", one.count, one.do, axis)
        for one in spectrum.remarks
        if one.code not in TOLD
    ]
    every, agreement = side_by_side(
        lambda: find_lines(spectrum) if plan.lines else None, lambda: compare_allan(spectrum, curve), spectrum.used
    )
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


def lines_remark(lines: Lines | None, axis: str) -> Iterator[Remark]:
    """Yield one remark on all lines of a spectrum, the strongest first."""
    if lines is None or not len(lines):
        return
    found = sorted(lines.found, key=lambda line: -line.ratio)
    named = [
        f"{line.name}{'' if line.kind == 'line' else ' (broad)'}, {number(line.ratio, 3)} times the noise around it"
        for line in found[:LISTED_LINES]
    ]
    more = f"; {len(found) - LISTED_LINES} more" if len(found) > LISTED_LINES else ""
    what = f"{axis}: lines in the spectrum ({len(found)}): {'; '.join(named)}{more}"
    do = "Find the source: mains, fans, resonances; the fit includes lines, but not broad peaks"
    yield Remark("lines", "warning", what, do=do, axis=axis)


def lines_to_fit(found: Sequence[Spectral]) -> tuple[float, ...]:
    """Return the frequencies of the lines that bend an Allan deviation most, rising [Hz]."""
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


def check(plan: Plan, readings: Readings) -> None:
    """Refuse, at the cost of Allan deviations alone, records that cannot be fitted.

    Raises
    ------
    DataError
        As ``reduce``: if no record of any axis has a deviation, with some noise, or the terms have none (``no_noise``).
    """
    if plan.terms is not None and set(plan.terms) <= NOISELESS:
        what = f"terms: {', '.join(plan.terms) or 'none'}, without noise"
        raise DataError(what, why="nothing would scatter", do='Add "random_walk"', code="no_noise")
    problems: dict[str, Problem] = {}
    for axis in readings.axes:
        for run in readings.records:
            try:
                curve = fitted(plan, run, axis, None if run.present.get(axis) is None else run.there(axis))
            except DataError as error:
                problems.setdefault(axis, error.problems[0])
                continue
            try:
                run_of(curve, 0, sample_unit(plan.kind, plan.unit))
            except DataError as error:
                if error.problems[0].code != SHORT:
                    problems.setdefault(axis, error.problems[0])
                    continue
            return
    raise DataError(problems_of(problems, readings))


def problems_of(found: Mapping[str, Problem], readings: Readings) -> list[Problem]:
    """Return why no axis has terms, each reason once, with the axes that it holds for."""
    alike: dict[Problem, list[str]] = {}
    for axis, problem in found.items():
        alike.setdefault(problem, []).append(axis)
    recorded = f"{duration(readings.length)} recorded, {len(readings.records[0])} samples a record"
    return [
        Problem(
            f"no noise terms of {', '.join(names)}: {problem.what}",
            readings.records[0].name,
            problem.why or recorded,
            problem.do or "Record the sensor standing still, for longer",
            problem.code,
        )
        for problem, names in alike.items()
    ]
