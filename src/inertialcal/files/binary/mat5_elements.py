"""Elements of a MATLAB 5 to 7 file, checked before a reader in C follows them.

Such a file is a tree of elements, each a tag (type, number of bytes) and its data; matrices hold elements,
compressed ones hold packed elements. scipy trusts the types, and crashes on one that there is not: a damaged
file would end the program without a word.

References
----------
.. [1] The MathWorks, MAT-File Format, R2019b, chapter 1: tables 1-1 and 1-3, data element format.
"""

from __future__ import annotations

import zlib
from typing import Literal

from ...core.errors import DataError
from ..source import LARGEST, check_size, too_large

HEADER = 128  # bytes of text, version and byte order
MATRIX, COMPRESSED = 14, 15
SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # by type
FLAGS, DIMENSIONS, NAME = (5, 6), (5, 6), (1, 2, 16)  # types of the first three elements of a matrix
OPAQUE = 17  # class of objects: their elements are others
DEEPEST = 32  # matrices within matrices


def check_elements(data: bytes, path: str) -> None:
    """Refuse a file whose elements do not fit into each other.

    Raises
    ------
    DataError
        If a type is none (``damaged_file``), an element is longer than what holds it, or unpacked elements
        are larger than the limits of ``files.source`` (``too_large``).
    """
    order: Literal["little", "big"] = "little" if data[126:128] == b"IM" else "big"
    _Checker(order, path, len(data)).walk(data, HEADER, len(data), 0)


class _Checker:
    """One walk through a file; keeps count of what was unpacked."""

    def __init__(self, order: Literal["little", "big"], path: str, packed: int):
        self.order = order
        self.path = path
        self.packed = packed
        self.unpacked = 0

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
                raise self.damaged(f"type {kind}, which there is not, at byte {at}")
            at = following

    def tag(self, data: bytes, at: int, end: int) -> tuple[int, int, int, int]:
        """Type, offset and size of an element's data, and the offset behind it."""
        if at + 8 > end:
            raise self.damaged(f"an element that is cut off at byte {at}")
        first = int.from_bytes(data[at : at + 4], self.order)
        if first >> 16:  # small element: size, type and up to four bytes of data in one tag
            kind, start, size, following = first & 0xFFFF, at + 4, first >> 16, at + 8
            end = min(end, at + 8)
        else:
            kind, start, size = first, at + 8, int.from_bytes(data[at + 4 : at + 8], self.order)
            following = start + size + (0 if kind == COMPRESSED else -size % 8)
        if start + size > end:
            raise self.damaged(f"an element of {size} bytes at byte {at}, where {end - start} are left")
        return kind, start, size, following

    def matrix(self, data: bytes, at: int, end: int, depth: int) -> None:
        """Check the elements of a matrix."""
        if depth > DEEPEST:
            raise self.damaged(f"more than {DEEPEST} matrices within each other")
        if at == end:
            return  # an empty cell
        _, start, size, following = self.expected(data, at, end, FLAGS)
        if size != 8:
            raise self.damaged(f"flags of {size} bytes at byte {at}")
        flags = int.from_bytes(data[start : start + 4], self.order)
        if flags & 0xFF != OPAQUE:
            following = self.shape(data, following, end, flags)
        self.walk(data, following, end, depth + 1)

    def shape(self, data: bytes, at: int, end: int, flags: int) -> int:
        """Check dimensions, name and, for numbers, that there are as many as the dimensions say."""
        _, start, size, following = self.expected(data, at, end, DIMENSIONS)
        values = 1
        for offset in range(start, start + size, 4):
            values *= int.from_bytes(data[offset : offset + 4], self.order, signed=True)
        *_, following = self.expected(data, following, end, NAME)
        if not 0 <= values <= LARGEST:
            raise self.damaged(f"a matrix of {values} values at byte {at}")
        parts = 2 if flags & 0x0800 else 1  # real and imaginary
        if 6 <= flags & 0xFF <= 15:
            for _ in range(parts):
                following = self.numbers(data, following, end, values)
        return following

    def numbers(self, data: bytes, at: int, end: int, values: int) -> int:
        """Check the numbers of a matrix, and return the offset behind them."""
        kind, _, size, following = self.expected(data, at, end, tuple(SIZES))
        if size != values * SIZES[kind]:
            raise self.damaged(f"{size} bytes of numbers where {values} values are announced, at byte {at}")
        return following

    def expected(self, data: bytes, at: int, end: int, kinds: tuple[int, ...]) -> tuple[int, int, int, int]:
        """Check one element of a type that must stand here."""
        found = self.tag(data, at, end)
        if found[0] not in kinds:
            raise self.damaged(f"an element of type {found[0]} out of place at byte {at}")
        return found

    def unpack(self, packed: bytes) -> bytes:
        """Content of a compressed element."""
        unpacker = zlib.decompressobj()
        try:
            content = unpacker.decompress(packed, LARGEST + 1 - self.unpacked)
        except zlib.error as error:
            raise self.damaged(f"a compressed element that cannot be unpacked ({error})") from None
        if not unpacker.eof and len(content) + self.unpacked <= LARGEST:
            raise self.damaged("a compressed element that is cut off")
        self.unpacked += len(content)
        if self.unpacked > LARGEST:
            raise too_large(self.path, self.unpacked)
        check_size(self.path, self.unpacked, self.packed)
        return content

    def damaged(self, what: str) -> DataError:
        """Return the error for a file that is not what it says."""
        return DataError(
            f"cannot be read as a MATLAB file: it holds {what}",
            where=self.path,
            do="Copy it again from its source, or export it as text",
            code="damaged_file",
        )
