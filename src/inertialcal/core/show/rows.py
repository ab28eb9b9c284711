"""Rows of ``results.json`` for people: their names, sentences that cite them, and which stand in which table.

Rows are mappings as ``results.json`` holds them. Programs read the fields, never the names made here.

Sentences make no number: they cite rows, so that a report can say where in the results each stands.

Alternatives: other ways of reducing the same readings, and single flips, a column each. The result comes first; the
others are shown as long as there is room, else counted. They may lack their uncertainty and still be shown.

Two tests side by side: an axis a line, both errors and their difference. A procedure declares as `Compared` which error
of its tests can stand next to that of another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from ..key import CHANGES, PLAIN, WAYS, Case, Method
from ..results import WrittenRow, case_of, key_of
from .wording import VERDICTS, words

R = TypeVar("R", bound=WrittenRow)
MOST = 5  # columns beside the result
ALL, TEXTBOOK = Case(Method.ALL_READINGS), Case(Method.TEXTBOOK)
Line = tuple[str, str, str, str]  # quantity, its case, axis, unit


def lines_of(rows: Iterable[R]) -> dict[Line, dict[Case, R]]:
    """Return a line a figure: its rows by case, `PLAIN` the result, others the alternatives to it."""
    every = list(rows)
    cases = [case_of(row) for row in every]
    open_ones = {_figure(row) for row, case in zip(every, cases, strict=True) if not case.beside and _is_open(row)}
    found: dict[Line, dict[Case, R]] = {}
    for row, case in zip(every, cases, strict=True):
        if _is_shown(row, case, open_ones):
            way = case._replace(condition="", sensor="") if case.beside else PLAIN
            own = (case.sensor or case.condition) if case.beside else str(case)
            found.setdefault((key_of(row).name, own, str(row["axis"]), str(row["unit"])), {})[way] = row
    return found


def columns_of(lines: Mapping[Line, Mapping[Case, WrittenRow]]) -> tuple[list[Case], list[Case]]:
    """Return the alternatives that have a column beside the result, and those for which there is no room."""
    there = list(dict.fromkeys(way for ways in lines.values() for way in ways if way != PLAIN))
    shown = [way for method in WAYS if (way := Case(method)) in there]
    parts = [way for way in there if way not in shown]
    left: list[Case] = []
    for method in (Method.RESULT, Method.TEXTBOOK):
        group = [way for way in parts if way.method is method]
        fits = len(shown) + len(group) <= MOST
        shown, left = (shown + group, left) if fits else (shown, left + group)
    return shown, left


def missing_of(rows: Iterable[R]) -> dict[str, list[R]]:
    """Return by their reason the rows of the result that the data could not carry; of those beside it what is new."""
    every = list(rows)
    shown = {id(row) for ways in lines_of(every).values() for row in ways.values()}
    known = {(*_figure(row), reason_text(row)) for row in every if not case_of(row).beside}
    found: dict[str, list[R]] = {}
    for row in every:
        case, reason = case_of(row)._replace(condition=""), reason_text(row)
        again = case.beside and case != TEXTBOOK and (*_figure(row), reason) in known
        opened = case.method is Method.UNSCREENED
        if _is_open(row) and case != ALL and not opened and not again and id(row) not in shown:
            found.setdefault(reason, []).append(row)
    return found


def case_words(case: Case) -> str:
    """Return the case in words, for the head of a column."""
    if case.method is not Method.TEXTBOOK:
        return str(case).replace("_", " ")
    rest = str(case._replace(method=Method.RESULT, sensor="", condition=""))
    return f"textbook formula, {rest}" if rest else "textbook formula"


def names_of(cases: Iterable[Case]) -> str:
    """Return the names of cases, the first and the last of many."""
    names = list(dict.fromkeys(case_words(case) for case in cases))
    if len(names) <= MOST:
        return "; ".join(names)
    return "; ".join([*names[:2], "...", names[-1]])


def _is_open(row: WrittenRow) -> bool:
    return bool(row["status"] == "not_estimated")


def _is_shown(row: WrittenRow, case: Case, open_ones: set[tuple[str, str]]) -> bool:
    if not _is_open(row):
        return True
    has_value = row["value"] is not None and case.beside
    return has_value and not (case.method is Method.ALL_READINGS and _figure(row) in open_ones)


def _figure(row: WrittenRow) -> tuple[str, str]:
    return key_of(row).name, row["axis"]


def quantity_name(row: WrittenRow) -> str:
    """Return the quantity with its power: ``"bias_temperature_2"``."""
    return key_of(row).name


def case_name(row: WrittenRow) -> str:
    """Return the method, part, place, sensor or condition of a row: ``"-20 degC"``, ``"flip 3"``; else nothing."""
    return str(case_of(row))


def full_name(row: WrittenRow) -> str:
    """Return the quantity, with its case in brackets: ``"bias (-20 degC)"``."""
    case = case_name(row)
    return f"{quantity_name(row)} ({case})" if case else quantity_name(row)


def reason_text(row: WrittenRow) -> str:
    """Return the reason of a row; empty where it has none."""
    return "" if row["reason"] is None else str(row["reason"]["text"])


def reason_code(row: WrittenRow) -> str:
    """Return the code of the reason of a row; empty where it has none."""
    return "" if row["reason"] is None else str(row["reason"]["code"])


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


@dataclass(frozen=True)
class Compared:
    """An error that stands beside that of another test: its quantities, and what its tables are called."""

    error: str  # Quantity: error of the test
    other: str  # Quantity: error of the other test
    change: str  # Quantity: this error less the other
    reduction: str  # Quantity: how much nearer to zero this one is
    title: str  # Of a table for a terminal
    caption: str  # Of a table for a report

    @property
    def roles(self) -> dict[str, str]:
        """What each quantity is: ``error``, ``other``, ``change`` or ``reduction``."""
        return {self.error: "error", self.other: "other", self.change: "change", self.reduction: "reduction"}


def pairs_of(rows: Iterable[R], compared: Compared | None) -> dict[tuple[str, str], dict[str, R]]:
    """Return by axis and part of the readings ("": all of them) the rows of both errors and of their difference.

    Each by its role: ``error``, ``other``, ``change``, ``reduction``. Axes that have no change are left out: there is
    nothing to set side by side.
    """
    roles = {} if compared is None else compared.roles
    every = [(roles[row["quantity"]], row) for row in rows if row["quantity"] in roles and _stands_there(row)]
    axes = {str(row["axis"]) for role, row in every if role == "change" and row["value"] is not None}
    found: dict[tuple[str, str], dict[str, R]] = {}
    for axis in sorted(axes):
        for role, row in every:
            if row["axis"] == axis:
                way = str(case) if (case := case_of(row)).beside else ""
                found.setdefault((axis, way), {})[role] = row
    return {key: pair for key, pair in found.items() if "change" in pair}


def own_rows(rows: Iterable[R], compared: Compared | None) -> list[R]:
    """Return the rows without those that stand in the table of both tests side by side, or in that of changes."""
    every = [row for row in rows if case_of(row).method not in CHANGES]
    if compared is None or not pairs_of(every, compared):
        return every
    return [row for row in every if row["quantity"] not in (compared.other, compared.change, compared.reduction)]


def verdict_of(pair: Mapping[str, WrittenRow]) -> str:
    """Return ``nearer`` or ``farther``: from zero than the other, by its interval; else ``not shown``."""
    row = pair.get("reduction")
    interval = None if row is None else row["interval"]
    if interval is None:
        return "not shown"
    lo, hi = (None if interval[end] is None else float(interval[end]) for end in ("lo", "hi"))
    return "nearer" if lo is not None and lo > 0.0 else "farther" if hi is not None and hi < 0.0 else "not shown"


def _stands_there(row: WrittenRow) -> bool:
    case = case_of(row)
    return not case.beside or (case.member is not None and case.method is Method.RESULT)


@dataclass(frozen=True, eq=False)
class Changed(Generic[R]):
    """What a figure changed by since another test: the figure in both, the change or ratio, what is allowed."""

    before: R | None
    after: R | None
    change: R
    lower: float | None  # Allowed, in the unit of the change; None where no requirement is about it
    upper: float | None
    verdict: str  # The worst; empty where no requirement is about it

    @property
    def name(self) -> str:
        """The quantity in words, with the place that it is of."""
        at = case_of(self.change).at
        name = words(quantity_name(self.change))
        return name if at is None else f"{name} ({at.what} {at})"

    @property
    def is_ratio(self) -> bool:
        """Whether it is told as the later figure over the earlier one."""
        return case_of(self.change).method is Method.RATIO

    @property
    def part(self) -> float | None:
        """Share of what is allowed that the change makes up, signed; None where nothing is allowed, or not known."""
        if self.upper is None or self.lower is None or self.change["value"] is None or not self.upper > self.lower:
            return None
        return 2.0 * (float(self.change["value"]) - 0.5 * (self.lower + self.upper)) / (self.upper - self.lower)


def changed(rows: Iterable[R], verdicts: Iterable[R], test: str, other: str) -> list[Changed[R]]:
    """Return the changes of a test since another one, estimated ones alone.

    Parameters
    ----------
    rows, verdicts : iterable of rows
        Of ``results.json``.
    test, other : str
        Names of both tests.
    """
    every = list(rows)
    plain = {(row["test"], key_of(row)): row for row in every if case_of(row)._replace(at=None).plain}
    judged = [one for one in verdicts if one["test"] == test and one["of"] == "change"]
    found = []
    for row in every:
        if row["test"] != test or case_of(row).method not in CHANGES or row["status"] == "not_estimated":
            continue
        own = key_of(row).name, row["axis"], row["sensor"]
        mine = [one for one in judged if (one["quantity"], one["axis"], one["sensor"]) == own]
        worst = min(mine, key=lambda one: VERDICTS.index(one["verdict"]), default=None)
        scale = _percent(row, worst)
        lower, upper = (None if worst is None or worst[end] is None else float(worst[end]) * scale
                        for end in ("lower", "upper"))  # fmt: skip
        key = key_of(row)
        word = "" if worst is None else str(worst["verdict"])
        found.append(Changed(plain.get((other, key)), plain.get((test, key)), row, lower, upper, word))
    return found


def _percent(row: WrittenRow, verdict: WrittenRow | None) -> float:
    """Return what limits of a verdict in percent are times the unit of its row."""
    return 0.01 if verdict is not None and verdict["unit"] == "%" and row["unit"] == "1" else 1.0
