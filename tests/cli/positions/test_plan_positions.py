"""`plan positions` on the command line: what it prints, its JSON object, one clear message for bad input."""

from __future__ import annotations

import pytest

from inertialcal.cli.commands import Planners
from typed_commands import call, call_json

PLAN = ("plan", "positions")
SCATTER = ("--scatter", "0.1 mg")
FACES = (*SCATTER, "--have", "faces")


def test_it_prints_the_positions_and_what_they_tell(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = call(capsys, *PLAN, *FACES, "--next", "3")
    assert (status, err) == (0, "")
    assert "7         between x up, y up and z up" in out  # the eight corners tell alike: the first of them
    assert "after 9 positions: 9 of 9 parameters determined" in out
    assert "warning: taken as exact: --gravity-u" in out
    assert call(capsys, *PLAN, *FACES, "--quiet") == (0, "", "")


def test_one_json_object_with_rows_of_results(capsys: pytest.CaptureFixture[str]) -> None:
    found = call_json(capsys, *PLAN, *FACES, "--gravity-u", "1 mGal")
    assert (found["command"], found["exit"], found["remarks"]) == ("plan positions", 0, [])
    assert found["positions"] == []
    assert found["not_told"] == ["misalignment_yx", "misalignment_zx", "misalignment_zy"]
    assert len(found["results"]) == 9
    for row in found["results"]:
        told = not row["quantity"].startswith("misalignment")
        assert (row["status"] == "estimated") is (row["value"] is not None) is told
    aimed = call_json(capsys, *PLAN, *SCATTER, "--target", "bias=0.05 mg", "--target", "misalignment=0.01 deg")
    values = {(row["quantity"], row["axis"]): row["value"] for row in aimed["results"]}
    assert max(values["bias_uncertainty", axis] for axis in "xyz") <= 0.05 * (1.0 + 1e-12)
    assert values["misalignment_uncertainty", "zx"] <= 0.01
    assert [one["number"] for one in aimed["positions"]] == list(range(1, len(aimed["positions"]) + 1))
    assert not any(wanted in one for one in aimed["not_told"] for wanted in ("bias", "misalignment"))


def test_the_error_of_gravity_is_in_scale_factors_and_that_of_directions_across(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def of(*words: str) -> dict[tuple[str, str], float]:
        rows = call_json(capsys, *PLAN, *FACES, "--known", *words)["results"]
        return {(row["quantity"], row["axis"]): row["value"] for row in rows}

    bare, heavy, askew = of(), of("--gravity-u", "9.80665 mm/s2"), of("--pose", "1 mrad")
    scale, across, bias = (
        ("scale_factor_error_uncertainty", "x"),
        ("misalignment_uncertainty", "xy"),
        ("bias_uncertainty", "x"),
    )
    assert heavy[scale] == pytest.approx((bare[scale] ** 2 + 0.1**2) ** 0.5)
    assert (heavy[across], heavy[bias]) == pytest.approx((bare[across], bare[bias]))
    assert askew[across] == pytest.approx((bare[across] ** 2 + 1e-6 / 2.0) ** 0.5)
    assert askew[scale] == pytest.approx(bare[scale], rel=1e-3)  # weights alone change


BAD: list[tuple[tuple[str, ...], int, str]] = [
    ((), 2, "--scatter is missing"),
    (SCATTER, 2, "nothing to plan"),
    (("--scatter", "0.1 deg"), 2, "scatter: '0.1 deg'"),
    (("--scatter", "0.1"), 2, "has no unit"),
    (("--scatter", "much"), 2, "--scatter: quantity 'much'"),
    (("--scatter", "-1 mg"), 2, "--scatter = -0.00980665"),
    (("--scatter", "nan mg"), 2, "--scatter: quantity 'nan mg'"),
    (("--scatter", "0 g"), 2, "should be greater than"),
    ((*SCATTER, "--have", "all"), 2, "'none', 'faces', 'faces+edges', 'cube'"),
    ((*FACES, "--gravity", "9.8"), 2, "gravity: '9.8'"),
    ((*FACES, "--gravity", "1 m/s2"), 2, "should be greater than or equal to 9.7 m/s^2"),
    ((*FACES, "--gravity-u", "-1 mGal"), 2, "should be greater than or equal to 0 m/s^2"),
    ((*FACES, "--known", "--pose", "1 m"), 2, "pose: '1 m'"),
    ((*FACES, "--pose", "1 deg"), 2, "--pose of directions that are not known"),
    ((*FACES, "--target", "bias"), 2, "target bias: no uncertainty given"),
    ((*FACES, "--target", "bias=1 mg", "--target", "bias=2 mg"), 2, "'bias' stands twice"),
    ((*FACES, "--target", "bias=1 deg"), 2, "bias: '1 deg'"),
    ((*FACES, "--target", "bias=0 mg"), 2, "bias: '0 mg': need more than 0"),
    ((*FACES, "--target", "drift=1"), 2, "target 'drift': no such parameter"),
    ((*FACES, "--target", "misalignment_xy=1 mrad"), 2, "Only known directions determine it: --known"),
    ((*FACES, "--target", "bias=1 mg", "--next", "2"), 2, "a target, and a number of positions to add"),
    ((*FACES, "--next", "-1"), 2, "--next = -1"),
    ((*FACES, "--next", "1", "--goal", "speed"), 2, "goal 'speed': no such parameter"),
    ((*FACES, "--goal", "trace"), 2, "goal 'trace', and no number of positions to add"),
    ((*FACES, "--next", "5", "--most", "10"), 2, "11 positions, and 10 in all"),
    ((*FACES, "--most", "0"), 2, "--most = 0"),
    ((*FACES, "--most", "1000000"), 2, "should be less than or equal to 1000"),
    ((*FACES, "--next", "1.5"), 2, "Invalid value for '--next'"),
    ((*FACES, "--target", "bias=1 ng", "--most", "30"), 3, "after 30 positions, 9.81e-09 wanted"),
    (
        (*FACES, "--gravity-u", "1 mg", "--target", "scale_factor_error=10 ppm"),
        3,
        "cannot be known better than 0.001: the uncertainty of gravity",
    ),
]


@pytest.mark.parametrize(("words", "expected", "said"), BAD, ids=[" ".join(one[0][-2:]) or "none" for one in BAD])
def test_bad_input_is_refused_in_one_message(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], expected: int, said: str
) -> None:
    status, out, err = call(capsys, *PLAN, *words)
    assert (status, out) == (expected, "")
    assert said in " ".join(err.split())
    assert err.count("error:") == 1


def test_a_refusal_as_json_names_both_words(capsys: pytest.CaptureFixture[str]) -> None:
    found = call_json(capsys, *PLAN, *FACES, "--most", "0")
    assert (found["command"], found["exit"], found["errors"][0]["code"]) == ("plan positions", 2, "wrong_value")


def test_both_plans_are_there() -> None:
    assert Planners(name="plan").list_commands(None) == [
        "rate-table",
        "flip",
        "thermal",
        "allan",
        "mass-attraction",
        "positions",
        "vibration",
        "vibration survey",
        "turned-mass",
        "magnetometer-bias",
    ]
