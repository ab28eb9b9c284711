"""CSV of results: a cell stays a cell, and no spreadsheet runs one, whatever stands in the texts of a campaign."""

from __future__ import annotations

import csv
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.campaign.outcome.publish import csv_text
from inertialcal.report.drawings import rows_csv

FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
TEXTS = st.text(st.one_of(st.sampled_from("=+-@\t\r\n,;\"'1a "), st.characters(codec="utf-8", exclude_characters="\0")))


@given(rows=st.lists(st.tuples(TEXTS, TEXTS), min_size=1, max_size=3))
@pytest.mark.parametrize("where", ["file", "page"])
def test_a_text_stays_one_cell_and_is_no_formula(where: str, rows: list[tuple[str, str]]) -> None:
    given = [{"one": one, "other": other} for one, other in rows]
    text = csv_text(given, ["one", "other"]) if where == "file" else rows_csv(given)
    found = list(csv.reader(StringIO(text, newline="")))
    assert found[0] == ["one", "other"]
    assert [len(row) for row in found] == [2] * (len(rows) + 1)
    assert not any(cell.startswith(FORMULA) and len(cell) > 1 for row in found for cell in row)


def test_negative_numbers_stay_numbers() -> None:
    assert csv_text([{"value": -1.5, "dof": -2}], ["value", "dof"]) == "value,dof\n-1.5,-2\n"
