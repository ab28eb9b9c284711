"""The engine: a test, from whatever side it comes, is a procedure, a plan and sources. Names no procedure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...core.curve import Curve
from ...core.errors import PlanError
from ...core.influence import Standards
from ...core.results import Row
from ...procedures import procedure_of
from ...procedures.protocol import Correction, Facts, P, Procedure, R, Result, S, Tested
from ..file.plans import plan_values
from ..file.schema import CampaignFile, Test
from ..inputs.channels import chain_of
from ..inputs.origins import Origin
from ..inputs.sources import Ready, Store, facts_of


@dataclass(frozen=True, eq=False)
class Prepared:
    """A test ready to be reduced: entry, plan, facts, readings, SHA-256 of its files by path, and its recordings."""

    test: Test
    facts: Facts
    plan: Any
    readings: Any
    inputs: Mapping[str, str]
    origins: tuple[Origin, ...] = ()


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


def prepare_test(
    file: CampaignFile, test: Test, standards: Standards, store: Store, corrections: Sequence[Correction] = ()
) -> Prepared:
    """Return a test of a campaign, ready to be reduced.

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

    Raises
    ------
    PlanError, DataError
        If a setting is wrong, or a recording cannot be read.
    """
    procedure = procedure_of(test.procedure)
    entries = {name: file.recordings[name] for name in test.recordings}
    sensors = {name: file.sensors[entry.sensor] for name, entry in entries.items()}
    facts = {entry.sensor: facts_of(sensors[name], standards, file.site) for name, entry in entries.items()}
    first = facts[entries[test.recordings[0]].sensor]
    plan = plan_of(procedure, test.plan, first)
    spec = procedure.inputs_for(plan, corrections)
    sources = [
        Ready(store, name, one, sensors[name], facts[one.sensor], spec, test, chain_of(one, sensors[name]))
        for name, one in entries.items()
    ]
    readings = procedure.readings(plan, sources, corrections)
    more = procedure.remarks(first)
    if more:
        readings = replace(readings, remarks=(*readings.remarks, *more))
    inputs = {path: digest for one in sources for path, digest in one.inputs.items()}
    return Prepared(test, first, plan, readings, inputs, tuple(one.origin for one in sources))


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
        As the procedure says.
    """
    procedure = procedure_of(prepared.test.procedure)
    found: Result = procedure.reduce(prepared.plan, prepared.readings)
    return found


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
        SI, each with the name of the test.
    curves : sequence of Curve
        Of what it holds out, SI.
    against : sequence of Row
        Those of the rows that are about another test, too.
    """

    test: Test
    tested: Tested[Any, Any, Any]
    rows: Sequence[Row]
    curves: Sequence[Curve] = ()
    against: Sequence[Row] = ()

    @property
    def procedure(self) -> Procedure[Any, Any, Any]:
        """Of the test."""
        return procedure_of(self.test.procedure)

    @property
    def result(self) -> Result:
        """Of all its sensors."""
        found: Result = self.tested.result
        return found

    @property
    def parts(self) -> Mapping[str, Result]:
        """The result by kind of sensor; under no name where the test has one sensor."""
        found: Mapping[str, Result] = self.procedure.by_sensor(self.tested.result)
        return found


def reduced_tests(prepared: Sequence[Prepared], results: Mapping[str, Result]) -> list[ReducedTest]:
    """Return the tests of a campaign with their rows, each knowing the one that it is set beside.

    Parameters
    ----------
    prepared : sequence of Prepared
        Every test.
    results : mapping of str to Result
        Of each, by name.
    """
    plain = {
        one.test.id: Tested(
            one.test.id,
            one.test.condition,
            one.test.use,
            one.plan,
            one.readings,
            results[one.test.id],
            tuple(one.test.recordings),
            tuple(one.inputs),
            one.facts,
        )
        for one in prepared
    }
    found = []
    for one in prepared:
        tested = replace(plain[one.test.id], against=plain.get(one.test.against or ""))
        rows = procedure_of(one.test.procedure).rows(tested.result)
        found.append(ReducedTest(one.test, tested, [replace(row, test=one.test.id) for row in rows]))
    return found
