"""Formats that are known by their first bytes and not read: each by its name, so that a refusal says what it is."""

from __future__ import annotations

import shlex
import zipfile
from pathlib import Path

from ..core.errors import DataError
from .own import own
from .source import opened

ZIP, ZIP_MEMBER = b"PK\x03\x04", b"PK\x01\x02"
YAML = "YAML, settings or a model and no recording"
UNREAD = (
    (b"#ROSBAG", "a ROS 1 bag of an old version"),
    (b"RIFF", "a RIFF file without sound"),
    (b"%PDF", "a PDF"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x89PNG", "a PNG picture"),
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself (run git lfs pull)"),
)
UNREAD_TEXT = ((b"<", "XML or HTML"), (b"{", "JSON"), (b"%YAML", YAML))  # after blanks
PACKED = (  # and what unpacks them
    (b"BZh", "a bzip2 file", "bunzip2 -k"),
    (b"\xfd7zXZ\x00", "an xz file", "unxz -k"),
    (b"\x28\xb5\x2f\xfd", "a zstd file", "zstd -d"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-zip archive", "7z x"),
)


def refusal(data: bytes, path: str, readable: str) -> DataError | None:
    """Return the error for a format that is known but not read, or for a damaged archive; None for anything else.

    Parameters
    ----------
    data : bytes
        Content, unpacked.
    path : str
        File, for the message.
    readable : str
        Formats that are read.
    """
    if (known := own(Path(path))) is not None:
        return DataError(f"this is {known.what}, no recording", path, do=known.do, code="unsupported_format")
    packed = next((one for one in PACKED if data.startswith(one[0])), None)
    if packed is not None:
        do = f"Unpack it: {packed[2]} {shlex.quote(path)}"
        return DataError(f"this is {packed[1]}, which is read unpacked", where=path, do=do, code="unsupported_format")
    what = _zipped(data) if data.startswith(ZIP) else _unread(data, path)
    if what is None:
        return None
    if not what:
        return DataError("damaged zip archive", where=path, do="Copy it again from its source", code="damaged_file")
    return DataError(
        f"this is {what}, which is not supported",
        where=path,
        do=f"Export it as text or Parquet. Formats read: {readable}",
        code="unsupported_format",
    )


def members(data: bytes) -> list[str]:
    """Return the names in a zip archive; none where it is damaged, or no archive."""
    if not data.startswith(ZIP):
        return []
    try:
        with opened(data) as stream, zipfile.ZipFile(stream) as archive:
            return archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return []


def _zipped(data: bytes) -> str:
    """Return what a zip archive is; empty where it is damaged."""
    found = members(data)
    return "a zip archive (unpack it)" if found else ""


def _unread(data: bytes, path: str) -> str | None:
    """Return which format that is not read this is, by its first bytes."""
    if path.lower().endswith((".yaml", ".yml")) and b"\x00" not in data[:64]:
        return YAML
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    found = next((what for magic, what in UNREAD if data.startswith(magic)), None)
    return found or next((what for magic, what in UNREAD_TEXT if start.startswith(magic)), None)
