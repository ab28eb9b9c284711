"""Acceleration records of the public archive (PAD): pairs of data file and header, or a folder of them.

Each data file holds records of time and acceleration [g], its header says how to read them. What a result could
depend on without notice is a remark: the stamps are made anew from TimeZero and sample rate, BiasCoeff is never
applied, and what was done to the data before is told. Files of one sensor make one recording with gaps.

References
----------
.. [1] NASA Glenn, Principal Investigator Microgravity Services: acceleration data of the station, PIMS-ISS-101 (2002).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, empty, is_long, is_stored, put
from ...core.errors import DataError, UsageError
from ...core.recording import SECOND, Recording, Source, Times
from ...core.remarks import Remark, condensed
from ...core.times import instant_text
from ...core.unit.magnitudes import check_sample_rate
from ..assemble import assemble
from ..binary.arrays import number_column
from ..columns import Content
from ..reader import ArchiveReader, Request
from ..source import read_bytes
from ..time.window import Window, cut_remark, nothing_left
from .data import FLOAT, Digest, layout_of, read_numbers, room_of
from .header import (
    STEPS,
    PadHeader,
    applied,
    change_remarks,
    gap_remark,
    header_remarks,
    read_header,
    regenerate,
    time_remarks,
)
from .pairs import Pair, check_byte_order, check_frame, check_pair, pairs_of, turned

NAME = "pad"
JOINED = 0.5  # in intervals: a file that begins so near to the next sample goes on where the last one ended
MARGIN = 1.01, 1  # factor and seconds by which a file may last longer than its size and sample rate say
WORDS = {"<f4": "little endian", ">f4": "big endian", "": "text"}


@dataclass(frozen=True)
class _File:
    """A pair with its header."""

    pair: Pair
    header: PadHeader


@dataclass(frozen=True, eq=False)
class _Part:
    """The samples of one file that lie in the window."""

    file: _File
    first: int
    last: int
    total: int
    time_ns: Times
    values: list[NDArray[Any]]
    remarks: tuple[Remark, ...]


@dataclass(eq=False)
class _Room:
    """Room for the samples of several files, end to end."""

    time_ns: Times
    values: list[NDArray[Any]]
    filled: int = 0

    @classmethod
    def of(cls, files: Sequence[_File]) -> _Room | None:
        """Return the room that files of binary numbers may take; None of one file, and of text."""
        if len(files) < 2 or not all(file.header.number_type for file in files):
            return None
        columns = 1 + len(layout_of(files[0].header).names)
        most = sum(file.pair.data.stat().st_size for file in files) // (FLOAT * columns)
        stored = is_long(room_of(most, columns))
        return cls(empty(most, np.int64, stored), [empty(most, np.float32, stored) for _ in range(columns - 1)])


def _placed(part: _Part, room: _Room | None) -> _Part:
    """Return a part whose samples stand in the room, behind those of the parts before; its own are let go."""
    first, many = (0 if room is None else room.filled), len(part.time_ns)
    if room is None or first + many > len(room.time_ns) or len(part.values) != len(room.values):  # it grows meanwhile
        return part
    for place, values in zip((room.time_ns, *room.values), (part.time_ns, *part.values), strict=True):
        for a, b in batches(values):
            put(place, first + a, values[a:b])
    room.filled = stop = first + many
    return replace(part, time_ns=room.time_ns[first:stop], values=[one[first:stop] for one in room.values])


def _copied(x: NDArray[Any]) -> NDArray[Any]:
    """Return a copy, in memory or stored as what it is copied from."""
    out = empty(len(x), x.dtype, is_stored(x))
    for first, stop in batches(x):
        put(out, first, x[first:stop])
    return out


def read_archived(path: str | Path, request: Request) -> Recording | None:
    """Return the recording of a path that is a pair of the archive or a folder of such; None where it is neither.

    Raises
    ------
    DataError
        As `pairs_of` and `read_pad`.
    UsageError
        As `read_pad`; ``wrong_column``, if a time column is named.
    """
    pairs = pairs_of(path)
    if not pairs:
        return None
    if request.time_column is not None:
        raise UsageError(
            f"{path}: time column {request.time_column!r}",
            why="the time of an archive record follows from its header",
            do="Leave --time-column out",
            code="wrong_column",
        )
    return read_pad(
        str(path),
        pairs,
        window=request.window,
        frame=request.frame,
        units=request.units,
        sample_rate=request.sample_rate,
        required=request.required,
    )


def read_pad(
    path: str,
    pairs: Sequence[Pair],
    *,
    window: Window,
    frame: str | None = None,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    required: Sequence[str] = (),
) -> Recording:
    """Return the recording in pairs of the archive.

    Parameters
    ----------
    path : str
        As given.
    pairs : sequence of Pair
        One, or those of a folder.
    window : Window
        Times that bound it.
    frame : {"data", "sensor"}, optional
        Axes: as the data are (the default), or those of the sensor.
    units, sample_rate, required
        As ``files.read`` takes them.

    Returns
    -------
    Recording
        In UTC; its SHA-256 is that of all bytes used, each data file before its header, the files in order of time.

    Raises
    ------
    DataError
        By code: ``missing_file``, ``empty_file``, ``too_large``, ``truncated``, ``damaged_file``, ``bad_header``,
        ``bad_stamps``, ``header_disagrees``, ``several_sensors``, ``several_clocks``, ``overlapping_files``,
        ``no_frames``, ``nothing_left``, and those of ``files.read``.
    UsageError
        ``wrong_time``, ``wrong_frame``, ``sample_rate``.
    """
    check_frame(frame)
    if sample_rate is not None and (wrong := check_sample_rate(sample_rate)):
        raise UsageError(wrong, code="sample_rate")
    files = sorted((_File(pair, read_header(pair.header)) for pair in pairs), key=lambda f: f.header.time_zero)
    _one_sensor(files, path)
    bounds = window.bounds("utc")
    digest = hashlib.sha256()
    opened = [file for file in files if _may_lie_in(file, bounds)]
    _one_rate(opened, path)
    room = _Room.of(opened)
    parts = [_placed(_part(file, bounds, sample_rate, frame, digest), room) for file in opened]
    rate = sample_rate or files[0].header.sample_rate
    remarks = [*_joints(parts, rate), *(remark for part in parts for remark in part.remarks)]
    kept = [part for part in parts if len(part.time_ns)]
    if not kept:
        raise nothing_left(path, _ends(files, parts, rate), "utc")
    if not window.is_all:
        total = sum(part.total for part in parts)
        remarks.append(cut_remark(path, sum(len(p.time_ns) for p in kept), total, len(files) - len(opened)))
    content = _joined(kept, room, files[0].header, frame, rate, path)
    content = replace(content, remarks=(*content.remarks, *condensed(remarks)))
    source = Source(path, digest.hexdigest(), content.format, NAME)
    recording = assemble(content, source, units=units, sample_rate=sample_rate, required=required)
    said = {step for part in kept for step in applied(part.file.header)}
    return replace(recording, applied=tuple(step for step in STEPS if step in said))


def _one_sensor(files: Sequence[_File], path: str) -> None:
    sensors = sorted({file.header.sensor for file in files})
    if len(sensors) > 1:
        raise DataError(
            f"{len(files)} files of {len(sensors)} sensors: {', '.join(sensors)[:120]}",
            where=path,
            why="different sensors have different clocks",
            do="Name the folder of one sensor, or one file",
            code="several_sensors",
        )


def _one_rate(files: Sequence[_File], path: str) -> None:
    rates = sorted({file.header.sample_rate for file in files})
    if len(rates) > 1:
        raise DataError(
            f"files of {len(rates)} sample rates: {', '.join(f'{rate:g}' for rate in rates)[:120]} Hz",
            where=path,
            do="Name files of one sample rate, or limit the time (--from, --to)",
            code="several_clocks",
        )


def _may_lie_in(file: _File, bounds: tuple[int | None, int | None]) -> bool:
    """Whether a file can hold samples of the window, by its start and size."""
    start, stop = bounds
    if stop is not None and file.header.time_zero >= stop:
        return False
    if start is None or not file.header.number_type:
        return True
    record = FLOAT * (1 + len(layout_of(file.header).names))
    seconds = file.pair.data.stat().st_size / record / file.header.sample_rate * MARGIN[0] + MARGIN[1]
    return file.header.time_zero + round(seconds * SECOND) >= start


def _part(
    file: _File, bounds: tuple[int | None, int | None], said_rate: float | None, frame: str | None, digest: Digest
) -> _Part:
    header, where = file.header, str(file.pair.data)
    time, values = read_numbers(file.pair.data, header, digest)
    digest.update(read_bytes(file.pair.header))
    check_byte_order(time, header, where)
    rate = said_rate or header.sample_rate
    stamps = regenerate(time, header.time_zero, rate, where)
    del time
    remarks = [*check_pair(file.pair, header, stamps, said_rate), *time_remarks(stamps, rate, where)]
    kept = _inside(stamps.time_ns, bounds)
    chosen = stamps.time_ns[kept]
    if len(chosen) < len(stamps.time_ns):  # copies, so that what lies outside is let go
        chosen, values = _copied(chosen), [_copied(column[kept]) for column in values]
    values, said = turned(values, header, frame, where) if layout_of(header).named else (values, ())
    remarks += [*header_remarks(header, where), *said]
    first, last = int(stamps.time_ns[0]), int(stamps.time_ns[-1])
    return _Part(file, first, last, len(stamps.time_ns), chosen, values, tuple(remarks))


def _inside(time_ns: Times, bounds: tuple[int | None, int | None]) -> slice:
    start, stop = bounds
    first = 0 if start is None else int(np.searchsorted(time_ns, start))
    last = len(time_ns) if stop is None else int(np.searchsorted(time_ns, stop))
    return slice(first, max(first, last))


def _joints(parts: Sequence[_Part], rate: float) -> list[Remark]:
    """Remarks where the sign in a name and the times of two files do not fit; overlapping files are refused."""
    remarks = list(change_remarks([p.file.header for p in parts], [str(p.file.pair.data) for p in parts]))
    for before, after in pairwise(parts):
        where = str(after.file.pair.data)
        gap = (after.first - before.last) / SECOND * rate - 1.0
        if gap < -JOINED:
            raise DataError(
                f"begins {instant_text(after.first)}, before {before.file.pair.data.name} ends",
                where=where,
                why="the time appears twice: a copy, or a filtered version, in the same folder",
                do="Remove one of them",
                code="overlapping_files",
            )
        name = after.file.pair.name
        if name is not None and name.contiguous != (gap < JOINED):
            said = "+ in the name: continues" if name.contiguous else "- in the name: a gap"
            what = f"{said}; by the time stamps {gap:.3g} sample(s) are missing before it"
            remarks.append(Remark("contiguity_differs", "warning", what, where))
    return remarks


def _ends(files: Sequence[_File], parts: Sequence[_Part], rate: float) -> Times:
    """First and last time there is, as far as it is known without opening more files."""
    last = max((part.last for part in parts), default=files[-1].header.time_zero)
    name = files[-1].pair.name
    ends = [files[0].header.time_zero, last, files[-1].header.time_zero, *([name.stop] if name else [])]
    return np.array([min(ends), max(ends)], dtype=np.int64)


def _joined(
    parts: list[_Part], room: _Room | None, header: PadHeader, frame: str | None, rate: float, path: str
) -> Content:
    """One set of columns; the parts are let go column by column."""
    layout = layout_of(header)
    many, systems = len(parts), {str(part.file.header.data_system) for part in parts}
    if len(systems) > 1 and frame != "sensor":
        raise DataError(
            f"data in {len(systems)} coordinate systems: {'; '.join(sorted(systems))[:160]}",
            where=path,
            do="Read them in the axes of the sensor (--frame sensor), or one file alone",
            code="several_frames",
        )
    if room is not None and room.filled == sum(len(part.time_ns) for part in parts):
        parts = [replace(parts[0], time_ns=room.time_ns[: room.filled], values=[x[: room.filled] for x in room.values])]
    time_ns = _end_to_end([part.time_ns for part in parts])
    columns = tuple(
        number_column(name, _taken(parts, i), unit)
        for i, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True))
    )
    remarks = [*gap_remark(time_ns, rate, path)]
    if not layout.named:
        what = f"{len(layout.names)} columns after the time, without names or units: column_2 to column_14"
        remarks.append(Remark("columns_unnamed", "warning", what, path))
    said = f"PAD, {header.sensor}, {WORDS[header.number_type]}" + (f", {many} files" if many > 1 else "")
    return Content(columns, said, None, header.sample_rate, tuple(remarks), time_ns, header.cutoff)


def _taken(parts: list[_Part], column: int) -> NDArray[Any]:
    """One column end to end; the parts let it go, so that two copies of a day are never there at once."""
    found = _end_to_end([part.values[column] for part in parts])
    for part in parts:
        part.values[column] = found[:0]
    return found


def _end_to_end(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


READER = ArchiveReader(NAME, "PAD pairs", read_archived)
