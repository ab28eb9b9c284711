"""Conditions of a campaign: which models it makes, and which tests each kind of their terms comes from."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.errors import Problem
from ...core.schema.toml import At
from ...procedures import procedure_names, procedure_of
from ...procedures.model_terms import KINDS, TermKind
from .schema import CampaignFile, Terms, Test

BY_DECISION: tuple[TermKind, ...] = ("hysteresis",)  # kinds that come into a model only where [model] names them
MATRIX: tuple[TermKind, ...] = ("scale_factor", "misalignment", "asymmetry")  # from one reduction


def gives(test: Test) -> tuple[TermKind, ...]:
    """Return the kinds of terms that a test can give to a model."""
    fits = test.use == "fit" and test.procedure in procedure_names()
    return procedure_of(test.procedure).gives if fits else ()


def parts_of_others(file: CampaignFile) -> set[str]:
    """Return the tests that another one is made of: their terms are in its own."""
    known = [test for test in file.tests if test.procedure in procedure_names()]
    return {name for test in known if procedure_of(test.procedure).made_of for name in test.after}


def on_sensor(file: CampaignFile, test: Test, sensor: str) -> bool:
    """Whether a test reads a sensor."""
    return any(file.recordings[name].sensor == sensor for name in test.recordings if name in file.recordings)


def conditions_of(file: CampaignFile, sensor: str) -> tuple[str, ...]:
    """Return the conditions that a sensor has a model of; one without a name where no test for a fit states any."""
    tests = [test for test in file.tests if gives(test) and on_sensor(file, test, sensor)]
    makes = [test for test in tests if procedure_of(test.procedure).makes_model]
    stated = dict.fromkeys(test.condition for test in makes if test.condition)
    return tuple(stated or [""]) if makes else ()


def in_condition(file: CampaignFile, test: Test, sensor: str, condition: str) -> bool:
    """Whether a test is of a condition; one that states none is of the only one that others state."""
    return test.condition == condition or (not test.condition and conditions_of(file, sensor) == (condition,))


def chosen_tests(file: CampaignFile, sensor: str, condition: str) -> dict[TermKind, list[Test]]:
    """Return the tests that each kind of term of a model comes from.

    Where ``[model] by_condition`` decides, those that it names. Where ``terms`` does, those of them that are of the
    condition; if none is, all tests of the condition, and only without any those of others. Else all tests of the
    condition; a hysteresis only where it is named, for compensation then needs the way of the temperature. What a test
    took off its readings before belongs to its bias.
    """
    every = [test for test in file.tests if gives(test) and on_sensor(file, test, sensor)]
    parts = parts_of_others(file)
    own = [test for test in every if in_condition(file, test, sensor, condition) and test.id not in parts]
    found: dict[TermKind, list[Test]] = {}
    for kind in KINDS:
        able = [test for test in every if kind in gives(test)]
        named = _named(file.model.by_condition.get(condition, {}), kind)
        if named is not None:
            chosen = [test for test in able if test.id in named]
        else:
            named = _named(file.model.terms, kind)
            wanted = [test for test in able if named and test.id in named]
            others = named and not any(test.id in named for test in every)  # it decides on another sensor
            undecided = (named is None or others) and kind not in BY_DECISION
            mine = [test for test in able if test in own and (undecided or wanted)]
            chosen = [test for test in wanted if test in own] or mine or wanted
        if chosen:
            found[kind] = chosen
    if "bias" in found:
        before = {name for test in found["bias"] for name in bias_before(file, test)} - parts
        found["bias"] = [test for test in every if test in found["bias"] or test.id in before]
    return found


def bias_before(file: CampaignFile, test: Test) -> list[str]:
    """Return the tests whose bias a test has taken off, so that its own adds to it."""
    known = {one.id for one in file.tests if one.procedure in procedure_names()
             and procedure_of(one.procedure).corrects == "bias"}  # fmt: skip
    return [name for name in test.after if name in known]


def _named(terms: Terms, kind: TermKind) -> set[str] | None:
    """Return the tests that are named for a kind of term; None where nothing is said of it."""
    if kind in MATRIX and any(one in terms for one in MATRIX):
        return {test for one in MATRIX for test in terms.get(one, [])}
    return set(terms[kind]) if kind in terms else None


def condition_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find tests whose condition is not one of the campaign, or that state none where others do."""
    known = file.conditions
    for number, test in enumerate(file.tests):
        if known and test.condition and test.condition not in known:
            what = f"test {test.id!r}: no condition {test.condition!r} in [conditions]"
            do = f"There are: {', '.join(known)}"
            yield Problem(what, at("tests", number, "condition"), do=do, code="unknown_name")
    for number, one in enumerate(file.requirements):
        if known and one.condition and one.condition not in known:
            what = f"requirement {one.id!r}: no condition {one.condition!r} in [conditions]"
            do = f"There are: {', '.join(known)}"
            yield Problem(what, at("requirements", number, "condition"), do=do, code="unknown_name")
    for sensor in file.sensors:
        stated = conditions_of(file, sensor)
        if len(stated) < 2:
            continue
        for number, test in enumerate(file.tests):
            procedure = procedure_of(test.procedure) if test.procedure in procedure_names() else None
            part = procedure is not None and procedure.gives and test.use in ("fit", "hold_out")
            if part and not test.condition and on_sensor(file, test, sensor):
                what = f"test {test.id!r} states no condition, others of sensor {sensor!r} state {', '.join(stated)}"
                do = 'Give it condition, or use = "report_only"'
                where = at("tests", number)
                yield Problem(what, where, "each condition has a model of its own", do, "condition_needed")
    yield from _decisions(file, at)


def _decisions(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find tests in ``[model]`` that give no such term, and conditions in it that no model has."""
    by_id = {test.id: test for test in file.tests}
    every = dict.fromkeys(one for sensor in file.sensors for one in conditions_of(file, sensor))
    tables: list[tuple[tuple[str, ...], Terms]] = [(("model", "terms"), file.model.terms)]
    for condition, terms in file.model.by_condition.items():
        tables.append((("model", "by_condition", condition), terms))
        if condition not in every:
            what = f"model.by_condition.{condition}: no test with use = 'fit' makes a model in this condition"
            do = f"There are: {', '.join(filter(None, every)) or 'none'}"
            yield Problem(what, at("model", "by_condition", condition), do=do, code="unknown_name")
    for path, terms in tables:
        said = ".".join(path)
        for kind, names in terms.items():
            for name in names:
                if name not in by_id or kind not in gives(by_id[name]):
                    have = ", ".join(test.id for test in file.tests if kind in gives(test))
                    what = f"{said}.{kind}: {name!r} is no test with use = 'fit' that gives it"
                    yield Problem(what, at(*path, kind), do=f"There are: {have or 'none'}", code="unknown_name")
        lists = {kind: set(terms[kind]) for kind in MATRIX if kind in terms}
        if len({frozenset(names) for names in lists.values()}) > 1:
            what = f"{said}: {', '.join(lists)} come from one reduction and need the same tests"
            yield Problem(what, at(*path), code="wrong_value")


def after_condition(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that takes off its readings what another one found in another condition."""
    by_id = {one.id: one for one in file.tests}
    for name in test.after:
        first = by_id.get(name)
        if first is None or not first.condition or first.condition == test.condition:
            continue
        here = f"is made in {test.condition}" if test.condition else "states no condition"
        what = f"test {test.id!r} {here}, and comes after {name!r}, which was made in {first.condition}"
        why = f"what {name!r} found in {first.condition} may not hold for its readings"
        do = f"Name a test of its own condition in after, or state condition = {first.condition!r}"
        yield Problem(what, at("tests", number, "after"), why, do, "condition_differs")
