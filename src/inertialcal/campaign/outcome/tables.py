"""The outcome of a campaign as tables: figures test by test, a row a requirement, the closed loop, the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ...core.key import Method
from ...core.remarks import Remark
from ...core.results import case_of
from ...core.show.requirement_lines import HEADS, requirement_lines
from ...core.show.result_tables import estimated, figure, folded, not_estimated, remarks_line
from ...core.show.rounding import number, settled_ends
from ...core.show.rows import Changed, changed, names_of, own_rows, pairs_of, quantity_name, verdict_of
from ...core.show.tables import SHORT, Block, Table
from ...procedures import compared_in

UNSCREENED = Method.UNSCREENED.value
VERDICTS = ("PASS", "FAIL", "INCONCLUSIVE", "OPEN")


def outcome_parts(results: Mapping[str, Any], verdict: str, remarks: Sequence[Remark]) -> tuple[Block, ...]:
    """Return what is shown of a run; other ways of reducing the same readings are left out, and counted.

    Parameters
    ----------
    results : mapping
        Content of ``results.json``.
    verdict : str
        Over all requirements.
    remarks : sequence of Remark
        Of the campaign.
    """
    shown = [row for row in results["results"] if not case_of(row).beside]
    parts: list[Block] = [*_at_a_glance(results)]
    many = sum(row["status"] != "not_estimated" for row in shown) > SHORT
    for test in dict.fromkeys(row["test"] for row in shown):
        mine = [row for row in shown if row["test"] == test]
        own = estimated(own_rows(mine, compared_in(mine)), str(test))
        parts += [replace(part, folded=many) if isinstance(part, Table) else part for part in own]
        parts += [*_side_by_side(results, str(test)), *_changes(results, str(test))]
    parts += folded("not estimated, for {n} reason(s): see .results", not_estimated(shown))
    every = (case_of(row) for row in results["results"])
    alternatives = [case for case in every if case.beside and case.method is not Method.UNSCREENED]
    if alternatives:
        parts.append(f"not shown: {len(alternatives)} alternatives to these results ({names_of(alternatives)})")
    parts += [one.what for one in remarks if one.code in (UNSCREENED, f"{UNSCREENED}_refused")]
    parts += [*_requirements(results["verdicts"]), *_closed_loop(results["closed_loop"])]
    return (*parts, *remarks_line(remarks), f"verdict: {verdict or 'no requirement stated'}")


def _at_a_glance(results: Mapping[str, Any]) -> tuple[Block, ...]:
    """Return a row a requirement: as read, compensated, limit, margin, verdict."""
    rows = [one.cells for one in requirement_lines(results)]
    return (Table(("what is asked", *HEADS[1:]), rows, "requirements at a glance"),) if rows else ()


def _side_by_side(results: Mapping[str, Any], test: str) -> tuple[Block, ...]:
    """Return the errors of a test and of the one that it is set beside, a row an axis."""
    mine = [row for row in results["results"] if row["test"] == test]
    compared = compared_in(mine)
    if compared is None:
        return ()
    rows = [
        (axis, *(figure(pair.get(role)) for role in compared.roles.values()), pair["change"]["unit"], verdict_of(pair))
        for (axis, part), pair in pairs_of(mine, compared).items()
        if not part
    ]  # fmt: skip
    other = next((step["against"] for step in results["sequence"] if step["test"] == test), None)
    heads = ("axis", test, str(other), "difference", "nearer to zero by", "unit", "to zero")
    title = f"{test} against {other}: {compared.error.replace('_', ' ')}"
    return (Table(heads, rows, title, (1, 2, 3, 4)),) if rows else ()


CHANGE_HEADS = ("quantity", "axis", "before", "after", "change", "unit", "95 % interval", "allowed", "verdict")


def change_cells(one: Changed[Mapping[str, Any]]) -> list[str]:
    """Return the cells of a change under ``CHANGE_HEADS``."""
    row, ends = one.change, one.change["interval"]
    unit = "x" if one.is_ratio else str(row["unit"])
    own = unit if one.before is None else str(one.before["unit"])
    allowed = "" if one.lower is None or one.upper is None else (
        f"{number(one.lower, 4)} to {number(one.upper, 4)}" if one.is_ratio else f"± {number(one.upper, 4)}"
    )  # fmt: skip
    interval = "" if ends is None else settled_ends(row["value"], row["u"], ends["lo"], ends["hi"])
    name = quantity_name(row) + (f" [{own}]" if one.is_ratio else "")
    axis = f"{row['sensor']} {row['axis']}".strip()
    return [name, axis, figure(one.before), figure(one.after), figure(row), unit, interval, allowed, one.verdict]


def _changes(results: Mapping[str, Any], test: str) -> tuple[Block, ...]:
    """Return what each figure changed by since the test that this one is set against."""
    other = next((step["against"] for step in results["sequence"] if step["test"] == test), None)
    found = [] if other is None else changed(results["results"], results["verdicts"], test, str(other))
    rows = [change_cells(one) for one in found]
    return (Table(CHANGE_HEADS, rows, f"{test} against {other}: changes", (2, 3, 4)),) if rows else ()


def _requirements(verdicts: Sequence[Mapping[str, Any]]) -> tuple[Block, ...]:
    """How many places of each requirement passed, failed and were left open, by test and axis."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for one in verdicts:
        axis = f"{one['sensor']} {one['axis']}".strip()
        groups.setdefault((one["requirement"], one["test"], axis), []).append(one["verdict"])
    rows = [(*key, *(str(found.count(word)) for word in VERDICTS)) for key, found in groups.items()]
    heads = ("requirement", "test", "axis", *VERDICTS)
    return (Table(heads, rows, "requirements: places judged", (3, 4, 5, 6)),) if rows else ()


def _closed_loop(loop: Mapping[str, Any]) -> tuple[Block, ...]:
    said = f"closed loop, on readings held out: {loop['verdict']}"
    if not loop["axes"]:
        return (f"{said} ({loop['reason']})",)
    several = len({one["condition"] for one in loop["axes"]}) > 1
    rows = [
        (
            f"{one['axis']}, {one['condition']}" if several else one["axis"],
            number(one["raw_rms"], 3),
            number(one["compensated_rms"], 3),
            one["unit"],
            one["verdict"],
        )
        for one in loop["axes"]
    ]
    heads = ("rms error", "compensated", "unit", "verdict")
    warm = [
        (one["test"], one["axis"], number(one["raw_rms"], 3), number(one["compensated_rms"], 3), one["unit"],
         one["verdict"])
        for one in loop.get("over_temperature", ())
    ]  # fmt: skip
    over = Table(("test", "axis", *heads), warm, "bias over temperature, on power-ups held out", (2, 3))
    return (Table(("axis", *heads), rows, said, (1, 2)), *((over,) if warm else ()))
