"""Sentences about rows, as a report sets them: words, names as the user wrote them, and numbers cited from a row.

A sentence makes no number of its own: it cites rows, so that a report can say where in the results each stands. Rows
are mappings as ``results.json`` holds them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from ..results import WrittenRow, case_of

R = TypeVar("R", bound=WrittenRow)


class Quoted(str):
    """A name or text of the user's: a report sets it apart, so that it cannot change what stands around it."""

    __slots__ = ()


@dataclass(frozen=True, eq=False)
class Cited:
    """The value of a row."""

    row: WrittenRow  # Of ``results.json``
    u: bool = True  # Whether its uncertainty stands with it; without, it has few digits
    unit: bool = True  # Whether its unit stands with it


Sentence = tuple[str | Cited, ...]

BIASES = ("bias", "residual_bias")
ERROR = "scale_factor_error"


def estimated(rows: Iterable[R], quantity: str, any_case: bool = False) -> list[R]:
    """Return the estimated rows of a quantity: the results, or also those of every part, place and method."""
    return [
        row
        for row in rows
        if row["quantity"] == quantity
        and row["status"] == "estimated"
        and row["value"] is not None
        and (any_case or case_of(row).plain)
    ]


def largest(rows: Sequence[R]) -> R | None:
    """Return the row with the largest absolute value; the first of equals."""
    return max(rows, key=lambda row: abs(float(row["value"])), default=None)


def largest_of(quantities: Sequence[str], rows: Sequence[WrittenRow]) -> Sentence:
    """Say the largest value of some quantities, and on which axis; nothing where none was estimated."""
    row = largest([row for quantity in quantities for row in estimated(rows, quantity)])
    return () if row is None else ("Largest ", row["quantity"].replace("_", " "), " ", Cited(row), ", on ",
                                   Quoted(row["axis"]))  # fmt: skip


def error_sentence(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the scale factor error, the largest of several axes; the largest bias where there is none."""
    errors = [row for row in rows if row["quantity"] == ERROR]
    if not errors and (said := largest_of(BIASES, rows)):
        return said
    found = largest(estimated(errors, ERROR)) or largest([row for row in errors if row["value"] is not None])
    if found is None:
        return ("No scale factor error could be estimated",)
    if len({row["axis"] for row in errors}) > 1:
        return ("Largest scale factor error ", Cited(found), ", on ", Quoted(found["axis"]))
    return ("Scale factor error of ", Quoted(found["axis"]), " ", Cited(found))
