"""MATLAB files of versions 4 to 7, by scipy: matrices and structures of matrices.

Version 7.3 is HDF5; an ASCII ``.mat`` is text.

A file of version 5 to 7 is a tree of elements, each a tag (type, number of bytes) and its data; matrices hold elements,
compressed ones hold packed elements [1]_. scipy trusts the types, and crashes on some that are wrong, and on sparse
matrices that are damaged: so the tree is checked first, and what the check does not know is not given to scipy.

References
----------
.. [1] The MathWorks, MAT-File Format, R2019b, chapter 1: tables 1-1 and 1-3, data element format.
"""

from __future__ import annotations

import io
import warnings
import zlib
from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np

from ...core.errors import DataError
from ..budget import check_count, claim, claim_values
from ..columns import Content
from ..formats import ZIP
from ..reader import Reader
from ..source import Loaded, as_data_errors
from .arrays import NamedArray, columns_of

MAGIC = b"MATLAB 5.0 MAT-file"
NEWER = "5 to 7"  # versions
UNITS = "units"  # a structure of texts: the unit of the variable of each name
DEEPEST = 8  # structures within structures
HEADER = 128  # bytes of text, version and byte order
MATRIX, COMPRESSED = 14, 15
SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # by type
FLAGS, DIMENSIONS, NAME = (5, 6), (5, 6), (1, 2, 16)  # types of the first three elements of a matrix
CELL, STRUCTURE, OBJECT, TEXT, SPARSE, NUMBERS = 1, 2, 3, 4, 5, range(6, 16)  # classes of matrices, table 1-3
OPAQUE = 17  # the last class: objects, whose elements are others
MATRICES_DEEPEST = 32  # matrices within matrices
MATRICES = 100_000  # in all, cells and fields among them
CHUNK = 2**20  # bytes that are unpacked at once


def read_matlab4(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the matrices of one length, of a file of version 4; Raises as `read_matlab5`."""
    return _read(loaded, "4", variables)


def read_matlab5(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the matrices of one length, of a file of version 5 to 7.

    Raises
    ------
    DataError
        If it is damaged, or goes beyond the limits of ``files.budget``.
    """
    return _read(loaded, NEWER, variables)


def _read(loaded: Loaded, version: str, variables: Sequence[str] | None) -> Content:
    from scipy import io as scipy_io  # noqa: PLC0415 - heavy import

    with as_data_errors(loaded.path, f"a MATLAB file of version {version}"):
        if version == NEWER:
            check_elements(loaded)
        else:
            claim(loaded.path, loaded.on_disk, 4 * len(loaded.data), "matrices")
        # mat_dtype: doubles that MATLAB packed as bytes come back as doubles; counts stay whole numbers. It
        # also drops imaginary parts, with no more than a warning: then the types as stored tell which.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            content = scipy_io.loadmat(io.BytesIO(loaded.data), mat_dtype=True)
        units = _units(content)
        found = _variables(content)
        if any(issubclass(warning.category, np.exceptions.ComplexWarning) for warning in caught):
            stored = _variables(scipy_io.loadmat(io.BytesIO(loaded.data)))
            found = {name: None if stored.get(name) is None else value for name, value in found.items()}
    arrays = [NamedArray(name, value, units.get(name)) for name, value in found.items() if value is not None]
    skipped = [name for name, value in found.items() if value is None]
    skipped += [f"{UNITS}.{name}" for name in units if name not in found]
    return columns_of(arrays, f"MATLAB {version}", loaded.path, variables=variables, skipped=skipped)


def _units(content: dict[str, Any]) -> dict[str, str]:
    """Take the structure of units out of the content, where it is one of texts alone."""
    value = content.get(UNITS)
    if not isinstance(value, np.ndarray) or value.size != 1 or not value.dtype.names:
        return {}
    texts = {name: value.reshape(-1)[0][name] for name in value.dtype.names}
    if not all(isinstance(one, np.ndarray) and one.dtype.kind == "U" for one in texts.values()):
        return {}
    del content[UNITS]
    return {name: str(one.reshape(-1)[0]) if one.size else "" for name, one in texts.items()}


def _variables(content: dict[str, Any]) -> dict[str, Any]:
    """Each matrix by its full name; None for what is none."""
    return {key: item for name, value in content.items() if name[:2] != "__" for key, item in _flat(name, value)}


def _flat(name: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Each matrix with its full name; None for what is none (complex, text, cells, sparse, arrays of structures)."""
    if not isinstance(value, np.ndarray):
        yield name, None
    elif value.dtype.names is not None and value.size == 1 and depth < DEEPEST:
        for field in value.dtype.names:
            yield from _flat(f"{name}.{field}", value.reshape(-1)[0][field], depth + 1)
    else:
        yield name, value if value.dtype.kind in "biuf" else None


def check_elements(loaded: Loaded) -> None:
    """Refuse a file whose elements do not fit into each other.

    Raises
    ------
    DataError
        If a type is none (``damaged_file``), an element is longer than what holds it, or elements go beyond the
        limits of ``files.budget`` (``too_large``, ``too_many``).
    """
    order: Literal["little", "big"] = "little" if loaded.data[126:128] == b"IM" else "big"
    _Checker(order, loaded).walk(loaded.data, HEADER, len(loaded.data), 0)


class _Checker:
    """One walk through a file; keeps count of what was unpacked."""

    def __init__(self, order: Literal["little", "big"], loaded: Loaded):
        self.order = order
        self.loaded = loaded
        self.path = loaded.path
        self.unpacked = 0
        self.matrices = 0
        self.values = 0

    def walk(self, data: bytes, at: int, end: int, depth: int) -> None:
        """Check the elements between two offsets."""
        while at < end:
            kind, start, size, following = self.tag(data, at, end)
            if kind == COMPRESSED and depth == 0:
                inside = self.unpack(data[start : start + size])
                self.walk(inside, 0, len(inside), 1)
            elif kind == MATRIX:
                self.matrix(data, start, start + size, depth)
            elif kind not in SIZES:
                raise self.damaged(f"type {kind}, which does not exist, at byte {at}")
            at = following

    def tag(self, data: bytes, at: int, end: int) -> tuple[int, int, int, int]:
        """Type, offset and size of an element's data, and the offset behind it."""
        if at + 8 > end:
            raise self.damaged(f"an element cut off at byte {at}")
        first = int.from_bytes(data[at : at + 4], self.order)
        if first >> 16:  # small element: size, type and up to four bytes of data in one tag
            kind, start, size, following = first & 0xFFFF, at + 4, first >> 16, at + 8
            end = min(end, at + 8)
        else:
            kind, start, size = first, at + 8, int.from_bytes(data[at + 4 : at + 8], self.order)
            following = start + size + (0 if kind == COMPRESSED else -size % 8)
        if start + size > end:
            raise self.damaged(f"an element of {size} bytes at byte {at}, only {end - start} left")
        return kind, start, size, following

    def matrix(self, data: bytes, at: int, end: int, depth: int) -> None:
        """Check the elements of a matrix."""
        if depth > MATRICES_DEEPEST:
            raise self.damaged(f"more than {MATRICES_DEEPEST} nested matrices")
        self.matrices += 1
        check_count(self.matrices, MATRICES, "matrices", self.path)
        if at == end:
            return  # an empty cell
        _, start, size, following = self.expected(data, at, end, FLAGS)
        if size != 8:
            raise self.damaged(f"flags of {size} bytes at byte {at}")
        flags = int.from_bytes(data[start : start + 4], self.order)
        kind = flags & 0xFF
        if kind == SPARSE:
            raise DataError(
                "sparse matrices are not supported",
                where=self.path,
                do="Save it as a full matrix: x = full(x)",
                code="sparse_matrix",
            )
        if not CELL <= kind <= OPAQUE:
            raise self.damaged(f"a matrix of class {kind}, which does not exist, at byte {at}")
        if kind != OPAQUE:
            following = self.shape(data, following, end, flags)
        self.walk(data, following, end, depth + 1)

    def shape(self, data: bytes, at: int, end: int, flags: int) -> int:
        """Check dimensions, name and, for numbers, that there are as many as the dimensions say."""
        _, start, size, following = self.expected(data, at, end, DIMENSIONS)
        values = 1
        for offset in range(start, start + size, 4):
            values *= int.from_bytes(data[offset : offset + 4], self.order, signed=True)
        *_, following = self.expected(data, following, end, NAME)
        if values < 0:
            raise self.damaged(f"a matrix of {values} values at byte {at}")
        least = {CELL: 8, STRUCTURE: 8, OBJECT: 8, TEXT: 1}.get(flags & 0xFF, 0)  # bytes that a value takes
        if least * (values - 1) > end - following:  # scipy would make them all first
            raise self.damaged(f"a matrix of {values} values, but the file is too short, at byte {at}")
        if flags & 0xFF == TEXT:
            self.expected(data, following, end, tuple(SIZES))
        parts = 2 if flags & 0x0800 else 1  # real and imaginary
        if flags & 0xFF in (*NUMBERS, CELL, STRUCTURE, OBJECT, TEXT):
            self.values += values
            claim_values(self.path, self.loaded.on_disk, len(self.loaded.data) + 2 * self.unpacked, self.values, 1)
        if flags & 0xFF in NUMBERS:
            for _ in range(parts):
                at = following
                kind, _, size, following = self.expected(data, at, end, tuple(SIZES))
                if size != values * SIZES[kind]:
                    raise self.damaged(f"{size} bytes of numbers for {values} values, at byte {at}")
        return following

    def expected(self, data: bytes, at: int, end: int, kinds: tuple[int, ...]) -> tuple[int, int, int, int]:
        """Check one element of a type that must stand here."""
        found = self.tag(data, at, end)
        if found[0] not in kinds:
            raise self.damaged(f"an element of type {found[0]} out of place at byte {at}")
        return found

    def unpack(self, packed: bytes) -> bytes:
        """Content of a compressed element."""
        unpacker, content, tail, got = zlib.decompressobj(), bytearray(), packed, b"more"
        try:
            while not unpacker.eof and (tail or got):
                got = unpacker.decompress(tail, CHUNK)
                content += got
                tail = unpacker.unconsumed_tail
                whole = self.unpacked + len(content)
                claim(
                    self.path,
                    self.loaded.on_disk,
                    len(self.loaded.data) + 3 * whole,
                    f"{whole:,} bytes unpacked",
                    least=True,
                )
        except zlib.error as error:
            raise self.damaged(f"a compressed element that cannot be decompressed ({error})") from None
        if not unpacker.eof:
            raise self.damaged("a truncated compressed element")
        self.unpacked += len(content)
        return bytes(content)

    def damaged(self, what: str) -> DataError:
        """Return the error for a file that is not what it says."""
        return DataError(
            f"cannot be read as a MATLAB file: it holds {what}",
            where=self.path,
            do="Copy it again from its source, or export it as text",
            code="damaged_file",
        )


def _is_version_4(data: bytes, path: str) -> bool:
    """Whether a file starts with five binary integers; an ASCII one has no nul."""
    return path.lower().endswith(".mat") and b"\x00" in data[:20] and not data.startswith(ZIP)


VERSION_4 = Reader("mat4", "MATLAB", (".mat",), _is_version_4, read_matlab4)
VERSION_5 = Reader("mat5", "MATLAB", (".mat",), lambda data, path: data.startswith(MAGIC), read_matlab5)
