"""Parquet files: units in the metadata of a field (``unit`` or ``units``) or in its name.

The size of what a column unpacks to stands in the header of each page [1]_; that in the footer may be wrong. So all
page headers are read first, by what the footer says of each column, which is read here: where that contradicts itself,
pyarrow's own way to it ends the process. Lists, maps and binary columns are left out, and not unpacked.

References
----------
.. [1] Apache Parquet, parquet-format 2.11, src/main/thrift/parquet.thrift: PageHeader, FileMetaData; Apache Thrift,
   doc/specs/thrift-compact-protocol.md.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core import batches
from ...core.errors import DataError
from ...core.recording import ClockRate
from ...core.remarks import Remark
from ...core.results import changed
from ...core.show.tables import clean
from ..budget import COLUMNS, PARTS, READ, VALUE, check_count, claim, claim_room
from ..columns import Column, Content, LongColumns, Rows, ahead
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors
from ..text.delimited import arrow_numbers, sum_is_finite, text_in_numbers
from ..text.layout import BLANKS, judge
from ..text.layout import kind as kind_of_cell

if TYPE_CHECKING:
    from pyarrow import ChunkedArray, Field, Table

MAGIC = b"PAR1"
HEADER, LONGEST = 2**9, 2**24  # bytes in which the header of a page ends: usually, and at most
VARINT = rb"[\x80-\xff]{0,4}[\x00-\x7f]"  # of 32 bits
TEXT, WHOLE = (b"[%b]" % bytes(16 * delta + kind for delta in range(1, 16)) for kind in (8, 6))  # heads of fields
# Header of a data page of numbers as it usually is: type, sizes, sum, values, encodings, statistics.
USUAL = re.compile(
    rb"\x15\x00\x15(%b)\x15(%b)(?:\x15%b\x1c|\x2c)\x15(%b)\x15(%b)\x15%b\x15%b" % ((VARINT,) * 7)
    + rb"(?:\x1c(?:%b(?:\x08.{8}|\x04.{4})|%b[\x80-\xff]{0,9}[\x00-\x7f]|[\x11\x12])*\x00)?\x00\x00" % (TEXT, WHOLE),
    re.DOTALL,
)
DEEPEST = 8  # structures and lists within structures
ROW_GROUPS, COLUMN_CHUNKS, META_DATA = 4, 1, 3  # fields of FileMetaData, RowGroup, ColumnChunk
VALUES, PACKED_SIZE, DATA_PAGE, DICTIONARY_PAGE = 5, 7, 9, 11  # fields of ColumnMetaData
FOOTER = 20 * COLUMNS  # entries of a list in the footer: each takes a kilobyte
TEXT_CELL = 128  # bytes of a cell of text while it is judged
FRONT_CODED = 7  # DELTA_BYTE_ARRAY: each text takes over the beginning of the one before
BATCH, BUFFER = 2**17, 2**20  # rows of long columns that are read at once, and bytes of each
AT_ONCE = 2**27  # bytes of such texts that are unpacked at once
UNIT_KEYS = (b"unit", b"units")
RATE_KEYS = (b"sample_rate", b"sample_rate_hz", b"fs")
CLOCK_KEY = b"inertialcal_clock_rate"  # how well the rate of the stamps is known, as JSON


def read_parquet(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return all columns of a Parquet file, whatever variables are named.

    Raises
    ------
    DataError
        If it is damaged, a name appears twice, text stands among numbers, or it is larger than the limits
        of ``files.budget``.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    with as_data_errors(loaded.path, "a Parquet file"):

        def opened() -> Any:
            return pa.OSFile(loaded.path) if isinstance(loaded.data, FileBytes) else pa.BufferReader(loaded.data)

        file = parquet.ParquetFile(opened(), thrift_container_size_limit=FOOTER)
        about = file.metadata
        check_count(about.num_columns, COLUMNS, "columns", loaded.path)
        check_count(about.num_row_groups * about.num_columns, 100 * PARTS, "pieces of columns", loaded.path)
        leaves = [about.schema.column(i) for i in range(about.num_columns)]
        read = [i for i, leaf in enumerate(leaves) if _is_readable(leaf)]
        large = [i for i in read if leaves[i].physical_type != "BYTE_ARRAY"]
        large = large if batches.is_long(VALUE * about.num_rows * len(large)) else []
        groups = _groups(loaded.data)
        slow = _claim(loaded, about, groups, leaves, [i for i in read if i not in large])
        claim_room(loaded.path, loaded.on_disk, VALUE * about.num_rows * len(large), f"{about.num_rows:,} rows")
        _check_pages(loaded, about, groups, large)
        schema = file.schema_arrow
        _refuse_twice(schema.names, loaded.path)
        quick = [leaves[i].path for i in read if i not in slow and i not in large]
        texts = [leaf.path for leaf in leaves if leaf.physical_type == "BYTE_ARRAY" and leaf.path in quick]
        if texts or large:
            file = parquet.ParquetFile(
                opened(),
                metadata=about,
                read_dictionary=texts,
                buffer_size=BUFFER if large else 0,
                pre_buffer=not large,
            )
        table = _flat(file.read(columns=quick))
        columns: list[Column | str] = []
        for field in table.schema:
            columns.append(arrow_column(table.column(0), field, loaded.path))
            table = table.remove_column(0)  # frees its memory
        columns += [_front_coded(file, leaves[i].path, batch, loaded) for i, batch in slow.items()]
        columns += _batch_by_batch(file, [leaves[i].path for i in large], loaded.path)
        order = {leaf.path: i for i, leaf in enumerate(leaves)}
        columns.sort(key=lambda one: order.get(one.name if isinstance(one, Column) else one, 0))
    unread = (leaf.path for i, leaf in enumerate(leaves) if i not in read)
    columns += dict.fromkeys(path.split(".list.")[0].split(".key_value.")[0] for path in unread)
    return _content(columns, _rates_of(schema.metadata), loaded.path)


def contents_of(table: Table, parts: Sequence[range], paths: Sequence[str]) -> Iterator[Content | DataError]:
    """Yield some rows of a table in memory after others, as `read_parquet` returns them of a file each, or why not.

    Columns of numbers are turned into arrays once for all.

    Parameters
    ----------
    table : pyarrow.Table
        Of all.
    parts : sequence of range
        Rows of each.
    paths : sequence of str
        Name of each, for messages.

    Raises
    ------
    DataError
        If a name appears twice; that text stands among numbers, of its rows alone.
    """
    from pyarrow import types  # noqa: PLC0415 - heavy import

    with as_data_errors(paths[0], "a Parquet file"):
        check_count(table.num_columns, COLUMNS, "columns", paths[0])
        _refuse_twice(table.schema.names, paths[0])
        flat = _flat(table)
        whole: dict[int, Column | str] = {
            i: arrow_column(flat.column(i), field, paths[0])
            for i, field in enumerate(flat.schema)
            if types.is_floating(field.type) or (types.is_integer(field.type) and not flat.column(i).null_count)
        }
        for i, field in enumerate(flat.schema):
            if types.is_dictionary(field.type) and (column := _labels(flat.column(i), field)) is not None:
                whole[i] = column
    rates = _rates_of(table.schema.metadata)
    others = [(i, field) for i, field in enumerate(flat.schema) if i not in whole]
    for part, path in zip(parts, paths, strict=True):
        columns = {i: _rows_of(column, part) for i, column in whole.items()}
        try:
            for i, field in others:
                with as_data_errors(path, "a Parquet file"):
                    columns[i] = arrow_column(flat.column(i).slice(part.start, len(part)), field, path)
        except DataError as error:
            yield error
        else:
            yield _content([columns[i] for i in range(len(columns))], rates, path)


def _labels(values: ChunkedArray, field: Field) -> Column | None:
    """Return a column of words, or of whole numbers, each looked at once; None where one is neither or empty."""
    from pyarrow import types  # noqa: PLC0415 - heavy import

    if not types.is_string(field.type.value_type) or values.null_count or values.num_chunks != 1:
        return None
    coded = values.chunk(0)
    cells = [(text or "").strip(BLANKS) for text in coded.dictionary.to_pylist()]
    judged = judge(cells)
    if judged.values.dtype.kind != "i" and any(kind_of_cell(one) != "t" for one in cells):
        return None
    return Column(field.name, judged.values[coded.indices.to_numpy()], _unit_of(field))


def _rows_of(column: Column | str, part: range) -> Column | str:
    """Return some rows of a column of numbers."""
    if isinstance(column, str):
        return column
    values = column.values[part.start : part.stop]
    if column.is_complete:
        return changed(column, values=values)
    gone, nan = (
        rows[slice(*np.searchsorted(rows, (part.start, part.stop)))] - part.start
        for rows in (column.empty, column.not_a_number)
    )
    return replace(column, values=values, empty=gone, not_a_number=nan)


def _rates_of(metadata: dict[bytes, bytes] | None) -> tuple[float | None, ClockRate | None]:
    """Return the sample rate, and how well that of the stamps is known, as the metadata of a file say them."""
    known = metadata or {}
    return sample_rate_of(known), clock_of(known.get(CLOCK_KEY, b""))


def _content(columns: Sequence[Column | str], rates: tuple[float | None, ClockRate | None], path: str) -> Content:
    """Return the content of a file by its columns, and the names of what is no column."""
    kept = tuple([column for column in columns if isinstance(column, Column)])
    remarks: tuple[Remark, ...] = ()
    if len(kept) < len(columns):
        left_out = [name for name in columns if isinstance(name, str)]
        what = f"neither numbers, dates nor text, left out: {', '.join(left_out)[:120]}"
        remarks = (Remark("variables_left_out", "info", what, where=path, count=len(left_out)),)
    rate, clock = rates
    return Content(kept, "Parquet", None, rate, remarks, clock=clock)


def _refuse_twice(names: Sequence[str], path: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise DataError(f"column name {min(twice)!r} appears twice", where=path, code="duplicate_column")


def _flat(table: Table) -> Table:
    """Return a table without structures: a column for each of their fields."""
    from pyarrow import types  # noqa: PLC0415 - heavy import

    while any(types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return table


def _batch_by_batch(file: Any, paths: Sequence[str], path: str) -> list[Column | str]:
    """Return columns of numbers or times, filled a batch at a time: longer ones than memory holds lie on the disk."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    if not paths:
        return []
    long = LongColumns(file.metadata.num_rows)
    left_out: dict[str, None] = {}
    for batch in ahead(file.iter_batches(batch_size=BATCH, columns=list(paths), use_threads=True)):
        table = _flat(pa.Table.from_batches([batch]))
        made = [arrow_column(table.column(i), table.schema.field(i), path) for i in range(table.num_columns)]
        left_out |= dict.fromkeys(one for one in made if isinstance(one, str))
        long.add([one for one in made if isinstance(one, Column)])
    return [*long.columns(), *left_out]


_Struct = dict[int, Any]  # A structure of Thrift: value by number of the field


def _groups(data: bytes) -> list[list[_Struct]]:
    """Return what the footer says of each column, by group of rows: the fields of ColumnMetaData."""
    end = len(data) - 8
    about, _ = _struct(data[end - int.from_bytes(data[end : end + 4], "little") : end], 0)
    return [[chunk[META_DATA] for chunk in group[COLUMN_CHUNKS]] for group in about.get(ROW_GROUPS, [])]


def _check_pages(loaded: Loaded, about: Any, groups: Sequence[Sequence[_Struct]], large: Sequence[int]) -> None:
    """Claim the memory for the largest page of columns that are read a batch at a time."""
    pages = largest = 0
    for i in large:
        for group in groups:
            for page in _pages(loaded.data, group[i]):
                pages += 1
                check_count(pages, 100 * PARTS, "pages", loaded.path)
                largest = max(largest, page.size)
    need = (3 * len(large)) * largest
    claim(loaded.path, loaded.on_disk, need, f"{about.num_rows:,} rows, a page of {largest:,} bytes")


def _is_readable(leaf: Any) -> bool:
    """Whether a column can hold numbers, times or text: no list, no bytes."""
    if leaf.max_repetition_level:
        return False
    return leaf.physical_type not in ("BYTE_ARRAY", "FIXED_LEN_BYTE_ARRAY") or leaf.logical_type.type not in (
        "NONE", "UUID", "INTERVAL",
    )  # fmt: skip


def _claim(
    loaded: Loaded, about: Any, groups: Sequence[Sequence[_Struct]], leaves: Sequence[Any], read: Sequence[int]
) -> dict[int, int]:
    """Claim the memory for columns by their page headers; return those of front-coded text, with rows at once."""
    per_column, other = READ
    held = 0 if isinstance(loaded.data, FileBytes) else len(loaded.data)
    need: float = held + (VALUE * other * about.num_rows if read else 0)
    pages = 0
    slow: dict[int, int] = {}
    for i in read:
        is_text = leaves[i].physical_type == "BYTE_ARRAY"
        for group in groups:
            largest = 0
            for page in _pages(loaded.data, group[i]):
                pages += 1
                check_count(pages, 100 * PARTS, "pages", loaded.path)
                largest = max(largest, page.size)
                need += (TEXT_CELL if is_text else per_column * VALUE) * page.values + (page.size if is_text else 0)
                if is_text and page.encoding == FRONT_CODED:
                    slow[i] = min(slow.get(i, AT_ONCE), max(AT_ONCE // max(page.size, 1), 1))
            what = f"{about.num_rows:,} rows, {len(read)} column(s), a page of {largest:,} bytes"
            claim(loaded.path, loaded.on_disk, need + 2 * largest, what)
    return slow


def _front_coded(file: Any, path: str, batch: int, loaded: Loaded) -> Column | str:
    """One column of front-coded text, whose size shows only when it is unpacked: a few rows at a time."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    chunks, held = [], 0
    for part in file.iter_batches(batch_size=batch, columns=[path]):
        values = part.column(0)
        while pa.types.is_struct(values.type):
            values = values.flatten()[0]
        held += values.nbytes
        claim(loaded.path, loaded.on_disk, len(loaded.data) + 3 * held + AT_ONCE, f"the texts of {path!r}", least=True)
        chunks.append(values)
    kind = chunks[0].type if chunks else pa.string()
    return arrow_column(pa.chunked_array(chunks, kind), pa.field(path, kind), loaded.path)


@dataclass(frozen=True)
class _Page:
    """Header of a page."""

    size: int  # Unpacked [byte]
    packed: int  # As it lies there [byte]
    values: int  # 0 of a dictionary
    encoding: int


def _pages(data: bytes, chunk: _Struct) -> Iterator[_Page]:
    """Headers of the pages of a column in a group of rows."""
    at = min(chunk[DATA_PAGE], chunk.get(DICTIONARY_PAGE, chunk[DATA_PAGE]))
    if at < 0:
        raise ValueError("a page before the file")
    end = at + chunk[PACKED_SIZE]
    found = 0
    while at < end and found < chunk[VALUES]:
        page, at = _header(data, at)
        if min(page.size, page.packed, page.values) < 0 or at + page.packed > len(data):
            raise ValueError("a page that does not fit into the file")
        found += page.values
        yield page
        at += page.packed


def _header(data: bytes, at: int) -> tuple[_Page, int]:
    """Return what the header of a page says, and the place behind it."""
    head = data[at : at + HEADER]
    usual = USUAL.match(head)
    if usual:
        size, packed, values, encoding = usual.groups()
        return _Page(_signed(size), _signed(packed), _signed(values), _signed(encoding)), at + usual.end()
    try:
        fields, length = _struct(head, 0)
    except IndexError:  # it is longer
        head = data[at : at + LONGEST]
        fields, length = _struct(head, 0)
    about = fields.get(5) or fields.get(7) or fields.get(8) or {}
    values = 0 if 7 in fields else about.get(1, 0)
    page = _Page(fields.get(2, -1), fields.get(3, -1), values, about.get(4 if 8 in fields else 2, 0))
    return page, at + length


def _signed(varint: bytes) -> int:
    """Return the number that a zigzag varint of Thrift means."""
    raw = int.from_bytes(varint, "little")  # five bytes at most
    value = raw & 0x7F
    if raw > 0x7F:
        value |= raw >> 1 & 0x3F80 | raw >> 2 & 0x1FC000 | raw >> 3 & 0xFE00000 | raw >> 4 & 0x7F0000000
    return (value >> 1) ^ -(value & 1)


def _struct(data: bytes, at: int, depth: int = 0) -> tuple[_Struct, int]:
    """Return the fields of a structure of Thrift's compact protocol, and the place behind it."""
    fields: _Struct = {}
    number = 0
    while head := data[at]:
        kind, delta = head & 15, head >> 4
        at += 1
        if delta:
            number += delta
        else:
            number, at = _varint(data, at)
            number >>= 1
        if kind in (5, 6, 8):  # nearly all fields: here, as a call takes as long as their work
            value = data[at]
            at += 1
            if value & 0x80:
                value, at = _varint(data, at - 1)
            if kind == 8:
                at += value
            else:
                value = (value >> 1) ^ -(value & 1)
            fields[number] = value
        else:
            fields[number], at = _value(data, at, kind, depth)
    return fields, at + 1


def _value(data: bytes, at: int, kind: int, depth: int) -> tuple[Any, int]:
    """Return a value or list of a type of the compact protocol, and the place behind it; of a text only its length."""
    if depth > DEEPEST:
        raise ValueError("structures that are nested too deeply")
    if kind in (1, 2):  # in the field's own head
        return kind == 1, at
    if kind in (4, 5, 6):
        value, at = _varint(data, at)
        return (value >> 1) ^ -(value & 1), at
    if kind == 12:
        return _struct(data, at, depth + 1)
    if kind in (3, 7):
        return 0, at + (1 if kind == 3 else 8)
    if kind == 8:
        length, at = _varint(data, at)
        return length, at + length
    if kind in (9, 10):
        return _list(data, at, depth + 1)
    raise ValueError(f"type {kind} in a structure")


def _list(data: bytes, at: int, depth: int) -> tuple[list[Any], int]:
    """Return the elements of a list of the compact protocol, and the place behind it."""
    kind, size = data[at] & 15, data[at] >> 4
    size, at = _varint(data, at + 1) if size == 15 else (size, at + 1)
    if size > len(data) - at:
        raise ValueError("a list that does not fit into the file")
    elements = []
    for _ in range(size):
        value, at = _value(data, at, 3 if kind in (1, 2) else kind, depth)
        elements.append(value)
    return elements, at


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """Return a whole number of seven bits a byte, and the place behind it."""
    value = shift = 0
    while data[at] & 0x80:
        value |= (data[at] & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if shift > 63:
            raise ValueError("a number of more than 64 bits")
    return value | data[at] << shift, at + 1


def arrow_column(values: ChunkedArray, field: Field, path: str) -> Column | str:
    """One column, or its name if it is neither numbers, dates nor text."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    kind, unit = values.type, _unit_of(field)
    if pa.types.is_dictionary(kind) and not pa.types.is_string(kind.value_type):
        values, kind = values.cast(kind.value_type), kind.value_type
    if pa.types.is_timestamp(kind):
        stamps, empty = arrow_numbers(values.cast(pa.timestamp("ns")))
        return Column(field.name, stamps, unit, empty=empty)
    if pa.types.is_duration(kind):
        values, unit = values.cast(pa.int64()), kind.unit
    elif pa.types.is_boolean(kind):
        values = values.cast(pa.uint8())
    elif pa.types.is_decimal(kind) or pa.types.is_null(kind):
        values = values.cast(pa.float64(), safe=False)
    elif pa.types.is_string(kind) or pa.types.is_large_string(kind) or pa.types.is_dictionary(kind):
        return _text_column(values, field.name, unit, path)
    elif not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        return str(field.name)
    if values.null_count and not pa.types.is_floating(values.type):
        values = values.cast(pa.float64(), safe=False)
    numbers, empty = arrow_numbers(values)
    if numbers.dtype.kind != "f":
        return Column(field.name, numbers, unit)
    literal = _literal(numbers, empty)
    return Column(field.name, _missing(numbers, literal), unit, empty=empty, not_a_number=literal)


def _unit_of(field: Field) -> str | None:
    metadata = field.metadata or {}
    return next((metadata[key].decode("utf-8", "replace") for key in UNIT_KEYS if key in metadata), None)


def _literal(numbers: NDArray[Any], empty: Rows) -> Rows:
    """Return the places of NaN and infinity that are no null."""
    if not len(empty) and sum_is_finite(numbers):
        return empty
    return np.setdiff1d(np.flatnonzero(~np.isfinite(numbers)), empty, assume_unique=True)


def _missing(numbers: NDArray[Any], at: Rows) -> NDArray[Any]:
    """Return numbers with NaN in some places; Arrow's own memory stays as it is."""
    if len(at):
        numbers = numbers.copy()
        numbers[at] = np.nan
    return numbers


def _text_column(values: Any, name: str, unit: str | None, path: str) -> Column:
    """Text, or numbers that were stored as text."""
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    if pa.types.is_dictionary(values.type):  # each text once, however often it stands in the column
        cells = []
        for chunk in values.chunks:
            texts = [(text or "").strip(BLANKS) for text in chunk.dictionary.to_pylist()]
            cells += ["" if i is None else texts[i] for i in chunk.indices.to_pylist()]
    else:
        cells = ["" if cell is None else cell for cell in values.to_pylist()]
    judged = judge(cells)
    if len(judged.text):
        rows = np.arange(1, len(cells) + 1)
        raise DataError(text_in_numbers(name, cells, judged.text, rows, path))
    return Column(name, judged.values, unit, empty=judged.empty, not_a_number=judged.not_a_number)


def sample_rate_of(metadata: dict[bytes, bytes]) -> float | None:
    """Sample rate in the metadata of the file [Hz]."""
    for key in RATE_KEYS:
        try:
            value = float(metadata[key])
        except (KeyError, ValueError):
            continue
        if np.isfinite(value) and value > 0.0:
            return value
    return None


def clock_text(clock: ClockRate) -> bytes:
    """Return what `clock_of` reads."""
    return json.dumps({name: one for name, one in asdict(clock).items() if one != math.inf}).encode()


def clock_of(text: bytes) -> ClockRate | None:
    """Return how well the rate of stamps is known, as the metadata of a file say it; None where they do not."""
    try:
        said = json.loads(text)
        clock = ClockRate(float(said["u"]), float(said.get("dof", math.inf)), clean(str(said.get("source", ""))))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None
    return clock if 0.0 < clock.u < 1.0 and clock.dof > 0.0 else None


def clock_in(path: str | os.PathLike[str]) -> ClockRate | None:
    """Return what the footer of a Parquet file says of its clock, nothing else of it read; None of any other file.

    Behind the key of a pair stands its value: the head of a text, its length and itself.
    """
    try:
        with Path(path).open("rb") as stream:
            stream.seek(-8, os.SEEK_END)
            length, magic = int.from_bytes(stream.read(4), "little"), stream.read(4)
            if magic != MAGIC or length > LONGEST:
                return None
            stream.seek(-8 - length, os.SEEK_END)
            footer = stream.read(length)
        _, key, behind = footer.partition(CLOCK_KEY + b"\x18")
        size, at = _varint(behind, 0) if key else (0, 0)
    except (OSError, IndexError, ValueError):
        return None
    return clock_of(behind[at : at + size])


READER = Reader("parquet", "Parquet", (".parquet",), lambda data, path: data.startswith(MAGIC), read_parquet, True)
