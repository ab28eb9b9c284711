"""Figures beside the result: what has a column, what is left out and counted, what is not said twice."""

from __future__ import annotations

from typing import Any

import pytest

from inertialcal.core.key import Case, Member, Method
from inertialcal.core.show.result_tables import figure_beside, not_estimated
from inertialcal.core.show.rounding import near
from inertialcal.core.show.rows import MOST, columns_of, lines_of, missing_of, names_of
from written_rows import fields


def row(condition: str = "", value: float | None = 1.0, reason: str = "", quantity: str = "bias") -> dict[str, Any]:
    known = not reason
    return {
        "quantity": quantity, "axis": "y", "test": "t", **fields(condition, reason), "value": value,
        "u": 0.25 if known else None, "unit": "ug", "dof": None, "interval": None,
        "status": "estimated" if known else "not_estimated",
    }  # fmt: skip


def flip(number: int) -> Case:
    return Case(member=Member("flip", str(number)))


def test_what_stands_beside_is_on_the_line_of_the_result() -> None:
    rows = [row(), row("flip 1", 2.0, "no noise"), row("median", 3.0, "see the mean"), row("vacuum", 4.0)]
    lines = lines_of(rows)
    assert list(lines) == [("bias", "", "y", "ug"), ("bias", "vacuum", "y", "ug")]
    assert {str(way): one["value"] for way, one in lines["bias", "", "y", "ug"].items()} == {
        "": 1.0, "flip 1": 2.0, "median": 3.0,
    }  # fmt: skip
    assert columns_of(lines) == ([Case(Method.MEDIAN), flip(1)], [])
    assert missing_of(rows) == {}


def test_flips_have_columns_where_all_of_them_have_room() -> None:
    few = [row(), row("low_pass"), *(row(f"flip {i}") for i in range(MOST - 1)), row("as_published, flip 1")]
    shown, left = columns_of(lines_of(few))
    assert (len(shown), left) == (MOST, [Case(Method.TEXTBOOK, Member("flip", "1"))])
    many = [row(), row("low_pass"), *(row(f"flip {i}") for i in range(MOST))]
    assert columns_of(lines_of(many)) == ([Case(Method.LOW_PASS)], [flip(i) for i in range(MOST)])


def test_a_reason_of_the_result_is_not_said_again_for_each_flip() -> None:
    rows = [row(value=None, reason="not turned"), row("flip 1", None, "not turned"), row("flip 2", None, "lost")]
    assert not_estimated(rows) == ("not estimated: bias y: not turned", "not estimated: flip 2: lost")
    other = [row(), row("low_pass", None, "too short"), row("low_pass", None, "too short", "control_error")]
    assert not_estimated(other) == ("not estimated: low pass: too short",)


def test_readings_not_pruned_say_nothing_new_of_what_is_not_estimated() -> None:
    rows = [row(value=2.0, reason="unknown"), row("all_readings", 3.0, "unknown")]
    assert lines_of(rows) == {}
    assert [len(found) for found in missing_of(rows).values()] == [1]


def test_a_published_figure_without_a_result_keeps_its_line_and_its_reason() -> None:
    assert list(lines_of([row("as_published", 0.3634, "the sum itself")])) == [("bias", "", "y", "ug")]
    assert not_estimated([row("as_published", None, "not printed")]) == ("not estimated: bias y: not printed",)


def test_many_names_are_the_first_and_the_last() -> None:
    names = [flip(i) for i in range(9)]
    assert names_of(names[:2]) == "flip 0; flip 1"
    assert names_of(names) == "flip 0; flip 1; ...; flip 8"


@pytest.mark.parametrize(
    ("value", "u", "shown"),
    [(979.0512, 0.724, "979.051"), (0.0571, 1.7, "0.06"), (43.81, 12.0, "43.8"), (-3.21234e-7, 4.1e-8, "-3.212e-07"),
     (1.23456789, None, "1.23457"), (None, 0.1, "-"), (2.0, 0.0, "2")],
)  # fmt: skip
def test_a_value_without_uncertainty_has_a_digit_more_than_the_result_beside_it(
    value: float | None, u: float | None, shown: str
) -> None:
    assert near(value, u) == shown


def test_a_figure_with_its_own_uncertainty_keeps_it() -> None:
    assert figure_beside(row("flip 1", 2.0), row()) == "2.00 ± 0.25"
    assert figure_beside(row("median", 2.0, "see the mean"), row()) == "2.000"
    assert figure_beside(row("median", 2.0, "see the mean"), None) == "2"
    assert figure_beside(None, row()) == ""
