"""What a campaign says of a rate table's recordings: columns of a reduced table, a schedule of the table."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol, cast

from ...core.errors import Problem
from ...core.schema.quantities import Axis, Strict, Text, Unit
from ...core.units import kind
from ..entries import Entry, EntryKey, SaidSensor

Columns = Text | dict[Axis, Text]


class Rows(Strict):
    """rows = {...}: which column of a reduced table is what; a row is a dwell."""

    applied: Text
    reading: Columns
    unit: Unit
    applied_unit: Unit | None = None
    scatter: Columns | None = None
    samples: Text | None = None
    axis: Text | None = None
    group: Text | None = None
    run: Text | None = None
    time: Text | None = None


class Schedule(Strict):
    """schedule = {...}: a table of the dwells of a recording, a row a dwell, on its clock; or of several by name."""

    file: Text
    start: Text = "start"
    stop: Text = "stop"
    rate: Text = "rate"
    unit: Unit
    recording: Text | None = None


class RateTableEntry(Entry, Protocol):
    """A recording of a rate table."""

    @property
    def rows(self) -> Rows | None:
        """Columns of a reduced table."""
        ...

    @property
    def schedule(self) -> Schedule | None:
        """Dwells of a recording."""
        ...


def _readings(rows: Rows) -> list[str]:
    """Return the columns that hold readings and their scatter."""
    given = (one if isinstance(one, dict) else {"": one} for one in (rows.reading, rows.scatter or {}))
    return [column for one in given for column in one.values()]


KEYS = (
    EntryKey(
        "rows",
        Rows,
        table=True,
        apart=True,
        grouped=lambda rows: rows.group is not None,
        readings=_readings,
        run=lambda rows: rows.run,
    ),
    EntryKey("schedule", Schedule, file=lambda schedule: schedule.file),
)


def entry_problems(name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
    """Yield columns of a reduced table that do not fit the sensor."""
    rows = cast("RateTableEntry", entry).rows
    if rows is None:
        return
    where, wanted = at("recordings", name, "rows"), kind(sensor.unit)
    if sensor.mounting is not None:
        what = f"recordings.{name}: the sensor has a mounting, which is for recordings of channels"
        do = "Give the table in body axes, and another sensor without mounting for it"
        yield Problem(what, where, "the columns' axes would be ambiguous", do, "wrong_value")
    applied = rows.applied_unit or (sensor.unit if kind(rows.unit) in {"count", "voltage"} else rows.unit)
    if kind(applied) != wanted:
        yield Problem(f"recordings.{name}: applied in {applied!r}, need a unit of {wanted}", where, code="wrong_value")
    if kind(rows.unit) == "count" and sensor.chain.kind not in ("adc", "output"):
        yield Problem(f"recordings.{name}: counts, but the sensor's chain has no converter", where, code="wrong_value")
    elif kind(rows.unit) == "voltage" and sensor.chain.scale_factor is None:
        what = f"recordings.{name}: volts, but the sensor's chain has no scale_factor"
        yield Problem(what, where, code="wrong_value")
    elif kind(rows.unit) not in {"count", "voltage", wanted}:
        yield Problem(f"recordings.{name}: unit {rows.unit!r}, need a unit of {wanted}", where, code="wrong_value")
    for axis in [*(rows.reading if isinstance(rows.reading, dict) else ())]:
        if axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")
