"""Formats: told by their bytes, and the ones that are not read named."""

from __future__ import annotations

import io
import zipfile

import pytest

from inertialcal.core.errors import DataError
from inertialcal.files.formats import UNREAD
from inertialcal.files.registry import find_reader
from inertialcal.files.source import Loaded


def recognise(data: bytes, name: str) -> str:
    return find_reader(Loaded(name, data, "")).name


def _zip(*names: str) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name in names:
            archive.writestr(name, "x")
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "name", "expected"),
    [
        (b"PAR1....", "a.csv", "parquet"),
        (b"\x93NUMPY\x01\x00", "a", "npy"),
        (b"MATLAB 5.0 MAT-file, ...", "a.mat", "mat5"),
        (b"\x89HDF\r\n\x1a\n", "a.h5", "hdf5"),
        (b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n", "a.mat", "hdf5"),
        (b"\x00\x00\x00\x00\x05\x00\x00\x00", "a.MAT", "mat4"),
        (b"  1.0  2.0\n", "a.mat", "text"),
        (_zip("x.npy"), "a.npz", "npz"),
        (_zip("xl/workbook.xml"), "a.csv", "excel"),
        (_zip("mimetype", "content.xml"), "a.ods", "excel"),
        (b"RIFF\x00\x00\x00\x00WAVEfmt ", "a", "wav"),
        (b"    -1\n    58\n", "a.txt", "uff"),
        (b"    -1\r\n    58b     1     1", "a.uff", "uff"),
        (b"-1\n58\n57\n", "a.txt", "text"),
        (b"#ROSBAG V2.0\n", "a", "rosbag1"),
        (b"FMT, 128, 89, FMT, BBnNZ, Type\n", "a.log", "dataflash_text"),
        (b"000001D IU COLA", "a", "miniseed"),
        (b"000001,2\n3,4\n", "a.csv", "text"),
        (b'{"t": 1}\n{"t": 2}\n', "a.csv", "json_lines"),
        (b'\xef\xbb\xbf{"t": [1]}\r\n{"t"', "a", "json_lines"),
        (b"t,x\n1,2\n", "a.parquet", "text"),
    ],
)
def test_formats_that_are_read(data: bytes, name: str, expected: str) -> None:
    assert recognise(data, name) == expected


@pytest.mark.parametrize(("magic", "what"), UNREAD)
def test_formats_that_are_not(magic: bytes, what: str) -> None:
    with pytest.raises(DataError) as caught:
        recognise(magic + b"...", "a.bin")
    (problem,) = caught.value.problems
    assert problem.what == f"this is {what}, which is not supported"
    assert problem.code == "unsupported_format"
    assert "Formats read: CSV and other text, Parquet, MATLAB" in problem.do


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"\xef\xbb\xbf <?xml version", "XML or HTML"),
        (b'{"a": 1}', "JSON"),
        (b'{"a":\n{"b": 1}}', "JSON"),
        (_zip("a.csv"), r"a zip archive \(unpack it\)"),
    ],
)
def test_other_formats_that_are_not(data: bytes, what: str) -> None:
    with pytest.raises(DataError, match=f"this is {what}, which is not supported"):
        recognise(data, "a")


def test_a_damaged_archive() -> None:
    with pytest.raises(DataError, match="damaged zip archive"):
        recognise(_zip("x.npy")[:-30], "a.npz")
