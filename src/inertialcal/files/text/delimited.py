"""Separated text: CSV, tabs, semicolons, blanks; with or without header; decimal point or comma.

A regular file goes through Arrow's reader; whatever that does not take as plain numbers goes cell by cell,
which is slower and knows the row of each problem. Both give the same columns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ..budget import VALUE, claim
from ..columns import Column, Content, Rows
from ..reader import Reader
from ..source import Loaded
from .grouped import CODE, can_be_either, commas, grouped_cell, grouped_column, grouped_row, problem
from .layout import CELL, CELL_BYTES, Decimal, Layout, is_blank, judge, looks_like_text, sniff, split, text_of

ENDINGS = ("", ".asc", ".csv", ".dat", ".log", ".mat", ".prn", ".tab", ".tsv", ".txt")  # that text usually has
SHOWN = 60  # characters of a cell in a message
BLOCK = 2**22  # bytes that are looked at together


def parse(text: str, where: str, loaded: Loaded | None = None, decimal: Decimal | None = None) -> Content:
    r"""Return the columns of a text with ``\n`` line ends.

    Parameters
    ----------
    text, where : str
        The text, and its file.
    loaded : Loaded, optional
        The file that it is the content of.
    decimal : {".", ","}, optional
        Its decimal sign, where that was stated.

    Raises
    ------
    DataError
        If it has no row of data, rows differ in width, a name appears twice, or text stands among numbers;
        each with ``file:row``.
    """
    layout = sniff(text, where, decimal)
    if layout.across:
        return _across(text, layout, where)
    names = column_names(layout, where)
    raw = b"" if loaded is None else loaded.data
    same = raw.isascii() and b"\r" not in raw and len(raw) >= len(text)  # then the text needs no copy for Arrow
    text, cut = _whole_rows(text, layout, where)
    rows = 1 + text.count("\n", layout.start)
    held, cells = len(raw) + len(text) * (1 if same else 2), rows * layout.width
    on_disk = len(text) if loaded is None else loaded.on_disk
    need = max(held + 1.25 * VALUE * cells + VALUE * rows, VALUE * (cells + 8 * rows))  # then units and clock are found
    claim(where, on_disk, need, f"{cells:,} cells")
    found = fast(text, layout, names, raw if same else None)
    if found is None:
        claim(where, on_disk, held + CELL_BYTES * (cells + rows), f"{cells:,} cells, read one by one")
        found = exact(text, layout, names, where)
    if layout.decimal == "," and decimal is None:
        _refuse_grouped(found, text, layout, names, where)
    return replace(found, remarks=(*found.remarks, *cut))


def _refuse_grouped(found: Content, text: str, layout: Layout, names: Sequence[str], where: str) -> None:
    """Refuse ``1,242`` in a file with decimal commas where it is 1242, or where nobody can tell.

    Raises
    ------
    DataError
        ``grouped_digits``.
    """
    numbers = {column.name: column for column in found.columns if column.is_number}
    either = {name for name, column in numbers.items() if can_be_either(column)}
    others = (column.values for name, column in numbers.items() if name not in either)
    decimal = any(v.dtype.kind == "f" and np.any(v[np.isfinite(v)] % 1.0 != 0.0) for v in others)
    if either and not decimal:  # 1,5e3 is whole
        whole = {name for name, c in numbers.items() if name not in either and c.values.dtype.kind == "f"}
        decimal = any(commas(_cells(text, layout, at)).decimal for at, name in enumerate(names) if name in whole)
    judged = {}
    for at, name in enumerate(names):
        mixed = name in either and np.any((numbers[name].values % 1.0 == 0.0) & (numbers[name].values != 0.0))
        if name in either and (mixed or not decimal):
            judged[name] = commas(_cells(text, layout, at))
            decimal |= judged[name].decimal
    problems = []
    for name, said in judged.items():
        if said.either is None or (decimal and said.whole is None):
            continue
        at = names.index(name)
        cells = dict(_at(_cells(text, layout, at), (said.either, said.whole)))
        place = found.place(where, said.either)
        problems.append(problem(name, cells[said.either], place, None if said.whole is None else cells[said.whole]))
    if problems:
        raise DataError(problems)


def _cells(text: str, layout: Layout, at: int) -> Iterator[str]:
    """Cells of one column, from top to bottom."""
    begin = layout.start
    while begin < len(text):
        end = text.find("\n", begin)
        end = len(text) if end < 0 else end
        line = text[begin:end]
        begin = end + 1
        if line and not is_blank(line, layout.separator) and not line.lstrip().startswith(layout.comment):
            yield split(line, layout.separator)[at]


def _at(cells: Iterator[str], places: tuple[int | None, ...]) -> Iterator[tuple[int, str]]:
    """Cells at some places."""
    return ((index, cell) for index, cell in enumerate(cells) if index in places)


def _whole_rows(text: str, layout: Layout, where: str) -> tuple[str, tuple[Remark, ...]]:
    """Return the text without a last row that was not written to its end, with the remark that says so."""
    begin = text.rfind("\n") + 1
    last = text[begin:]
    if begin <= layout.start or is_blank(last, layout.separator) or last.lstrip().startswith(layout.comment):
        return text, ()
    cells = len(split(last, layout.separator))
    if cells >= layout.width:
        return text, ()
    what = (
        f"the last row is incomplete ({cells} of {layout.width} cells): left out. The file is still being "
        "written, or the recording was interrupted"
    )
    where = f"{where}:{text.count(chr(10)) + 1}"
    return text[: begin - 1], (Remark("row_cut_off", "warning", what, where, do="Read it again when it is complete"),)


def column_names(layout: Layout, where: str) -> tuple[str, ...]:
    """Names of the columns; ``column_3`` where the file has none.

    Raises
    ------
    DataError
        If a name appears twice.
    """
    names = tuple(name or f"column_{i}" for i, name in enumerate(layout.names, start=1))
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise DataError(
            f"column name {', '.join(map(repr, twice))} appears twice",
            where=where,
            why="it is not clear which one is meant",
            do="Rename one",
            code="duplicate_column",
        )
    return names


def fast(text: str, layout: Layout, names: tuple[str, ...], raw: bytes | None = None) -> Content | None:
    """Columns of a regular file by Arrow, or None where the file is not regular; ``raw``: the text as ASCII."""
    body = _regular_body(text, layout, raw)
    table = None if body is None else _arrow(body, layout, names)
    if table is None or body is None or len(table) != _line_ends(body) + 1:
        return None
    length, columns = len(table), []
    del body
    for i, name in enumerate(names):
        column = _from_arrow(table.column(0), layout, name, i)
        if column is None:
            return None
        columns.append(column)
        table = table.remove_column(0)  # frees its memory
    rows = np.arange(layout.row, layout.row + length, dtype=np.int64)
    return _content(columns, rows, layout)


def _line_ends(body: memoryview) -> int:
    return sum(bytes(body[at : at + BLOCK]).count(b"\n") for at in range(0, len(body), BLOCK))


def exact(text: str, layout: Layout, names: tuple[str, ...], where: str) -> Content:
    """Columns cell by cell, with the row of each problem.

    Raises
    ------
    DataError
        If rows differ in width, or text stands among numbers.
    """
    again = header_again(text, layout)
    remarks = () if again is None or not again[1] else (_header_remark(f"{where}:{again[0]}"),)
    if again is not None and not again[1]:
        raise header_repeated(f"{where}:{again[0]}")
    rows, cells = cell_columns(text, layout, where)
    columns, problems = [], []
    for i, name in enumerate(names):
        judged = judge(cells[i], layout.decimal)
        if len(judged.text):
            problems.append(text_in_numbers(name, cells[i], judged.text, rows, where))
        elif (at := _grouped(judged.values, layout)) is not None:
            problems.append(problem(name, cells[i][at], f"{where}:{rows[at]}", certain=True))
        columns.append(_column(name, judged.values, layout, i, judged.empty, judged.not_a_number))
    if problems:
        raise DataError(problems)
    found = _content(columns, rows, layout)
    return replace(found, remarks=(*found.remarks, *remarks))


def header_again(text: str, layout: Layout) -> tuple[int, bool] | None:
    """Return the row at which the header stands a second time, and whether as a comment; None where it does not."""
    first = next((name for name in layout.names if name), "")
    at = text.find(first, layout.start) if first else -1
    while at >= 0:
        begin, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
        line = text[begin : len(text) if end < 0 else end]
        bare = (
            line.lstrip().lstrip("".join(layout.comment)).strip() if line.lstrip().startswith(layout.comment) else line
        )
        if tuple(split(bare, layout.separator)) == layout.names:
            return 1 + text.count("\n", 0, begin), bare is not line
        at = text.find(first, end) if end >= 0 else -1
    return None


def header_repeated(where: str) -> DataError:
    """Return the error for a header among the rows."""
    what, why = "the header stands again", "a second recording in the same file?"
    do = "Split the file there; delete the line if the recording goes on"
    return DataError(what, where, why, do, "header_repeated")


def _header_remark(where: str) -> Remark:
    (problem,) = header_repeated(where).problems
    return Remark(problem.code, "warning", f"{problem.what}, as a comment: {problem.why}", where, do=problem.do)


def _grouped(values: NDArray[Any], layout: Layout) -> int | None:
    """First cell with grouped digits of a column that is text for them only."""
    return grouped_column(values, CELL[layout.decimal].fullmatch) if values.dtype.kind == "O" else None


def cell_columns(text: str, layout: Layout, where: str) -> tuple[Rows, list[list[str]]]:
    """Row of each line of data, and its cells by column; blanks around a cell may be left.

    Raises
    ------
    DataError
        If a row is not as wide as the others.
    """
    rows: list[int] = []
    flat: list[str] = []  # a list for each row would keep the garbage collector busy
    ragged: list[tuple[int, int]] = []
    grouped = ""
    body = text[layout.start :]
    plain = layout.separator if '"' not in body else None
    for row, line in enumerate(body.split("\n"), start=layout.row):
        if not line or is_blank(line, layout.separator) or line.lstrip().startswith(layout.comment):
            continue
        parts = line.split(plain) if plain else split(line, layout.separator)
        if len(parts) != layout.width:
            ragged.append((row, len(parts)))
            grouped = grouped or (grouped_row(parts) if layout.separator == "," else "")
        rows.append(row)
        flat += parts
    if ragged:
        row, width = ragged[0]
        raise DataError(
            f"{width} cell(s) in this row, {layout.width} in the others"
            + (f" ({len(ragged)} such rows)" if len(ragged) > 1 else ""),
            where=f"{where}:{row}",
            why=f"{grouped} with grouped digits?"
            if grouped
            else "it is not clear which number belongs to which column",
            do="Write the numbers without grouping" if grouped else "Correct or delete the row",
            code=CODE if grouped else "ragged_row",
        )
    return np.array(rows, dtype=np.int64), [flat[i :: layout.width] for i in range(layout.width)]


def text_in_numbers(name: str, cells: Sequence[str], at: Rows, rows: Rows, where: str) -> Problem:
    """Return the problem of text in a number column, at its first place; of grouped digits, where there are some."""
    grouped = grouped_cell([cells[int(i)] for i in at])
    if grouped is not None:
        place = int(at[grouped])
        return problem(name, cells[place], f"{where}:{rows[place]}", certain=True)
    first = cells[int(at[0])].strip()
    shown = first if len(first) <= SHOWN else first[:SHOWN] + "..."
    more = f" ({len(at)} such cells)" if len(at) > 1 else ""
    return Problem(
        f"text {shown!r} in number column {name!r}{more}",
        where=f"{where}:{rows[int(at[0])]}",
        do="Correct the cell, or leave it empty if the value is missing",
        code="text_in_numbers",
    )


def _regular_body(text: str, layout: Layout, raw: bytes | None) -> memoryview | None:
    """Rows of data without quotes, comments and blank lines; None where there are some."""
    start, end = layout.start, len(text)
    while end > start and text[end - 1] in "\n ":
        end -= 1
    # One letter is found much faster than two. x: Arrow reads 0x1F as a number.
    if any(text.find(sign, start, end) >= 0 for sign in ('"', "x", "X")) or text.find("\n\n", start, end) >= 0:
        return None
    for mark in layout.comment:
        if text.find(mark[0], start, end) >= 0 and text.find(f"\n{mark}", start, end) >= 0:
            return None
    if layout.separator is not None and raw is not None:
        return memoryview(raw)[start:end]
    body = text[start:end]
    if layout.separator is not None:
        return memoryview(body.encode())
    body = body.replace("\t", " ")
    while "  " in body:
        body = body.replace("  ", " ")
    return memoryview(body.replace("\n ", "\n").replace(" \n", "\n").strip(" ").encode())


def _arrow(body: memoryview, layout: Layout, names: tuple[str, ...]) -> Any:
    """Arrow table of the rows, whose columns are whole numbers, numbers, text or null; None if ragged."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import csv  # noqa: PLC0415 - heavy import

    keys = [str(i) for i in range(len(names))]
    as_text: dict[str, Any] = {}
    for _ in range(2):
        try:
            table = csv.read_csv(
                pa.BufferReader(pa.py_buffer(body)),
                read_options=csv.ReadOptions(column_names=keys),
                parse_options=csv.ParseOptions(
                    delimiter=layout.separator or " ", quote_char=False, ignore_empty_lines=False
                ),
                convert_options=csv.ConvertOptions(
                    null_values=[""],
                    strings_can_be_null=True,
                    true_values=[],
                    false_values=[],
                    decimal_point=layout.decimal,
                    column_types=as_text,
                ),
            )
        except pa.ArrowException:
            return None
        plain = (pa.int64(), pa.float64(), pa.string(), pa.null())
        odd = [key for key, kind in zip(keys, table.schema.types, strict=True) if kind not in plain]
        if not odd:
            return table
        as_text = dict.fromkeys(odd, pa.string())  # dates and times are judged by the clock
    return None


def _from_arrow(values: Any, layout: Layout, name: str, i: int) -> Column | None:
    """One column; None where only the exact way can judge it."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    if pa.types.is_string(values.type):
        if layout.width == 1:
            return None  # a line of blanks is no cell
        judged = judge(["" if cell is None else cell for cell in values.to_pylist()], layout.decimal)
        text = bool(len(judged.text)) or _grouped(judged.values, layout) is not None
        return None if text else _column(name, judged.values, layout, i, judged.empty, judged.not_a_number)
    if pa.types.is_null(values.type) or (values.null_count and not pa.types.is_float64(values.type)):
        values = values.cast(pa.float64(), safe=False)
    numbers, empty = arrow_numbers(values)
    if numbers.dtype.kind == "i":
        return _column(name, numbers, layout, i, empty, empty[:0])
    if np.isinf(numbers).any():
        return None
    nan = np.setdiff1d(np.flatnonzero(np.isnan(numbers)), empty, assume_unique=True)
    return _column(name, numbers, layout, i, empty, nan)


def arrow_numbers(values: Any) -> tuple[NDArray[Any], Rows]:
    """Return the numbers of an Arrow column and the places of its nulls, which are NaN or NaT.

    From Arrow's buffers: its own ``to_numpy`` imports pandas, a third of a second.
    """
    kind = np.dtype(values.type.to_pandas_dtype())
    numbers = np.empty(len(values), dtype=kind)
    null = np.zeros(len(values), dtype=bool)
    begin = 0
    for chunk in values.chunks:
        here, inside = slice(begin, begin + len(chunk)), slice(chunk.offset, chunk.offset + len(chunk))
        valid, data = chunk.buffers()
        numbers[here] = np.frombuffer(data, dtype=kind)[inside] if len(chunk) else 0
        if chunk.null_count:
            null[here] = np.unpackbits(np.frombuffer(valid, dtype=np.uint8), bitorder="little")[inside] == 0
        begin += len(chunk)
    if null.any():
        numbers[null] = np.nan if kind.kind == "f" else np.datetime64("NaT")
    return numbers, np.flatnonzero(null)


def _column(name: str, values: Any, layout: Layout, i: int, empty: Rows, nan: Rows) -> Column:
    return Column(name, values, layout.units[i] or None, bool(layout.names[i]), empty=empty, not_a_number=nan)


def _content(columns: list[Column], rows: Rows, layout: Layout) -> Content:
    """All columns but those without name and without value (a separator at the line's end)."""
    kept = [column for column in columns if column.named or len(column.empty) < len(rows)]
    remarks = layout.remarks
    if len(kept) < len(columns):
        what = f"{len(columns) - len(kept)} empty column(s) without a name left out"
        remarks = (*remarks, Remark("empty_column", "info", what))
    return Content(tuple(kept), layout.words, rows, layout.sample_rate, remarks)


def _across(text: str, layout: Layout, where: str) -> Content:
    """Return a lone line of numbers as one column."""
    cells = split(text[layout.start :].strip("\n"), layout.separator)
    while not cells[-1]:
        cells.pop()
    downward = replace(layout, separator=None, width=1, names=("",), units=("",), start=0, across=False)
    content = fast("\n".join(cells), downward, ("column_1",))
    if content is None:
        judged = judge(cells, layout.decimal)
        if len(judged.text):
            rows = np.full(len(cells), layout.row, dtype=np.int64)
            raise DataError(text_in_numbers("column_1", cells, judged.text, rows, where))
        column = _column("column_1", judged.values, downward, 0, judged.empty, judged.not_a_number)
        content = _content([column], np.arange(len(cells)), downward)
    remark = Remark("values_across", "info", f"one line of {len(cells)} numbers: read as one column", where)
    return replace(content, rows=None, format=layout.words, remarks=(*content.remarks, remark))


def read_text(loaded: Loaded, variables: Sequence[str] | None = None, decimal: Decimal | None = None) -> Content:
    """Return the columns of a text file, whatever variables are named; Raises as `parse` and ``encoding.decode``."""
    text, remarks = text_of(loaded)
    content = parse(text, loaded.path, loaded, decimal)
    return replace(content, remarks=remarks + content.remarks)


READER = Reader("text", "CSV and other text", ENDINGS, looks_like_text, read_text)
