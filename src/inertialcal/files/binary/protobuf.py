"""Protobuf: messages as objects, by the descriptors that stand in the file itself.

Fields are called as the descriptor calls them. A field of plain numbers that a message leaves out is zero, as proto3
says; one whose absence can be told (``optional``, a choice, proto2, a message within) is missing. Bytes, and groups,
are left out; an enumeration is its number.

References
----------
.. [1] Protocol Buffers, Encoding: protobuf.dev/programming-guides/encoding.
.. [2] google/protobuf/descriptor.proto: numbers of the fields of FileDescriptorSet.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from ..budget import PARTS, check_count

VARINT, FIXED_64, LENGTH, FIXED_32 = 0, 1, 2, 5  # how a field lies on the wire
STRING, MESSAGE, BYTES, ENUM = 9, 11, 12, 14  # types of a field, beside those of numbers
DEEPEST = 8  # messages within messages
SIGN, BITS = 1 << 63, 1 << 64
LONGEST = 10  # bytes of a varint
Wire = int | bytes


def _signed(value: int) -> int:
    return value - BITS if value & SIGN else value


def _int_32(value: int) -> int:
    return _signed(value) if value & SIGN else (value & 0xFFFFFFFF) - ((value & 0x80000000) << 1)


def _zigzag(value: int) -> int:
    return (value >> 1) ^ -(value & 1)


OF_VARINT: dict[int, Callable[[int], int]] = {
    3: _signed, 4: int, 5: _int_32, 8: int, 13: lambda value: value & 0xFFFFFFFF, ENUM: _int_32, 17: _zigzag,
    18: _zigzag,
}  # fmt: skip
OF_FIXED = {1: struct.Struct("<d"), 2: struct.Struct("<f"), 6: struct.Struct("<Q"), 7: struct.Struct("<I"),
            15: struct.Struct("<i"), 16: struct.Struct("<q")}  # fmt: skip


@dataclass(frozen=True)
class _Field:
    """A field of a message."""

    name: str
    type: int
    of: str = ""  # Full name of the message
    repeated: bool = False
    always: bool = False  # Zero where a message leaves it out


@dataclass
class Descriptors:
    """The types of messages that a FileDescriptorSet describes, by full name."""

    fields: dict[str, dict[int, _Field]] = field(default_factory=dict[str, dict[int, _Field]])

    def decode(self, kind: str, data: bytes, depth: int = 1) -> dict[str, object]:
        """Return a message as an object.

        Raises
        ------
        ValueError
            If it is no message of the type, or its type is not described.
        """
        if kind not in self.fields:
            raise ValueError(kind)
        own = self.fields[kind]
        found: dict[str, object] = {one.name: 0 for one in own.values() if one.always}
        lists: dict[str, list[object]] = {}
        for number, wire, value in _wire(data):
            one = own.get(number)
            if one is None or one.type == BYTES or (one.type == MESSAGE and depth == DEEPEST):
                continue
            made = self._values(one, wire, value, depth)
            if one.repeated:
                lists.setdefault(one.name, []).extend(made)
            elif made:
                found[one.name] = made[-1]
        return found | lists

    def _values(self, one: _Field, wire: int, value: Wire, depth: int) -> list[object]:
        """Return the value of a field, or those that are packed in it."""
        if isinstance(value, int):
            if wire != VARINT or one.type not in OF_VARINT:
                raise ValueError(one.name)
            return [OF_VARINT[one.type](value)]
        if one.type in OF_FIXED and (wire != LENGTH or one.repeated):
            return [number for (number,) in _fixed(OF_FIXED[one.type], value)]
        if wire != LENGTH:
            raise ValueError(one.name)
        if one.type == STRING:
            return [value.decode("utf-8")]
        if one.type == MESSAGE:
            return [self.decode(one.of, value, depth + 1)]
        if one.type in OF_VARINT and one.repeated:
            return [OF_VARINT[one.type](packed) for packed in _varints(value)]
        raise ValueError(one.name)


def described(data: bytes, path: str) -> Descriptors:
    """Return the types of messages in a FileDescriptorSet; none where it is damaged.

    Raises
    ------
    DataError
        ``too_many``.
    """
    found = Descriptors()
    try:
        for one in _all(data, 1):
            package, syntax = _text(one, 2), _text(one, 12)
            for message in _all(one, 4):
                _describe(message, f"{package}." if package else "", syntax == "proto3", found, path)
    except (ValueError, struct.error, RecursionError):
        return Descriptors()
    return found


def _describe(data: bytes, within: str, proto_3: bool, found: Descriptors, path: str) -> None:
    """Take over a type of messages and those within it."""
    name = within + _text(data, 1)
    own: dict[int, _Field] = {}
    for one in _all(data, 2):
        numbers = {number: value for number, _, value in _wire(one) if isinstance(value, int)}
        kind, repeated = numbers.get(5, 0), numbers.get(4) == 3
        always = proto_3 and not repeated and 9 not in numbers and kind in {*OF_VARINT, *OF_FIXED}
        own[numbers.get(3, 0)] = _Field(_text(one, 1), kind, _text(one, 6).removeprefix("."), repeated, always)
    found.fields[name] = own
    check_count(len(found.fields), PARTS, "types of messages", path)
    for one in _all(data, 3):
        _describe(one, f"{name}.", proto_3, found, path)


def _all(data: bytes, wanted: int) -> Iterator[bytes]:
    return (value for number, _, value in _wire(data) if number == wanted and isinstance(value, bytes))


def _text(data: bytes, wanted: int) -> str:
    return next((value.decode("utf-8") for value in _all(data, wanted)), "")


def _wire(data: bytes) -> Iterator[tuple[int, int, Wire]]:
    """Yield number, wire type and content of the fields of a message.

    Raises
    ------
    ValueError
        Where they do not fit together.
    """
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        wire = key & 7
        if wire == VARINT:
            value, at = _varint(data, at)
            yield key >> 3, wire, value
            continue
        size = {FIXED_64: 8, FIXED_32: 4}.get(wire)
        if wire == LENGTH:
            size, at = _varint(data, at)
        if size is None or at + size > len(data):
            raise ValueError(wire)
        yield key >> 3, wire, data[at : at + size]
        at += size


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """Return a number of seven bits a byte, and where it ends."""
    value = 0
    for i, byte in enumerate(data[at : at + LONGEST]):
        value |= (byte & 0x7F) << 7 * i
        if byte < 0x80:
            return value % BITS, at + i + 1
    raise ValueError(at)


def _varints(data: bytes) -> Iterator[int]:
    at = 0
    while at < len(data):
        value, at = _varint(data, at)
        yield value


def _fixed(form: struct.Struct, data: bytes) -> Iterator[tuple[float | int]]:
    if len(data) % form.size:
        raise ValueError(len(data))
    return form.iter_unpack(data)
