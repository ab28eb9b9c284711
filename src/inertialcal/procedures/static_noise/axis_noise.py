"""Noise of one axis: its terms, from all records together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Event
from weakref import WeakKeyDictionary

import numpy as np

from ...core.batches import every, is_stored, known_finite
from ...core.errors import DataError, InertialcalError, Problem
from ...core.key import Kind, Reason
from ...core.remarks import Remark
from ...core.results import changed
from ...core.show.rounding import freedom, number
from ...sensors.noise.fitting.estimator import Fit, fit_many
from ...sensors.noise.fitting.noise_fit import DOUBTS, NoiseFit, duration
from ...sensors.noise.fitting.problem import run_of
from ...sensors.noise.terms import GaussMarkov, RateRandomWalk, Sinusoid, Term, quantity_name, sample_unit
from ...sensors.noise.to_filters import sensor_noise
from ...signals.allan import Allan
from ...signals.screening.resolution import Resolution, resolution_of
from ...signals.spectrum.lines import Line, Lines
from ...signals.threads import pays
from .band import Bands, bands_of, inside_band
from .plan import Plan
from .readings import Readings, Run
from .record import Fitted, Recorded, Spectral, analysed, fitted, looked_through, recorded_alike, unit_of

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
MOST_LINES = 6  # taken into a fit
LISTED_LINES = 4  # lines that a remark names
SAME = 2.0  # spacings that a line may lie apart in two records
SHORT = "too_short"  # code of a record whose deviations are shown without terms
FEW = 12  # axes whose intervals of another probability are found when they are asked for
JUDGED = 0.9  # probability of the interval that a verdict of 95 % by one limit takes
LOOKED_AT = 64  # samples that mostly say whether a record scatters
ALIKE, TINY = 1e-6, 1e-100  # relative and absolute difference of samples that may be rounding
NOISELESS = {"rate_ramp"}  # terms that scatter nothing


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

    @cached_property
    def slow_fault(self) -> Reason:
        """Why slow terms of all records together are not to be told; empty where nothing speaks against them."""
        return next(filter(None, (slow_fault_of(record.run, self.axis) for record in self.records)), Reason())

    @cached_property
    def doubt(self) -> str:
        """Why figures of all records together may not hold; empty where nothing speaks against them."""
        faults = (fault_of(record.run, self.axis) for record in self.records)
        return doubt_of(self.fit) or next(filter(None, faults), "")

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


def noises_of(asked: Sequence[tuple[Plan, Readings, str]]) -> list[AxisNoise]:
    """Return the noise of many axes, of many units: what is alike is analysed and fitted side by side."""
    each = _each(asked)
    waves = [tuple(_waves(records, axis)) for (_, _, axis), (records, _, _) in zip(asked, each, strict=True)]
    found: dict[int, Fitted] = {}
    for i, (_, readings, _) in enumerate(asked):
        ahead = each[i][0][0].ahead if each[i][0] and len(readings.records) == 1 and not waves[i] else None
        if ahead is not None:  # not yet looked through then
            own = each[i][0][0]
            found[i] = replace(ahead, records=(replace(ahead.records[0], looked=own.looked, run=own.run),))
    missing = [i for i in range(len(asked)) if i not in found and each[i][0]]
    fits = fit_records([(asked[i][0], each[i][0], asked[i][2], waves[i]) for i in missing])
    found |= dict(zip(missing, fits, strict=True))
    return [_noise(*one, *own[1:], found.get(i)) for i, (one, own) in enumerate(zip(asked, each, strict=True))]


def _noise(
    plan: Plan, readings: Readings, axis: str, problems: Sequence[Problem], remarks: list[Remark], found: Fitted | None
) -> AxisNoise:
    """Return the noise of one axis, by the terms of its records; by none where there are none."""
    if found is None:
        return AxisNoise(axis, (), None, problems[0], (), (*remarks, *_no_terms(axis, problems[0])))
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


def fit_records(asked: Sequence[tuple[Plan, Sequence[Recorded], str, tuple[float, ...]]]) -> list[Fitted]:
    """Return the terms of records of each of many axes, whose slowest waves are given [Hz]."""
    every = bands_of([one[:3] for one in asked])
    found = [_banded(records, waves, bands) for (_, records, _, waves), bands in zip(asked, every, strict=True)]
    plans = [plan for plan, *_ in asked]
    fits = _fits_of([(plan, one.records, one.lines) for plan, one in zip(plans, found, strict=True)])
    # The lines may leave the chosen terms without noise
    again = [
        i
        for i, (plan, one, fit) in enumerate(zip(plans, found, fits, strict=True))
        if isinstance(fit, DataError) and fit.problems[0].code == "no_noise" and one.lines and plan.terms is None
    ]
    for i, fit in zip(again, _fits_of([(plans[i], found[i].records, ()) for i in again]), strict=True):
        found[i], fits[i] = replace(found[i], lines=()), fit
    return [
        changed(one, problem=fit.problems[0]) if isinstance(fit, InertialcalError) else changed(one, fit=fit)
        for one, fit in zip(found, fits, strict=True)
    ]


def _banded(records: Sequence[Recorded], waves: tuple[float, ...], bands: Bands) -> Fitted:
    """Return the records of one axis with their bands, and the lines to be fitted."""
    inside = tuple([
        inside_band(changed(one, band=band, unseen=unseen))
        for one, band, unseen in zip(records, bands.each, bands.unseen, strict=True)
    ])  # fmt: skip
    return Fitted(inside, bands, tuple(sorted((*lines_to_fit([one.spectral for one in inside]), *waves))))


def _waves(records: Sequence[Recorded], axis: str) -> Iterator[float]:
    """Yield the frequency of the slowest wave of all records [Hz], where there is one: below the lines of spectra."""
    waves = [
        1.0 / (float(one.run.found[axis]["slow_wave"].value[0]) * one.run.interval)
        for one in records
        if "slow_wave" in one.run.found.get(axis, ())
    ]
    yield from sorted(waves)[:1]


def _each(
    asked: Sequence[tuple[Plan, Readings, str]],
) -> list[tuple[list[Recorded], list[Problem], list[Remark]]]:
    """Return the records of each axis that can be fitted, or else all; why others cannot; what is suspicious."""
    every = [(plan, run, axis) for plan, readings, axis in asked for run in readings.records]
    known = iter(recorded_alike(every))
    return [_usable(plan, readings, axis, known) for plan, readings, axis in asked]


def _usable(
    plan: Plan, readings: Readings, axis: str, known: Iterator[Recorded | None]
) -> tuple[list[Recorded], list[Problem], list[Remark]]:
    """Return the same of one axis, some of whose records are known."""
    usable: list[Recorded] = []
    others: list[Recorded] = []
    problems: list[Problem] = []
    remarks: list[Remark] = []
    several = len(readings.records) > 1
    for run, alike in zip(readings.records, known, strict=False):
        try:
            found = _recorded(plan, run, axis) if alike is None else alike
            others.append(found)
            if found.taken is None:
                found = replace(found, taken=run_of(found.curve, 0, sample_unit(plan.kind, plan.unit)))
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
        return analysed(plan, run, axis, looked, looked.rates)
    with ThreadPoolExecutor(1) as pool:
        early = _early.get(run)
        found = None if early is None else early.found(plan, axis)
        if found is None:
            found = pool.submit(analysed, plan, run, axis, None, rates)
        looked = looked_through(plan, run, rates, axis)
        known = None if looked.cleaned else found.result()
    if known is None:
        return analysed(plan, run, axis, looked, looked.rates)
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
        found = analysed(plan, run, axis, None, rates)
        run_of(found.curve, 0, sample_unit(plan.kind, plan.unit))
    except DataError:
        return None
    return None if ended.is_set() else replace(found, ahead=fit_records([(plan, [found], axis, ())])[0])


def _fits_of(
    asked: Sequence[tuple[Plan, Sequence[Recorded], tuple[float, ...]]],
) -> list[NoiseFit | InertialcalError]:
    """Return the terms of the records of each of many axes, with lines of known frequency [Hz], or why there are none.

    Raises
    ------
    InertialcalError
        What is wrong with a plan.
    """
    also = (JUDGED,) if len(asked) > FEW else ()  # of a lot: judged by limits, most of them
    fits = fit_many([
        Fit(
            [one.taken or one.curve for one in records], plan.kind,
            "auto" if plan.terms is None else tuple(plan.terms), lines,
            [one.band or one.unseen for one in records], 0, plan.unit, also=also,
        )
        for plan, records, lines in asked
    ])  # fmt: skip
    for one in fits:
        if isinstance(one, InertialcalError) and not isinstance(one, DataError):
            raise one
    return fits


def _with_own(plan: Plan, one: Recorded, lines: tuple[float, ...]) -> Recorded:
    """Return the record with the terms of it alone."""
    (found,) = _fits_of([(plan, [one], lines)])
    return one if isinstance(found, InertialcalError) else replace(one, own=found)


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
            if _plainly_scatters(run, axis):
                return
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


def _plainly_scatters(run: Run, axis: str) -> bool:
    """Return whether the first samples alone say that a record has a deviation with some noise."""
    few = run.values[axis][:LOOKED_AT]
    if run.quantity != "rate" or run.present.get(axis) is not None or few.dtype.kind != "f" or len(few) < LOOKED_AT:
        return False
    least, largest = float(few.min()), float(few.max())  # NaN where one is missing
    return np.inf > largest - least > max(ALIKE * max(abs(least), abs(largest)), TINY)


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
