"""Cells of text: which are numbers, empty, a spelled-out NaN, or text; the exact rule for a column.

A column is numbers if it holds no more text than numbers; that text is then an error, which the caller
places. A column with more text than numbers is text. Whole numbers stay whole (int64) as long
as every cell is one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..columns import Rows

Decimal = Literal[".", ","]

_NAN = (
    r"(?P<nan>[-+]?(?:nan(?:\(\w*\))?|inf(?:inity)?|1[.,]\#(?:ind|qnan|snan|inf)\w*)"
    r"|n/?a|\#n/a|null|none)"
)
_CELL = r"(?P<integer>-?[0-9]+)|(?P<number>[-+]?(?:[0-9]+(?:{0}[0-9]*)?|{0}[0-9]+)(?:[ed][-+]?[0-9]+)?)|" + _NAN
CELL = {point: re.compile(_CELL.replace("{0}", re.escape(point)), re.IGNORECASE | re.ASCII) for point in (".", ",")}
KINDS = {"integer": "i", "number": "f", "nan": "n"}  # by the group that matched
BLANKS = " \t"
INT64_DIGITS = 18  # whole numbers of so many digits fit int64 for certain


@dataclass(frozen=True, eq=False)
class Cells:
    """One column, judged."""

    values: NDArray[Any]  # shape (n,): int64 or float64 (NaN where there is no number), or objects of type str
    empty: Rows  # Index of the cells of each kind; ``text`` only where the column is numbers
    not_a_number: Rows  # Index of the cells of each kind; ``text`` only where the column is numbers
    text: Rows  # Index of the cells of each kind; ``text`` only where the column is numbers


def judge(cells: Sequence[str], decimal: Decimal = ".") -> Cells:
    """Return a column as numbers or text, by the rule of the module head.

    Parameters
    ----------
    cells : sequence of str
        As they stand in the file, without quotes.
    decimal : {".", ","}
        Decimal sign.
    """
    stripped = [cell.strip(BLANKS) for cell in cells]
    match = CELL[decimal].fullmatch
    groups = [m.lastgroup if m else "" for m in map(match, stripped)]
    kinds = np.array([KINDS[g] if g else "t" if c else "e" for g, c in zip(groups, stripped, strict=True)], "U1")
    numbers, text = np.isin(kinds, ["i", "f"]), kinds == "t"
    none = np.empty(0, dtype=np.int64)
    empty, nan = np.flatnonzero(kinds == "e"), np.flatnonzero(kinds == "n")
    if text.sum() > numbers.sum():
        return Cells(np.array(stripped, dtype=object), empty, none, none)
    if stripped and np.all(kinds == "i") and max(map(len, stripped)) <= INT64_DIGITS:
        return Cells(np.array(stripped, dtype="S18").astype(np.int64), empty, nan, none)
    values = np.full(len(stripped), np.nan)
    at = np.flatnonzero(numbers)
    values[at] = list(map(float, _plain(" ".join([stripped[i] for i in at]), decimal).split()))
    bad = text | np.isinf(values)  # beyond the range of float64 is no number that can be used
    values[np.isinf(values)] = np.nan
    return Cells(_whole(values, stripped, kinds), empty, nan, np.flatnonzero(bad))


def kind(cell: str, decimal: Decimal = ".") -> str:
    """``i`` whole number, ``f`` number, ``e`` empty, ``n`` NaN, NA or infinity, ``t`` text."""
    match = CELL[decimal].fullmatch(cell)
    return KINDS[match.lastgroup or ""] if match else "t" if cell else "e"


def to_float(cell: str, decimal: Decimal = ".") -> float:
    """Return the number in a cell of kind ``i`` or ``f``; infinite where it is out of range."""
    return float(_plain(cell, decimal))


def _plain(text: str, decimal: Decimal) -> str:
    """Spelling that Python takes: point, and Fortran's exponent as e."""
    return text.lower().replace("d", "e").replace(decimal, ".")


def _whole(values: NDArray[np.float64], stripped: list[str], kinds: NDArray[Any]) -> NDArray[Any]:
    """As int64 where every cell is a whole number that fits."""
    if not len(kinds) or not np.all(kinds == "i"):
        return values
    try:
        return np.array([int(cell) for cell in stripped], dtype=np.int64)
    except (OverflowError, ValueError):  # ValueError: more digits than int() takes
        return values
