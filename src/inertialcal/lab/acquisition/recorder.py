"""The recording: MCAP that only grows, a chunk with its checksum at each writing to the disk.

What was acknowledged is on the disk: `Recorder.commit` writes all that was added as one chunk, has the system write it
to the disk (fsync), and then says how many rows of each instrument that makes. A file that a killed process or a lost
power left behind is whole up to its last acknowledged chunk, and is read to there: what follows fails its checksum. A
finished file ends with a checksum of all of it.

There is no index at its end, so that days take no more memory than minutes; readers go through it from its beginning.

References
----------
.. [1] MCAP: mcap.dev/spec.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from ...core.remarks import Remark
from ...files.loggers.rows import ENCODING, LIBRARY, RowLayout
from ...files.write.atomic import BINARY, sync
from ..clock import Instant
from ..instruments.protocol import Batch

try:
    import fcntl
except ImportError:  # no locks: whether it is still written is seen by its sign of life alone
    fcntl = None  # type: ignore[assignment]

RECORDING = "recording.mcap"
MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, METADATA, DATA_END = 1, 2, 3, 4, 5, 6, 12, 15
EVENTS = "lab.events"  # topic of remarks and of what was set, as JSON
EVENT_SCHEMA = b'{"type": "object", "properties": {"kind": {"type": "string"}}}'


class Disk(Protocol):
    """Where bytes go."""

    def write(self, data: bytes) -> None:
        """Write all of it. Raises OSError."""
        ...

    def sync(self) -> None:
        """Return when all that was written is on the disk. Raises OSError."""
        ...

    def close(self) -> None:
        """Close it."""
        ...


class File:
    """A new file, locked for as long as it is written."""

    def __init__(self, path: Path) -> None:
        self._fd = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o644)
        if fcntl is not None:
            with suppress(OSError):  # a file system without locks
                fcntl.flock(self._fd, fcntl.LOCK_EX)
        sync(path.parent)

    def write(self, data: bytes) -> None:
        """Write all of it."""
        view = memoryview(data)
        while view:
            view = view[os.write(self._fd, view) :]

    def sync(self) -> None:
        """Have it written to the disk."""
        os.fsync(self._fd)

    def close(self) -> None:
        """Close it."""
        os.close(self._fd)


def is_written(fd: int) -> bool | None:
    """Tell whether a process writes a recording that is open; None where locks are not known."""
    found = None
    if fcntl is not None:
        try:
            fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
            fcntl.flock(fd, fcntl.LOCK_UN)
            found = False
        except BlockingIOError:
            found = True
        except OSError:  # a file system without locks
            pass
    return found


class Recorder:
    """A recording that is being made.

    Parameters
    ----------
    disk : Disk
        Where it goes.
    layouts : mapping of str to RowLayout
        By instrument.
    about : mapping of str to str
        Texts that are kept in front of the data.
    """

    def __init__(self, disk: Disk, layouts: Mapping[str, RowLayout], about: Mapping[str, str]) -> None:
        self.disk, self.written = disk, 0
        self.acknowledged = dict.fromkeys(layouts, 0)  # rows on the disk, by instrument
        self._crc, self._on_disk = 0, 0
        self._keys = {name: number for number, name in enumerate([*layouts, EVENTS], 1)}
        self._sequence = dict.fromkeys(self._keys, 0)
        self._pending: list[bytes] = []
        self._rows = dict.fromkeys(layouts, 0)
        self._span = (2**63, 0)
        for name, layout in layouts.items():
            self._declare(name, "inertialcal.rows", "inertialcal", layout.schema(), ENCODING)
        self._declare(EVENTS, "inertialcal.event", "jsonschema", EVENT_SCHEMA, "json")
        pairs = b"".join(_text(name) + _text(text) for name, text in about.items())
        self._write(MAGIC + _record(HEADER, _text("") + _text(LIBRARY))
                    + _record(METADATA, _text("lab") + _sized(pairs)))  # fmt: skip

    def _declare(self, topic: str, name: str, encoding: str, schema: bytes, messages: str) -> None:
        key = self._keys[topic]
        self._pending.append(_record(SCHEMA, struct.pack("<H", key) + _text(name) + _text(encoding) + _sized(schema)))
        channel = struct.pack("<HH", key, key) + _text(topic) + _text(messages) + _sized(b"")
        self._pending.append(_record(CHANNEL, channel))

    @property
    def pending(self) -> int:
        """Bytes that are not written."""
        return sum(map(len, self._pending))

    def add(self, name: str, batch: Batch) -> None:
        """Add rows of an instrument."""
        self._message(name, batch.at, batch.rows.tobytes())
        self._rows[name] += len(batch.rows)

    def event(self, at: Instant, kind: str, content: Mapping[str, object]) -> None:
        """Add what happened."""
        self._message(EVENTS, at, json.dumps({"kind": kind, **content}).encode())

    def _message(self, topic: str, at: Instant, data: bytes) -> None:
        head = struct.pack("<HIQQ", self._keys[topic], self._sequence[topic], at.utc_ns, at.monotonic_ns)
        self._pending.append(_record(MESSAGE, head + data))
        self._sequence[topic] = (self._sequence[topic] + 1) % 2**32
        self._span = (min(self._span[0], at.utc_ns), max(self._span[1], at.utc_ns))

    def commit(self) -> dict[str, int]:
        """Write what was added to the disk; return the rows of each instrument that are there now.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        if not self._pending and self.written == self._on_disk:
            return self.acknowledged
        if self._pending:
            records = b"".join(self._pending)
            first, last = self._span if self._span[0] <= self._span[1] else (0, 0)
            head = struct.pack("<QQQI", first, last, len(records), zlib.crc32(records)) + _text("")
            self._write(_record(CHUNK, head + struct.pack("<Q", len(records)) + records))
            self._pending, self._span = [], (2**63, 0)
        self.disk.sync()
        self._on_disk = self.written
        self.acknowledged = dict(self._rows)
        return self.acknowledged

    def finish(self) -> None:
        """Write what is left, and the end.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        self.commit()
        self._write(_record(DATA_END, struct.pack("<I", self._crc)))
        foot = struct.pack("<BQQQ", FOOTER, 20, 0, 0)
        self._write(foot + struct.pack("<I", zlib.crc32(foot)) + MAGIC)
        self.disk.sync()

    def _write(self, data: bytes) -> None:
        self.disk.write(data)
        self.written += len(data)
        self._crc = zlib.crc32(data, self._crc)


def event_of(remark: Remark) -> dict[str, str | int]:
    """Return a remark as it is recorded."""
    return {**remark.to_dict(), "subject": remark.subject}


def _record(op: int, body: bytes) -> bytes:
    return struct.pack("<BQ", op, len(body)) + body


def _sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def _text(text: str) -> bytes:
    return _sized(text.encode())
