"""A comparison as text: a line a figure, reasons where there is no verdict, remarks, the overall verdict."""

from __future__ import annotations

from ..campaign.compare import BESIDE, Comparison
from ..campaign.differences import Difference
from ..core.results import Row
from ..core.rounding import number, with_uncertainty
from .output import table, wrapped
from .summary import remarks_text

HEADS = ["  quantity", "axis", "first", "second", "difference", "unit", "95 % interval", "verdict"]


def comparison_text(found: Comparison) -> str:
    """Return what ``compare`` prints."""
    blocks = [_figures(found), *_not_compared(found), *_beside(found)]
    blocks += list(remarks_text([remark.to_dict() for remark in found.remarks]))
    if found.verdict:
        blocks.append(f"overall: {found.verdict}")
    return "\n".join(block for block in blocks if block)


def _figures(found: Comparison) -> str:
    """One block a test."""
    compared = [one for one in found.differences if _is_shown(one)]
    judged = any(one.no_change is not None for one in compared)
    blocks = []
    for test in dict.fromkeys(one.row.test for one in compared) if found.kind == "results" else [None]:
        lines = [_line(one, judged) for one in compared if test is None or one.row.test == test]
        heads = [*HEADS, "allowed", "no change"] if judged else HEADS
        blocks.append((f"{test}\n" if test else "") + table(lines, heads))
    return "\n\n".join(blocks) or "nothing could be compared"


def _is_shown(one: Difference) -> bool:
    """Leave out what says nothing: no value, two equal ones without uncertainty, other ways of reduction alike."""
    if one.no_change is not None or one.word == "different":
        return True
    return not _is_beside(one) and (one.word == "not shown different" or bool(one.row.value))


def _is_beside(one: Difference) -> bool:
    return one.row.condition in BESIDE


def _beside(found: Comparison) -> list[str]:
    left_out = sum(1 for one in found.differences if _is_beside(one) and not _is_shown(one))
    names = ", ".join(BESIDE)
    return [f"  left out: {left_out} figures of other ways of reduction ({names}); --json has them"] if left_out else []


def _line(one: Difference, judged: bool) -> list[str]:
    row = one.row
    name = f"{row.quantity} ({row.condition})" if row.condition else row.quantity
    interval = row.interval
    cells = [
        f"  {name}",
        row.axis,
        _figure(one.first),
        _figure(one.second),
        _figure(row),
        row.unit,
        "" if interval is None else f"{number(interval.lo, 5)} .. {number(interval.hi, 5)}",
        one.word,
    ]
    return [*cells, *_verdict(one)] if judged else cells


def _verdict(one: Difference) -> tuple[str, str]:
    if one.no_change is None:
        return "", ""
    return f"± {number(one.no_change.limit_upper, 5)}", one.no_change.status


def _figure(row: Row) -> str:
    return with_uncertainty(row.value, row.u)


def _not_compared(found: Comparison) -> list[str]:
    reasons: dict[str, list[str]] = {}
    for one in found.differences:
        if one.word == "not compared" and not _is_beside(one):
            reasons.setdefault(one.row.reason, []).append(f"{one.row.quantity} {one.row.axis}".strip())
    return [
        wrapped(f"  not compared: {', '.join(dict.fromkeys(names))}: {reason}", "    ")
        for reason, names in reasons.items()
    ]
