"""Bags: recordings of ROS 1 (``.bag``), of ROS 2 in SQLite (``.db3``) and in MCAP (``.mcap``), and folders of ROS 2.

A bag is read from its beginning to where it stops being whole, without its index: a recorder that was killed left none
(`rosbags` and `mcap` refuse such a file, or take a torn message for a whole one). It is gone through twice: once to
see what it holds, once to decode the topic that is read, so that no more than a chunk is held at a time.

References
----------
.. [1] ROS 1 bag format 2.0: wiki.ros.org/Bags/Format/2.0.
.. [2] MCAP: mcap.dev/spec.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ...core.batches import any_step
from ...core.errors import DataError
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..binary.arrays import number_column
from ..binary.protobuf import Descriptors, described
from ..budget import PARTS, check_count, claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors
from ..time.stamps import is_utc
from .database import SQLITE, is_bag_2, missing_bytes, opened, whole_pages
from .json_lines import STAMP, read_json_lines
from .ros_messages import ENCODINGS, MESSAGES, Decoded, decode, message_type, stated
from .rows import ENCODING, layout_in, rows_content
from .rows import LIBRARY as OURS
from .topics import (
    INERTIAL,
    NAMED,
    NO_NUMBERS,
    Topic,
    choose,
    joined,
    library,
    on_disk,
    other_topics,
    stamps,
    torn,
    with_thermometer,
)

ROS_1, MCAP = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n"
CUT = "it ends in the middle of a chunk, which is read as far as it is whole"
AT_ONCE = 2**14  # messages that are decoded at once
ROWS = 2**9  # of a database that are taken at once
CHUNK = 2**30  # bytes that a chunk may unpack to
OF_MCAP = {"header": 1, "footer": 2, "schema": 3, "channel": 4, "message": 5, "chunk": 6, "data_end": 15}
OP_LENGTH = struct.Struct("<BQ")  # of a record of MCAP
MCAP_MESSAGE = 22  # bytes of channel, sequence, times of recording and of publication, before the content
PLAIN = frozenset((3, 4, 5))  # schema, channel, message
ENDS = frozenset((2, 6, 15))  # footer, chunk, end of the data
DATA_END = 4  # bytes of the checksum
FOOTER = 29  # bytes of the last record
JSON, PROTOBUF = "json", "protobuf"  # encodings of messages that are objects
LOG_TIME = "log_time_ns"
IN_WORDS = {JSON: "JSON", PROTOBUF: "Protobuf"}
ZSTD = b"\x28\xb5\x2f\xfd"  # with which a packed message begins, and no other one
LARGEST = 2**16  # bytes that a packed message may unpack to: no reading is longer
PIECE = 2**22  # bytes that are summed at once


class TornError(Exception):
    """A bag ends, or is damaged, at a byte."""

    def __init__(self, at: int, why: str) -> None:
        super().__init__(why)
        self.at, self.why = at, why


@dataclass(frozen=True)
class Connection:
    """Who wrote messages: a topic, and what its messages are."""

    topic: str
    kind: str  # As the bag names the type
    encoding: str  # ``"ros1"``, ``"cdr"``, that of `rows`, or one that is not read
    schema: bytes = b""  # Content of the schema


@dataclass(frozen=True, eq=False)
class Messages:
    """Messages that follow each other, in the bytes in which they lie."""

    keys: Times  # shape (n,): of the connections
    time_ns: Times  # shape (n,): of recording [ns]
    data: bytes
    first: Times  # shape (n,): first byte of each
    stop: Times  # shape (n,): byte behind the last of each

    def content(self, at: NDArray[np.intp]) -> list[bytes]:
        """Return the content of some of them."""
        return [self.data[a:b] for a, b in zip(self.first[at].tolist(), self.stop[at].tolist(), strict=True)]


@dataclass
class Bag:
    """A bag that is gone through: connections appear as their messages do.

    Parameters
    ----------
    scan : callable
        Yields the messages from the beginning, and fills in the connections; raises TornError where it is not whole.
    title : str
        Format in words.
    """

    scan: Callable[[Bag], Iterator[Messages]]
    title: str
    path: str
    size: int  # Bytes
    connections: dict[int, Connection] = field(default_factory=dict[int, Connection])
    remarks: tuple[Remark, ...] = ()

    def messages(self) -> Iterator[Messages]:
        """Yield the messages that are whole; where that ends is a remark."""
        self.remarks = ()
        try:
            yield from self.scan(self)
        except TornError as end:
            self.remarks = torn(self.path, self.size - end.at, end.at, end.why)


def read_bag(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the readings of a topic of a bag.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``; ``missing_extra`` for a compression; ``damaged_file``;
        ``too_large``.
    """
    with as_data_errors(loaded.path, "a bag"):
        if loaded.data.startswith(SQLITE):
            with on_disk(whole_pages(loaded), ".db3") as path:
                return content_of(bag_in_sqlite(path, loaded), variables)
        return content_of(bag_of(loaded), variables)


def bag_of(loaded: Loaded) -> Bag:
    """Return a bag that is a stream of records."""
    if loaded.data.startswith(MCAP):
        return Bag(lambda bag: _mcap(loaded, bag), "MCAP", loaded.path, len(loaded.data))
    return Bag(lambda bag: _ros_1(loaded, bag), "ROS 1 bag", loaded.path, len(loaded.data))


def content_of(bag: Bag, variables: Sequence[str] | None) -> Content:
    """Return the readings of a topic, those that were named or the one with inertial readings."""
    rows: Counter[str] = Counter()
    for part in bag.messages():
        for key, count in zip(*(one.tolist() for one in np.unique(part.keys, return_counts=True)), strict=True):
            rows[bag.connections[key].topic] += count
    by_topic: dict[str, list[Connection]] = {}
    for one in bag.connections.values():
        by_topic.setdefault(one.topic, []).append(one)
    topics = [_topic(name, own, rows[name]) for name, own in by_topic.items()]
    if (
        rows
        and not any(one.rank for one in topics)
        and any(one.encoding in IN_WORDS for one in bag.connections.values())
    ):
        return _of_objects(bag, variables)
    if not any(one.rank and one.rows != 0 for one in topics) and bag.remarks:
        raise DataError(bag.remarks[0].what, bag.path, "no reading before that is whole", code="damaged_file")
    unread = dict.fromkeys(one.encoding for one in bag.connections.values() if one.encoding not in ENCODINGS)
    if unread and not any(one.rank for one in topics):
        what = f"its messages are in {', '.join(unread)}, which is not read: {', '.join(map(str, topics[:NAMED]))}"
        do = "Record ROS, Protobuf or JSON messages, or export the topic as CSV or JSON lines"
        raise DataError(what, bag.path, do=do, code="no_channel")
    chosen = with_thermometer(topics, choose(topics, variables, bag.path), variables)
    for topic in chosen:
        if topic.rank == NO_NUMBERS:
            what = f"topic {topic.name} holds {topic.what or 'messages of no type'}"
            do = f"Read are {', '.join(f'sensor_msgs/{name}' for name in MESSAGES)}"
            raise DataError(what, where=bag.path, do=do, code="no_channel")
    parts = [(one, _content(bag, one, by_topic[one.name][0])) for one in chosen]
    content = joined(parts, bag.path, named=bool(variables))
    remarks = (*content.remarks, *other_topics(topics, chosen, bag.path), *bag.remarks)
    return Content(content.columns, bag.title, remarks=remarks)


def _topic(name: str, own: Sequence[Connection], rows: int) -> Topic:
    kinds = dict.fromkeys(one.kind for one in own)
    if all(one.encoding == ENCODING for one in own):
        return Topic(name, "rows of an instrument", None if rows else 0, INERTIAL)
    known = len(kinds) == 1 and all(one.encoding in ENCODINGS for one in own)
    kind = message_type(own[0].kind) if known else ""
    others = dict.fromkeys(one.encoding for one in own if one.encoding not in ENCODINGS)
    what = ", ".join(kinds) + (f" in {', '.join(others)}, which is not read" if others and any(others) else "")
    return Topic(name, what, rows, MESSAGES[kind][0] if kind else NO_NUMBERS, kind == "Temperature")


def _of_objects(bag: Bag, variables: Sequence[str] | None) -> Content:
    """Return the objects of a topic whose messages are JSON or Protobuf, as JSON lines with the times of recording."""
    lines: list[bytes] = []
    types: dict[bytes, Descriptors] = {}
    read: dict[str, None] = {}
    left = held = 0
    for part in bag.messages():
        contents = part.content(np.arange(len(part.keys)))
        for key, time, content in zip(part.keys.tolist(), part.time_ns.tolist(), contents, strict=True):
            connection = bag.connections[key]
            inside = _as_object(connection, content, types, bag.path)
            if inside is None:
                left += 1
                continue
            read[IN_WORDS[connection.encoding]] = None
            about = json.dumps({"topic": connection.topic, LOG_TIME: time}).encode()
            more = b", " if inside[1:-1].strip() else b""
            lines.append(about[:-1] + more + inside[1:].replace(b"\n", b" "))
            held += len(lines[-1])
        claim(bag.path, bag.size, 3 * held, f"{len(lines):,} messages of {' and '.join(read)}", least=True)
    found = read_json_lines(Loaded(bag.path, b"\n".join(lines), "", size=bag.size), variables)
    words, remarks = " and ".join(read), list(found.remarks)
    if any(_is_stamp(one) for one in found.columns):
        found = replace(found, columns=tuple(one for one in found.columns if one.name != LOG_TIME))
    else:
        what = f"times of recording are used: messages of {words} have no stamp that all agree on"
        remarks.append(Remark("log_time", "info", what, where=bag.path))
    if left:
        what = f"messages that are not objects of {words or 'JSON'}: left out"
        remarks.append(Remark("damaged_records", "warning", what, where=bag.path, count=left))
    return replace(found, format=f"{bag.title}, {words}", rows=None, remarks=(*remarks, *bag.remarks))


def _as_object(one: Connection, content: bytes, types: dict[bytes, Descriptors], path: str) -> bytes | None:
    """Return a message as an object of JSON; None where it is none."""
    if one.encoding == PROTOBUF:
        if one.schema not in types:
            types[one.schema] = described(one.schema, path)
        try:
            return json.dumps(types[one.schema].decode(one.kind, content)).encode()
        except ValueError:
            return None
    inside = content.strip()
    return inside if one.encoding == JSON and inside[:1] + inside[-1:] == b"{}" else None


def _is_stamp(column: Column) -> bool:
    """Whether a column is the instant of each message, in seconds and nanoseconds since 1970, and goes on."""
    values = column.values
    named = column.name != LOG_TIME and column.name.endswith(STAMP) and values.dtype.kind == "i" and len(values) > 1
    return named and is_utc(values) and not any_step(values, lambda step: step < 0) and bool(values[-1] > values[0])


def _without_packing(messages: Sequence[bytes], path: str) -> list[bytes]:
    """Return messages unpacked that were packed one by one; one that unpacks to more than a reading stays as it is."""
    if not any(one.startswith(ZSTD) for one in messages):
        return list(messages)
    zstandard = library("zstandard", "a bag packed by zstd", path)
    made = []
    for one in messages:
        content = one
        if one.startswith(ZSTD):
            with suppress(zstandard.ZstdError), zstandard.ZstdDecompressor().stream_reader(one) as stream:
                found = stream.read(LARGEST + 1)
                content = found if len(found) <= LARGEST else one
        made.append(content)
    return made


def _content(bag: Bag, topic: Topic, connection: Connection) -> Content:
    """Return the readings of one topic."""
    if connection.encoding == ENCODING:
        return rows_content(bag, topic.name, layout_in(connection.schema, bag.path))
    return _decoded(bag, topic, connection)


def _decoded(bag: Bag, topic: Topic, connection: Connection) -> Content:
    """Return the readings of one topic of messages of ROS."""
    kind, rows = message_type(connection.kind), topic.rows or 0
    width = sum(len(part.names) + part.covariance for part in MESSAGES[kind][1])
    claim_room(bag.path, bag.size, 16 * rows * (width + 2), f"{rows:,} messages")
    long = LongColumns(rows)
    keys = [key for key, one in bag.connections.items() if one.topic == topic.name]
    held: list[bytes] = []
    logged: list[Times] = []
    frames: dict[str, None] = {}
    broken = 0
    first = low = high = np.empty(0)

    def flush() -> None:
        nonlocal broken, first, low, high
        found: Decoded = decode(_without_packing(held, bag.path), kind, connection.encoding)
        broken += len(held) - len(found.values)
        frames.update(dict.fromkeys(found.frames))
        if len(found.values):
            low, high = _extremes(found.values, low, high)
            first = found.values[0] if not len(first) else first
            columns = [found.time_ns, np.concatenate(logged)[found.whole], *found.values.T]
            long.add([Column(str(i), values) for i, values in enumerate(columns)])
        held.clear()
        logged.clear()

    for part in bag.messages():
        own = np.flatnonzero(np.isin(part.keys, keys))
        for begin in range(0, len(own), AT_ONCE):
            at = own[begin : begin + AT_ONCE]
            held += part.content(at)
            logged.append(part.time_ns[at])
            if len(held) >= AT_ONCE:
                flush()
    if held:
        flush()
    if not len(first):
        raise DataError(f"no message of topic {topic.name} is whole", where=bag.path, code="damaged_file")
    whole = [column.values[: rows - broken] for column in long.columns()]
    columns, remarks = stated(kind, first, low, high, list(frames), bag.path)
    if broken:
        what = f"messages of topic {topic.name} that are not {connection.kind}: left out"
        remarks += (Remark("damaged_records", "warning", what, where=bag.path, count=broken),)
    time_ns, log_ns = whole[0], whole[1]
    if not any_step(time_ns, lambda step: step != 0) and any_step(log_ns, lambda step: step != 0):
        what = "the stamps in the headers are all the same: the times of recording are used"
        remarks += (Remark("log_time", "warning", what, where=bag.path, do="They jitter more than the sensor's clock"),)
        time_ns = log_ns
    made = [number_column(name, whole[2 + at], unit) for name, unit, at in columns]
    return Content((stamps(time_ns, is_utc(time_ns)), *made), bag.title, remarks=remarks)


def _extremes(values: Any, low: Any, high: Any) -> tuple[Any, Any]:
    least, most = np.fmin.reduce(values), np.fmax.reduce(values)
    return (np.fmin(low, least), np.fmax(high, most)) if len(low) else (least, most)


def _take(data: bytes, at: int, size: int, why: str = "it ends in the middle of a record", begin: int = -1) -> bytes:
    """Return bytes of a file; raises TornError where there are fewer."""
    found = data[at : at + size]
    if len(found) != size:
        raise TornError(at if begin < 0 else begin, why)
    return found


# ROS 1


def _ros_1(loaded: Loaded, bag: Bag) -> Iterator[Messages]:
    """Yield the messages of a bag of ROS 1, chunk by chunk."""
    data, at, closed = loaded.data, len(ROS_1), True
    while at < len(data):
        head, begin, size = _ros_1_record(data, at, at)
        op = head.get(b"op", b"")
        if op == b"\x03":
            closed = _whole(head, b"index_pos", 8, at) > 0
        if op == b"\x05":
            inside = _ros_1_chunk(head, data[begin : begin + size], loaded, at, begin + size > len(data))
            yield from _ros_1_inside(inside, bag, len(data) if begin + size > len(data) else at)
            if begin + size > len(data):
                raise TornError(len(data), CUT)
        elif op in (b"\x02", b"\x07"):
            _take(data, begin, size, begin=at)
            yield from _ros_1_inside(data[at : begin + size], bag, at)
        elif begin + size > len(data):
            raise TornError(at, "it ends in the middle of a record")
        at = begin + size
    if not closed:
        raise TornError(at, "it has no index")


def _ros_1_inside(inside: bytes, bag: Bag, at: int) -> Iterator[Messages]:
    """Yield the messages of the content of a chunk, together, and raise where it stops being whole."""
    found: list[tuple[int, int, int, int]] = []  # connection, time [ns], first byte, byte behind the last
    place, torn = 0, None
    try:
        while place < len(inside):
            head, start, length = _ros_1_record(inside, place, at, CUT)
            if start + length > len(inside):
                raise TornError(at, CUT)
            one = _ros_1_one(head, inside[start : start + length] if head.get(b"op") == b"\x07" else b"", bag, at)
            place = start + length
            if one:
                found.append((*one, start, place))
    except TornError as error:
        torn = error
    keys, times, first, stop = np.array(found, np.int64).reshape(-1, 4).T
    yield Messages(keys, times, inside, first, stop)
    if torn:
        raise torn


def _ros_1_record(
    data: bytes, at: int, outer: int, why: str = "it ends in the middle of a record"
) -> tuple[dict[bytes, bytes], int, int]:
    """Return the fields of a record's header, and first byte and size of its data."""
    (length,) = struct.unpack("<I", _take(data, at, 4, why, outer))
    head = _take(data, at + 4, length, why, outer)
    (size,) = struct.unpack("<I", _take(data, at + 4 + length, 4, why, outer))
    fields: dict[bytes, bytes] = {}
    place = 0
    while place + 4 <= len(head):
        (one,) = struct.unpack_from("<I", head, place)
        name, equals, value = head[place + 4 : place + 4 + one].partition(b"=")
        if not equals:
            raise TornError(outer, "a record is damaged")
        fields[name] = value
        place += 4 + one
    return fields, at + 8 + length, size


def _ros_1_chunk(head: dict[bytes, bytes], packed: bytes, loaded: Loaded, at: int, cut: bool) -> bytes:
    """Return the content of a chunk; of one that is cut off, as much as is there."""
    size = _whole(head, b"size", 4, at)
    return unpacked(packed, head.get(b"compression", b"").decode("ascii", "replace"), size, loaded, at, cut)


def _whole(head: dict[bytes, bytes], name: bytes, size: int, at: int) -> int:
    value = head.get(name, b"")
    if len(value) != size:
        raise TornError(at, "a record is damaged")
    return int.from_bytes(value, "little")


def _ros_1_one(head: dict[bytes, bytes], data: bytes, bag: Bag, at: int) -> tuple[int, int] | None:
    """Return connection and time [ns] of a message, or None: a connection is written down."""
    op = head.get(b"op", b"")
    if op == b"\x07":
        about, _, _ = _ros_1_record(struct.pack("<I", len(data)) + data + bytes(4), 0, at)
        topic, kind = (one.decode("utf-8", "replace") for one in (head.get(b"topic", b""), about.get(b"type", b"")))
        bag.connections[_whole(head, b"conn", 4, at)] = Connection(topic, kind, "ros1")
        check_count(len(bag.connections), PARTS, "connections", bag.path)
    elif op == b"\x02":
        key, time = _whole(head, b"conn", 4, at), _whole(head, b"time", 8, at)
        if key not in bag.connections:
            raise TornError(at, "a message without its connection")
        return key, (time & 0xFFFFFFFF) * SECOND + (time >> 32)
    return None


def unpacked(packed: bytes, how: str, size: int, loaded: Loaded, at: int, cut: bool = False) -> bytes:
    """Return the content of a chunk, at most as long as it says; of one that is cut off, as much as is there.

    Raises
    ------
    TornError
        If it cannot be unpacked.
    DataError
        ``missing_extra``, ``unsupported_format``, ``too_large``.
    """
    if how in ("", "none"):
        return packed
    held = 0 if isinstance(loaded.data, FileBytes) else len(loaded.data)
    claim(loaded.path, loaded.on_disk, held + len(packed) + 2 * size, f"a chunk of {size:,} bytes")
    check_count(size, CHUNK, "bytes in a chunk", loaded.path)
    errors: tuple[type[Exception], ...] = (OSError, ValueError, RuntimeError, EOFError)
    found: bytes
    try:
        if how == "bz2":
            import bz2  # noqa: PLC0415 - loaded where it is needed

            found = bz2.BZ2Decompressor().decompress(packed, size)
        elif how == "lz4":
            frame = library("lz4.frame", "a bag packed by lz4", loaded.path)
            found = frame.LZ4FrameDecompressor().decompress(packed, size)
        elif how == "zstd":
            zstandard = library("zstandard", "a bag packed by zstd", loaded.path)
            errors = (*errors, zstandard.ZstdError)
            with zstandard.ZstdDecompressor().stream_reader(packed) as stream:
                found = stream.read(size)
        else:
            do = "Write it anew with zstd, lz4 or without compression"
            raise DataError(f"chunks packed by {how!r}", where=loaded.path, do=do, code="unsupported_format")
    except DataError:
        raise
    except errors:
        raise TornError(at, "a chunk cannot be unpacked") from None
    if len(found) != size and not cut:
        raise TornError(at, "a chunk is shorter than it says")
    return found


# MCAP


def _mcap(loaded: Loaded, bag: Bag) -> Iterator[Messages]:
    """Yield the messages of an MCAP file, chunk by chunk, up to its summary."""
    data, at = loaded.data, len(MCAP)
    schemas: dict[int, tuple[str, bytes]] = {}
    always_summed = False
    while at < len(data):
        op, size = OP_LENGTH.unpack(_take(data, at, 9))
        if op == 0:
            raise TornError(at, "a record is damaged")
        if op in (OF_MCAP["footer"], OF_MCAP["data_end"]):
            _mcap_closed(data, at, op == OF_MCAP["data_end"] and size == DATA_END, bag)
            return
        if at + 9 + size > len(data):
            if op != OF_MCAP["chunk"] or always_summed:  # what a loss of power left of one may be anything
                raise TornError(at, "it ends in the middle of a record")
            yield from _mcap_inside(_mcap_chunk(data[at + 9 :], loaded, at, False, True), bag, schemas, at)
            raise TornError(len(data), CUT)
        if op == OF_MCAP["chunk"]:
            inside = _mcap_chunk(_take(data, at + 9, size), loaded, at, always_summed)
            if (yield from _mcap_inside(inside, bag, schemas, at)) != len(inside):
                raise TornError(at, "a chunk is damaged")
            at += 9 + size
        elif op == OF_MCAP["header"]:
            always_summed = _text(data[at + 9 : at + 9 + size], _text(data[at + 9 : at + 9 + size], 0)[1])[0] == OURS
            at += 9 + size
        elif op in PLAIN:
            at += yield from _mcap_inside(data[at : at + max(PIECE, 9 + size)], bag, schemas, at)
        else:
            at += 9 + size
    raise TornError(at, "it has no end")


class Growing:
    """An MCAP file of ours that is still written: what is whole of it is read, each time from where it was read to.

    Parameters
    ----------
    path : str
        For messages.
    """

    def __init__(self, path: str) -> None:
        self.bag = Bag(lambda bag: iter(()), "MCAP", path, 0)
        self.at = len(MCAP)  # Bytes that were read
        self.ended = False  # The end of the data was read: nothing more will come
        self.damaged = 0  # Chunks in the middle whose checksum is wrong: left out
        self._schemas: dict[int, tuple[str, bytes]] = {}

    def messages(self, stream: BinaryIO) -> Iterator[Messages]:
        """Yield the messages of each chunk that is whole now, up to the first record that is not, yet or for ever."""
        loaded = Loaded(self.bag.path, b"", "")
        size = stream.seek(0, 2)
        while not self.ended and self.at + 9 <= size:
            stream.seek(self.at)
            op, length = OP_LENGTH.unpack(stream.read(9))
            if op == 0 or self.at + 9 + length > size:
                return
            if op == OF_MCAP["chunk"]:
                try:
                    inside = _mcap_chunk(stream.read(length), loaded, self.at, True)
                except TornError:
                    if self.at + 9 + length == size:  # the last one: what is there of it may not be all
                        return
                    inside = b""
                    self.damaged += 1
                with suppress(TornError):
                    yield from _mcap_inside(inside, self.bag, self._schemas, self.at)
            self.ended = op == OF_MCAP["data_end"]
            self.at += 9 + length


def _mcap_inside(
    inside: bytes, bag: Bag, schemas: dict[int, tuple[str, bytes]], at: int
) -> Generator[Messages, None, int]:
    """Yield the messages of records that follow each other; return the bytes of those that are whole.

    A chunk, and the end of the data, are not gone into.
    """
    found: list[int] = []
    place, end, number, message = 0, len(inside), OP_LENGTH.unpack_from, OF_MCAP["message"]
    while place + 9 <= end:
        op, length = number(inside, place)
        following = place + 9 + length
        if following > end or op in ENDS:
            break
        if op == message:
            found.append(place)
        elif op in PLAIN:
            _mcap_about(op, inside[place + 9 : following], bag, schemas, at)
        place = following
    first = np.array(found, np.int64)
    lengths = _gathered(inside, first + 1, "<u8")
    why = ""
    if np.any(lengths < MCAP_MESSAGE):
        why, first = "a record is damaged", first[: np.argmax(lengths < MCAP_MESSAGE)]
    keys = _gathered(inside, first + 9, "<u2")
    known = np.isin(keys, list(bag.connections))
    if not known.all():
        why, first = "a message without its channel", first[: np.argmin(known)]
    rows = slice(len(first))
    times = _gathered(inside, first + 15, "<i8")
    yield Messages(keys[rows], np.maximum(times, 0), inside, first + 9 + MCAP_MESSAGE, first + 9 + lengths[rows])
    if why:
        raise TornError(at, why)
    return place


def _gathered(data: bytes, first: Times, kind: str) -> Times:
    """Return the numbers that stand from some bytes on."""
    table = np.frombuffer(data, np.uint8)[first[:, None] + np.arange(np.dtype(kind).itemsize)]
    return np.ascontiguousarray(table).view(kind).astype(np.int64)[:, 0]


def _mcap_closed(data: bytes, at: int, summed: bool, bag: Bag) -> None:
    """Look at the end of the data, and at what stands behind it."""
    if summed:
        _mcap_sum(data, at, bag)
        _mcap_end(data, at, bag)
    else:
        _mcap_damaged(bag)


def _mcap_sum(data: bytes, at: int, bag: Bag) -> None:
    """Compare the checksum of all that stands before the end of the data, if the file has one, with its content."""
    (said,) = struct.unpack("<I", _take(data, at + 9, DATA_END))
    found = 0
    for first in range(0, at if said else 0, PIECE):
        found = zlib.crc32(data[first : min(first + PIECE, at)], found)
    if said != found:
        what = "the checksum of the data is not that of its content: a byte was changed since it was written"
        do = "Copy it again from the logger: some readings may be wrong"
        bag.remarks += (Remark("wrong_checksum", "warning", what, where=bag.path, do=do),)


def _mcap_end(data: bytes, at: int, bag: Bag) -> None:
    """Look at what stands behind the data: a file that was finished ends with a footer, whose checksum covers it."""
    end = len(data) - len(MCAP)
    foot = end - FOOTER
    whole = foot >= at and data[end:] == MCAP and data[foot : foot + 9] == OP_LENGTH.pack(OF_MCAP["footer"], FOOTER - 9)
    if whole:
        summary, _, said = struct.unpack("<QQI", data[foot + 9 : end])
        begin = summary if at < summary <= foot else foot
        found = 0
        for first in range(begin, end - DATA_END, PIECE):
            found = zlib.crc32(data[first : min(first + PIECE, end - DATA_END)], found)
        whole = said in (0, found)
    if not whole:
        _mcap_damaged(bag)


def _mcap_damaged(bag: Bag) -> None:
    what = "the end of the file is damaged, so that the checksum of its content is not known"
    do = "Copy it again from the logger"
    bag.remarks += (Remark("wrong_checksum", "warning", what, where=bag.path, do=do),)


def _mcap_chunk(body: bytes, loaded: Loaded, at: int, summed: bool, cut: bool = False) -> bytes:
    """Return the records of a chunk; its checksum is looked at, which only other writers may leave out.

    Of one that is cut off, as much as is there, whose checksum nobody can look at.
    """
    try:
        _, _, size, checksum, length = struct.unpack_from("<QQQII", body)
        how = body[32 : 32 + length].decode("ascii", "replace")
        (packed,) = struct.unpack_from("<Q", body, 32 + length)
    except struct.error:
        raise TornError(at, "a chunk is damaged") from None
    records = body[40 + length : 40 + length + packed]
    if len(records) != packed and not cut:
        raise TornError(at, "a chunk is damaged")
    found = unpacked(records, how, size, loaded, at, cut)
    if cut:
        if not found:
            packing = f"packed by {how}, of which nothing can be unpacked" if how else "of which nothing is there"
            raise TornError(at, f"it ends in the middle of a chunk {packing}")
        return found
    if (checksum or summed) and zlib.crc32(found) != checksum:
        raise TornError(at, "the checksum of a chunk is not that of its content")
    return found


def _mcap_about(op: int, body: bytes, bag: Bag, schemas: dict[int, tuple[str, bytes]], at: int) -> None:
    """Write down a schema or a channel."""
    try:
        if op == OF_MCAP["schema"]:
            (key,) = struct.unpack_from("<H", body)
            name, place = _text(body, 2)
            _, place = _text(body, place)
            (length,) = struct.unpack_from("<I", body, place)
            schemas[key] = name, body[place + 4 : place + 4 + length]
        else:
            key, schema = struct.unpack_from("<HH", body)
            topic, place = _text(body, 4)
            encoding, _ = _text(body, place)
            kind, content = schemas.get(schema, ("", b""))
            bag.connections[key] = Connection(topic, kind, encoding, content)
            check_count(len(bag.connections), PARTS, "channels", bag.path)
    except struct.error:
        raise TornError(at, "a record is damaged") from None


def _text(body: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", body, at)
    return body[at + 4 : at + 4 + length].decode("utf-8", "replace"), at + 4 + length


# ROS 2 in SQLite


def _from_rows(rows: Sequence[tuple[int, int, bytes]]) -> Messages:
    keys, times, contents = zip(*rows, strict=True)
    stop = np.cumsum([len(one) for one in contents], dtype=np.int64)
    first = np.concatenate([[0], stop[:-1]])
    return Messages(np.array(keys, np.int64), np.array(times, np.int64), b"".join(contents), first, stop)


def bag_in_sqlite(path: str, loaded: Loaded) -> Bag:
    """Return a bag of ROS 2 in SQLite."""
    import sqlite3  # noqa: PLC0415 - loaded where it is needed

    connection, missing = opened(path, loaded), missing_bytes(loaded.data)
    query = (
        "SELECT topic_id, timestamp, data FROM messages WHERE typeof(timestamp) = 'integer' AND typeof(data) = 'blob'"
    )
    query += "" if missing else " ORDER BY timestamp, id"  # an index lies anywhere in a file, the rows mostly in order

    def scan(bag: Bag) -> Iterator[Messages]:
        kept: list[tuple[int, int, bytes]] = []
        torn: TornError | None = None
        try:
            topics = connection.execute("SELECT id, name, type, serialization_format FROM topics")
            for key, topic, kind, encoding in topics:
                bag.connections[key] = Connection(str(topic), str(kind), str(encoding))
                check_count(len(bag.connections), PARTS, "topics", bag.path)
            for row in connection.execute(query):
                if row[0] in bag.connections:
                    kept.append(row)
                if len(kept) == ROWS:
                    yield _from_rows(kept)
                    kept.clear()
        except sqlite3.DatabaseError as error:
            if not bag.connections:
                raise
            cut = f"{missing:,} bytes at its end are gone" if missing else str(error)
            torn = TornError(bag.size, f"the database is damaged ({cut})")
        if kept:
            yield _from_rows(kept)
        if torn:
            raise torn

    return Bag(scan, "ROS 2 bag (SQLite)", loaded.path, len(loaded.data))


ROSBAG_1 = Reader("rosbag1", "ROS 1 and 2 bags", (".bag",), lambda data, path: data.startswith(ROS_1), read_bag, True)
ROSBAG_2 = Reader("rosbag2", "ROS 1 and 2 bags", (".db3",), is_bag_2, read_bag, True)
READER = Reader("mcap", "MCAP", (".mcap",), lambda data, path: data.startswith(MCAP), read_bag, True)
