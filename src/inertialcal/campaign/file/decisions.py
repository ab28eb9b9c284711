"""Decision rules that a contract names: ``[decision]`` for all requirements, ``decision`` of one of them.

A key that the rule does not use is refused, and a rule that cannot judge a requirement: a test uncertainty ratio needs
two limits, a global risk the distribution of the items and a figure whose error is Student's.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, ValidationError

from ...core.errors import DataError, PlanError, Problem, UsageError
from ...core.judging import Process, Rule, RuleName
from ...core.schema.quantities import Relative, Strict
from ...core.schema.toml import At, parse_toml
from ...core.units import parse_quantity, same_dimension

NEEDS: dict[RuleName, str] = {
    "guard_factor": "factor",
    "false_accept_risk": "risk",
    "test_uncertainty_ratio": "ratio",
}
KEYS: dict[RuleName, tuple[str, ...]] = {
    "interval": ("binary",),
    "simple_acceptance": (),
    "guard_factor": ("factor", "binary"),
    "false_accept_risk": ("risk", "process", "binary"),
    "test_uncertainty_ratio": ("ratio", "otherwise"),
}
EXAMPLES = {
    "factor": "factor = NUMBER",
    "risk": 'risk = "NUMBER %"',
    "ratio": "ratio = NUMBER",
}


class ProcessEntry(Strict):
    """``process``: distribution of the true values of all items."""

    mean: str | None = None
    sd: str | None = None
    in_tolerance: Relative | None = None


class Decision(Strict):
    """[decision]."""

    rule: RuleName = "interval"
    factor: Annotated[float, Field(gt=0.0, le=10.0)] | None = None
    risk: Relative | None = None
    process: ProcessEntry | None = None
    ratio: Annotated[float, Field(ge=1.0, le=1000.0)] | None = None
    otherwise: Decision | None = None
    binary: bool = False

    def made(self) -> Rule:
        """Return the rule."""
        process = None
        if (entry := self.process) is not None:
            given = [None if text is None else parse_quantity(text) for text in (entry.mean, entry.sd)]
            process = Process(given[0], given[1], entry.in_tolerance)
        inner = None if self.otherwise is None else self.otherwise.made()
        numbers = {name: one for name in ("factor", "risk", "ratio") if (one := getattr(self, name)) is not None}
        return Rule(self.rule, **numbers, process=process, otherwise=inner, binary=self.binary)


def read_decision(text: str) -> Rule:
    """Return the rule of an option: ``simple_acceptance``, ``guard_factor=1``, or a table as campaign.toml has it.

    Raises
    ------
    UsageError
        ``decision``.
    """
    name, equals, value = text.partition("=")
    name, value = name.strip(), value.strip()
    table = text if text.strip().startswith("{") else f'{{ rule = "{name}" }}'
    if equals and table is not text:
        key = next((key for rule, key in NEEDS.items() if rule == name), "")
        quoted = f'"{value}"' if key == "risk" else value
        table = f'{{ rule = "{name}", {key or "of"} = {quoted} }}'
    do = f'Write one of {", ".join(KEYS)}, with its number: guard_factor=NUMBER, false_accept_risk="NUMBER %"'
    try:
        found = Decision.model_validate(parse_toml(f"decision = {table}".encode(), "")[1]["decision"])
    except PlanError as error:
        raise UsageError(f"--decision {text!r}: {error.problems[0].what}", do=do, code="decision") from None
    except ValidationError as error:
        wrong = error.errors(include_url=False)[0]
        key = ".".join(str(part) for part in wrong["loc"])
        what = f"{key}: {wrong['msg'].removeprefix('Value error, ')}"
        raise UsageError(f"--decision {text!r}: {what}", do=do, code="decision") from None
    problems = [*key_problems(found, ("decision",), lambda *path: ""), *_global("--decision", found)]
    if problems:
        raise UsageError(f"--decision {text!r}: {problems[0].what}", do=problems[0].do or do, code="decision")
    return found.made()


def _global(what: str, decision: Decision) -> Iterator[Problem]:
    for one in (decision, decision.otherwise):
        if one is not None and one.process is not None:
            yield Problem(f"{what}: a global risk is about the items of a process, not about a difference")


def key_problems(decision: Decision, path: tuple[str | int, ...], at: At) -> Iterator[Problem]:
    """Find keys that the rule needs, or does not use, and numbers that it cannot have."""
    name = f"decision: rule = {decision.rule!r}"
    for key in Decision.model_fields:
        if key != "rule" and key not in KEYS[decision.rule] and getattr(decision, key) not in (None, False):
            do = f"It takes: {', '.join(KEYS[decision.rule]) or 'no other key'}"
            yield Problem(f"{name} does not use {key}", at(*path, key), "it would have no effect", do, "unknown_key")
    needed = NEEDS.get(decision.rule)
    if needed and getattr(decision, needed) is None:
        yield Problem(f"{name} needs {needed}", at(*path, "rule"), do=f"Add {EXAMPLES[needed]}", code="missing_key")
    if decision.risk is not None and not 0.0 < decision.risk < 0.5:
        what = f"decision: risk = {100.0 * decision.risk:g} %"
        yield Problem(what, at(*path, "risk"), do="Need more than 0 and less than 50 %", code="wrong_value")
    yield from _process(decision, path, at)
    if (inner := decision.otherwise) is not None:
        if inner.rule == "test_uncertainty_ratio":
            what = "decision: otherwise is a test uncertainty ratio again"
            yield Problem(what, at(*path, "otherwise"), do="Name the rule below the ratio", code="wrong_value")
        else:
            yield from key_problems(inner, (*path, "otherwise"), at)


def _process(decision: Decision, path: tuple[str | int, ...], at: At) -> Iterator[Problem]:
    process = decision.process
    if process is None:
        return
    where = at(*path, "process")
    if (process.sd is None) == (process.in_tolerance is None):
        do = 'Give sd = "NUMBER UNIT" or in_tolerance = "NUMBER %"'
        yield Problem("decision: process needs the standard deviation, or the share in tolerance", where, do=do,
                      code="missing_key")  # fmt: skip
    if process.in_tolerance is not None and not 0.0 < process.in_tolerance < 1.0:
        what = f"decision: in_tolerance = {100.0 * process.in_tolerance:g} %"
        yield Problem(what, where, do="Need more than 0 and less than 100 %", code="wrong_value")
    if process.in_tolerance is not None and process.mean is not None:
        what = "decision: in_tolerance is about a process centred between the limits; mean has no effect"
        yield Problem(what, where, do="Leave mean out, or give sd", code="wrong_value")
    for key in ("mean", "sd"):
        text = getattr(process, key)
        try:
            if text is not None and key == "sd" and not parse_quantity(text).value > 0.0:
                yield Problem(f"decision: sd = {text!r}", where, do="Need a number above zero", code="wrong_value")
            elif text is not None:
                parse_quantity(text)
        except DataError as error:
            yield Problem(f"decision: {key}: {error.problems[0].what}", where, code="wrong_value")


def fit_problems(
    decision: Decision, name: str, limits: tuple[str | None, str | None], over: str, size: bool, where: str
) -> Iterator[Problem]:
    """Find what keeps a rule from judging a requirement.

    Parameters
    ----------
    decision : Decision
        The rule.
    name : str
        Of the requirement.
    limits : pair of str or None
        Lower and upper, as the requirement states them.
    over : str
        What it is judged over: ``rate``, ``temperature``; empty for a single figure.
    size : bool
        Whether the figure is a size, which is judged by its own interval.
    where : str
        Place, for messages.
    """
    do = "Give the requirement a decision of its own that it can be judged by"
    if decision.rule == "test_uncertainty_ratio" and None in limits:
        what = f"requirement {name!r}: a test uncertainty ratio needs two limits, it has one"
        yield Problem(what, where, "the ratio is the span of the limits over 2 U", do, "wrong_value")
    for one in (decision, decision.otherwise):
        if one is None or one.process is None:
            continue
        if over or size:
            why = f"it is judged over {over}" if over else "the interval of a size is not Student's"
            what = f"requirement {name!r}: a global risk is defined for a single figure with a normal error"
            yield Problem(what, where, why, "State the risk without process", "wrong_value")
        elif one.process.in_tolerance is not None and None in limits:
            what = f"requirement {name!r}: in_tolerance needs two limits, it has one"
            yield Problem(what, where, do="Give mean and sd of the process", code="wrong_value")
        else:
            yield from _kinds(one.process, name, limits, where)


def _kinds(process: ProcessEntry, name: str, limits: tuple[str | None, str | None], where: str) -> Iterator[Problem]:
    stated = next((text for text in limits if text is not None), None)
    for key in ("mean", "sd"):
        text = getattr(process, key)
        if text is None:
            if key == "mean" and process.sd is not None and None in limits:
                what = f"requirement {name!r}: process needs its mean where there is one limit"
                yield Problem(what, where, do='Add mean = "NUMBER UNIT", that of the process', code="missing_key")
            continue
        try:
            same = stated is None or same_dimension(parse_quantity(text).unit, parse_quantity(stated).unit)
        except DataError:
            continue  # named elsewhere
        if not same:
            what = f"requirement {name!r}: {key} of the process is {text!r}, its limit {stated!r}"
            yield Problem(what, where, do="Give both in one kind of unit", code="wrong_value")
