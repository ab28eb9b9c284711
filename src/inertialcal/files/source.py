"""Bytes of a file: read once, hashed, and unpacked if gzip, within stated limits."""

from __future__ import annotations

import gzip
import hashlib
import io
import shlex
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import DataError, InertialcalError

LARGEST = 4 * 2**30  # bytes of a file, packed or not
RATIO_FROM = 64 * 2**20  # unpacked bytes from which the ratio is looked at
LARGEST_RATIO = 400  # a recording packs 3:1 to 20:1; the format's own end is 1032:1
CHUNK = 2**22
CAMPAIGN = "campaign.toml"
FEW = 3  # names of files told
GZIP = b"\x1f\x8b"


@dataclass(frozen=True)
class Loaded:
    """A file's content."""

    path: str  # As given
    data: bytes  # Unpacked
    sha256: str  # Of the bytes of the file as it lies there, packed or not
    packed: bool = False  # Whether it was gzip


def load(path: str | Path) -> Loaded:
    """Return the content of a file.

    Raises
    ------
    DataError
        If there is no such file, it is no ordinary file, cannot be read, is empty, is larger than 4 GiB
        (also when unpacked), or is a damaged gzip file.
    """
    name = str(path)
    raw = _bytes(Path(path), name)
    sha256 = hashlib.sha256(raw).hexdigest()
    packed = raw.startswith(GZIP)
    data = _unpack(raw, name) if packed else raw
    if not data:
        raise DataError("the file is empty", where=name, do="Record again, or name another", code="empty_file")
    return Loaded(name, data, sha256, packed)


def _bytes(path: Path, name: str) -> bytes:
    """Content of an ordinary file."""
    try:
        if path.is_dir():
            raise _folder(Path(path), name)
        if path.exists() and not path.is_file():
            raise DataError("not a regular file", where=name, code="missing_file")
        size = path.stat().st_size
        if size > LARGEST:
            raise too_large(name, size)
        return path.read_bytes()
    except FileNotFoundError:
        raise DataError("no such file", where=name, do="Check the name and the folder", code="missing_file") from None
    except (OSError, ValueError) as error:  # ValueError: a nul in the name
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"cannot be read: {reason}", where=name, code="missing_file") from None


def _folder(path: Path, name: str) -> DataError:
    """Return the error for a folder where a file is needed, with what may be meant."""
    inside = sorted(one.name for one in path.iterdir() if not one.name.startswith("."))
    if CAMPAIGN in inside:
        do = f"It holds a campaign: inertialcal run {shlex.quote(name)}; or name one of its files"
    elif inside:
        more = f", ... ({len(inside)} in all)" if len(inside) > FEW else ""
        do = f"Name one of its files: {', '.join(inside[:FEW])}{more}"
    else:
        do = "It is empty"
    return DataError("this is a folder, not a file", where=name, do=do, code="missing_file")


def _unpack(raw: bytes, name: str) -> bytes:
    """Content of gzip data, of one or several members."""
    out = io.BytesIO()
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(raw)) as packed:
            while chunk := packed.read(CHUNK):
                out.write(chunk)
                check_size(name, out.tell(), len(raw))
    except (OSError, EOFError, zlib.error) as error:
        raise DataError(
            f"damaged gzip file: {error}",
            where=name,
            why=f"{out.tell()} bytes could be decompressed",
            do="Copy it again from its source",
            code="damaged_file",
        ) from None
    return out.getvalue()


def check_size(name: str, unpacked: int, packed: int) -> None:
    """Refuse content that is larger than memory should take.

    Raises
    ------
    DataError
        If it is larger than 4 GiB, or unpacks more than 400 to 1.
    """
    if unpacked > LARGEST:
        raise too_large(name, unpacked)
    if unpacked > RATIO_FROM and unpacked > LARGEST_RATIO * packed:
        raise DataError(
            f"unpacks to more than {LARGEST_RATIO} times its size",
            where=name,
            why="no recording compresses that well; it would fill the memory",
            do="Unpack it and check by hand",
            code="too_large",
        )


def too_large(name: str, size: int) -> DataError:
    """Return the error for content beyond the limit."""
    return DataError(
        f"holds {size / 2**30:.3g} GiB or more, the limit is {LARGEST / 2**30:.3g} GiB",
        where=name,
        do="Cut it into parts",
        code="too_large",
    )


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
