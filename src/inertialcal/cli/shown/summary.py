"""A campaign's results as text for a terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...campaign.outcome.tables import CHANGE_HEADS, change_cells
from ...core.key import PLAIN, Method
from ...core.remarks import Remark
from ...core.show.requirement_lines import HEADS, requirement_lines
from ...core.show.result_tables import degrees, figure, figure_beside, interval, not_estimated
from ...core.show.rounding import items, number
from ...core.show.rows import (
    Compared,
    case_words,
    changed,
    columns_of,
    lines_of,
    missing_of,
    names_of,
    own_rows,
    pairs_of,
    reason_code,
    reason_text,
    verdict_of,
)
from ...core.show.tables import PROSE_WIDTH
from ...procedures import compared_in
from .. import figures
from .output import clean, cleaned, json_out, short, table, terminal_width, wrapped
from .screen import folded, folds, say, screen

if TYPE_CHECKING:
    from ...campaign.outcome.budget import Budgets
    from ...campaign.outcome.results_file import ResultsFile
    from ...core.results import WrittenRow
    from ...core.show.output_tables import OutputTable


NARROWEST = 24  # columns of a requirement's words beside columns that are not folded
MISSING = 6  # rows of reasons why figures were not estimated, on a terminal


def results_text(results: Mapping[str, Any]) -> str:
    """Return the figures of a campaign, test by test, each result with what stands beside it."""
    return screen(results_parts(results))


def results_parts(results: Mapping[str, Any]) -> list[str]:
    """Return the figures of a campaign, and on a terminal apart from them how many were not estimated."""
    results, blocks = cleaned({name: results.get(name, []) for name in ("results", "sequence", "verdicts")}), []
    tests = list(dict.fromkeys(row["test"] for row in results["results"]))
    against = {step["test"]: step.get("against") for step in results["sequence"]}
    for test in tests:
        rows = [row for row in results["results"] if row["test"] == test]
        compared = compared_in(rows)
        own = own_rows(rows, compared)
        blocks.append(f"{test}\n{_estimated(own)}")
        missing = "\n".join(part for part in (_in_doubt(own), "" if folds() else _not_estimated(rows)) if part)
        if missing:
            blocks[-1] += f"\n{missing}"
        if compared is not None:
            blocks[-1] += _side_by_side(rows, compared, test, str(against.get(test) or "the other"))
        blocks[-1] += _changes(results, test, against.get(test))
    counted = _missing_counted(results["results"]) if folds() else ""
    return ["\n\n".join(blocks), counted]


def _missing_counted(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return how many figures were not estimated, a line a reason: the commonest first."""
    counts = sorted(((len(found), reason) for reason, found in missing_of(rows).items()), key=lambda one: -one[0])
    lines = [f"  not estimated: {items(n, 'figure')}: {clean(reason)}" for n, reason in counts]
    return folded("\n".join(short(line, terminal_width()) for line in lines), MISSING)


def _estimated(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return a line a quantity: the result, then its alternatives: other methods and single parts."""
    lines = lines_of(rows)
    shown, left = columns_of(lines)
    cells = [
        [f"  {f'{quantity} ({case})' if case else quantity}", axis, figure(ways.get(PLAIN)), unit,
         interval(ways.get(PLAIN)), degrees(ways.get(PLAIN)),
         *(figure_beside(ways.get(way), ways.get(PLAIN)) for way in shown)]
        for (quantity, case, axis, unit), ways in lines.items()
        if not ways.keys() <= set(left)
    ]  # fmt: skip
    heads = ["  quantity", "axis", "value ± u", "unit", "95 % interval", "dof"]
    found = table(cells, [*heads, *(case_words(way) for way in shown)])
    if not left:
        return found
    count = sum(way in left for ways in lines.values() for way in ways)
    more = wrapped(f"  not shown: {count} alternatives to these results ({names_of(left)}); see --json", "    ")
    return f"{found}\n{more}"


def _in_doubt(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return a line a reason why figures of axes may not hold."""
    axes: dict[str, dict[str, None]] = {}
    for row in rows:
        opened = row["method"] == Method.UNSCREENED
        if row["status"] == "estimated" and reason_code(row) == "in_doubt" and not opened:
            axes.setdefault(reason_text(row), {})[row["axis"]] = None
    return "\n".join(wrapped(f"  {reason} ({', '.join(found)})", "    ") for reason, found in axes.items())


def _not_estimated(rows: Sequence[Mapping[str, Any]]) -> str:
    return "\n".join(wrapped(f"  {line}", "    ") for line in not_estimated(rows))


def _side_by_side(rows: Sequence[Mapping[str, Any]], compared: Compared, test: str, other: str) -> str:
    """One line an axis: both errors, and which of them is nearer to zero."""
    cells = [
        [f"  {axis}", figure(pair.get("error")), figure(pair.get("other")), figure(pair["change"]),
         interval(pair["change"]), figure(pair.get("reduction")), interval(pair.get("reduction")),
         pair["change"]["unit"], verdict_of(pair)]
        for (axis, part), pair in pairs_of(rows, compared).items()
        if not part
    ]  # fmt: skip
    heads = ["  axis", test, other, "difference", "95 % interval", "nearer to 0 by", "95 % interval", "unit", "to 0"]
    return f"\n{wrapped(f'  side by side: {compared.title}', '    ')}\n{table(cells, heads)}" if cells else ""


def _changes(results: Mapping[str, Any], test: str, other: str | None) -> str:
    """One line a figure: before, after, what it changed by."""
    found = [] if other is None else changed(results["results"], results["verdicts"], test, other)
    if not found:
        return ""
    cells = [[f"  {name}", *rest] for name, *rest in (change_cells(one) for one in found)]
    return f"\n  changes since {clean(str(other))}\n{table(cells, [f'  {CHANGE_HEADS[0]}', *CHANGE_HEADS[1:]])}"


def verdicts_part(results: Mapping[str, Any]) -> str:
    """Return the requirements one by one, under the rule that they are decided by."""
    rule = wrapped(f"requirements ({results['decision_rule']})")
    return f"{rule}\n{verdicts_text(results)}"


def verdicts_text(results: Mapping[str, Any]) -> str:
    """Return one line a requirement, test and axis: where it holds and where not."""
    lines = []
    groups: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
    for verdict in cleaned(results["verdicts"]):
        axis = f"{verdict['sensor']} {verdict['axis']}".strip()
        groups.setdefault((verdict["requirement"], verdict["test"], axis), []).append(verdict)
    for (requirement, test, axis), verdicts in groups.items():
        lines.append([f"  {requirement}", test, axis, *_counts(verdicts)])
    shown = table(lines, ["  requirement", "test", "axis", "verdict", "where"])
    own: dict[str, list[str]] = {}
    for name, rule in {one["requirement"]: one["rule"] for one in results["verdicts"]}.items():
        if rule != results["decision_rule"]:
            own.setdefault(rule, []).append(clean(name))
    whose = {rule: "its own rule" if len(names) == 1 else "their own rule" for rule, names in own.items()}
    rules = [wrapped(f"  {', '.join(own[rule])} by {one}: {clean(rule)}", "    ") for rule, one in whose.items()]
    return "\n".join([shown, *rules])


def requirement_table(results: Mapping[str, Any]) -> str:
    """Return a line a requirement, raw and compensated: what was asked for, what was found, and the verdict on all.

    Where no line says why the verdict on all is INCONCLUSIVE, a last one names the error that leaves it open.
    """
    cells = [list(cleaned(one.cells)) for one in requirement_lines(results)]
    if not cells:
        return ""
    last, errors = f"overall: {results['verdict']}", [one for one in results["remarks"] if one["severity"] == "error"]
    if errors and results["verdict"] not in {word for *_, word in cells}:
        last += "\n" + wrapped(f"  in doubt: {clean(errors[0]['what'])}", "    ")
    heads = list(HEADS)
    rest = sum(2 + max(len(row[i]) for row in [heads, *cells]) for i in range(1, len(heads)))
    if (least := rest + NARROWEST) <= terminal_width():
        room = max(min(terminal_width(), PROSE_WIDTH), least) - rest
        whole, cells = cells, []
        for name, *others in whole:
            first, *more = textwrap.wrap(name, room, subsequent_indent="  ") or [""]
            cells += [[first, *others], *([line, *("" for _ in others)] for line in more)]
    else:  # every column is folded; of those that find no room beside each other, the margin is the last
        for row in (heads, *cells):
            row[-2:] = reversed(row[-2:])
    return f"{table(cells, heads)}\n{last}"


def _counts(verdicts: Sequence[Mapping[str, Any]]) -> tuple[str, str]:
    found = {one["verdict"] for one in verdicts}
    word = next(w for w in ("FAIL", "INCONCLUSIVE", "OPEN", "PASS") if w in found)
    parts = []
    for name in ("PASS", "FAIL", "INCONCLUSIVE", "OPEN"):
        at = [one for one in verdicts if one["verdict"] == name]
        rated = [one for one in at if one["at"] is not None]
        if rated:
            parts.append(f"{name} at {_rates(rated)}")
        parts += [f"{one['reason']}{_decided(one)}" for one in at if one["at"] is None]
    return word, "; ".join(part for part in parts if part)


def _decided(verdict: Mapping[str, Any]) -> str:
    """Return what PASSes, the risk and the test uncertainty ratio of a figure, in brackets."""
    low, high, risk, ratio = (verdict[name] for name in ("accept_lower", "accept_upper", "risk", "ratio"))
    parts = []
    if low is not None or high is not None:
        ends = f"{number(low, 4)} to {number(high, 4)}" if None not in (low, high) else ""
        ends = ends or (f"up to {number(high, 4)}" if low is None else f"from {number(low, 4)}")
        parts.append(f"PASS {ends} {'' if verdict['unit'] == '1' else verdict['unit']}".strip())
    if risk is not None:
        size = "< 0.01 %" if risk < 1e-4 else f"{100.0 * risk:.2g} %"
        parts.append(f"false {'accept' if verdict['verdict'] == 'PASS' else 'reject'} {size}")
    if ratio is not None:
        parts.append(f"TUR {number(ratio, 2)}:1")
    return f" ({', '.join(parts)})" if parts else ""


def _rates(verdicts: Sequence[Mapping[str, Any]]) -> str:
    unit = verdicts[0]["at_unit"]
    rates = sorted((one["at"] for one in verdicts), key=lambda rate: (0.0 if unit == "degC" else abs(rate), rate))
    if len(rates) <= 6:
        return f"{', '.join(f'{rate:+g}' for rate in rates)} {unit}"
    if unit == "degC":
        return f"{len(rates)} temperatures, {min(rates):g} to {max(rates):g} {unit}"
    return f"{len(rates)} rates, |rate| {abs(rates[0]):g} to {abs(rates[-1]):g} {unit}"


def budgets_text(budgets: Budgets) -> str:
    """Return the sources of uncertainty test by test, then what must improve."""
    blocks = []
    for one in budgets.tables:
        rows = [[f"  {name}", *rest] for name, *rest in one.rows]
        heads = [f"  {one.heads[0]}", *one.heads[1:]]
        blocks.append(f"{wrapped(one.caption)}\n{table(cleaned(rows), heads, right=one.right)}")
    if budgets.said:
        blocks.append("\n".join(wrapped(clean(line), "  ") for line in budgets.said))
    return "\n\n".join(blocks)


def closed_loop_text(results: Mapping[str, Any]) -> str:
    """Return one line an axis: error before and after compensation, on readings held out."""
    loop = cleaned(results["closed_loop"])
    over = list(_over_temperature_text(loop.get("over_temperature", ())))
    if not loop["axes"]:
        reason = f" ({loop['reason']})" if loop["reason"] else ""
        return "\n".join([wrapped(f"closed loop: {loop['verdict']}{reason}"), *over])
    several = len({one["condition"] for one in loop["axes"]}) > 1
    rows = [
        [
            f"  {one['axis']}" + (f", {one['condition']}" if several else ""), number(one["raw_rms"], 3),
            number(one["compensated_rms"], 3), one["unit"], f"{one['dwells']}", f"{one['runs']}",
            one["verdict"], one["reason"],
        ]
        for one in loop["axes"]
    ]  # fmt: skip
    heads = ["  axis", "rms error", "compensated", "unit", "dwells", "runs", "verdict", ""]
    said = f"closed loop, on readings held out: {loop['verdict']}\n{table(rows, heads)}"
    return "\n".join([said, *over])


def _over_temperature_text(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield one line an axis of each thermal test held out: bias before and after its polynomial is taken off."""
    cells = [
        [
            f"  {one['axis']}", one["test"], number(one["raw_rms"], 3), number(one["compensated_rms"], 3), one["unit"],
            f"{one['runs']}", one["verdict"], one["reason"],
        ]
        for one in rows
    ]  # fmt: skip
    if cells:
        yield "  bias over temperature, on power-ups held out"
        yield table(cells, ["  axis", "test", "rms bias", "compensated", "unit", "runs", "verdict", ""])


def remarks_part(remarks: Sequence[Mapping[str, Any]]) -> str:
    """Return the remarks of a run under a head; those to know, not to act on, are counted on a terminal."""
    pressing = [one for one in remarks if one["severity"] != "info"] if folds() else remarks
    lines = [*remarks_text(pressing, "  ")]
    rest = len(remarks) - len(pressing)
    lines += [f"  ... {rest} more {'note' if rest == 1 else 'notes'}: --all"] if rest else []
    return "\n".join(["remarks", *lines]) if lines else ""


def remarks_text(remarks: Sequence[Mapping[str, Any]], indent: str = "") -> Iterator[str]:
    """Yield each remark as text, the serious ones first."""
    order = {"error": 0, "warning": 1, "info": 2}
    for remark in sorted(remarks, key=lambda one: order[str(one["severity"])]):
        yield wrapped(f"{indent}{Remark(**remark)}", "    ")


def print_reduced(
    columns: Mapping[str, str],
    rows: Sequence[Mapping[str, Any]],
    remarks: Sequence[Mapping[str, Any]],
    line: str = "",
    found: str = "",
) -> None:
    """Print which channel was what, what was found in it, the figures, what there is to say, and what was written."""
    print(wrapped("columns: " + ", ".join(f"{what} = {clean(name)}" for what, name in columns.items())))
    if found:
        print(wrapped(found))
    say("\n".join([results_text({"results": rows}), *remarks_text(remarks), *([line] if line else [])]))


def show_results(
    found: ResultsFile,
    edited: Sequence[Remark],
    output: Path | None,
    chosen: dict[str, str | None],
    as_json: bool,
    quiet: bool,
) -> int:
    """Print the results, and which files beside them were edited, or draw one figure of them.

    Raises
    ------
    DataError
        If the file does not hold what a run writes, or has no data for the figure.
    """
    from ...campaign.outcome.results_file import as_results

    with as_results(found.path):
        line = "" if output is None else figures.write(output, found.content, [found.path], chosen)
        if as_json:
            remarks = [*(remark.to_dict() for remark in edited), *found.content.get("remarks", [])]
            more = {"remarks": remarks} | ({} if output is None else {"written": str(output)})
            inputs = [{"path": found.path, "sha256": found.sha256}]
            json_out("show", {"inputs": inputs} | found.content | more)
        elif not quiet:
            for text in remarks_text([remark.to_dict() for remark in edited]):
                print(text)
            say(line or _text(found))
    return 0


def _text(found: ResultsFile) -> str:
    content = found.content
    parts = results_parts(content)
    if content.get("closed_loop"):
        parts.append(closed_loop_text(content))
    if content.get("verdicts"):
        parts.append(verdicts_part(content))
    return screen(parts)


def tables_text(tables: Sequence[OutputTable[WrittenRow]]) -> str:
    """Return the tables of a suite: a line a figure, a column a sensor, and why figures are not estimated."""
    blocks = []
    for one in tables:
        cells: list[list[str]] = []
        group = ""
        for line in one.lines:
            if line.group != group:
                group = line.group
                cells.append([f"  {group}", *("" for _ in one.axes), ""])
            taken = f"  taken from {', '.join(dict.fromkeys(line.taken.values()))}" if line.taken else ""
            cells.append([f"    {line.name}", *(_output_cell(line.rows[axis]) for axis in one.axes), line.unit + taken])
        title = f"{one.title}, condition {one.condition}" if one.condition else one.title
        told = [wrapped(f"  {', '.join(names)}: {text}", "    ") for text, names in one.reasons]
        right = range(1, len(one.axes) + 1)
        blocks.append("\n".join([wrapped(title), table(cleaned(cells), ["", *one.axes, "unit"], right=right), *told]))
    return "\n\n".join(blocks)


def _output_cell(row: WrittenRow) -> str:
    if row["status"] == "not_estimated" and row["value"] is None:
        return "not estimated"
    return figure(row)
