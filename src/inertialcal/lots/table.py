"""Figures of a lot as arrays: a row a test of a unit, a column a figure, from the rows of its units."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.key import At, Key, Method

IDENTITY = ("test", "quantity", "axis", "sensor", "power", "at_what", "at", "at_unit", "condition", "unit")
HEAD = ("serial", "status", "verdict", "reason_code")
COLUMNS = (*IDENTITY, "method", "member_kind", "status", "value", "u", "dof", "common")  # of a figure
PARAMETER = ("quantity", "axis", "sensor", "power")
LIMIT = ("requirement", "test", "quantity", "axis", "sensor", "at", "unit")
ASSEMBLED = "model"  # test of figures that stand in another test already
NOT_STATED = "not stated"  # level of an empty cell
BY_DAY = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})(?:,? +(\d{1,2}):(\d\d)(:\d\d(?:\.\d+)?)?)?")  # 12.03.2026 08:30
Words = tuple[str | float | None, ...]  # that say which figure, limit or parameter something is
JUDGED = ("PASS", "FAIL", "INCONCLUSIVE")


@dataclass(frozen=True)
class Figure:
    """Which figure a column is."""

    test: str
    quantity: str
    axis: str
    sensor: str
    power: int
    at_what: str
    at: float | None
    at_unit: str
    condition: str
    unit: str

    @property
    def parameter(self) -> tuple[str, str, str, int]:
        """What of the model it is."""
        return self.quantity, self.axis, self.sensor, self.power

    @property
    def name(self) -> str:
        """In words."""
        place = None if self.at is None else At(self.at_what, self.at, self.at_unit)
        quantity = Key(self.quantity, self.axis, self.sensor, self.power, place).name.replace("_", " ")
        words = " ".join(part for part in (quantity, self.axis, self.sensor, self.condition) if part)
        return words if place is None else f"{words} at {place}"


@dataclass(frozen=True)
class Limits:
    """What a requirement asks of a figure, and what became of it: verdict of each row, -1 where there is none."""

    requirement: str
    lower: float | None
    upper: float | None
    verdicts: NDArray[np.int8]  # index into ``JUDGED``


@dataclass(frozen=True)
class Wrong:
    """A test of a unit with an error: what it read is not what the campaign says."""

    row: int
    test: str
    code: str
    what: str  # Of the first
    count: int


@dataclass(frozen=True, eq=False)
class Table:
    """Figures of a lot.

    Parameters
    ----------
    serials, statuses, verdicts, reasons : tuple of str, length n
        Of each row.
    figures : tuple of Figure, length k
        Columns.
    told, u, dof : ndarray, shape (n, k)
        NaN where a row has no such figure; degrees of freedom may be infinite.
    common : ndarray, shape (n, k)
        Part of u that all units of a station share by its standards.
    limits : mapping of int to tuple of Limits
        Of columns that requirements judge.
    parameters : mapping
        Of the models, as ``Figure.parameter`` names them: which rows have each, ndarray of bool, shape (n,).
    columns : pyarrow.Table
        What the table of units says beside the serial.
    wrong : tuple of Wrong
        Tests with errors.
    """

    serials: tuple[str, ...]
    statuses: tuple[str, ...]
    verdicts: tuple[str, ...]
    reasons: tuple[str, ...]
    figures: tuple[Figure, ...]
    told: Array
    u: Array
    dof: Array
    common: Array
    limits: Mapping[int, tuple[Limits, ...]]
    parameters: Mapping[tuple[str, str, str, int], NDArray[np.bool_]]
    columns: pa.Table
    wrong: tuple[Wrong, ...] = ()

    def __len__(self) -> int:
        return len(self.serials)

    @cached_property
    def values(self) -> Array:
        """What statistics are made of, shape (n, k): as told, NaN in tests with errors."""
        made = self.told.copy()
        for one in self.wrong:
            made[one.row, [one.test in (figure.test, "") for figure in self.figures]] = np.nan
        return made

    @cached_property
    def own(self) -> Array:
        """Part of u that is drawn anew for each unit, shape (n, k)."""
        return np.asarray(np.sqrt(np.maximum(self.u**2 - self.common**2, 0.0)))

    @cached_property
    def own_dof(self) -> Array:
        """Degrees of freedom of that, shape (n, k): the standards have theirs without end."""
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.where(self.u > 0.0, self.own / self.u, 1.0)
        return np.asarray(np.maximum(self.dof * share**4, 1.0))

    @cached_property
    def units(self) -> NDArray[np.intp]:
        """Which unit each row is of, from 0 on in the order of the table."""
        known: dict[str, int] = {}
        return np.array([known.setdefault(one, len(known)) for one in self.serials], dtype=np.intp)

    @cached_property
    def first(self) -> NDArray[np.bool_]:
        """Which rows are the first done test of their unit: the others count in the gauge alone."""
        seen: set[str] = set()
        return np.array([one not in seen and state == "done" and not seen.add(one)  # type: ignore[func-returns-value]
                         for one, state in zip(self.serials, self.statuses, strict=True)])  # fmt: skip

    def usual(self, number: int) -> NDArray[np.bool_]:
        """Return which rows have a figure from the same terms of the model as most: of its test, sensor and axis."""
        own = self.figures[number]
        which = self._terms[own.test, own.sensor, own.axis]
        known = self.first & np.isfinite(self.values[:, number])
        return np.asarray(which == np.argmax(np.bincount(which[known], minlength=1)))

    @cached_property
    def _terms(self) -> dict[tuple[str, str, str], NDArray[np.intp]]:
        """Which rows have the same terms of the model, by test, sensor and axis."""
        beside: dict[tuple[str, str, str], set[tuple[str, str, str, int]]] = {}
        for one in self.figures:
            beside.setdefault((one.test, one.sensor, one.axis), set()).add(one.parameter)
        found = {}
        for of, names in beside.items():
            has = [rows for name, rows in self.parameters.items() if name in names]
            index = np.column_stack(has) if has else np.zeros((len(self), 1), dtype=bool)
            found[of] = np.unique(index, axis=0, return_inverse=True)[1].reshape(-1)
        return found

    def levels(self, name: str) -> tuple[NDArray[np.intp], tuple[str, ...]]:
        """Return the level of each row and the names of levels, of a column of the table of units."""
        cells = [NOT_STATED if one is None else str(one) for one in self.columns[name].to_pylist()]
        names = tuple(dict.fromkeys(cells))
        return np.array([names.index(one) for one in cells], dtype=np.intp), names

    def place(self, name: str) -> tuple[Array, str]:
        """Return where each row stands along the lot, and the unit of that: days of instants, or a number as it is."""
        column = self.columns[name]
        kind = column.type
        if pa.types.is_timestamp(kind) or pa.types.is_date(kind):
            seconds = pc.cast(pc.cast(column, pa.timestamp("ns", getattr(kind, "tz", None))), pa.int64())
            return _floats(seconds) / 86_400e9, "day"
        if pa.types.is_integer(kind) or pa.types.is_floating(kind):
            return _floats(column), name
        stamps = np.array([np.nan] * len(self))
        for row, one in enumerate(column.to_pylist()):
            with suppress(ValueError):
                if one is not None:
                    stamps[row] = np.datetime64(_iso(str(one).strip()), "ns").astype(np.int64) / 86_400e9
        return stamps, "day"


def _iso(cell: str) -> str:
    """Return an instant as ISO 8601 has it, from that or from day.month.year."""
    found = BY_DAY.fullmatch(cell)
    if found is None:
        return cell.removesuffix("Z")
    day, month, year, hour, minute, rest = found.groups()
    return f"{year}-{int(month):02d}-{int(day):02d}T{int(hour or 0):02d}:{minute or '00'}{rest or ''}"


def _floats(column: pa.ChunkedArray) -> Array:
    return np.asarray(pc.cast(column, pa.float64(), safe=False).to_numpy(), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Figures:
    """Figures of some units in a row, as `figures_of` finds them: by their rows from 0, and by numbers of keys."""

    head: pa.Table  # What the units are and how they ended
    keys: tuple[Words, ...]  # Of figures, in the order in which they come
    cells: tuple[NDArray[Any], ...]  # Row, number of the figure, value, u, dof, common
    asked: tuple[Words, ...]  # What requirements judge
    limits: tuple[tuple[float | None, float | None], ...]
    judged: tuple[NDArray[Any], ...]  # Row, number of what is asked, verdict
    parameters: tuple[Words, ...]
    modelled: tuple[NDArray[Any], ...]  # Row, number of the parameter
    wrong: tuple[Wrong, ...]


def figures_of(rows: pa.Table, names: Sequence[str]) -> Figures:
    """Return the figures of some units.

    Parameters
    ----------
    rows : pyarrow.Table
        Of units, as a lot writes them.
    names : sequence of str
        Columns of theirs that the table of units gave.
    """
    row, found = _flattened(rows["results"], COLUMNS)
    keep = pc.and_(pc.equal(found["method"], Method.RESULT.value), pc.is_null(found["member_kind"]))
    keep = pc.and_(keep, pc.equal(found["status"], "estimated"))
    kept = np.asarray(pc.fill_null(keep, False).to_numpy(zero_copy_only=False), dtype=bool)
    assembled = np.asarray(pc.equal(found["test"], ASSEMBLED).to_numpy(zero_copy_only=False), dtype=bool)
    of_model, own = kept & assembled, kept & ~assembled
    parameters, modelled = _numbered(found.select(PARAMETER).filter(pa.array(of_model)))
    mine = found.filter(pa.array(own))
    keys, at = _numbered(mine.select(IDENTITY))
    cells = (row[own], at, *(_column(mine, name) for name in ("value", "u", "dof", "common")))
    judged_row, judged = _flattened(rows["verdicts"], (*LIMIT, "lower", "upper", "verdict"))
    asked, number = _numbered(judged.select(LIMIT))
    first = np.unique(number, return_index=True)[1]
    ends = np.column_stack([_column(judged, name)[first] for name in ("lower", "upper")]).tolist()
    limits = tuple((None if np.isnan(lower) else lower, None if np.isnan(upper) else upper) for lower, upper in ends)
    words = [JUDGED.index(word) if word in JUDGED else -1 for word in judged["verdict"].to_pylist()]
    return Figures(
        rows.select([*HEAD, *names]), keys, cells, asked, limits, (judged_row, number, np.array(words, dtype=np.int8)),
        parameters, (row[of_model], modelled), tuple(_wrong(rows["remarks"])),
    )  # fmt: skip


def table_of_figures(every: Sequence[Figures]) -> Table:
    """Return the figures of a lot: of all its units, in their order.

    Raises
    ------
    DataError
        ``no_units``.
    """
    if not every:
        raise DataError("a lot without a unit", code="no_units")
    made = _Made()
    for one in every:
        made.add(one)
    return made.table()


class _Made:
    """Figures as they come, some units at a time."""

    def __init__(self) -> None:
        self.numbers: dict[tuple[Any, ...], int] = {}
        self.asked: dict[tuple[Any, ...], int] = {}
        self.limits: list[tuple[float | None, float | None]] = []
        self.cells: list[tuple[Any, ...]] = []  # row, column, value, u, dof, common: arrays
        self.judged: list[tuple[Any, ...]] = []  # row, number of the limit, verdict: arrays
        self.wrong: list[Wrong] = []
        self.heads: list[pa.Table] = []
        self.count = 0
        self.parameters: dict[tuple[Any, ...], int] = {}
        self.modelled: list[tuple[Any, ...]] = []  # row, number of the parameter: arrays

    def add(self, some: Figures) -> None:
        first, self.count = self.count, self.count + some.head.num_rows
        self.heads.append(some.head)
        self.limits += [ends for key, ends in zip(some.asked, some.limits, strict=True) if key not in self.asked]
        for cells, keys, known, whole in (
            (some.cells, some.keys, self.numbers, self.cells),
            (some.judged, some.asked, self.asked, self.judged),
            (some.modelled, some.parameters, self.parameters, self.modelled),
        ):
            numbers = np.array([known.setdefault(key, len(known)) for key in keys], dtype=np.intp)
            whole.append((cells[0] + first, numbers[cells[1]], *cells[2:]))
        self.wrong += [replace(one, row=one.row + first) for one in some.wrong]

    def table(self) -> Table:
        n, k = self.count, len(self.numbers)
        values, u, common = (np.full((n, k), np.nan) for _ in range(3))
        dof = np.full((n, k), np.inf)
        for rows, at, value, uncertainty, free, shared in self.cells:
            values[rows, at], u[rows, at] = value, np.nan_to_num(uncertainty, nan=0.0)
            dof[rows, at] = np.where(np.isnan(free), np.inf, free)
            common[rows, at] = np.nan_to_num(shared, nan=0.0)
        figures = tuple(_figure(key) for key in self.numbers)
        head = pa.concat_tables(self.heads, promote_options="permissive")
        texts = {name: tuple(str(one or "") for one in head[name].to_pylist())
                 for name in ("serial", "status", "verdict", "reason_code")}  # fmt: skip
        rest = head.drop_columns(list(texts))
        return Table(texts["serial"], texts["status"], texts["verdict"], texts["reason_code"], figures, values, u, dof,
                     common, self._limits(figures), self._modelled(), rest, tuple(self.wrong))  # fmt: skip

    def _modelled(self) -> dict[tuple[str, str, str, int], NDArray[np.bool_]]:
        has = np.zeros((self.count, len(self.parameters)), dtype=bool)
        for rows, at in self.modelled:
            has[rows, at] = True
        return {(quantity, axis or "", sensor or "", int(power or 0)): has[:, number]
                for (quantity, axis, sensor, power), number in self.parameters.items()}  # fmt: skip

    def _limits(self, figures: Sequence[Figure]) -> dict[int, tuple[Limits, ...]]:
        verdicts = np.full((self.count, len(self.asked)), -1, dtype=np.int8)
        for rows, at, words in self.judged:
            verdicts[rows, at] = words
        made: dict[int, list[Limits]] = {}
        places = {(one.test, one.quantity, one.axis, one.sensor, one.at, one.unit): i for i, one in enumerate(figures)}
        for key, number in self.asked.items():
            requirement, *of = key
            column = places.get(tuple("" if cell is None and at != 4 else cell for at, cell in enumerate(of)))  # type: ignore[arg-type]
            if column is not None:
                made.setdefault(column, []).append(Limits(str(requirement), *self.limits[number], verdicts[:, number]))
        return {column: tuple(found) for column, found in made.items()}


def _figure(key: Sequence[Any]) -> Figure:
    test, quantity, axis, sensor, power, what, at, at_unit, condition, unit = key
    return Figure(test or "", quantity or "", axis or "", sensor or "", int(power or 0), what or "", at, at_unit or "",
                  condition or "", unit or "")  # fmt: skip


def _wrong(column: pa.ChunkedArray) -> list[Wrong]:
    rows, found = _flattened(column, ("severity", "test", "code", "what"))
    bad = np.asarray(pc.equal(found["severity"], "error").to_numpy(zero_copy_only=False), dtype=bool)
    made: dict[tuple[int, str], Wrong] = {}
    for row, one in zip(rows[bad].tolist(), found.filter(pa.array(bad)).to_pylist(), strict=True):
        known = made.get((row, one["test"]), Wrong(row, one["test"], one["code"], one["what"], 0))
        made[row, one["test"]] = replace(known, count=known.count + 1)
    return list(made.values())


def _numbered(found: pa.Table) -> tuple[tuple[tuple[Any, ...], ...], NDArray[np.intp]]:
    """Return the different rows of a table in the order in which they come, and which of them each row is."""
    if not found.num_rows:
        return (), np.zeros(0, dtype=np.intp)
    codes = [_coded(column) for column in found.columns]
    index = np.zeros(found.num_rows, dtype=np.int64)
    for words, at in codes:
        index = index * len(words) + at
    _, first, where = np.unique(index, return_index=True, return_inverse=True)
    order = np.argsort(first)
    numbers = np.empty(len(first), dtype=np.intp)
    numbers[order] = np.arange(len(first))
    keys = tuple(tuple(words[at[k]] for words, at in codes) for k in first[order])
    return keys, np.asarray(numbers[where])


def _coded(column: pa.ChunkedArray) -> tuple[list[Any], NDArray[np.intp]]:
    """Return the words of a column, none among them, and which of them each cell is."""
    coded = column.combine_chunks().dictionary_encode()
    at = pc.fill_null(pc.add(coded.indices.cast(pa.int64()), 1), 0).to_numpy()
    return [None, *coded.dictionary.to_pylist()], np.asarray(at, dtype=np.intp)


def _flattened(column: pa.ChunkedArray, names: Sequence[str]) -> tuple[NDArray[np.intp], pa.Table]:
    """Return the row of each entry of lists, and some of its fields as a table."""
    whole = column.combine_chunks()
    entries = whole.flatten()
    rows = pc.list_parent_indices(whole).to_numpy().astype(np.intp)
    fields = dict(zip((one.name for one in entries.type), entries.flatten(), strict=True))
    return rows, pa.table({name: fields[name] for name in names})


def _column(found: pa.Table, name: str) -> Array:
    return np.asarray(found[name].combine_chunks().to_numpy(zero_copy_only=False), dtype=np.float64)
