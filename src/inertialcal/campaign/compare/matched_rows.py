"""Figures of two results matched by what they are: quantity, axis, condition, and test where tests have names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any

from ...core.remarks import Remark
from ...core.results import Row
from ...core.units import convert, factor, same_dimension

SHOWN = 6  # names in a remark


def matched(
    first: Sequence[Row], second: Sequence[Row], by_test: bool = True
) -> tuple[list[tuple[Row, Row]], tuple[Remark, ...]]:
    """Return the figures that stand in both, in the order of the first, and remarks on the others.

    Parameters
    ----------
    by_test : bool
        Whether the test is part of a figure's name. Figures that only differ in the name of their test are then
        still taken together where both sides have exactly one.
    """
    keys: list[Any] = [_of]
    if by_test:
        keys.insert(0, lambda row: (_of(row), row.test))
    left, right = list(range(len(first))), list(range(len(second)))
    pairs: dict[int, int] = {}
    for key in keys:
        ours, theirs = (_unique([(key(rows[i]), i) for i in rest]) for rows, rest in ((first, left), (second, right)))
        pairs |= {i: theirs[name] for name, i in ours.items() if name in theirs}
        left = [i for i in left if i not in pairs]
        right = [i for i in right if i not in set(pairs.values())]
    fitting = {i: j for i, j in pairs.items() if same_dimension(first[i].unit, second[j].unit)}
    remarks = [
        *_alone("first", [first[i] for i in left]),
        *_alone("second", [second[j] for j in right]),
        *_other_dimension([first[i] for i in pairs if i not in fitting]),
    ]
    return [(first[i], _in_unit(second[fitting[i]], first[i].unit)) for i in sorted(fitting)], tuple(remarks)


def _of(row: Row) -> Hashable:
    """Return what a row is; a place as tables show it, for no two records find a line at the same frequency."""
    place = None if row.key.at is None else str(row.key.at)
    return row.key._replace(at=None), place, row.method, row.member, row.condition


def _unique(named: Sequence[tuple[Hashable, int]]) -> dict[Hashable, int]:
    """Positions by name, of names that stand once."""
    count = Counter(name for name, _ in named)
    return {name: i for name, i in named if count[name] == 1}


def _in_unit(row: Row, unit: str) -> Row:
    """Return the row in another unit; its interval is not needed here."""
    if row.unit == unit:
        return replace(row, interval=None)
    value = None if row.value is None else float(convert([row.value], row.unit, unit)[0])
    scale = factor(row.unit, unit, difference=True)
    u = None if row.u is None else row.u * scale
    shared = {name: change * scale for name, change in row.shared.items()}
    return replace(row, value=value, u=u, unit=unit, interval=None, shared=shared)


def _alone(side: str, rows: Sequence[Row]) -> list[Remark]:
    return rows_remark(f"only_in_{side}", f"only in the {side}, so not compared:", rows)


def _other_dimension(rows: Sequence[Row]) -> list[Remark]:
    return rows_remark("unit_mismatch", "in units of two kinds, so not compared:", rows)


def rows_remark(code: str, what: str, rows: Sequence[Row]) -> list[Remark]:
    """Return one remark that counts figures and names the first; none where there is no figure."""
    if not rows:
        return []
    names = list(dict.fromkeys(f"{row.quantity} {row.axis}".strip() for row in rows))
    shown = ", ".join(names[:SHOWN]) + (", ..." if len(names) > SHOWN else "")
    return [Remark(code, "info", f"{what} {shown}", count=len(rows))]
