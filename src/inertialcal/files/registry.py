"""Readers: the one place that knows them all, and those of other distributions.

A file is told by its bytes. Readers of others (entry points ``inertialcal.readers``) are loaded only where no reader of
ours knows the bytes, or where they are text under an ending that text does not usually have; so none can take a
file from a reader that is built in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.errors import DataError, Problem, UsageError
from ..core.plugins import BrokenPlugin, Plugin, fault, load_plugins
from ..core.recording import Recording, Source
from ..core.remarks import Remark
from .assemble import assemble
from .binary import hdf5, matlab, numpy_file, parquet
from .columns import Column, Content
from .formats import refusal
from .pad import reader as pad
from .reader import ArchiveReader, Reader, Request
from .reader_errors import as_data_errors
from .source import Loaded, load
from .text import delimited
from .time.window import cut

TEXT = delimited.READER  # what no other reader knows
READERS: tuple[Reader, ...] = (
    parquet.READER,
    matlab.VERSION_5,
    hdf5.READER,
    numpy_file.NPY,
    numpy_file.NPZ,
    matlab.VERSION_4,
)
ARCHIVES: tuple[ArchiveReader, ...] = (pad.READER,)
GROUP = "inertialcal.readers"
KINDS = "iufMO"  # of the values of a column: numbers, instants, text


def read_recording(path: str | Path, request: Request) -> Recording:
    """Return the recording in a file, or in a record of several files; Raises as ``files.read``."""
    for archive in ARCHIVES:
        recording = archive.read(path, request)
        if recording is not None:
            return recording
    if request.frame is not None:
        raise UsageError(
            f"{path}: a frame is asked for",
            why="only records of the acceleration archive say their coordinate systems",
            do="Leave --frame out",
            code="wrong_frame",
        )
    loaded = load(path)
    reader = find_reader(loaded)
    content = reader.read(loaded, request.variables)
    packed = ", gzip" if loaded.packed else ""
    recording = assemble(
        content,
        Source(loaded.path, loaded.sha256, content.format + packed, reader.name),
        units=request.units,
        sample_rate=request.sample_rate,
        time_column=request.time_column,
        required=request.required,
    )
    return cut(recording, request.window)


def find_reader(loaded: Loaded) -> Reader:
    """Return the reader of a loaded file: ours by its bytes, else one of others, else that of text.

    Raises
    ------
    DataError
        If the file is of a known format that nobody reads; readers of others that are broken are named.
    """
    data, path = loaded.data, loaded.path
    found = next((reader for reader in READERS if reader.recognises(data, path)), None)
    if found is not None:
        return found
    refused = refusal(data, path, readable())
    if refused is None and _ending(path) in TEXT.endings and TEXT.recognises(data, path):
        return TEXT
    other, broken = _of_others(data, path)
    if other is None and refused is not None:
        raise DataError([*refused.problems, *(_problem(one, path) for one in broken)])
    return _naming(other or TEXT, broken)


def readable() -> str:
    """Return the titles of all formats that are read here."""
    titles = [reader.title for reader in (TEXT, *READERS)] + [archive.title for archive in ARCHIVES]
    return ", ".join(dict.fromkeys(titles))


def _ending(path: str) -> str:
    """Return the ending of a name in small letters, without that of gzip."""
    return Path(path.lower().removesuffix(".gz")).suffix


def _of_others(data: bytes, path: str) -> tuple[Reader | None, list[BrokenPlugin]]:
    """Return the reader of another distribution that knows a file, if there is one, and those that are broken."""
    plugins, faults = load_plugins(GROUP, Reader)
    broken = list(faults)
    own = {reader.name for reader in (TEXT, *READERS)} | {archive.name for archive in ARCHIVES}
    for plugin in plugins:
        if plugin.value.name in own:
            broken.append(BrokenPlugin(plugin.name, plugin.origin, f"has the name of ours, {plugin.value.name!r}"))
            continue
        try:
            if plugin.value.recognises(data, path):
                return _guarded(plugin), broken
        except Exception as error:  # whatever the code of somebody else raises
            broken.append(BrokenPlugin(plugin.name, plugin.origin, f"cannot tell its files: {fault(error)}"))
    return None, broken


def _guarded(plugin: Plugin[Reader]) -> Reader:
    """Return a reader of others whose faults are errors that a user can act on."""
    name = f"the reader {plugin.name!r} of {plugin.origin}"

    def read(loaded: Loaded, variables: Sequence[str] | None) -> Content:
        with as_data_errors(loaded.path, f"{plugin.value.title}, by {name}"):
            content = plugin.value.read(loaded, variables)
        wrong = _fault(content)
        if wrong:
            raise DataError(
                f"{name} gives {wrong}", where=loaded.path, do="Tell those who made it", code="broken_plugin"
            )
        return content

    return replace(plugin.value, read=read)


def _fault(content: object) -> str:
    """Return why this is not the content of a file; empty where it is."""
    if not isinstance(content, Content):
        return f"a {type(content).__name__}, need a Content"
    for column in content.columns:
        values = column.values if isinstance(column, Column) else None
        if not isinstance(values, np.ndarray) or values.ndim != 1 or values.dtype.kind not in KINDS:
            return "a column that holds neither numbers, instants nor text"
    if len({len(column.values) for column in content.columns}) > 1:
        return "columns of different length"
    names = [column.name for column in content.columns]
    return "two columns of one name" if len(set(names)) < len(names) else ""


def _naming(reader: Reader, broken: Sequence[BrokenPlugin]) -> Reader:
    """Return a reader that names the broken ones of others, which might have read the file."""
    if not broken:
        return reader

    def read(loaded: Loaded, variables: Sequence[str] | None) -> Content:
        problems = [_problem(one, loaded.path) for one in broken]
        try:
            content = reader.read(loaded, variables)
        except DataError as error:
            raise DataError([*error.problems, *problems]) from None
        remarks = (Remark(one.code, "warning", one.what, one.where, do=one.do) for one in problems)
        return replace(content, remarks=(*content.remarks, *remarks))

    return replace(reader, read=read)


def _problem(one: BrokenPlugin, path: str) -> Problem:
    what = f"the reader {one.name!r} of {one.origin} {one.why}: it is left out"
    return Problem(what, path, do="Mend or uninstall it", code="broken_plugin")
