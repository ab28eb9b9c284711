"""Positions planned from words: units, words of the positions, what is refused."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from inertialcal.campaign.single_positions_plan import in_words, positions_plan
from inertialcal.cli.plans_positions import plan_positions
from inertialcal.core.errors import PlanError, UsageError


def test_target_in_units_of_the_user_is_met() -> None:
    found = positions_plan("0.2 mg", {"bias": "0.1 mg", "misalignment_yx": "0.02 deg"}, have="faces")
    u = {row["parameter"]: row["u"] for row in found.rows()}
    assert all(u[f"bias_{axis}"] <= 0.1e-3 * 9.80665 * (1.0 + 1e-9) for axis in "xyz")
    assert u["misalignment_yx"] <= np.radians(0.02)
    assert found.steps()[0]["number"] == 7
    assert len(found.steps()) == len(found.directions) - 6
    assert "positions to take" in str(found)


def test_six_faces_name_what_they_do_not_tell() -> None:
    shown = str(positions_plan("0.1 mg", have="faces"))
    assert "6 of 9" in shown
    assert shown.count("not told: misalignment") == 3
    assert "9 of 9" in str(positions_plan("0.1 mg", have="faces", following=3))
    assert "12 of 12" in str(positions_plan("0.1 mg", have="faces", known=True))


def test_positions_in_words() -> None:
    assert in_words(np.array([0.0, 0.0, -1.0])) == "z down"
    assert in_words(np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)) == "between x up and y down"
    assert in_words(np.ones(3) / np.sqrt(3.0)) == "between x up and y up and z up"


@pytest.mark.parametrize(
    ("words", "error", "match"),
    [
        ({"scatter": "0.1 deg"}, UsageError, "scatter"),
        ({"scatter": "much"}, UsageError, "scatter"),
        ({"have": "all"}, UsageError, "positions 'all'"),
        ({"have": "none"}, UsageError, "nothing to plan"),
        ({"target": {"bias": "1 deg"}}, UsageError, "bias"),
        ({"target": {"drift": "1"}}, PlanError, "target drift"),
        ({"following": 1, "goal": "speed"}, PlanError, "goal 'speed'"),
    ],
)
def test_what_cannot_be_meant_is_refused(words: dict[str, Any], error: type[Exception], match: str) -> None:
    given: dict[str, Any] = {"scatter": "0.1 mg", "have": "faces"} | words
    with pytest.raises(error, match=match):
        positions_plan(**given)


@pytest.fixture(scope="module")
def app() -> typer.Typer:
    """The command by itself."""
    made = typer.Typer(rich_markup_mode=None)
    made.command("positions")(plan_positions)
    made.callback()(lambda: None)
    return made


def test_command_prints_the_plan(app: typer.Typer) -> None:
    done = CliRunner().invoke(app, ["positions", "--scatter", "0.1 mg", "--target", "bias=0.2 mg"])
    assert done.exit_code == 0
    assert "positions to take" in done.output
    assert "bias_x" in done.output
    silent = CliRunner().invoke(app, ["positions", "--scatter", "0.1 mg", "--have", "faces", "--quiet"])
    assert (silent.exit_code, silent.output) == (0, "")


def test_command_prints_one_json_object(app: typer.Typer) -> None:
    done = CliRunner().invoke(app, ["positions", "--scatter", "0.1 mg", "--have", "faces", "--next", "1", "--json"])
    found = json.loads(done.output)
    assert [one["number"] for one in found["positions"]] == [7]
    assert len(found["predicted"]) == 9
    assert all(one["u"] is None or one["u"] > 0.0 for one in found["predicted"])
    bare = CliRunner().invoke(app, ["positions", "--scatter", "0.1 mg", "--have", "faces", "--json"])
    assert len(json.loads(bare.output)["not_told"]) == 3


def test_command_tells_every_option_and_refuses(app: typer.Typer) -> None:
    shown = CliRunner().invoke(app, ["positions", "--help"]).output
    for option in ("--scatter", "--target", "--have", "--known", "--pose", "--gravity-u", "--next", "--goal", "--most"):
        assert option in shown
    for words, refused, said in (
        (["--scatter", "1 m"], UsageError, "scatter '1 m'"),
        (["--scatter", "0.1 mg", "--target", "bias"], UsageError, "--target bias"),
        (["--scatter", "0.1 mg", "--target", "bias=0.001 mg"], PlanError, "after 200 positions"),
    ):
        done = CliRunner().invoke(app, ["positions", *words])
        assert isinstance(done.exception, refused)
        assert done.exception.exit_status == (2 if refused is UsageError else 3)
        assert said in str(done.exception)
