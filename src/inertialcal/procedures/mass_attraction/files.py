"""A mass-attraction calibration without a campaign file: what ``mass-attraction FILE...`` does, and Python."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.recording import SECOND, Channel, Recording
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...core.times import read_elapsed, read_instant
from ...core.units import convert, kind, parse_quantity, same_dimension
from ...files import read
from ...files.source import load
from ...files.time.plausible import time_remarks
from ..display import displayed, displayed_curve
from . import reduction as procedure
from .plan import Scatter, Tilt
from .recordings import READING, TEMPERATURE, TILT
from .schedule_csv import read_schedule

if TYPE_CHECKING:
    from pandas import DataFrame


TEST = "mass_attraction"
UNIT = "ug"  # that accelerations are told in, where nothing says another one
PULSES = ("count", "count/s")
STAMPS = {"start": -0.5, "middle": 0.0, "end": 0.5}  # of the gate, that the stamp is after its middle
LIKE = {"s": "100 s", "rad": "9.2e-10 rad", "count/s/(m/s^2)": "10.21 count/s/ug"}


@dataclass(frozen=True, eq=False)
class MassAttractionFile:
    """Result of one or more files.

    Parameters
    ----------
    result : mass_attraction.Result
        SI.
    rows : tuple of Row
        In the unit that was asked for.
    inputs : mapping of str to str
        SHA-256 by path, the schedule's too.
    columns : mapping of str to str
        Which channel was taken for what, in the first file.
    unit : str
        Of accelerations.
    remarks : tuple of Remark
        What reading and reducing brought up.
    """

    result: procedure.Result
    rows: tuple[Row, ...]
    inputs: Mapping[str, str]
    columns: Mapping[str, str]
    unit: str
    remarks: tuple[Remark, ...] = ()

    @property
    def responses(self) -> tuple[procedure.Response, ...]:
        """What each run responds, SI."""
        return self.result.responses

    def content(self) -> dict[str, Any]:
        """Return what ``results.json`` would hold of it: rows and curves in the unit that was asked for."""
        curves = [displayed_curve(one, self.unit).to_dict(TEST) for one in self.result.curves()]
        return {"results": [row.to_dict() for row in self.rows], "curves": curves}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: which channel was what, the figures, how many remarks."""
        taken = ", ".join(f"{what} = {name}" for what, name in self.columns.items())
        rows = [row.to_dict() for row in self.rows if not row.case.beside]
        caption = f"mass attraction: {self.result.readings.runs} run(s)"
        return (f"columns: {taken}", *estimate_table(rows, caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def mass_attraction(
    paths: str | Path | Sequence[str | Path],
    schedule: str | Path,
    *,
    null: Sequence[str | Path] = (),
    column: str | None = None,
    tilt: str | None = None,
    tilt_is: Tilt = "regressed",
    mercury: str = "0 rad",
    gate: str | None = None,
    begin: str | None = None,
    stamp: str = "middle",
    nominal: str | None = None,
    high_g: str | None = None,
    u_high_g: str | None = None,
    scatter: Scatter = "between_runs",
    unit: str = UNIT,
    units: Mapping[str, str] | None = None,
    time_column: str | None = None,
) -> MassAttractionFile:
    """Find the scale factor of a pulse-rate accelerometer from records of a moved mass.

    Each file is a run of its own; the schedule starts with its first sample, or at ``begin``. A file without a time has
    a row for each dwell of the schedule, in order.

    Parameters
    ----------
    paths : path or sequence of path
        Runs with the mass moved; any format that ``inertialcal.read`` takes.
    schedule : path
        CSV of the dwells: start, stop, position, applied.
    null : sequence of path
        Runs with the mass at rest.
    column : str, optional
        Of the pulses, or pulses a second; by default the one in such a unit.
    tilt : str, optional
        Column of the tilt meter.
    tilt_is : {"regressed", "known", "ignored"}
        What becomes of the tilt, as ``plan.tilt`` has it.
    mercury : str
        Amplitude by which the mass tilts the mercury of the meter.
    gate : str, optional
        Time over which pulses are counted: ``"100 s"``; needed where the column holds pulses.
    begin : str, optional
        When the schedule starts, on the clock of the file: UTC with a date, or elapsed time; by default with its first
        sample. Of one file: the others have instants of their own.
    stamp : {"start", "middle", "end"}
        What of its gate the stamp of a sample is; counts with ``begin`` alone.
    nominal : str, optional
        Scale factor of the data sheet: ``"10.21 count/s/ug"``.
    high_g, u_high_g : str, optional
        Scale factor at high g that the result is compared with, and its standard uncertainty.
    scatter : {"between_runs", "within_runs"}
        Where the uncertainty of several runs comes from.
    unit : str
        Of accelerations in the result.
    units : mapping of str to str, optional
        As ``inertialcal.read`` takes them: ``{"pulses": "count", "tilt_rad": "rad"}``.
    time_column : str, optional
        Name, or number from 1, of the column with the time.

    Raises
    ------
    DataError
        If a file cannot be read or cannot carry the answer.
    UsageError
        If it is not clear which column is what, or in which unit.
    """
    moved = [Path(one) for one in ([paths] if isinstance(paths, str | Path) else paths)]
    nulls = [Path(one) for one in null]
    _check(moved, nulls, unit, tilt_is, scatter)
    _check_begin(begin, stamp, len(moved) + len(nulls))
    plan = procedure.Plan(
        nominal=None if nominal is None else _above_zero(nominal, "count/s/(m/s^2)", "nominal"),
        tilt=tilt_is if tilt is not None else "ignored",
        mercury=_quantity(mercury, "rad", "mercury"),
        scatter=scatter,
        high_g=_high_g(high_g, u_high_g),
    )
    if plan.tilt == "known" and plan.nominal is None:
        do = 'Say it: --nominal "10.21 count/s/ug", or --tilt-is regressed'
        raise UsageError("a known tilt needs the nominal scale factor", do=do, code="no_nominal")
    window = None if gate is None else _above_zero(gate, "s", "gate")
    plans = read_schedule(schedule)
    files = [(path, True) for path in moved] + [(path, False) for path in nulls]
    whole = [read(path, units=units, time_column=time_column) for path, _ in files]
    taken = [_taken(one, column, tilt) for one in whole]
    runs, found = [], []
    for (path, is_moved), one, named in zip(files, whole, taken, strict=True):
        run, remarks = _run(plan, _in_units(one, named, window), plans, path.stem, is_moved, window, begin, stamp)
        runs.append(run)
        found += [*time_remarks(one), *remarks]
    result = procedure.reduce(plan, procedure.Readings(tuple(runs)))
    rows = tuple(displayed(replace(row, test=TEST), unit) for row in result.rows())
    inputs = {str(path): one.source.sha256 for (path, _), one in zip(files, whole, strict=True)}
    inputs[str(schedule)] = load(schedule).sha256
    return MassAttractionFile(result, rows, inputs, taken[0], unit, gather([*result.remarks, *found]))


def _check(moved: Sequence[Path], nulls: Sequence[Path], unit: str, tilt_is: str, scatter: str) -> None:
    """Refuse no file, a file twice, and words that are none."""
    if not moved:
        raise UsageError("no file", do="Name a record with the mass moved")
    known: set[Path] = set()
    for file in (*moved, *nulls):
        if file.resolve() in known:
            raise UsageError(f"{file}: given twice", why="a copy is no second run", code="duplicate_id")
        known.add(file.resolve())
    if kind(unit) != "acceleration":
        raise UsageError(f"unit {unit!r} is no unit of acceleration", do="ug, g, m/s2, ...", code="wrong_value")
    for what, word, words in (
        ("tilt_is", tilt_is, ("regressed", "known", "ignored")), ("scatter", scatter, ("between_runs", "within_runs")),
    ):  # fmt: skip
        if word not in words:
            raise UsageError(f"{what} {word!r}", do=f"There are: {', '.join(words)}", code="unknown_name")


def _quantity(given: str, unit: str, what: str, difference: bool = False) -> float:
    """Return a setting in a unit; that it needs one is said with the setting and the text given."""
    try:
        return float(parse_quantity(given).to(unit, difference=difference))
    except DataError:
        do = f"Write a number with its unit, like {LIKE[unit]}"
        raise UsageError(f"{what}: {given!r}", do=do, code="no_unit") from None


def _above_zero(given: str, unit: str, what: str) -> float:
    """Return a setting that is above zero."""
    found = _quantity(given, unit, what)
    if not found > 0.0:
        raise UsageError(f"{what}: {given!r}", do=f"It must be above zero, like {LIKE[unit]}", code="wrong_value")
    return found


def _check_begin(begin: str | None, stamp: str, files: int) -> None:
    if stamp not in STAMPS:
        raise UsageError(f"stamp {stamp!r}", do=f"There are: {', '.join(STAMPS)}", code="unknown_name")
    if begin is None and stamp != "middle":
        what = f"stamp {stamp!r}, but the schedule starts with the first sample whatever its stamp is"
        raise UsageError(what, do="Say --begin, or leave --stamp out", code="no_effect")
    if begin is not None and files > 1:
        what = f"one begin of the schedule, and {files} files"
        do = "Reduce each file by itself, or write a campaign: mass = { schedule = ..., begin = ... } of each recording"
        raise UsageError(what, "each run has an instant of its own", do, code="contradiction")


def _high_g(value: str | None, u: str | None) -> procedure.HighG | None:
    if value is None:
        if u is not None:
            raise UsageError("an uncertainty at high g, without the scale factor", do="Say --high-g", code="no_value")
        return None
    wanted = "count/s/(m/s^2)"
    return procedure.HighG(
        _above_zero(value, wanted, "high_g"), 0.0 if u is None else _quantity(u, wanted, "u_high_g", True)
    )


def _taken(recording: Recording, column: str | None, tilt: str | None) -> dict[str, str]:
    """Return the channels of pulses, tilt and temperature, as said or by their units."""
    pulses = [c.name for c in recording.channels if c.unit is not None and _is_pulses(c.unit)]
    chosen = column or (pulses[0] if len(pulses) == 1 else None)
    have = ", ".join(recording.names)
    if chosen is None:
        what = f"{recording.source.path}: no column is clearly that of the pulses; it has {have}"
        raise UsageError(what, do="Say it: --column COLUMN --unit COLUMN=count", code="no_column")
    warm = [c.name for c in recording.channels if c.quantity == TEMPERATURE]
    named = {READING: chosen} | ({} if tilt is None else {TILT: tilt})
    return named | ({TEMPERATURE: warm[0]} if len(warm) == 1 else {})


def _is_pulses(unit: str) -> bool:
    return any(same_dimension(unit, one) for one in PULSES)


def _in_units(recording: Recording, taken: Mapping[str, str], gate: float | None) -> Recording:
    """Return the channels that were taken, as ``mass_attraction`` wants them."""
    made = []
    for what, name in taken.items():
        channel = recording.channel(name)
        data = np.asarray(channel.data, dtype=np.float64)
        if what == READING:
            made.append(Channel(what, _rate(channel, data, gate, recording), "count/s"))
        else:
            wanted = "rad" if what == TILT else "degC"
            if channel.unit is None or kind(channel.unit) != kind(wanted):
                place, own = recording.source.path, channel.unit or "?"
                raise UsageError(
                    f"{place}: {name!r} ({own}) has no unit of {what}", do=f"Say it: --unit {name}={wanted}",
                    code="no_unit",
                )  # fmt: skip
            made.append(Channel(what, convert(data, channel.unit, wanted), wanted))
    averaging = gate or recording.averaging_time
    return replace(recording, channels=tuple(made), averaging_time=averaging)


def _rate(channel: Channel, data: Any, gate: float | None, recording: Recording) -> Any:
    """Return pulses a second."""
    if channel.unit is not None and same_dimension(channel.unit, "count/s"):
        return convert(data, channel.unit, "count/s")
    if channel.unit is None or not same_dimension(channel.unit, "count"):
        what = (
            f"{recording.source.path}: {channel.name!r} ({channel.unit or '?'}) is neither pulses nor pulses a second"
        )
        raise UsageError(what, do=f"Say it: --unit {channel.name}=count", code="no_unit")
    if gate is None:
        what = (
            f"{recording.source.path}: {channel.name!r} holds pulses, and nothing says for how long they were counted"
        )
        raise UsageError(what, do='Say it: --gate "100 s"', code="no_gate")
    return data / gate


def _run(
    plan: procedure.Plan,
    recording: Recording,
    schedule: procedure.Schedule,
    name: str,
    moved: bool,
    gate: float | None,
    begin: str | None,
    stamp: str,
) -> tuple[procedure.Run, tuple[Remark, ...]]:
    """Return a run: by its clock, or a row a dwell."""
    path = recording.source.path
    if recording.time_ns is not None:
        averaging = recording.averaging_time or schedule.dwell
        starts = None if begin is None else _instant(begin, recording) + round(STAMPS[stamp] * averaging * SECOND)
        one = procedure.SourceMassRecording(replace(recording, averaging_time=averaging), schedule, starts, name, moved)
        readings = procedure.readings_from(plan, [one])
        return readings.series[0], readings.remarks
    if begin is not None:
        what = f"{path}: the file has no time for the schedule to begin at"
        raise UsageError(what, do="Name it: --time-column COLUMN; or leave --begin out", code="no_time")
    if gate is not None and not math.isclose(gate, schedule.dwell, rel_tol=0.01):
        what = f"{path}: a gate of {gate:g} s, rows of dwells of {schedule.dwell:g} s"
        raise DataError(what, why="pulses are counted for the gate", do="Mend the one that is wrong",
                        code="gate_disagrees")  # fmt: skip
    tilt = np.asarray(recording.channel(TILT).data) if TILT in recording.names else None
    reading = np.asarray(recording.channel(READING).data)
    return procedure.run_of_rows(schedule, reading, tilt, name, path, moved), recording.remarks


def _instant(begin: str, recording: Recording) -> int:
    """Return when the schedule starts, on the clock of the recording [ns]."""
    try:
        return read_instant(begin) if recording.epoch == "utc" else read_elapsed(begin)
    except ValueError as error:
        clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {recording.source.path} is {clock}"
        raise UsageError(f"begin: {error}", why, code="wrong_time") from None


__all__ = ["MassAttractionFile", "mass_attraction"]
