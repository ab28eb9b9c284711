"""Workbooks: Excel (``.xlsx``, ``.xlsb``, ``.xls``) and OpenDocument (``.ods``), by python-calamine.

A sheet is a table as any text is: it is handed to the reader of text, a line a row, so that headers, units, dates and
empty cells mean the same in both, and rows have the numbers that the sheet shows.
"""

from __future__ import annotations

import datetime
import io
import re
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...core.remarks import Remark
from ..apart import apart
from ..budget import claim
from ..columns import Content
from ..formats import ZIP, members
from ..reader import Reader
from ..source import Loaded
from ..text.layout import Decimal, kind
from ..text.pieces import read_text
from .topics import (
    NO_NUMBERS,
    Topic,
    choose,
    has_temperature,
    in_topic,
    joined,
    library,
    other_topics,
    rank_of,
    time_first,
    with_thermometer,
)

OLD = b"\xd0\xcf\x11\xe0"
CELL = 100  # bytes of a cell in Python
HEADER_ROWS = 2  # names and units
SIGNS: tuple[Decimal, ...] = (".", ",")  # of decimals, in cells of text
UNCOMPUTED = re.compile(rb"<f[ />](?:[^<]|<(?!v>[^<]|/c>|c[ >]))*</c>")  # a formula without a value behind it
ERRORS = re.compile(r"#(?:DIV/0!|N/A|NAME\?|NULL!|NUM!|REF!|VALUE!)")
Cell = Any  # number, text, truth value, date or time


def read_excel(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a sheet: the one that was named, or the only one with numbers.

    Raises
    ------
    DataError
        As the reader of text; ``several_topics``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    calamine = library("python_calamine", "a workbook", loaded.path)
    parts: list[bytes] = []
    if loaded.data.startswith(ZIP):
        with zipfile.ZipFile(io.BytesIO(loaded.data)) as archive:
            size = sum(one.file_size for one in archive.infolist())
            claim(loaded.path, loaded.on_disk, len(loaded.data) + 2 * size, f"{size:,} bytes unpacked")
            parts = [one.filename.encode() for one in archive.infolist()]
    book = calamine.load_workbook(io.BytesIO(loaded.data))
    sheets: dict[str, tuple[list[list[Cell]], bool]] = {}
    topics = []
    cells = 0
    for about in book.sheets_metadata:
        if about.typ != calamine.SheetTypeEnum.WorkSheet:
            continue
        sheet = book.get_sheet_by_name(about.name)
        cells += sheet.total_height * sheet.total_width
        claim(loaded.path, loaded.on_disk, len(loaded.data) + CELL * cells, f"{cells:,} cells")
        rows = sheet.to_python(skip_empty_area=False)
        as_text = sum(map(_is_data, rows)) < HEADER_ROWS  # a sheet without numbers: its texts may be some
        first = next((i for i, row in enumerate(rows) if _is_data(row, as_text)), None)
        hidden = "" if about.visible == calamine.SheetVisibleEnum.Visible else "hidden"
        numbers = 0 if first is None else sum(_is_data(row, as_text) for row in rows)
        used = _used(rows[first:]) if first is not None else []
        names = [_cell(rows[_header(rows, first, used)][i]) for i in used] if first is not None else []
        rank = NO_NUMBERS if numbers < HEADER_ROWS else rank_of(((one, None) for one in names), about.name)
        warm = has_temperature(((one, None) for one in names), about.name)
        topics.append(Topic(about.name, hidden, numbers, rank, warm))
        sheets[about.name] = rows, as_text
    chosen = with_thermometer(topics, choose(topics, variables, loaded.path), variables)
    contents = []
    for topic in chosen:
        rows, as_text = sheets[topic.name]
        text = _text(rows, as_text)
        content = read_text(replace(loaded, data=text.encode(), packed=False), None, None if as_text else ".")
        columns = in_topic(content.columns, topic.name)
        contents.append((topic, replace(content, columns=time_first(columns) if len(chosen) > 1 else columns)))
    found = joined(contents, loaded.path, named=bool(variables))
    what = "OpenDocument" if b"content.xml" in parts else "Excel"
    remarks = (*found.remarks, *_not_computed(loaded), *other_topics(topics, chosen, loaded.path))
    return replace(found, format=f"{what}, sheet {chosen[0].name!r}", remarks=remarks)


def _is_data(row: Sequence[Cell], as_text: bool = False) -> bool:
    """Whether a row holds numbers, ``as_text`` too: as many as half of what it holds, or a date and a number."""
    there = [cell for cell in row if cell != ""]
    numbers = [cell for cell in there if isinstance(cell, int | float) or (as_text and _is_spelled(cell))]
    return bool(numbers) and 2 * len(numbers) >= len(there) - sum(isinstance(one, datetime.date) for one in there)


def _is_spelled(cell: Cell) -> bool:
    return isinstance(cell, str) and any(kind(cell.strip(), sign) in ("i", "f") for sign in SIGNS)


def _text(rows: Sequence[Sequence[Cell]], as_text: bool) -> str:
    """Return a sheet as text, tabs between the cells; what stands above its header as comments."""
    first = next((i for i, row in enumerate(rows) if _is_data(row, as_text)), 0)
    used = _used(rows[first:])
    head = _header(rows, first, used)
    dated = [at for at in used if any(isinstance(row[at], datetime.datetime) for row in rows[first:])]
    lines = []
    for i, row in enumerate(rows):
        if i < head:
            lines.append("# " + " ".join(filter(None, map(_cell, row))))
        elif i < first and not any(map(_cell, row)):
            lines.append("")
        else:
            lines.append("\t".join(_cell(_instant(row[at]) if at in dated else row[at]) for at in used))
    return "\n".join(lines) + "\n"


def _instant(cell: Cell) -> Cell:
    """Return the instant of midnight, which a workbook keeps as a day."""
    is_day = isinstance(cell, datetime.date) and not isinstance(cell, datetime.datetime)
    return datetime.datetime.combine(cell, datetime.time()) if is_day else cell


def _used(rows: Sequence[Sequence[Cell]]) -> list[int]:
    """Return the columns of a table: one with nothing but a title or a remark beside the table is none of it."""
    used = [i for i in range(max(map(len, rows), default=0)) if any(_cell(row[i]) for row in rows)]
    return list(range(used[0], used[-1] + 1)) if used else []


def _header(rows: Sequence[Sequence[Cell]], first: int, used: Sequence[int]) -> int:
    """Return the row of the names above the first row of data: units, all or some, and empty rows may stand between."""
    last = first
    while last > 0 and not any(_cell(rows[last - 1][i]) for i in used):
        last -= 1
    above = range(max(last - HEADER_ROWS, 0), last)
    return next((i for i in above if 2 * sum(_cell(rows[i][at]) != "" for at in used) > len(used)), first)


def _cell(cell: Cell) -> str:
    """Return a cell as text that reads back; an error of a formula is a missing value."""
    if isinstance(cell, str):
        text = " ".join(cell.split())
        return "NaN" if ERRORS.fullmatch(text) else text
    if isinstance(cell, bool):
        return str(int(cell))
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 2**53 else repr(cell)
    if isinstance(cell, datetime.timedelta):
        return repr(cell.total_seconds())
    if isinstance(cell, datetime.date | datetime.time):
        return cell.isoformat()
    return str(cell)


def _not_computed(loaded: Loaded) -> tuple[Remark, ...]:
    """Return a remark on formulas whose value the workbook does not hold: their cells are empty."""
    count = 0
    if loaded.data.startswith(ZIP):
        with zipfile.ZipFile(io.BytesIO(loaded.data)) as archive:
            for name in archive.namelist():
                if name.startswith("xl/worksheets/") and name.endswith(".xml"):
                    sheet = archive.read(name)
                    if b"<f" in sheet:
                        count += len(UNCOMPUTED.findall(sheet))
    if not count:
        return ()
    what, do = "formulas that were never computed: their cells are empty", "Open the workbook, and save it"
    return (Remark("not_computed", "warning", what, where=loaded.path, count=count, do=do),)


def _is_book(data: bytes, path: str) -> bool:
    if not data.startswith(ZIP):
        return data.startswith(OLD)
    names = set(members(data))
    return bool(names & {"xl/workbook.xml", "xl/workbook.bin"}) or {"content.xml", "mimetype"} <= names


READER = Reader("excel", "Excel", (".xlsx", ".xlsb", ".xls", ".ods"), _is_book, apart(read_excel, "a workbook"))
