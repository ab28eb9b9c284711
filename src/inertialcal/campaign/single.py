"""One table without a campaign file: what `rate-table FILE` and ``inertialcal.rate_table`` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..core.errors import DataError, UsageError
from ..core.frames import frame
from ..core.remarks import Remark
from ..core.results import Row
from ..core.units import normalise, parse_quantity, si_unit
from ..files.table import read_table
from ..procedures import rate_table as procedure
from ..procedures.rate_table.plan import AXES
from .display import displayed
from .schema import Chain, RecordingEntry, Rows, Sensor, Test
from .table_columns import Guess, guess
from .tables import rate_table_readings


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

    def to_frame(self) -> Any:
        """Return a pandas DataFrame, a row a figure."""
        rows = [row.to_dict() for row in self.rows]
        return frame({name: [row[name] for row in rows] for name in rows[0]})

    def __str__(self) -> str:
        """Return the estimate as a table."""
        return str(self.result)


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
    """Reduce a table of rate-table dwells, a row a dwell.

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
    read = read_table(file)
    found, table_names = guess(read), read.names
    if axis is not None and axis not in AXES:
        raise UsageError(f"axis {axis!r}", do=f"There are: {', '.join(AXES)}", code="unknown_name")
    if axis is not None and found.axis is not None:
        what = f"{file}: column {found.axis!r} says which axis was turned, and --axis says {axis}"
        raise UsageError(what, do="Leave --axis out", code="wrong_value")
    chosen = _columns(found, table_names, applied, reading, axis, file)
    spoken = unit or found.unit
    if spoken is None:
        raise UsageError(
            f"{file}: nothing says the unit of rate and reading", do="Say it: --unit deg/s", code="no_unit"
        )
    rows = Rows(
        applied=chosen["applied"],
        reading=chosen["reading"],
        unit=normalise(spoken),
        scatter=scatter or (found.scatter if isinstance(chosen["reading"], str) else None),
        run=run or found.run,
        group=group or found.group,
        samples=found.samples,
        axis=None if axis else found.axis,
    )
    sensor = Sensor(
        kind="gyro",
        axes=["x", "y", "z"],
        unit=_rate_unit(normalise(spoken)),
        chain=Chain(kind="none", scale_factor=scale_factor),
    )
    entry = RecordingEntry(sensor="sensor", file=file.name, rows=rows)
    turned = {"axis": chosen["axis"]} if chosen["axis"] else {}
    test = Test(id="rate_table", procedure="rate_table", recordings=["file"], plan=turned)
    readings, table = rate_table_readings(file.parent, "file", entry, sensor, test)
    result = procedure.reduce(_plan(chosen["axis"], zero_reference, scale_factor, input_range, sensor), readings)
    columns = {name: value for name, value in rows.model_dump().items() if value is not None} | turned
    shown = tuple(displayed(replace(row, test="rate_table"), sensor.unit) for row in result.rows())
    return RateTableFile(result, shown, columns, table.source.sha256, sensor.unit)


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


def _columns(
    found: Guess,
    names: Sequence[str],
    applied: str | None,
    reading: str | Mapping[str, str] | None,
    axis: str | None,
    file: Path,
) -> dict[str, Any]:
    if applied is None and found.applied is None:
        raise UsageError(
            f"{file}: no column is clearly the applied rate", do="Say it: --applied COLUMN", code="no_column"
        )
    if reading is None and len(found.readings) != 1 and not found.by_axis:
        have = f" ({', '.join(found.readings)})" if found.readings else ""
        have = have or f"; it has {', '.join(names)}"
        what = f"{file}: {len(found.readings)} columns can be the reading{have}"
        raise UsageError(what, do="Say it: --reading COLUMN", code="no_column")
    by_axis = dict(found.by_axis) if len(found.by_axis) > 1 else None
    chosen: Any = reading or by_axis or found.readings[0]
    turned = axis or (None if found.axis else _only_axis(found, chosen))
    if turned is None and found.axis is None:
        raise UsageError(f"{file}: nothing says which axis was turned", do="Say it: --axis x", code="no_axis")
    return {"applied": applied or found.applied, "reading": chosen, "axis": turned or ""}


def _only_axis(found: Guess, chosen: Any) -> str | None:
    axes = [axis for axis, name in found.by_axis.items() if name == chosen]
    return axes[0] if len(axes) == 1 else None


__all__ = ["DataError", "RateTableFile", "rate_table"]
