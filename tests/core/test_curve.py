"""Curve: equal columns, plain values."""

from __future__ import annotations

import json

import numpy as np
import pytest

from inertialcal.core.curve import Column, Curve
from inertialcal.core.errors import DataError


def test_not_finite_numbers_are_null_and_all_values_are_plain() -> None:
    curve = Curve(
        "trace",
        "x",
        {
            "lo": Column(np.array([1.0, np.nan, np.inf]), "rad/s"),
            "u": Column([None, np.float64(0.5), np.nan], "1"),
            "used": Column([True, False, True]),
            "run": Column(["1", "", "<b>\0"]),
        },
        recording="a",
    )
    found = curve.to_dict("t")
    assert list(found) == ["name", "test", "axis", "recording", "columns"]
    assert found["columns"]["lo"] == {"unit": "rad/s", "values": [1.0, None, None]}
    assert found["columns"]["u"]["values"] == [None, 0.5, None]
    assert found["columns"]["run"]["values"] == ["1", "", "<b>\0"]
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_columns_of_different_length_are_refused() -> None:
    with pytest.raises(DataError, match=r"curve 'c': columns of different length: \{'a': 1, 'b': 2\}"):
        Curve("c", "x", {"a": Column([1.0]), "b": Column([1.0, 2.0])})
