"""Figures beside the result: other ways of reducing the same readings, and single flips, a column each.

Rows are mappings as ``results.json`` holds them, those of one test. The result comes first; what stands beside it is
shown as long as there is room, else counted. A figure beside the result may lack its uncertainty and still be shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ..key import WAYS, Case, Method, case_of
from .sentence import R, WrittenRow

MOST = 5  # columns beside the result
ALL, TEXTBOOK = Case(Method.ALL_READINGS), Case(Method.TEXTBOOK)
Key = tuple[str, str, str, str]  # quantity, condition of its own, axis, unit


def lines_of(rows: Iterable[R]) -> dict[Key, dict[str, R]]:
    """Return what is shown, a line a figure: its rows by the condition that they stand beside under, "" the result."""
    every = list(rows)
    results = [row for row in every if not case_of(row["condition"]).beside]
    open_ones = {_figure(row) for row in results if _is_open(row)}
    whole = _of_the_test([str(row["condition"]) for row in results])
    found: dict[Key, dict[str, R]] = {}
    for row in every:
        if _is_shown(row, open_ones):
            way = row["condition"] if case_of(row["condition"]).beside else ""
            own = whole if way else row["condition"]
            found.setdefault((row["quantity"], own, row["axis"], row["unit"]), {})[way] = row
    return found


def _of_the_test(conditions: Sequence[str]) -> str:
    """Return the condition of the whole test, which its rows have where they have none of their own; "" is none."""
    if not conditions or "" in conditions:
        return ""
    return max(conditions, key=conditions.count)


def columns_of(lines: Mapping[Key, Mapping[str, WrittenRow]]) -> tuple[list[str], list[str]]:
    """Return which conditions have a column beside the result, and for which there is no room."""
    there = list(dict.fromkeys(way for ways in lines.values() for way in ways if way))
    shown: list[str] = [way for way in WAYS if way in there]
    parts = [way for way in there if way not in shown]
    left: list[str] = []
    for method in (Method.RESULT, Method.TEXTBOOK):
        group = [way for way in parts if case_of(way).method is method]
        fits = len(shown) + len(group) <= MOST
        shown, left = (shown + group, left) if fits else (shown, left + group)
    return shown, left


def missing_of(rows: Iterable[R]) -> dict[str, list[R]]:
    """Return by their reason the rows of the result that the data could not carry; of those beside it what is new."""
    every = list(rows)
    shown = {id(row) for ways in lines_of(every).values() for row in ways.values()}
    known = {(*_figure(row), row["reason"]) for row in every if not case_of(row["condition"]).beside}
    found: dict[str, list[R]] = {}
    for row in every:
        case = case_of(row["condition"])
        again = case.beside and case != TEXTBOOK and (*_figure(row), row["reason"]) in known
        if _is_open(row) and case != ALL and not again and id(row) not in shown:
            found.setdefault(row["reason"], []).append(row)
    return found


def names_of(conditions: Sequence[str]) -> str:
    """Return conditions as words, the first and the last of many."""
    if len(conditions) <= MOST:
        return "; ".join(conditions)
    return "; ".join([*conditions[:2], "...", conditions[-1]])


def _is_open(row: WrittenRow) -> bool:
    return bool(row["status"] == "not_estimated")


def _is_shown(row: WrittenRow, open_ones: set[tuple[str, str]]) -> bool:
    if not _is_open(row):
        return True
    told = row["value"] is not None and case_of(row["condition"]).beside
    return told and not (case_of(row["condition"]) == ALL and _figure(row) in open_ones)


def _figure(row: WrittenRow) -> tuple[str, str]:
    return row["quantity"], row["axis"]
