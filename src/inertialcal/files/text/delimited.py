"""Separated text: CSV, tabs, semicolons, blanks; with or without header; decimal point or comma.

A regular file goes through Arrow's reader; whatever that does not take as plain numbers goes cell by cell,
which is slower and knows the row of each problem. Both give the same columns.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, Problem
from ...core.remarks import Remark
from ..budget import VALUE, claim
from ..columns import Column, Content, Rows, no_rows
from ..source import Loaded
from ..time.stamps import EARLIEST, ISO, LATEST
from .grouped import (
    CODE,
    can_be_either,
    commas,
    grouped_cell,
    grouped_column,
    grouped_row,
    problem,
    shows_groups,
    without_groups,
)
from .headers import heading
from .layout import (
    BLANKS,
    CELL,
    CELL_BYTES,
    PLAIN,
    Decimal,
    Layout,
    is_blank,
    judge,
    kind,
    sniff,
    split,
    without_first,
    without_signs,
)
from .printed import as_table

if TYPE_CHECKING:
    from pyarrow import ChunkedArray as ArrowColumn
    from pyarrow import Table as ArrowTable

SHOWN = 60  # characters of a cell in a message
ALIKE = 20  # rows above the last that show with how many digits its last number was to be written
BLOCK = 2**20  # bytes that are looked at together: a cache holds them
AT_ONCE = 2**22  # bytes that Arrow parses at once
LINE_END = ord("\n")


def parse(
    text: str, where: str, loaded: Loaded | None = None, decimal: Decimal | None = None, skip: int = 0
) -> Content:
    r"""Return the columns of a text with ``\n`` line ends.

    Parameters
    ----------
    text, where : str
        The text, and its file.
    loaded : Loaded, optional
        The file that it is the content of.
    decimal : {".", ","}, optional
        Its decimal sign, where that was stated.
    skip : int
        Lines before the table, where that was stated.

    Raises
    ------
    DataError
        If it has no row of data, rows differ in width, a name appears twice, or text stands among numbers;
        each with ``file:row``.
    """
    text = without_first(text, skip)
    printed = as_table(text, where)
    text, sign = without_signs(text if printed is None else printed.text)
    layout = sniff(text, where, decimal)
    if sign:
        what = f"every line begins with {sign!r}, rows too: read without it"
        layout = replace(layout, remarks=(Remark("rows_as_comments", "info", what, where), *layout.remarks))
    if printed is not None:
        units = (*printed.units, *layout.units[len(printed.units) :])
        names = printed.names if len(printed.names) == layout.width else layout.names
        layout = replace(layout, names=names, units=units, remarks=(*printed.remarks, *layout.remarks))
    if layout.across:
        return _across(text, layout, where)
    names = column_names(layout, where)
    raw = b"" if loaded is None else loaded.data
    same = (
        not (skip or sign) and printed is None and raw.isascii() and b"\r" not in raw and len(raw) >= len(text)
    )  # then the text needs no copy for Arrow
    text, cut = whole_rows(text, layout, where)
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


def whole_rows(text: str, layout: Layout, where: str, above: int = 0) -> tuple[str, tuple[Remark, ...]]:
    """Return the text without a last row that was not written to its end, with the remark that says so.

    ``above``: lines of the file above the text.
    """
    begin = text.rfind("\n") + 1
    last = text[begin:]
    if begin <= layout.start or is_blank(last, layout.separator) or last.lstrip().startswith(layout.comment):
        return text, ()
    cells = len(split(last, layout.separator))
    short = f"{cells} of {layout.width} cells"
    if cells >= layout.width:
        of_above = {_digits(line, layout) for line in text[: max(begin - 1, 0)].rsplit("\n", ALIKE)[1:]}
        above_alike = len(of_above) == 1 and text.count("\n", max(layout.start, 0)) >= ALIKE
        if not above_alike or _digits(last, layout) >= max(of_above):
            return text, ()
        short = "no line end, and its last number has fewer digits than the others"
    what = (
        f"the last row is incomplete ({short}): left out. The file is still being written, or the recording was "
        "interrupted"
    )
    where = f"{where}:{above + text.count(chr(10)) + 1}"
    return text[: max(begin - 1, 0)], (
        Remark("row_cut_off", "warning", what, where, do="Read it again when it is complete"),
    )


def _digits(line: str, layout: Layout) -> int:
    """Return how many characters the last number of a line has behind its decimal sign; 0 without one."""
    _, sign, behind = split(line, layout.separator)[-1].strip().partition(layout.decimal)
    return len(behind) if sign else 0


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
    end = len(text)
    while end > layout.start and text[end - 1] in "\n ":
        end -= 1
    rows = memoryview(text[layout.start : end].encode() if raw is None else raw)
    rows = rows if raw is None else rows[layout.start : end]
    body = regular_rows(rows, layout, other_signs(rows, layout))
    table = None if body is None else arrow_table(body, layout, names)
    if table is None:
        return None
    length, columns = len(table), []
    del body, rows
    for i, name in enumerate(names):
        column = from_arrow(table.column(0), layout, name, i)
        if column is None:
            return None
        columns.append(column)
        table = table.remove_column(0)  # frees its memory
    return content_of(columns, range(layout.row, layout.row + length), layout)


def line_ends(body: bytes | memoryview) -> int:
    """Return how many lines end in a text."""
    signs = np.frombuffer(body, dtype=np.uint8)
    return sum(int(np.count_nonzero(signs[at : at + BLOCK] == LINE_END)) for at in range(0, len(signs), BLOCK))


def exact(text: str, layout: Layout, names: tuple[str, ...], where: str) -> Content:
    """Columns cell by cell, with the row of each problem.

    Raises
    ------
    DataError
        If rows differ in width, or text stands among numbers.
    """
    again = header_again(text, layout)
    remarks: tuple[Remark, ...] = () if again is None or not again[1] else (_header_remark(f"{where}:{again[0]}"),)
    if again is not None and not again[1]:
        raise header_repeated(f"{where}:{again[0]}")
    rows, cells = cell_columns(text, layout, where)
    columns, problems = [], []
    sure = any(shows_groups(one, layout.decimal) for one in cells)
    for i, name in enumerate(names):
        judged = judge(cells[i], layout.decimal)
        if len(judged.text) or judged.values.dtype.kind == "O":
            whole = sure or heading(name, layout.units[i] or None).unit == "count"
            plain = without_groups(cells[i], layout.decimal, CELL[layout.decimal].fullmatch, whole)
            if plain is not cells[i]:
                judged = judge(plain, layout.decimal)
                remarks += () if sure else (_grouped_remark(name, cells[i], plain, where),)
        if len(judged.text):
            problems.append(text_in_numbers(name, cells[i], judged.text, rows, where))
        elif (at := _grouped(judged.values, layout)) is not None:
            problems.append(problem(name, cells[i][at], f"{where}:{rows[at]}", certain=True))
        columns.append(_column(name, judged.values, layout, i, judged.empty, judged.not_a_number))
    if problems and all(kind(one[0].strip(BLANKS), layout.decimal) == "t" for one in cells if one):
        do = f"If this row is the header, and what stands above it a title: --skip {int(rows[0]) - 1}"
        problems = [replace(one, do=do) if one.code == "text_in_numbers" else one for one in problems]
    if problems:
        raise DataError(problems)
    found = content_of(columns, rows, layout)
    return replace(found, remarks=(*found.remarks, *remarks))


def _grouped_remark(name: str, cells: Sequence[str], plain: Sequence[str], where: str) -> Remark:
    """Return the remark on a column of counts whose digits are grouped."""
    changed = [(cell, one) for cell, one in zip(cells, plain, strict=True) if cell != one]
    (cell, one), count = changed[0], len(changed)
    return Remark("grouped_digits", "info", f"{name!r} is in counts: {cell} is {one}", where=where, count=count)


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


def text_in_numbers(
    name: str, cells: Sequence[str], at: Rows, rows: Rows, where: str, count: int | None = None
) -> Problem:
    """Return the problem of text in a number column, at its first place; of grouped digits, where there are some.

    ``count``: how many such cells there are, where not all are given.
    """
    count = len(at) if count is None else count
    grouped = grouped_cell([cells[int(i)] for i in at])
    if grouped is not None:
        place = int(at[grouped])
        return problem(name, cells[place], f"{where}:{rows[place]}", certain=True)
    first = cells[int(at[0])].strip()
    shown = first if len(first) <= SHOWN else first[:SHOWN] + "..."
    more = f" ({count} such cells)" if count > 1 else ""
    return Problem(
        f"text {shown!r} in number column {name!r}{more}",
        where=f"{where}:{rows[int(at[0])]}",
        do="Correct the cell, or leave it empty if the value is missing",
        code="text_in_numbers",
    )


def other_signs(body: bytes | memoryview, layout: Layout) -> bytes:
    """Return what rows hold besides plain numbers, separators and line ends; of most files nothing."""
    usual = (PLAIN + "\n" + layout.decimal + (layout.separator or BLANKS)).encode()
    view = memoryview(body)
    return b"".join(bytes(view[at : at + BLOCK]).translate(None, usual) for at in range(0, len(view), BLOCK))


def regular_rows(body: bytes | memoryview, layout: Layout, others: bytes) -> memoryview | None:
    """Return rows of data for Arrow, without quotes and comments; None where there are some.

    ``others``: what `other_signs` says of them.
    """
    if any(sign in others for sign in (b'"', b"x", b"X")):  # x: Arrow reads 0x1F as a number
        return None
    marks = [mark.encode() for mark in layout.comment if mark[0].encode() in others]
    if marks and re.search(rb"(?:\A|\n)(?:" + b"|".join(map(re.escape, marks)) + b")", body):
        return None
    if layout.separator is not None:
        return memoryview(body)
    if _holds_blank_line(body):  # before blanks are taken off
        return None
    squeezed = bytes(body).replace(b"\t", b" ")
    while b"  " in squeezed:
        squeezed = squeezed.replace(b"  ", b" ")
    return memoryview(squeezed.replace(b"\n ", b"\n").replace(b" \n", b"\n").strip(b" "))


def _holds_blank_line(body: bytes | memoryview) -> bool:
    return re.search(rb"(?:\A|\n)\n", body) is not None


def arrow_table(
    body: memoryview, layout: Layout, names: tuple[str, ...], kinds: Mapping[str, Any] | None = None
) -> ArrowTable | None:
    """Arrow table of the rows, whose columns are whole numbers, numbers, text or null; None if ragged, or a row blank.

    ``kinds``: types of columns, by their number from 0, that are known already. The last row has no line end.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import csv  # noqa: PLC0415 - heavy import

    keys = [str(i) for i in range(len(names))]
    as_text: dict[str, Any] = dict(kinds or {})
    for _ in range(2):
        try:
            table = csv.read_csv(
                pa.BufferReader(pa.py_buffer(body)),
                read_options=csv.ReadOptions(column_names=keys, block_size=AT_ONCE),
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
            blank = all(column.null_count for column in table.columns) and _holds_blank_line(body)
            return None if blank else table
        as_text |= dict.fromkeys(odd, pa.string())  # dates and times are judged by the clock
    return None


def from_arrow(values: ArrowColumn, layout: Layout, name: str, i: int) -> Column | None:
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
    if not len(empty) and sum_is_finite(numbers):
        return _column(name, numbers, layout, i, empty, empty)
    if np.isinf(numbers).any():
        return None
    nan = np.setdiff1d(np.flatnonzero(np.isnan(numbers)), empty, assume_unique=True)
    return _column(name, numbers, layout, i, empty, nan)


def instants_from_arrow(values: ArrowColumn, layout: Layout, name: str, i: int) -> Column | None:
    """Return a column of dates that may be the time of a file; None where one cell is none, or only some say a zone."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    import pyarrow.compute as pc  # noqa: PLC0415 - heavy import

    timed = i == 0 or heading(name, layout.units[i] or None).quantity == "time"
    every = f"^(?:{ISO.pattern})$"
    if not timed or values.null_count or not pc.all(pc.match_substring_regex(values, every)).as_py():
        return None
    naive = not pc.any(pc.match_substring_regex(values, r"(?:Z|UTC|[+-][0-9]{2}:?[0-9]{2})$")).as_py()
    try:
        found = values.cast(pa.timestamp("ns") if naive else pa.timestamp("ns", "UTC"))
    except pa.ArrowInvalid:  # no such day, a decimal comma, a zone in some cells only
        return None
    stamps = np.concatenate([np.frombuffer(one.buffers()[1], "datetime64[ns]")[one.offset : one.offset + len(one)]
                             for one in found.chunks])  # fmt: skip
    if not np.datetime64(EARLIEST, "ns") <= stamps.min() <= stamps.max() < np.datetime64(LATEST, "ns"):
        return None
    return replace(_column(name, stamps, layout, i, no_rows(), no_rows()), naive=naive)


def arrow_numbers(values: Any) -> tuple[NDArray[Any], Rows]:
    """Return the numbers of an Arrow column and the places of its nulls, which are NaN or NaT.

    From Arrow's buffers: its own ``to_numpy`` imports pandas, a third of a second. Of one piece without nulls they are
    Arrow's own memory, read-only.
    """
    kind = np.dtype(values.type.to_pandas_dtype())
    if values.num_chunks == 1 and len(values) and not values.null_count:
        (only,) = values.chunks
        return np.frombuffer(only.buffers()[1], dtype=kind)[only.offset : only.offset + len(only)], no_rows()
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


def content_of(columns: Sequence[Column], rows: Rows | range, layout: Layout) -> Content:
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
        content = content_of([column], np.arange(len(cells)), downward)
    remark = Remark("values_across", "info", f"one line of {len(cells)} numbers: read as one column", where)
    return replace(content, rows=None, format=layout.words, remarks=(*content.remarks, remark))


def sum_is_finite(numbers: NDArray[Any]) -> bool:
    """Return whether the sum is finite, and so each number: one pass. False decides nothing: sums may overflow."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(numbers.sum()))
