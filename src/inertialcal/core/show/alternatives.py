"""Figures beside the result: other ways of reducing the same readings, and single flips, a column each.

Rows are mappings as ``results.json`` holds them, those of one test. The result comes first; what stands beside it is
shown as long as there is room, else counted. A figure beside the result may lack its uncertainty and still be shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..key import PLAIN, WAYS, Case, Method
from ..results import WrittenRow, case_of, key_of
from .names import reason_text
from .sentence import R

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
            way = case._replace(condition="") if case.beside else PLAIN
            own = case.condition if case.beside else str(case)
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
        if _is_open(row) and case != ALL and not again and id(row) not in shown:
            found.setdefault(reason, []).append(row)
    return found


def names_of(cases: Iterable[Case]) -> str:
    """Return the names of cases, the first and the last of many."""
    names = list(dict.fromkeys(str(case) for case in cases))
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
