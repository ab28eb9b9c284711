"""Elements of MATLAB files: sound ones pass, each kind of damage is refused with its place."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import io as scipy_io
from scipy import sparse

from inertialcal.core.errors import DataError
from inertialcal.files import read
from inertialcal.files.binary.matlab import check_elements
from inertialcal.files.budget import max_memory
from inertialcal.files.source import Loaded

HEADER = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def element(kind: int, data: bytes, order: str = "<") -> bytes:
    return struct.pack(order + "II", kind, len(data)) + data + bytes(-len(data) % 8)


def matrix(values: bytes, count: int, flags: int = 6, order: str = "<") -> bytes:
    parts = [
        element(6, struct.pack(order + "II", flags, 0), order),
        element(5, struct.pack(order + "ii", 1, count), order),
        element(1, b"x", order),
        element(9, values, order),
    ]
    return element(14, b"".join(parts), order)


THREE = struct.pack("<3d", 1.0, 2.0, 3.0)


def refused(data: bytes) -> str:
    with pytest.raises(DataError) as caught:
        check_elements(Loaded("a.mat", data, ""))
    (problem,) = caught.value.problems
    assert (problem.where, problem.code) == ("a.mat", "damaged_file")
    return problem.what.removeprefix("cannot be read as a MATLAB file: it holds ")


@pytest.mark.parametrize("compression", [False, True])
def test_what_scipy_writes(compression: bool) -> None:
    content: dict[str, Any] = {
        "x": np.arange(5) / 3, "i": np.arange(4, dtype=np.int16), "z": np.ones(3) * 1j, "t": "text",
        "s": {"a": [1, 2], "b": {"c": "d"}}, "cell": np.array([[1], "a"], dtype=object), "l": np.ones(3, bool),
        "e": np.zeros((0, 3)),
    }  # fmt: skip
    stream = io.BytesIO()
    scipy_io.savemat(stream, content, do_compression=compression)
    check_elements(Loaded("a.mat", stream.getvalue(), ""))


def test_both_byte_orders() -> None:
    check_elements(Loaded("a.mat", HEADER + matrix(THREE, 3), ""))
    values = struct.pack(">3d", 1.0, 2.0, 3.0)
    big = HEADER[:-4] + b"\x01\x00MI" + matrix(values, 3, order=">")
    check_elements(Loaded("a.mat", big, ""))
    assert scipy_io.loadmat(io.BytesIO(big))["x"].tolist() == [[1.0, 2.0, 3.0]]


def test_an_empty_file_and_an_empty_cell() -> None:
    check_elements(Loaded("a.mat", HEADER, ""))
    check_elements(Loaded("a.mat", HEADER + element(14, b""), ""))


def test_a_type_that_there_is_not() -> None:
    assert refused(HEADER + element(217, bytes(8))) == "type 217, which does not exist, at byte 128"
    inside = matrix(THREE, 3).replace(struct.pack("<II", 9, 24), struct.pack("<II", 217, 24))
    assert refused(HEADER + inside) == "an element of type 217 out of place at byte 184"


def test_an_element_longer_than_the_file() -> None:
    assert refused((HEADER + matrix(THREE, 3))[:-8]) == "an element of 80 bytes at byte 128, only 72 left"
    assert refused(HEADER + b"\x09\x00\x00") == "an element cut off at byte 128"


def test_more_or_fewer_numbers_than_announced() -> None:
    assert refused(HEADER + matrix(THREE, 4)) == "24 bytes of numbers for 4 values, at byte 184"
    assert refused(HEADER + matrix(THREE, -3)) == "a matrix of -3 values at byte 152"
    assert refused(HEADER + matrix(THREE, 3, flags=0x0806)).endswith("at byte 216")  # no imaginary part follows


def test_compressed_elements() -> None:
    packed = zlib.compress(matrix(THREE, 3))
    check_elements(Loaded("a.mat", HEADER + element(15, packed)[: 8 + len(packed)], ""))
    assert refused(HEADER + element(15, packed[:-6])) == "a truncated compressed element"
    assert refused(HEADER + element(15, b"nonsense")).startswith("a compressed element that cannot be decompressed")
    assert refused(HEADER + element(15, zlib.compress(matrix(THREE, 4)))).startswith("24 bytes of numbers for 4")


def test_matrices_without_end() -> None:
    nested = matrix(THREE, 3)
    for _ in range(40):
        head = element(6, struct.pack("<II", 1, 0)) + element(5, struct.pack("<ii", 1, 1)) + element(1, b"")
        nested = element(14, head + nested)
    assert refused(HEADER + nested) == "more than 32 nested matrices"


def test_compressed_zeros_stop_early() -> None:
    data = HEADER + element(15, zlib.compress(bytes(10**7)))
    with max_memory("265 MiB"), pytest.raises(DataError, match="needs more than 265 MiB of memory") as caught:
        check_elements(Loaded("a.mat", data, ""))
    assert caught.value.problems[0].code == "too_large"


def test_a_sparse_matrix_is_refused_and_says_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "sparse.mat"
    scipy_io.savemat(path, {"t": np.arange(5.0), "x": sparse.csc_matrix(np.eye(5))})
    with pytest.raises(DataError, match="sparse matrices") as caught:
        read(path)
    assert (caught.value.problems[0].code, caught.value.problems[0].where) == ("sparse_matrix", str(path))
    assert "full(x)" in caught.value.problems[0].do


@pytest.mark.parametrize("kind", [0, 18, 200])
def test_a_class_that_there_is_not(kind: int) -> None:
    assert (
        refused(HEADER + matrix(THREE, 3, flags=kind)) == f"a matrix of class {kind}, which does not exist, at byte 136"
    )


@pytest.mark.parametrize("kind", [1, 2, 4])
def test_more_cells_than_the_file_has_bytes(kind: int) -> None:
    """scipy makes room for them all before it looks for the first: a damaged dimension takes minutes."""
    assert refused(HEADER + matrix(THREE, 10**9, flags=kind)).startswith("a matrix of 1000000000 values, but the file")


def test_a_text_without_its_letters() -> None:
    """scipy would take what follows the matrix for them, and crash."""
    parts = matrix(THREE, 1, flags=4)[8:-32]  # flags, dimensions, name
    assert refused(HEADER + element(14, parts)).startswith("an element cut off at byte")
