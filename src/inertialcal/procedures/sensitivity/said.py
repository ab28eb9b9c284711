"""What a plan says of conditions and terms, looked at before any recording: a name that is none would do nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches

from ...core.errors import DataError, PlanError, Problem
from ...core.key import AXES
from ...core.units import parse_quantity
from ..entries import SaidTest
from .plan import HIGHEST_ORDER, SUPPLY, TEMPERATURE, WARM_UP
from .stated import stated_table


def problems(test: SaidTest) -> Iterator[Problem]:
    """Yield references of no condition of the test, stated terms that it has not, and values that are none."""
    to = [to] if isinstance(to := test.plan.get("to", [SUPPLY]), str) else list(to)
    conditions = [name for name in to if name not in (TEMPERATURE, WARM_UP)]
    for name, said in _table(test, "references").items():
        path = test.at("tests", test.number, "plan", "references", name)
        if name == TEMPERATURE:
            what = f"references.{TEMPERATURE}: its reference is reference_temperature"
            yield Problem(what, path, do=f'Write reference_temperature = "{said}"', code="unknown_key")
        elif name not in conditions:
            yield _unknown(f"references.{name}", name, conditions, path)
        else:
            yield from _unreadable(f"references.{name}", str(said), path)
    terms = _terms(to, conditions)
    for name, said in _table(test, "stated").items():
        path = test.at("tests", test.number, "plan", "stated", name)
        if name not in {*terms, *(f"{term}_{axis}" for term in terms for axis in AXES)}:
            yield _unknown(f"stated.{name}", name, terms, path)
            continue
        try:
            table = stated_table(name, said)
        except PlanError as error:
            yield from (Problem(one.what, path, one.why, one.do, one.code) for one in error.problems)
            continue
        for part in ("value", "u"):
            yield from _unreadable(f"stated.{name}.{part}", table[part], path, least=0.0 if part == "u" else None)


def _table(test: SaidTest, name: str) -> Mapping[str, object]:
    given = test.plan.get(name)
    return given if isinstance(given, Mapping) else {}


def _terms(to: list[str], conditions: list[str]) -> list[str]:
    found = ["scale_factor_error"]
    for name in conditions:
        found += [f"bias_{name}", f"bias_{name}_{TEMPERATURE}", f"scale_factor_error_{name}"]
    if TEMPERATURE in to:
        found += [f"bias_{TEMPERATURE}_{j}" for j in range(1, HIGHEST_ORDER + 1)]
        found += [f"scale_factor_error_{TEMPERATURE}_1"]
    return found


def _unknown(what: str, name: str, known: list[str], where: str) -> Problem:
    near = get_close_matches(name, [*known, *(f"{one}_{axis}" for one in known for axis in AXES)], n=1)
    do = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known) or 'none'}"
    return Problem(f"{what}: nothing that the test asks for with 'to'", where, "it would have no effect", do,
                   "unknown_key")  # fmt: skip


def _unreadable(what: str, said: str, where: str, least: float | None = None) -> Iterator[Problem]:
    """Yield a value that is no quantity, or lies below the least."""
    try:
        value = parse_quantity(said).value
    except DataError as error:
        yield from (Problem(f"{what}: {one.what}", where, one.why, one.do, one.code) for one in error.problems)
        return
    if least is not None and value < least:
        yield Problem(f"{what} = {said!r}: should not be below {least:g}", where, code="wrong_value")
