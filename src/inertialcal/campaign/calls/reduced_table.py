"""A reduced table without a campaign file: which column is what, and its rows as dwells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from ...core.units import normalise
from ...files.info.table_columns import Guess
from ...procedures.rate_table.entry import Rows
from ...procedures.rate_table.plan import Plan
from ...procedures.rate_table.procedure import PROCEDURE
from ...procedures.rate_table.reduction import Readings
from ..file.recordings import RecordingEntry
from ..file.schema import Test
from ..file.sensors import Sensor
from ..inputs.sources import Folder, Ready, facts_of


def table_columns(
    found: Guess,
    names: Sequence[str],
    said: Mapping[str, Any],
    file: Path,
) -> dict[str, Any]:
    """Return which column is what, as ``rows`` of a campaign file has it, and ``axis`` where none says it.

    Parameters
    ----------
    found : Guess
        What the names tell.
    names : sequence of str
        Of all columns.
    said : mapping
        What the user said: ``applied``, ``reading``, ``axis``, ``unit``, ``scatter``, ``run``, ``group``; None
        where nothing.
    file : path
        For messages.

    Raises
    ------
    UsageError
        If it is not clear which column is what, or in which unit.
    """
    if said["axis"] is not None and found.axis is not None:
        what = f"{file}: column {found.axis!r} says which axis was turned, and --axis says {said['axis']}"
        raise UsageError(what, do="Leave --axis out", code="wrong_value")
    lacks = [*_lacking(found, names, said)]
    if lacks:
        code = lacks[0][2]
        asked = " ".join(dict.fromkeys(option for _, option, _ in lacks))
        raise UsageError(f"{file}: {'; '.join(what for what, _, _ in lacks)}", do=f"Say it: {asked}", code=code)
    chosen = _columns(found, said)
    spoken = said["unit"] or found.unit
    rows = Rows(
        applied=chosen["applied"],
        reading=chosen["reading"],
        unit=normalise(spoken),
        scatter=said["scatter"] or (found.scatter if isinstance(chosen["reading"], str) else None),
        run=said["run"] or found.run,
        group=said["group"] or found.group,
        samples=found.samples,
        axis=None if said["axis"] else found.axis,
    )
    turned = {"axis": chosen["axis"]} if chosen["axis"] else {}
    return {name: value for name, value in rows.model_dump().items() if value is not None} | turned


def turned_axis(columns: Mapping[str, Any]) -> str:
    """Return the axis that was turned in all of the file; empty where a column says it."""
    axis = str(columns.get("axis", ""))
    return axis if axis in ("x", "y", "z") else ""


def table_readings(file: Path, columns: Mapping[str, Any], sensor: Sensor) -> tuple[Readings, str]:
    """Return the rows of the table as dwells, and SHA-256 of the file.

    Raises
    ------
    DataError
        As ``rate_table.tables.readings_of_table``.
    """
    turned = turned_axis(columns)
    rows = Rows(**{name: value for name, value in columns.items() if name != "axis" or not turned})
    entry = RecordingEntry.model_validate({"sensor": "sensor", "file": file.name, "rows": rows})
    test = Test(id="rate_table", procedure="rate_table", recordings=["file"])
    source = Ready(Folder(file.parent), "file", entry, sensor, facts_of(sensor, {}), PROCEDURE.inputs, test)
    readings = PROCEDURE.readings(Plan(axis=turned), [source])
    return readings, source.inputs[file.name]


def _lacking(found: Guess, names: Sequence[str], said: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield what is not clear, the option that says it, and its code: all at once, so that one more try is enough."""
    if said["applied"] is None and found.applied is None:
        yield "no column is clearly the applied rate", "--applied COLUMN", "no_column"
    if said["reading"] is None and len(found.readings) != 1 and not found.by_axis:
        have = f" ({', '.join(found.readings)})" if found.readings else f"; it has {', '.join(names)}"
        yield f"{len(found.readings)} columns can be the reading{have}", "--reading COLUMN", "no_column"
        if said["axis"] is None and found.axis is None and not isinstance(said["reading"], dict):
            yield "nothing says which axis was turned", "--axis x", "no_axis"
    elif said["axis"] is None and found.axis is None and _only_axis(found, _reading(found, said)) is None:
        yield "nothing says which axis was turned", "--axis x", "no_axis"
    if said["unit"] is None and found.unit is None:
        yield "nothing says the unit of rate and reading", "--unit deg/s", "no_unit"


def _reading(found: Guess, said: Mapping[str, Any]) -> Any:
    by_axis = dict(found.by_axis) if len(found.by_axis) > 1 else None
    return said["reading"] or by_axis or found.readings[0]


def _columns(found: Guess, said: Mapping[str, Any]) -> dict[str, Any]:
    reading = _reading(found, said)
    turned = said["axis"] or (None if found.axis else _only_axis(found, reading))
    return {"applied": said["applied"] or found.applied, "reading": reading, "axis": turned or ""}


def _only_axis(found: Guess, chosen: Any) -> str | None:
    axes = [axis for axis, name in found.by_axis.items() if name == chosen]
    return axes[0] if len(axes) == 1 else None
