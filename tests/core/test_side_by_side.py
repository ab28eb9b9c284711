"""Rows of two ground models, as they are read side by side."""

from __future__ import annotations

from typing import Any

import pytest

from inertialcal.core.show.rows import own_rows, pairs_of, verdict_of
from inertialcal.procedures.flip.figures import COMPARED
from written_rows import fields


def row(quantity: str, value: float | None, condition: str = "", axis: str = "y", half: float = 0.0) -> dict[str, Any]:
    interval = None if value is None or not half else {"lo": value - half, "hi": value + half, "p": 0.95}
    return {"quantity": quantity, "axis": axis, **fields(condition), "value": value, "interval": interval}


ROWS = [
    row("bias", 1.0),
    row("model_bias_error", -1.0), row("other_model_bias_error", 3.0),
    row("model_bias_error_change", -4.0), row("model_bias_error_reduction", 2.0, half=1.0),
    row("model_bias_error_change", -4.1, "flip 2"), row("model_bias_error", -1.1, "as_published, flip 2"),
    row("model_bias_error", 5.0, axis="z"), row("model_bias_error_change", None, axis="z"),
]  # fmt: skip


def test_an_axis_has_both_errors_and_what_they_differ_by_by_flip() -> None:
    found = pairs_of(ROWS, COMPARED)
    assert list(found) == [("y", ""), ("y", "flip 2")]
    assert found["y", ""]["other"]["value"] == 3.0
    assert found["y", "flip 2"]["change"]["value"] == -4.1


def test_a_condition_of_the_test_is_the_result() -> None:
    assert list(pairs_of([one | {"condition": "cold"} for one in ROWS[:5]], COMPARED)) == [("y", "")]


def test_rows_of_the_other_stand_in_their_own_table_alone() -> None:
    assert [one["quantity"] for one in own_rows(ROWS, COMPARED)] == ["bias", *["model_bias_error"] * 3]
    assert own_rows(ROWS[:2], COMPARED) == ROWS[:2]


@pytest.mark.parametrize(
    ("value", "half", "word"),
    [(2.0, 1.0, "nearer"), (-2.0, 1.0, "farther"), (0.5, 1.0, "not shown"), (2.0, 0.0, "not shown")],
)
def test_nearer_is_what_the_interval_shows(value: float, half: float, word: str) -> None:
    assert verdict_of({"reduction": row("model_bias_error_reduction", value, half=half)}) == word
    assert verdict_of({}) == "not shown"
