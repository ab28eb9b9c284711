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
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, VALUE, check_count, claim_room
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from .topics import NO_NUMBERS, OTHER, Topic, choose, joined, left_out, library, other_topics, torn

VERSION_3 = b"MS\x03"
QUALITIES = b"DRQM"
Clock = tuple[tuple[int, float, int], ...]  # start [ns], sample rate [Hz] and samples of each segment
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
        clocks: dict[Clock, list[tuple[str, NDArray[Any]]]] = {}
        others: list[str] = []
        for trace in traces:
            segments = [one for one in trace if one.numsamples]
            if not segments or any(one.sampletype not in NUMBERS or one.samprate <= 0 for one in segments):
                others.append(trace.sourceid)
                continue
            key = tuple((one.starttime, one.samprate, one.numsamples) for one in segments)
            if whole < len(loaded.data) and len(key) == 1:  # what was torn may have cut traces at different samples
                key = next((one for one in clocks if len(one) == 1 and one[0][:2] == key[0][:2]), key)
            rows = sum(one.numsamples for one in segments)
            claim_room(loaded.path, loaded.on_disk, 2 * VALUE * rows, f"{rows:,} samples")
            values = np.concatenate([np.array(one.np_datasamples, copy=True) for one in segments])
            clocks.setdefault(key, []).append((trace.sourceid.removeprefix("FDSN:"), values))
    topics, by_name = [], {}
    for key, own in clocks.items():
        rows = min(len(values) for _, values in own)
        what = f"{len(own)} trace(s), {key[0][1]:g} Hz"
        topics.append(Topic(own[0][0], what, rows, OTHER if rows > 1 else NO_NUMBERS))
        by_name[own[0][0]] = key
    chosen = choose(topics, variables, loaded.path)
    parts = [(one, _columns(by_name[one.name], clocks[by_name[one.name]], loaded.path)) for one in chosen]
    content = joined(parts, loaded.path)
    remarks = (*content.remarks, *left_out(others, loaded.path), *other_topics(topics, chosen, loaded.path))
    if whole < len(loaded.data):
        remarks += torn(loaded.path, len(loaded.data) - whole, whole)
    return Content(content.columns, "miniSEED", remarks=remarks)


def _columns(clock: Clock, traces: Sequence[tuple[str, NDArray[Any]]], path: str) -> Content:
    """Return the traces of one clock, its stamps first."""
    rows = min(len(values) for _, values in traces)
    stamps = [start + np.rint(np.arange(count) * (SECOND / rate)).astype(np.int64) for start, rate, count in clock]
    columns = [Column("time", np.concatenate(stamps)[:rows].view("datetime64[ns]"))]
    for name, values in traces:
        columns.append(number_column(name, values[:rows], "count" if values.dtype.kind == "i" else None))
    return Content(tuple(columns), "miniSEED", remarks=_longer(traces, rows, path))


def _longer(traces: Sequence[tuple[str, NDArray[Any]]], rows: int, path: str) -> tuple[Remark, ...]:
    """Return a remark on samples that some traces have and others do not."""
    count = sum(len(values) - rows for _, values in traces)
    what = "samples behind the end of the shortest trace: left out"
    return (Remark("torn_file", "warning", what, where=path, count=count),) if count else ()


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
