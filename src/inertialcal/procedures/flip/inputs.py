"""Readings of a flip: from a table of reduced means, or from recordings with the positions of the head."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.times import read_elapsed, read_instant
from ...core.units import convert, factor, kind, si_unit
from ...files.text.table import Table
from ..protocol import Source
from .dwells.plausible import readable
from .dwells.quiet import Window
from .dwells.recordings import FlipRecording
from .entry import FlipEntry, Means, Position
from .readings import Readings
from .tables import MeanOf, readings_of_means


def readings_of_means_tables(sources: Sequence[Source]) -> Readings:
    """Return the readings of tables of reduced means.

    Raises
    ------
    DataError
        ``nothing_left`` if no row is in the groups of the test; as `means_of`.
    """
    found: list[MeanOf] = []
    remarks: list[Remark] = []
    for source in sources:
        table, means = source.table(), cast("FlipEntry", source.entry).means
        assert means is not None  # noqa: S101 - as the file was checked
        rows = means_of(table, means, source.file)
        chosen = [one for one in rows if source.groups is None or one.flip in source.groups]
        source.chose(len(chosen))
        found += chosen
        remarks += [*table.remarks, *table.missing(means.mean)]
    if not found:
        what = f"test {sources[0].test!r}: no row is in its groups ({', '.join(sources[0].groups or ())})"
        raise DataError(what, code="nothing_left")
    readings = readings_of_means(found)
    return replace(readings, remarks=(*remarks, *readings.remarks))


def means_of(table: Table, means: Means, file: str) -> list[MeanOf]:
    """Return the means of a table, a row each, SI.

    Raises
    ------
    DataError
        If a column is missing, a position has no angle (``wrong_value``), or an axis is none of x, y, z.
    """
    angles = means.angles
    values = convert(table.numbers(means.mean), means.unit, si_unit(means.unit))
    axes, positions = table.text(means.axis), table.text(means.position)
    flips = table.text(means.flip) if means.flip else ("1",) * len(table)
    warm = table.numbers(means.temperature) if means.temperature else [math.nan] * len(table)
    scale = factor(means.unit, si_unit(means.unit))
    told = _predicted(table, means)
    widths = {float(p): table.numbers(column, required=False) * scale for p, column in means.half_widths.items()}
    found = []
    for i, row in enumerate(table.rows):
        where = f"{file}:{row}"
        if positions[i] not in angles:
            what = f"column {means.position!r}: position {positions[i]!r} has no angle"
            raise DataError(what, where, do=f"means.angles has: {', '.join(angles)}", code="wrong_value")
        given = tuple((p, float(width[i])) for p, width in widths.items() if math.isfinite(width[i]))
        found.append(
            MeanOf(
                axes[i].lower(),
                angles[positions[i]],
                float(values[i]),
                flips[i],
                given,
                float(warm[i]),
                where=where,
                predicted=float(told[i]),
            )
        )
    return found


def _predicted(table: Table, means: Means) -> Array:
    """Return the bias that a ground model predicts, SI, shape (n,); in the unit of the means, or that of its head."""
    if means.predicted is None:
        return np.full(len(table), math.nan)
    own = table.unit(means.predicted)
    unit = own if own is not None and kind(own) == kind(means.unit) else means.unit
    return table.numbers(means.predicted) * factor(unit, si_unit(unit))


def turned_head(source: Source) -> FlipRecording:
    """Return a recording with the windows that its entry gives.

    Raises
    ------
    DataError
        ``wrong_time`` if a time is not on the clock of the recording.
    """
    name, entry = source.name, cast("FlipEntry", source.entry)
    recording = readable(source.recordings()[0][1])
    begin = None if entry.clock is None else entry.clock.mission_start
    origin = None if begin is None else read_instant(begin)
    return FlipRecording(
        recording, tuple(_window(one, recording, name, origin) for one in entry.positions or ()), name=name
    )


def _window(given: Position, recording: Recording, name: str, origin: int | None) -> Window:
    start, stop = (_instant(one, recording, name, origin) for one in (given.start, given.stop))
    return Window(start, stop, given.angle, given.flip)


def _instant(given: Any, recording: Recording, name: str, origin: int | None) -> int:
    """Return an instant on the clock of the recording [ns]; ``origin``: where mission elapsed time is zero."""
    try:
        return read_instant(given, origin) if recording.epoch == "utc" else read_elapsed(given)
    except ValueError as error:
        clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {recording.source.path or name} is {clock}"
        raise DataError(f"recordings.{name}.positions: {error}", why=why, code="wrong_time") from None
