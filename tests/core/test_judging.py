"""The small grammar of ``where``."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.judging import parse_condition


def at(text: str, deg_s: float) -> bool:
    return parse_condition(text).holds({"rate": math.radians(deg_s)})


def test_comparisons_convert_units() -> None:
    assert at("abs(rate) >= 0.1 deg/s", -0.2)
    assert not at("abs(rate) >= 0.1 deg/s", 0.05)
    assert at("rate > 1 deg/s and rate < 3 deg/s", 2.0)
    assert not at("rate > 1 deg/s and rate < 3 deg/s", 4.0)
    assert at("rate < 1 deg/s or rate > 3 deg/s and rate < 5 deg/s", 4.0)
    assert at("", 1.0)


def test_the_limit_itself_holds_whatever_the_rounding() -> None:
    assert at("abs(rate) >= 0.1 deg/s", 0.1)
    assert at("abs(rate) <= 0.1 deg/s", -0.1)
    assert not at("abs(rate) > 0.1 deg/s", 0.1)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("__import__('os')", "is no comparison"),
        ("abs(rate) >= 0.1 furlong/s", "furlong"),
        ("pressure > 3 Pa", "'pressure' is not known"),
        ("rate > 5 %", "rate cannot be compared with '5 %'"),
        ("rate == 5 deg/s", "is no comparison"),
        ("rate > 1 deg/s " + "and rate > 1 deg/s " * 40, "characters long, at most"),
    ],
)
def test_what_does_not_follow_the_grammar_is_refused(text: str, words: str) -> None:
    with pytest.raises(DataError, match=words.replace("(", r"\(")):
        parse_condition(text)


@given(st.text(alphabet="abs(rte) <>=0.1degs/andor%\n'\"", max_size=60))
def test_no_text_gets_past_the_grammar(text: str) -> None:
    try:
        parse_condition(text)
    except DataError as error:
        assert str(error)  # noqa: PT017
