"""Requirements at a glance: which figure a line shows, its margin in words, the closed loop."""

from __future__ import annotations

from typing import Any

import pytest

from inertialcal.cli.shown.summary import requirement_table
from inertialcal.core.show.requirement_lines import HEADS, requirement_lines


def verdict(word: str, value: float | None, margin: float | None, **more: Any) -> dict[str, Any]:
    return {
        "requirement": "R1", "test": "t", "axis": "x", "sensor": "", "at": None, "at_unit": "", "value": value,
        "unit": "deg/s", "lower": -0.05, "upper": 0.05, "margin": margin, "verdict": word, "reason": "why",
        "readings": "as_read", "as_read": None,
    } | more  # fmt: skip


def results(verdicts: list[dict[str, Any]], word: str, loops: list[dict[str, Any]] | None = None) -> dict[str, Any]:
    rows = [{"requirement": "R1", "text": "bias small", "verdict": word}]
    rows += [{"requirement": "closed loop", "text": "better", "verdict": loops[0]["verdict"]}] if loops else []
    loop = {"verdict": "PASS", "reason": "", "axes": loops or [], "over_temperature": []}
    return {"verification": rows, "verdicts": verdicts, "closed_loop": loop, "verdict": word, "remarks": []}


def test_a_line_shows_the_place_that_decides() -> None:
    places = [verdict("PASS", 0.01, 0.03), verdict("FAIL", 0.08, -0.02, axis="z", at=60.0, at_unit="degC"),
              verdict("INCONCLUSIVE", 0.049, -0.3, axis="y")]  # fmt: skip
    (line,) = requirement_lines(results(places, "FAIL"))
    assert line.cells == (
        "R1: bias small", "0.08 deg/s", "", "within 0.05 deg/s", "0.02 deg/s beyond", "FAIL",
    )  # fmt: skip
    assert line.place == "z, at 60 degC, t"
    assert (line.raw_value, line.compensated_value, line.margin_value) == (0.08, None, -0.02)
    assert len(line.cells) == len(HEADS)


def test_compensated_figures_stand_beside_the_same_as_read() -> None:
    raw = {"value": 0.14, "margin": -0.08, "verdict": "FAIL"}
    small = {"value": 0.02, "margin": 0.02, "verdict": "PASS"}
    places = [verdict("PASS", 0.004, 0.03, readings="compensated", as_read=raw),
              verdict("PASS", 0.006, 0.02, readings="compensated", as_read=small)]  # fmt: skip
    (line,) = requirement_lines(results(places, "PASS"))
    assert (line.raw, line.compensated, line.margin) == ("0.14 deg/s", "0.006 deg/s", "0.02 deg/s to spare")
    assert (line.raw_verdict, line.verdict) == ("FAIL", "PASS")


def test_a_place_with_a_figure_comes_before_one_of_which_nothing_is_known() -> None:
    places = [verdict("INCONCLUSIVE", None, None, reason="no reading"), verdict("INCONCLUSIVE", 0.06, -0.02)]
    (line,) = requirement_lines(results(places, "INCONCLUSIVE"))
    assert (line.raw, line.margin) == ("0.06 deg/s", "interval 0.02 deg/s beyond")


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (verdict("INCONCLUSIVE", 0.04, -0.01), "interval 0.01 deg/s beyond"),
        (verdict("INCONCLUSIVE", None, None), "why"),
        (verdict("INCONCLUSIVE", 0.01, 0.02), "why"),  # in doubt though inside
        (verdict("PASS", 0.049, -0.01), "why"),  # simple acceptance: its interval goes beyond
        (verdict("OPEN", None, None), "why"),
    ],
)
def test_the_margin_never_says_more_than_the_verdict(one: dict[str, Any], said: str) -> None:
    (line,) = requirement_lines(results([one], one["verdict"]))
    assert line.margin == said
    assert line.verdict == one["verdict"]


@pytest.mark.parametrize(
    ("lower", "upper", "said"),
    [(None, 5.0, "at most 5 %"), (1.0, None, "at least 1 %"), (0.0, 5.0, "0 to 5 %"), (None, None, "")],
)
def test_limits_in_words(lower: float | None, upper: float | None, said: str) -> None:
    (line,) = requirement_lines(results([verdict("PASS", 1.0, 1.0, lower=lower, upper=upper, unit="%")], "PASS"))
    assert line.limit == said


def loop(word: str, raw: float, after: float, axis: str) -> dict[str, Any]:
    return {"verdict": word, "raw_rms": raw, "compensated_rms": after, "unit": "deg/s", "axis": axis, "condition": ""}


def test_the_closed_loop_has_a_line_of_the_axis_that_does_worst() -> None:
    loops = [loop("PASS", 0.02, 0.019, "x"), loop("INCONCLUSIVE", 0.01, 0.005, "y")]
    *_, line = requirement_lines(results([verdict("PASS", 0.0, 0.05)], "PASS", loops))
    assert (line.place, line.raw, line.compensated) == ("y", "rms 0.01 deg/s", "rms 0.005 deg/s")
    assert line.margin == "50 % smaller, not shown"
    *_, line = requirement_lines(results([verdict("PASS", 0.0, 0.05)], "PASS", [loop("FAIL", 0.0, 1.0, "x")]))
    assert line.margin == ""


def test_a_table_ends_with_the_verdict_on_all_and_steers_no_terminal() -> None:
    text = requirement_table(results([verdict("OPEN", None, None, reason="a\x1b[31m\nb")], "INCONCLUSIVE"))
    assert text.splitlines()[-1] == "overall: INCONCLUSIVE"
    assert "\x1b" not in text
    assert requirement_table({"verification": [], "verdicts": [], "verdict": None}) == ""


def test_an_error_that_alone_leaves_the_verdict_open_is_named_below_it() -> None:
    passed = results([verdict("PASS", 0.0, 0.05)], "PASS")
    error = {"severity": "error", "what": "recording b: a copy of a"}
    assert requirement_table(passed | {"remarks": [error]}).endswith("overall: PASS")
    left_open = passed | {"remarks": [error], "verdict": "INCONCLUSIVE"}
    assert requirement_table(left_open).endswith("overall: INCONCLUSIVE\n  in doubt: recording b: a copy of a")


def test_on_a_narrow_terminal_the_verdict_stands_beside_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    content = results([verdict("PASS", 0.0123, 0.0377)], "PASS", [loop("PASS", 0.01, 0.005, "y")])
    content["verification"][0]["text"] = "error of rate within 5 % from 0.1 deg/s on, reading at rest subtracted"
    heads, *_ = text = requirement_table(content).splitlines()
    assert heads.split()[:5] == ["requirement", "raw", "compensated", "limit", "verdict"]
    assert max(map(len, text)) <= 80
    assert any("to spare" in line for line in text)
