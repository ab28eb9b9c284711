"""A comparison as text: a line a figure, reasons where there is no verdict, remarks, the overall verdict."""

from __future__ import annotations

from ...campaign.compare.compare import Comparison
from ...campaign.compare.tables import HEADS, JUDGED, is_beside, is_shown, line, not_compared
from ...core.show.alternatives import names_of
from .output import table, wrapped
from .summary import remarks_text


def comparison_text(found: Comparison) -> str:
    """Return what ``compare`` prints."""
    reasons = [wrapped(f"  {reason}", "    ") for reason in not_compared(found.differences)]
    blocks = [_figures(found), *reasons, *_beside(found)]
    blocks += list(remarks_text([remark.to_dict() for remark in found.remarks]))
    if found.verdict:
        blocks.append(f"overall: {found.verdict}")
    return "\n".join(block for block in blocks if block)


def _figures(found: Comparison) -> str:
    """One block a test."""
    compared = [one for one in found.differences if is_shown(one)]
    judged = any(one.no_change is not None for one in compared)
    blocks = []
    for test in dict.fromkeys(one.row.test for one in compared) if found.kind == "results" else [None]:
        lines = [line(one, judged) for one in compared if test is None or one.row.test == test]
        lines = [[f"  {name}", *cells] for name, *cells in lines]
        heads = [f"  {HEADS[0]}", *HEADS[1:], *(JUDGED if judged else ())]
        blocks.append((f"{test}\n" if test else "") + table(lines, heads))
    return "\n\n".join(blocks) or "nothing could be compared"


def _beside(found: Comparison) -> list[str]:
    left_out = [one.row.case for one in found.differences if is_beside(one) and not is_shown(one)]
    names = names_of(list(dict.fromkeys(left_out)))
    return [f"  left out: {len(left_out)} figures beside the result ({names}); --json has them"] if left_out else []
