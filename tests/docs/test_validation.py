"""The page of the validation is made of what was found, what was found is found again, and a false line shows."""

from __future__ import annotations

import importlib
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parents[2] / "docs" / "validation"


@pytest.fixture(scope="module")
def validated() -> Any:
    """The package beside the page, with the tests whose data it takes."""
    tests = HERE.parents[1] / "tests"
    added = [str(HERE), *(str(tests / one) for one in ("statistics", "signals/allan", "procedures/positions"))]
    sys.path[:0] = added
    yield importlib.import_module("validated")
    del sys.path[: len(added)]


def test_the_page_is_what_was_found(validated: Any) -> None:
    page = importlib.import_module("validated.page").page
    found = importlib.import_module("validated.found").load()
    assert set(found) == set(validated.PARTS)
    written = HERE.parent / "validation.md"
    assert written.read_text(encoding="utf-8") == page(found), "make validation"
    assert all(line.holds for part in found.values() for table in part.tables for line in table.lines)


def test_a_line_that_does_not_hold_is_bold(validated: Any) -> None:
    found = importlib.import_module("validated.found")
    page = importlib.import_module("validated.page").page
    table = found.Table("T", "Text.", ("a", "b"), (0, 2), (found.Line(("one", 1.234), holds=False),))
    told = page({"noise": found.Part("2026-01-01", "0", (table,))})
    assert "| **one** | **1.2** |" in told
    assert "0 of 1 lines hold" in told
    assert "| one | 1.2 |" in page(
        {"noise": found.Part("2026-01-01", "0", (replace(table, lines=(found.Line(("one", 1.2)),)),))}
    )


@pytest.mark.parametrize(
    "part",
    [
        "least_squares",
        "slower",
        *(pytest.param(one, marks=pytest.mark.slow) for one in ("recordings", "noise", "peers")),
    ],
)
def test_what_was_found_is_found_again(validated: Any, part: str) -> None:
    kept = importlib.import_module("validated.found").load()[part]
    try:
        tables = validated.PARTS[part]()
    except validated.AbsentError as absent:
        pytest.skip(str(absent))
    assert len(tables) == len(kept.tables)
    for table, before in zip(tables, kept.tables, strict=True):
        assert [line.cells[0] for line in table.lines] == [line.cells[0] for line in before.lines]
        for line, was in zip(table.lines, before.lines, strict=True):
            assert line.holds, line
            for value, old, digits in zip(line.cells, was.cells, table.digits, strict=True):
                if (
                    isinstance(old, float) and digits > 3
                ):  # figures; of differences and digits it is asked that they hold
                    assert math.isclose(float(value), old, rel_tol=1e-5), (line, was)
