"""Recordings of a stepped table as sources give them: axis that was turned, and rates, by channel or schedule."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from ...core.errors import DataError
from ...core.recording import SECOND, Recording
from ...core.times import read_instant
from ...core.units import convert
from ...files.text.table import read_table
from ..protocol import Source
from .entry import RateTableEntry, Schedule
from .plan import Plan
from .recordings import APPLIED, RateTableRecording


def turned_recordings(plan: Plan, sources: Sequence[Source]) -> list[RateTableRecording]:
    """Return recordings as ``readings_from`` wants them.

    Raises
    ------
    DataError
        If nothing says which axis was turned, or at which rates.
    """
    return [_turned(plan, source) for source in sources]


def _turned(plan: Plan, source: Source) -> RateTableRecording:
    entry, (_, recording) = cast("RateTableEntry", source.entry), source.recordings()[0]
    axis = entry.axis or plan.axis
    if not axis:
        what = f"recordings.{source.name}: nothing says which axis was turned"
        raise DataError(what, do='Give axis = "x" there, or plan = { axis = "x" }', code="no_axis")
    if entry.schedule is None:
        if APPLIED not in recording.names:
            do = "Give channels.applied (the rate of the table), or a schedule"
            raise DataError(f"recordings.{source.name}: nothing says the rate of the table", do=do, code="no_applied")
        return RateTableRecording(recording, str(axis), source.run, name=source.name, file=source.file)
    windows, rates = _scheduled(source, entry.schedule, recording)
    if source.windows:
        inside = [any(a <= start and stop <= b for a, b in source.windows) for start, stop in windows]
        windows, rates = tuple(w for w, use in zip(windows, inside, strict=True) if use), rates[np.array(inside)]
    return RateTableRecording(recording, str(axis), source.run, windows, rates, source.name, source.file)


def _scheduled(
    source: Source, schedule: Schedule, recording: Recording
) -> tuple[tuple[tuple[int, int], ...], np.ndarray]:
    """Windows [ns] and rates [SI] of a schedule."""
    table = source.read_file(schedule.file, read_table)
    rates = convert(table.numbers(schedule.rate), schedule.unit, source.facts.si)
    if not np.all(np.isfinite(rates)):
        where = f"{schedule.file}:{table.rows[int(np.flatnonzero(~np.isfinite(rates))[0])]}"
        raise DataError(f"column {schedule.rate!r}: no rate", where, do="Fill it in", code="nan_in_required")
    utc = recording.epoch == "utc"
    starts, stops = (
        [
            _instant(cell, utc, f"{schedule.file}:{row}")
            for cell, row in zip(table.text(column), table.rows, strict=True)
        ]
        for column in (schedule.start, schedule.stop)
    )
    return tuple(zip(starts, stops, strict=True)), rates


def _instant(cell: str, utc: bool, where: str) -> int:
    try:
        number: float | str = float(cell)
    except ValueError:
        number = cell
    if not utc and isinstance(number, float) and np.isfinite(number) and abs(number) < 1e9:
        return round(number * SECOND)
    try:
        return read_instant(number)
    except ValueError as error:
        raise DataError(str(error), where, code="wrong_time") from None
