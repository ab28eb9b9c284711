"""Layout of a text file: comment lines, header, separator, decimal sign, where the numbers start.

Judged from the first 200 lines that hold something. Candidates for separator and decimal sign are scored by
the share of lines of equal width times the share of cells that are numbers; at a tie the first in
``CANDIDATES`` wins. The header is the first of these lines if no cell of it is a number and it is as wide as
the rows; failing that the last comment line, if it is. Units stand in a line of words, or a comment, below it. Lines
before a header that are neither (an export's preamble) are left out and counted. A sign of comments that stands
before every line, rows too, is none.

Text is UTF-8 with a Latin-1 fallback, or UTF-16 by its byte-order mark; binary data is refused.

A column is numbers if it holds no more text than numbers; that text is then an error, which the caller places. A column
with more text than numbers is text. Whole numbers stay whole (int64) as long as every cell is one.
"""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core import units
from ...core.errors import DataError
from ...core.remarks import Remark
from ..budget import COLUMNS, LINE, check_count, claim
from ..columns import Rows
from ..source import Loaded
from .settings_head import LONGEST, settings_of

SAMPLE = 200  # lines
MOST_BEFORE = 100_000  # comments and blank lines before the table
CELL_BYTES = 88  # that a cell takes as text
LONGEST_COMMENT = 10_000  # characters of it that are looked at
LONGEST_CELL = 400  # characters: no number is longer
SOME = 64  # cells that tell whether a column has few different ones
CELLS = 50  # of a line that are looked at
ACROSS = 16  # numbers in a lone line from which it is a series
CANDIDATES: tuple[tuple[str | None, Decimal], ...] = (
    (",", "."),
    ("\t", "."),
    (";", "."),
    ("\t", ","),
    (None, "."),
    (None, ","),
    (";", ","),
)
QUOTED: tuple[str | None, Decimal] = (",", ",")  # only in quotes can a comma be both
# A quoted number whose comma can group no digits.
QUOTED_DECIMAL = re.compile(r'"[-+]?(?:0|[0-9]{4,}|[0-9]+(?=,(?:[0-9]{1,2}|[0-9]{4,})"))(?:,[0-9]+)"')
GROUPED_WHOLE = re.compile(r"[-+]?[1-9][0-9]{0,2}(?:\.[0-9]{3})+")  # by points, where the decimal sign is a comma
PERFECT = (1.0, True, 1.0)  # score of a separator: lines of one width in several columns, all of them numbers
WORDS = {",": "comma-separated", "\t": "tab-separated", ";": "semicolon-separated", None: "blank-separated"}
PLAIN = "0123456789.-+eE"  # characters of plain numbers
NUMBER = frozenset("ifn")  # kinds of cells
HARDLY = 0.05  # share of numbers in a text that is no table
WORDS_BELOW = 2  # lines of words, at most, between a header and its numbers
RATIO = "1"  # where a unit stands
WAVEFORM = ("waveform", "t0", "delta t")
NUMBERED = 3  # lines: names, units, numbers
COMMENT = ("#", "%", "//", "!")
SEMICOLON_COMMENT = (*COMMENT, ";")
OF_SPREADSHEET = re.compile(r'"?sep=.?"?', re.IGNORECASE)  # a first line that names the separator
SIGN = re.compile(r"[ \t]*(?://+|([#%!;])\1*)")  # of a comment, however often it stands there
SIGNS = "#%/;! \t"  # what may stand before the text of a comment
ROW_AS_COMMENT = re.compile(r"[ \t]*[-+]?[0-9.][-+0-9.,;:/TZeE \t]*")  # numbers, and a date
SAMPLE_RATE = re.compile(
    r"\b(?:fs|(?:sampl(?:e|ing)|data|update)[ _-]*(?:rate|frequency|freq))\b[^0-9=:]{0,12}[=:]?\s*"
    r"([0-9]+(?:\.[0-9]*)?(?:e[-+]?[0-9]+)?)\s*(k?hz|sps|/s)?",
    re.IGNORECASE,
)
Table = list[list[str]]  # cells by line


@dataclass(frozen=True)
class Line:
    """A line that holds something: row in the file from 1, offset of its first character, text."""

    row: int
    offset: int
    text: str


@dataclass(frozen=True)
class Layout:
    """How a text file is laid out."""

    separator: str | None  # None for blanks
    decimal: Decimal  # Decimal sign
    width: int  # Cells in a row
    names: tuple[str, ...]  # One a column; empty text where there is none
    units: tuple[str, ...]  # One a column; empty text where there is none
    start: int  # Offset of the first character of the first data row
    row: int  # Of the first data row in the file
    comment: tuple[str, ...]  # Starts of a comment line
    across: bool = False  # Whether the only line is a series of numbers
    sample_rate: float | None = None  # As comments say it [Hz]
    remarks: tuple[Remark, ...] = ()  # What was unusual

    @property
    def words(self) -> str:
        """The layout in words."""
        sign = ", decimal comma" if self.decimal == "," else ""
        return f"text, {WORDS[self.separator] if self.width > 1 else 'one column'}{sign}"


def sniff(text: str, where: str, decimal: Decimal | None = None) -> Layout:
    r"""Return the layout of a text with ``\n`` line ends; ``decimal``: its decimal sign, where that was stated.

    Raises
    ------
    DataError
        If it holds no row, or the header is not as wide as the rows.
    """
    layout = _sniff(text, where, SEMICOLON_COMMENT, decimal)
    return _sniff(text, where, COMMENT, decimal) if layout.separator == ";" else layout


def without_first(text: str, lines: int) -> str:
    """Return the text with its first lines empty, so that rows keep their numbers."""
    at = 0
    for _ in range(lines):
        at = text.find("\n", at) + 1
        if not at:
            return ""
    return "\n" * lines + text[at:]


def without_signs(text: str) -> tuple[str, str]:
    """Return a text whose every line is a comment, and most of them rows, without the signs, and its sign.

    Any other text as it is, and no sign. Blanks stand where the signs stood, so that rows and cells keep their places.
    """
    first = SIGN.match(text.lstrip())
    mark = first[0] if first else ""
    signs = text.count(";") if mark.startswith(";") else 0  # more of them than lines: they separate
    rows = lines = 0
    for line in _lines(text) if mark else ():
        if lines == SAMPLE:
            break
        sign = SIGN.match(line.text)
        if sign is None and line.text.strip():
            return text, ""
        if sign is not None and line.text[sign.end() :].strip():
            lines += 1
            rows += ROW_AS_COMMENT.fullmatch(line.text, sign.end()) is not None
    if 2 * rows <= lines or signs > 1 + text.count("\n"):
        return text, ""
    bare = re.sub(rf"^{SIGN.pattern}", lambda sign: " " * len(sign[0]), text, flags=re.MULTILINE)
    return bare, mark.strip()


def split(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line, without quotes and outer blanks."""
    if '"' in line:
        line = line.strip(BLANKS) if separator is None else line
        parts = next(csv.reader([line], delimiter=separator or " ", skipinitialspace=True), [])
    elif separator is None:
        parts = re.split(r"[ \t]+", line.strip(BLANKS))
    else:
        parts = line.split(separator)
        if " " not in line and "\t" not in line:
            return parts
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


def _sniff(text: str, where: str, comment: tuple[str, ...], stated: Decimal | None) -> Layout:
    comments, lines = _head(text, comment, where)
    if not lines:
        raise DataError("no rows of data", where=where, do="Record again", code="empty_file")
    _check_lines(lines, where)
    settings = settings_of([line.text for line in lines[: 2 * LONGEST]])
    given = lines[: settings.lines + settings.below] if settings else []
    lines, all_lines = lines[len(given) :], lines
    separator, decimal, table = _separator(lines, stated)
    width = _width(table)
    if _is_prose(table, decimal):
        what, do = "no table of numbers: lines of words, with different numbers of cells", "Name a recording"
        raise DataError(what, where=where, do=do, code="no_channel")
    header, first = _first_data(table, decimal, width)
    notes = [line.text for line in (*given, *lines[: first if header is None else header])]
    above = [one.text for one in comments if one.row < lines[0].row]
    if settings is not None and len(settings.units) != width:
        raise _header_width(len(settings.units), width, f"{where}:{lines[0].row}")
    names, units_row = _comment_header(above, separator, width) if header is None and not settings else ((), ())
    from_comment = bool(names)
    names = names or (("",) * width if header is None else tuple(_header(table[header], table, width)))
    if header is not None and len(names) != width:
        raise _header_width(len(names), width, f"{where}:{lines[header].row}")
    if header is not None and width == 1 and len(lines) == header + 2:  # a row alone, cut off in its first cell
        wide = max(len(split(lines[header].text, sign)) for sign in ",;\t")
        if wide > 1:
            raise _header_width(wide, width, f"{where}:{lines[header].row}")
    if header is not None:
        units_row, below = _units(table[header:], decimal, width)
        first += below
        units_row = units_row or _units_in_comments(comments, lines[header : first + 1], separator, width)
    if first >= len(lines):
        raise DataError("a header, but no rows of data", where=where, code="empty_file")
    start = lines[first]
    rate = _sample_rate(above + notes)
    if settings is not None:
        names = settings.names or names
        units_row = tuple(own or one for own, one in zip(units_row or settings.units, settings.units, strict=True))
        rate = rate or (1.0 / settings.step if settings.step else None)
    return Layout(
        separator=separator,
        decimal=stated or _decimal(text, start, separator, decimal),
        width=width,
        names=names,
        units=units_row or ("",) * width,
        start=start.offset,
        row=start.row,
        comment=comment,
        across=len(lines) == 1 and header is None and width >= ACROSS,
        sample_rate=rate,
        remarks=_remarks(notes, all_lines, names if from_comment else (), where)
        + _ambiguous(table[first:], separator, header, where),
    )


def _check_lines(lines: list[Line], where: str) -> None:
    """Refuse lines with too many cells, or that are too long; a lone line may be a series across."""
    for line in lines:
        if len(lines) > 1 and len(line.text) < COLUMNS:  # it cannot have too many cells
            continue
        cells = max(len(line.text.split()), *(1 + line.text.count(sign) for sign in ",;\t"))
        if len(lines) > 1 or cells < ACROSS:
            check_count(len(line.text), LINE, "characters in a line", f"{where}:{line.row}")
        if len(lines) > 1:
            check_count(cells, COLUMNS, "columns", f"{where}:{line.row}")


def _head(text: str, comment: tuple[str, ...], where: str) -> tuple[list[Line], list[Line]]:
    """Comment lines up to the last line that is looked at, and the first lines that hold something."""
    comments: list[Line] = []
    lines: list[Line] = []
    for line in _lines(text):
        stripped = line.text.strip()
        if stripped.startswith(comment):
            comments.append(replace(line, text=stripped[:LONGEST_COMMENT]))
        elif stripped and not (line.row == 1 and OF_SPREADSHEET.fullmatch(stripped)):
            lines.append(line)
        if len(lines) == SAMPLE:
            break
        check_count(line.row - len(lines), MOST_BEFORE, "comments and blank lines before the table", where)
    return comments, lines


def _separator(lines: list[Line], stated: Decimal | None) -> tuple[str | None, Decimal, Table]:
    """Separator and decimal sign with the best score, and the lines cut by it."""
    starts = [line.text[:LINE] for line in lines]
    tables: dict[str | None, Table] = {}
    best: tuple[float, bool, float] | None = None
    quoted = [QUOTED] if any(QUOTED_DECIMAL.search(start) for start in starts) else []
    for one in (one for one in [*CANDIDATES, *quoted] if stated in (None, one[1])):
        if one[0] not in tables:
            tables[one[0]] = [split(start, one[0]) for start in starts]
        score = _score(tables[one[0]], one[1])
        if best is None or score > best:
            best, (separator, decimal) = score, one
        if best == PERFECT:  # none after it can be better
            break
    table = tables[separator]
    return separator, decimal, table if len(lines) > 1 else [split(lines[0].text, separator)]


def _score(table: Table, decimal: Decimal) -> tuple[float, bool, float]:
    """Share of alike lines times share of numbers; more than one column; share of alike lines."""
    width = _width(table)
    alike = [i for i, cells in enumerate(table) if len(cells) == width]
    share = len(alike) / len(table)
    # The first line may be a header, which must fit in width but holds no number, and units may stand below it.
    rows = [i for i in alike if i and not (i == 1 and _holds_units(table[i]))] or alike
    filled = text = 0
    every = [cell for i in rows for cell in table[i][:CELLS]]
    if _are_numbers(every, decimal):
        filled, rows = len(every), []
    for i in rows:
        cells = table[i][:CELLS]
        if _are_numbers(cells, decimal):
            filled += len(cells)
            continue
        kinds = Counter(kind(cell, decimal) for cell in cells)
        filled += kinds.total() - kinds["e"]
        text += kinds["t"]
        if decimal == "," and kinds["t"]:  # 32.804 beside 0,25 is a whole number
            text -= sum(GROUPED_WHOLE.fullmatch(cell) is not None for cell in cells)
    numbers = (filled - text) / filled if filled else 0.0
    if width == 1 and decimal == "," and ("," in table[0][0] or numbers < 1.0 or share < 1.0):
        numbers = 0.0  # 1,5 are two columns, unless a name stands above them that has no comma
    return round(share * numbers, 6), width > 1, share


def _holds_units(cells: list[str]) -> bool:
    """Whether some cells are filled, all of them with units."""
    filled = [cell for cell in cells if cell.strip()]
    return bool(filled) and all(units.is_unit(_unbracketed(cell)) for cell in filled)


def _are_numbers(cells: list[str], decimal: Decimal) -> bool:
    """Whether all cells are plain numbers; False where that is not known at once."""
    if decimal != "." or "".join(cells).strip(PLAIN) or max(map(len, cells), default=0) > LONGEST_CELL:
        return False
    return _floats(cells)


def _floats(cells: list[str]) -> bool:
    try:
        return len([*map(float, cells)]) > 0
    except ValueError:
        return False


def _width(table: Table) -> int:
    """Most frequent number of cells in the later half, where data is."""
    counts = Counter(len(cells) for cells in table[len(table) // 2 :])
    return max(counts, key=lambda width: (counts[width], width))


def _is_prose(table: Table, decimal: Decimal) -> bool:
    """Whether hardly a cell of some lines, which differ in width, is a number."""
    if len(table) < NUMBERED or len({len(cells) for cells in table}) < NUMBERED:
        return False
    kinds = Counter(kind(cell, decimal) for cells in table for cell in cells[:CELLS])
    return sum(kinds[one] for one in NUMBER) < HARDLY * kinds.total()


def _first_data(table: Table, decimal: Decimal, width: int) -> tuple[int | None, int]:
    """Index of the header, if there is one, and of the first row of data.

    The header is the last line of words before the numbers if it has several cells, whether it fits or not. A
    spreadsheet fills the lines of its title up to the width of the table: they are none of it.
    """
    before: int | None = None
    titles = max(_titles(table, decimal, width), _waveform(table))
    if _is_numbered(table, decimal, width):
        return 0, 1
    for i, cells in enumerate(table):
        kinds = [kind(cell, decimal) for cell in cells[:CELLS]]
        if i < titles or (len(cells) != width and _header_below(table, i, decimal, width)):
            continue
        if not _has_number(kinds):
            if len(_header(cells, table, width)) == width and not _is_title(table[i:], decimal, width):
                return i, i + 1
            before = i if len(cells) > 1 else None
        elif i == 0 or kinds[0] in NUMBER or len(cells) == width:
            return before, i
    return 0, 1  # words only, and no line as wide as most: the first is the header, and does not fit


def _header_below(table: Table, at: int, decimal: Decimal, width: int) -> bool:
    """Whether a line of words as wide as the rows stands below one that is not, and nothing as wide between them.

    So stand the settings of a logger above its table: a list of its channels is none of its rows.
    """
    for i in range(at + 1, len(table) - 1):
        if len(_header(table[i], table, width)) == width:
            kinds = [kind(cell, decimal) for cell in table[i][:CELLS]]
            return set(kinds) <= {"t", "e"} and kinds.count("t") > 1
    return False


def _titles(table: Table, decimal: Decimal, width: int) -> int:
    """Lines above the header that are as wide as the rows, but begin with a word and end with empty cells.

    There are some only if a line of words, not of units, that is filled further stands between them and the numbers.
    """
    filled: list[int] = []
    for line in table:
        cells = line if len(line) <= width else _header(line, table, width)  # a title may have more empty cells
        kinds = [kind(cell, decimal) for cell in cells[:CELLS]]
        if len(cells) != width or width == 1 or kinds[0] in NUMBER:
            break
        last = max((k + 1 for k, cell in enumerate(cells) if cell.strip()), default=0)
        of_units = all(units.is_unit(_unbracketed(cell)) for cell in cells if cell.strip())
        filled.append(-last if of_units or _has_number(kinds) else last)
    header = filled.index(max(filled)) if filled else 0
    if len(filled) == len(table):  # every row begins with a word, or a date: titles are hardly filled
        below = filled[header + 1 : header + 2]
        header = header if below and below[0] < 0 and all(2 * abs(one) <= width for one in filled[:header]) else 0
    return header if header and all(abs(one) < filled[header] for one in filled[:header]) else 0


def _waveform(table: Table) -> int:
    """Lines above the header that say start and step of a waveform, as LabVIEW writes them."""
    words = [cells[0].strip().lower() for cells in table[: len(WAVEFORM)]]
    return len(WAVEFORM) if words == [*WAVEFORM] else 0


def _is_numbered(table: Table, decimal: Decimal, width: int) -> bool:
    """Whether the first line names columns by numbers, as oscilloscopes do: units stand below, then numbers alone."""
    if len(table) < NUMBERED or any(len(cells) != width for cells in table[:NUMBERED]) or width == 1:
        return False
    names, given, first = ([kind(cell, decimal) for cell in cells] for cells in table[:NUMBERED])
    return names[0] == "t" and set(given) <= {"t", "e"} and _holds_units(table[1]) and set(first) <= NUMBER


def _is_title(table: Table, decimal: Decimal, width: int) -> bool:
    """Whether the first of some lines, of words, is hardly filled, and a full one that is no line of units follows it.

    A line of numbers, as wide as most, ends the search.
    """
    filled = sum(bool(cell.strip()) for cell in table[0])
    if 2 * filled >= width:
        return False
    for cells in table[1:]:
        kinds = [kind(cell, decimal) for cell in cells[:CELLS]]
        if len(cells) == width and kinds[0] in NUMBER:
            return False
        full = len(cells) == width and set(kinds) == {"t"}
        if full and not all(units.is_unit(_unbracketed(cell)) for cell in cells):
            return True
    return False


def _has_number(kinds: list[str]) -> bool:
    return not NUMBER.isdisjoint(kinds)


def _header(cells: list[str], table: Table, width: int) -> list[str]:
    """Names for a row of ``width`` cells; an empty cell at the end of either is no column."""
    while cells and not cells[-1] and len(cells) > width:
        cells = cells[:-1]
    if len(cells) != width - 1 or width == 1:
        return cells
    ends = {row[-1] for row in table if len(row) == width}
    return [*cells, ""] if ends == {""} else cells


def _header_width(names: int, width: int, where: str) -> DataError:
    return DataError(
        f"the header names {names} column(s), the rows have {width}",
        where=where,
        why="it is not clear which number belongs to which name",
        do="Name each column, with the same separator as the numbers",
        code="ragged_row",
    )


def _comment_header(comments: list[str], separator: str | None, width: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the columns in the last comment, or in the one above the units, and the units; empty without them.

    An underline is no comment.
    """
    texts = [one.lstrip(SIGNS) for one in comments]
    *above, last = [one for one in texts if not one or any(sign.isalnum() for sign in one)] or [""]
    units_row = _comment_units(last, separator, width)
    names = _comment_names(above[-1], separator, width) if above and units_row else ()
    return (names, units_row) if names else (_comment_names(last, separator, width), ())


def _comment_names(comment: str, separator: str | None, width: int) -> tuple[str, ...]:
    """Cells of a comment, if they can name the columns."""
    for cells in _comment_cells(comment, separator, width):
        if all(kind(cell) == "t" for cell in cells) and len(set(cells)) == width:
            # One column: a sentence is no name.
            return cells if width > 1 or len(comment.split()) == 1 else ()
    return ()


def _units_in_comments(comments: list[Line], between: list[Line], separator: str | None, width: int) -> tuple[str, ...]:
    """Units in a comment between two lines."""
    rows = range(between[0].row, between[-1].row)
    found = (_comment_units(one.text.lstrip(SIGNS), separator, width) for one in comments if one.row in rows)
    return next(filter(None, found), ())


def _comment_units(comment: str, separator: str | None, width: int) -> tuple[str, ...]:
    """Cells of a comment, if all that are filled are units."""
    for cells in _comment_cells(comment, separator, width):
        given = tuple(_unbracketed(cell) for cell in cells)
        if any(given) and all(units.is_unit(unit) for unit in given if unit):
            return given
    return ()


def _comment_cells(text: str, separator: str | None, width: int) -> Iterator[tuple[str, ...]]:
    """Cells of a comment, by each way that gives as many as a row has."""
    for parts in (split(text, separator), re.split(r"\s{2,}|\t", text)):
        if len(parts) == width:
            yield tuple(part.strip() for part in parts)


def _units(table: Table, decimal: Decimal, width: int) -> tuple[tuple[str, ...], int]:
    """Units below the first line of a table, and how many lines of words stand there, two at most, before the numbers.

    Words stand in columns that hold numbers below, and above dates; the first such line whose words are units, at least
    half of them, says the units.
    """
    names, *below = table[: 2 + WORDS_BELOW]
    kinds = [[kind(cell, decimal) for cell in cells] for cells in below]
    for count in range(1, min(len(below), 1 + WORDS_BELOW)):
        if any(len(cells) != len(names) for cells in below[: count + 1]):
            break
        if _has_number(kinds[count]) and all(_is_of_words(one, kinds[count]) for one in kinds[:count]):
            given = [[_unbracketed(cell) for cell in cells] for cells in below[:count]]
            row = next((one for one, own in zip(given, kinds, strict=False) if _are_units(one, own)), None)
            if row is not None:
                return (*row, *[""] * (width - len(row))), count
    return (), 0


def _are_units(cells: list[str], kinds: list[str]) -> bool:
    """Whether at least half of the words of a line are units, and nothing else stands there but ``1`` and ``n/a``."""
    words = [cell for cell, one in zip(cells, kinds, strict=True) if one == "t"]
    others = [cell for cell, one in zip(cells, kinds, strict=True) if one in "if"]
    return 2 * sum(map(units.is_unit, words)) >= len(words) > 0 and set(others) <= {RATIO}


def _is_of_words(kinds: list[str], numbers: list[str]) -> bool:
    """Whether a line has words in columns of numbers; what stands above text, such as dates, may be any."""
    above = [one for one, below in zip(kinds, numbers, strict=True) if below in NUMBER | {"e"}]
    return "t" in above


def _unbracketed(cell: str) -> str:
    """Return a cell without brackets around all of it."""
    text = cell.strip()
    return text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text


def _decimal(text: str, start: Line, separator: str | None, decimal: Decimal) -> Decimal:
    """Decimal comma also where the first 200 lines hold whole numbers only."""
    if decimal == "," or separator == "," or text.find(",", start.offset) < 0:
        return decimal
    commas = re.compile(r"[0-9],[0-9]").search(text, start.offset)
    points = re.compile(r"[0-9]\.[0-9]").search(text, start.offset)
    return "," if commas and not points else decimal


def _remarks(notes: list[str], lines: list[Line], from_comment: tuple[str, ...], where: str) -> tuple[Remark, ...]:
    """Remarks on a preamble and on names from a comment."""
    remarks = []
    if notes:
        what = f"{len(notes)} line(s) before the table ignored: {notes[0].strip()[:60]!r} ..."
        remarks.append(Remark("preamble", "info", what, where=f"{where}:{lines[0].row}"))
    if from_comment:
        what = f"column names taken from the last comment: {', '.join(from_comment)[:120]}"
        remarks.append(Remark("header_from_comment", "info", what, where=where))
    return tuple(remarks)


def _ambiguous(table: Table, separator: str | None, header: int | None, where: str) -> tuple[Remark, ...]:
    """Remark on two columns of whole numbers that may be one of numbers with a decimal comma."""
    pairs = separator == "," and header is None and all(len(cells) == 2 for cells in table)
    if not pairs or not all(kind(cell) == "i" for cells in table for cell in cells):
        return ()
    if any(cells[1].startswith("-") for cells in table):
        return ()
    what = "read as two columns of whole numbers; or is it one column with decimal commas?"
    return (Remark("decimal_comma", "warning", what, where=where, do="Add a header line to make it clear"),)


def _sample_rate(comments: list[str]) -> float | None:
    """Sample rate [Hz] that a comment states."""
    for comment in comments:
        match = SAMPLE_RATE.search(comment)
        if match and float(match[1]) > 0.0:
            return float(match[1]) * (1e3 if (match[2] or "").lower() == "khz" else 1.0)
    return None


CONTROL = bytes(sorted(set(range(1, 32)) - set(b"\t\n\v\f\r\x1a")))  # Ctrl-Z ends a text of CP/M and DOS
CONTROL_SHARE = 1e-3  # of the bytes, from which it is no text
BEGINNING = 2**16  # bytes that tell text
WIDE = re.compile(rb"[\xf0-\xff]")  # starts of what takes four bytes a letter; of UTF-16 too
MARKS = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


def decode(data: bytes, where: str) -> tuple[str, tuple[Remark, ...]]:
    r"""Return the text with ``\n`` line ends, without a trailing Ctrl-Z, and what reading it brought up.

    Raises
    ------
    DataError
        If it holds nul bytes or many control characters.
    """
    remarks: tuple[Remark, ...] = ()
    if data.startswith(tuple(mark for mark, _ in MARKS)):
        text = _utf16(data, where)
    else:
        # Raise where bytes are no text
        at = data.find(b"\x00")
        if at >= 0:
            row = data.count(b"\n", 0, at) + 1
            raise DataError(
                f"a nul byte at byte {at}",
                where=f"{where}:{row}",
                why="binary data in an unknown format, or a text file truncated while it was written",
                do="Export it as text or Parquet, or delete the damaged end",
                code="not_text",
            )
        controls = len(data) - len(data.translate(None, CONTROL))
        if controls > CONTROL_SHARE * len(data):
            raise DataError(
                f"{controls} control characters in {len(data)} bytes",
                where=where,
                why="binary data in an unknown format",
                do="Export it as text or Parquet",
                code="not_text",
            )
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            text = data.decode("latin-1")
            remarks = (_not_utf8(data, error.start, where),)
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.rstrip("\x1a"), remarks


def text_of(loaded: Loaded) -> tuple[str, tuple[Remark, ...]]:
    """Return the text of a loaded file as `decode` does.

    Raises
    ------
    DataError
        As `decode`; ``too_large``.
    """
    data = loaded.data
    letter = 1 if data.isascii() else 4 if WIDE.search(data) else 2  # bytes of a letter in memory
    need = len(data) * (1 + letter * (2 if b"\r" in data else 1))
    lines = 1 + data.count(b"\n")
    if lines == 1:  # a series across: each number is cut out
        need += CELL_BYTES * max(data.count(sign) for sign in (b",", b";", b"\t", b" "))
    claim(loaded.path, loaded.on_disk, need, f"{len(data):,} bytes of text in {lines:,} line(s)")
    return decode(data, loaded.path)


def holds_control(data: bytes) -> bool:
    """Whether bytes hold nul bytes or control characters: `decode` judges them by their share of the file."""
    return b"\x00" in data or len(data.translate(None, CONTROL)) != len(data)


def looks_like_text(data: bytes, path: str) -> bool:
    """Whether the beginning of a file is text, so that `decode` may be tried."""
    return data.startswith(tuple(mark for mark, _ in MARKS)) or b"\x00" not in data[:BEGINNING]


def _utf16(data: bytes, where: str) -> str:
    try:
        return data.decode("utf-16").replace("\x00", "\ufffd")
    except UnicodeDecodeError as error:
        raise DataError(f"marked as UTF-16, but invalid at byte {error.start}", where=where, code="not_text") from None


def _not_utf8(data: bytes, at: int, where: str) -> Remark:
    row = data.count(b"\n", 0, at) + 1
    return Remark("not_utf8", "info", f"byte {data[at]:#04x} is not UTF-8: read as Latin-1", where=f"{where}:{row}")


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
    some = set(cells[:SOME])
    if 2 * len(some) < min(len(cells), SOME):  # few different ones, as labels are: each is looked at once
        different = {cell: cell.strip(BLANKS) for cell in set(cells)}
        known = dict(zip(different, _kinds(list(different.values()), decimal), strict=True))
        stripped, kinds = [different[cell] for cell in cells], np.array([known[cell] for cell in cells], "U1")
    else:
        stripped = [cell.strip(BLANKS) for cell in cells]
        kinds = np.array(_kinds(stripped, decimal), "U1")
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


def _kinds(cells: Sequence[str], decimal: Decimal) -> list[str]:
    """Return the `kind` of each cell."""
    match = CELL[decimal].fullmatch
    if max(map(len, cells), default=0) > LONGEST_CELL:
        groups = [m.lastgroup if len(c) <= LONGEST_CELL and (m := match(c)) else "" for c in cells]
    else:
        groups = [m.lastgroup if m else "" for m in map(match, cells)]
    return [KINDS[g] if g else "t" if c else "e" for g, c in zip(groups, cells, strict=True)]


def kind(cell: str, decimal: Decimal = ".") -> str:
    """``i`` whole number, ``f`` number, ``e`` empty, ``n`` NaN, NA or infinity, ``t`` text."""
    match = CELL[decimal].fullmatch(cell) if len(cell) <= LONGEST_CELL else None
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
