"""What a device would send: rows as lines or packets of a dialect, for replays and for devices to rehearse on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import numpy as np

from ...core.recording import SECOND, Recording
from ...files.loggers.rows import Rows
from .decoder import BYTE_ORDER, SUMS
from .dialect import SUM_BYTES, Dialect, FieldEntry, FrameEntry

STAMP = "stamp"  # name of the stamps of a recording, and of their unit
AXES: Mapping[str, Literal["x", "y", "z"]] = {"x": "x", "y": "y", "z": "z"}
LONGEST = 64  # characters of a name


def dialect_of(recording: Recording) -> Dialect:
    """Return the dialect in which a recording is replayed: lines with its stamps and its channels."""
    fields = [FieldEntry(name=STAMP, type="int64", unit="ns", role="time")]
    taken = {STAMP}
    for number, one in enumerate(recording.channels, 1):
        name = "".join(c if c.isascii() and c.isalnum() else "_" for c in one.name).strip("_")
        name = name if name.isidentifier() and len(name) <= LONGEST and name not in taken else f"channel_{number}"
        taken.add(name)
        whole = one.data.dtype.kind in "iu" and one.data.dtype.itemsize <= 8 and one.data.dtype != np.uint64
        fields.append(FieldEntry(name=name, type="int64" if whole else "float64", unit=one.unit or "",
                                 axis=AXES.get(one.axis, "")))  # fmt: skip
    return Dialect(title="lines of a recording", frame=FrameEntry(kind="lines"), fields=tuple(fields))


def rows_of(recording: Recording, dialect: Dialect, first: int, stop: int) -> Rows:
    """Return samples of a recording as rows of its dialect."""
    layout, stamps = dialect.layout, recording.stamps
    assert layout is not None  # noqa: S101 - made by `dialect_of`
    assert stamps is not None  # noqa: S101 - looked at
    rows = np.empty(stop - first, layout.dtype)
    for one, channel in zip(layout.channels, (None, *recording.channels), strict=True):
        rows[one.name] = stamps[first:stop] if channel is None else channel.data[first:stop]
    return rows


def frames(rows: Rows, dialect: Dialect) -> Iterator[bytes]:
    """Yield each row as the device sends it."""
    frame, end = dialect.frame, dialect.terminator.encode()
    assert frame is not None  # noqa: S101 - rows have one
    separator = frame.separator
    if frame.kind == "packets":
        yield from _packets(rows, dialect, frame)
        return
    for row in rows:
        text = frame.prefix + separator.join(repr(value) for value in row.item())
        if frame.checksum != "none":
            digits = 2 * SUM_BYTES[frame.checksum]
            text += f"*{SUMS[frame.checksum](text.removeprefix('$').encode()):0{digits}X}"
        yield text.encode() + end


def _packets(rows: Rows, dialect: Dialect, frame: FrameEntry) -> Iterator[bytes]:
    kinds = {one.name: np.dtype(one.type).newbyteorder(BYTE_ORDER[frame.byte_order])
             for one in dialect.fields if one.type != "pad"}  # fmt: skip
    for row in rows:
        body = dialect.sync
        for one in dialect.fields:
            body += bytes(one.bytes) if one.type == "pad" else np.array(row[one.name], kinds[one.name]).tobytes()
        covered = body if frame.checksum_over == "all" else body[len(dialect.sync) :]
        size = SUM_BYTES[frame.checksum]
        yield body + (SUMS[frame.checksum](covered).to_bytes(size, frame.byte_order) if size else b"")


def due(recording: Recording) -> list[float]:
    """Return when each sample is sent, since the first [s]."""
    stamps = recording.stamps
    assert stamps is not None  # noqa: S101 - looked at
    return ((stamps - stamps[0]) / SECOND).tolist() if len(stamps) else []
