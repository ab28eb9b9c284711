"""Exports of HOBO loggers: the time zone stands in the header, and rows of events hold no readings.

A header is ``Date Time, GMT+01:00``, in summer time as well: the offset that the logger was started with holds to the
end, whatever the clocks of its place do.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ...core.recording import SECOND
from ...core.remarks import Remark
from ..columns import Column, Content

ZONE = re.compile(r"(?:GMT|UTC) ?([+-])([0-9]{1,2}):?([0-9]{2})?\b")
LOGGER, SENSOR = "LGR S/N", "SEN S/N"  # serial numbers in headers


def zone_of(name: str) -> int | None:
    """Return how far a clock is ahead of UTC by the header of its column [ns]: ``Date Time, GMT+01:00``; else None."""
    said = ZONE.search(name)
    if said is None:
        return None
    minutes = 60 * int(said[2]) + int(said[3] or 0)
    return (minutes if said[1] == "+" else -minutes) * 60 * SECOND


def without_events(content: Content, path: str) -> Content:
    """Return the content without rows in which no sensor was read: the logger wrote down an event."""
    if not any(LOGGER in one.name for one in content.columns):
        return content
    read = [one for one in content.columns if SENSOR in one.name and one.is_number]
    gone = np.zeros(len(content), dtype=int)
    for one in read:
        gone[one.empty] += 1
    kept = np.flatnonzero(gone < max(len(read), 1))
    count = len(content) - len(kept)
    if not read or not count or not len(kept):
        return content
    first = int(np.flatnonzero(gone == len(read))[0])
    remark = Remark(
        "event_rows", "info", "rows of events without readings: left out", content.place(path, first), count
    )
    place = np.cumsum(gone < len(read)) - 1  # of a row among those that are kept

    def cut(one: Column) -> Column:
        return replace(
            one,
            values=one.values[kept],
            empty=place[one.empty[gone[one.empty] < len(read)]],
            not_a_number=place[one.not_a_number[gone[one.not_a_number] < len(read)]],
        )

    rows = None if content.rows is None else np.asarray(content.rows)[kept]
    return replace(content, columns=tuple(map(cut, content.columns)), rows=rows, remarks=(*content.remarks, remark))
