"""A thermal test without a campaign file: what ``thermal FILE...`` and ``inertialcal.thermal`` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ...core.axes import AXES
from ...core.errors import DataError, UsageError
from ...core.recording import Channel, Recording
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...core.units import convert, kind, parse_quantity
from ...files import read
from ...files.time.plausible import time_remarks
from ..display import curve_contents, displayed
from . import reduction as procedure
from .recordings import TEMPERATURE, ThermalRecording, readings_from

if TYPE_CHECKING:
    from pandas import DataFrame


KINDS = {"gyro": ("angular_rate", "rad/s"), "acc": ("acceleration", "m/s^2")}
UNITS = {"gyro": "deg/s", "acc": "m/s2"}
Sensor = Literal["gyro", "acc"]


@dataclass(frozen=True, eq=False)
class ThermalFile:
    """Result of one or more files.

    Parameters
    ----------
    result : thermal.Result
        SI.
    rows : tuple of Row
        In the unit of the files.
    inputs : mapping of str to str
        SHA-256 by path.
    columns : mapping of str to str
        Which channel was taken for what, in the first file.
    unit : str
        Of the readings.
    remarks : tuple of Remark
        What reading and reducing brought up.
    """

    result: procedure.Result
    rows: tuple[Row, ...]
    inputs: Mapping[str, str]
    columns: Mapping[str, str]
    unit: str
    remarks: tuple[Remark, ...] = ()
    sensor: Sensor = field(default="gyro")

    def content(self) -> dict[str, Any]:
        """Return rows and curves as ``results.json`` would hold them, in the unit of the files."""
        curves = curve_contents(self.result.curves(), self.unit, "thermal")
        return {"curves": curves, "results": [row.to_dict() for row in self.rows]}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: which channel was what, the figures in the unit of the files, how many remarks."""
        taken = ", ".join(f"{what} = {name}" for what, name in self.columns.items())
        rows = [row.to_dict() for row in self.rows if not row.case.beside]
        caption = f"thermal: {len(self.inputs)} recording(s)"
        return (f"columns: {taken}", *estimate_table(rows, caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def thermal(
    paths: str | Path | Sequence[str | Path],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    sensor: Sensor | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    at: Sequence[str] = (),
    reference_temperature: str = "20 degC",
    order: int | None = None,
    warm_up: str | None = None,
    one_run: bool = False,
    start: str | None = None,
    stop: str | None = None,
) -> ThermalFile:
    """Find the bias over temperature from recordings of a unit at rest while its temperature changed.

    Each file is taken for a power-up of its own.

    Parameters
    ----------
    paths : path or sequence of path
        Any format that ``inertialcal.read`` takes.
    columns : mapping of str to str, optional
        Channels by what they are: ``x``, ``y``, ``z``, ``temperature``, or ``temperature_x``, ... for a thermometer
        of each sensor; by default they are told by their names.
    units : mapping of str to str, optional
        As ``inertialcal.read`` takes them: ``{"gyro": "deg/s", "temperature": "degC"}``.
    sensor : {"gyro", "acc"}, optional
        Which sensors are reduced; by default gyros, accelerometers where there is no gyro.
    sample_rate, time_column, start, stop
        As ``inertialcal.read`` takes them.
    at : sequence of str
        Temperatures at which the bias is told too, ``"-20 degC"``.
    reference_temperature : str
        Powers are those of the temperature less this.
    order : int, optional
        Of the polynomial; by default chosen on what is held out.
    warm_up : str, optional
        Left out after each power-up, ``"300 s"``; by default found.
    one_run : bool
        All files are of one power-up.

    Raises
    ------
    DataError
        If a file cannot be read or cannot carry the answer.
    UsageError
        If it is not clear which channel is what, or in which unit.
    """
    files = [Path(one) for one in ([paths] if isinstance(paths, str | Path) else paths)]
    _check_once(files)
    if sensor is not None and sensor not in KINDS:
        raise UsageError(f"sensor {sensor!r}", do=f"There are: {', '.join(KINDS)}", code="unknown_name")
    plan = procedure.Plan(
        order=_order(order),
        at=[_quantity(one, "degC", "at") for one in at],
        reference_temperature=_quantity(reference_temperature, "degC", "reference_temperature"),
        warm_up=None if warm_up is None else _quantity(warm_up, "s", "warm_up"),
        run_level="power_up",
    )
    recordings = [
        read(file, units=units, sample_rate=sample_rate, time_column=time_column, start=start, stop=stop)
        for file in files
    ]
    chosen: Sensor = sensor or _sensor_of(recordings[0], columns)
    taken = [_taken(one, columns, chosen) for one in recordings]
    label = "1" if one_run else ""
    warmed = [ThermalRecording(_in_si(one, found, chosen), label) for one, found in zip(recordings, taken, strict=True)]
    result = procedure.reduce(plan, readings_from(warmed, KINDS[chosen][1]))
    unit = _unit(recordings[0].channel(next(iter(taken[0].values()))))
    rows = tuple(displayed(replace(row, test="thermal"), unit) for row in result.rows())
    remarks = gather([*result.remarks, *(remark for one in recordings for remark in time_remarks(one))])
    inputs = {str(file): one.source.sha256 for file, one in zip(files, recordings, strict=True)}
    return ThermalFile(result, rows, inputs, taken[0], unit, remarks, chosen)


def _check_once(files: Sequence[Path]) -> None:
    """Refuse a file that is given twice."""
    known: set[Path] = set()
    for file in files:
        if file.resolve() in known:
            raise UsageError(f"{file}: given twice", why="a copy is no second run", code="duplicate_id")
        known.add(file.resolve())
    if not files:
        raise UsageError("no file", do="Name a recording")


def _order(order: int | None) -> int | None:
    if order is not None and not 0 <= order <= procedure.LARGEST_ORDER:
        raise UsageError(f"order {order}: need 0 to {procedure.LARGEST_ORDER}", code="wrong_value")
    return order


def _quantity(given: str, unit: str, what: str) -> float:
    """Return a setting in a unit; that it needs one is said with the setting and the text given."""
    try:
        return float(parse_quantity(given).to(unit))
    except DataError:
        like = {"degC": "20 degC", "s": "300 s"}[unit]
        raise UsageError(
            f"{what}: {given!r}", do=f"Write a number with its unit, like {like}", code="no_unit"
        ) from None


def _sensor_of(recording: Recording, columns: Mapping[str, str] | None) -> Sensor:
    """Return which sensors a recording is of: gyros where there are any."""
    for axis, name in (columns or {}).items():
        unit = recording.channel(name).unit if axis in AXES else None
        if unit is not None:
            return "acc" if kind(unit) == "acceleration" else "gyro"
    there = {channel.quantity for channel in recording.channels if channel.axis in AXES}
    return "acc" if "acc" in there and "gyro" not in there else "gyro"


def _taken(recording: Recording, columns: Mapping[str, str] | None, sensor: Sensor) -> dict[str, str]:
    """Return the channel of each axis and of the temperature, as said or by their names.

    Raises
    ------
    UsageError
        If that is not clear, or a unit is missing.
    """
    said = dict(columns or {})
    wrong = [what for what in said if what not in {*AXES, TEMPERATURE, *(f"{TEMPERATURE}_{axis}" for axis in AXES)}]
    if wrong:
        do = "There are: x, y, z, temperature, temperature_x, ..."
        raise UsageError(f"column {wrong[0]!r}", do=do, code="unknown_name")
    axes = {axis: said[axis] for axis in AXES if axis in said} or _axes(recording, sensor)
    warm = {what: name for what, name in said.items() if what not in AXES} or _temperatures(recording)
    path = recording.source.path
    have = ", ".join(recording.names)
    if not axes:
        what = f"{path}: no channel is clearly a sensor's axis; it has {have}"
        raise UsageError(what, do="Say it: --column x=COLUMN --column y=COLUMN", code="no_column")
    if not warm:
        what = f"{path}: no channel is clearly the temperature; it has {have}"
        raise UsageError(what, do="Say it: --column temperature=COLUMN", code="no_column")
    _check_units(recording, axes, warm, sensor)
    return axes | warm


def _axes(recording: Recording, sensor: Sensor) -> dict[str, str]:
    found = [c for c in recording.channels if c.axis in AXES and c.quantity in (sensor, "")]
    named = {c.axis: c.name for c in found}
    return named if len(named) == len(found) else {}


def _temperatures(recording: Recording) -> dict[str, str]:
    """Return the one temperature, or that of each axis."""
    found = [c for c in recording.channels if c.quantity == TEMPERATURE]
    if len(found) == 1:
        return {TEMPERATURE: found[0].name}
    by_axis = {f"{TEMPERATURE}_{c.axis}": c.name for c in found if c.axis in AXES}
    return by_axis if len(by_axis) == len(found) else {}


def _check_units(recording: Recording, axes: Mapping[str, str], warm: Mapping[str, str], sensor: Sensor) -> None:
    """Refuse readings and temperatures without a unit of their kind: all that is missing at once."""
    lacks = {
        f"{sensor}={UNITS[sensor]}": [n for n in axes.values() if not _is(recording.channel(n), KINDS[sensor][0])],
        f"{TEMPERATURE}=degC": [name for name in warm.values() if not _is(recording.channel(name), TEMPERATURE)],
    }
    missing = {option: names for option, names in lacks.items() if names}
    if missing:
        lacking = [recording.channel(name) for every in missing.values() for name in every]
        names = ", ".join(f"{channel.name!r} ({channel.unit or '?'})" for channel in lacking)
        counted = any(channel.unit == "count" for channel in lacking)
        why = "counts and volts need the chain of a campaign file" if counted else ""
        do = f"Say it: {' '.join(f'--unit {option}' for option in missing)}"
        raise UsageError(f"{recording.source.path}: no unit of their kind: {names}", "", why, do, "no_unit")


def _is(channel: Channel, wanted: str) -> bool:
    return channel.unit is not None and kind(channel.unit) == wanted


def _unit(channel: Channel) -> str:
    return channel.unit or ""


def _in_si(recording: Recording, taken: Mapping[str, str], sensor: Sensor) -> Recording:
    """Return the channels that were taken, named by what they are, in SI and degC."""
    made = []
    for what, name in taken.items():
        channel = recording.channel(name)
        unit = "degC" if what not in AXES else KINDS[sensor][1]
        data = convert(np.asarray(channel.data, dtype=np.float64), channel.unit or unit, unit)
        made.append(replace(channel, name=what, data=data, unit=unit))
    return replace(recording, channels=tuple(made))


__all__ = ["ThermalFile", "thermal"]
