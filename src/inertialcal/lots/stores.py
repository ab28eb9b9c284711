"""Where the recordings of a lot lie: a folder, or an address that pyarrow's file systems read (``s3://bucket/path``).

A unit is read from a folder, as a campaign is. In a local store that is the store itself. What comes from elsewhere, or
out of a file of many units, is laid into a folder for the time of a block.
"""

from __future__ import annotations

import codecs
import hashlib
import os
import re
import shutil
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pa_csv
import pyarrow.dataset as ds
import pyarrow.fs as pa_fs
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..campaign.file.recordings import RecordingEntry
from ..campaign.inputs.sources import HELD, ReadOnce, request_of
from ..core.errors import DataError, PlanError
from ..core.recording import Recording, Source
from ..files.assemble import Assembled
from ..files.binary.parquet import contents_of
from ..files.reader import Request
from ..files.registry import Columns, read_recording
from ..files.text.table import Table, table_of_content
from .units import csv_heading

WHOLE = re.compile(r"-?[0-9]{1,20}")  # number
COLUMN = re.compile(r"\{([^{}]*)\}")
CSV = (".csv", ".txt", ".tsv")
HEAD = 2**16  # bytes of a CSV that tell what separates its cells, and its letters
PADDED = 8  # bytes of which Arrow streams values in whole multiples
PATIENCE = 20  # until a server that does not answer is given up [s]; of its own, that of Google Cloud waits 15 minutes
Key = tuple[str, ...]  # what tells a unit apart in a file of many: its serial number, and more cells as text


@dataclass(frozen=True)
class Shared:
    """A file whose rows say of which unit they are: by a column for the serial number, and what others must say."""

    file: str
    serial: str
    match: tuple[tuple[str, str], ...] = ()  # Column of the file, column of the table of units

    @property
    def columns(self) -> tuple[str, ...]:
        """Those of the file that tell units apart."""
        return self.serial, *(name for name, _ in self.match)

    def of_unit(self, cells: Mapping[str, str], root: str) -> Shared:
        """Return it with the file of a unit, where its name is a pattern; errors as `file_of` has them."""
        return replace(self, file=file_of(self.file, cells, root)) if COLUMN.search(self.file) else self

    @property
    def is_text(self) -> bool:
        """Whether it is CSV."""
        return PurePosixPath(self.file).suffix.lower() in CSV


@dataclass(frozen=True)
class Place:
    """Where the recordings of all units lie.

    Parameters
    ----------
    store : str
        Folder, or address.
    endpoint, region : str
        Of an S3 server; empty for those of the environment.
    """

    store: str
    endpoint: str = ""
    region: str = ""

    @property
    def is_local(self) -> bool:
        """Whether it is a folder of this machine."""
        return "://" not in self.store

    def opened(self) -> tuple[pa_fs.FileSystem, str]:
        """Return the file system, and the folder in it. Keys are those of the environment.

        Raises
        ------
        PlanError
            ``wrong_value``, if the address is none that pyarrow knows.
        """
        if self.is_local:
            return pa_fs.LocalFileSystem(), self.store
        try:
            if self.store.startswith("s3://"):
                scheme, _, host = self.endpoint.rpartition("://")
                words = {"endpoint_override": host, "scheme": scheme or "https"} if host else {}
                if self.region:
                    words["region"] = self.region
                return pa_fs.S3FileSystem(**words), self.store.removeprefix("s3://").rstrip("/")
            address = self.store
            if address.startswith(("gs://", "gcs://")) and "retry_limit_seconds" not in address:
                address += f"{'&' if '?' in address else '?'}retry_limit_seconds={PATIENCE}"
            system, path = pa_fs.FileSystem.from_uri(address)
        except (pa.ArrowInvalid, pa.ArrowNotImplementedError, OSError, ValueError) as error:
            do = 'Write a folder, or an address like "s3://bucket/lot7"'
            if self.store.startswith("hdfs://"):
                do = "Install Java and a Hadoop client here (libjvm, libhdfs), or copy the recordings into a folder"
            raise PlanError(f"store {self.store!r}: {_said(error)}", do=do, code="wrong_value") from None
        return system, path.rstrip("/")

    def files(self, names: Set[str]) -> set[str]:
        """Return which of some names are those of files."""
        if self.is_local:
            return {name for name in names if os.path.isfile(os.path.join(self.store, name))}
        return set(self.stamps(sorted(names)))

    def stamps(self, files: Sequence[str]) -> dict[str, list[int]]:
        """Return size and time of the last change of each file, by its name; nothing of those that are not there."""
        if self.is_local:
            found = {}
            for file in files:
                try:
                    about = os.stat(os.path.join(self.store, file))
                except (OSError, ValueError):
                    continue
                found[file] = [about.st_size, about.st_mtime_ns]
            return found
        system, root = self.opened()
        with reading(self.store):
            infos = system.get_file_info([f"{root}/{file}" for file in files]) if files else []
        known = zip(files, infos, strict=True)
        return {file: [one.size, one.mtime_ns or 0] for file, one in known if one.type == pa_fs.FileType.File}


def _said(error: BaseException) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__


@contextmanager
def reading(where: str) -> Iterator[None]:
    """Turn what a file system says into a DataError.

    Raises
    ------
    DataError
        ``unreachable``.
    """
    try:
        yield
    except (OSError, pa.ArrowException) as error:
        do = "Check the address, the server, and the keys in the environment"
        raise DataError(f"the store cannot be read: {_said(error)}", where, do=do, code="unreachable") from None


def file_of(pattern: str, cells: Mapping[str, str], folder: str = "") -> str:
    """Return the file that a pattern names for a unit, its columns plainly replaced.

    Parameters
    ----------
    pattern : str
        ``"noise/{serial}.parquet"``.
    cells : mapping of str to str
        Of the unit, by column.
    folder : str
        Store, where it is a folder of this machine.

    Raises
    ------
    DataError
        ``bad_path``: a cell is empty or no part of a name; ``outside``: a link leads out of the store.
    """
    for name in COLUMN.findall(pattern):
        cell = cells.get(name, "")
        if not cell or cell in {".", ".."} or any(one in cell for one in "/\\\0:") or cell != cell.strip():
            what = f"column {name}: {cell!r} cannot be part of the name of a file"
            raise DataError(what, why=f"the recording would be {pattern}", do="Correct the table", code="bad_path")
    found = COLUMN.sub(lambda one: cells[one.group(1)], pattern)
    if folder:
        try:
            root = Path(folder).resolve()
            inside = (root / found).resolve().is_relative_to(root)
        except (OSError, RuntimeError, ValueError):
            inside = False
        if not inside:
            raise DataError(f"{found!r} lies outside the store", do="Copy it into the store", code="outside")
    return found


class Alike(NamedTuple):
    """What an entry says of how its file is read, and the recording that it gave."""

    said: tuple[object, ...]
    request: Request
    assembled: Assembled


@dataclass(frozen=True, eq=False)
class UnitStore(ReadOnce):
    """Files of a unit: recordings in the folder of the unit, what is common to all beside the template.

    Parameters
    ----------
    folder : Path
        Of the template, in which ground models lie.
    waiting : Counter of str
        As `ReadOnce` has it.
    root : Path
        In which the recordings lie as the campaign of the unit names them.
    handed : mapping of (Content, Source)
        Columns of recordings that came out of a file of many units, and lie nowhere, by file.
    alike : dict of Alike
        Recordings of other units, by file and columns that it needs.
    """

    root: Path = field(default_factory=Path)
    handed: Mapping[str, Columns] = field(default_factory=dict[str, Columns])
    alike: dict[tuple[str, ...], Alike] = field(default_factory=dict[tuple[str, ...], "Alike"])

    def path(self, file: str) -> Path:
        """Return where a file lies: one that is no recording of the unit, beside the template."""
        own = self.root / file
        return own if file in self.waiting or own.exists() else self.folder / file

    def recording(self, entry: RecordingEntry, required: Sequence[str]) -> Recording:
        """Return a recording as its file has it."""
        known = self.handed.get(entry.file)
        if known is None:
            return super().recording(entry, required)
        which = (entry.file, *required)
        alike = self.alike.get(which)
        said = (entry.clock, entry.text, entry.frame, entry.topics)
        if alike is not None and all(one is other for one, other in zip(said, alike.said, strict=True)):
            request = alike.request
        else:
            request = request_of(entry, required)
            alike = alike if alike is not None and alike.request == request else None
        own = None if alike is None else alike.assembled
        found = read_recording(known[1].path, request, handed=known, alike=own)
        if alike is None and request.window.is_all:
            self.alike[which] = Alike(said, request, Assembled(known[0], found))
        return found

    def table(self, file: str, text: Mapping[str, Any] | None = None) -> Table:
        """Return a reduced table."""
        if file in self.handed and file not in self._tables:
            self._tables[file] = table_of_content(*self.handed[file])
        return super().table(file, text)

    def has(self, file: str) -> bool:
        """Return whether there is such a file."""
        return file in self.handed or super().has(file)


class _Piece(NamedTuple):
    """Some rows of a table."""

    table: pa.Table
    rows: range | NDArray[np.intp]
    nbytes: float  # That they take, about


def _joined(pieces: Sequence[_Piece]) -> pa.Table:
    """Return the rows of pieces one after the other."""
    return pa.concat_tables(
        one.table.slice(one.rows.start, len(one.rows)) if isinstance(one.rows, range) else one.table.take(one.rows)
        for one in pieces
    )


class Delivery:
    """Recordings of a block of units where they do not lie in a local store already: in folders, or in memory.

    Parameters
    ----------
    place : Place
        Where recordings lie.
    shared : mapping of str to Shared
        Files of many units, by recording.
    """

    def __init__(self, place: Place, shared: Mapping[str, Shared]) -> None:
        self.place, self.shared = place, shared
        self.temporary = None if place.is_local and not shared else TemporaryDirectory(prefix="inertialcal-lot-")
        self.handed: dict[int, dict[str, Columns]] = {}  # of each unit, by file
        self.alike: dict[tuple[str, ...], Alike] = {}  # by file and columns that it needs: recordings of other units

    def __enter__(self) -> Delivery:
        """Return it."""
        return self

    def __exit__(self, *given: object) -> None:
        """Forget the folders."""
        if self.temporary is not None:
            self.temporary.cleanup()

    def load_shared(self, units: Mapping[int, Mapping[str, str]]) -> dict[int, DataError]:
        """Deliver the rows of each unit of each file of many; return why those of a unit cannot be.

        Parameters
        ----------
        units : mapping of int to mapping of str to str
            Cells of each unit, by its number.
        """
        refused: dict[int, DataError] = {}
        root = self.place.store if self.place.is_local else ""
        wanted: dict[Shared, dict[int, Key]] = {}  # by file; several where its name is a pattern
        for number, cells in units.items():
            for one in dict.fromkeys(self.shared.values()):
                try:
                    named = one.of_unit(cells, root)
                except DataError as error:
                    refused.setdefault(number, error)
                    continue
                key = (cells["serial"], *(cells.get(column, "") for _, column in one.match))
                wanted.setdefault(named, {})[number] = key
        for one, keys in wanted.items():
            try:
                found = self._rows(one, frozenset(keys.values()))
            except DataError as error:
                refused |= dict.fromkeys(keys, error)
                continue
            there = {number: found[key] for number, key in keys.items() if key in found}
            held = sum(piece.nbytes for pieces in there.values() for piece in pieces)
            if held <= HELD and not one.is_text:
                refused = self._hand_over(one, there) | refused
            else:
                for number, pieces in there.items():
                    self._lay_down(number, one, _joined(pieces))
            for number, key in keys.items():
                if number in there:
                    continue
                said = " and ".join(f"{name} {part!r}" for name, part in zip(one.columns, key, strict=True))
                do = f"Check column {one.serial}, or take the unit out of the table"
                refused.setdefault(number, DataError(f"no row of {said}", one.file, do=do, code="no_rows"))
        return refused

    def _hand_over(self, shared: Shared, there: Mapping[int, Sequence[_Piece]]) -> dict[int, DataError]:
        """Hand over the rows of units in memory, all columns turned into arrays at once; return those that are none."""
        groups: dict[int, tuple[pa.Table, dict[int, range]]] = {}
        scattered: dict[int, pa.Table] = {}
        for number, pieces in there.items():
            table, rows = pieces[0].table, pieces[0].rows
            if len(pieces) == 1 and isinstance(rows, range):
                groups.setdefault(id(table), (table, {}))[1][number] = rows
            else:
                scattered[number] = _joined(pieces)
        if scattered:
            ends = np.cumsum([0, *(len(one) for one in scattered.values())]).tolist()
            parts = dict(zip(scattered, (range(*pair) for pair in pairwise(ends)), strict=True))
            groups[0] = pa.concat_tables(scattered.values()), parts
        refused: dict[int, DataError] = {}
        for table, parts in groups.values():
            refused |= self._hand_over_rows(shared, table, parts)
        return refused

    def _hand_over_rows(self, shared: Shared, table: pa.Table, parts: Mapping[int, range]) -> dict[int, DataError]:
        """Hand over stretches of rows of one table, by unit; return those that are none."""
        first, stop = min(one.start for one in parts.values()), max(one.stop for one in parts.values())
        every = table.slice(first, stop - first).drop_columns([shared.serial]).combine_chunks()
        own = [range(one.start - first, one.stop - first) for one in parts.values()]
        name = str(Path(shared.file))
        paths = [os.path.join(self._root(number), name) for number in parts]
        refused: dict[int, DataError] = {}
        try:
            contents = list(contents_of(every, own, paths))
        except DataError as error:
            return dict.fromkeys(parts, error)
        for number, digest, path, content in zip(
            parts, digests_of(plain_rows(every), own), paths, contents, strict=True
        ):
            if isinstance(content, DataError):
                refused[number] = content
                continue
            source = Source(path, digest, content.format, "parquet")
            self.handed.setdefault(number, {})[shared.file] = content, source
        return refused

    def _lay_down(self, number: int, shared: Shared, rows: pa.Table) -> None:
        """Lay the rows of a unit into a file: text is read by the rules of text, long columns a part at a time."""
        own, path = rows.drop_columns([shared.serial]).combine_chunks(), self.root(number) / shared.file
        path.parent.mkdir(parents=True, exist_ok=True)
        if shared.is_text:
            pa_csv.write_csv(own, path, pa_csv.WriteOptions(delimiter=";", quoting_style="needed"))
        else:
            pq.write_table(own, path, compression="none", use_dictionary=False, write_statistics=False)

    def _rows(self, shared: Shared, wanted: Set[Key]) -> dict[Key, list[_Piece]]:
        """Return the rows of some units of a file of many, piece by piece."""
        system, root = self.place.opened()
        known = system.get_file_info(f"{root}/{shared.file}")
        if known.type == pa_fs.FileType.NotFound:
            do = "Check files in LOT.toml"
            raise DataError("no such file", shared.file, do=do, code="missing_file")
        found: dict[Key, list[_Piece]] = {}
        with reading(shared.file):
            path = f"{root}/{shared.file}"
            if shared.is_text:
                data = ds.dataset(path, filesystem=system, format=_as_text(system, path))
                names = data.schema.names
            else:
                once = (
                    _footers if known.type == pa_fs.FileType.File else _footers.__wrapped__
                )  # a folder tells no change
                footers = once(self.place, path, shared.serial, known.size, known.mtime_ns)
                names = footers[0].schema.names if footers else []
            for name in shared.columns:
                if name not in names:
                    do = f"It has: {', '.join(names)}"
                    raise DataError(f"no column {name!r}", shared.file, do=do, code="unknown_column")
            serials = sorted({key[0] for key in wanted})
            if shared.is_text:
                tables = iter([data.to_table(filter=ds.field(shared.serial).isin(serials), use_threads=False)])
            else:
                tables = _groups(footers, serials, system)
            for table in tables:
                of_row = table.nbytes / max(len(table), 1)
                for key, rows in _rows_by_key(table, shared.columns).items():
                    if key in wanted:
                        found.setdefault(key, []).append(_Piece(table, rows, of_row * len(rows)))
        return found

    def root(self, number: int) -> Path:
        """Return the folder in which the recordings of a unit lie."""
        return Path(self._root(number))

    def _root(self, number: int) -> str:
        return self.place.store if self.temporary is None else os.path.join(self.temporary.name, str(number))

    def lay_out(self, number: int, files: Sequence[str]) -> None:
        """Lay out the files that a unit has for itself.

        Raises
        ------
        DataError
            ``unreachable``; one that is not there is told where it is read.
        """
        if self.temporary is None or not files:
            return
        root = self.root(number)
        system, store = self.place.opened()
        for file in dict.fromkeys(files):
            path = root / file
            path.parent.mkdir(parents=True, exist_ok=True)
            if self.place.is_local:
                here = Path(self.place.store).resolve() / file
                if here.exists():
                    path.symlink_to(here) if os.name == "posix" else shutil.copyfile(here, path)
                continue
            with reading(file):
                if system.get_file_info(f"{store}/{file}").type == pa_fs.FileType.File:
                    with system.open_input_stream(f"{store}/{file}") as source, open(path, "wb") as target:
                        shutil.copyfileobj(source, target, 2**22)

    def leave(self, number: int) -> None:
        """Forget the files of a unit."""
        if self.temporary is not None:
            shutil.rmtree(self.root(number), ignore_errors=True)


def plain_rows(table: pa.Table) -> pa.Table:
    """Return rows without codes, of whole bytes: bits of other rows may stand beside those of these."""
    for at, one in enumerate(table.schema):
        kind = _plain(one.type)
        if kind != one.type:
            table = table.set_column(at, one.with_type(kind), table.column(at).cast(kind))
    return table


def digests_of(plain: pa.Table, parts: Sequence[range]) -> list[str]:
    """Return the SHA-256 of some plain rows (`plain_rows`) after others: of their schema, and those of their columns.

    Of a column that is as Arrow streams it. What lies below a null is nobody's: where there are nulls it is of where
    they are, and of what is there. A column that is the same as in the rows before, as times are, is looked at once.
    """
    begun = hashlib.sha256(plain.schema.serialize())
    held = [_held(column) for column in plain.columns]
    before: dict[int, tuple[pa.Buffer, bytes]] = {}  # by column: what it was, and its digest
    heads: dict[tuple[int, int], memoryview] = {}  # what stands before the values, by column and their number
    found = []
    for part in parts:
        digest = begun.copy()
        for at, (column, values) in enumerate(zip(plain.columns, held, strict=True)):
            if values is None:
                of_column = hashlib.sha256()
                for one in _streamed(column.slice(part.start, len(part))):
                    of_column.update(one)
                digest.update(of_column.digest())
                continue
            width = values.size // len(plain)
            own = values.slice(part.start * width, len(part) * width)
            if at not in before or not own.equals(before[at][0]):
                beyond = -own.size % PADDED
                if (at, len(part)) not in heads:
                    (whole,) = _streamed(column.slice(part.start, len(part)))
                    heads[at, len(part)] = memoryview(whole)[: whole.size - own.size - beyond]
                of_column = hashlib.sha256(heads[at, len(part)])
                of_column.update(own)
                of_column.update(bytes(beyond))
                before[at] = own, of_column.digest()
            digest.update(before[at][1])
        found.append(digest.hexdigest())
    return found


def _held(column: pa.ChunkedArray) -> pa.Buffer | None:
    """Return the values of a column as they lie in memory; None where they do not lie there one after the other."""
    kind = column.type
    if column.null_count or column.num_chunks != 1 or not pa.types.is_primitive(kind) or kind.bit_width % 8:
        return None
    chunk, width = column.chunk(0), kind.bit_width // 8
    return chunk.buffers()[1].slice(chunk.offset * width, len(chunk) * width)


def _streamed(column: pa.ChunkedArray) -> Iterator[Any]:
    """Yield the bytes of some rows of a column."""
    if pa.types.is_nested(column.type):
        yield repr(column.to_pylist()).encode()
        return
    known = (column.is_null().cast(pa.uint8()), column.drop_null()) if column.null_count else (column,)
    for one in known:
        yield pa.record_batch([one.combine_chunks()], [""]).serialize()


def _plain(kind: pa.DataType) -> pa.DataType:
    kind = kind.value_type if pa.types.is_dictionary(kind) else kind
    return pa.uint8() if pa.types.is_boolean(kind) else kind


def _as_text(system: pa_fs.FileSystem, path: str) -> ds.CsvFileFormat:
    """Return how a CSV is read whose cells all stay as they stand there; its first line tells what separates them."""
    with system.open_input_stream(path) as stream:
        head = stream.read(HEAD)
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
        encoding = "utf8"
    except UnicodeDecodeError:
        encoding = "latin-1"
    text = head.decode("utf-8-sig" if encoding == "utf8" else encoding, "replace")
    separator, names = csv_heading(text)
    kinds = dict.fromkeys(names, pa.string())
    options = pa_csv.ConvertOptions(column_types=kinds, null_values=[""], strings_can_be_null=True)
    parsed, letters = pa_csv.ParseOptions(delimiter=separator), pa_csv.ReadOptions(encoding=encoding)
    return ds.CsvFileFormat(parse_options=parsed, convert_options=options, read_options=letters)


@dataclass(frozen=True, eq=False)
class _Footer:
    """What the end of a Parquet file says."""

    path: str
    metadata: pq.FileMetaData
    schema: pa.Schema
    ends: tuple[list[str | int], list[str | int]]  # Least and largest serial number of each group
    unsaid: NDArray[np.bool_]  # Of which groups it does not say them

    @classmethod
    def of(cls, path: str, metadata: pq.FileMetaData, serial: str) -> _Footer:
        """Return what is known of the groups of a file."""
        groups = [metadata.row_group(number) for number in range(metadata.num_row_groups)]
        at = next((i for i in range(metadata.num_columns) if metadata.schema.column(i).path == serial), None)
        said = [None if at is None else group.column(at).statistics for group in groups]
        known = [(one.min, one.max) if one is not None and one.has_min_max else None for one in said]
        schema = metadata.schema.to_arrow_schema()
        for kind, none in ((str, ""), (int, 0)):
            if any(known) and all(one is None or type(one[0]) is kind for one in known):
                lows, highs = ([none if one is None else one[end] for one in known] for end in (0, 1))
                return cls(path, metadata, schema, (lows, highs), np.array([one is None for one in known]))
        return cls(path, metadata, schema, ([""] * len(known), [""] * len(known)), np.ones(len(known), dtype=bool))

    def groups(self, serials: Sequence[str]) -> list[int]:
        """Return the groups of rows that may hold some serial numbers, ascending, in order."""
        lows, highs = self.ends
        wanted: list[Any] = list(serials)
        if lows and isinstance(lows[0], int):
            wanted = sorted(int(one) for one in serials if WHOLE.fullmatch(one))
        within = [bisect_right(wanted, high) > bisect_left(wanted, low) for low, high in zip(lows, highs, strict=True)]
        return [int(one) for one in np.flatnonzero(np.array(within, dtype=bool) | self.unsaid)]


@lru_cache(maxsize=8)
def _footers(place: Place, path: str, serial: str, size: int | None, changed: int | None) -> tuple[_Footer, ...]:
    """Return the footers of a Parquet file, or of those of a folder: of all units, so that each block needs few."""
    data = ds.dataset(path, filesystem=place.opened()[0], format=ds.ParquetFileFormat())
    return tuple(_Footer.of(one.path, one.metadata, serial) for one in data.get_fragments())


def _groups(footers: Sequence[_Footer], serials: Sequence[str], system: pa_fs.FileSystem) -> Iterator[pa.Table]:
    """Yield the groups of rows of Parquet files that may hold what is looked for, by their statistics."""
    remote = not isinstance(system, pa_fs.LocalFileSystem)
    for one in footers:
        groups = one.groups(serials)
        texts = [field.name for field in one.schema if pa.types.is_string(field.type)]
        words = {"filesystem": system, "metadata": one.metadata, "read_dictionary": texts, "pre_buffer": remote}
        if groups:
            with pq.ParquetFile(one.path, **words) as file:
                for group in groups:
                    yield file.read_row_group(group, use_threads=False)


def _rows_by_key(table: pa.Table, names: Sequence[str]) -> dict[Key, range | NDArray[np.intp]]:
    """Return the rows of each combination of the cells of some columns as text, in their order."""
    runs = [_runs(one.chunk(0) if one.num_chunks == 1 else one.combine_chunks()) for one in map(table.column, names)]
    stops = np.unique(np.concatenate([ends for ends, _ in runs]))  # of each run of equal cells
    own = [[texts[at] for at in np.searchsorted(ends, stops).tolist()] for ends, texts in runs]
    pieces: dict[Key, list[tuple[int, int]]] = {}
    start = 0
    for stop, *key in zip(stops.tolist(), *own, strict=True):
        known = pieces.setdefault(tuple(key), [])
        if known and known[-1][1] == start:
            known[-1] = known[-1][0], stop
        else:
            known.append((start, stop))
        start = stop
    return {
        key: range(*one[0]) if len(one) == 1 else np.concatenate([np.arange(*pair) for pair in one])
        for key, one in pieces.items()
    }


def _runs(column: pa.Array) -> tuple[NDArray[np.intp], list[str]]:
    """Return where each run of equal cells ends, and their text; that of a null is empty."""
    coded = pa.types.is_dictionary(column.type)
    column = column.cast(pa.string()) if pa.types.is_string_view(column.type) else column
    codes = column.indices if coded else column
    if pa.types.is_integer(codes.type) and not codes.null_count:
        numbers = codes.to_numpy()
        is_last = np.ones(len(numbers), dtype=bool)
        np.not_equal(numbers[1:], numbers[:-1], out=is_last[:-1])
        ends = np.flatnonzero(is_last) + 1
        values = codes.take(pa.array(ends - 1))
    else:
        found = pc.run_end_encode(codes)
        ends, values = found.run_ends.to_numpy().astype(np.intp), found.values
    values = column.dictionary.take(values) if coded else values
    return ends, ["" if one is None else str(one) for one in values.cast(pa.string()).to_pylist()]
