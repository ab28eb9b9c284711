"""Rows of results: as DESIGN states them, with null for what is absent."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.key import At, Case, Key, Member, Method, Reason
from inertialcal.core.results import COLUMNS, Curvature, Interval, Row, case_of, finite, flat, key_of, not_estimated

KEYS = [
    "quantity", "axis", "sensor", "power", "at", "test", "condition", "method", "member", "value", "u", "unit", "dof",
    "interval", "status", "reason", "shared", "curvature",
]  # fmt: skip


def test_row_with_everything() -> None:
    interval = Interval(0.4988, 0.5012)
    row = Row(Key("scale_factor", "x"), 0.5, 6e-4, "V/(deg/s)", 12.5, interval, test="rate_x", condition="ambient",
              shared={"rate_table.rate": -0.01}, curvature={"third_order_x": Curvature(0.2, 3.0)})  # fmt: skip
    assert list(row.to_dict()) == KEYS
    assert json.loads(json.dumps(row.to_dict(), allow_nan=False)) == {
        "quantity": "scale_factor",
        "axis": "x",
        "sensor": "",
        "power": 0,
        "at": None,
        "test": "rate_x",
        "condition": "ambient",
        "method": "result",
        "member": None,
        "value": 0.5,
        "u": 6e-4,
        "unit": "V/(deg/s)",
        "dof": 12.5,
        "interval": {"lo": 0.4988, "hi": 0.5012, "p": 0.95},
        "status": "estimated",
        "reason": None,
        "shared": {"rate_table.rate": -0.01},
        "curvature": {"third_order_x": {"change": 0.2, "size": 3.0}},
    }


def test_what_is_absent_is_null() -> None:
    row = Row(Key("bias", "x"), 1.0, None, "deg/s", math.inf, Interval(None, math.inf, 0.9)).to_dict()
    assert row["u"] is None
    assert row["dof"] is None
    assert row["interval"] == {"lo": None, "hi": None, "p": 0.9}
    assert Row(Key("bias", "x"), 1.0, None, "deg/s").to_dict()["interval"] is None
    nothing = Row(Key("bias", "x"), math.nan, None, "deg/s", math.inf, Interval(None, math.inf, 0.9)).to_dict()
    assert (nothing["value"], nothing["interval"], nothing["status"]) == (None, None, "not_estimated")


def test_row_that_the_data_cannot_carry() -> None:
    row = not_estimated(Key("misalignment", "xz"), "rad", Reason("not_turned", "axis z was never turned"))
    assert (row.value, row.u, row.status) == (None, None, "not_estimated")
    assert row.to_dict()["reason"] == {"code": "not_turned", "text": "axis z was never turned"}
    assert row.reason.code == "not_turned"


@pytest.mark.parametrize(
    ("number", "plain"),
    [(1.5, 1.5), (0, 0.0), (np.float64(2.0), 2.0), (None, None), (math.nan, None), (-math.inf, None)],
)
def test_finite(number: float | None, plain: float | None) -> None:
    assert finite(number) == plain
    assert type(finite(number)) in {float, type(None)}


ALONE = Case(at=At("line", 9.97, "Hz"), member=Member("run", "a"))


@pytest.mark.parametrize(
    ("case", "beside"),
    [(Case(), False), (Case(condition="vacuum"), False), (Case(Method.TEXTBOOK), True), (Case(Method.MEDIAN), True),
     (Case(member=Member("flip", "12")), True), (ALONE, False), (Case(member=Member("path", "warming")), False)],
)  # fmt: skip
def test_cases_that_are_not_the_result(case: Case, beside: bool) -> None:
    assert case.beside is beside


CASES = {
    "": Case(),
    "vacuum": Case(condition="vacuum"),
    "as_published": Case(Method.TEXTBOOK),
    "flip 3": Case(member=Member("flip", "3")),
    "as_published, flip 3": Case(Method.TEXTBOOK, Member("flip", "3")),
    "run power up, 2 alone": Case(member=Member("run", "power up, 2")),
    "-20 degC": Case(at=At("temperature", -20.0, "degC")),
    "warming, -20 degC": Case(member=Member("path", "warming"), at=At("temperature", -20.0, "degC")),
    "line at 9.97 Hz": Case(at=At("line", 9.97, "Hz")),
    "line at 2 x 9.97 Hz, run a alone": Case(member=Member("run", "a"), at=At("line", 9.97, "Hz"), times=2),
    "gyro": Case(sensor="gyro"),
    "held out, no g-sensitivity": Case(member=Member("held_out", "no g-sensitivity")),
}


@pytest.mark.parametrize("condition", CASES)
def test_what_a_row_is_as_text(condition: str) -> None:
    assert str(CASES[condition]) == condition


@pytest.mark.parametrize(
    ("key", "name"),
    [
        (Key("bias", "x"), "bias_x"),
        (Key("misalignment", "xz"), "misalignment_xz"),
        (Key("bias_temperature", "x", power=2), "bias_temperature_2_x"),
        (Key("bias_voltage", "y"), "bias_voltage_0_y"),
        (Key("bias", "z", at=At("temperature", -20.0, "degC")), "bias_z at -20 degC"),
    ],
)
def test_names_of_values(key: Key, name: str) -> None:
    assert str(key) == name


@pytest.mark.parametrize(
    "row",
    [
        Row(Key("bias", "x", at=At("temperature", 20.0, "degC")), 1.0, 0.1, "deg/s", condition="vacuum"),
        Row(Key("bias_temperature", "x", power=3), 1.0, None, "deg/s", 4.0, Interval(0.5, None), method=Method.MEDIAN),
        Row(Key("line_frequency", "z", power=2, at=At("line", 9.97, "Hz")), 20.0, 0.1, "Hz", member=Member("run", "a")),
        Row(Key("scatter_position", "", "gyro"), 1.0, 0.1, "deg/s", reason=Reason("", "why"), test="t"),
        Row(Key("bias", "y"), None, None, "ug", status="not_estimated", condition="ambient"),
    ],
)
def test_rows_are_read_back(row: Row) -> None:
    written = row.to_dict()
    assert Row.from_dict(written) == row
    assert (key_of(written), case_of(written)) == (row.key, row.case)
    assert tuple(flat(written)) == COLUMNS


@pytest.mark.parametrize("fields", [{"test": "again"}, {"value": math.inf}, {"u": 2.0, "unit": "g"}])
def test_a_changed_row_is_what_a_new_one_would_be(fields: dict[str, object]) -> None:
    row = Row(Key("bias", "x"), 1.0, 0.5, "m/s^2", 4.0, Interval(0.0, 2.0))
    assert row.changed(**fields) == replace(row, **fields)  # type: ignore[arg-type]
    assert row == Row(Key("bias", "x"), 1.0, 0.5, "m/s^2", 4.0, Interval(0.0, 2.0))
