"""Bytes to rows: lines and packets as a dialect describes them, with what is torn, doubled, late or lost counted.

A row is taken only when it is whole: a line up to its end with the number of fields that it should have, a packet with
its sync bytes, its length and its checksum. What stands before the first line end after connecting is passed over: a
number whose first digits are gone reads like another number. A line without checksum that has lost a byte inside reads
like another line; only a checksum tells.

With a counter, what is missing between two rows is counted, and one of the same count came twice. By time alone, a row
came twice if all of it is the same and the time usually goes on from row to row. Rows that came late in one lot are put
in order; one that comes after its successors were handed over is left out, and counted.
"""

from __future__ import annotations

import binascii
import functools
import operator
import re
import zlib
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...files.loggers.rows import RowLayout, Rows
from .dialect import SUM_BYTES, Dialect

LONGEST = 2**16  # bytes of a line, or of a packet that is waited for
BYTE_ORDER: Mapping[str, Literal["<", ">"]] = {"little": "<", "big": ">"}
LATE = 64  # rows that one may come late by
Steps = NDArray[np.float64]


def crc16_modbus(data: bytes) -> int:
    """Return the CRC-16 of Modbus: polynomial 0xA001 reflected, beginning with 0xFFFF."""
    found = 0xFFFF
    for byte in data:
        found = (found >> 8) ^ _MODBUS[(found ^ byte) & 0xFF]
    return found


def _modbus_row(value: int) -> int:
    for _ in range(8):
        value = (value >> 1) ^ (0xA001 if value & 1 else 0)
    return value


_MODBUS = tuple(_modbus_row(value) for value in range(256))
SUMS: Mapping[str, Callable[[bytes], int]] = {
    "xor8": lambda data: functools.reduce(operator.xor, data, 0),
    "sum8": lambda data: sum(data) & 0xFF,
    "crc16_ccitt": lambda data: binascii.crc_hqx(data, 0xFFFF),
    "crc16_modbus": crc16_modbus,
    "crc32": zlib.crc32,
}


@dataclass
class Counts:
    """What was not taken as it came, since the beginning."""

    damaged: int = 0  # Lines or packets that are not whole
    passed: int = 0  # Bytes passed over until rows were found
    doubled: int = 0  # Rows that came twice
    late: int = 0  # Rows that came after later ones
    lost: int = 0  # Rows that the counter says are missing
    restarted: int = 0  # Times that counter or time began anew


class Decoder:
    """Rows of one connection after the other.

    Parameters
    ----------
    dialect : Dialect
        Of lines or packets.
    begins_whole : bool
        Whether what comes first after connecting is the beginning of a line.
    """

    def __init__(self, dialect: Dialect, begins_whole: bool) -> None:
        layout = dialect.layout
        assert layout is not None  # noqa: S101 - the caller has looked
        assert dialect.frame is not None  # noqa: S101 - as the layout
        self.dialect, self.frame, self.layout, self.begins_whole = dialect, dialect.frame, layout, begins_whole
        self.counts = Counts()
        self.order = Order(layout, self.counts)
        self._held, self._in_step = b"", begins_whole
        order = BYTE_ORDER[self.frame.byte_order]
        parts = [
            (f"pad_{i}" if one.type == "pad" else one.name,
             f"V{one.bytes}" if one.type == "pad" else np.dtype(one.type).newbyteorder(order).str)
            for i, one in enumerate(dialect.fields)
        ]  # fmt: skip
        ends = [("sum_bytes", f"V{SUM_BYTES[self.frame.checksum]}")] if self.frame.checksum != "none" else []
        self._sync, self._row_type = dialect.sync, layout.dtype
        self._packet = np.dtype([("sync_bytes", f"V{len(dialect.sync)}"), *parts, *ends])

    def reset(self) -> None:
        """Forget what was held of the last connection."""
        self._held, self._in_step = b"", self.begins_whole
        self.order.reset()

    def feed(self, data: bytes, whole: bool = False) -> Rows:
        """Return the rows that are complete now.

        Parameters
        ----------
        data : bytes
            What has come.
        whole : bool
            It ends where a line or packet ends, as a datagram does.
        """
        self._held += data
        rows = self._lines(whole) if self.frame.kind == "lines" else self._packets()
        if whole and self._held:
            self.counts.damaged += 1
            self._held = b""
        return self.order.checked(rows)

    # ---- lines ----

    def _lines(self, whole: bool) -> Rows:
        end = self.dialect.terminator.encode()
        *lines, self._held = self._held.split(end)
        if whole and self._held:
            lines, self._held = [*lines, self._held], b""
        if lines and not self._in_step:
            first = lines.pop(0)
            self.counts.passed += 0 if first.startswith(self.frame.comment.encode() or b"\0") else len(first)
            self._in_step = True
        if len(self._held) > LONGEST:
            self.counts.damaged += 1
            self._held, self._in_step = b"", False
        found = []
        for line in lines:
            try:
                row = self._row(line)
            except (ValueError, OverflowError):
                self.counts.damaged += 1
                continue
            if row is not None:
                found.append(row)
        try:
            return np.array(found, self.layout.dtype)
        except OverflowError:  # a number that its type does not hold
            kept = [one for one in found if self._holds(one)]
            self.counts.damaged += len(found) - len(kept)
            return np.array(kept, self.layout.dtype)

    def _holds(self, row: tuple[float | int, ...]) -> bool:
        try:
            np.array([row], self.layout.dtype)
        except OverflowError:
            return False
        return True

    def _row(self, line: bytes) -> tuple[float | int, ...] | None:
        """Return the numbers of a line; None of a comment, a blank line and one that begins otherwise."""
        text = line.decode("ascii").strip()
        if not text or (self.frame.comment and text.startswith(self.frame.comment)):
            return None
        if self.frame.prefix and not text.startswith(self.frame.prefix):
            return None
        if self.frame.checksum != "none":
            text, star, said = text.rpartition("*")
            covered = text.removeprefix("$").encode()
            if not star or int(said, 16) != SUMS[self.frame.checksum](covered):
                raise ValueError
        text = text.removeprefix(self.frame.prefix)
        cells = text.split() if self.frame.separator == " " else text.split(self.frame.separator)
        if len(cells) != len(self.layout.channels):
            raise ValueError
        return tuple(
            float(cell) if one.type.startswith("float") else int(cell)
            for cell, one in zip(cells, self.layout.channels, strict=True)
        )

    # ---- packets ----

    def _packets(self) -> Rows:
        data, size, sync = self._held, self._packet.itemsize, self._sync
        good: list[bytes] = []
        at = 0
        while len(data) - at >= size:
            if data.startswith(sync, at):
                packet = data[at : at + size]
                if self._sum_fits(packet):
                    good.append(packet)
                    at += size
                    continue
                self.counts.damaged += 1
            following = data.find(sync, at + 1)
            following = following if following >= 0 else max(len(data) - len(sync) + 1, at + 1)
            self.counts.passed += following - at
            at = following
        self._held = data[at:]
        packed = np.frombuffer(b"".join(good), self._packet)
        rows = np.empty(len(packed), self._row_type)
        for one in self.layout.channels:
            rows[one.name] = packed[one.name]
        return rows

    def _sum_fits(self, packet: bytes) -> bool:
        kind = self.frame.checksum
        if kind == "none":
            return True
        covered = packet[0 if self.frame.checksum_over == "all" else len(self._sync) : -SUM_BYTES[kind]]
        return int.from_bytes(packet[-SUM_BYTES[kind] :], self.frame.byte_order) == SUMS[kind](covered)


class Order:
    """What follows what, by the counter of an instrument or, without one, by its time.

    A row up to `LATE` rows behind came late. What is further behind, and a wide counter that jumps by more than half of
    its range, is an instrument that began anew: counting goes on from there.
    """

    def __init__(self, layout: RowLayout, counts: Counts) -> None:
        self.counter = layout.role("counter")
        self.key = self.counter or layout.role("time")
        self.counts = counts
        self.reset()

    def reset(self) -> None:
        """Take the next row as the first."""
        self._last: Rows | None = None  # shape (1,)
        self._apart: deque[float] = deque(maxlen=LATE)  # steps from row to row, of late

    def checked(self, rows: Rows) -> Rows:
        """Return rows in order, without those that came twice or too late; count what is missing."""
        if self.key is None or not len(rows):
            return rows
        if self.counter is not None and self._last is not None:  # what is usual, without looking closer
            counted = [*self._last[self.counter.name].tolist(), *rows[self.counter.name].tolist()]
            if counted == list(range(counted[0], counted[0] + len(counted))):
                self._last = rows[-1:]
                return rows
        steps = self._steps(rows[self.key.name])
        if self._last is not None and self._began_anew(steps):
            self.counts.restarted += 1
            self.reset()
            steps = self._steps(rows[self.key.name])
        order = np.argsort(steps, kind="stable")
        rows, steps = rows[order], steps[order]
        first = self._last is None
        in_time = (steps >= 0.0) | first
        self.counts.late += int(np.sum(~in_time))
        rows, steps = rows[in_time], steps[in_time]
        if not len(rows):
            return rows
        apart = np.diff(steps, prepend=steps[0] - 1.0 if first else 0.0)
        doubled = self._doubled(rows, apart)
        self._apart.extend(apart[1:] if first else apart)
        self.counts.doubled += int(np.sum(doubled))
        rows, steps = rows[~doubled], steps[~doubled]
        if not len(rows):
            return rows
        if self.counter is not None:
            self.counts.lost += int(np.sum(np.diff(steps, prepend=steps[0] - 1.0 if first else 0.0) - 1.0))
        self._last = rows[-1:]
        return rows

    def _doubled(self, rows: Rows, apart: Steps) -> NDArray[np.bool_]:
        """Return which rows came before, shape (n,)."""
        again: NDArray[np.bool_] = apart == 0.0
        if self.counter is None and again.any():
            usual = np.median([*self._apart, *apart])
            lines = [one.tobytes() for one in rows]
            before = [b"" if self._last is None else self._last.tobytes(), *lines[:-1]]
            same = [one == other for one, other in zip(lines, before, strict=True)]
            again &= np.array(same) & (usual > 0)
        return again

    def _began_anew(self, steps: Steps) -> bool:
        assert self.key is not None  # noqa: S101 - looked at above
        if self.counter is None:
            return bool(np.all(steps < -LATE * np.median([*self._apart, 0.0])))
        size = np.dtype(self.key.type).itemsize
        return size >= 4 and bool(np.any((steps < -LATE) | (steps > 2.0 ** (8 * size - 1))))

    def _steps(self, values: NDArray[Any]) -> Steps:
        """Return how far each row is beyond the last one taken; a counter begins anew at the end of its type."""
        assert self.key is not None  # noqa: S101 - looked at above
        last = (values if self._last is None else self._last[self.key.name])[0].item()
        if self.counter is None:
            return np.asarray(values, np.float64) - float(last)
        if values.dtype.itemsize == 8:
            return (values.astype(np.int64) - np.int64(last)).astype(np.float64)
        span = 2 ** (8 * values.dtype.itemsize)
        late = min(LATE, span // 8)
        steps: Steps = ((values.astype(np.int64) - int(last) + late) % span - late).astype(np.float64)
        return steps


def number_in(answer: str, pattern: str) -> float:
    """Return the number in an answer.

    Raises
    ------
    DataError
        ``no_number``.
    """
    found = re.findall(pattern, answer)
    try:
        return float(found[-1])
    except (IndexError, ValueError):
        raise DataError(f"the answer {answer[:80]!r} holds no number", code="no_number") from None
