"""Readings of a mass-attraction calibration: recordings with the schedule of the mass, or a table of reduced runs."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from ...core.errors import DataError
from ...core.recording import Channel, Recording
from ...core.times import read_elapsed, read_instant
from ...core.units import factor, parse_quantity
from ...files.text.table import Table
from ..protocol import Source
from .entry import Lines, MassEntry
from .readings import Line
from .recordings import READING, TEMPERATURE, TILT, SourceMassRecording
from .schedule_csv import read_schedule

SAME = 0.01  # relative difference of gate and averaging time that is none
YES, NO = ("yes", "true", "1"), ("no", "false", "0")


def moved_mass(source: Source) -> SourceMassRecording:
    """Return a recording as ``readings_from`` wants it: pulses a second, tilt [rad], temperature [degC].

    Raises
    ------
    DataError
        ``gate_disagrees`` if gate and averaging time differ; if recording or schedule cannot be read.
    """
    name, entry, facts = source.name, cast("MassEntry", source.entry), source.facts
    assert entry.mass is not None  # noqa: S101 - as the file was checked
    schedule = source.read_file(entry.mass.schedule, read_schedule)
    gate = float(facts.gate or 0.0)
    averaging = None if entry.clock is None else entry.clock.averaging
    if averaging is not None and abs(averaging / gate - 1.0) > SAME:
        what = f"recordings.{name}: clock.averaging is {averaging:g} s, the gate of the chain {gate:g} s"
        why = "pulses are counted for the gate: the scale factor would be wrong by their ratio"
        raise DataError(what, entry.file, why, "Mend the one that is wrong", "gate_disagrees")
    _, body = source.recordings()[0]
    axis = next(one for one in facts.axes if one in (entry.channels or {}))
    rate = np.asarray(body.channel(axis).data, dtype=np.float64) * (facts.pulse_scale_factor or 1.0)
    kept = tuple(body.channel(one) for one in (TILT, TEMPERATURE) if one in body.names)
    made = (Channel(READING, rate, "count/s", "chain", axis), *kept)
    found = replace(body, channels=made, averaging_time=averaging or gate)
    begin = _begin(entry.mass.begin, found, name)
    return SourceMassRecording(found, schedule, begin, entry.run or name, entry.mass.moved)


def _begin(given: str | int | float | None, recording: Recording, name: str) -> int | None:
    """Return when the schedule starts, on the clock of the recording [ns]."""
    if given is None:
        return None
    try:
        return read_instant(given) if recording.epoch == "utc" else read_elapsed(given)
    except ValueError as error:
        clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {recording.source.path or name} is {clock}"
        raise DataError(f"recordings.{name}.mass.begin: {error}", why=why, code="wrong_time") from None


def lines_of(table: Table, lines: Lines, file: str) -> list[Line]:
    """Return the runs of a table that was reduced before, a row each, SI.

    Raises
    ------
    DataError
        If a column is missing, or a cell that is needed is empty or no number.
    """
    applied = table.numbers(lines.applied) * factor(lines.applied_unit, "m/s^2")
    scale = factor(lines.unit, "count/s")
    columns = {
        what: np.full(len(table), math.nan) if column is None else table.numbers(column) * scale
        for what, column in (
            ("response", lines.response), ("noise", lines.noise), ("psd_response", lines.psd_response),
            ("psd_noise", lines.psd_noise), ("scatter", lines.scatter),
        )
    }  # fmt: skip
    u = 0.0 if lines.u_applied is None else parse_quantity(lines.u_applied).to("m/s^2", difference=True)
    moved = table.text(lines.moved) if lines.moved else ("yes",) * len(table)
    strokes = [a for a, cell in zip(applied.tolist(), moved, strict=True) if cell.lower() in YES and a > 0.0]
    found = []
    for i, name in enumerate(table.text(lines.run)):
        where = f"{file}:{table.rows[i]}"
        is_moved = _is_yes(moved[i], lines.moved or "", where)
        amplitude = float(applied[i]) if is_moved else (strokes[0] if strokes else math.nan)
        _check_row(amplitude, columns["response"][i], columns["noise"][i], where)
        found.append(
            Line(
                name, amplitude, beside=lines.beside, u_applied=u / amplitude, moved=is_moved, where=where,
                **{what: float(values[i]) for what, values in columns.items()},
            )
        )  # fmt: skip
    return found


def _is_yes(cell: str, column: str, where: str) -> bool:
    word = cell.strip().lower()
    if word not in (*YES, *NO):
        raise DataError(f"column {column!r}: {cell!r}", where, do="Write yes or no", code="wrong_value")
    return word in YES


def _check_row(applied: float, response: float, noise: float, where: str) -> None:
    if not (applied > 0.0 and math.isfinite(response) and noise > 0.0):
        what = f"applied {applied:g} m/s^2, response {response:g}, noise {noise:g} count/s"
        raise DataError(what, where, "a run needs all three, noise and applied above zero", code="missing_value")
