"""One file without a campaign file: what `rate-table FILE` and ``inertialcal.rate_table`` do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.axes import AXES
from ...core.errors import DataError, UsageError
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...core.units import parse_quantity, si_unit
from ...files import read
from ...files.info.table_columns import guess
from ...files.text.table import read_table
from ...procedures.display import curve_contents, displayed
from ...procedures.rate_table import reduction as procedure
from ..file.sensors import Chain, Sensor
from .reduced_table import table_columns, table_readings, turned_axis
from .stepped_recording import is_stepped, stepped_columns, stepped_readings

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class RateTableFile:
    """Result of one file.

    Parameters
    ----------
    result : rate_table.Result
        SI.
    rows : tuple of Row
        In the unit of the file.
    columns : dict
        Which column was taken for what.
    sha256 : str
        Of the file.
    unit : str
        Of the readings.
    """

    result: procedure.Result
    rows: tuple[Row, ...]
    columns: dict[str, Any]
    sha256: str
    unit: str

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What the reduction brought up."""
        return self.result.remarks

    def content(self) -> dict[str, Any]:
        """Return the curves as ``results.json`` would hold them, in the unit of the file."""
        return {"curves": curve_contents(self.result.curves(), self.unit)}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: which column was what, the figures in the unit of the file, how many remarks."""
        taken = ", ".join(f"{what} = {name}" for what, name in self.columns.items())
        rows = [row.to_dict() for row in self.rows if not row.case.beside]
        dwells = f"rate table: {len(self.result.readings)} dwells"
        return (f"columns: {taken}", *estimate_table(rows, dwells), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def rate_table(
    path: str | Path,
    *,
    applied: str | None = None,
    reading: str | Mapping[str, str] | None = None,
    axis: str | None = None,
    unit: str | None = None,
    scatter: str | None = None,
    run: str | None = None,
    group: str | None = None,
    scale_factor: str | None = None,
    input_range: str | None = None,
    zero_reference: bool = False,
) -> RateTableFile:
    """Reduce a rate-table test in one file: dwells, a row each, or a recording of a table turned in steps.

    Columns that are not named are taken by their names in the header, where only one can be meant.

    Parameters
    ----------
    path : path
        Any format that ``inertialcal.read`` takes.
    applied, scatter, run, group : str, optional
        Columns.
    reading : str, or mapping of axis to str, optional
        Column or columns of the sensor's reading.
    axis : {"x", "y", "z"}, optional
        Axis that was turned, where no column says it.
    unit : str, optional
        Of applied rate and reading, where the header does not say it.
    scale_factor : str, optional
        Ideal one, ``"0.5 V/(deg/s)"``: the scale factor then comes out in volts too.
    input_range : str, optional
        Largest rate, ``"5 deg/s"``.
    zero_reference : bool
        The reading at rest was subtracted.

    Raises
    ------
    DataError
        If the file cannot be read or cannot carry the answer.
    UsageError
        If it is not clear which column is what, or in which unit.
    """
    file = Path(path)
    if axis is not None and axis not in AXES:
        raise UsageError(f"axis {axis!r}", do=f"There are: {', '.join(AXES)}", code="unknown_name")
    table = read_table(file)
    found = guess(table)
    said = {"applied": applied, "reading": reading, "axis": axis, "unit": unit, "scatter": scatter, "run": run,
            "group": group}  # fmt: skip
    recording = None if scatter or run or group else _recorded(file, applied or found.applied)
    if recording is not None:
        columns = stepped_columns(recording, said | {"applied": applied or found.applied})
    else:
        columns = table_columns(found, table.names, said, file)
    sensor = Sensor(
        kind="gyro",
        axes=["x", "y", "z"],
        unit=_rate_unit(columns["unit"]),
        chain=Chain(kind="none", scale_factor=scale_factor),
    )
    plan = _plan(turned_axis(columns), zero_reference, scale_factor, input_range, sensor)
    if recording is not None:
        readings, sha256 = stepped_readings(file, columns, plan, sensor)
    else:
        readings, sha256 = table_readings(file, columns, sensor)
    result = procedure.reduce(plan, readings)
    shown = tuple(displayed(replace(row, test="rate_table"), sensor.unit) for row in result.rows())
    return RateTableFile(result, shown, columns, sha256, sensor.unit)


def _recorded(file: Path, applied: str | None) -> Recording | None:
    """Return the recording of a stepped table; None where the file is a table of dwells."""
    recording = None if applied is None else read(file)
    return recording if recording is not None and is_stepped(recording, applied) else None


def _plan(axis: str, zero_reference: bool, volts: str | None, largest: str | None, sensor: Sensor) -> procedure.Plan:
    si = si_unit(sensor.unit)
    end = None if largest is None else abs(parse_quantity(largest).to(si))
    return procedure.Plan(
        axis=axis,
        zero_reference=zero_reference,
        input_range=None if end is None else (-end, end),
        scale_factor=None if volts is None else dict.fromkeys(sensor.axes, parse_quantity(volts).to(f"V/({si})")),
    )


def _rate_unit(unit: str) -> str:
    if si_unit(unit) != "rad/s":
        raise UsageError(f"unit {unit!r} is no unit of angular rate", do="Say it: --unit deg/s", code="no_unit")
    return unit


__all__ = ["DataError", "RateTableFile", "rate_table"]
