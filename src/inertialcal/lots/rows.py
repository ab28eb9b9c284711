"""Units as rows of a table: what a lot writes into ``units/part-00000.parquet``."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from ..campaign.engine.whole import VERDICT_COLUMNS
from ..campaign.outcome.contents import Figure
from ..core.errors import Problem
from ..core.estimate import Array, Estimate
from ..core.influence import influence_of
from ..core.key import Method
from ..core.remarks import Remark
from ..core.results import COLUMNS
from ..procedures.display import shown_in

RESULT = (*COLUMNS, "common")  # the last: the part of u that all units of a station share by its standards
VERDICT = (*VERDICT_COLUMNS, "quantity")
NUMBERS = frozenset({"at", "value", "u", "common", "dof", "lo", "hi", "p", "lower", "upper", "margin"})
REMARK = ("code", "severity", "test", "where", "count", "what", "do")
PROBLEM = ("code", "what", "where", "why", "do")
OWN = ("number", "serial", "status", "reason_code", "reason", "verdict", "results", "verdicts", "remarks", "model",
       "inputs", "problems")  # fmt: skip


def _struct(names: Sequence[str], whole: frozenset[str] = frozenset()) -> pa.DataType:
    kinds = {name: pa.float64() if name in NUMBERS else pa.int64() if name in whole else pa.string() for name in names}
    return pa.struct(list(kinds.items()))


LISTS = {
    "results": _struct(RESULT, frozenset({"power"})),
    "verdicts": _struct(VERDICT),
    "remarks": _struct(REMARK, frozenset({"count"})),
    "model": _struct(("name", "json")),
    "inputs": _struct(("path", "sha256")),
    "problems": _struct(PROBLEM),
}
PLAIN = {name: pa.int64() if name == "number" else pa.string() for name in OWN if name not in LISTS}
SCHEMA = pa.schema([(name, pa.list_(LISTS[name]) if name in LISTS else PLAIN[name]) for name in OWN])
Cells = tuple[Any, ...]
NONE = (None,) * 3


@dataclass(frozen=True, eq=False)
class UnitRow:
    """What became of a unit."""

    number: int  # In the table of units, from 0
    serial: str
    status: Literal["done", "quarantined"]
    verdict: str = ""
    results: Sequence[Figure] = ()
    verdicts: Sequence[dict[str, Any]] = ()
    remarks: Sequence[tuple[str, Remark]] = ()  # Test, remark
    models: Sequence[tuple[str, str]] = ()  # Name and text of each file
    inputs: Sequence[tuple[str, str]] = ()  # Path, SHA-256
    problems: Sequence[Problem] = field(default=())
    shares: frozenset[str] = frozenset()  # Influences whose errors units of one station share

    @property
    def reason_code(self) -> str:
        """Code of why it was quarantined; empty of a unit that is done."""
        return self.problems[0].code if self.problems else ""

    @property
    def reason(self) -> str:
        """Why it was quarantined; empty of a unit that is done."""
        return str(self.problems[0]) if self.problems else ""


def quarantined(number: int, serial: str, problems: Sequence[Problem]) -> UnitRow:
    """Return the row of a unit that was refused."""
    return UnitRow(number, serial, "quarantined", problems=tuple(problems))


def _verdict_cells(one: dict[str, Any]) -> Cells:
    cells = one | (one["interval"] or {})
    return tuple([cells.get(name) for name in VERDICT])


def _remark_cells(given: tuple[str, Remark]) -> Cells:
    test, one = given
    return one.code, one.severity, test, one.where, one.count, one.what, one.do


def _problem_cells(one: Problem) -> Cells:
    return one.code, one.what, one.where, one.why, one.do


def table_of(rows: Sequence[UnitRow]) -> pa.Table:
    """Return units as a table of the columns of `SCHEMA`."""
    made: list[pa.Array] = []
    sources: dict[str, tuple[Callable[[UnitRow], Sequence[Any]], Callable[[Any], Cells]]] = {
        "verdicts": (lambda one: one.verdicts, _verdict_cells),
        "remarks": (lambda one: one.remarks, _remark_cells),
        "model": (lambda one: one.models, tuple),
        "inputs": (lambda one: one.inputs, tuple),
        "problems": (lambda one: one.problems, _problem_cells),
    }
    for name in OWN:
        if name == "results":
            made.append(_results(rows))
        elif name in sources:
            of_unit, cells = sources[name]
            made.append(_list(LISTS[name], [[cells(one) for one in of_unit(row)] for row in rows]))
        else:
            made.append(pa.array([_clean(getattr(row, name)) for row in rows], PLAIN[name]))
    return pa.Table.from_arrays(made, schema=SCHEMA)


def stream_of(rows: Sequence[UnitRow]) -> bytes:
    """Return units as an Arrow stream, which is what the ledger keeps."""
    sink, table = io.BytesIO(), table_of(rows)
    with pa.ipc.new_stream(sink, table.schema, options=pa.ipc.IpcWriteOptions(compression="zstd")) as stream:
        stream.write_table(table)
    return sink.getvalue()


def _results(rows: Sequence[UnitRow]) -> pa.ListArray:
    """Return the figures of units in the order of `RESULT`: text once for all units that have it, numbers as arrays."""
    known: dict[tuple[Any, ...], int] = {}
    places: list[int] = []
    found: list[float | None] = []
    for unit in rows:  # once: what lies scattered in memory is slow to come by
        for row, sensor_unit, test, condition, _, _ in unit.results:
            said = (row.key, row.unit, row.member, row.status, row.reason, sensor_unit, test, condition,
                    None if row.method is Method.RESULT else row.method)  # fmt: skip
            places.append(known.setdefault(said, len(known)))
            ends = row.interval
            found += (row.value, row.u, row.dof)
            found += NONE if ends is None else (ends.lo, ends.hi, ends.p)
    common = [part for unit in rows for part in _common(unit)]
    texts, scale = [], np.ones(len(known))
    for i, (key, own_unit, member, status, reason, sensor_unit, test, condition, way) in enumerate(known):
        shown, scale[i] = shown_in(key.name, own_unit, sensor_unit)
        place, part = key.at or (None,) * 3, member or (None,) * 2
        cells = (
            key.quantity,
            key.axis,
            key.sensor,
            key.power,
            *place,
            test,
            condition,
            (way or Method.RESULT).value,
            *part,
        )
        texts.append((*cells, shown, status, *(reason or (None, None))))
    at = np.array(places, dtype=np.int64)
    value, u, dof, lo, hi, p = pa.array(found, pa.float64()).to_numpy(zero_copy_only=False).reshape(-1, 6).T
    scale = scale[at]
    numbers = {"value": value * scale, "u": u * scale, "dof": dof, "lo": lo * scale, "hi": hi * scale, "p": p,
               "common": np.array(common) * scale}  # fmt: skip
    named = dict(zip((name for name in RESULT if name not in numbers), zip(*texts, strict=True), strict=False))
    arrays = [
        pa.array(numbers[one.name], mask=~np.isfinite(numbers[one.name])) if one.name in numbers
        else _column(named.get(one.name, ()), one.type).take(pa.array(at))
        for one in LISTS["results"]
    ]  # fmt: skip
    return _lists(LISTS["results"], [len(one.results) for one in rows], arrays)


def _common(unit: UnitRow) -> list[float]:
    """Return the part of u of each figure of a unit that units of a station share by its standards, SI."""
    parts: dict[Estimate, list[float]] = {}
    found = []
    for row, _, _, _, estimate, at in unit.results:
        if row.shared:
            found.append(_shared(row.shared, unit.shares))
        elif estimate is None:
            found.append(0.0)
        else:
            if estimate not in parts:
                parts[estimate] = _part(estimate, unit.shares)
            found.append(parts[estimate][at])
    return found


def _part(estimate: Estimate, shares: frozenset[str]) -> list[float]:
    """Return the same of each value of an estimate."""
    found: dict[str, Array] = {}
    for one in estimate.components:
        if one.changes is not None and one.influence in shares:
            for unknown, changes in one.named_changes.items():
                found[unknown] = found[unknown] + changes if unknown in found else changes
    if not found:
        return [0.0] * len(estimate.values)
    part: list[float] = np.sqrt((np.array([*found.values()]) ** 2).sum(axis=0)).tolist()
    return part


def _shared(changes: Mapping[str, float], shares: frozenset[str]) -> float:
    return math.sqrt(sum(change**2 for name, change in changes.items() if influence_of(name) in shares))


def _list(kind: pa.StructType, rows: Sequence[Sequence[Cells]]) -> pa.ListArray:
    every = [one for row in rows for one in row]
    columns: Iterable[Sequence[Any]] = zip(*every, strict=True) if every else [()] * kind.num_fields
    arrays = [_column(column, one.type) for one, column in zip(kind, columns, strict=True)]
    return _lists(kind, [len(row) for row in rows], arrays)


def _lists(kind: pa.StructType, lengths: Sequence[int], arrays: Sequence[pa.Array]) -> pa.ListArray:
    """Return a list a unit, so many each, of structures."""
    offsets = pa.array(np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32))
    return pa.ListArray.from_arrays(offsets, pa.StructArray.from_arrays(arrays, fields=list(kind)))


def _column(cells: Sequence[Any], kind: pa.DataType) -> pa.Array:
    try:
        return pa.array(cells, kind)
    except (UnicodeError, pa.ArrowException):  # text that is not UTF-8, or no text
        return pa.array([_clean(cell) for cell in cells], kind)


def _clean(cell: Any) -> Any:
    """Return text that is UTF-8: a name of a file may not be."""
    if not isinstance(cell, str) or cell.isascii():
        return cell if cell is None or isinstance(cell, str | int) else str(cell)
    return cell.encode("utf-8", "replace").decode("utf-8")
