"""Layout of a text file: comment lines, header, separator, decimal sign, where the numbers start.

Judged from the first 200 lines that hold something. Candidates for separator and decimal sign are scored by
the share of lines of equal width times the share of cells that are numbers; at a tie the first in
``CANDIDATES`` wins. The header is the first of these lines if no cell of it is a number and it is as wide as
the rows; failing that the last comment line, if it is. Lines before a header that are neither (an export's
preamble) are left out and counted.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from ..core import units
from ..core.errors import DataError, InertialcalError
from ..core.remarks import Remark
from .cells import BLANKS, Decimal, kind

SAMPLE = 200  # lines
ACROSS = 16  # numbers in a lone line from which it is a series
CANDIDATES: tuple[tuple[str | None, Decimal], ...] = (
    (",", "."),
    ("\t", "."),
    (";", "."),
    (";", ","),
    ("\t", ","),
    (None, "."),
    (None, ","),
)
WORDS = {",": "comma-separated", "\t": "tab-separated", ";": "semicolon-separated", None: "blank-separated"}
COMMENT = ("#", "%", "//")
SEMICOLON_COMMENT = (*COMMENT, ";")
SAMPLE_RATE = re.compile(
    r"\b(?:fs|(?:sampl(?:e|ing)|data)[ _-]*(?:rate|frequency|freq))\b[^0-9=:]{0,12}[=:]?\s*"
    r"([0-9]+(?:\.[0-9]*)?(?:e[-+]?[0-9]+)?)\s*(k?hz|sps|/s)?",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Line:
    """A line that holds something: row in the file from 1, offset of its first character, text."""

    row: int
    offset: int
    text: str


@dataclass(frozen=True)
class Layout:
    """How a text file is laid out.

    Parameters
    ----------
    separator : str or None
        None for blanks.
    decimal : {".", ","}
        Decimal sign.
    width : int
        Cells in a row.
    names, units : tuple of str
        One a column; empty text where there is none.
    start, row : int
        Offset of the first character of the first data row, and its row in the file.
    comment : tuple of str
        Starts of a comment line.
    across : bool
        Whether the only line is a series of numbers.
    sample_rate : float or None
        As comments say it [Hz].
    remarks : tuple of Remark
        What was unusual.
    """

    separator: str | None
    decimal: Decimal
    width: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    start: int
    row: int
    comment: tuple[str, ...]
    across: bool = False
    sample_rate: float | None = None
    remarks: tuple[Remark, ...] = ()

    @property
    def words(self) -> str:
        """The layout in words."""
        sign = ", decimal comma" if self.decimal == "," else ""
        return f"text, {WORDS[self.separator] if self.width > 1 else 'one column'}{sign}"


def sniff(text: str, where: str) -> Layout:
    r"""Return the layout of a text with ``\n`` line ends.

    Raises
    ------
    DataError
        If it holds no row, or the header is not as wide as the rows.
    """
    layout = _sniff(text, where, SEMICOLON_COMMENT)
    return _sniff(text, where, COMMENT) if layout.separator == ";" else layout


def split(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line, without quotes and outer blanks."""
    if '"' in line:
        line = line.strip(BLANKS) if separator is None else line
        parts = next(csv.reader([line], delimiter=separator or " ", skipinitialspace=True), [])
    elif separator is None:
        parts = re.split(r"[ \t]+", line.strip(BLANKS))
    else:
        parts = line.split(separator)
    return [part.strip(BLANKS) for part in parts]


def is_blank(line: str, separator: str | None) -> bool:
    """Whether a line holds nothing, not even empty cells."""
    return not line.strip(BLANKS if separator != "\t" else " ")


def _lines(text: str) -> Iterator[Line]:
    """Each line, with its row and offset."""
    row, offset = 1, 0
    while offset < len(text):
        end = text.find("\n", offset)
        end = len(text) if end < 0 else end
        yield Line(row, offset, text[offset:end])
        row, offset = row + 1, end + 1


def _sniff(text: str, where: str, comment: tuple[str, ...]) -> Layout:
    comments, lines = _head(text, comment)
    if not lines:
        raise DataError("holds no row of data", where=where, do="Record again", code="empty_file")
    separator, decimal = _separator(lines)
    width = _width(lines, separator)
    header, first = _first_data(lines, separator, decimal, width)
    notes = [line.text for line in lines[: first if header is None else header]]
    remarks = _preamble_remark(notes, lines, where)
    names, from_comment = _names(lines, header, comments, separator, width, where)
    units_row = _units(lines, first, header, separator, decimal)
    if units_row:
        first += 1
    if first >= len(lines):
        raise DataError("holds a header and no row of data", where=where, code="empty_file")
    start = lines[first]
    return Layout(
        separator=separator,
        decimal=_decimal(text, start, separator, decimal),
        width=width,
        names=names,
        units=units_row or ("",) * width,
        start=start.offset,
        row=start.row,
        comment=comment,
        across=len(lines) == 1 and header is None and width >= ACROSS,
        sample_rate=_sample_rate(comments + notes),
        remarks=remarks + from_comment,
    )


def _head(text: str, comment: tuple[str, ...]) -> tuple[list[str], list[Line]]:
    """Comment lines before the first line that holds something, and the first of these lines."""
    comments: list[str] = []
    lines: list[Line] = []
    for line in _lines(text):
        stripped = line.text.strip()
        if stripped.startswith(comment):
            if not lines:
                comments.append(stripped)
        elif stripped:
            lines.append(line)
        if len(lines) == SAMPLE:
            break
    return comments, lines


def _separator(lines: list[Line]) -> tuple[str | None, Decimal]:
    """Separator and decimal sign with the best score."""
    scored = [(_score(lines, separator, decimal), -i) for i, (separator, decimal) in enumerate(CANDIDATES)]
    return CANDIDATES[-max(scored)[1]]


def _score(lines: list[Line], separator: str | None, decimal: Decimal) -> tuple[float, bool, float]:
    """Share of alike lines times share of numbers; more than one column; share of alike lines."""
    width = _width(lines, separator)
    alike = [line for line in lines if len(split(line.text, separator)) == width]
    share = len(alike) / len(lines)
    # The first line may be a header, which must fit in width but holds no number.
    rows = [line for line in alike if line is not lines[0]] or alike
    kinds = Counter(kind(cell, decimal) for line in rows for cell in split(line.text, separator))
    filled = kinds.total() - kinds["e"]
    numbers = (kinds.total() - kinds["e"] - kinds["t"]) / filled if filled else 0.0
    return round(share * numbers, 6), width > 1, share


def _width(lines: list[Line], separator: str | None) -> int:
    """Most frequent number of cells in the later half, where data is."""
    counts = Counter(len(split(line.text, separator)) for line in lines[len(lines) // 2 :])
    return max(counts, key=lambda width: (counts[width], width))


def _first_data(lines: list[Line], separator: str | None, decimal: Decimal, width: int) -> tuple[int | None, int]:
    """Index of the header, if there is one, and of the first row of data."""
    for i, line in enumerate(lines):
        cells = split(line.text, separator)
        kinds = [kind(cell, decimal) for cell in cells]
        is_words = not any(k in "ifn" for k in kinds)
        if is_words and _fits(cells, width):
            return i, i + 1
        if not is_words and (i == 0 or kinds[0] in "ifn" or len(cells) == width):
            return None, i
    return 0, 1  # words only, and no line as wide as most: the first is the header, and does not fit


def _fits(cells: list[str], width: int) -> bool:
    """Whether a header names the columns of a row; an empty end on either side does not count."""
    while cells and not cells[-1] and len(cells) > width:
        cells = cells[:-1]
    return len(cells) in (width, width - 1) and (len(cells) == width or width > 1)


def _names(
    lines: list[Line],
    header: int | None,
    comments: list[str],
    separator: str | None,
    width: int,
    where: str,
) -> tuple[tuple[str, ...], tuple[Remark, ...]]:
    """Names of the columns, from the header or the last comment."""
    if header is not None:
        names = split(lines[header].text, separator)[:width]
        rows = lines[header + 1 :]
        short = len(names) < width and any(split(row.text, separator)[-1] for row in rows)
        if short or not _fits(names, width):
            raise _header_width(len(names), width, f"{where}:{lines[header].row}")
        return tuple(names + [""] * (width - len(names))), ()
    names = _comment_names(comments[-1], separator, width) if comments else []
    if not names:
        return ("",) * width, ()
    said = f"columns named by the last comment: {', '.join(names)}"
    return tuple(names), (Remark("header_from_comment", "info", said, where=where),)


def _header_width(names: int, width: int, where: str) -> DataError:
    return DataError(
        f"the header names {names} column(s), the rows have {width}",
        where=where,
        why="which number belongs to which name is not known",
        do="Give each column one name, separated as the numbers are",
        code="ragged_row",
    )


def _comment_names(comment: str, separator: str | None, width: int) -> list[str]:
    """Cells of a comment line, if they can name the columns."""
    text = comment.lstrip("#%/; \t")
    for cells in (split(text, separator), re.split(r"\s{2,}|\t", text)):
        cells = [cell.strip() for cell in cells]
        if len(cells) == width and all(kind(cell) == "t" for cell in cells) and len(set(cells)) == width:
            # One column: a sentence is no name.
            return cells if width > 1 or len(text.split()) == 1 else []
    return []


def _units(
    lines: list[Line], first: int, header: int | None, separator: str | None, decimal: Decimal
) -> tuple[str, ...]:
    """Units row below a header: every cell is a unit or empty, at least one is a unit."""
    if header is None or first + 1 >= len(lines):
        return ()
    cells = split(lines[first].text, separator)
    names = split(lines[header].text, separator)
    given = [cell.strip("[]() ") for cell in cells]
    if len(cells) != len(names) or any(kind(cell, decimal) in "ifn" for cell in cells):
        return ()
    known = [_is_unit(unit) for unit in given if unit]
    return tuple(given) if known and all(known) else ()


def _is_unit(text: str) -> bool:
    try:
        units.normalise(text)
    except InertialcalError:
        return False
    return True


def _decimal(text: str, start: Line, separator: str | None, decimal: Decimal) -> Decimal:
    """Decimal comma also where the first 200 lines hold whole numbers only."""
    if decimal == "," or separator == "," or text.find(",", start.offset) < 0:
        return decimal
    commas = re.compile(r"[0-9],[0-9]").search(text, start.offset)
    points = re.compile(r"[0-9]\.[0-9]").search(text, start.offset)
    return "," if commas and not points else decimal


def _preamble_remark(notes: list[str], lines: list[Line], where: str) -> tuple[Remark, ...]:
    if not notes:
        return ()
    first = notes[0].strip()[:60]
    what = f"{len(notes)} line(s) before the table left out: {first!r} ..."
    return (Remark("preamble", "info", what, where=f"{where}:{lines[0].row}"),)


def _sample_rate(comments: list[str]) -> float | None:
    """Sample rate [Hz] that a comment states."""
    for comment in comments:
        match = SAMPLE_RATE.search(comment)
        if match and float(match[1]) > 0.0:
            return float(match[1]) * (1e3 if (match[2] or "").lower() == "khz" else 1.0)
    return None
