"""Cells: numbers as people and programs write them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.files.text.layout import Decimal, judge, kind, to_float


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("5", 5.0), ("-0", 0.0), ("+2.76E-007", 2.76e-7), (".5", 0.5), ("1.", 1.0), ("1e5", 1e5), ("1.5D-3", 1.5e-3),
        ("007", 7.0),
    ],
)  # fmt: skip
def test_numbers(cell: str, expected: float) -> None:
    assert kind(cell) in "if"
    assert to_float(cell) == expected


@pytest.mark.parametrize(
    "cell", ["nan", "NaN", "-nan(ind)", "inf", "-Infinity", "NA", "n/a", "null", "None", "1.#QNAN"]
)
def test_what_stands_for_no_number(cell: str) -> None:
    assert kind(cell) == "n"


@pytest.mark.parametrize("cell", ["x", "1 2", "1_000", "0x1F", "--", "1e", "1,5", "12:30", "１", "1.2.3", "e5", "."])
def test_text(cell: str) -> None:
    assert kind(cell) == "t"


def test_a_decimal_comma_makes_the_point_text() -> None:
    assert (kind("1,5", ","), kind("1.5", ","), to_float("-1,5e3", ",")) == ("f", "t", -1500.0)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from([".", ","]))
def test_every_float_is_read_back_to_the_last_bit(value: float, decimal: Decimal) -> None:
    cell = repr(value).replace(".", decimal)
    assert to_float(cell, decimal) == value
    assert judge([cell], decimal).values[0] == value


@given(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=1))
def test_whole_numbers_stay_whole(numbers: list[int]) -> None:
    values = judge([str(number) for number in numbers]).values
    assert values.dtype == np.int64
    assert values.tolist() == numbers


def test_long_cells_take_no_longer_than_their_length() -> None:
    # A pattern that tries every way to cut the digits in two would take hours.
    assert kind("9" * 200_000 + "x") == "t"


def test_whole_numbers_beyond_int64_become_floats() -> None:
    assert judge(["1", str(2**63)]).values.tolist() == [1.0, 2.0**63]
    assert judge(["1", "9" * 5000, "2"]).text.tolist() == [1]  # beyond float64, too


def test_empty_and_not_a_number_hold_nan_and_are_listed_apart() -> None:
    judged = judge(["1", "", "NaN", " ", "2.5"])
    np.testing.assert_array_equal(judged.values, [1.0, np.nan, np.nan, np.nan, 2.5])
    assert (judged.empty.tolist(), judged.not_a_number.tolist()) == ([1, 3], [2])


def test_text_among_numbers_is_listed_and_a_column_of_text_is_text() -> None:
    assert judge(["1", "two", "3"]).text.tolist() == [1]
    labels = judge(["a", "1", "b"])
    assert labels.values.tolist() == ["a", "1", "b"]
    assert labels.text.tolist() == []


def test_a_number_beyond_float64_is_text() -> None:
    judged = judge(["1.5", "1e999", "2.0"])
    assert judged.text.tolist() == [1]
    assert math.isnan(judged.values[1])


def test_a_column_without_any_value_is_nan() -> None:
    assert np.isnan(judge(["", ""]).values).all()
    assert judge([]).values.shape == (0,)
