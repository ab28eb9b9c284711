"""Rows of results: as DESIGN states them, with null for what is absent."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from inertialcal.core.results import Interval, Row, finite, is_beside, not_estimated

KEYS = ["quantity", "axis", "test", "condition", "value", "u", "unit", "dof", "interval", "status", "reason"]


def test_row_with_everything() -> None:
    interval = Interval(0.4988, 0.5012)
    row = Row("scale_factor", "x", 0.5, 6e-4, "V/(deg/s)", 12.5, interval, test="rate_x", condition="ambient")
    assert list(row.to_dict()) == KEYS
    assert json.loads(json.dumps(row.to_dict(), allow_nan=False)) == {
        "quantity": "scale_factor",
        "axis": "x",
        "test": "rate_x",
        "condition": "ambient",
        "value": 0.5,
        "u": 6e-4,
        "unit": "V/(deg/s)",
        "dof": 12.5,
        "interval": {"lo": 0.4988, "hi": 0.5012, "p": 0.95},
        "status": "estimated",
        "reason": "",
    }


def test_what_is_absent_is_null() -> None:
    row = Row("bias", "x", math.nan, None, "deg/s", math.inf, Interval(None, math.inf, 0.9)).to_dict()
    assert row["value"] is None
    assert row["u"] is None
    assert row["dof"] is None
    assert row["interval"] == {"lo": None, "hi": None, "p": 0.9}
    assert Row("bias", "x", 1.0, None, "deg/s").to_dict()["interval"] is None


def test_row_that_the_data_cannot_carry() -> None:
    row = not_estimated("misalignment", "xz", "rad", "axis z was never turned", "ambient")
    assert (row.value, row.u, row.status) == (None, None, "not_estimated")
    assert row.to_dict()["reason"] == "axis z was never turned"
    assert row.condition == "ambient"


@pytest.mark.parametrize(
    ("number", "plain"),
    [(1.5, 1.5), (0, 0.0), (np.float64(2.0), 2.0), (None, None), (math.nan, None), (-math.inf, None)],
)
def test_finite(number: float | None, plain: float | None) -> None:
    assert finite(number) == plain
    assert type(finite(number)) in {float, type(None)}


@pytest.mark.parametrize(
    ("condition", "beside"),
    [("", False), ("vacuum", False), ("R1", False), ("as_published", True), ("all_readings", True), ("median", True),
     ("low_pass", True), ("flip 12", True), ("as_published, flip 2", True), ("flip", False), ("no flip 1", False)],
)  # fmt: skip
def test_conditions_that_are_not_the_result(condition: str, beside: bool) -> None:
    assert is_beside(condition) is beside
