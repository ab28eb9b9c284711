"""Readings of a moved-mass campaign: recordings cut into the dwells of their schedule, or runs reduced before.

A sample is the mean over its averaging time (a gate, for pulses; where neither is stated, its interval, a dwell at
most) and belongs to a dwell if all of it lies there.
Samples within a move are left out and counted. A dwell of which half of the samples or more are missing, or no
readings, is a gap: nothing is closed up, because that would shift the phase of the drive.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Channel, Recording
from ...core.remarks import Remark
from ...core.times import read_elapsed, read_instant
from ...core.units import factor, parse_quantity, same_dimension
from ...files.text.table import Table
from ...physics.motion.schedule import Schedule
from ..corrections import corrected
from ..protocol import Correction, Source
from .entry import Lines, MassEntry
from .plan import Plan
from .schedule_csv import read_schedule

READING, TILT, TEMPERATURE = "reading", "tilt", "temperature"
INSIDE = 0.02  # of a dwell, by which a sample may reach beyond it: clocks of logger and mover
HALF = 0.5  # of the samples, that may lie in no dwell; of those of a dwell, that must be there
SAME = 0.01  # relative difference of gate and averaging time that rounding explains
YES, NO = ("yes", "true", "1"), ("no", "false", "0")


@dataclass(frozen=True, eq=False)
class Run:
    """Readings of one run, a value a dwell."""

    name: str  # Of the run
    schedule: Schedule  # Its n dwells
    reading: Array  # shape (n,): mean of each [output unit]; NaN for a gap
    # shape (n,): of the pad, as the meter reads it [rad]; NaN for a gap, None without a meter
    tilt: Array | None = None
    temperature: Array | None = None  # shape (n,): [degC]
    moved: bool = True  # False for a null run
    where: str = ""  # Place of the readings, for messages

    @property
    def there(self) -> int:
        """Number of dwells with a reading."""
        return int(np.isfinite(self.reading).sum())


@dataclass(frozen=True)
class Line:
    """A run reduced before: its line and the mean amplitude of the lines next to it, as a document prints them."""

    name: str  # Of the run
    applied: float  # Amplitude of the drive; of a null run that of a moved mass [m/s^2]
    response: float  # Amplitude at the drive [output unit]
    noise: float  # Mean amplitude of the lines next to it [output unit]
    beside: int = 8  # Number of those lines
    u_applied: float = 0.0  # Relative standard uncertainty of ``applied`` (1)
    moved: bool = True  # False for a null run
    psd_response: float = float("nan")  # Response from the power spectrum [output unit]; NaN if not known
    psd_noise: float = float("nan")  # Noise from the power spectrum [output unit]; NaN if not known
    scatter: float = float("nan")  # Standard deviation of the reduced readings [output unit]; NaN if not known
    where: str = ""  # For messages


@dataclass(frozen=True, eq=False)
class Readings:
    """Runs of one instrument: with a value a dwell, or reduced before; remarks from reading them."""

    series: tuple[Run, ...] = ()
    lines: tuple[Line, ...] = ()
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of dwells with a reading, and of lines."""
        return sum(run.there for run in self.series) + len(self.lines)

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.series) + len(self.lines)


@dataclass(frozen=True, eq=False)
class SourceMassRecording:
    """A recording with the schedule of its mass."""

    # ``reading`` [output unit], perhaps ``tilt`` [rad] and ``temperature`` [degC]; stamps in the middle of each
    # average, with averaging time. Without a time, a row is a dwell.
    recording: Recording
    schedule: Schedule  # Of the mass
    begin: int | None = None  # Start of the schedule on the clock of the recording [ns]; None: the first sample
    name: str = ""  # Of the run
    moved: bool = True  # False for a null run


def moved_mass(source: Source, corrections: Sequence[Correction] = ()) -> SourceMassRecording:
    """Return a recording of a campaign as ``readings_from`` takes it, after corrections.

    What is not known of them changes no response: a constant does not follow the mass.

    Raises
    ------
    DataError
        ``gate_disagrees`` if gate and averaging time differ; if recording or schedule cannot be read.
    """
    name, entry, facts = source.name, cast("MassEntry", source.entry), source.facts
    assert entry.mass is not None  # noqa: S101 - as the file was checked
    schedule = source.read_file(entry.mass.schedule, read_schedule)
    gate, averaging = facts.gate, None if entry.clock is None else entry.clock.averaging
    if gate is not None and averaging is not None and abs(averaging / gate - 1.0) > SAME:
        what = f"recordings.{name}: clock.averaging is {averaging:g} s, the gate of the chain {gate:g} s"
        why = "the scale factor would be wrong by their ratio"
        raise DataError(what, entry.file, why, "Correct the wrong one", "gate_disagrees")
    named = source.recordings()[0]
    body = corrected(corrections, [named])[0][0] if corrections else named[1]
    axis = next(one for one in facts.axes if one in (entry.channels or {}))
    back = 1.0 if facts.si == facts.output_unit else facts.output_scale_factor or 1.0  # from readings to the output
    output = np.asarray(body.channel(axis).data, dtype=np.float64) * back
    kept = tuple(body.channel(one) for one in (TILT, TEMPERATURE) if one in body.names)
    made = (Channel(READING, output, facts.output_unit, "chain", axis), *kept)
    interval = body.sample_interval
    averaging = averaging or gate or body.averaging_time or (interval and min(interval, schedule.dwell))
    found = replace(body, channels=made, averaging_time=averaging)
    begin = None
    if entry.mass.begin is not None:
        try:
            begin = (read_instant if found.epoch == "utc" else read_elapsed)(entry.mass.begin)
        except ValueError as error:
            clock = "UTC" if found.epoch == "utc" else "elapsed time, without a date"
            why = f"the clock of {found.source.path or name} is {clock}"
            raise DataError(f"recordings.{name}.mass.begin: {error}", why=why, code="wrong_time") from None
    return SourceMassRecording(found, schedule, begin, entry.run or name, entry.mass.moved)


def readings_from(plan: Plan, moved: Iterable[SourceMassRecording]) -> Readings:
    """Return the readings of runs, a mean a dwell.

    Parameters
    ----------
    plan : Plan
        Not used yet; as all procedures have it.
    moved : iterable of SourceMassRecording
        Recordings with their schedules.

    Raises
    ------
    DataError
        ``no_time`` if a recording has no averaging time, ``gate_too_long``, ``length_differs`` if record and schedule
        do not span the same time.
    """
    runs, remarks = [], []
    for one in map(_timed, moved):
        where = one.recording.source.path or one.name
        remarks += list(one.recording.remarks)
        if one.recording.time_ns is None:
            runs.append(_run_without_time(one, where))
            continue
        seconds, averaging = _clock(one, where)
        slack = INSIDE * one.schedule.dwell
        at = np.searchsorted(one.schedule.start - slack, seconds - 0.5 * averaging, side="right") - 1
        inside = (at >= 0) & (seconds + 0.5 * averaging <= one.schedule.stop[np.maximum(at, 0)] + slack)
        dwell = np.where(inside, at, -1)
        outside = int(np.sum(dwell < 0))
        if outside > 1 and outside > HALF * len(dwell):
            what = f"{one.name}: {outside} of {len(dwell)} samples lie in no dwell of the schedule"
            do = "Check begin, the clock, and dwell and move of the schedule"
            raise DataError(what, where, "their times do not fit", do, "schedule_differs")
        if outside:
            what = f"{one.name}: samples that reach into a move of the mass, or beyond the schedule, are left out"
            remarks.append(Remark("outside_dwells", "info", what, where, outside))
        means = {
            name: _means(np.asarray(one.recording.channel(name).data, dtype=np.float64), dwell, len(one.schedule))
            for name in (READING, TILT, TEMPERATURE)
            if name in one.recording.names
        }
        run = Run(one.name, one.schedule, means[READING], means.get(TILT), means.get(TEMPERATURE), one.moved, where)
        runs.append(run)
    return Readings(tuple(runs), (), tuple(remarks))


def _timed(one: SourceMassRecording) -> SourceMassRecording:
    """Return a recording with stamps: by its sample rate where it has none, and more rows than there are dwells."""
    recording, interval = one.recording, one.recording.sample_interval
    if recording.time_ns is not None or not interval or len(recording) <= len(one.schedule):
        return one
    stamps = np.rint(np.arange(len(recording)) * (interval * SECOND)).astype(np.int64)
    return replace(one, recording=replace(recording, time_ns=stamps))


def _run_without_time(one: SourceMassRecording, where: str) -> Run:
    gate, dwell = one.recording.averaging_time, one.schedule.dwell
    if one.begin is not None:
        what, do = "the file has no time for the schedule to begin at", "Name the time column, or leave begin out"
        raise DataError(what, where, do=do, code="no_time")
    if gate is not None and abs(gate / dwell - 1.0) > SAME:
        what, why = f"a gate of {gate:g} s, rows of dwells of {dwell:g} s", "pulses are counted for the gate"
        raise DataError(what, where, why, "Correct the wrong one", "gate_disagrees")
    tilt = np.asarray(one.recording.channel(TILT).data, dtype=float) if TILT in one.recording.names else None
    reading = np.asarray(one.recording.channel(READING).data, dtype=float)
    return run_of_rows(one.schedule, reading, tilt, one.name, where, one.moved)


def _clock(one: SourceMassRecording, where: str) -> tuple[Array, float]:
    """Return middles of the samples on the clock of the schedule [s], and the averaging time [s]."""
    recording, schedule = one.recording, one.schedule
    averaging = recording.averaging_time
    assert recording.time_ns is not None  # noqa: S101 - else a row is a dwell
    if averaging is None or not averaging > 0.0:
        what, do = f"{one.name}: averaging time of the samples missing", "Give clock.averaging, or the gate"
        raise DataError(what, where, do=do, code="no_time")
    if averaging > schedule.dwell * (1.0 + INSIDE):
        what = f"{one.name}: a gate of {averaging:g} s, but the mass dwells for {schedule.dwell:g} s"
        why = "every sample would include a move of the mass"
        raise DataError(what, where, why, "Correct the wrong one", "gate_too_long")
    zero = recording.time_ns[0] - round(0.5 * averaging * SECOND) if one.begin is None else one.begin
    begins = round(float(schedule.start[0]) * SECOND) if one.begin is None else 0
    seconds = (recording.time_ns - zero + begins) / SECOND
    late = (seconds[0] - 0.5 * averaging - schedule.start[0]) / schedule.step
    early = (schedule.stop[-1] - seconds[-1] - 0.5 * averaging) / schedule.step
    worst = max((late, "begins", "after"), (early, "ends", "before"), (-late, "begins", "before"),
                (-early, "ends", "after"))  # fmt: skip
    if worst[0] >= schedule.samples_per_cycle:
        what = (
            f"{one.name}: the record {worst[1]} {worst[0]:.0f} dwells {worst[2]} its schedule of {len(schedule)} dwells"
        )
        why = "record and schedule are not of one run, or one of them was cut"
        do = "Give the schedule of this record, or cut both to the same time"
        raise DataError(what, where, why, do, "length_differs")
    return seconds, averaging


def _means(values: Array, dwell: NDArray[np.int64], n: int) -> Array:
    """Return the mean of each dwell by the samples that are there, NaN where that is less than half of them."""
    inside = dwell >= 0
    used = inside & np.isfinite(values)
    sums = np.bincount(dwell[used], values[used], n)
    count = np.bincount(dwell[used], minlength=n)
    enough = count >= np.maximum(HALF * np.bincount(dwell[inside], minlength=n), 1.0)
    return np.asarray(np.where(enough, sums / np.maximum(count, 1), np.nan))


def run_of_rows(
    schedule: Schedule, reading: Array, tilt: Array | None = None, name: str = "", where: str = "", moved: bool = True
) -> Run:
    """Return a run from a reduced table, a row a dwell in the order of the schedule.

    Raises
    ------
    DataError
        ``length_differs`` if the table does not have a row for each dwell.
    """
    if len(reading) != len(schedule):
        what = f"{len(reading)} rows, but the schedule has {len(schedule)} dwells"
        why = "it is not known which row belongs to which dwell"
        do = "Give a row for each dwell, empty for a missing reading, and the schedule of this run"
        raise DataError(what, where, why, do, "length_differs")
    return Run(name, schedule, reading, tilt, None, moved, where)


def lines_of(table: Table, lines: Lines, file: str, output_unit: str) -> list[Line]:
    """Return the runs of a table that was reduced before, a row each, SI.

    Raises
    ------
    DataError
        If a column is missing, or a required cell is empty or not a number; ``unit_mismatch`` if its unit is not that
        of the sensor's output.
    """
    if not same_dimension(lines.unit, output_unit):
        what = f"responses in {lines.unit}, but the sensor gives {output_unit}"
        raise DataError(
            what, file, do="Correct the unit of the lines, or the chain of the sensor", code="unit_mismatch"
        )
    applied = table.numbers(lines.applied) * factor(lines.applied_unit, "m/s^2")
    scale = factor(lines.unit, output_unit)
    named = {
        "response": lines.response, "noise": lines.noise, "psd_response": lines.psd_response,
        "psd_noise": lines.psd_noise, "scatter": lines.scatter,
    }  # fmt: skip
    columns = {
        what: np.full(len(table), math.nan) if column is None else table.numbers(column) * scale
        for what, column in named.items()
    }
    u = 0.0 if lines.u_applied is None else parse_quantity(lines.u_applied).to("m/s^2", difference=True)
    moved = table.text(lines.moved) if lines.moved else ("yes",) * len(table)
    strokes = [a for a, cell in zip(applied.tolist(), moved, strict=True) if cell.lower() in YES and a > 0.0]
    found = []
    for i, name in enumerate(table.text(lines.run)):
        where = f"{file}:{table.rows[i]}"
        word = moved[i].strip().lower()
        if word not in (*YES, *NO):
            raise DataError(f"column {lines.moved!r}: {moved[i]!r}", where, do="Write yes or no", code="wrong_value")
        is_moved = word in YES
        amplitude = float(applied[i]) if is_moved else (strokes[0] if strokes else math.nan)
        values = {what: float(column[i]) for what, column in columns.items()}
        if not (amplitude > 0.0 and math.isfinite(values["response"]) and values["noise"] > 0.0):
            what = (
                f"applied {amplitude:g} m/s^2, response {values['response']:g}, noise {values['noise']:g} {output_unit}"
            )
            raise DataError(what, where, "a run needs all three, noise and applied above zero", code="missing_value")
        found.append(
            Line(name, amplitude, beside=lines.beside, u_applied=u / amplitude, moved=is_moved, where=where, **values)
        )
    return found
