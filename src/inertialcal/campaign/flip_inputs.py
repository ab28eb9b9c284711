"""Readings of a flip: from a table of reduced means, or from recordings with the positions of the head."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.influence import Standards
from ..core.recording import Recording
from ..core.times import read_elapsed, read_instant
from ..core.units import convert, factor, kind, si_unit
from ..files.text.table import Table, read_table
from ..procedures.flip import reduction as flip
from ..procedures.flip.plausible import readable
from ..procedures.flip.recordings import Turned, readings_from
from ..procedures.flip.tables import MeanOf, readings_of_means
from .channels import prepare_recording
from .ground import chain_model
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .schema import Test
from .schema_recordings import Means, Position, RecordingEntry
from .schema_sensors import Sensor


def prepared_flip(campaign: Campaign, test: Test, sensor: Sensor) -> Prepared:
    """Return a flip ready to be reduced.

    Raises
    ------
    DataError
        If a recording cannot be read, or means and recordings are mixed in one test.
    """
    plan = flip_plan(test, campaign.standards)
    entries = {name: campaign.file.recordings[name] for name in test.recordings}
    tables = [name for name, entry in entries.items() if entry.means is not None]
    if tables and len(tables) < len(entries):
        what = f"test {test.id!r}: reduced means ({', '.join(tables)}) and recordings in one test"
        raise DataError(what, do="Make two tests of them", code="wrong_value")
    if tables:
        return _from_means(campaign.folder, test, plan, entries)
    return _from_recordings(campaign.folder, test, sensor, plan, entries)


def flip_plan(test: Test, standards: Standards) -> flip.Plan:
    """Return the plan of a test, with the standards of the campaign."""
    values, _ = plan_values(test.procedure, test.plan, "")
    return flip.Plan(**values, standards=standards)


def _from_means(folder: Path, test: Test, plan: flip.Plan, entries: dict[str, RecordingEntry]) -> Prepared:
    found: list[MeanOf] = []
    inputs, origins, remarks = {}, [], []
    for name, entry in entries.items():
        table = read_table(folder / entry.file)
        assert entry.means is not None  # noqa: S101 - tables only
        means = means_of(table, entry.means, entry.file)
        chosen = [one for one in means if test.groups is None or one.flip in test.groups]
        found += chosen
        inputs[entry.file] = table.source.sha256
        origins.append(Origin(name, entry.file, table.source.sha256, "table", len(table), len(chosen)))
        remarks += [*table.remarks, *table.missing(entry.means.mean)]
    if not found:
        what = f"test {test.id!r}: no row is in its groups ({', '.join(test.groups or ())})"
        raise DataError(what, code="nothing_left")
    readings = readings_of_means(found)
    readings = replace(readings, remarks=(*remarks, *readings.remarks))
    return Prepared(test, plan, readings, inputs, tuple(origins))


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


def _from_recordings(
    folder: Path, test: Test, sensor: Sensor, plan: flip.Plan, entries: dict[str, RecordingEntry]
) -> Prepared:
    turned, inputs, origins = [], {}, []
    for name, entry in entries.items():
        recording = prepare_recording(folder, name, entry, sensor, keep_bias=not plan.corrected)
        turned.append(turned_head(recording, name, entry))
        inputs[entry.file] = recording.source.sha256
        origins.append(Origin(name, entry.file, recording.source.sha256, "recording", len(recording), len(recording)))
    model = chain_model(sensor, folder)
    if model is not None and model.file:
        inputs[model.file] = model.sha256
    return Prepared(test, plan, readings_from(plan, turned), inputs, tuple(origins))


def turned_head(recording: Recording, name: str, entry: RecordingEntry) -> Turned:
    """Return a recording with the windows that its entry gives.

    Raises
    ------
    DataError
        ``wrong_time`` if a time is not on the clock of the recording.
    """
    recording = readable(recording)
    begin = None if entry.clock is None else entry.clock.mission_start
    origin = None if begin is None else read_instant(begin)
    return Turned(recording, tuple(_window(one, recording, name, origin) for one in entry.positions or ()), name=name)


def _window(given: Position, recording: Recording, name: str, origin: int | None) -> flip.Window:
    start, stop = (_instant(one, recording, name, origin) for one in (given.start, given.stop))
    return flip.Window(start, stop, given.angle, given.flip)


def _instant(given: Any, recording: Recording, name: str, origin: int | None) -> int:
    """Return an instant on the clock of the recording [ns]; ``origin``: where mission elapsed time is zero."""
    try:
        return read_instant(given, origin) if recording.epoch == "utc" else read_elapsed(given)
    except ValueError as error:
        clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {recording.source.path or name} is {clock}"
        raise DataError(f"recordings.{name}.positions: {error}", why=why, code="wrong_time") from None
