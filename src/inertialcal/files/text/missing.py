"""Missing values: an empty cell is one, a spelled-out NaN is one only where nobody needs the number."""

from __future__ import annotations

from collections.abc import Callable

from ...core.errors import DataError
from ...core.remarks import Remark
from ..columns import Rows


def missing_remarks(name: str, empty: Rows, nan: Rows, where: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return remarks on the empty cells of a column and on its literal NaN.

    Parameters
    ----------
    name : str
        Column.
    empty, nan : ndarray of int64
        Index of the cells of each kind.
    where : callable
        Gives ``file:row`` of an index.
    """
    remarks = []
    if len(empty):
        what = f"empty cell in {name!r}: missing"
        remarks.append(Remark("missing_cells", "info", what, where(int(empty[0])), len(empty), subject=name))
    if len(nan):
        what = f"no finite number (NaN, inf) in {name!r}: taken as missing"
        remarks.append(Remark("nan_literal", "warning", what, where(int(nan[0])), len(nan), subject=name))
    return tuple(remarks)


def nan_in_required(name: str, cell: str, count: int, where: str) -> DataError:
    """Return the error for a spelled-out NaN in a column that must hold numbers."""
    more = f" ({count} such cells)" if count > 1 else ""
    return DataError(
        f"literal {cell!r} in required column {name!r}{more}",
        where=where,
        why="some program wrote it in place of a number: missing, or a computation that failed?",
        do="Leave the cell empty if the value is missing",
        code="nan_in_required",
    )
