"""A table of reduced readings, as the Readings of a rate table.

Units: the columns stand in ``rows.unit`` (counts and volts go through the sensor's chain with its nominal
reference); applied rates in ``rows.applied_unit``, or that same unit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.times import read_instant
from ...core.units import convert, kind, si_unit
from ...files.text.table import Table
from ..protocol import Source
from .entry import Columns, RateTableEntry, Rows
from .plan import Plan
from .readings import Places, Readings

Mask = NDArray[np.bool_]


MOST_GROUPS = 12  # that a message lists


@dataclass(frozen=True, eq=False)
class _Table:
    """A table with what is said about it."""

    source: Source
    table: Table
    rows: Rows
    plan: Plan

    @property
    def name(self) -> str:
        """As the campaign calls it."""
        return self.source.name


def readings_of_table(plan: Plan, given: Source) -> Readings:
    """Return the dwells of a reduced table that a test uses, SI.

    Raises
    ------
    DataError
        If a column is missing or holds what it must not, or no row is left.
    """
    table, rows = given.table(), cast("RateTableEntry", given.entry).rows
    assert rows is not None  # noqa: S101 - as the file was checked
    source = _Table(given, table, rows, plan)
    applied_unit = rows.applied_unit or (given.facts.unit if kind(rows.unit) in {"count", "voltage"} else rows.unit)
    applied = convert(table.numbers(rows.applied), applied_unit, si_unit(applied_unit))
    remarks = [*table.remarks, *table.missing(rows.applied)]
    file = given.file
    readings = Readings(
        applied=applied,
        axis=_axis(source),
        outputs=_outputs(source),
        scatters=_scatters(source),
        samples=None if rows.samples is None else table.numbers(rows.samples),
        group=None if rows.group is None else table.labels(rows.group),
        run=None if rows.run is None else table.labels(rows.run),
        recording=np.full(len(table), given.name),
        where=Places(file, table.rows),
        sensors=tuple(given.facts.axes),
        remarks=tuple(remarks),
    )
    chosen = _chosen(source, readings)
    given.chose(len(chosen), int(np.count_nonzero(~np.isfinite(table.numbers(rows.applied)))))
    return chosen


def _axis(source: _Table) -> NDArray[Any]:
    if source.rows.axis is not None:
        found, axes = source.table.labels(source.rows.axis), source.source.facts.axes
        if not {*found.tolist()} <= {*axes}:
            at = int(np.flatnonzero(~np.isin(found, axes))[0])
            what, have = f"column {source.rows.axis!r}: axis {found[at]!r}", ", ".join(axes)
            raise DataError(what, source.table.where(at), do=f"The sensor has: {have}")
        return found
    axis = source.plan.axis or None
    if not axis:
        what = f"test {source.source.test!r}: axis that was turned not given"
        raise DataError(what, do='Give plan = { axis = "x" }, or rows.axis', code="no_axis")
    return np.full(len(source.table), str(axis))


def _columns(given: Columns | None, source: _Table) -> dict[str, str]:
    """Column by sensor axis; a single column belongs to the axis that is turned."""
    if given is None:
        return {}
    if isinstance(given, dict):
        return {str(name): column for name, column in given.items()}
    axis = source.plan.axis or None
    if axis is None:
        what = f"recordings.{source.name}: one reading column, and the axis turned changes from row to row"
        raise DataError(what, do='Name the columns by sensor: reading = { x = "...", y = "..." }', code="no_axis")
    return {str(axis): given}


def _outputs(source: _Table) -> dict[str, Array]:
    found = {}
    for axis, column in _columns(source.rows.reading, source).items():
        found[axis] = source.source.in_si(source.table.numbers(column), source.rows.unit, axis)
    return found


def _scatters(source: _Table) -> dict[str, Array]:
    """Return standard deviations, SI; as differences they know no reference and no zero."""
    found = {}
    for axis, column in _columns(source.rows.scatter, source).items():
        values = source.table.numbers(column)
        if np.any(values < 0.0):
            where = source.table.where(int(np.flatnonzero(values < 0.0)[0]))
            raise DataError(f"column {column!r}: a standard deviation is negative", where)
        found[axis] = values * source.source.factor(source.rows.unit, axis)
    return found


def _chosen(source: _Table, readings: Readings) -> Readings:
    """Keep the rows of the test's groups and windows that have a reading; the rest is counted."""
    keep = np.isfinite(readings.applied)
    absent: list[Remark] = []
    if source.source.groups is not None:
        absent = _without_rows(source, _group(source, readings))
        keep &= np.isin(_group(source, readings), source.source.groups)
    if source.source.windows is not None:
        keep &= _in_windows(source)
    if not keep.any():
        what = f"test {source.source.test!r}: no row of {source.table.source.path} is in its groups and windows"
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


def _without_rows(source: _Table, group: NDArray[Any]) -> list[Remark]:
    """Name groups of the test that no row is in: an error where the test has no other table, else a remark.

    Raises
    ------
    DataError
        ``unknown_name``.
    """
    there = list(dict.fromkeys(str(one) for one in group))
    absent = [one for one in source.source.groups or [] if one not in there]
    if not absent:
        return []
    names, have = ", ".join(repr(one) for one in absent), ", ".join(repr(one) for one in there[:MOST_GROUPS])
    what = f"no row of {source.name!r} is in group {names} of test {source.source.test!r}"
    if source.source.alone:
        why = "the test would use less than it says"
        raise DataError(what, str(source.table.source.path), why, f"There are: {have}", "unknown_name")
    return [Remark("group_absent", "warning", what, do=f"There are: {have}")]


def _group(source: _Table, readings: Readings) -> NDArray[Any]:
    if readings.group is None:
        what = f"recordings.{source.name}: groups are asked for, but rows.group names no column"
        raise DataError(what, code="wrong_column")
    return readings.group


def _in_windows(source: _Table) -> Mask:
    if source.rows.time is None:
        what = f"recordings.{source.name}: windows are asked for, but rows.time names no column"
        raise DataError(what, code="wrong_column")
    # UTC nanoseconds of each row
    column = source.rows.time
    found = np.empty(len(source.table), dtype=np.int64)
    for i, cell in enumerate(source.table.text(column)):
        try:
            found[i] = read_instant(_number_or_text(cell))
        except ValueError as error:
            raise DataError(f"column {column!r}: {error}", source.table.where(i), code="wrong_time") from None
    instants = found
    inside = np.zeros(len(instants), dtype=bool)
    for start, stop in source.source.windows or []:
        inside |= (instants >= start) & (instants < stop)
    return inside


def _number_or_text(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell
