"""Requirements against the tests of a campaign: quantities, the units of their limits, conditions."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches

from ...core.errors import DataError, Problem
from ...core.judging import parse_condition
from ...core.schema.toml import At
from ...core.units import kind, normalise, parse_quantity, same_dimension
from ...procedures import all_quantities
from ...procedures.protocol import Quantity
from .schema import CampaignFile, Requirement


def requirement_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find requirements on tests, quantities, limits or conditions that cannot be judged."""
    ids = {test.id for test in file.tests}
    for number, one in enumerate(file.requirements):
        for name in one.tests or []:
            if name not in ids:
                do = f"There are: {', '.join(sorted(ids))}"
                what = f"requirement {one.id!r}: no test {name!r}"
                yield Problem(what, at("requirements", number, "tests"), do=do, code="unknown_name")
        for key in ("limit", "lower", "upper"):
            text = getattr(one, key)
            if text is not None:
                yield from _limit(one, text, at("requirements", number, key))
        yield from _spelling(one, at("requirements", number, "quantity"))
        yield from _where(one, at("requirements", number, "where"))


def _where(one: Requirement, where: str) -> Iterator[Problem]:
    """Find a condition that cannot be read, or that is about something else than the quantity is told over."""
    try:
        condition = parse_condition(one.where)
    except DataError as error:
        what = f"requirement {one.id!r}: {error.problems[0].what}"
        yield Problem(what, where, do=error.problems[0].do, code="wrong_value")
        return
    over = _known(one).over
    others = {part.name for every in condition.alternatives for part in every} - {over}
    if over and others:
        what = f"requirement {one.id!r}: where names {' and '.join(sorted(others))}, {one.quantity} is over {over}"
        yield Problem(what, where, "it would have no effect", f"Write it in terms of {over}", "wrong_value")


def _limit(one: Requirement, text: str, where: str) -> Iterator[Problem]:
    try:
        unit = normalise(parse_quantity(text).unit)
    except DataError as error:
        yield Problem(f"requirement {one.id!r}: {error.problems[0].what}", where, code="wrong_value")
        return
    if text == one.limit and parse_quantity(text).value <= 0.0:
        what = f"requirement {one.id!r}: limit = {text!r} is the size of both limits, it must be above zero"
        yield Problem(what, where, do="For one side give lower or upper", code="wrong_value")
    what = f"requirement {one.id!r}: {one.quantity} cannot be compared with {text!r}"
    needed, shown = _known(one).kinds, _known(one).shown_by_kind.values()
    if needed and kind(unit) not in needed:
        yield Problem(what, where, do=f"Give a limit of kind {' or '.join(needed)}", code="wrong_value")
    if shown and not any(same_dimension(unit, other) for other in shown):
        yield Problem(what, where, do=f"Give a limit in {' or '.join(shown)}", code="wrong_value")


def _spelling(one: Requirement, where: str) -> Iterator[Problem]:
    """Tell a misspelt quantity from one that no test here gives (which is OPEN)."""
    known = all_quantities()
    near = get_close_matches(one.quantity, known, n=1, cutoff=0.8)
    if one.quantity not in known and near:
        what = f"requirement {one.id!r}: no quantity {one.quantity!r}"
        yield Problem(what, where, "it would stay OPEN for ever", f"Did you mean {near[0]}?", "unknown_name")
    if one.where and not _known(one).over:
        ranged = [name for name, quantity in known.items() if quantity.over]
        what = f"requirement {one.id!r}: where is about {' or '.join(ranged)}, not {one.quantity}"
        yield Problem(what, where, "it would have no effect", code="wrong_value")


def _known(one: Requirement) -> Quantity:
    return all_quantities().get(one.quantity, Quantity())
