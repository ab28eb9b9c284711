"""Dwells of recordings of a stepped table.

The dwells are cut where the table says so: by the ``applied`` channel of the recording (commanded rate or
encoder), or by a schedule of times and rates. First and last sample of each dwell are dropped and counted: an
average may reach into the ramp. A dwell with many samples missing, invalid or at the rail is left out.

With ``zero_reference`` the reading at rest, interpolated in time between the dwells at rest before and after, is
subtracted from each dwell of the same recording: drift slower than the rests drops out, and so does the bias.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Origin
from ...core.recording import SECOND, Recording, Times
from ...core.remarks import Remark
from ...core.times import read_instant
from ...core.units import convert
from ...core.unknowns import Unknowns, joined
from ...files.text.table import Table, read_table
from ...signals.segmentation.dwells import Dwell, Tally, tally
from ...signals.time.schedule import dwells_by_reference, dwells_by_windows
from ..protocol import Source
from .entry import RateTableEntry, Schedule
from .fit.earth_input import earth_in_dwells, gathered
from .plan import Plan
from .readings import Cut, Readings, Trace, trace

APPLIED = "applied"


@dataclass(frozen=True, eq=False)
class RateTableRecording:
    """A recording while one axis was turned in steps."""

    recording: Recording  # Channels named by axis [rad/s], and ``applied`` [rad/s] where there is no schedule
    axis: str  # Axis that was turned
    run: str = ""  # Power-up run; empty where not given
    windows: tuple[tuple[int, int], ...] = ()  # Schedule: start and stop of each dwell [ns]
    rates: Array | None = None  # shape (w,): rate in each window [rad/s]
    name: str = ""  # Of the recording, for figures; its file where not given
    file: str = ""  # Its file, as people know it
    # What was taken off its readings before: changes of one dwell, the same in all, by origin
    taken_off: Mapping[Origin, Unknowns] = field(default_factory=dict[Origin, Unknowns])


def readings_from(plan: Plan, turned: Sequence[RateTableRecording]) -> Readings:
    """Return the dwells of the recordings of a test.

    Raises
    ------
    DataError
        If a recording has no dwell, all of its samples are invalid (``no_valid_sample``), or it has no dwell at
        rest and the plan asks for a zero reference (``never_still``).
    """
    if not turned:
        raise DataError("no recordings", code="no_dwells")
    parts = [_of_recording(plan, number, one) for number, one in enumerate(turned)]
    sensors = [name for name in AXES if any(name in part.names for part in parts)]
    runs = [one.run for one in turned]
    earth, sources = gathered([(part.earth, part.sources) for part in parts])
    before = np.cumsum([0, *(len(part.applied) for part in parts)])
    return Readings(
        applied=np.concatenate([part.applied for part in parts]),
        axis=np.concatenate([np.full(len(part.applied), one.axis) for part, one in zip(parts, turned, strict=True)]),
        outputs={s: np.concatenate([part.column(part.means, s) for part in parts]) for s in sensors},
        scatters={s: np.concatenate([part.column(part.scatters, s) for part in parts]) for s in sensors},
        samples=np.concatenate([part.samples for part in parts]),
        run=None if not any(runs) else np.concatenate(
            [np.full(len(part.applied), run) for part, run in zip(parts, runs, strict=True)]
        ),
        recording=np.concatenate([np.full(len(part.applied), part.trace.recording) for part in parts]),
        where=tuple(place for part in parts for place in part.where),
        sensors=tuple(sensors),
        earth=earth,
        earth_sources=sources,
        taken_off=_taken_off(plan, parts, turned),
        remarks=(*(remark for part in parts for remark in part.remarks), _counted(parts)),
        incomplete=np.concatenate([part.incomplete for part in parts]),
        tallies=tuple(part.tally for part in parts),
        files=tuple(one.file for one in turned),
        traces=tuple(part.trace.shifted(int(rows)) for part, rows in zip(parts, before[:-1], strict=True)),
    )  # fmt: skip


def _taken_off(plan: Plan, parts: Sequence[_Part], turned: Sequence[RateTableRecording]) -> dict[Origin, Unknowns]:
    """Return what was taken off each dwell; what is the same in a recording drops out with its reading at rest."""
    if plan.zero_reference:
        return {}
    lengths = [len(part.applied) for part in parts]
    each = [{name: off.over(n) for name, off in one.taken_off.items()} for one, n in zip(turned, lengths, strict=True)]
    return joined(each, lengths)


def _counted(parts: Sequence[_Part]) -> Remark:
    """Say where all samples went: one line for all recordings."""
    samples, used, edges, bad = (
        sum(getattr(part.tally, name) for part in parts) for name in ("samples", "used", "edge_dropped", "missing")
    )
    outliers = sum(part.tally.outliers for part in parts)
    what = (
        f"{len(parts)} recording{'s' * (len(parts) != 1)}, {samples} samples:"
        f" {used} used in {sum(part.dwells for part in parts)} dwells,"
        f" {edges} dropped at their edges, {bad} missing or invalid in them, {outliers} outliers, the rest between them"
    )
    return Remark("dwells", "info", what)


@dataclass(frozen=True, eq=False)
class _Part:
    names: tuple[str, ...]
    applied: Array
    means: Array
    scatters: Array
    samples: Array
    earth: Array
    sources: dict[str, Array]
    where: tuple[str, ...]
    remarks: tuple[Remark, ...]
    dwells: int
    tally: Tally
    trace: Trace

    @property
    def incomplete(self) -> NDArray[np.bool_]:
        """Dwells kept as not read: they stand after the others."""
        return np.arange(len(self.applied)) >= self.dwells

    def column(self, values: Array, sensor: str) -> Array:
        """Return the values of one sensor; NaN where the recording does not have it."""
        return values[:, self.names.index(sensor)] if sensor in self.names else np.full(len(values), np.nan)


def _of_recording(plan: Plan, number: int, one: RateTableRecording) -> _Part:
    recording = replace(one.recording, time_ns=one.recording.stamps)
    one = replace(one, recording=recording)
    there = [name for name in AXES if name in recording.names]
    names = [name for name in there if np.isfinite(recording.channel(name).data).any()]
    signal = recording.array(names)
    place = recording.source.path or f"recording {number + 1}"
    if recording.time_ns is None:
        raise DataError("no time: dwells cannot be placed", place, do="Name the time column in clock", code="no_time")
    if not names or not np.isfinite(signal).all(axis=1).any():
        what = "no sample is valid in all sensors"
        raise DataError(what, place, do="Check the built-in test, the rails and the columns", code="no_valid_sample")
    try:
        cut = _cut(plan, one, signal, recording.time_ns)
    except DataError as error:
        raise DataError([replace(problem, where=place) for problem in error.problems]) from None
    kept, lost, remarks = _complete(plan, cut, _lost(plan, one, signal, cut.dwells), place)
    dwells, applied = kept.dwells, kept.applied
    remarks += [
        Remark("sensor_invalid", "warning", f"{s} sensor: no valid sample", place) for s in there if s not in names
    ]
    means = np.array([dwell.mean for dwell in dwells])
    earth, sources = earth_in_dwells(plan, one.axis, *_angles(one, dwells, applied))
    if plan.zero_reference:
        rest = _rest_weights(dwells, applied, place)
        means, earth = means - rest @ means, earth - rest @ earth
        sources = {name: patterns - np.einsum("ij,sjk->sik", rest, patterns) for name, patterns in sources.items()}
        moving = applied != 0.0
        means, earth, applied = means[moving], earth[moving], applied[moving]
        sources = {name: patterns[:, moving] for name, patterns in sources.items()}
        dwells = [dwell for dwell, turning in zip(dwells, moving, strict=True) if turning]
    else:
        remarks += _no_rest(applied, place)
    count = len(lost.dwells)
    unread = np.full((count, len(names)), np.nan)
    applied = np.concatenate([applied, lost.applied])
    return _Part(
        tuple(names),
        applied,
        np.vstack([means, unread]),
        np.vstack([np.array([dwell.scatter for dwell in dwells]), unread]),
        np.array([float(np.min(dwell.n_effective)) for dwell in dwells] + [np.nan] * count),
        np.vstack([earth, np.zeros((count, 3))]),
        {name: np.concatenate([p, np.zeros((len(p), count, 3))], axis=1) for name, p in sources.items()},
        tuple(f"{place}: dwell {i + 1} ({rate:+.6g} rad/s)" for i, rate in enumerate(applied)),
        (*recording.remarks, *remarks),
        len(dwells),
        tally(dwells, len(recording)),
        trace(one.name or place, one.axis, names, signal, recording.time_ns, kept, lost, plan.zero_reference),
    )


def _cut(plan: Plan, one: RateTableRecording, signal: Array, time_ns: Times) -> Cut:
    if one.rates is not None:
        if not np.isfinite(one.rates).all():
            raise DataError("a rate of the schedule is missing", code="nan_in_required")
        dwells = list(dwells_by_windows(one.windows, signal, time_ns))
        return Cut(dwells, _rounded(one.rates))
    commanded = one.recording.array([APPLIED])[:, 0]
    found = dwells_by_reference(commanded, signal, time_ns, tolerance=plan.applied_tolerance)
    rates = [float(np.ravel(dwell.applied)[0]) for dwell in found if dwell.applied is not None]
    still = [0.0 if abs(rate) <= plan.applied_tolerance else rate for rate in rates]
    return Cut(list(found), _rounded(still))


def _rounded(rates: ArrayLike) -> Array:
    """Return rates to twelve digits, so that the same rate of two dwells is the same number."""
    return np.array([float(f"{rate:.12g}") for rate in np.ravel(np.asarray(rates, dtype=float))])


def _lost(plan: Plan, one: RateTableRecording, signal: Array, dwells: list[Dwell]) -> Cut:
    """Dwells that were commanded where not one sample is valid: no reading is left of them."""
    if one.rates is not None or one.recording.time_ns is None or np.isfinite(signal).all():
        return Cut([], np.zeros(0))
    commanded = one.recording.array([APPLIED])[:, 0]
    every = dwells_by_reference(commanded, commanded, one.recording.time_ns, tolerance=plan.applied_tolerance)
    gone = [d for d in every if not any(d.start < own.stop and own.start < d.stop for own in dwells)]
    rates = _rounded([float(np.ravel(d.applied)[0]) for d in gone if d.applied is not None])
    return Cut(gone, np.where(np.abs(rates) <= plan.applied_tolerance, 0.0, rates))


def _complete(plan: Plan, cut: Cut, gone: Cut, place: str) -> tuple[Cut, Cut, list[Remark]]:
    """Leave out dwells with too many samples missing, invalid or at the rail; their rates are kept as not read."""
    keep = np.array([dwell.missing <= plan.missing * (dwell.missing + dwell.n) for dwell in cut.dwells], dtype=bool)
    short = cut.choose(~keep)
    lost = Cut([*short.dwells, *gone.dwells], np.concatenate([short.applied, gone.applied]))
    if not lost.dwells:
        return cut, lost, []
    rates = ", ".join(f"{rate:+g}" for rate in np.unique(np.degrees(lost.applied).round(9)))
    what = f"more than {plan.missing:.0%} of the samples missing, invalid or at the rail: left out ({rates} deg/s)"
    remark = Remark("dwell_incomplete", "warning", what, place, len(lost.dwells))
    if not keep.any():
        raise DataError("every dwell is missing, invalid or saturated", place, do=what, code="no_valid_sample")
    return cut.choose(keep), lost, [remark]


def _rest_weights(dwells: list[Dwell], applied: Array, place: str) -> Array:
    """Weights of all dwells in the interpolated reading at rest at each dwell, shape (n, n)."""
    rest = np.flatnonzero(applied == 0.0)
    if not len(rest):
        what = "the table is never still: no dwell at rest to refer to"
        raise DataError(what, place, do="Record a dwell at rest, or leave zero_reference out", code="never_still")
    if len(rest) == len(applied):
        raise DataError("the table never turns", place, code="no_dwells")
    middle = np.array([0.5 * (dwell.start + dwell.stop) for dwell in dwells])
    weights = np.zeros((len(dwells), len(dwells)))
    for column, unit in zip(rest, np.eye(len(rest)), strict=True):
        weights[:, column] = np.interp(middle, middle[rest], unit)
    return weights


def _no_rest(applied: Array, place: str) -> list[Remark]:
    if np.any(applied == 0.0):
        return []
    what = "the table is never at rest: the bias relies on symmetric rates"
    return [Remark("never_still", "warning", what, place, do="Record dwells at rest")]


def _angles(one: RateTableRecording, dwells: list[Dwell], applied: Array) -> tuple[Array, Array]:
    """Table angle at the start of each dwell, from the start of the recording, and the angle turned in it [rad].

    NaN for the start where only a schedule is known: what the table did between the dwells is not.
    """
    time_ns = one.recording.time_ns
    assert time_ns is not None  # noqa: S101 - checked before
    interval = one.recording.sample_interval or 0.0
    seconds = (time_ns - time_ns[0]) / SECOND
    spans = np.array([seconds[dwell.stop - 1] - seconds[dwell.start] + interval for dwell in dwells])
    angle = applied * spans
    if one.rates is not None:
        return np.full(len(dwells), np.nan), angle
    rate = np.nan_to_num(one.recording.array([APPLIED])[:, 0])
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(seconds)
    turned = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([turned[d.start] for d in dwells]) - 0.5 * applied * interval, angle


def together(parts: list[Readings]) -> Readings:
    """Return the dwells of several recordings as one test.

    Raises
    ------
    DataError
        If some have runs and others have none.
    """
    if len(parts) == 1:
        return parts[0]
    if len({part.run is None for part in parts}) > 1:
        raise DataError("some recordings of the test name their runs and some do not", do="Give rows.run for all")
    sensors = list(dict.fromkeys(name for part in parts for name in part.outputs))
    before = np.cumsum([0, *(len(part) for part in parts)])
    earth: Array | None = None
    sources: dict[str, Array] = {}
    if all(part.earth is not None for part in parts):
        earth, sources = gathered([(part.earth, dict(part.earth_sources)) for part in parts if part.earth is not None])
    return Readings(
        applied=np.concatenate([part.applied for part in parts]),
        axis=np.concatenate([part.axis for part in parts]),
        outputs={name: _filled([part.outputs.get(name) for part in parts], parts) for name in sensors},
        scatters={name: _filled([part.scatters.get(name) for part in parts], parts) for name in sensors
                  if any(name in part.scatters for part in parts)},
        samples=None if any(part.samples is None for part in parts)
        else np.concatenate([part.samples for part in parts if part.samples is not None]),
        run=None if parts[0].run is None
        else np.concatenate([part.run for part in parts if part.run is not None]),
        recording=None if any(part.recording is None for part in parts)
        else np.concatenate([part.recording for part in parts if part.recording is not None]),
        group=None if all(part.group is None for part in parts)
        else np.concatenate([np.full(len(part), "") if part.group is None else part.group for part in parts]),
        where=tuple(place for part in parts for place in part.where),
        sensors=parts[0].sensors,
        earth=earth,
        earth_sources=sources,
        taken_off=joined([part.taken_off for part in parts], [len(part) for part in parts]),
        remarks=tuple(remark for part in parts for remark in part.remarks),
        incomplete=None if all(part.incomplete is None for part in parts) else np.concatenate(
            [np.zeros(len(part), dtype=bool) if part.incomplete is None else part.incomplete for part in parts]
        ),
        tallies=tuple(one for part in parts for one in part.tallies),
        files=tuple(one for part in parts for one in part.files),
        traces=tuple(
            one.shifted(int(rows)) for part, rows in zip(parts, before[:-1], strict=True) for one in part.traces
        ),
    )  # fmt: skip


def _filled(columns: list[Array | None], parts: list[Readings]) -> Array:
    filled = [np.full(len(part), np.nan) if c is None else c for c, part in zip(columns, parts, strict=True)]
    return np.concatenate(filled)


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
        what = f"recordings.{source.name}: axis that was turned not given"
        raise DataError(what, do='Give axis = "x" there, or plan = { axis = "x" }', code="no_axis")
    if entry.schedule is None:
        if APPLIED not in recording.names:
            do = "Give channels.applied (the rate of the table), or a schedule"
            raise DataError(f"recordings.{source.name}: rate of the table not given", do=do, code="no_applied")
        return RateTableRecording(recording, str(axis), source.run, name=source.name, file=source.file)
    windows, rates = _scheduled(source, entry.schedule, recording)
    windows, remarks = _since_start(windows, recording, entry.schedule.file)
    recording = replace(recording, remarks=(*recording.remarks, *remarks))
    if source.windows:
        inside = [any(a <= start and stop <= b for a, b in source.windows) for start, stop in windows]
        windows, rates = tuple(w for w, use in zip(windows, inside, strict=True) if use), rates[np.array(inside)]
    return RateTableRecording(recording, str(axis), source.run, windows, rates, source.name, source.file)


def _scheduled(
    source: Source, schedule: Schedule, recording: Recording
) -> tuple[tuple[tuple[int, int], ...], np.ndarray]:
    """Windows [ns] and rates [SI] of a schedule."""
    table = source.read_file(schedule.file, read_table)
    if schedule.recording is not None:
        table = _rows_of(table, schedule.recording, source.name)
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


Windows = tuple[tuple[int, int], ...]


def _since_start(windows: Windows, recording: Recording, file: str) -> tuple[Windows, tuple[Remark, ...]]:
    """Return the dwells of a schedule [ns]; in UTC those that can only be counted from the first sample."""
    stamps = recording.stamps
    if recording.epoch != "utc" or stamps is None or not len(stamps) or not windows:
        return windows, ()
    first, lasts = int(stamps[0]), int(stamps[-1]) - int(stamps[0])
    ends = [end for window in windows for end in window]
    if min(ends) < 0 or max(ends) > min(lasts + SECOND, first - 1):
        return windows, ()
    what = f"its dwells, to {max(ends) / SECOND:.6g} s, are counted from the first sample of {recording.source.path}"
    shifted = tuple((first + start, first + stop) for start, stop in windows)
    return shifted, (Remark("since_start", "info", what, file, do="Else write instants: 2026-03-25T08:00:00Z"),)


def _rows_of(table: Table, column: str, name: str) -> Table:
    """Return the rows of one recording of a programme of several."""
    own = [k for k, label in enumerate(table.text(column)) if label == name]
    if not own:
        what = f"column {column!r}: no row is of {name!r}"
        raise DataError(what, table.source.path, do="Name the recording as its rows do", code="no_dwells")
    cells = tuple(tuple(cells[k] for k in own) for cells in table.cells)
    return replace(table, cells=cells, rows=table.rows[own])


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
