"""Which format a file is in: by what its first bytes say, then by the ending of its name."""

from __future__ import annotations

import io
import zipfile
from typing import Literal

from ..core.errors import DataError

Format = Literal["text", "parquet", "hdf5", "mat5", "mat4", "npy", "npz"]

READABLE = "CSV and other text, Parquet, MATLAB, HDF5, NumPy, PAD pairs"
HDF5 = b"\x89HDF\r\n\x1a\n"
HDF5_AT = (0, 512, 1024, 2048)  # a user block may stand first (HDF5 file format, II.A)
MAGIC: tuple[tuple[bytes, Format], ...] = (
    (b"PAR1", "parquet"),
    (b"\x93NUMPY", "npy"),
    (b"MATLAB 5.0 MAT-file", "mat5"),
)
UNREAD = (
    (b"LabVIEW Measurement", "a LabVIEW measurement file (.lvm)"),
    (b"\x1a\x45\xdf\xa3", "an EBML recorder file (enDAQ .IDE)"),
    (b"TDSm", "a National Instruments TDMS file"),
    (b"MDF     ", "an ASAM MDF file"),
    (b"ULog\x01\x12\x35", "a PX4 ULog"),
    (b"\xa3\x95", "an ArduPilot data-flash log"),
    (b"#ROSBAG", "a ROS 1 bag"),
    (b"\x89MCAP0\r\n", "an MCAP file"),
    (b"SQLite format 3\x00", "an SQLite database (ROS 2 bag?)"),
    (b"RIFF", "a RIFF file (WAV?)"),
    (b"ARROW1", "an Arrow IPC (Feather) file"),
    (b"\xd0\xcf\x11\xe0", "an old Excel file"),
    (b"%PDF", "a PDF"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x89PNG", "a PNG picture"),
    (b"BZh", "a bzip2 file"),
    (b"\xfd7zXZ\x00", "an xz file"),
    (b"\x28\xb5\x2f\xfd", "a zstd file"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-zip archive"),
    (b"version https://git-lfs", "a pointer of Git LFS, not the file itself (git lfs pull)"),
)
UNREAD_TEXT = ((b"<", "XML or HTML"), (b"{", "JSON"))  # after blanks


def recognise(data: bytes, name: str) -> Format:
    """Return the format of a file's content.

    Parameters
    ----------
    data : bytes
        Content, unpacked.
    name : str
        Path; its ending decides between what bytes cannot tell apart.

    Raises
    ------
    DataError
        If it is of a known format that is not read.
    """
    for magic, found in MAGIC:
        if data.startswith(magic):
            return found
    if any(data[at : at + len(HDF5)] == HDF5 for at in HDF5_AT):
        return "hdf5"
    if data.startswith(b"PK\x03\x04"):
        return _zipped(data, name)
    if name.lower().endswith(".mat") and b"\x00" in data[:20]:
        return "mat4"  # a version 4 file starts with five binary integers, an ASCII one has no nul
    _refuse_unread(data, name)
    return "text"


def _refuse_unread(data: bytes, name: str) -> None:
    """Raise for formats that are known but not read."""
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    for magic, what in UNREAD:
        if data.startswith(magic):
            raise unread(what, name)
    for magic, what in UNREAD_TEXT:
        if start.startswith(magic):
            raise unread(what, name)


def _zipped(data: bytes, name: str) -> Format:
    """``npz``, or an error that names what else is in the archive."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        raise DataError(
            "damaged zip archive", where=name, do="Copy it again from its source", code="damaged_file"
        ) from None
    if any(member.endswith(".npy") for member in members):
        return "npz"
    if "xl/workbook.xml" in members:
        raise unread("an Excel workbook (save it as CSV)", name)
    raise unread("a zip archive (unpack it)", name)


def unread(what: str, name: str) -> DataError:
    """Return the error for a format that is known but not read."""
    return DataError(
        f"this is {what}, which is not read yet",
        where=name,
        do=f"Export it as text or Parquet. Formats read: {READABLE}",
        code="unsupported_format",
    )
