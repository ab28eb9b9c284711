"""TDMS files of LabVIEW, by npTDMS: channels in groups, scaled as the file says.

The time of a channel is that of its waveform: start and increment. A start that LabVIEW left unset lies in 1904.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.batches import SIZE, made
from ...core.errors import DataError
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, VALUE, check_count, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import Loaded
from .topics import (
    NO_NUMBERS,
    Topic,
    choose,
    has_temperature,
    joined,
    left_out,
    library,
    on_disk,
    other_topics,
    rank_of,
    torn,
    unique,
    with_thermometer,
)

MAGIC, LEAD_IN = b"TDSm", 28  # bytes
WAVEFORM = ("wf_increment", "wf_start_time", "wf_start_offset")
UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit")
SET = np.datetime64("1971-01-01", "ns")  # starts before it were never set


def read_tdms(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the channels of a group that share a clock.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    nptdms = library("nptdms", "a TDMS file", loaded.path)
    with on_disk(loaded, ".tdms") as path, nptdms.TdmsFile.open(path) as file:
        sets: dict[tuple[Any, ...], list[Any]] = {}
        others: list[str] = []
        is_torn = bool(file.file_status.incomplete_final_segment)
        channels = [one for group in file.groups() for one in group.channels()]
        check_count(len(channels), PARTS, "channels", loaded.path)
        for one in channels:
            kind = one.dtype
            if len(one) and kind is not None and np.dtype(kind).kind in "biufM":
                waveform = (str(one.properties.get(key)) for key in WAVEFORM)
                sets.setdefault((one.group_name, 0 if is_torn else len(one), *waveform), []).append(one)
            else:
                others.append(one.name)
        several = [group for group in {clock[0] for clock in sets} if sum(clock[0] == group for clock in sets) > 1]
        by_name: dict[str, list[Any]] = {}
        clocks: dict[str, list[Any]] = {}
        for (group, *clock), members in sets.items():
            name = f"{group}/{members[0].name}" if group in several else group
            by_name[name], clocks[name] = members, clock
        topics = [_topic(name, these) for name, these in by_name.items()]
        chosen = with_thermometer(topics, choose(topics, variables, loaded.path), variables)
        if all(clocks[topic.name] == clocks[chosen[0].name] for topic in chosen):
            content = _content([one for topic in chosen for one in by_name[topic.name]], loaded)
        else:
            parts = [(topic, _content(by_name[topic.name], loaded)) for topic in chosen]
            timed = all(part.columns[0].values.dtype.kind == "M" for _, part in parts)
            if not timed and variables:
                raise DataError(
                    "groups of different clocks", loaded.path, do="Read one at a time", code="several_clocks"
                )
            content = joined(parts, loaded.path, named=bool(variables)) if timed else parts[0][1]
        said = (*left_out(others, loaded.path), *_torn(file, loaded), *other_topics(topics, chosen, loaded.path))
        return replace(content, remarks=(*content.remarks, *said))


def _content(taken: Sequence[Any], loaded: Loaded) -> Content:
    """Return channels of one clock, behind its stamps where their start is known."""
    rows = min(len(one) for one in taken)
    claim_room(loaded.path, loaded.on_disk, 2 * VALUE * rows * (len(taken) + 1), f"{rows * len(taken):,} values")
    long = LongColumns(rows)
    names = unique([one.name for one in taken])
    step = max(SIZE // 4, 1)
    for first in range(0, rows, step):
        count = min(step, rows - first)
        long.add([number_column(name, np.asarray(one.read_data(first, count)), _unit(one.properties))
                  for name, one in zip(names, taken, strict=True)])  # fmt: skip
    clock, rate = _clock(taken[0].properties, rows)
    columns = [replace(column, matrix=one.group_name) for column, one in zip(long.columns(), taken, strict=True)]
    return Content((*clock, *columns), "TDMS", None, rate)


def _topic(name: str, channels: Sequence[Any]) -> Topic:
    rows = min(map(len, channels))
    said = [(one.name, _unit(one.properties)) for one in channels]
    rank = rank_of(said, name) if rows > 1 else NO_NUMBERS
    return Topic(name, " ".join(one.name for one in channels[:6]), rows, rank, has_temperature(said, name))


def _unit(properties: Any) -> str | None:
    said = next((str(properties[name]) for name in UNITS if properties.get(name)), "")
    return said.strip() or None


def _clock(properties: Any, rows: int) -> tuple[tuple[Column, ...], float | None]:
    """Return the time of a waveform: a column where its start is known, else the sample rate."""
    try:
        step = float(properties.get("wf_increment", 0.0))
        offset = float(properties.get("wf_start_offset", 0.0))
    except (TypeError, ValueError):
        return (), None
    if not np.isfinite(step) or step <= 0.0:
        return (), None
    start = properties.get("wf_start_time")
    if not isinstance(start, np.datetime64) or not start > SET:
        return (), 1.0 / step
    zero = int(start.astype("datetime64[ns]").astype(np.int64)) + round(offset * SECOND)

    def part(first: int, stop: int) -> Times:
        since: Times = np.rint(np.arange(first, stop) * (step * SECOND)).astype(np.int64)
        return zero + since

    time_ns = made(rows, np.int64, part)
    return (Column("time", time_ns.view("datetime64[ns]")),), None


def _torn(file: Any, loaded: Loaded) -> tuple[Remark, ...]:
    status, path = file.file_status, loaded.path
    if not status.incomplete_final_segment:  # one that is cut off before its values is passed over by npTDMS
        whole, size = _whole_until(loaded.data), len(loaded.data)
        return torn(path, size - whole, whole, "the last segment is not whole") if whole < size else ()
    there = status.channel_statuses or {}
    lost = max((one.expected_length - one.read_length for one in there.values()), default=0)
    what = "the last segment is not whole" + (f": {lost:,} rows of it are missing" if lost > 0 else "")
    do = "Was the logger switched off while it wrote?"
    return (Remark("torn_file", "warning", what, where=path, count=max(lost, 1), do=do),)


def _whole_until(data: bytes) -> int:
    """Return the byte at which the last whole segment ends: a lead-in says where the next begins (ni.com, TDMS)."""
    at, size = 0, len(data)
    while data[at : at + 4] == MAGIC and at + LEAD_IN <= size:
        following = at + LEAD_IN + int.from_bytes(data[at + 12 : at + 20], "little")
        if following > size:
            break
        at = following
    return at


READER = Reader(
    "tdms", "TDMS", (".tdms",), lambda data, path: data.startswith(MAGIC), apart(read_tdms, "a TDMS file"), True
)
