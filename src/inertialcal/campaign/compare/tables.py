"""A comparison as tables: a row a figure, reasons where there is none, the overall verdict."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.result_tables import folded, remarks_line
from ...core.show.rounding import number, with_uncertainty
from ...core.show.tables import Block, Table
from .differences import Difference

HEADS = ("quantity", "axis", "first", "second", "difference", "unit", "95 % interval", "verdict")
JUDGED = ("allowed", "no change")


def comparison_parts(
    kind: str, differences: Sequence[Difference], remarks: Sequence[Remark], verdict: str
) -> tuple[Block, ...]:
    """Return what is shown of a comparison; the columns are fewer than `compare` prints, to fit a notebook.

    Parameters
    ----------
    kind : {"models", "results"}
        What was compared; results come test by test.
    differences : sequence of Difference
        All figures that stand in both.
    remarks : sequence of Remark
        Of the comparison.
    verdict : str
        Over all allowed changes; empty where none is stated.
    """
    shown = [one for one in differences if is_shown(one)]
    judged = any(one.no_change is not None for one in shown)
    parts: list[Block] = []
    for test in dict.fromkeys(one.row.test if kind == "results" else "" for one in shown):
        rows = [_narrow(one, judged) for one in shown if kind != "results" or one.row.test == test]
        heads = ("quantity", "difference", "unit", "95 % interval", *(JUDGED if judged else ("verdict",)))
        parts.append(Table(heads, rows, f"{test}: second less first" if test else "second less first", (1, 3)))
    reasons = folded("not compared, for {n} reason(s): see .differences", not_compared(differences))
    parts += [*reasons, *remarks_line(remarks)]
    if not shown:
        parts.insert(0, "nothing could be compared")
    return (*parts, *((f"overall: {verdict}",) if verdict else ()))


def is_shown(one: Difference) -> bool:
    """Leave out what says nothing: no value, two equal ones without uncertainty, other ways of reduction alike."""
    if one.no_change is not None or one.word == "different":
        return True
    return not is_beside(one) and (one.word == "not shown different" or bool(one.row.value))


def is_beside(one: Difference) -> bool:
    """Return whether the figure is of another way of reducing the same readings, or of a part of them."""
    return one.row.case.beside


def line(one: Difference, judged: bool) -> list[str]:
    """Return the cells of a figure under ``HEADS``, and ``JUDGED`` where changes are judged."""
    figures = [_figure(row) for row in (one.first, one.second, one.row)]
    cells = [_name(one.row), one.row.axis, *figures, one.row.unit, _interval(one.row, 5), one.word]
    return [*cells, *_verdict(one)] if judged else cells


def _narrow(one: Difference, judged: bool) -> list[str]:
    """Return the difference alone, to fit a notebook and a terminal."""
    row = one.row
    name = f"{_name(row)} {row.axis}".strip()
    return [name, _figure(row), row.unit, _interval(row, 3), *(_verdict(one) if judged else (one.word,))]


def _name(row: Row) -> str:
    return f"{row.quantity} ({case})" if (case := str(row.case)) else row.quantity


def _interval(row: Row, digits: int) -> str:
    ends = row.interval
    return "" if ends is None else f"{number(ends.lo, digits)} .. {number(ends.hi, digits)}"


def _verdict(one: Difference) -> tuple[str, str]:
    if one.no_change is None:
        return "", ""
    return f"± {number(one.no_change.limit_upper, 5)}", one.no_change.status


def _figure(row: Row) -> str:
    return with_uncertainty(row.value, row.u)


def not_compared(differences: Sequence[Difference]) -> list[str]:
    """Return a line a reason why figures were not compared."""
    reasons: dict[str, list[str]] = {}
    for one in differences:
        if one.word == "not compared" and not is_beside(one):
            reasons.setdefault(one.row.reason.text, []).append(f"{one.row.quantity} {one.row.axis}".strip())
    return [f"not compared: {', '.join(dict.fromkeys(names))}: {reason}" for reason, names in reasons.items()]
