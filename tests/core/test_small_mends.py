"""Texts and names that a user meets: counts of one, shares, columns that say their axis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.core.schema import model, results
from inertialcal.core.schema.content import StatedInfluence
from inertialcal.core.schema.settings import settings_values
from inertialcal.core.show.rounding import freedom, items
from inertialcal.files.info.table_columns import guess
from inertialcal.files.text.table import read_table
from inertialcal.procedures.positions.plan import Plan


def test_one_is_singular() -> None:
    assert (freedom(1.0), freedom(1.004, 3), freedom(4)) == (
        "1 degree of freedom", "1 degree of freedom", "4 degrees of freedom",
    )  # fmt: skip
    assert (items(1, "cube"), items(0, "cube"), items(2, "cube")) == ("1 cube", "0 cubes", "2 cubes")


@pytest.mark.parametrize(
    ("value", "words"),
    [(0.02, 'like "2 %"'), (3, 'like "300 %"'), ("0 %", "should be greater than 0"), ([1], 'like "1 %"')],
)
def test_a_share_is_said_in_percent(value: Any, words: str) -> None:
    _, problems = settings_values(Plan, {"prior_scale_factor": value}, lambda *path: "")
    assert words in problems[0].what
    assert not problems[0].what.endswith(" 1")


def test_other_units_stay() -> None:
    _, problems = settings_values(Plan, {"prior_bias": "0 m/s^2"}, lambda *path: "")
    assert problems[0].what.endswith("should be greater than 0 m/s^2")


def test_influences_share_their_base() -> None:
    assert issubclass(model.Influence, StatedInfluence)
    assert issubclass(results.Influence, StatedInfluence)
    assert [*results.Influence.model_fields][-2:] == ["reason", "redrawn_by"]


def test_a_matrix_of_three_columns_has_axes(tmp_path: Path) -> None:
    rng, t = np.random.default_rng(1), np.arange(2000) / 100.0
    acc = rng.standard_normal((2000, 3)) + np.array([0.0, 0.0, 9.81])
    np.savez(tmp_path / "a.npz", time=t, acc=acc, status=np.zeros((2000, 3)))
    recording = ic.read(tmp_path / "a.npz", units={"acc": "m/s2"})
    assert [one.axis for one in recording.channels if one.quantity == "acc"] == ["x", "y", "z"]
    assert {one.axis for one in recording.channels if one.quantity != "acc"} == {""}
    found = ic.sine(tmp_path / "a.npz", period="1 s", units={"acc": "m/s2"})
    assert {row.axis for row in found.rows} == {"x", "y", "z"}
    np.savez(tmp_path / "b.npz", time=t, acc=acc[:, :2])
    assert {one.axis for one in ic.read(tmp_path / "b.npz").channels} == {""}


@pytest.mark.parametrize("letter", ["g", "w", "gyro_", ""])
def test_a_rate_table_with_one_reading_an_axis(tmp_path: Path, letter: str) -> None:
    rng = np.random.default_rng(2)
    rate = np.tile([-100.0, -50.0, 0.0, 50.0, 100.0], 2)
    other = 0.1 * rng.standard_normal((2, len(rate)))
    table = np.column_stack([rate, *other, 1.001 * rate + other[0]])
    heads = ["rate", *(f"{letter}{axis}" for axis in "xyz")]
    np.savetxt(tmp_path / "a.csv", table, "%.5f", ",", header=",".join(f"{one} [deg/s]" for one in heads), comments="")
    assert set(guess(read_table(tmp_path / "a.csv")).by_axis) == {"x", "y", "z"}
    rows = ic.rate_table(tmp_path / "a.csv", axis="z").rows
    errors = {row.axis for row in rows if row.quantity == "scale_factor_error" and row.status == "estimated"}
    assert errors == {"z"}


def test_a_table_says_which_reading_is_missing(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("rate [deg/s],one,two\n1,1,1\n2,2,2\n")
    with pytest.raises(InertialcalError, match="reading="):
        ic.rate_table(tmp_path / "a.csv", axis="z")
