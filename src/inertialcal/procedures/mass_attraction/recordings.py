"""Readings of a moved-mass campaign: recordings on a clock, cut into the dwells of their schedule.

A sample is the mean over its averaging time (a gate, for pulses); it belongs to a dwell if all of it lies there. What
lies in a move is left out and counted. A dwell without a sample is a gap, and so is one whose readings are errors:
nothing is closed up, since that would shift the phase of the drive.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...physics.motion.schedule import Schedule
from .plan import Plan
from .readings import Readings, Run

READING, TILT, TEMPERATURE = "reading", "tilt", "temperature"
INSIDE = 0.02  # of a dwell, by which a sample may reach beyond it: clocks of logger and mover
HALF = 0.5
SAME = 0.01  # relative difference of gate and dwell that rounding explains


@dataclass(frozen=True, eq=False)
class SourceMassRecording:
    """A recording with the schedule of its mass.

    Parameters
    ----------
    recording : Recording
        ``reading`` [count/s], ``tilt`` [rad] and ``temperature`` [degC] as far as they are there; stamps in the middle
        of each average, with averaging time.
    schedule : Schedule
        Of the mass.
    begin : int or None
        When the schedule starts, on the clock of the recording [ns]; None: with its first sample.
    name : str
        Of the run.
    moved : bool
        Whether the mass was moved.
    """

    recording: Recording
    schedule: Schedule
    begin: int | None = None
    name: str = ""
    moved: bool = True


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
        ``no_time`` if a recording has no clock or no averaging time, ``gate_too_long``, ``length_differs`` if record
        and schedule do not span the same time.
    """
    runs, remarks = [], []
    for one in moved:
        run, found = _run(one)
        runs.append(run)
        remarks += found
    return Readings(tuple(runs), (), tuple(remarks))


def _run(one: SourceMassRecording) -> tuple[Run, list[Remark]]:
    where = one.recording.source.path or one.name
    if one.recording.time_ns is None:
        return _run_of_rows(one, where), list(one.recording.remarks)
    seconds, averaging = _clock(one, where)
    _check_ends(one, seconds, averaging, where)
    dwell = _dwell_of(one.schedule, seconds, averaging)
    outside = int(np.sum(dwell < 0))
    remarks = list(one.recording.remarks)
    if outside > 1 and outside > HALF * len(dwell):
        what = f"{one.name}: {outside} of {len(dwell)} samples lie in no dwell of the schedule"
        do = "Look at begin, at the clock, and at dwell and move of the schedule"
        raise DataError(what, where, "their times do not fit", do, "schedule_differs")
    if outside:
        what = f"{one.name}: samples that reach into a move of the mass, or beyond the schedule, are left out"
        remarks.append(Remark("outside_dwells", "info", what, where, outside))
    n = len(one.schedule)
    means = {
        name: _means(np.asarray(one.recording.channel(name).data, dtype=np.float64), dwell, n)
        for name in (READING, TILT, TEMPERATURE)
        if name in one.recording.names
    }
    run = Run(
        one.name, one.schedule, means[READING], means.get(TILT), means.get(TEMPERATURE), one.moved, where
    )  # fmt: skip
    return run, remarks


def _run_of_rows(one: SourceMassRecording, where: str) -> Run:
    """Return a run whose record has no time: a row a dwell."""
    gate, dwell = one.recording.averaging_time, one.schedule.dwell
    if one.begin is not None:
        what, do = "the file has no time for the schedule to begin at", "Name the time column, or leave begin out"
        raise DataError(what, where, do=do, code="no_time")
    if gate is not None and abs(gate / dwell - 1.0) > SAME:
        what, why = f"a gate of {gate:g} s, rows of dwells of {dwell:g} s", "pulses are counted for the gate"
        raise DataError(what, where, why, "Correct the wrong one", "gate_disagrees")
    columns = [
        np.asarray(one.recording.channel(name).data, dtype=np.float64) if name in one.recording.names else None
        for name in (READING, TILT)
    ]
    assert columns[0] is not None  # noqa: S101 - each has a reading
    return run_of_rows(one.schedule, columns[0], columns[1], one.name, where, one.moved)


def _clock(one: SourceMassRecording, where: str) -> tuple[Array, float]:
    """Return middles of the samples since the schedule's zero [s], and the averaging time [s]."""
    recording = one.recording
    averaging = recording.averaging_time
    if recording.time_ns is None or averaging is None or not averaging > 0.0:
        what = f"{one.name}: no clock, or nothing says what a sample is the mean of"
        raise DataError(what, where, do="Give clock.column and clock.averaging, or the gate", code="no_time")
    if averaging > one.schedule.dwell * (1.0 + INSIDE):
        what = f"{one.name}: a gate of {averaging:g} s, but the mass dwells for {one.schedule.dwell:g} s"
        why = "every sample would have a move of the mass in it"
        raise DataError(what, where, why, "Mend the one that is wrong", "gate_too_long")
    zero = recording.time_ns[0] - round(0.5 * averaging * SECOND) if one.begin is None else one.begin
    begins = round(float(one.schedule.start[0]) * SECOND) if one.begin is None else 0
    return (recording.time_ns - zero + begins) / SECOND, averaging


def _check_ends(one: SourceMassRecording, seconds: Array, averaging: float, where: str) -> None:
    """Refuse a record that does not span its schedule, or a schedule that ends while the record goes on."""
    schedule = one.schedule
    late = (seconds[0] - 0.5 * averaging - schedule.start[0]) / schedule.step
    early = (schedule.stop[-1] - seconds[-1] - 0.5 * averaging) / schedule.step
    cycle = schedule.samples_per_cycle
    worst = max((late, "begins", "after"), (early, "ends", "before"), (-late, "begins", "before"),
                (-early, "ends", "after"))  # fmt: skip
    if worst[0] >= cycle:
        what = (
            f"{one.name}: the record {worst[1]} {worst[0]:.0f} dwells {worst[2]} its schedule of {len(schedule)}"
            f" dwells does"
        )
        why = "record and schedule are not of one run, or one of them was cut"
        raise DataError(what, where, why, "Give the schedule of this record, or cut both to one time", "length_differs")


def _dwell_of(schedule: Schedule, seconds: Array, averaging: float) -> NDArray[np.int64]:
    """Return the dwell that each sample lies in; -1 where it reaches beyond."""
    slack = INSIDE * schedule.dwell
    at = np.searchsorted(schedule.start - slack, seconds - 0.5 * averaging, side="right") - 1
    inside = (at >= 0) & (seconds + 0.5 * averaging <= schedule.stop[np.maximum(at, 0)] + slack)
    return np.where(inside, at, -1)


def _means(values: Array, dwell: NDArray[np.int64], n: int) -> Array:
    """Return the mean of each dwell, NaN where it has none; a dwell with an error reading has none."""
    used = dwell >= 0
    sums = np.bincount(dwell[used], values[used], n)
    count = np.bincount(dwell[used], minlength=n)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(sums / count)


def run_of_rows(
    schedule: Schedule, reading: Array, tilt: Array | None = None, name: str = "", where: str = "", moved: bool = True
) -> Run:
    """Return a run from a reduced table, a row a dwell in the order of the schedule.

    Raises
    ------
    DataError
        ``length_differs`` if the table has not a row for each dwell.
    """
    if len(reading) != len(schedule):
        what = f"{len(reading)} rows, but the schedule has {len(schedule)} dwells"
        do = "Give a row for each dwell, empty where there is no reading, and the schedule of this run"
        raise DataError(what, where, "which row belongs to which dwell is not known", do, "length_differs")
    return Run(name, schedule, reading, tilt, None, moved, where)
