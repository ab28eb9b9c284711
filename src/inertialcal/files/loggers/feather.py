"""Arrow files (Feather) and streams: units in the metadata of a field, as in Parquet.

A file is a stream between two marks, with an index at its end: where the end is missing, the stream is read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ...core.errors import DataError
from ...core.remarks import Remark
from ..apart import apart
from ..binary.parquet import arrow_column, sample_rate_of
from ..budget import COLUMNS, PARTS, VALUE, check_count, claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors
from .topics import left_out, torn

MAGIC, OLD, STREAM = b"ARROW1", b"FEA1", b"\xff\xff\xff\xff"
START = 8  # byte at which the stream in a file begins
TEXT_CELL = 128  # bytes of a cell of text while it is judged


def read_feather(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return all columns, whatever variables are named.

    Raises
    ------
    DataError
        As ``read_parquet``.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import

    path = loaded.path
    with as_data_errors(path, "an Arrow file"):
        schema, batches, ends = _opened(loaded, pa)
        check_count(len(schema), COLUMNS, "columns", path)
        twice = [name for name, count in Counter(schema.names).items() if count > 1]
        if twice:
            raise DataError(f"column name {min(twice)!r} appears twice", where=path, code="duplicate_column")
        sizes = [batch.num_rows for batch in batches()]
        remarks: tuple[Remark, ...] = ends()
        rows = sum(sizes)
        check_count(len(sizes), 100 * PARTS, "batches", path)
        texts = [name for name, kind in zip(schema.names, schema.types, strict=True) if not _is_number(kind, pa)]
        held = 0 if isinstance(loaded.data, FileBytes) else len(loaded.data)
        need = held + 3 * VALUE * max(sizes, default=0) * len(schema) + TEXT_CELL * rows * len(texts)
        claim(path, loaded.on_disk, need, f"{rows:,} rows")
        claim_room(path, loaded.on_disk, VALUE * rows * len(schema), f"{rows:,} rows")
        long = LongColumns(rows)
        gone = dict.fromkeys(name for name in texts if not _is_text(schema.field(name).type, pa))
        numbers = [name for name in schema.names if name not in texts]
        held_texts: dict[str, list[Any]] = {name: [] for name in texts if name not in gone}
        for batch in batches():
            table = pa.Table.from_batches([batch])
            made = [arrow_column(table.column(name), schema.field(name), path) for name in numbers]
            gone |= dict.fromkeys(one for one in made if isinstance(one, str))
            if made:
                long.add([one for one in made if isinstance(one, Column)])
            for name in held_texts:
                held_texts[name] += table.column(name).chunks
        columns = list(long.columns())
        for name, parts in held_texts.items():
            one = arrow_column(pa.chunked_array(parts, schema.field(name).type), schema.field(name), path)
            columns += [one] if isinstance(one, Column) else []
        columns.sort(key=lambda one: schema.names.index(one.name))
        rate = sample_rate_of(schema.metadata or {})
    if remarks and not any(len(one.values) for one in columns):
        raise DataError(remarks[0].what, where=path, why="no rows before that are whole", code="damaged_file")
    return Content(tuple(columns), "Arrow (Feather)", None, rate, (*left_out(list(gone), path), *remarks))


def _is_number(kind: Any, pa: Any) -> bool:
    types = pa.types
    return bool(
        types.is_integer(kind) or types.is_floating(kind) or types.is_boolean(kind) or types.is_timestamp(kind)
        or types.is_duration(kind) or types.is_decimal(kind) or types.is_null(kind)
    )  # fmt: skip


def _is_text(kind: Any, pa: Any) -> bool:
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _opened(loaded: Loaded, pa: Any) -> tuple[Any, Callable[[], Iterator[Any]], Callable[[], tuple[Remark, ...]]]:
    """Return schema, a function that yields the batches that are whole, and one that says where they end."""
    from pyarrow import feather, ipc  # noqa: PLC0415 - heavy import

    data = loaded.data

    def source() -> Any:
        return pa.OSFile(loaded.path) if isinstance(data, FileBytes) else pa.BufferReader(data)

    if data.startswith(OLD):
        table = feather.read_table(source())
        return table.schema, lambda: iter(table.to_batches()), tuple
    if data.startswith(MAGIC) and data[-len(MAGIC) :] == MAGIC:
        file = ipc.open_file(source())
        return file.schema, lambda: (file.get_batch(i) for i in range(file.num_record_batches)), tuple
    stream = _Stream(loaded, source, pa)
    return stream.opened()[1].schema, stream.batches, stream.ends


class _Stream:
    """The stream of an Arrow file without an end, or one that is no file."""

    def __init__(self, loaded: Loaded, source: Callable[[], Any], pa: Any) -> None:
        self._loaded, self._source, self._pa = loaded, source, pa
        self._at, self._is_whole = 0, False

    def opened(self) -> tuple[Any, Any]:
        """Return the file at the stream, and the reader of the stream."""
        from pyarrow import ipc  # noqa: PLC0415 - heavy import

        file = self._source()
        if self._loaded.data.startswith(MAGIC):
            file.seek(START)
        return file, ipc.open_stream(file)

    def batches(self) -> Iterator[Any]:
        """Yield the batches that are whole."""
        data = self._loaded.data
        file, reader = self.opened()
        while True:
            self._at = file.tell()
            try:
                batch = reader.read_next_batch()
            except StopIteration:
                self._is_whole = not data.startswith(MAGIC) and data[-8:-4] == STREAM
                return
            except (self._pa.ArrowException, OSError):
                return
            yield batch

    def ends(self) -> tuple[Remark, ...]:
        """Return a remark where the stream is not whole."""
        if self._is_whole:
            return ()
        rest = len(self._loaded.data) - self._at
        return torn(self._loaded.path, rest, self._at, *(() if rest else ("it has no end",)))


def _recognises(data: bytes, path: str) -> bool:
    return data.startswith((MAGIC, OLD)) or (data.startswith(STREAM) and data[8:12] == b"\x10\0\0\0")


READER = Reader("feather", "Arrow (Feather)", (".feather", ".arrow"), _recognises,
                apart(read_feather, "an Arrow file"), True)  # fmt: skip
