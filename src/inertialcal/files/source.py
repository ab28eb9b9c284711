"""Bytes of a file: read once, hashed, and unpacked if gzip, within the limits of ``budget``.

Every file of a user is read by `load` or `read_bytes`: only an ordinary file, and no more of it than its size. A long
one may stay where it is, for a reader that takes it piece by piece (`FileBytes`).
"""

from __future__ import annotations

import hashlib
import io
import os
import stat
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, cast, overload

from ..core import batches
from ..core.errors import DataError, InertialcalError, Problem, UsageError
from ..core.recording import Digest
from ..core.remarks import Remark
from .budget import DOCUMENT, check_count, claim
from .own import own

AT_ONCE = 2**17  # bytes that are hashed at once; more of them by a thread
CACHED = 2**29  # bytes of a file in place that a system still holds when it was read: hashed then, else meanwhile
CHUNK = 2**22  # bytes that are unpacked at once
HASHED = 2**18  # bytes of a file in place that are hashed at once: a cache holds them
SHORT = 2**24  # bytes of a file that is read whole, whatever its reader can: one reading for all that look at it
FIRST, STEP = 2**10, 2**16  # bytes of a gzip member that are unpacked first, as members can be tiny, and then
PIECE = 2**12  # bytes of a file in place that are read for one
MEMBERS = 200_000  # of a gzip file; bgzip makes one of each 64 KiB
HAS_PREAD = hasattr(os, "pread")
NO_WAIT = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOCTTY", 0)
FEW = 3  # names of files told
GZIP = b"\x1f\x8b"
SOUGHT = b"PAR1"  # format whose library reads what it needs, where it lies


@dataclass(frozen=True)
class Loaded:
    """A file's content."""

    path: str  # As given
    data: bytes  # Unpacked; of a file that stays in place, `FileBytes`
    hashed: str | Digest  # SHA-256 of the bytes of the file as it lies there, packed or not; or who works it out
    packed: bool = False  # Whether it was gzip
    size: int = 0  # Bytes of the file as it lies there

    @property
    def sha256(self) -> str:
        """SHA-256 of the bytes of the file as it lies there, packed or not."""
        return self.hashed if isinstance(self.hashed, str) else self.hashed.result()

    @property
    def on_disk(self) -> int:
        """Bytes of the file as it lies there; of its content where nobody said."""
        return self.size or len(self.data)


def checked_path(given: object, what: str = "file") -> str | os.PathLike[str]:
    """Return a path that a call was given.

    Raises
    ------
    UsageError
        ``wrong_type``, if it is none: a Recording, a list, an array.
    """
    if isinstance(given, str) or (isinstance(given, os.PathLike) and isinstance(os.fspath(given), str)):
        return given
    called = f"a {what} is named by its path, not by a value of type {type(given).__name__}"
    raise UsageError(called, do="Give a path", code="wrong_type")


def load(path: str | os.PathLike[str], *, document: bool = False, in_place: bool = False) -> Loaded:
    """Return the content of a file.

    Parameters
    ----------
    path : path
        Of the file.
    document : bool
        Whether it is parsed whole, as JSON is.
    in_place : bool
        Whether a long file that is not packed may stay where it is, as `FileBytes`; `settled` then says, after it was
        read, whether it was still the same.

    Raises
    ------
    DataError
        ``missing_file`` (also a folder, a pipe, a device), ``empty_file``, ``damaged_file`` (gzip),
        ``too_large``.
    """
    name = str(path)
    if in_place and (long := _in_place(path)) is not None:
        return long
    raw = read_bytes(path)
    hashed = _hash(raw) if len(raw) <= AT_ONCE else Digest(lambda: _hash(raw))
    packed = raw.startswith(GZIP)
    data = _unpack(raw, name) if packed else raw
    if not data:
        raise DataError("the file is empty", where=name, do="Record again, or name another", code="empty_file")
    if document or name.lower().endswith(".json"):
        claim(name, len(raw), DOCUMENT * len(data), f"{len(data):,} bytes of structured text")
    return Loaded(name, data, hashed, packed, len(raw))


def _hash(raw: bytes) -> str:
    return hashlib.sha256(raw).hexdigest()


def whole(loaded: Loaded) -> Loaded:
    """Return the content of a file in memory, also where it had stayed in place; Raises as `load`."""
    return load(loaded.path) if isinstance(loaded.data, FileBytes) else loaded


class FileBytes:
    """Bytes of a file that stay there: a piece is read where one is asked for."""

    def __init__(self, path: str | os.PathLike[str], most: int | None = None) -> None:
        self.path = path
        self._file = open(path, "rb")  # noqa: SIM115 - as long as somebody holds the bytes
        about = os.fstat(self._file.fileno())
        self._size = about.st_size if most is None else min(about.st_size, most)
        self._stamps = _stamps(about)
        self._at, self._piece = 0, b""

    def __del__(self) -> None:
        self._file.close()

    def __len__(self) -> int:
        return self._size

    @overload
    def __getitem__(self, at: int) -> int: ...

    @overload
    def __getitem__(self, at: slice) -> bytes: ...

    def __getitem__(self, at: int | slice) -> int | bytes:
        """Return one byte, or those of a slice without a step."""
        if isinstance(at, slice):
            first, stop, _ = at.indices(self._size)
            if HAS_PREAD and stop - first <= PIECE:  # a page of a file has such a header: a tenth of the time
                return os.pread(self._file.fileno(), max(stop - first, 0), first)
            self._file.seek(first)
            return self._file.read(max(stop - first, 0))
        if not self._at <= at < self._at + len(self._piece):
            self._at, self._piece = at, self[at : at + PIECE]
        return self._piece[at - self._at]

    def count(self, part: bytes) -> int:
        """Return how often some bytes, no end of which is a beginning of them, stand in the file."""
        found, tail = 0, b""
        self._file.seek(0)
        while block := self._file.read(CHUNK):
            held = tail + block
            found += held.count(part)
            tail = held[max(len(held) - len(part) + 1, 0) :]
        return found

    def sha256(self) -> str:
        """Return the SHA-256 of the bytes that the file had when it was opened."""
        self._file.seek(0)
        digest, block, left = hashlib.sha256(), bytearray(HASHED), self._size
        while left and (got := self._file.readinto(memoryview(block)[:left])):
            digest.update(memoryview(block)[:got])
            left -= got
        return digest.hexdigest()

    def is_unchanged(self) -> bool:
        """Whether the file of that path is the one that was opened, and was not written to since."""
        try:
            return _stamps(os.stat(self.path)) == self._stamps
        except OSError:
            return False

    def has_grown(self, digest: str) -> bool:
        """Whether the file was only written on since it was opened, when it had that SHA-256: a log that goes on."""
        try:
            about = os.stat(self.path)
            same = (about.st_dev, about.st_ino) == self._stamps[:2] and about.st_size > self._size
            return same and FileBytes(self.path, self._size).sha256() == digest  # not what is buffered
        except OSError:
            return False

    def startswith(self, magic: bytes | tuple[bytes, ...]) -> bool:
        """Whether the file begins so."""
        return self[:PIECE].startswith(magic)


def opened(data: bytes) -> IO[bytes]:
    """Return what reads the content of a file from its beginning, also where it stays in place."""
    return open(data.path, "rb") if isinstance(data, FileBytes) else io.BytesIO(data)


def _stamps(about: os.stat_result) -> tuple[int, ...]:
    return about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns


def settled(loaded: Loaded, *, may_grow: bool = False) -> tuple[str | Digest, tuple[Remark, ...]]:
    """Return the SHA-256 of what was read of a file, or who works it out, and a remark where it was written on.

    What can be worked out from now on as well is not waited for: of bytes in memory, and of a file in place that is
    looked at once more then.

    ``may_grow``: whether its reader takes nothing behind what the file was when it was opened.

    Raises
    ------
    DataError
        ``input_changed``, if it stayed in place, and what was read of it is no longer there.
    """
    hashed = loaded.hashed
    if isinstance(loaded.data, FileBytes):
        hashed = hashed if _is_late(loaded.data) else loaded.sha256
        if not loaded.data.is_unchanged():
            if not (may_grow and loaded.data.has_grown(loaded.sha256)):
                raise DataError(changed_input(loaded.path))
            what = f"the file was written on while it was read: its first {len(loaded.data):,} bytes were taken"
            do = "Read it again when it is complete"
            return loaded.sha256, (Remark("still_written", "warning", what, loaded.path, do=do),)
    if isinstance(hashed, Digest):
        hashed.begin()
    return hashed, ()


def _is_late(data: FileBytes) -> bool:
    """Whether a file in place is hashed after it was read: its library reads it with all that the machine has."""
    return len(data) <= CACHED and data.startswith(SOUGHT)


def changed_input(path: str, what: str = "the file changed while it was read") -> Problem:
    """Return the problem of an input that is no longer what was read."""
    why = "the results would be of a mixture"
    return Problem(what, path, why, "Wait until it is complete, then run again", "input_changed")


def _in_place(path: str | os.PathLike[str]) -> Loaded | None:
    """Return the content of a long file that stays where it is; None of a short one, and of a packed one."""
    try:
        size = os.stat(path).st_size
        if size <= min(AT_ONCE, batches.HELD) or not os.path.isfile(path):
            return None
        data = FileBytes(path)
        if data.startswith(GZIP) or (size <= batches.HELD and (size <= SHORT or not data.startswith(SOUGHT))):
            return None
        same = FileBytes(path, len(data))  # its place in the file is its own
    except (OSError, ValueError):  # said where it is read whole
        return None
    late = _is_late(data)

    def digest() -> str:
        found = same.sha256()
        if late and not data.is_unchanged():
            what, why = "the file changed before it was hashed", "its hash would not be that of what was read"
            raise DataError(replace(changed_input(str(path), what), why=why))
        return found

    hashed = Digest(digest)
    if not late:
        hashed.begin()
    return Loaded(str(path), cast("bytes", data), hashed, False, len(data))


def read_bytes(path: str | os.PathLike[str], most: int | None = None) -> bytes:
    """Return the bytes of an ordinary file as it lies there; of ``most`` at most where that is given.

    Raises
    ------
    DataError
        ``missing_file``, ``too_large``.
    """
    name = str(path)
    try:
        if os.path.isdir(path):
            raise _folder(Path(path), name)
        with open(os.open(path, os.O_RDONLY | NO_WAIT), "rb") as stream:
            about = os.fstat(stream.fileno())
            if not stat.S_ISREG(about.st_mode):
                raise _special(about.st_mode, name)
            size = about.st_size if most is None else min(about.st_size, most)
            claim(name, size, size, "the content")
            return stream.read(size)  # a file that says it is empty and is not (/proc) counts as empty
    except FileNotFoundError:
        raise DataError("no such file", where=name, do="Check the name and the folder", code="missing_file") from None
    except (OSError, ValueError) as error:  # ValueError: a nul in the name
        try:  # a socket cannot be opened
            mode = os.stat(path).st_mode
        except (OSError, ValueError):
            mode = stat.S_IFREG
        if not stat.S_ISREG(mode):
            raise _special(mode, name) from None
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"cannot be read: {reason}", where=name, code="missing_file") from None


def _special(mode: int, name: str) -> DataError:
    """Return the error for a pipe, a socket or a device."""
    what = (
        "a pipe"
        if stat.S_ISFIFO(mode)
        else "a socket"
        if stat.S_ISSOCK(mode)
        else "a folder"
        if stat.S_ISDIR(mode)
        else "a device"
    )
    do = "Save what it gives as a file, and name that"
    return DataError(f"not a regular file but {what}", where=name, do=do, code="missing_file")


def _folder(path: Path, name: str) -> DataError:
    """Return the error for a folder where a file is needed, with what may be meant."""
    inside = sorted(one.name for one in path.iterdir() if not one.name.startswith("."))
    if (known := own(path)) is not None:
        do = f"It holds {known.what}: {known.do}; or name one of its files"
    elif inside:
        more = f", ... ({len(inside)} in all)" if len(inside) > FEW else ""
        do = f"Name one of its files: {', '.join(inside[:FEW])}{more}"
    else:
        do = "It is empty"
    return DataError("this is a folder, not a file", where=name, do=do, code="missing_file")


def _unpack(raw: bytes, name: str) -> bytes:
    """Content of gzip data, of one or several members."""
    out, at, members, why = bytearray(), 0, 0, ""
    while at < len(raw) and not why:
        start = raw[at : at + FIRST]
        if not start[0]:  # a file may be filled up with nuls
            at += len(start) - len(start.lstrip(b"\x00"))
            continue
        members += 1
        check_count(members, MEMBERS, "gzip members", name)
        member, fed = zlib.decompressobj(wbits=31), start
        try:
            while not member.eof and not why:
                at += len(fed)
                got = member.decompress(member.unconsumed_tail or fed, CHUNK)
                out += got
                claim(name, len(raw), len(raw) + 2 * len(out), f"{len(out):,} bytes unpacked", least=True)
                fed = b"" if member.unconsumed_tail else raw[at : at + STEP]
                if not (got or fed or member.unconsumed_tail or member.eof):
                    why = "it ends too early"
            at -= len(member.unused_data)
        except zlib.error as error:
            why = str(error)
    if why:
        raise DataError(
            f"damaged gzip file: {why}",
            where=name,
            why=f"{len(out)} bytes could be decompressed",
            do="Copy it again from its source",
            code="damaged_file",
        )
    return bytes(out)


LONGEST = 160  # characters of their message


@contextmanager
def as_data_errors(where: str, what: str) -> Iterator[None]:
    """Turn any error of a foreign reader into a DataError; its warnings are not shown.

    Parameters
    ----------
    where : str
        File.
    what : str
        What the file is meant to be: ``"a Parquet file"``.

    Raises
    ------
    DataError
        With code ``damaged_file``.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InertialcalError:
        raise
    except Exception as error:
        said = " ".join(str(error).split())[:LONGEST] or type(error).__name__
        raise DataError(
            f"cannot be read as {what}: {said}",
            where=where,
            do="Copy it again from its source, or export it as text",
            code="damaged_file",
        ) from None
