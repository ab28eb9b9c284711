"""miniSEED, versions 2 and 3, by pymseed: traces of counts, each with the times of its records.

The three components of an instrument share a clock where their records do; then they are one recording. Units are not
in such a file: its numbers are counts of the recorder.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.recording import SECOND
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, VALUE, check_count, claim_room
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from .topics import NO_NUMBERS, OTHER, Topic, choose, left_out, library, other_topics, torn

VERSION_3 = b"MS\x03"
QUALITIES = b"DRQM"
NUMBERS = {"i": np.int32, "f": np.float32, "d": np.float64}


def read_miniseed(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the traces that share a clock.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    pymseed = library("pymseed", "a miniSEED file", loaded.path)
    whole = _whole_until(pymseed, loaded.data)
    with pymseed.MS3TraceList.from_buffer(loaded.data[:whole], unpack_data=True) as traces:
        check_count(len(traces), PARTS, "traces", loaded.path)
        clocks: dict[tuple[Any, ...], list[tuple[str, NDArray[Any]]]] = {}
        times: dict[tuple[Any, ...], list[tuple[int, float, int]]] = {}
        others: list[str] = []
        for trace in traces:
            segments = [one for one in trace if one.numsamples]
            if not segments or any(one.sampletype not in NUMBERS or one.samprate <= 0 for one in segments):
                others.append(trace.sourceid)
                continue
            key = tuple((one.starttime, one.samprate, one.numsamples) for one in segments)
            rows = sum(one.numsamples for one in segments)
            claim_room(loaded.path, loaded.on_disk, 2 * VALUE * rows, f"{rows:,} samples")
            values = np.concatenate([np.array(one.np_datasamples, copy=True) for one in segments])
            clocks.setdefault(key, []).append((trace.sourceid.removeprefix("FDSN:"), values))
            times[key] = list(key)
    topics, by_name = [], {}
    for key, own in clocks.items():
        rows = sum(count for _, _, count in times[key])
        topics.append(
            Topic(own[0][0], f"{len(own)} trace(s), {times[key][0][1]:g} Hz", rows, OTHER if rows > 1 else NO_NUMBERS)
        )
        by_name[own[0][0]] = key
    chosen = choose(topics, variables, loaded.path)
    key = by_name[chosen[0].name]
    stamps = [start + np.rint(np.arange(count) * (SECOND / rate)).astype(np.int64) for start, rate, count in times[key]]
    time = Column("time", np.concatenate(stamps).view("datetime64[ns]"))
    columns = [
        number_column(name, values, "count" if values.dtype.kind == "i" else None) for name, values in clocks[key]
    ]
    remarks = (*left_out(others, loaded.path), *other_topics(topics, chosen, loaded.path))
    if whole < len(loaded.data):
        remarks += torn(loaded.path, len(loaded.data) - whole, whole)
    return Content((time, *columns), "miniSEED", remarks=remarks)


def _whole_until(pymseed: Any, data: bytes) -> int:
    """Return the byte at which the last whole record ends."""
    at = 0
    try:
        for record in pymseed.MS3Record.from_buffer(data):
            at += record.reclen
    except Exception:  # noqa: S110 - what is not whole shows below
        pass
    return at


def _recognises(data: bytes, path: str) -> bool:
    start = data[:8]
    old = start[:6].isdigit() and start[6:7] in [QUALITIES[i : i + 1] for i in range(4)] and start[7:8] in (b" ", b"\0")
    return start.startswith(VERSION_3) or (len(start) == 8 and old)


READER = Reader(
    "miniseed", "miniSEED", (".mseed", ".msd", ".seed"), _recognises, apart(read_miniseed, "a miniSEED file")
)
