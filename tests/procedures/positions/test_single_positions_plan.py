"""Positions planned from words: units, words of the positions, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import PlanError, UsageError
from inertialcal.procedures.positions.planning.planner import in_words


def test_target_in_units_of_the_user_is_met() -> None:
    found = ic.plan_positions(scatter="0.2 mg", target={"bias": "0.1 mg", "misalignment_yx": "0.02 deg"}, have="faces")
    u = dict(zip(found.prediction.names, found.prediction.u, strict=True))
    assert all(u[f"bias_{axis}"] <= 0.1e-3 * 9.80665 * (1.0 + 1e-9) for axis in "xyz")
    assert u["misalignment_yx"] <= np.radians(0.02)
    shown = {(row.quantity, row.axis): row for row in found.rows}
    assert shown["misalignment_uncertainty", "zx"].value is None
    for quantity, axis, value, unit in (
        ("bias", "x", u["bias_x"] / 9.80665e-3, "mg"),
        ("misalignment", "yx", np.degrees(u["misalignment_yx"]), "deg"),
        ("scale_factor_error", "z", 100.0 * u["scale_factor_error_z"], "%"),
    ):
        row = shown[f"{quantity}_uncertainty", axis]
        assert row.value == pytest.approx(value)
        assert row.unit == unit
    assert found.steps()[0]["number"] == 7
    assert len(found.steps()) == len(found.directions) - 6
    assert "positions to take" in str(found)


def test_six_faces_name_what_they_do_not_tell() -> None:
    found = ic.plan_positions(scatter="0.1 mg", have="faces")
    assert "6 of 9" in str(found)
    assert "not determined: misalignment_yx, misalignment_zx, misalignment_zy" in str(found)
    left = {row.axis: row.reason.text for row in found.rows if row.status == "not_estimated"}
    assert left == {axis: f"these positions do not determine misalignment_{axis}" for axis in ("yx", "zx", "zy")}
    assert "9 of 9" in str(ic.plan_positions(scatter="0.1 mg", have="faces", following=3))
    assert "12 of 12" in str(ic.plan_positions(scatter="0.1 mg", have="faces", known=True))


def test_one_axis_laid_up_and_down_by_hand() -> None:
    """Two readings at plus and minus g: bias is half their sum, scale factor half their difference over 2 g."""
    found = ic.plan_positions(scatter="1 mg", following=2, goal="bias_z", gravity_u="2 mg")
    assert [step["up"] for step in found.steps()] == ["z up", "z down"]
    u = dict(zip(found.prediction.names, found.prediction.u, strict=True))
    assert u["bias_z"] / 9.80665e-3 == pytest.approx(np.sqrt(0.5))
    assert u["scale_factor_error_z"] == pytest.approx(np.hypot(1e-3 * np.sqrt(0.5), 2e-3))
    assert found.remarks == ()


def test_what_is_not_stated_is_remarked() -> None:
    assert "gravity_u" in ic.plan_positions(scatter="1 mg", have="faces").remarks[0].what
    (remark,) = ic.plan_positions(scatter="1 mg", have="faces", known=True, gravity_u="1 mGal").remarks
    assert (remark.code, "pose" in remark.what) == ("no_standard_uncertainty", True)
    stated = ic.plan_positions(scatter="1 mg", have="faces", known=True, gravity_u="1 mGal", pose="0.1 deg")
    assert stated.remarks == ()


def test_figures_as_a_data_frame() -> None:
    pandas = pytest.importorskip("pandas")
    found = ic.plan_positions(scatter="1 mg", have="faces").to_frame()
    assert isinstance(found, pandas.DataFrame)
    assert list(found["quantity"].unique())[-1] == "bias_uncertainty"


def test_positions_in_words() -> None:
    assert in_words(np.array([0.0, 0.0, -1.0])) == "z down"
    assert in_words(np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)) == "between x up and y down"
    assert in_words(np.ones(3) / np.sqrt(3.0)) == "between x up, y up and z up"


@pytest.mark.parametrize(
    ("words", "error", "match"),
    [
        ({"scatter": None}, UsageError, "scatter is missing"),
        ({"have": "none"}, UsageError, "nothing to plan"),
        ({"target": {"bias": "1 ng"}}, PlanError, "after 200 positions"),
    ],
)
def test_python_refuses_as_the_command_does(words: dict[str, Any], error: type[Exception], match: str) -> None:
    given: dict[str, Any] = {"scatter": "0.1 mg", "have": "faces"} | words
    with pytest.raises(error, match=match):
        ic.plan_positions(**given)
