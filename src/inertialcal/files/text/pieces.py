"""Separated text of any length: what is regular is read a piece at a time, the rest whole.

Of a text in pieces, one is read and hashed, one parsed and one stored at a time. If any piece is not regular, or holds
words, the text is read whole; one that is too long for that is refused with what is wrong in it.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, cast

import numpy as np

from ...core.errors import DataError, InertialcalError, Problem
from ...core.remarks import Remark
from ..budget import LINE, VALUE, claim, claim_room
from ..columns import Column, Content, LongColumns, ahead
from ..reader import Reader
from ..source import FileBytes, Loaded, whole
from .delimited import (
    ALIKE,
    SHOWN,
    arrow_table,
    cell_columns,
    column_names,
    content_of,
    fast,
    from_arrow,
    instants_from_arrow,
    line_ends,
    other_signs,
    parse,
    regular_rows,
    text_in_numbers,
    whole_rows,
)
from .layout import BLANKS, SAMPLE, Decimal, Layout, decode, holds_control, kind, looks_like_text, sniff, text_of
from .settings_head import MARKED

ENDINGS = ("", ".asc", ".csv", ".dat", ".log", ".mat", ".prn", ".tab", ".tsv", ".txt")  # that text usually has
TOO_LARGE = "too_large"
SHORT = 2**20  # bytes of a text that is read whole: pieces of it would save nothing
HEAD = 2**16  # bytes that tell the layout of a text in pieces, if they hold the lines for it; and of its last rows
PIECE = 2**23  # bytes of a long file that are read together
COUNTED = 2**20  # bytes at the beginning whose lines are counted
SPARE = 0.02  # of the rows of a file, more than its beginning makes likely
ENOUGH = 32  # bytes of memory for each byte of a piece and its cells, at most


def read_text(
    loaded: Loaded, variables: Sequence[str] | None = None, decimal: Decimal | None = None, skip: int = 0
) -> Content:
    """Return the columns of a text file, whatever variables are named; Raises as `parse` and ``layout.decode``."""
    long = isinstance(loaded.data, FileBytes)
    stacked = MARKED.match(bytes(loaded.data[:SAMPLE]).decode("latin-1"))  # channels may stand below each other
    if not (skip or stacked) and (long or len(loaded.data) > SHORT):
        with suppress(_IrregularError):
            return _piece_by_piece(loaded, decimal)
    return (_read_long if long else _read_whole)(loaded, decimal, skip)


def _read_whole(loaded: Loaded, decimal: Decimal | None, skip: int) -> Content:
    """Return the columns of a text in memory; Raises as `read_text`."""
    text, remarks = text_of(loaded)
    content = parse(text, loaded.path, loaded, decimal, skip)
    return replace(content, remarks=remarks + content.remarks)


def _read_long(loaded: Loaded, decimal: Decimal | None, skip: int) -> Content:
    """Return the columns of a long text that is not regular; one that is too long is refused with what is wrong in it.

    Raises
    ------
    DataError
        As `read_text`; ``ragged_row``, ``text_in_numbers`` with ``file:row`` also where the whole takes too much.
    """
    try:
        return _read_whole(whole(loaded), decimal, skip)
    except DataError as error:
        if error.problems[0].code != TOO_LARGE or skip:
            raise
        found = _found_in_pieces(loaded, decimal)
        if not found:
            raise
        raise DataError(found) from None


def _found_in_pieces(loaded: Loaded, decimal: Decimal | None) -> list[Problem]:
    """Return what is wrong in the rows of a long text; nothing where pieces of lines do not show it."""
    head = loaded.data[:PIECE]
    try:
        layout = sniff(decode(head[: head.rfind(b"\n") + 1], loaded.path)[0], loaded.path, decimal)
    except InertialcalError:
        return []
    names, row = column_names(layout, loaded.path), 1
    numbers, words = [0] * layout.width, [0] * layout.width
    first: list[dict[int, str]] = [{} for _ in names]  # words of each column by their row
    for piece in _pieces(loaded):
        text = bytes(piece).decode("utf-8", "replace").replace("\r\n", "\n").replace("\r", "\n")
        below = replace(layout, start=layout.start if row == 1 else 0, row=layout.row if row == 1 else row)
        row += text.count("\n")
        text = whole_rows(text, replace(below, start=-1), loaded.path)[0] if not text.endswith("\n") else text
        quick = fast(text, below, names)
        if quick is not None and all(one.is_number for one in quick.columns):
            for one in quick.columns:
                numbers[names.index(one.name)] += len(one.values) - len(one.empty) - len(one.not_a_number)
            continue
        try:
            rows, cells = cell_columns(text, below, loaded.path)
        except DataError as error:
            return list(error.problems)
        for i, column in enumerate(cells):
            groups = np.array([kind(cell.strip(BLANKS), layout.decimal) for cell in column], dtype="U1")
            at = np.flatnonzero(groups == "t")
            numbers[i] += int(np.count_nonzero((groups == "i") | (groups == "f")))
            words[i] += len(at)
            first[i] |= {int(rows[k]): column[k] for k in at[: max(SHOWN - len(first[i]), 0)].tolist()}
    return [
        text_in_numbers(
            name, [*first[i].values()], np.arange(len(first[i])), np.array([*first[i]]), loaded.path, words[i]
        )
        for i, (name, bad) in enumerate(zip(names, first, strict=True))
        if 0 < words[i] <= numbers[i]
    ]


class _IrregularError(Exception):
    """A text that only its whole can be judged of."""


def _piece_by_piece(loaded: Loaded, decimal: Decimal | None) -> Content:
    """Return the columns of a long text; Raises _IrregularError, and DataError where names appear twice."""
    first = next(_pieces(loaded), memoryview(b""))
    begin = _beginning(first, loaded.path, decimal)
    layout, remarks = begin.layout, begin.remarks
    names = column_names(layout, loaded.path)
    columns, cut = _filled(loaded, begin, names, _claimed_rows(loaded, layout, first))
    count = len(columns[0].values)
    found = content_of(columns, range(layout.row, layout.row + count), layout)
    return replace(found, remarks=(*remarks, *found.remarks, *cut))


@dataclass(frozen=True)
class _Beginning:
    """The first lines of a text that is read in pieces."""

    layout: Layout
    rows: bytes  # of data
    size: int  # bytes, with what stands above the rows
    remarks: tuple[Remark, ...]  # what reading them brought up


def _beginning(first: memoryview, path: str, decimal: Decimal | None) -> _Beginning:
    """Return a few lines of the first piece if there are enough of them to tell the layout, else all of it.

    Raises _IrregularError.
    """
    for size in (bytes(first[:HEAD]).rfind(b"\n") + 1, len(first)):
        head = bytes(first[:size])
        try:
            text, remarks = decode(head, path)
            layout = sniff(text, path, decimal)
        except InertialcalError:
            continue
        unsure = layout.across or (layout.decimal == "," and decimal is None)
        if not unsure and not holds_control(head) and text.count("\n", layout.start) >= SAMPLE:
            return _Beginning(layout, text[layout.start :].encode(), size, remarks)
    raise _IrregularError


def _claimed_rows(loaded: Loaded, layout: Layout, first: memoryview) -> int:
    """Return about how many rows a text has, and claim the memory and the room for them.

    Raises
    ------
    DataError
        ``too_large``.
    """
    size, where = len(loaded.data), loaded.path
    some = first[:COUNTED]
    rows = int((1 + line_ends(some)) * size / len(some) * (1.0 + SPARE))
    if isinstance(loaded.data, FileBytes):
        claim(where, loaded.on_disk, ENOUGH * min(PIECE, size), f"pieces of {PIECE:,} bytes")
        claim_room(where, loaded.on_disk, VALUE * rows * layout.width, f"{rows:,} rows of {layout.width} cells")
        return rows
    try:  # and units and clock are found
        claim(where, loaded.on_disk, size + ENOUGH * min(PIECE, size) + VALUE * rows * (layout.width + 8), "pieces")
    except DataError:  # the whole may take less
        raise _IrregularError from None
    return rows


def _filled(
    loaded: Loaded, begin: _Beginning, names: tuple[str, ...], rows: int
) -> tuple[tuple[Column, ...], tuple[Remark, ...]]:
    """Return the columns, filled a piece at a time, and the remark on a last row that is cut off.

    Twice where one is whole numbers in its first pieces only. Raises _IrregularError.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    layout, known = begin.layout, dict[str, Any]()
    keys = [str(i) for i in range(len(names))]
    while True:
        long = LongColumns(rows)
        kinds: dict[str, set[Any]] = {key: set() for key in keys}
        cut: tuple[Remark, ...] = ()
        several = len(loaded.data) > PIECE  # then one is read, and one parsed, while one is stored
        bodies = ahead(_bodies(loaded, begin)) if several else _bodies(loaded, begin)
        every = _tables(bodies, layout, names, known)
        with closing(ahead(every) if several else every) as tables:
            for table, incomplete in tables:
                cut = incomplete
                if table is None:
                    continue
                of_piece = dict(zip(keys, table.schema.types, strict=True))
                dates = [key for key, kind in of_piece.items() if kind == pa.string()]  # which are text for Arrow
                if dates and (len(dates) > 1 or not isinstance(loaded.data, FileBytes)):
                    raise _IrregularError
                for key, kind in of_piece.items():
                    kinds[key].add(kind)
                for batch in filter(len, table.to_batches()):
                    part = pa.Table.from_batches([batch])
                    made = [
                        (instants_from_arrow if key in dates else from_arrow)(part.column(i), layout, names[i], i)
                        for i, key in enumerate(keys)
                    ]
                    if None in made:
                        raise _IrregularError
                    long.add(cast("list[Column]", made))
        if not any({pa.int64(), pa.float64()} <= seen for seen in kinds.values()):
            return long.columns(), cut


_Body = tuple[memoryview, tuple[Remark, ...]]  # rows, and the remark on one that is cut off


def _tables(
    bodies: Iterator[_Body], layout: Layout, names: tuple[str, ...], known: dict[str, Any]
) -> Generator[tuple[Any, tuple[Remark, ...]]]:
    """Yield Arrow's table of each piece, and the remark on a last row that is cut off; Raises _IrregularError.

    ``known``: types of columns by their number; those that are certain from now on are added.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    for rows, cut in bodies:
        if not rows:  # the last piece was blank, or one row that was cut off
            yield None, cut
            return
        body = _regular(rows, layout) if layout.separator is None else rows
        table = arrow_table(body, layout, names, known)
        if table is None:
            raise _IrregularError
        if body is rows and not _is_plain(table, rows):
            _regular(rows, layout)
        known |= {name: kind for name, kind in zip(table.column_names, table.schema.types, strict=True)
                  if kind in (pa.float64(), pa.string())}  # fmt: skip
        yield table, cut


def _is_plain(table: Any, rows: memoryview) -> bool:
    """Whether Arrow took all cells of rows for numbers, none of them for one because it is hexadecimal."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    kinds = set(table.schema.types)
    whole = bytes(rows) if pa.int64() in kinds else b""
    return kinds <= {pa.float64(), pa.int64()} and b"x" not in whole and b"X" not in whole


def _regular(rows: memoryview, layout: Layout) -> memoryview:
    """Return rows for Arrow that hold more than plain numbers; Raises _IrregularError."""
    others = other_signs(rows, layout)
    comma = layout.decimal != "," and layout.separator != "," and b"," in others  # of a file with decimal commas?
    if comma or not others.isascii() or holds_control(others):
        raise _IrregularError
    body = regular_rows(rows, layout, others)
    if body is None:
        raise _IrregularError
    return body


def _bodies(loaded: Loaded, begin: _Beginning) -> Generator[_Body]:
    """Yield the rows of data of each piece; Raises _IrregularError."""
    layout, done = begin.layout, 0
    held = not isinstance(loaded.data, FileBytes)
    returns = held and b"\r" in loaded.data
    pieces: Iterator[bytes | memoryview] = chain([begin.rows], _pieces(loaded, begin.size))
    for piece in pieces:
        rows = memoryview(piece)
        done += len(piece) if done else begin.size
        last = done == len(loaded.data)
        if not rows:
            raise _IrregularError
        if returns if held else b"\r" in cast("bytes", rows.obj):
            rows = _in_lines(rows)
        cut: tuple[Remark, ...] = ()
        if last:
            rows, cut = _complete(rows, loaded, layout)
        elif bytes(rows[-2:]) in (b"\n", b"\n\n"):  # a blank line, which Arrow leaves out here
            raise _IrregularError
        else:
            rows = rows[:-1]
        yield rows, cut
    if done != len(loaded.data):
        raise _IrregularError


def _complete(rows: memoryview, loaded: Loaded, layout: Layout) -> tuple[memoryview, tuple[Remark, ...]]:
    """Return the last rows of a text as `whole_rows`, without blanks behind them; Raises _IrregularError."""
    rows = rows[: _end(rows, b"\x1a")]
    near = max(len(rows) - LINE, 0)
    at = near + bytes(rows[near:]).rfind(b"\n") + 1
    if near and at == near:
        raise _IrregularError
    cut: tuple[Remark, ...] = ()
    end = bytes(rows[at:])
    if not end.isascii():
        raise _IrregularError
    if end:
        tail = bytes(_in_lines(memoryview(loaded.data[max(len(loaded.data) - HEAD, 0) :])))
        above = [line.decode("ascii", "replace") for line in tail.rsplit(b"\n", ALIKE + 1)[1:-1]]
        last = "\n".join([*above, end.decode()])
        _, cut = whole_rows(last, replace(layout, start=-1), loaded.path)
        if cut:  # seldom: only then lines are counted
            count = sum(line_ends(_in_lines(piece)) for piece in _pieces(loaded))
            cut = whole_rows(last, replace(layout, start=-1), loaded.path, count - len(above))[1]
            rows = rows[:at]
    return rows[: _end(rows, b"\n ")], cut


def _in_lines(rows: memoryview) -> memoryview:
    return memoryview(bytes(rows).replace(b"\r\n", b"\n").replace(b"\r", b"\n"))


def _end(rows: memoryview, signs: bytes) -> int:
    """Return how many bytes there are without some at the end."""
    end = len(rows)
    while end and rows[end - 1] in signs:
        end -= 1
    return end


def _pieces(loaded: Loaded, at: int = 0) -> Iterator[memoryview]:
    """Yield the bytes of a file from a place on, in pieces of whole lines, as far as there are lines."""
    held = not isinstance(loaded.data, FileBytes)
    while at < len(loaded.data):
        piece = loaded.data if held else loaded.data[at : at + PIECE]
        first = at if held else 0
        stop = min(first + PIECE, len(piece))
        if at - first + stop < len(loaded.data):
            stop = piece.rfind(b"\n", first, stop) + 1
        if stop <= first:
            return
        yield memoryview(piece)[first:stop]
        at += stop - first


READER = Reader("text", "CSV and other text", ENDINGS, looks_like_text, read_text, True)
