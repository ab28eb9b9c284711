"""A model as text: in words, then every coefficient with all its digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...campaign.compare.compare import HEADS, JUDGED, Comparison, is_beside, is_shown, line, not_compared, rule_lines
from ...core.results import key_of
from ...core.show.rounding import number, settled_number
from ...core.show.rows import names_of, reason_text
from ...sensors.flight import Step
from ...sensors.model.sensor_model import SensorModel, show
from .output import clean, table, wrapped
from .summary import remarks_text


def model_text(model: SensorModel, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return what ``show`` prints.

    Parameters
    ----------
    model : SensorModel
        What to show.
    rows : sequence of mapping
        Its parameters, as rows of results.
    """
    heads = ["  name", "value", "u", "unit", "dof", "from"]
    cells = [
        [
            f"  {key_of(row)}",
            repr(row["value"]),
            "-" if row["u"] is None else settled_number(row["u"], 3),
            row["unit"],
            "" if row["u"] is None else "inf" if row["dof"] is None else number(row["dof"], 3),
            "; ".join(text for text in (row["test"], reason_text(row)) if text),
        ]
        for row in rows
    ]
    return f"{show(model)}\n\nCoefficients, all digits\n{table(cells, heads, right=(1, 2))}"


def steps_text(steps: Sequence[Step], axes: Sequence[str]) -> str:
    """Return a calculation step by step: a line a step, its groups with a head."""
    cells: list[list[str]] = []
    for before, one in zip((None, *steps), steps, strict=False):
        if before is None or before.group != one.group:
            cells.append([one.group, *("" for _ in axes), ""])
        cells.append([f"  {one.name}", *(f"{value:.{one.decimals}f}" for value in one.values), one.unit])
    return table(cells, ["", *axes, "unit"], right=range(1, len(axes) + 1))


def comparison_text(found: Comparison) -> str:
    """Return what ``compare`` prints."""
    reasons = [wrapped(f"  {reason}", "    ") for reason in not_compared(found.differences)]
    blocks = [_figures(found), *reasons, *_beside(found)]
    blocks += list(remarks_text([remark.to_dict() for remark in found.remarks]))
    blocks += [wrapped(line) for line in rule_lines(found.rule)]
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
        blocks.append((f"{clean(test)}\n" if test else "") + table(lines, heads))
    return "\n\n".join(blocks) or "nothing could be compared"


def _beside(found: Comparison) -> list[str]:
    left_out = [one.row.case for one in found.differences if is_beside(one) and not is_shown(one)]
    names = names_of(list(dict.fromkeys(left_out)))
    said = f"  left out: {len(left_out)} figures beside the result ({names}); --json has them"
    return [clean(said)] if left_out else []
