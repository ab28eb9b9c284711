"""Flight logs of ArduPilot (DataFlash): binary (``.bin``) and as text (``.log``).

A log describes itself [1]_: messages FMT say what the others hold, FMTU, UNIT and MULT in which units. A number is
what is stored times its multiplier; where a log has none (before 2018), what the letter of its format says. Stamps
count microseconds since the autopilot started; where a message says when its sample was taken (SampleUS), that is its
time.

References
----------
.. [1] ArduPilot, libraries/AP_Logger/README.md and LogStructure.h.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core import units
from ...core.errors import InertialcalError
from ...core.remarks import Remark
from ..binary.arrays import number_column
from ..budget import claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded, as_data_errors
from .topics import INERTIAL, NO_NUMBERS, OTHER, Topic, choose, frame_remark, joined, left_out, other_topics, torn

MARK = b"\xa3\x95"
BLOCK = 2**24  # bytes that are gone through at once
KINDS = {"a": "(32,)<i2", "b": "i1", "B": "u1", "M": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "f": "<f4",
         "d": "<f8", "g": "<f2", "n": "S4", "N": "S16", "Z": "S64", "c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4",
         "L": "<i4", "q": "<i8", "Q": "<u8"}  # fmt: skip
SCALES = {"c": 0.01, "C": 0.01, "e": 0.01, "E": 0.01, "L": 1e-7}  # what a letter says, of the number stored
ABOUT = ("FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE", "VER")
READINGS = ("IMU", "IMU2", "IMU3", "ACC", "ACC1", "ACC2", "ACC3", "GYR", "GYR1", "GYR2", "GYR3", "IMT", "RAW_IMU")
CLOCKS = {"SampleUS": "us", "TimeUS": "us", "TimeMS": "ms"}  # that of the measurement before that of the message
KNOWN = {"Gyr": "rad/s", "Acc": "m/s^2"}  # of logs without units, from 2016 on
FRAME = "body of the autopilot, x forward, y right, z down"
FMT, FMT_LENGTH = 128, 89
INSTANCE = "#"
NUMBERED = "I"  # label of a field that says the instance
TEXT_CELL = 120  # bytes of a cell of text while it is read


@dataclass
class Format:
    """What messages of one type hold."""

    name: str
    length: int  # Bytes, with mark and type
    letters: str
    labels: list[str]
    units: str = ""  # A letter each, of UNIT
    multipliers: str = ""  # A letter each, of MULT

    @property
    def kind(self) -> np.dtype[np.void]:
        """Numbers of a message as they are stored."""
        return np.dtype([(f"f{i}", KINDS[letter]) for i, letter in enumerate(self.letters)])

    @property
    def is_named(self) -> bool:
        """Whether letters and labels fit to each other: all that a text needs."""
        return all(letter in KINDS for letter in self.letters) and len(self.letters) == len(self.labels) > 0

    @property
    def is_whole(self) -> bool:
        """Whether letters, labels and length fit to each other."""
        return self.is_named and self.kind.itemsize + 3 == self.length

    @property
    def instance(self) -> int | None:
        """Which field says the instance of the sensor."""
        at = self.units.find(INSTANCE)
        if not self.units and NUMBERED in self.labels:  # a log that says no units
            at = self.labels.index(NUMBERED)
        return at if 0 <= at < len(self.letters) and KINDS[self.letters[at]] in ("u1", "i1") else None


@dataclass
class Log:
    """What a log says of itself."""

    formats: dict[int, Format] = field(default_factory=dict[int, Format])
    units: dict[str, str] = field(default_factory=dict[str, str])
    multipliers: dict[str, float] = field(default_factory=dict[str, float])
    skipped: int = 0  # Bytes between messages
    end: int = 0  # Behind the last whole message

    def learn(self, name: str, values: dict[str, Any]) -> None:
        """Take over what a message about the log says."""
        if name == "FMTU" and (one := self.formats.get(int(values["FmtType"]))):
            one.units, one.multipliers = values["UnitIds"], values["MultIds"]
        elif name == "UNIT":
            self.units[chr(int(values["Id"]))] = values["Label"]
        elif name == "MULT":
            self.multipliers[chr(int(values["Id"]))] = float(values["Mult"])

    def learn_bytes(self, kind: int, body: bytes) -> None:
        """Take over what a message of a binary log says about the log, if it is of such a type."""
        if kind == FMT and (made := _format(body)):
            self.formats.setdefault(made[0], made[1])
        one = self.formats.get(kind)
        if one is None or one.name not in ("FMTU", "UNIT", "MULT"):
            return
        values = {}
        for label, value in zip(one.labels, np.frombuffer(body, one.kind)[0].tolist(), strict=True):
            is_text = isinstance(value, bytes)
            values[label] = value.split(b"\0")[0].decode("ascii", "replace") if is_text else value
        self.learn(one.name, values)

    def unit(self, one: Format, at: int, scaled: bool = False) -> tuple[str | None, float]:
        """Return the unit of a field, and by what its stored numbers (``scaled``: those printed) are multiplied."""
        letter, label = one.letters[at], one.labels[at]
        own = 1.0 if scaled else SCALES.get(letter, 1.0)
        if label in CLOCKS:
            return CLOCKS[label], 1.0
        said = self.units.get(one.units[at : at + 1], "")
        times = self.multipliers.get(one.multipliers[at : at + 1])
        factor = times if times and not (scaled and letter in SCALES) else own
        if not one.units and one.name in READINGS:
            said = KNOWN.get(label[:3], "degC" if label in ("Temp", "T") else "")
        try:
            return units.normalise(said) if said else None, factor
        except InertialcalError:
            return None, factor


def read_binary(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a topic of a binary log.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``too_large``, ``damaged_file``.
    """
    path = loaded.path
    with as_data_errors(path, "an ArduPilot log"):
        log = Log()
        counts: dict[tuple[int, int], int] = {}
        for kind, block, at in _messages(loaded.data, log):
            one = log.formats[kind]
            instance = one.instance
            if instance is None:
                counts[kind, -1] = counts.get((kind, -1), 0) + len(at)
                continue
            place = one.kind.fields
            offset = place[f"f{instance}"][1] if place else 0
            numbers, many = np.unique(np.frombuffer(block, np.uint8)[at + 3 + offset], return_counts=True)
            for number, count in zip(numbers.tolist(), many.tolist(), strict=True):
                counts[kind, number] = counts.get((kind, number), 0) + count
        names = {key: _name(log.formats[key[0]].name, key[1]) for key in counts}
        topics = [_topic(names[key], log.formats[key[0]], rows) for key, rows in counts.items()]
        chosen = choose(topics, variables, path)
        keys = {name: key for key, name in names.items()}
        parts = [(one, _binary_columns(loaded, log, keys[one.name], one)) for one in chosen]
        content = joined(parts, path)
        remarks = (*content.remarks, *_damage(log, loaded), *other_topics(topics, chosen, path))
        return Content(content.columns, "ArduPilot DataFlash", remarks=remarks)


def _name(name: str, instance: int) -> str:
    return name if instance < 0 else f"{name}[{instance}]"


def _topic(name: str, one: Format, rows: int) -> Topic:
    numbers = [label for label, letter in zip(one.labels, one.letters, strict=True) if KINDS[letter][0] not in "S("]
    fields = [label for label in numbers if label not in CLOCKS]
    rank = NO_NUMBERS if one.name in ABOUT or not fields else INERTIAL if one.name in READINGS else OTHER
    return Topic(name, " ".join(fields[:6]) + (" ..." if len(fields) > 6 else ""), rows, rank)


def _messages(data: bytes, log: Log) -> Iterator[tuple[int, bytes, NDArray[np.int64]]]:
    """Yield type, block and places of the messages of a log, block by block; fill in what the log says of itself."""
    log.skipped = log.end = 0
    at, size = 0, len(data)
    while at < size:
        block = data[at : at + BLOCK]
        last = at + len(block) >= size
        places: dict[int, list[int]] = {}
        place = 0
        while (found := block.find(MARK, place)) >= 0 and found + 3 <= len(block):
            kind = block[found + 2]
            length = FMT_LENGTH if kind == FMT else log.formats[kind].length if kind in log.formats else 0
            if found + length > len(block) and not last:
                break
            if not length or found + length > len(block):  # by chance, or torn
                place = found + 1
                continue
            log.skipped += at + found - log.end
            log.learn_bytes(kind, block[found + 3 : found + length])
            places.setdefault(kind, []).append(found)
            place = found + length
            log.end = at + place
        for kind, these in places.items():
            if kind in log.formats:
                yield kind, block, np.array(these)
        at += len(block) if last else max(found if found >= 0 else len(block) - 2, 1)


def _format(body: bytes) -> tuple[int, Format] | None:
    """Return what a message FMT says, where it fits together."""
    kind, length, name, letters, labels = struct.unpack("<BB4s16s64s", body)
    texts = [one.split(b"\0")[0].decode("ascii", "replace").strip() for one in (name, letters, labels)]
    found = Format(texts[0], length, texts[1], [label.strip() for label in texts[2].split(",")])
    if not found.is_whole and len(found.labels) > len(found.letters):
        found.labels = found.labels[: len(found.letters)]
    return (kind, found) if found.is_whole else None


def _binary_columns(loaded: Loaded, log: Log, key: tuple[int, int], topic: Topic) -> Content:
    """Return the columns of messages of one type and instance."""
    one, rows = log.formats[key[0]], topic.rows or 0
    claim_room(loaded.path, loaded.on_disk, 16 * rows * len(one.labels), f"{rows:,} messages")
    kept = [i for i, letter in enumerate(one.letters) if KINDS[letter][0] not in "S("]
    long = LongColumns(rows)
    for kind, block, at in _messages(loaded.data, log):
        if kind != key[0]:
            continue
        raw = np.frombuffer(block, np.uint8)
        table = raw[(at + 3)[:, None] + np.arange(one.kind.itemsize)].view(one.kind)[:, 0]
        if key[1] >= 0:
            table = table[table[f"f{one.instance}"].astype(np.int64) % 256 == key[1]]
        if len(table):
            long.add([Column(str(i), np.ascontiguousarray(table[f"f{i}"])) for i in kept])
    values = dict(zip(kept, (column.values for column in long.columns()), strict=True))
    return _content(one, log, values, loaded.path, False)


def _content(one: Format, log: Log, values: dict[int, NDArray[Any]], path: str, scaled: bool) -> Content:
    """Return columns with their units, the clock first."""
    columns: list[Column] = []
    for i, numbers in values.items():
        unit, factor = log.unit(one, i, scaled)
        made = numbers if factor == 1.0 else numbers * factor if factor > 1.0 else numbers / round(1.0 / factor, 9)
        columns.append(number_column(one.labels[i], made, unit))
    columns.sort(key=lambda column: list(CLOCKS).index(column.name) if column.name in CLOCKS else len(CLOCKS))
    gone = [label for i, label in enumerate(one.labels) if i not in values]
    remarks = (*left_out(gone, path), *frame_remark(FRAME if one.name in READINGS else "", path))
    return Content(tuple(columns), "ArduPilot DataFlash", remarks=remarks)


def _damage(log: Log, loaded: Loaded) -> tuple[Remark, ...]:
    remarks: tuple[Remark, ...] = ()
    if log.skipped:
        what = f"{log.skipped:,} bytes between messages belong to none: left out"
        remarks += (Remark("damaged_records", "warning", what, where=loaded.path),)
    rest = loaded.data[log.end :] if len(loaded.data) - log.end < BLOCK else b"?"
    if rest.strip(b"\0\xff"):  # a memory chip is filled up with them
        remarks += torn(loaded.path, len(loaded.data) - log.end, log.end)
    return remarks


def read_text_log(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a topic of a log as text; Raises as `read_binary`."""
    path = loaded.path
    with as_data_errors(path, "an ArduPilot log"):
        commas = loaded.data.count(b",")
        claim(path, loaded.on_disk, 3 * len(loaded.data) + TEXT_CELL * commas, f"{commas:,} cells")
        log, by_name, rows, damaged = _text_rows(loaded.data)
        topics, cells = [], {}
        for name, one in by_name.items():
            for instance, own in _instances(one, rows.get(name, [])):
                title = _name(name, instance)
                topics.append(_topic(title, one, len(own)))
                cells[title] = (one, own)
        chosen = choose(topics, variables, path)
        parts = []
        for topic in chosen:
            one, own = cells[topic.name]
            values: dict[int, NDArray[Any]] = {}
            for i, letter in enumerate(one.letters):
                if KINDS[letter][0] not in "S(" and (column := _numbers([row[i] for row in own], letter)) is not None:
                    values[i] = column
            parts.append((topic, _content(one, log, values, path, True)))
        content = joined(parts, path)
        remarks = (*content.remarks, *other_topics(topics, chosen, path))
        if damaged:
            what = "lines that do not hold what their format says: left out"
            remarks += (Remark("torn_file", "warning", what, f"{path}:{damaged[0]}", len(damaged)),)
        return Content(content.columns, "ArduPilot DataFlash, text", remarks=remarks)


def _text_rows(data: bytes) -> tuple[Log, dict[str, Format], dict[str, list[list[str]]], list[int]]:
    """Return what a log says of itself, its formats and rows by name, and the lines that are not whole."""
    log, by_name = Log(), {}
    rows: dict[str, list[list[str]]] = {}
    damaged: list[int] = []
    lines = data.decode("utf-8", "replace").split("\n")
    end = lines.pop()  # empty, or a line without an end: its last number may be cut
    for number, line in enumerate(lines, start=1):
        name, *cells = (cell.strip() for cell in line.split(","))
        if name == "FMT" and len(cells) >= 5 and cells[0].isdigit() and cells[1].isdigit():
            one = Format(cells[2], int(cells[1]), cells[3], cells[4:])
            if one.is_named:
                log.formats[int(cells[0])] = by_name[cells[2]] = one
        elif name in by_name and len(cells) == len(by_name[name].labels):
            if name in ("FMTU", "UNIT", "MULT"):
                try:
                    log.learn(name, dict(zip(by_name[name].labels, cells, strict=True)))
                except (KeyError, ValueError):
                    damaged.append(number)
            rows.setdefault(name, []).append(cells)
        elif (name in by_name and name not in ABOUT) or (line.strip() and name not in by_name and name not in ABOUT):
            damaged.append(number)
    damaged += [len(lines) + 1] if end.strip() else []
    return log, by_name, rows, damaged


def _instances(one: Format, rows: list[list[str]]) -> Iterator[tuple[int, list[list[str]]]]:
    if one.instance is None or not all(row[one.instance].isdigit() for row in rows):
        yield -1, rows
        return
    by_number: dict[int, list[list[str]]] = {}
    for row in rows:
        by_number.setdefault(int(row[one.instance]), []).append(row)
    yield from by_number.items()


def _numbers(cells: list[str], letter: str) -> NDArray[Any] | None:
    """Return cells as numbers; None where one is none."""
    try:
        if letter in "bBMhHiIqQ":
            return np.array([int(cell) for cell in cells], dtype=np.int64)
        return np.array([float(cell) for cell in cells])
    except (ValueError, OverflowError):
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            return None


def is_text_log(data: bytes, path: str) -> bool:
    """Whether a text is a log: its first lines are formats."""
    start = data[:4096]
    return start.startswith(b"FMT,") or b"\nFMT," in start


BINARY = Reader("dataflash", "ArduPilot logs", (".bin",), lambda data, path: data.startswith(MARK), read_binary, True)
TEXT_LOG = Reader("dataflash_text", "ArduPilot logs", (".log",), is_text_log, read_text_log)
