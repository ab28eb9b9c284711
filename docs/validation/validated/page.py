"""The page: tables of what was found, those first that matter most, and where the tool is worse."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .found import Cell, Line, Part, Table

HEAD = """# Validation: truth that is not ours

What the tool gives, beside what others found in the same data: recordings with the results of their makers, reference
data of NIST, the programs of the field, and simulators that share nothing with the estimators. One command makes this
page anew, in a clone; with a name it renews a part:

    make validation
    make validation PARTS=noise

The recordings are those of others and are not part of the package: name their folder in `INERTIALCAL_SHARED`. A part
whose data or peers are absent is left as it was found. **Bold** is what does not hold what is asked of its line.
Figures are kept as data in `docs/validation/found.json`, with the day on which they were found;
version 0.1.0 is the tree before the first release.
"""

ELSEWHERE = """## Elsewhere

| what | where |
|---|---|
| printed figures of the three documents behind the tool, computed again | [source audit](source_audit.md) |
| faults put into clean data: how many are named | [what it checks](gate.md) |
| coverage of each simulated rig at n = 1,000 | [score](commands/score.md#every-rig) |
| speed beside named peers | [speed](speed.md) |
| files damaged at random | [what it survives](robustness.md) |
"""


def shown(cell: Cell, digits: int) -> str:
    """Return a cell as text: a number of significant digits, or as it is."""
    if cell is None:
        return ""
    if isinstance(cell, float) and digits:
        return f"{cell:.{digits}g}" if cell == 0.0 or 1e-3 <= abs(cell) < 1e7 else f"{cell:.{max(digits - 1, 0)}e}"
    return str(cell).replace("|", "\\|")


def _row(line: Line, table: Table) -> str:
    cells = [shown(cell, digits) for cell, digits in zip(line.cells, table.digits, strict=True)]
    return "| " + " | ".join(cell if line.holds or not cell else f"**{cell}**" for cell in cells) + " |"


def _table(table: Table) -> str:
    rows = [
        f"| {' | '.join(table.heads)} |",
        "|" + "---|" * len(table.heads),
        *(_row(one, table) for one in table.lines),
    ]
    held, judged = table.counted
    said = f" {held} of {judged} lines hold." if judged else ""
    return f"## {table.title}\n\n{table.text}{said}\n\n" + "\n".join(rows) + "\n"


def _dated(found: Mapping[str, Part]) -> Iterable[str]:
    yield "| part | found on | by version | lines that hold |\n|---|---|---|---|"
    for name, part in found.items():
        held, judged = (sum(one.counted[i] for one in part.tables) for i in (0, 1))
        yield f"| `{name}` | {part.day} | {part.version} | {f'{held} of {judged}' if judged else ''} |"


def page(found: Mapping[str, Part]) -> str:
    """Return the page."""
    order = [name for name in ("recordings", "least_squares", "noise", "peers", "coverage", "slower") if name in found]
    parts = {name: found[name] for name in order}
    tables = [_table(one) for part in parts.values() for one in part.tables]
    return "\n".join([HEAD, "\n".join(_dated(parts)) + "\n", *tables, ELSEWHERE])
