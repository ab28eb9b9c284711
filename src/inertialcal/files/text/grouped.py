"""Grouped digits: whether ``1,242`` is 1242 or 1.242, judged by its column and by the rest of the file.

A number with one comma and three digits behind it can be either. It is a decimal comma where another comma of the file
can be nothing else (``0,5``, ``12,34``, ``1234,567``). It groups digits where the column also has whole numbers without
a comma (``998``). Otherwise nobody can tell, and the file is refused.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.errors import Problem
from ..columns import Column

_HEAD = r"[-+]?[1-9][0-9]{0,2}"
# Text, where numbers have the other decimal sign, or where a sign stands twice: 1,242; 1,242,000; 1.242,5; 1'242
GROUPED = re.compile(rf"{_HEAD}(?:(?:,[0-9]{{3}})+(?:\.[0-9]*)?|(?:\.[0-9]{{3}})+(?:,[0-9]*)?"
                     rf"|(?:[ '_\u2019\u00a0\u202f][0-9]{{3}})+(?:[.,][0-9]*)?)")  # fmt: skip
CERTAIN = {  # by decimal sign
    ",": re.compile(rf"{_HEAD}(?:\.[0-9]{{3}})+,[0-9]+"),
    ".": re.compile(rf"{_HEAD}(?:,[0-9]{{3}})+\.[0-9]+"),
}
WHOLES = {  # the same, or whole
    ",": re.compile(rf"{_HEAD}(?:\.[0-9]{{3}})+(?:,[0-9]+)?"),
    ".": re.compile(rf"{_HEAD}(?:,[0-9]{{3}})+(?:\.[0-9]+)?"),
}
BY_SPACE = {  # French and Swiss: spaces that do not break, and apostrophes, can be nothing else
    sign: re.compile(rf"{_HEAD}(?:[\u00a0\u202f\u2019'][0-9]{{3}})+(?:{re.escape(sign)}[0-9]*)?") for sign in (",", ".")
}
SPACES = str.maketrans("", "", "\u00a0\u202f\u2019'")
EITHER = re.compile(rf"{_HEAD},[0-9]{{3}}")  # 1242 or 1.242
WHOLE = re.compile(r"[-+]?[0-9]{1,3}")
THOUSAND = 1000.0
CODE = "grouped_digits"
SHOWN = 40  # characters of a cell in a message
LONGEST = 100  # characters of a number


@dataclass(frozen=True)
class Commas:
    """What the cells of a column say of their commas."""

    either: int | None = None  # Index of the first cell that can be 1242 or 1.242
    whole: int | None = None  # Index of the first whole number below 1000, without a comma, that is not zero
    decimal: bool = False  # Whether a comma can be nothing else than a decimal one


def commas(cells: Iterable[str]) -> Commas:
    """Return what the cells of a column say of their commas."""
    either = whole = None
    for index, cell in enumerate(cells):
        if "," not in cell:
            if whole is None and WHOLE.fullmatch(cell) and int(cell):
                whole = index
        elif EITHER.fullmatch(cell):
            either = index if either is None else either
        else:
            return Commas(None, None, True)
    return Commas(either, whole)


def grouped_cell(cells: Sequence[str]) -> int | None:
    """Return the index of the first number with grouped digits among cells that are not read as numbers."""
    return next((i for i, cell in enumerate(cells) if GROUPED.fullmatch(cell.strip())), None)


def grouped_column(cells: Iterable[object], number: Callable[[str], object]) -> int | None:
    """Return the first cell with grouped digits where all others are numbers or empty; None elsewhere."""
    first = None
    for index, cell in enumerate(cells):
        text = str(cell).strip()
        if text and (len(text) > LONGEST or not number(text)):
            if len(text) > LONGEST or not GROUPED.fullmatch(text):
                return None
            first = index if first is None else first
    return first


def shows_groups(cells: Iterable[str], decimal: str) -> bool:
    """Whether a cell has both signs (``1.234,5``), so that one of them can only group digits, in the whole file."""
    sign = "." if decimal == "," else ","
    return any(sign in cell and len(cell) < LONGEST and CERTAIN[decimal].fullmatch(cell.strip()) for cell in cells)


def without_groups(
    cells: Sequence[str], decimal: str, number: Callable[[str], object], sure: bool = False
) -> Sequence[str]:
    """Return the cells of a column without the signs that group their digits, where they can be nothing else.

    So it is where both signs stand in a cell (``1.234,5``), or an apostrophe or a space that does not break, and all
    others are numbers without groups, or empty. ``sure``: where another column of the file has such a cell, or where
    the column is in counts, whole numbers are grouped as well (``1.000``).
    """
    certain, found, made = (WHOLES if sure else CERTAIN)[decimal], False, list[str]()
    sign = "." if decimal == "," else ","
    for cell in cells:
        text = cell.strip()
        grouped = sign in text and len(text) < LONGEST and certain.fullmatch(text) is not None
        if not grouped and text and len(text) < LONGEST and BY_SPACE[decimal].fullmatch(text):
            text, found = text.translate(SPACES), True
        if text and not grouped and (len(text) > LONGEST or not number(text)):
            return cells
        found = found or grouped
        made.append(text.replace(sign, "") if grouped else text)
    return made if found else cells


def grouped_row(parts: Sequence[str]) -> str:
    """Return the first number that the commas of a row may have cut at its groups; empty where there is none."""
    pairs = (f"{a.strip()},{b.strip()}" for a, b in pairwise(parts))
    return next((pair for pair in pairs if EITHER.fullmatch(pair)), "")


def can_be_either(column: Column) -> bool:
    """Whether all values of a column read with decimal commas could be whole numbers with grouped digits."""
    values = column.values
    if values.dtype.kind != "f":
        return False
    values = np.abs(values[np.isfinite(values)])
    below = values[values < 1.0]
    if below.any() or not np.any(values != np.rint(values)) or values.max() >= THOUSAND:
        return False
    thousands = values * THOUSAND
    return bool(np.all(np.abs(thousands - np.rint(thousands)) < 1e-6 * THOUSAND))


def problem(name: str, cell: str, where: str, whole: str | None = None, certain: bool = False) -> Problem:
    """Return the problem of a cell with grouped digits.

    Parameters
    ----------
    name, cell, where : str
        Column, the cell, its file and row.
    whole : str, optional
        Whole number of the column that has no comma.
    certain : bool
        Whether the comma can be no decimal sign; else it can be either.
    """
    cell = cell.strip()
    shown = cell if len(cell) <= SHOWN else cell[:SHOWN] + "..."
    if certain or whole is not None:
        why = "" if whole is None else f"the column also has {whole!r}: the comma groups digits"
        what = f"grouped digits {shown!r} in number column {name!r}"
        do = "Write the numbers without grouping: 1242 or 1242.5"
        if whole is not None:
            do += ". If the comma is the decimal sign all the same: inertialcal convert FILE NEW.csv --decimal comma"
        return Problem(what, where, why, do, CODE)
    what = f"{shown!r} in number column {name!r} is {cell.replace(',', '')} or {cell.replace(',', '.')}"
    why = "nothing in the file says whether the comma groups digits or is the decimal sign"
    do = "If it is the decimal sign: inertialcal convert FILE NEW.csv --decimal comma. "
    do += "Otherwise write the numbers without grouping"
    return Problem(what, where, why, do, CODE)
