"""A campaign's results as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..core.remarks import Remark
from ..core.result_tables import degrees, figure, interval
from ..core.rounding import number
from .output import table, wrapped

PUBLISHED = "as_published"
ALL = "all_readings"


def results_text(results: Mapping[str, Any]) -> str:
    """Return the figures of a campaign, test by test, the default beside the published and the unpruned ones."""
    blocks = []
    tests = list(dict.fromkeys(row["test"] for row in results["results"]))
    for test in tests:
        rows = [row for row in results["results"] if row["test"] == test]
        blocks.append(f"{test}\n{_estimated(rows)}")
        missing = _not_estimated(rows)
        if missing:
            blocks[-1] += f"\n{missing}"
    return "\n\n".join(blocks)


def _estimated(rows: Sequence[Mapping[str, Any]]) -> str:
    """One line a quantity: the default estimate, and beside it the other ways of reduction."""
    shown = [row for row in rows if row["status"] != "not_estimated"]
    beside = [name for name in (ALL, PUBLISHED) if any(row["condition"] == name for row in shown)]
    groups: dict[tuple[str, str, str], dict[str, Mapping[str, Any]]] = {}
    for row in shown:
        way = row["condition"] if row["condition"] in beside else ""
        name = row["quantity"] if way or not row["condition"] else f"{row['quantity']} ({row['condition']})"
        groups.setdefault((name, row["axis"], row["unit"]), {})[way] = row
    cells = [
        [f"  {name}", axis, figure(ways.get("")), unit, interval(ways.get("")), degrees(ways.get("")),
         *(figure(ways.get(way)) for way in beside)]
        for (name, axis, unit), ways in groups.items()
    ]  # fmt: skip
    heads = [
        "  quantity",
        "axis",
        "value ± u",
        "unit",
        "95 % interval",
        "dof",
        *(way.replace("_", " ") for way in beside),
    ]
    return table(cells, heads)


def _not_estimated(rows: Sequence[Mapping[str, Any]]) -> str:
    reasons: dict[str, list[str]] = {}
    for row in rows:
        if row["status"] == "not_estimated" and row["condition"] != "all_readings":
            known = "" if row["value"] is None else f" ({number(row['value'], 3)} {row['unit']})"
            reasons.setdefault(row["reason"], []).append(f"{row['quantity']} {row['axis']}{known}")
    return "\n".join(f"  not estimated: {', '.join(names)}: {reason}" for reason, names in reasons.items())


def verdicts_text(results: Mapping[str, Any]) -> str:
    """Return one line a requirement, test and axis: where it holds and where not."""
    lines = []
    groups: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
    for verdict in results["verdicts"]:
        groups.setdefault((verdict["requirement"], verdict["test"], verdict["axis"]), []).append(verdict)
    for (requirement, test, axis), verdicts in groups.items():
        lines.append([f"  {requirement}", test, axis, *_counts(verdicts)])
    return table(lines, ["  requirement", "test", "axis", "verdict", "where"])


def _counts(verdicts: Sequence[Mapping[str, Any]]) -> tuple[str, str]:
    found = {one["verdict"] for one in verdicts}
    word = next(w for w in ("FAIL", "INCONCLUSIVE", "OPEN", "PASS") if w in found)
    parts = []
    for name in ("PASS", "FAIL", "INCONCLUSIVE", "OPEN"):
        at = [one for one in verdicts if one["verdict"] == name]
        rated = [one for one in at if one["at"] is not None]
        if rated:
            parts.append(f"{name} at {_rates(rated)}")
        parts += [one["reason"] for one in at if one["at"] is None]
    return word, "; ".join(part for part in parts if part)


def _rates(verdicts: Sequence[Mapping[str, Any]]) -> str:
    rates = sorted((one["at"] for one in verdicts), key=lambda rate: (abs(rate), rate))
    unit = verdicts[0]["at_unit"]
    if len(rates) <= 6:
        return f"{', '.join(f'{rate:+g}' for rate in rates)} {unit}"
    return f"{len(rates)} rates, |rate| {abs(rates[0]):g} to {abs(rates[-1]):g} {unit}"


def closed_loop_text(results: Mapping[str, Any]) -> str:
    """Return one line an axis: error before and after compensation, on readings held out."""
    loop = results["closed_loop"]
    if not loop["axes"]:
        return f"closed loop: {loop['verdict']} ({loop['reason']})"
    rows = [
        [
            f"  {one['axis']}", number(one["raw_rms"], 3), number(one["compensated_rms"], 3), one["unit"],
            f"{one['dwells']}", f"{one['runs']}", one["verdict"], one["reason"],
        ]
        for one in loop["axes"]
    ]  # fmt: skip
    heads = ["  axis", "rms error", "compensated", "unit", "dwells", "runs", "verdict", ""]
    return f"closed loop, on readings held out: {loop['verdict']}\n{table(rows, heads)}"


def remarks_text(remarks: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield each remark as text, the serious ones first."""
    order = {"error": 0, "warning": 1, "info": 2}
    for remark in sorted(remarks, key=lambda one: order[str(one["severity"])]):
        yield wrapped(str(Remark(**remark)), "    ")
