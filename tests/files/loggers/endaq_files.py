"""Recordings of an enDAQ recorder, element by element as its scheme says: nothing of the library that reads them.

Whole numbers of 32 bits in blocks of 200 samples, a polynomial a subchannel, clock of 32768 Hz since an instant in UTC.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

TICKS, BLOCK = 32_768, 200  # a second, samples
CHANNELS = (8, 80, 59, 36)  # their numbers


class Subchannel(NamedTuple):
    """A column: name, quantity, unit, what a count is, counts."""

    name: str
    label: str
    unit: str
    scale: float
    counts: NDArray[np.int64]


class Group(NamedTuple):
    """Subchannels of one clock."""

    name: str
    sample_rate: float
    columns: Sequence[Subchannel]


def element(number: int, content: bytes) -> bytes:
    """Return an element: its number, its length in eight bytes, what it holds."""
    return (
        number.to_bytes((number.bit_length() + 7) // 8, "big") + (len(content) | 1 << 56).to_bytes(8, "big") + content
    )


def _whole(number: int, value: int) -> bytes:
    return element(number, value.to_bytes(8, "big"))


def _real(number: int, value: float) -> bytes:
    return element(number, struct.pack(">d", value))


def _text(number: int, value: str) -> bytes:
    return element(number, value.encode())


def write_endaq(path: Path, groups: Sequence[Group], start: int) -> None:
    """Write groups; ``start`` is the instant of the first sample [s since 1970]."""
    polynomials, channels, blocks = b"", b"", list[tuple[int, bytes]]()
    for number, group in zip(CHANNELS, groups, strict=False):
        inside = b""
        for i, one in enumerate(group.columns):
            own = 10 * number + i
            polynomials += element(0x4B01, _whole(0x4B03, own) + _real(0x4B04, 0.0) + _real(0x4B08, one.scale)
                                   + _real(0x4B08, 0.0))  # fmt: skip
            inside += element(0x52A0, _whole(0x52A1, i) + _text(0x52A2, one.name) + _whole(0x52A3, own)
                              + _text(0x52A5, one.label) + _text(0x52A6, one.unit))  # fmt: skip
        about = _whole(0x5272, number) + _text(0x5273, group.name) + _text(0x5275, ">" + "i" * len(group.columns))
        about += _text(0x5277, f"1/{TICKS}") + _whole(0x5278, 2**32) + _text(0x5279, str(group.sample_rate))
        channels += element(0x5271, about + inside)
        rows = np.column_stack([one.counts for one in group.columns]).astype(">i4")
        for first in range(0, len(rows), BLOCK):
            part = rows[first : first + BLOCK]
            begin, end = (round(at / group.sample_rate * TICKS) for at in (first, first + len(part) - 1))
            times = _whole(0xB0, number) + _whole(0xB8, begin) + _whole(0xB9, end)
            blocks.append((begin, element(0xA1, times + element(0xB2, part.tobytes()))))
    scheme = (0x4286, 1), (0x42F7, 1), (0x42F2, 4), (0x42F3, 8), (0x4287, 2), (0x4285, 2)
    head = element(0x1A45DFA3, _text(0x4282, "mide") + b"".join(_whole(*one) for one in scheme))
    recorder = element(0x5210, _whole(0x5211, 18) + _whole(0x5212, 1234) + _text(0x5214, "W8-R100D40"))
    path.write_bytes(
        head
        + element(0x18526570, recorder + element(0x5270, channels))
        + element(0x4B00, polynomials)
        + element(0x5462, start.to_bytes(4, "big"))
        + b"".join(content for _, content in sorted(blocks, key=lambda one: one[0]))
    )
