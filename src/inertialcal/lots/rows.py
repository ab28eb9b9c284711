"""Units as rows of a table: what a lot writes into ``units/part-00000.parquet``."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import pyarrow as pa

from ..campaign.engine.whole import VERDICT_COLUMNS
from ..core.errors import Problem
from ..core.influence import influence_of
from ..core.remarks import Remark
from ..core.results import COLUMNS, Row, finite

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


@dataclass(frozen=True, eq=False)
class UnitRow:
    """What became of a unit."""

    number: int  # In the table of units, from 0
    serial: str
    status: Literal["done", "quarantined"]
    verdict: str = ""
    results: Sequence[Row] = ()
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


def result_cells(row: Row, shares: frozenset[str]) -> Cells:
    """Return a row of ``results.json`` in the order of `RESULT`, with the influences that units of a station share."""
    key, at, member, ends = row.key, row.key.at, row.member, row.interval
    what, value, unit = (None, None, None) if at is None else at
    kind, label = (None, None) if member is None else member
    code, text = row.reason if row.reason else (None, None)
    low, high, p = (None, None, None) if ends is None else (finite(ends.lo), finite(ends.hi), ends.p)
    return (
        key.quantity, key.axis, key.sensor, key.power, what, value, unit, row.test, row.condition, row.method.value,
        kind, label, finite(row.value), finite(row.u), row.unit, finite(row.dof), low, high, p, row.status, code, text,
        math.sqrt(sum(change**2 for name, change in row.shared.items() if influence_of(name) in shares)),
    )  # fmt: skip


def _verdict_cells(one: dict[str, Any]) -> Cells:
    cells = one | (one["interval"] or {})
    return tuple(None if (cell := cells.get(name)) is None else cell for name in VERDICT)


def _remark_cells(given: tuple[str, Remark]) -> Cells:
    test, one = given
    return one.code, one.severity, test, one.where, one.count, one.what, one.do


def _problem_cells(one: Problem) -> Cells:
    return one.code, one.what, one.where, one.why, one.do


def table_of(rows: Sequence[UnitRow]) -> pa.Table:
    """Return units as a table of the columns of `SCHEMA`."""
    made: list[pa.Array] = []
    sources: dict[str, tuple[Callable[[UnitRow], Sequence[Any]], Callable[[Any], Cells]]] = {
        "results": (lambda one: [result_cells(each, one.shares) for each in one.results], tuple),
        "verdicts": (lambda one: one.verdicts, _verdict_cells),
        "remarks": (lambda one: one.remarks, _remark_cells),
        "model": (lambda one: one.models, tuple),
        "inputs": (lambda one: one.inputs, tuple),
        "problems": (lambda one: one.problems, _problem_cells),
    }
    for name in OWN:
        if name in sources:
            of_unit, cells = sources[name]
            made.append(_list(LISTS[name], [[cells(one) for one in of_unit(row)] for row in rows]))
        else:
            made.append(pa.array([_clean(getattr(row, name)) for row in rows], PLAIN[name]))
    return pa.Table.from_arrays(made, schema=SCHEMA)


def _list(kind: pa.StructType, rows: Sequence[Sequence[Cells]]) -> pa.Array:
    offsets = [0]
    for row in rows:
        offsets.append(offsets[-1] + len(row))
    every = [one for row in rows for one in row]
    columns: Iterable[Sequence[Any]] = zip(*every, strict=True) if every else [()] * kind.num_fields
    fields = [kind.field(number) for number in range(kind.num_fields)]
    arrays = [pa.array([_clean(cell) for cell in column] if pa.types.is_string(one.type) else column, one.type)
              for one, column in zip(fields, columns, strict=True)]  # fmt: skip
    return pa.ListArray.from_arrays(pa.array(offsets, pa.int32()), pa.StructArray.from_arrays(arrays, fields=fields))


def _clean(cell: Any) -> Any:
    """Return text that is UTF-8: a name of a file may not be."""
    if not isinstance(cell, str) or cell.isascii():
        return cell if cell is None or isinstance(cell, str | int) else str(cell)
    return cell.encode("utf-8", "replace").decode("utf-8")
