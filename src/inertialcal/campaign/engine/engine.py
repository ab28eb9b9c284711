"""The engine: a test, from whatever side it comes, is a procedure, a plan and sources. Names no procedure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError, InertialcalError, PlanError, Problem
from ...core.influence import Occasion, Selection, Standards, zero_remarks
from ...core.key import Method
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.rounding import number
from ...procedures import procedure_of
from ...procedures.display import displayed
from ...procedures.protocol import Correction, Exclusion, Facts, P, Procedure, R, Result, S, Tested
from ...procedures.recorded import QUANTITIES as RECORDED
from ...sensors.chain.converter import Chain
from ...signals.screening.screen import NO_READINGS
from ...signals.time.sample_rates import rate_remarks
from ..file.load import Campaign
from ..file.plans import plan_values
from ..file.schema import CampaignFile, Test, site_text
from ..file.sensors import Sensor
from ..file.test_checks import counts_twice
from ..inputs.changed import one_digest
from ..inputs.channels import chain_of
from ..inputs.duplicates import Content, between, duplicates, pairs
from ..inputs.gate import RULE, Gate
from ..inputs.sources import Folder, Origin, Ready, Store, facts_of
from .together import Work, alone, ask

STAYS = 0.1  # standard uncertainties that a figure may move by and count as the same
NAMED = 3  # figures that a remark names
CHANGES = frozenset({"unit_changed", "sign_changed", "scale_changed", "axes_changed"})  # in mid-record
FOLLOWING = frozenset(
    {
        "gain_disagrees",
        "reading_disagrees",
        "run_differs",
        "recording_differs",
        "level_step",
        "noise_change",
        "not_stationary",
        "disturbed",
        "not_at_rest",
    }
)  # remarks that a change in mid-record brings about in its recording
COMPENSATED = "compensated"  # code of the remark of a reader, and of that on the recording of a test


@dataclass(frozen=True, eq=False)
class Prepared:
    """A test ready to be reduced.

    Its entry, facts, plan and readings; SHA-256 of its files by path; its recordings; samples that the gate left out;
    what recordings hold, where it is compared with others; what drew the errors of standards in it; what each of its
    recordings gives, where a requirement asks for it; its first and last instant, where its recordings say them;
    how each was saved, where saves are late.
    """

    test: Test
    facts: Facts
    plan: Any
    readings: Any
    inputs: Mapping[str, str]
    origins: tuple[Origin, ...] = ()
    screened: tuple[Exclusion, ...] = ()
    contents: tuple[Content, ...] = ()
    occasion: Occasion = field(default_factory=Occasion)
    recorded: tuple[Row, ...] = ()
    span: tuple[int, int] | None = None
    saves: tuple[Curve, ...] = ()

    @property
    def selection(self) -> Selection:
        """What it takes of its recordings."""
        hashes = tuple(one.sha256 for one in self.origins)
        return Selection(hashes, tuple(self.test.groups or ()), tuple(self.test.windows or ()))


@contextmanager
def computable(name: str, subject: str = "test") -> Iterator[None]:
    """Refuse readings on which the arithmetic of a test, or of a campaign, breaks down.

    The last resort, where no check has named them.

    Raises
    ------
    DataError
        ``not_computable``, with what failed.
    """
    try:
        yield
    except (ArithmeticError, ValueError) as error:
        kind = type(error).__name__
        if isinstance(error, ValueError) and kind != "LinAlgError":  # which is one, too
            raise
        what = f"{subject} {name!r}: its figures cannot be computed from these readings ({kind}: {error})"
        do = "Look for readings that do not vary, or vary beyond all measure"
        raise DataError(what, do=do, code="not_computable") from error


def plan_of(procedure: Procedure[P, R, S], given: Mapping[str, Any], facts: Facts) -> P:
    """Return the plan of a test: what was set, as text with units or as parsed, and what sensor and site say.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(procedure.name, dict(given), "")
    if problems:
        raise PlanError(problems)
    return procedure.plan(values, facts)


@dataclass(frozen=True, eq=False)
class Outline:
    """What a test is before any file is read: units of a lot share it, as their campaigns hold the same objects."""

    given: tuple[object, ...]  # It follows from these alone
    procedure: Procedure[Any, Any, Any]
    leading: Facts  # Of the first sensor, with those of the others
    facts: Mapping[str, Facts]  # By sensor
    chains: Mapping[str, Chain | None]  # By recording
    plan: object
    counts_twice: bool  # Whether another test of its readings would be fitted, too
    exact: tuple[Remark, ...]  # On standards without uncertainty
    asked: bool  # Whether a requirement asks for what recordings give

    @classmethod
    def of(cls, file: CampaignFile, test: Test, standards: Standards) -> Outline:
        """Return that of a test.

        Raises
        ------
        PlanError
            If a setting is wrong.
        """
        procedure = procedure_of(test.procedure)
        entries = {name: file.recordings[name] for name in test.recordings}
        facts = {one.sensor: facts_of(file.sensors[one.sensor], standards, file.site) for one in entries.values()}
        first = entries[test.recordings[0]].sensor
        leading = replace(facts[first], others=tuple(one for name, one in facts.items() if name != first))
        return cls(
            _given(file, test, standards),
            procedure,
            leading,
            facts,
            {name: chain_of(one, file.sensors[one.sensor]) for name, one in entries.items()},
            plan_of(procedure, test.plan, leading),
            any(counts_twice(file, test, one) for one in file.tests),
            tuple(zero_remarks(standards, procedure.effects())),
            any(one.quantity in RECORDED for one in file.requirements),
        )

    def holds(self, file: CampaignFile, test: Test, standards: Standards) -> bool:
        """Return whether it is that of a test of another campaign."""
        given = _given(file, test, standards)
        return len(given) == len(self.given) and all(a is b for a, b in zip(given, self.given, strict=True))


def _given(file: CampaignFile, test: Test, standards: Standards) -> tuple[object, ...]:
    """Return what an outline follows from, but for the files."""
    entries = [file.recordings[name] for name in test.recordings]
    of_recordings = [part for one in entries for part in (one.sensor, one.channels)]
    return test, standards, file.sensors, file.site, file.tests, file.requirements, *of_recordings


Outlines = dict[int, Outline]  # By number of the test


def _prepare_test(
    file: CampaignFile,
    test: Test,
    standards: Standards,
    store: Store,
    corrections: Sequence[Correction],
    gate: Gate | None,
    screening: bool,
    outline: Outline,
    when_read: Callable[[], None] | None,
) -> Work[Prepared]:
    """Work out a test of a campaign, ready to be reduced; ``when_read`` is called when its files are done with.

    Parameters
    ----------
    file : CampaignFile
        Its sensors, recordings and site.
    test : Test
        One of its tests.
    standards : mapping of Influence
        Of the campaign.
    store : Store
        That holds its files.
    corrections : sequence of Correction
        What tests before it found, to be taken off.
    gate : Gate or None
        That knows columns which other tests read.
    screening : bool
        Leave out samples that are no readings.
    outline : Outline
        Of the test.
    when_read : callable or None
        Called when nothing more is read of its files.

    Raises
    ------
    PlanError, DataError
        If a setting is wrong, or a recording cannot be read.
    """
    procedure, plan, facts = outline.procedure, outline.plan, outline.facts
    spec = procedure.inputs_for(plan, corrections)
    gate = gate or Gate()
    sources = []
    for name in dict.fromkeys(test.recordings):
        entry, chain = file.recordings[name], outline.chains[name]
        sensor = file.sensors[entry.sensor]
        sources.append(Ready(store, name, entry, sensor, facts[entry.sensor], spec, test, chain, screening, gate))
    several = len({one.file for one in sources}) > 1  # one file is no copy of itself
    compared = screening and (several or outline.counts_twice)
    contents = [one.content for one in sources if compared or one.is_table]
    problems = list(duplicates(contents))
    if problems:
        raise DataError(problems)
    try:
        with computable(test.id):
            readings = procedure.readings(plan, sources, corrections)
    except InertialcalError as error:
        raise _explained(error, [remark for one in sources for remark in one.remarks]) from None
    gated = [remark for one in sources for remark in one.remarks]
    rates = [remark for sensor in facts for remark in rate_remarks(_rates(sources, sensor))]
    known = {(one.code, one.what) for one in readings.remarks}
    unsaid = [one for source in sources for one in source.on_time if (one.code, one.what) not in known]
    elsewhere = list(_outside_condition(file, test, sources))
    inputs = one_digest(pair for one in sources for pair in one.inputs.items())
    screened = tuple(exclusion for one in sources for exclusion in one.exclusions)
    origins = tuple(one.origin for one in sources)
    occasion = occasion_of(file, test, sources)
    recorded = tuple(replace(row, test=test.id) for one in sources if outline.asked for row in one.recorded())
    spans = [one.span for one in sources]
    ends = [span for span in spans if span is not None]
    whole = len(ends) == len(spans) > 0
    span = (min(start for start, _ in ends), max(stop for _, stop in ends)) if whole else None
    saves = tuple(curve for one in sources if (curve := one.saves) is not None)
    del sources  # what was read of many units is not held at a time
    if when_read is not None:
        when_read()
    try:
        with computable(test.id):
            disagreements = yield from _disagreements(procedure, test, plan, readings, corrections)
    except InertialcalError as error:
        raise _explained(error, gated) from None
    of_sensor = procedure.remarks(outline.leading)
    more = (*elsewhere, *disagreements, *gated, *rates, *unsaid, *readings.remarks, *of_sensor, *outline.exact)
    if len(more) > len(readings.remarks):
        readings = replace(readings, remarks=in_order(more, test.recordings))
    return Prepared(
        test,
        outline.leading,
        plan,
        readings,
        inputs,
        origins,
        screened,
        tuple(contents),
        occasion,
        recorded,
        span,
        saves,
    )


def _disagreements(
    procedure: Procedure[P, R, S], test: Test, plan: P, readings: R, corrections: Sequence[Correction]
) -> Work[Sequence[Remark]]:
    """Work out where recordings disagree; without what other tests found, as for a check, they may differ by it."""
    if test.after and not corrections:
        return ()
    many = procedure.agreement_many
    return procedure.agreement(plan, readings) if many is None else (yield from ask(many, (plan, readings)))


def _outside_condition(file: CampaignFile, test: Test, sources: Sequence[Ready]) -> Iterator[Remark]:
    """Yield an error for each recording that its pressure places in another condition; a warning of a part of one."""
    own = file.conditions.get(test.condition)
    if own is None or own.pressure is None:
        return
    low, high = own.pressure
    for one in sources:
        pressures = one.pressures
        if not len(pressures):
            continue
        level, beyond = float(np.median(pressures)), (pressures < low) | (pressures > high)
        if not low <= level <= high:
            inside = (name for name, other in file.conditions.items()
                      if other.pressure is not None and other.pressure[0] <= level <= other.pressure[1])  # fmt: skip
            found = " or ".join(inside)
            what = f"recording {one.name}: pressure {level:.4g} Pa, {test.condition} is {low:.4g} to {high:.4g} Pa"
            do = f"Give the test condition = {found!r}" if found else "Give it another condition"
            yield Remark("outside_condition", "error", what, one.file, do=do, recording=one.name)
        elif beyond.any():
            at = float(pressures[np.argmax(beyond)])
            what = (
                f"recording {one.name}: part of it, such as {at:.4g} Pa, lies outside {test.condition}, {low:.4g} to "
                f"{high:.4g} Pa, and counts as {test.condition}"
            )
            do = "Cut that out: windows of the test, or start and stop of the recording's clock"
            count = int(np.count_nonzero(beyond))
            yield Remark("partly_outside_condition", "warning", what, one.file, count, do, recording=one.name)


def occasion_of(file: CampaignFile, test: Test, sources: Sequence[Ready]) -> Occasion:
    """Return what drew the errors of standards in a test: as stated, else the one day and power-up of its recordings.

    A label of a power-up holds in its campaign alone.
    """
    days = {day for one in sources for day in one.days}
    day = test.day or (days.pop() if len(days) == 1 else "")
    runs = {one.run for one in sources}
    run = runs.pop() if len(runs) == 1 else ""
    power_up = test.power_up or (f"{file.campaign.id}, {day}, {run}" if run and day else "")
    return Occasion(test.mounting, power_up, day, site_text(file.site))


def _rates(sources: Sequence[Ready], sensor: str) -> list[tuple[str, str, float]]:
    """Return name, file and sample rate [Hz] of each recording of a sensor that was read."""
    found = ((one.name, one.file, one.sample_rate) for one in sources if one.entry.sensor == sensor)
    return [(name, file, rate) for name, file, rate in found if rate is not None]


def shared_readings(campaign: Campaign, prepared: Sequence[Prepared]) -> Iterator[tuple[int, Problem]]:
    """Yield readings of two tests that would count twice, each with the number of the later test."""
    for one, other in combinations(prepared, 2):
        if counts_twice(campaign.file, one.test, other.test):
            number = campaign.file.tests.index(other.test)
            every, own = [*one.contents, *other.contents], len(one.contents)
            for first, second in sorted(pairs(every)):
                if first < own <= second:
                    yield from ((number, problem) for problem in between(every[first], every[second]))


def order_of(tests: Sequence[Test]) -> list[int]:
    """Return the numbers of tests so that each stands after that whose correction it takes; else as they stand."""
    by_name = {one.id: one for one in tests}

    def depth(test: Test) -> int:
        return max((1 + depth(by_name[name]) for name in test.after if name in by_name), default=0)

    return sorted(range(len(tests)), key=lambda number: depth(tests[number]))


def corrections_for(test: Test, tests: Sequence[Test], results: Mapping[str, Result]) -> list[Correction]:
    """Return what the tests found that a test comes after, to be taken off its readings."""
    before = [one for one in tests if one.id in test.after]
    made = (procedure_of(one.procedure).correction(one.id, results[one.id]) for one in before)
    return [one for one in made if one is not None]


def reduce_test(prepared: Prepared) -> Result:
    """Return the result of a test.

    Raises
    ------
    DataError
        As the procedure says; what its readings disagree by comes first.
    """
    procedure = procedure_of(prepared.test.procedure)
    try:
        with computable(prepared.test.id):
            found: Result = procedure.reduce(prepared.plan, prepared.readings)
    except InertialcalError as error:
        raise _explained(error, prepared.readings.remarks) from None
    return found


def reduce_alike(prepared: Sequence[Prepared]) -> list[Result | Exception]:
    """Return the result of one test for each of many units, or what `reduce_test` raises there."""
    procedure = procedure_of(prepared[0].test.procedure)
    try:
        found = procedure.reduce_many([(one.plan, one.readings) for one in prepared])
    except Exception:  # of one of them: which one, and what it says, comes out where each is alone
        return [_alone(one) for one in prepared]
    return [
        _explained(result, one.readings.remarks) if isinstance(result, InertialcalError) else result
        for one, result in zip(prepared, found, strict=True)
    ]


def _alone(prepared: Prepared) -> Result | Exception:
    try:
        return reduce_test(prepared)
    except Exception as error:  # no refusal: a fault of the program, which ends one unit and not the others
        return error


def _explained(error: InertialcalError, remarks: Sequence[Remark]) -> InertialcalError:
    """Return a refusal after the errors of the readings, and before the samples that are no readings."""
    errors = [one.problem for one in remarks if one.severity == "error"]
    screened = [one.problem for one in remarks if one.severity != "error" and one.code in NO_READINGS]
    return type(error)(list(dict.fromkeys([*errors, *error.problems, *screened])))


class Change(NamedTuple):
    """What a figure changed by since another test."""

    row: Row  # By ``Method.CHANGE``, this test less the other, or by ``Method.RATIO``, this test over the other
    first: Row  # Of the other, earlier test
    second: Row  # Of this test


@dataclass(frozen=True, eq=False)
class ReducedTest:
    """A test of a campaign that was reduced.

    Parameters
    ----------
    test : Test
        Its entry.
    tested : Tested
        As procedures see it: plan, readings, result.
    rows : sequence of Row
        SI; they name no test.
    own : tuple of Remark
        What reading and reducing brought up, errors first.
    curves : sequence of Curve
        Of what it holds out, SI.
    against : sequence of Row
        Those of the rows that are about another test, too.
    changes : sequence of Change
        What figures changed by since another test; their rows are among those.
    compared : tuple of Remark
        What the two have in common.
    errors : tuple of Remark
        Why its figures may not hold, its own and those of tests that it comes after: no model is made of them, and no
        requirement is judged.
    opened : tuple of Remark
        What its figures are with the samples that screening left out.
    recorded : sequence of Row
        What each of its recordings gives, where a requirement asks for it.
    saves : sequence of Curve
        How each of its recordings was saved, where saves are late.
    """

    test: Test
    tested: Tested[Any, Any, Any]
    rows: Sequence[Row]
    own: tuple[Remark, ...] = ()
    curves: Sequence[Curve] = ()
    against: Sequence[Row] = ()
    changes: Sequence[Change] = ()
    compared: tuple[Remark, ...] = ()
    errors: tuple[Remark, ...] = ()
    opened: tuple[Remark, ...] = ()
    recorded: Sequence[Row] = ()
    saves: Sequence[Curve] = ()

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """The same, with what it was set beside and what screening left out."""
        return (*self.own, *self.compared, *self.opened)

    @property
    def procedure(self) -> Procedure[Any, Any, Any]:
        """Of the test."""
        return procedure_of(self.test.procedure)

    @property
    def result(self) -> Result:
        """Of all its sensors."""
        found: Result = self.tested.result
        return found

    @cached_property
    def plain_rows(self) -> Mapping[str, Sequence[Row]]:
        """Rows by quantity that are its results, neither by another way nor of a part of the readings."""
        found: dict[tuple[str, int], list[Row]] = {}
        plain = Method.RESULT
        for row in self.rows:
            if row.method is plain and row.member is None and (key := row.key).at is None:
                found.setdefault((key.quantity, key.power), []).append(row)
        return {rows[0].quantity: rows for rows in found.values()}

    @cached_property
    def parts(self) -> Mapping[str, Result]:
        """The result by kind of sensor; under no name where the test has one sensor."""
        found: Mapping[str, Result] = self.procedure.by_sensor(self.tested.result)
        return found


@dataclass(frozen=True, eq=False)
class Opened:
    """A test reduced with the samples that screening left out.

    Parameters
    ----------
    count : int
        Samples that were left out.
    rows : sequence of Row
        Of its result, SI.
    refused : str
        Why it cannot be reduced with them; empty where it can.
    """

    count: int
    rows: Sequence[Row] = ()
    refused: str = ""

    @property
    def said(self) -> str:
        """How its remark begins."""
        return f"with the {self.count} sample{'s' * (self.count > 1)} that screening left out"


def screened_samples(prepared: Prepared, result: Result) -> int:
    """Return how many samples screening left out of a test."""
    procedure = procedure_of(prepared.test.procedure)
    left_out = [*prepared.screened, *procedure.exclusions(tested_of(prepared, result))]
    return sum(each.count for each in left_out if each.rule == RULE and each.counts == "sample")


def open_test(
    campaign: Campaign, prepared: Prepared, count: int, found: Mapping[str, Any], store: Store | None, gate: Gate
) -> Opened:
    """Return what a test gives with the samples that screening left out.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : Prepared
        The test without them.
    count : int
        How many they are.
    found : mapping of str to Result
        Of the tests that it comes after, by name.
    store : Store or None
        That holds its files.
    gate : Gate
        That knows its columns.
    """
    test = prepared.test
    try:
        opened = prepare(campaign, campaign.file.tests.index(test), found, store, gate, screening=False)
        result = reduce_test(opened)
        with computable(test.id):
            rows = procedure_of(test.procedure).rows(result)
    except InertialcalError as error:
        return Opened(count, refused=error.problems[0].what)
    return Opened(count, rows)


def with_opened(campaign: Campaign, one: ReducedTest, opened: Opened) -> ReducedTest:
    """Return a test with its figures as they come out with the samples that screening left out."""
    if opened.refused:
        what = f"{opened.said}, the test is refused: {opened.refused}"
        return replace(one, opened=(Remark("unscreened_refused", "info", what),))
    plain = [
        replace(row, test=one.test.id, method=Method.UNSCREENED, shared={}) for row in opened.rows if row.case.plain
    ]
    what = f"{opened.said}: {_moved(campaign, one, plain)}"
    return replace(one, rows=[*one.rows, *plain], opened=(Remark("unscreened", "info", what),))


def _moved(campaign: Campaign, one: ReducedTest, opened: Sequence[Row]) -> str:
    """Say how figures move with the samples that were left out, in the order of the results."""
    results = {row.key: row for row in one.rows if row.case.plain}
    pairs = [(results[row.key], row) for row in opened if row.key in results]
    moved = [pair for pair in pairs if _change(*pair) > STAYS]
    texts = []
    for pair in moved[:NAMED]:
        unit = sensor_of(campaign, one.test, pair[0].key.sensor).unit
        before, after = (displayed(row, unit) for row in pair)
        name = f"{before.quantity} {before.axis} {before.key.sensor}".rstrip()
        unit = "" if before.unit == "1" else f" {before.unit}"
        if before.value is None or after.value is None:
            known = after if before.value is None else before
            figure = f"{number(known.value, 4)}{unit}"
            end = "not estimated without them" if known is after else "without them, not estimated with them"
            texts.append(f"{name} {figure} {end}")
            continue
        texts.append(f"{name} {number(after.value, 4)} instead of {number(before.value, 4)}{unit}")
    more, still = len(moved) - len(texts), len(pairs) - len(moved)
    texts += [f"{more} more figure{'s' * (more > 1)} changed"] * (more > 0)
    texts += [f"{still} of {len(pairs)} figures within a tenth of their standard uncertainty"] * (still > 0)
    return "; ".join(texts) or "no figure"


def _change(before: Row, after: Row) -> float:
    """Return the change of a figure in standard uncertainties of the first, or relative to a limit without one."""
    if before.value is None or after.value is None:
        return 0.0 if before.value is after.value else math.inf
    change, scale = abs(after.value - before.value), before.u or abs(before.value)
    return change / scale if scale else math.inf if change else 0.0


def tested_of(prepared: Prepared, result: Result) -> Tested[Any, Any, Any]:
    """Return a test as procedures see it, set beside no other."""
    test = prepared.test
    return Tested(
        test.id,
        test.condition,
        test.use,
        prepared.plan,
        prepared.readings,
        result,
        tuple(test.recordings),
        tuple(prepared.inputs),
        prepared.facts,
        occasion=prepared.occasion,
        selection=prepared.selection,
    )


def reduced_tests(prepared: Sequence[Prepared], results: Mapping[str, Result]) -> Work[list[ReducedTest]]:
    """Work out the tests of a campaign with their rows, each knowing the one that it is set beside.

    Parameters
    ----------
    prepared : sequence of Prepared
        Every test.
    results : mapping of str to Result
        Of each, by name.
    """
    plain = {one.test.id: tested_of(one, results[one.test.id]) for one in prepared}
    tests = {one.test.id: one.test for one in prepared}
    own = {name: _remarks(tested) for name, tested in plain.items()}
    wrong = {name: [one for one in remarks if one.severity == "error"] for name, remarks in own.items()}
    found = []
    for one in prepared:
        tested, other = plain[one.test.id], plain.get(one.test.against or "")
        tested = tested if other is None else replace(tested, against=other)
        with computable(one.test.id):
            rows = yield from ask(procedure_of(one.test.procedure).rows_many, tested.result)
        errors = tuple(remark for name in _with_those_before(one.test, tests) for remark in wrong[name])
        said = own[one.test.id]
        found.append(ReducedTest(one.test, tested, rows, said, errors=errors, recorded=one.recorded, saves=one.saves))
    return found


def _remarks(tested: Tested[Any, Any, Any]) -> tuple[Remark, ...]:
    own = tested.result.remarks
    known = {(one.code, one.what) for one in own}
    every = [*own, *(one for one in tested.readings.remarks if (one.code, one.what) not in known)]
    return in_order(every, tested.recordings)


def in_order(remarks: Sequence[Remark], recordings: Sequence[str]) -> tuple[Remark, ...]:
    """Return remarks, errors first, and of these changes in mid-record, without what follows from a change."""
    changed = {one.recording: one.where.rpartition(":")[0] for one in remarks if one.code in CHANGES and one.recording}

    def follows(one: Remark) -> bool:
        if one.code not in FOLLOWING:
            return False
        if one.recording or one.where:
            places = (one.where == file or one.where.startswith(f"{file}:") for file in changed.values())
            return one.recording.split(",")[0] in changed or any(places)
        return all(name in changed for name in recordings)

    kept = [one for one in remarks if not (changed and follows(one))]
    return tuple(sorted(kept, key=lambda one: (one.severity != "error", one.recording not in changed)))


def _with_those_before(test: Test, tests: Mapping[str, Test]) -> list[str]:
    """Return a test and all that it comes after, by name."""
    before = (name for first in test.after if first in tests for name in _with_those_before(tests[first], tests))
    return list(dict.fromkeys((test.id, *before)))


def prepare(
    campaign: Campaign,
    number: int,
    found: Mapping[str, Any] | None = None,
    store: Store | None = None,
    gate: Gate | None = None,
    screening: bool = True,
    outlines: Outlines | None = None,
) -> Prepared:
    """Return readings and plan of one test; problems get the place of the test where they have none.

    Parameters
    ----------
    campaign : Campaign
        As read.
    number : int
        Of the test.
    found : mapping of str to Result, optional
        Of tests that were reduced before, by name: what a test comes after is taken off. Without them nothing is.
    store : Store, optional
        That holds its files; by default the folder of the campaign.
    gate : Gate, optional
        That knows columns which other tests read.
    screening : bool
        Leave out samples that are no readings.
    outlines : dict of Outline, optional
        Of tests of other units, by number; those of this one are added.
    """
    return alone(preparing(campaign, number, found, store, gate, screening, outlines))


def preparing(
    campaign: Campaign,
    number: int,
    found: Mapping[str, Any] | None = None,
    store: Store | None = None,
    gate: Gate | None = None,
    screening: bool = True,
    outlines: Outlines | None = None,
    when_read: Callable[[], None] | None = None,
) -> Work[Prepared]:
    """Work out what `prepare` returns; ``when_read`` is called when nothing more is read of the files of the test."""
    file, test, standards = campaign.file, campaign.file.tests[number], campaign.standards
    try:
        corrections = [] if found is None else corrections_for(test, file.tests, found)
        outline = None if outlines is None else outlines.get(number)
        if outline is None or not outline.holds(file, test, standards):
            outline = Outline.of(file, test, standards)
            if outlines is not None:
                outlines[number] = outline
        store = store or Folder(campaign.folder)
        prepared = yield from _prepare_test(
            file, test, standards, store, corrections, gate, screening, outline, when_read
        )
        known = tuple(prepared.readings.remarks)
        of_files = (remark for remark in known if remark.code != COMPENSATED)
        remarks = (*(_inside(campaign, remark) for remark in of_files), *_compensated(campaign, prepared))
        if remarks == known:
            return prepared
        return replace(prepared, readings=replace(prepared.readings, remarks=remarks))
    except InertialcalError as error:
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None


def _compensated(campaign: Campaign, prepared: Prepared) -> Iterator[Remark]:
    """Yield a remark a recording that a model was applied to: a warning where a campaign fits to it."""
    fits = bool(campaign.sha256) and prepared.test.use == "fit"
    do = 'Name the raw recording, or say use = "report_only"' if fits else ""
    for one in prepared.origins:
        if one.compensated_by:
            what = f"recording {one.name} was compensated by model {one.compensated_by} before"
            yield Remark(COMPENSATED, "warning" if fits else "info", what, one.file, do=do)


def _inside(campaign: Campaign, remark: Remark) -> Remark:
    """Name files as the campaign does: results must not depend on where the folder lies."""
    prefix = f"{campaign.folder}/"
    where, what = remark.where.replace(prefix, ""), remark.what.replace(prefix, "")
    return remark if (where, what) == (remark.where, remark.what) else replace(remark, where=where, what=what)


def placed(problem: Problem, campaign: Campaign, number: int) -> Problem:
    """Return a problem with its file as the campaign names it; what has no place gets that of its test."""
    where = problem.where.removeprefix(f"{campaign.folder}/") or campaign.at("tests", number)
    return replace(problem, where=where)


def sensors_of(campaign: Campaign, test: Test) -> dict[str, Sensor]:
    """Return the sensors of the recordings of a test, by name."""
    names = (campaign.file.recordings[name].sensor for name in test.recordings)
    return {name: campaign.file.sensors[name] for name in names}


def sensor_of(campaign: Campaign, test: Test, kind: str = "") -> Sensor:
    """Return the sensor of a test: of a kind, where the test has several, else the first."""
    first, *others = sensors_of(campaign, test).values()
    return next((one for one in others if one.kind == kind), first)
