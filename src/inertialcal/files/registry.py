"""Readers: name -> `Reader`, loaded when a file may be theirs.

A file is told by its bytes. Readers of installed packages (entry point ``inertialcal.readers``) are asked only where no
built-in one knows the bytes, or where they are text under an ending that text does not usually have; so none can take
a file from a reader that is built in. One that is broken is left out, and named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from ..core.errors import DataError, InertialcalError, Problem, UsageError
from ..core.recording import Recording, Source
from ..core.registry import Registry
from ..core.remarks import Remark
from .assemble import Assembled, assemble
from .budget import COLUMNS, PARTS, check_count
from .columns import Column, Content
from .formats import ZIP, ZIP_MEMBER, refusal
from .loggers import bag_folder
from .pad import reader as pad
from .reader import ArchiveReader, Reader, Request, wrong_frame
from .source import Loaded, as_data_errors, load, settled, whole
from .time.window import cut

TEXT = "text"  # what no other reader knows
BUILT_IN = {  # name -> module and attribute, in the order in which they are asked
    TEXT: "text.pieces:READER",
    "parquet": "binary.parquet:READER",
    "mat5": "binary.matlab:VERSION_5",
    "hdf5": "binary.hdf5:READER",
    "npy": "binary.numpy_file:NPY",
    "npz": "binary.numpy_file:NPZ",
    "mat4": "binary.matlab:VERSION_4",
    "cards": "text.card_images:READER",
    "rosbag1": "loggers.bags:ROSBAG_1",
    "rosbag2": "loggers.bags:ROSBAG_2",
    "mcap": "loggers.bags:READER",
    "ulog": "loggers.ulog:READER",
    "dataflash": "loggers.dataflash:BINARY",
    "dataflash_text": "loggers.dataflash:TEXT_LOG",
    "excel": "loggers.excel:READER",
    "tdms": "loggers.tdms:READER",
    "uff": "loggers.uff:READER",
    "wav": "loggers.wav:READER",
    "feather": "loggers.feather:READER",
    "mdf": "loggers.mdf:READER",
    "ide": "loggers.ide:READER",
    "lvm": "loggers.lvm:READER",
    "miniseed": "loggers.miniseed:READER",
    "sqlite": "loggers.sqlite:READER",
    "json_lines": "loggers.json_lines:READER",
}
GROWING = (TEXT, "json_lines", "dataflash")  # read from the beginning to where the file ended when it was opened
READERS: Registry[Reader] = Registry(
    "reader", Reader, "inertialcal.readers", {name: f"{__package__}.{place}" for name, place in BUILT_IN.items()}
)
ARCHIVES: tuple[ArchiveReader, ...] = (pad.READER, bag_folder.READER)
Sign = Literal[".", ","]
SIGNS: dict[str, Sign] = {"comma": ",", "point": "."}
KINDS = "iufMO"  # of the values of a column: numbers, instants, text


Columns = tuple[Content, Source]
Parsed = dict[tuple[str, tuple[str, ...] | None, str | None, int | None], Columns]


def read_recording(
    path: str | Path,
    request: Request,
    parsed: Parsed | None = None,
    handed: Columns | None = None,
    alike: Assembled | None = None,
) -> Recording:
    """Return the recording in a file, or in a record of several files; Raises as ``files.read``.

    Parameters
    ----------
    path, request
        As ``files.read`` takes them.
    parsed : dict, optional
        Columns of files that were read before, by path and what was asked of the reader; those of a new one are added.
    handed : (Content, Source), optional
        What the file holds, where it was read already by others: it need not be there.
    alike : Assembled, optional
        Another recording of which the same was asked.
    """
    for archive in ARCHIVES if handed is None else ():
        recording = archive.read(path, request)
        if recording is not None:
            return recording
    if request.frame is not None:
        raise wrong_frame(path)
    variables = tuple(request.topics or ()) or None
    key = (str(path), variables, request.decimal, request.skip)
    known = handed if handed is not None or parsed is None else parsed.get(key)
    loaded = None
    if handed is not None and (request.decimal is not None or request.skip is not None):
        raise _no_text(str(path), READERS[handed[1].reader], request)
    if known is None:
        content, source, loaded = _columns(path, request)
    else:
        content, source = known
    recording = None if alike is None else alike.with_values(content, source)
    recording = recording or assemble(
        content,
        source,
        units=request.units,
        sample_rate=request.sample_rate,
        time_column=request.time_column,
        required=request.required,
        dates=request.dates,
    )
    if loaded is not None:  # nobody waits for the hash of what is in memory
        digest, remarks = settled(loaded, may_grow=source.reader in GROWING)
        source = replace(source, sha256=digest)
        recording = replace(recording, source=source, remarks=(*recording.remarks, *remarks))
    if parsed is not None:
        parsed[key] = content, source
    return cut(recording, request.window)


def _columns(path: str | Path, request: Request) -> tuple[Content, Source, Loaded]:
    """Return the columns of a file, where they come from (without the SHA-256), and the file."""
    loaded = load(path, in_place=True)
    reader = find_reader(loaded)
    loaded = loaded if reader.in_place else whole(loaded)
    if request.decimal is None and request.skip is None:
        content = reader.read(loaded, request.topics or None)
    else:
        content = _text_as_said(loaded, reader, request)
    check_count(len(content.columns), COLUMNS, "columns", loaded.path)
    packed = ", gzip" if loaded.packed else ""
    return content, Source(loaded.path, "", content.format + packed, reader.name), loaded


def _text_as_said(loaded: Loaded, reader: Reader, request: Request) -> Content:
    """Return the columns of a text whose decimal sign, or lines before the table, were stated."""
    if reader.name != TEXT:
        raise _no_text(loaded.path, reader, request)
    from .text.pieces import read_text  # noqa: PLC0415 - loaded where it is needed

    return read_text(loaded, None, sign_of(request.decimal), lines_of(request.skip))


def _no_text(path: str, reader: Reader, request: Request) -> UsageError:
    option, what = ("skip", "lines before the table") if request.decimal is None else ("decimal", "decimal sign")
    problem, why = f"{path}: --{option} given", f"{reader.title} has no {what}"
    return UsageError(problem, why=why, do=f"Leave --{option} out", code="wrong_value")


def sign_of(decimal: str | None) -> Sign | None:
    """Return a decimal sign by the word for it; Raises UsageError for another word."""
    if decimal is not None and decimal not in SIGNS:
        raise UsageError(f"decimal sign {decimal!r}", do=f"Write {' or '.join(SIGNS)}", code="wrong_value")
    return None if decimal is None else SIGNS[decimal]


def lines_of(skip: int | None) -> int:
    """Return how many lines stand before the table; Raises UsageError for a number that cannot be."""
    if skip is not None and skip < 0:
        raise UsageError(
            f"skip {skip}: need 0 lines or more", do="Count the lines before the header", code="wrong_value"
        )
    return skip or 0


def find_reader(loaded: Loaded) -> Reader:
    """Return the reader of a loaded file: a built-in one by its bytes, else one of a package, else that of text.

    Raises
    ------
    DataError
        If the file is of a known format that nobody reads; broken readers of packages are named.
    """
    data, path = loaded.data, loaded.path
    if data.startswith(ZIP):
        check_count(data.count(ZIP_MEMBER), PARTS, "members of an archive", path)
    for name in BUILT_IN:
        if name != TEXT and READERS[name].recognises(data, path):
            return READERS[name]
    text = READERS[TEXT]
    refused = refusal(data, path, readable())
    if refused is None and _ending(path) in text.endings and text.recognises(data, path):
        return text
    found, broken = _of_packages(whole(loaded).data, path)
    if found is None and refused is not None:
        raise DataError([*refused.problems, *broken])
    return _naming(found or text, broken)


def readable() -> str:
    """Return the titles of all formats that are read without other packages."""
    titles = [READERS[name].title for name in BUILT_IN] + [archive.title for archive in ARCHIVES if archive.title]
    return ", ".join(dict.fromkeys(titles))


def _ending(path: str) -> str:
    """Return the ending of a name in small letters, without that of gzip."""
    return Path(path.lower().removesuffix(".gz")).suffix


def _of_packages(data: bytes, path: str) -> tuple[Reader | None, list[Problem]]:
    """Return the first reader of a package that knows a file, if there is one, and what is wrong with others."""
    broken: list[Problem] = []
    for name in READERS:
        if name in BUILT_IN:
            continue
        try:
            with as_data_errors(path, f"a file of the {_called(name)}"):
                if READERS[name].recognises(data, path):
                    return _guarded(READERS[name]), broken
        except InertialcalError as error:
            broken += [replace(one, where=path, code="broken_plugin") for one in error.problems]
    return None, broken


def _called(name: str) -> str:
    package = READERS.packages().get(name)
    return f"reader {name!r}" + (f" of {package}" if package else "")


def _guarded(reader: Reader) -> Reader:
    """Return a reader whose faults are errors that a user can act on."""

    def read(loaded: Loaded, variables: Sequence[str] | None) -> Content:
        with as_data_errors(loaded.path, f"{reader.title}, by the {_called(reader.name)}"):
            content = reader.read(loaded, variables)
        wrong = _fault(content)
        if wrong:
            what, do = f"the {_called(reader.name)} gives {wrong}", "Report it to its authors"
            raise DataError(what, where=loaded.path, do=do, code="broken_plugin")
        return content

    return replace(reader, read=read)


def _fault(content: object) -> str:
    """Return why this is not the content of a file; empty where it is."""
    if not isinstance(content, Content):
        return f"a {type(content).__name__}, need a Content"
    for column in content.columns:
        values = column.values if isinstance(column, Column) else None
        if not isinstance(values, np.ndarray) or values.ndim != 1 or values.dtype.kind not in KINDS:
            return "a column that is neither numbers, times nor text"
    if len({len(column.values) for column in content.columns}) > 1:
        return "columns of different length"
    names = [column.name for column in content.columns]
    return "two columns of one name" if len(set(names)) < len(names) else ""


def _naming(reader: Reader, broken: Sequence[Problem]) -> Reader:
    """Return a reader that names the broken ones of packages, which might have read the file."""
    if not broken:
        return reader

    def read(loaded: Loaded, variables: Sequence[str] | None) -> Content:
        try:
            content = reader.read(loaded, variables)
        except DataError as error:
            raise DataError([*error.problems, *broken]) from None
        remarks = (Remark(one.code, "warning", f"{one.what} ({one.why})", one.where, do=one.do) for one in broken)
        return replace(content, remarks=(*content.remarks, *remarks))

    return replace(reader, read=read)
