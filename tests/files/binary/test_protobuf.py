"""Protobuf on the wire: the examples of its documentation, and messages put together by hand."""

from __future__ import annotations

import struct

import pytest

from inertialcal.files.binary.protobuf import described

# Types of fields, as descriptor.proto numbers them.
DOUBLE, INT32, STRING, MESSAGE, SINT32 = 1, 5, 9, 11, 17


def held(field: int, content: bytes) -> bytes:
    """Return a field with a length below 128."""
    assert len(content) < 128
    return bytes([field << 3 | 2, len(content)]) + content


def field(name: str, number: int, kind: int, *, of: str = "", repeated: bool = False, choice: bool = False) -> bytes:
    content = held(1, name.encode()) + bytes([3 << 3, number, 4 << 3, 3 if repeated else 1, 5 << 3, kind])
    content += held(6, of.encode()) if of else b""
    return held(2, content + (bytes([9 << 3, 0]) if choice else b""))


def file(*messages: bytes, syntax: bytes = b"proto3") -> bytes:
    content = held(2, b"lab") + b"".join(bytes([4 << 3 | 2, len(one)]) + one for one in messages) + held(12, syntax)
    return b"\x0a" + bytes([len(content) & 0x7F | 0x80, len(content) >> 7]) + content


INNER = held(1, b"Inner") + field("a", 1, INT32)
OUTER = held(1, b"Outer") + field("c", 3, MESSAGE, of=".lab.Inner") + field("b", 2, STRING)
OUTER += field("f", 6, INT32, repeated=True)


@pytest.mark.parametrize(
    ("kind", "data", "found"),
    [
        ("lab.Inner", "08 96 01", {"a": 150}),
        ("lab.Inner", "", {"a": 0}),
        ("lab.Inner", "08 fe ff ff ff ff ff ff ff ff 01", {"a": -2}),
        ("lab.Inner", "08 96 01 12 01 41", {"a": 150}),  # a field of a later version
        ("lab.Outer", "12 07 74 65 73 74 69 6e 67", {"b": "testing"}),
        ("lab.Outer", "1a 03 08 96 01", {"c": {"a": 150}}),
        ("lab.Outer", "32 06 03 8e 02 9e a7 05", {"f": [3, 270, 86942]}),
        ("lab.Outer", "30 01 30 02", {"f": [1, 2]}),
    ],
)
def test_examples_of_the_documentation(kind: str, data: str, found: dict[str, object]) -> None:
    assert described(file(INNER, OUTER), "x").decode(kind, bytes.fromhex(data)) == found


@pytest.mark.parametrize(("wire", "value"), [(0, 0), (1, -1), (2, 1), (3, -2), (4294967294, 2147483647)])
def test_zigzag(wire: int, value: int) -> None:
    types = described(file(held(1, b"Z") + field("z", 1, SINT32)), "x")
    content = bytes([(wire >> 7 * i) & 0x7F | (0x80 if wire >> 7 * (i + 1) else 0) for i in range(5)])
    assert types.decode("lab.Z", b"\x08" + content[: max(1, -(-wire.bit_length() // 7))]) == {"z": value}


def test_what_is_left_out_is_zero_only_where_its_absence_cannot_be_told() -> None:
    chosen = held(1, b"M") + field("x", 1, DOUBLE) + field("t", 2, DOUBLE, choice=True)
    assert described(file(chosen), "x").decode("lab.M", b"") == {"x": 0}
    assert described(file(chosen, syntax=b"proto2"), "x").decode("lab.M", b"") == {}
    numbers = b"\x09" + struct.pack("<d", 9.81) + b"\x11" + struct.pack("<d", 0.0)
    assert described(file(chosen), "x").decode("lab.M", numbers) == {"x": 9.81, "t": 0.0}


@pytest.mark.parametrize("data", ["08", "08 96", "0a 05 01", "0d 01 02", "0b", "08 " + "ff " * 11])
def test_damaged_messages_are_refused(data: str) -> None:
    types = described(file(INNER), "x")
    with pytest.raises(ValueError, match=r"."):
        types.decode("lab.Inner", bytes.fromhex(data))


def test_a_damaged_descriptor_describes_nothing() -> None:
    assert described(file(INNER)[:-3], "x").fields == {}
