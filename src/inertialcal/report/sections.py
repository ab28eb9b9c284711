"""What the sections of the page hold: rows of results grouped as people read them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ..core.key import PLAIN, Case, Key
from ..core.remarks import is_placed
from ..core.results import case_of, key_of
from ..core.show.rows import Changed, changed, columns_of, lines_of, missing_of, own_rows, pairs_of
from ..core.show.wording import SEVERITIES
from ..procedures import compared_in
from .findings import Finding, of_test
from .numbers import Branch, Text

MODEL = "model"
FEW, SLACK = 10, 2  # lines of a list that stand open; that a few more do too
MANY = 1e5  # degrees of freedom that make no difference to infinitely many


@dataclass(frozen=True)
class Line:
    """One quantity of one axis: its row, and the alternatives to it by their case."""

    quantity: str
    case: str
    axis: str
    unit: str
    row: Branch | None
    alternatives: dict[Case, Branch]


@dataclass(frozen=True)
class Section:
    """One test, or the estimates of the model."""

    test: str  # identifier
    anchor: str  # id on the page
    step: Branch | None  # its row of the sequence
    finding: Finding  # its title
    lines: list[Line]  # estimated quantities
    ways: list[Case]  # alternatives to the result: other methods, single flips
    alone: Sequence[tuple[Case, str]]  # recordings reduced on their own, with their names
    missing: list[tuple[str, list[Branch]]]  # quantities that could not be estimated, by reason
    remarks: list[Branch]  # remarks on this test
    # comparison with another test: both errors and their difference, by axis and part of the readings
    pairs: dict[tuple[str, str], dict[str, Branch]]
    pairs_caption: str  # title of their table
    changes: list[Changed[Branch]]  # what figures changed by since that test

    @property
    def together(self) -> list[Line]:
        """Lines of the whole test; what only single records have stands in the table of these."""
        return [
            line for line in self.lines if line.row is not None or not line.alternatives.keys().isdisjoint(self.ways)
        ]

    @property
    def first_lines(self) -> list[Line]:
        """The ten lines that matter most: of the whole test before those of a part or condition of it."""
        return self._ordered[:FEW] if len(self.together) > FEW + SLACK else self.together

    @property
    def more_lines(self) -> list[Line]:
        """The other lines."""
        return self._ordered[len(self.first_lines) :]

    @property
    def _ordered(self) -> list[Line]:
        return sorted(self.together, key=lambda line: (line.row is None, bool(line.case)))


def anchor(kind: str, name: str, number: int) -> str:
    """Return an id: the name as far as an id can hold it, and a number that keeps it apart."""
    kept = re.sub(r"[^A-Za-z0-9_-]+", "-", name)[:40].strip("-")
    return f"{kind}-{kept}" if kept == name else f"{kind}-{kept}-{number}".replace("--", "-")


def sections(
    rows: Sequence[Branch], sequence: Sequence[Branch], verdicts: Sequence[Branch], remarks: Sequence[Branch]
) -> list[Section]:
    """Return a section a test, in the order run.

    Parameters
    ----------
    rows, sequence, verdicts, remarks : sequence of Branch
        Of results.json.
    """
    steps = {step["test"]: step for step in sequence}
    tests = [*steps, *(t for t in dict.fromkeys(row["test"] for row in rows) if t not in steps and t != MODEL)]
    found = []
    for number, test in enumerate(tests):
        mine = [row for row in rows if row["test"] == test]
        judged = [one for one in verdicts if one["test"] == test]
        compared = compared_in(mine)
        lines, every = table(own_rows(mine, compared))
        runs = {way: part for way in every if (part := way.member) is not None and part.kind == "run"}
        alone = [(way, Text(part.label)) for way, part in runs.items()]
        ways = [way for way in every if way not in runs]
        step = steps.get(test)
        finding = of_test("" if step is None else str(step["procedure"]), mine, judged)
        found.append(
            Section(
                test, anchor("test", test, number), step, finding, lines, ways, alone,
                missing(mine), placed(remarks, test), pairs_of(mine, compared),
                "" if compared is None else compared.caption,
                [] if step is None or not step["against"] else changed(rows, verdicts, test, str(step["against"])),
            )
        )  # fmt: skip
    return found


def table(rows: Iterable[Branch]) -> tuple[list[Line], list[Case]]:
    """Return the estimated rows, a line a quantity and axis, and the alternatives that have a column."""
    groups = lines_of(rows)
    shown, left = columns_of(groups)
    lines = [
        Line(
            Text(quantity),
            Text(case),
            Text(axis),
            Text(unit),
            found.get(PLAIN),
            {way: row for way, row in found.items() if way != PLAIN},
        )
        for (quantity, case, axis, unit), found in groups.items()
    ]
    return lines, [*shown, *left]


def missing(rows: Iterable[Branch]) -> list[tuple[str, list[Branch]]]:
    """Return the rows that the data could not carry, by their reason."""
    return [(Text(reason), found) for reason, found in missing_of(rows).items()]


def budgeted(rows: Iterable[Branch]) -> dict[tuple[str, Key], Branch]:
    """Return the rows that budgets add up to, by test and key."""
    return {
        (row["test"], key_of(row)): row
        for row in rows
        if case_of(row).plain and row["status"] == "estimated" and row["u"] is not None
    }


def placed(remarks: Iterable[Branch], test: str) -> list[Branch]:
    """Return the remarks of a test, the serious ones first."""
    mine = [one for one in remarks if is_placed(one["where"], test)]
    return by_severity(mine)


def by_severity(remarks: Iterable[Branch]) -> list[Branch]:
    """Return remarks, the serious ones first."""
    return sorted(remarks, key=lambda one: SEVERITIES.index(one["severity"]))


def by_key(rows: Iterable[Branch]) -> list[tuple[Key, list[Branch]]]:
    """Return rows by what they are of, in order of first appearance."""
    groups: dict[Key, list[Branch]] = {}
    for row in rows:
        groups.setdefault(key_of(row), []).append(row)
    return list(groups.items())


def grouped(rows: Iterable[Branch], *keys: str) -> list[tuple[tuple[str, ...], list[Branch]]]:
    """Return rows by the values of some keys, in order of first appearance."""
    groups: dict[tuple[str, ...], list[Branch]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return list(groups.items())
