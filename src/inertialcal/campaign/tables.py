"""A table of reduced readings, as a campaign describes it, to the Readings of the rate table.

Units: the columns stand in ``rows.unit`` (counts and volts go through the sensor's chain with its nominal
reference); applied rates in ``rows.applied_unit``, or that same unit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.times import read_instant
from ..core.units import convert, factor, kind, si_unit
from ..files.text.table import Table, read_table
from ..procedures.rate_table.earth_input import gathered
from ..procedures.rate_table.reduction import Readings
from ..procedures.rate_table.taken_off import joined
from ..sensors.chain.from_counts import convert as convert_counts
from .chains import build_chain, scale_factors
from .schema import Test
from .schema_recordings import Columns, RecordingEntry, Rows
from .schema_sensors import Sensor

Mask = NDArray[np.bool_]


MOST_GROUPS = 12  # that a message lists


@dataclass(frozen=True, eq=False)
class _Source:
    """A table with what the campaign says about it."""

    name: str
    table: Table
    rows: Rows
    sensor: Sensor


def rate_table_readings(
    folder: Path, name: str, entry: RecordingEntry, sensor: Sensor, test: Test
) -> tuple[Readings, Table]:
    """Return the dwells of a reduced table that a test uses, SI.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    name, entry : str, RecordingEntry
        The recording.
    sensor : Sensor
        That was tested.
    test : Test
        Its ``groups`` and ``windows`` choose rows; its ``plan.axis`` is the axis turned where the table has no
        column for it.

    Raises
    ------
    DataError
        If a column is missing or holds what it must not, or no row is left.
    """
    assert entry.rows is not None  # noqa: S101 - the schema sees to it
    source = _Source(name, read_table(folder / entry.file), entry.rows, sensor)
    table, rows = source.table, entry.rows
    applied_unit = rows.applied_unit or (sensor.unit if kind(rows.unit) in {"count", "voltage"} else rows.unit)
    applied = convert(table.numbers(rows.applied), applied_unit, si_unit(applied_unit))
    remarks = [*table.remarks, *table.missing(rows.applied)]
    readings = Readings(
        applied=applied,
        axis=_axis(source, test),
        outputs=_outputs(source, test),
        scatters=_scatters(source, test),
        samples=None if rows.samples is None else table.numbers(rows.samples),
        group=None if rows.group is None else np.array(table.text(rows.group), dtype=str),
        run=None if rows.run is None else np.array(table.text(rows.run), dtype=str),
        where=tuple(f"{entry.file}:{row}" for row in table.rows),
        sensors=tuple(sensor.axes),
        remarks=tuple(remarks),
    )
    return _chosen(source, test, readings), table


def _axis(source: _Source, test: Test) -> NDArray[Any]:
    if source.rows.axis is not None:
        found = np.array(source.table.text(source.rows.axis), dtype=str)
        for i, value in enumerate(found):
            if value not in source.sensor.axes:
                where = source.table.where(i)
                have = ", ".join(source.sensor.axes)
                raise DataError(f"column {source.rows.axis!r}: axis {value!r}", where, do=f"The sensor has: {have}")
        return found
    axis = test.plan.get("axis")
    if not axis:
        what = f"test {test.id!r}: nothing says which axis was turned"
        raise DataError(what, do='Give plan = { axis = "x" }, or rows.axis', code="no_axis")
    return np.full(len(source.table), str(axis))


def _columns(given: Columns | None, source: _Source, test: Test) -> dict[str, str]:
    """Column by sensor axis; a single column belongs to the axis that is turned."""
    if given is None:
        return {}
    if isinstance(given, dict):
        return {str(name): column for name, column in given.items()}
    axis = test.plan.get("axis")
    if axis is None:
        what = f"recordings.{source.name}: one reading column, and the axis turned changes from row to row"
        raise DataError(what, do='Name the columns by sensor: reading = { x = "...", y = "..." }', code="no_axis")
    return {str(axis): given}


def _outputs(source: _Source, test: Test) -> dict[str, Array]:
    found = {}
    for axis, column in _columns(source.rows.reading, source, test).items():
        found[axis] = _in_si(source, axis, source.table.numbers(column))
    return found


def _scatters(source: _Source, test: Test) -> dict[str, Array]:
    """Return standard deviations, SI; as differences they know no reference and no zero."""
    found = {}
    for axis, column in _columns(source.rows.scatter, source, test).items():
        values = source.table.numbers(column)
        if np.any(values < 0.0):
            where = source.table.where(int(np.flatnonzero(values < 0.0)[0]))
            raise DataError(f"column {column!r}: a standard deviation is negative", where)
        found[axis] = values * _scale(source, axis)
    return found


def _in_si(source: _Source, axis: str, values: Array) -> Array:
    """Return readings, SI: counts through the chain, volts over the scale factor."""
    unit, chain = source.rows.unit, source.sensor.chain
    if kind(unit) == "count":
        if chain.reference == "channel":
            what = f"recordings.{source.name}: counts, and the reference voltage is a channel that the table lacks"
            raise DataError(what, source.table.source.path, do="Give readings in volts", code="missing_reference")
        made = convert_counts(build_chain(source.sensor, (axis,)), values[:, None], place=source.table.where)
        return np.asarray(made.readings)[:, 0]
    if kind(unit) == "voltage":
        return values * _scale(source, axis)
    return convert(values, unit, si_unit(unit))


def _scale(source: _Source, axis: str) -> float:
    """SI input units per unit of the table, for differences."""
    unit = source.rows.unit
    if kind(unit) not in {"count", "voltage"}:
        return factor(unit, si_unit(unit))
    volts_per_si = float(scale_factors(source.sensor, (axis,))[0])
    if kind(unit) == "voltage":
        return factor(unit, "V") / volts_per_si
    built = build_chain(source.sensor, (axis,))
    return built.step / float(np.ravel(built.gain)[0]) / volts_per_si


def _chosen(source: _Source, test: Test, readings: Readings) -> Readings:
    """Keep the rows of the test's groups and windows that have a reading; the rest is counted."""
    keep = np.isfinite(readings.applied)
    absent: list[Remark] = []
    if test.groups is not None:
        absent = _without_rows(source, test, _group(source, readings))
        keep &= np.isin(_group(source, readings), test.groups)
    if test.windows is not None:
        keep &= _in_windows(source, test)
    if not keep.any():
        what = f"test {test.id!r}: no row of {source.table.source.path} is in its groups and windows"
        raise DataError(what, code="nothing_left")
    chosen = readings.take(keep)
    remarks = [*chosen.remarks, *absent]
    for axis, values in chosen.outputs.items():
        missing = ~np.isfinite(values)
        if missing.any():
            first = chosen.where[int(np.flatnonzero(missing)[0])]
            what = f"{axis} sensor: empty cells, taken as not read"
            remarks.append(Remark("empty_cells", "info", what, first, int(missing.sum())))
    return replace(chosen, remarks=tuple(remarks))


def _without_rows(source: _Source, test: Test, group: NDArray[Any]) -> list[Remark]:
    """Name groups of the test that no row is in: an error where the test has no other table, else a remark.

    Raises
    ------
    DataError
        ``unknown_name``.
    """
    there = list(dict.fromkeys(str(one) for one in group))
    absent = [one for one in test.groups or [] if one not in there]
    if not absent:
        return []
    names, have = ", ".join(repr(one) for one in absent), ", ".join(repr(one) for one in there[:MOST_GROUPS])
    what = f"no row of {source.name!r} is in group {names} of test {test.id!r}"
    if len(test.recordings) == 1:
        why = "the test would use less than it says"
        raise DataError(what, str(source.table.source.path), why, f"There are: {have}", "unknown_name")
    return [Remark("group_absent", "warning", what, do=f"There are: {have}")]


def _group(source: _Source, readings: Readings) -> NDArray[Any]:
    if readings.group is None:
        what = f"recordings.{source.name}: groups are asked for, but rows.group names no column"
        raise DataError(what, code="wrong_column")
    return readings.group


def _in_windows(source: _Source, test: Test) -> Mask:
    if source.rows.time is None:
        what = f"recordings.{source.name}: windows are asked for, but rows.time names no column"
        raise DataError(what, code="wrong_column")
    instants = _instants(source, source.rows.time)
    inside = np.zeros(len(instants), dtype=bool)
    for start, stop in test.windows or []:
        inside |= (instants >= start) & (instants < stop)
    return inside


def _instants(source: _Source, column: str) -> NDArray[np.int64]:
    """UTC nanoseconds of each row."""
    found = np.empty(len(source.table), dtype=np.int64)
    for i, cell in enumerate(source.table.text(column)):
        try:
            found[i] = read_instant(_number_or_text(cell))
        except ValueError as error:
            raise DataError(f"column {column!r}: {error}", source.table.where(i), code="wrong_time") from None
    return found


def _number_or_text(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def together(parts: list[Readings]) -> Readings:
    """Return the dwells of several recordings as one test.

    Raises
    ------
    DataError
        If one has runs and another has none: they could not be told apart.
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
        outputs={name: _joined([part.outputs.get(name) for part in parts], parts) for name in sensors},
        scatters={name: _joined([part.scatters.get(name) for part in parts], parts) for name in sensors
                  if any(name in part.scatters for part in parts)},
        samples=None if any(part.samples is None for part in parts)
        else np.concatenate([part.samples for part in parts if part.samples is not None]),
        run=None if parts[0].run is None
        else np.concatenate([part.run for part in parts if part.run is not None]),
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
        traces=tuple(
            one.shifted(int(rows)) for part, rows in zip(parts, before[:-1], strict=True) for one in part.traces
        ),
    )  # fmt: skip


def _joined(columns: list[Array | None], parts: list[Readings]) -> Array:
    filled = [np.full(len(part), np.nan) if c is None else c for c, part in zip(columns, parts, strict=True)]
    return np.concatenate(filled)
