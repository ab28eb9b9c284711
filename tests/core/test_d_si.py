"""Units of the Digital System of Units: those of its tables, and the refusal of all that is not in it."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.unit.d_si import WORDS, d_si
from inertialcal.core.units import known_units, multiply, si_unit


@pytest.mark.parametrize(
    ("unit", "wanted"),
    [
        ("1", r"\one"), ("%", r"\percent"), ("rad/s", r"\radian\second\tothe{-1}"),
        ("deg/s", r"\degree\second\tothe{-1}"),
        ("m/s^2", r"\metre\second\tothe{-2}"), ("m/s^2/sqrt(Hz)", r"\metre\hertz\tothe{-0.5}\second\tothe{-2}"),
        ("um/s^2", r"\micro\metre\second\tothe{-2}"), ("deg/sqrt(h)", r"\degree\hour\tothe{-0.5}"),
        ("count", r"\one"), ("count/s", r"\second\tothe{-1}"), ("degC", r"\degreecelsius"), ("kPa", r"\kilo\pascal"),
    ],
)  # fmt: skip
def test_units_of_the_field(unit: str, wanted: str) -> None:
    assert d_si(unit) == wanted


@pytest.mark.parametrize("unit", ["g", "ug", "mGal", "Torr", "mdeg/h", "rev/min", "psi", "degF", "ppb"])
def test_what_it_cannot_say_is_refused(unit: str) -> None:
    with pytest.raises(DataError) as refused:
        d_si(unit)
    assert refused.value.problems[0].code == "not_in_d_si"


@given(st.sampled_from(known_units()), st.sampled_from(known_units()))
def test_the_si_unit_of_any_product_can_be_said(one: str, other: str) -> None:
    said = d_si(si_unit(multiply(one, other)))
    words = re.sub(r"\\tothe\{-?[0-9.]+\}", "", said).split("\\")
    assert words[0] == ""
    assert set(words[1:]) <= {*WORDS.values(), "one"}
