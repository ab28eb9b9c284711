"""Changes that do not matter, as a user states them: ``0.1 %``, ``bias=0.01 deg/s``.

A change without a name holds for every figure of its dimension; in percent also for scale factors, relative to
the first value. One with the name of a quantity holds for that quantity alone and goes before; in percent it is
relative to the first value where the quantity has a unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...core.errors import DataError, UsageError
from ...core.results import Row
from ...core.units import Quantity, factor, parse_quantity, same_dimension

RELATIVE = ("scale_factor",)  # quantities whose zero nobody has set, so that percent of them has a meaning


@dataclass(frozen=True)
class Allowed:
    """One statement: a quantity (empty for all), and the largest change that does not matter."""

    quantity: str
    change: Quantity


def parse_allowed(texts: Sequence[str]) -> tuple[Allowed, ...]:
    """Return the statements of ``CHANGE`` or ``QUANTITY=CHANGE``.

    Raises
    ------
    UsageError
        ``allowed``, if one cannot be read, is not above zero, or stands twice.
    """
    found = tuple(_parse(text) for text in texts)
    names = [one.quantity for one in found]
    if len(set(names)) < len(names):
        raise UsageError("two allowed changes for the same quantity", do="Give one", code="allowed")
    return found


def _parse(text: str) -> Allowed:
    name, equals, change = text.rpartition("=")
    try:
        quantity = parse_quantity(change)
    except DataError as error:
        raise UsageError(
            f"allowed change {text!r}: {error.problems[0].what}",
            do='Write it like "0.1 %" or "bias=0.01 deg/s"',
            code="allowed",
        ) from None
    if not quantity.value > 0.0 or (equals and not name.strip()):
        raise UsageError(f"allowed change {text!r}", do="Need a number above zero", code="allowed")
    return Allowed(name.strip(), quantity)


def allowed_for(row: Row, stated: Sequence[Allowed]) -> float | None:
    """Return the change allowed for a figure, in its unit; None where none is stated.

    Raises
    ------
    DataError
        ``unit_mismatch``, if a change stated for this quantity is of another dimension.
    """
    for one in stated:
        if one.quantity == row.quantity:
            return _named(row, one)
    return next((limit for one in stated if not one.quantity and (limit := _general(row, one)) is not None), None)


def is_named(row: Row, stated: Sequence[Allowed]) -> bool:
    """Whether a change is stated for this very quantity."""
    return any(one.quantity == row.quantity for one in stated)


def _named(row: Row, one: Allowed) -> float | None:
    if same_dimension(one.change.unit, row.unit):
        return one.change.value * factor(one.change.unit, row.unit, difference=True)
    if same_dimension(one.change.unit, "1"):
        return _relative(row, one)
    raise DataError(
        f"allowed change of {row.quantity}: {one.change} for a figure in {row.unit!r}",
        do=f"Give it in {row.unit}, or in %",
        code="unit_mismatch",
    )


def _general(row: Row, one: Allowed) -> float | None:
    if same_dimension(one.change.unit, row.unit):
        return one.change.value * factor(one.change.unit, row.unit, difference=True)
    return _relative(row, one) if row.quantity in RELATIVE and same_dimension(one.change.unit, "1") else None


def _relative(row: Row, one: Allowed) -> float | None:
    if not row.value:
        return None
    return abs(row.value) * one.change.value * factor(one.change.unit, "1")
