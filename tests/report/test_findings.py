"""Findings and highlights pick the row that their rule names, and say it with its number."""

from __future__ import annotations

import re
from typing import Any

import pytest

from inertialcal.core.key import Case, Method
from inertialcal.core.show import wording
from inertialcal.report import findings
from inertialcal.report.findings import highlights
from inertialcal.report.numbers import Branch, Number, Text, both, digits, rounded, uncertainty, wrap
from inertialcal.report.sections import anchor, missing, table
from written_rows import fields


def row(quantity: str, axis: str, value: float | None, u: float | None = 0.01, **more: Any) -> dict[str, Any]:
    return {
        "quantity": quantity, "axis": axis, "test": "t", **fields(), "value": value, "u": u, "unit": "%",
        "dof": 5.0, "interval": None, "status": "estimated" if value is not None else "not_estimated",
    } | more  # fmt: skip


def verdict(word: str, margin: float | None = None, **more: Any) -> dict[str, Any]:
    return {
        "requirement": "R1", "test": "t", "axis": "x", "at": 2.0, "at_unit": "deg/s", "margin": margin, "unit": "%",
        "lower": -5.0, "upper": 5.0, "verdict": word,
    } | more  # fmt: skip


def axis(name: str, raw: float, left: float) -> dict[str, Any]:
    return {"axis": name, "raw_rms": raw, "compensated_rms": left, "unit": "deg/s", "verdict": "PASS"}


def plain(finding: findings.Finding) -> str:
    return re.sub("<[^>]*>", "", findings.html(finding))


def pointers(finding: findings.Finding) -> list[str]:
    return re.findall('data-at="([^"]*)"', findings.html(finding))


def results(**more: Any) -> Any:
    loop = {"verdict": "not run", "reason": "no test is held out", "axes": []}
    steps = [{"test": "t"}]
    return wrap({"results": [], "sequence": steps, "verdicts": [], "closed_loop": loop} | more, "")


def test_a_test_says_its_largest_scale_factor_error_and_verdicts() -> None:
    rows = wrap([row("scale_factor_error", "x", 0.2), row("scale_factor_error", "y", -0.7, 0.03)], "/results")
    judged = wrap([verdict("PASS"), verdict("INCONCLUSIVE")], "/verdicts")
    found = findings.of_test("rate_table", rows, judged)
    assert plain(found) == "Largest scale factor error -0.700 ± 0.030 %, on y; R1 INCONCLUSIVE"
    assert pointers(found) == ["/results/1/value", "/results/1/u"]


def test_a_moved_mass_says_its_scale_factor_runs_and_null_runs() -> None:
    rows = [
        row("scale_factor", "x", 10.31, 0.35, unit="count/s/ug"), row("high_g_difference", "x", 0.9, 3.5),
        row("response_amplitude", "x", 0.22, **fields("run 1 alone")),
        row("response_amplitude", "x", 0.24, **fields("run 2 alone")),
        row("null_response", "x", 0.001, 0.002, **fields("run n alone"), unit="ug"),
    ]  # fmt: skip
    assert plain(findings.of_test("mass_attraction", wrap(rows, ""), [])) == (
        "Scale factor 10.31 ± 0.35 count/s/ug from two runs with the mass moved; 0.9 ± 3.5 % off that at high g;"
        " with the mass at rest at most 0.0010 ± 0.0020 ug"
    )
    lost = [row("scale_factor", "x", None), *rows[2:4]]
    assert (
        plain(findings.of_test("mass_attraction", wrap(lost, ""), []))
        == "The response of two runs cannot be told from noise"
    )


def test_a_test_that_carries_nothing_says_so() -> None:
    assert (
        plain(findings.of_test("", wrap([row("bias", "x", None)], ""), []))
        == "No scale factor error could be estimated"
    )


@pytest.mark.parametrize(
    ("word", "verification", "axes", "said"),
    [
        (None, [], [], "gives no verdict"),
        ("PASS", [("R1", "PASS")], [], "All requirements are met, uncertainty included."),
        ("PASS", [("closed loop", "PASS")], [1], "Compensation improves hold-out readings."),
        ("INCONCLUSIVE", [("R1", "INCONCLUSIVE"), ("R2", "OPEN")], [], "No test covers R2."),
        ("INCONCLUSIVE", [("R1", "INCONCLUSIVE"), ("R2", "INCONCLUSIVE")], [], "The data cannot decide R1 and R2"),
        ("FAIL", [("R1", "FAIL"), ("R2", "PASS")], [], "R1: an interval lies entirely outside its limits."),
        ("FAIL", [("closed loop", "FAIL")], [1], "worse than raw, so no model is delivered"),
        ("FAIL", [("R1", "INCONCLUSIVE"), ("closed loop", "FAIL")], [1], "is delivered. The data cannot decide R1: "),
        ("FAIL", [("R1", "FAIL"), ("R2", "OPEN")], [], "outside its limits. No test covers R2."),
        ("INCONCLUSIVE", [("closed loop", "INCONCLUSIVE")], [1], "The data cannot show whether compensation improves"),
    ],
)
def test_the_verdict_says_why(
    word: str | None, verification: list[tuple[str, str]], axes: list[int], said: str
) -> None:
    stated = [{"requirement": name, "verdict": found, "decision": {}} for name, found in verification]
    rows = wrap(stated, "/verification")
    text = plain(findings.of_verdict(word, rows, wrap({"axes": axes}, "/closed_loop")))
    assert said in text
    assert text.endswith(".")
    assert "decide closed loop" not in text
    if said.startswith("R1:"):
        assert "R2" not in text


def test_the_box_of_the_verdict_says_the_rules_and_the_likeliest_to_be_wrong() -> None:
    basis = {"accept_lower": -4.0, "accept_upper": 4.0, "ratio": 5.0}
    matrix = [
        {"requirement": name, "rule": rule, "decision": {"rule": "guard_factor"}, "verdict": "PASS"}
        for name, rule in (("R1", "guard factor 1"), ("R2", "guard factor 1"), ("R3", "simple"), ("closed loop", ""))
    ]
    judged = [verdict("PASS", risk=0.001, **basis), verdict("FAIL", risk=0.2, **basis), verdict("OPEN", risk=None)]
    lines = findings.of_decision(wrap(matrix, "/verification"), wrap(judged, "/verdicts"))
    assert [plain(line) for line in lines] == [
        "R1 and R2: guard factor 1.",
        "R3: simple.",
        "The verdict most likely to be wrong: R1 FAIL (t x at 2 deg/s), with probability 0.2; PASS from -4 % up to 4 %;"
        " test uncertainty ratio 5.",
    ]
    text = plain(findings.of_verdict("FAIL", wrap([matrix[0] | {"verdict": "FAIL"}], "/verification"), wrap({}, "")))
    assert text == "R1: by its decision rule."


def test_the_closed_loop_says_the_axis_with_the_largest_error_left() -> None:
    loop = {"verdict": "PASS", "reason": "", "axes": [axis("x", 0.9, 0.001), axis("y", 0.02, 0.004)]}
    found = findings.of_closed_loop(wrap(loop, "/closed_loop"))
    assert "rms error of y" in plain(found)
    assert pointers(found) == ["/closed_loop/axes/1/raw_rms", "/closed_loop/axes/1/compensated_rms"]


def test_highlights_are_those_of_their_rules() -> None:
    loop = {"verdict": "PASS", "reason": "", "axes": [axis("x", 0.9, 0.001), axis("y", 0.02, 0.004)]}
    rows = [
        row("scale_factor_error", "x", 0.9),
        row("misalignment", "xy", -0.02, 0.001, unit="rad"),  # 0.02 rad counts as 2 %
        row("scale_factor_error", "z", 7.0, **fields("as_published")),
    ]
    first, second = highlights(results(closed_loop=loop, results=rows))
    assert "rms error of y" in plain(first.label)
    assert plain(second.figure) == "-0.0200 ± 0.0010 rad"


def test_an_angle_in_degrees_is_compared_with_errors() -> None:
    rows = [row("scale_factor_error", "x", 0.9), row("misalignment", "xy", -2.0, 0.1, unit="deg")]
    assert any(plain(one.figure) == "-2.00 ± 0.10 deg" for one in highlights(results(results=rows)))


def test_highlights_fall_back_where_there_is_no_loop_and_no_requirement() -> None:
    rows = [row("bias", "x", 0.1, unit="deg/s"), row("bias", "y", -0.3, unit="deg/s"), row("scale_factor", "x", 0.5)]
    found = highlights(results(results=rows))
    assert [pointers(one.figure)[0] for one in found] == ["/results/1/value", "/results/2/value"]
    assert highlights(results()) == []


def test_a_budget_says_the_source_with_the_largest_share() -> None:
    rows = wrap(
        [{"source": "a", "share": 0.2}, {"source": "b", "share": 0.8}, {"source": "c", "share": None}], "/budgets"
    )
    assert plain(findings.of_budget(rows)) == "Mostly b: 0.8 of the variance"


def left_out(count: int, counts: str, test: str = "t", rule: str = "edge") -> dict[str, Any]:
    return {"test": test, "rule": rule, "count": count, "counts": counts}


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "Nothing was left out"),
        ([left_out(1, "dwell"), left_out(1, "dwell", rule="at_rail")], "Two dwells left out, by two stated rules"),
        ([left_out(22, "sample"), left_out(22, "sample")], "Samples at two places left out, by one stated rule"),
        (
            [left_out(1, "dwell"), left_out(54, "row", "u", "not_chosen")],
            "One dwell and rows at one place left out, by two stated rules; "
            "items left out by several tests count once per test",
        ),
        ([left_out(4, "window", rule="settling")], "Parts of four windows left out, by one stated rule"),
    ],
)
def test_exclusions_are_counted_as_what_they_are(rows: list[dict[str, Any]], said: str) -> None:
    assert plain(findings.of_exclusions(wrap(rows, "/exclusions"))) == said


def test_texts_in_a_finding_are_escaped() -> None:
    assert "&lt;b&gt;" in findings.html(("<b>", Text("<b>")))
    assert "<b>" not in findings.html(("<b>", Text("<b>")))


@pytest.mark.parametrize(
    ("value", "u", "shown"),
    [
        (1.001247, 0.000418, ["1.00125", "0.00042"]),
        (-3.2e-7, 4.1e-8, ["-3.20e-07", "0.41e-07"]),
        (2.5, None, ["2.5"]),
        (2.5, 0.0, ["2.5"]),
    ],
)
def test_a_number_is_shown_to_its_uncertainty_and_each_part_reads_back(
    value: float, u: float | None, shown: list[str]
) -> None:
    number, uncertain = Number(value, "/a"), None if u is None else Number(u, "/b")
    text = str(both(number, uncertain))
    assert re.findall(">([^<]*)</data>", text) == shown
    assert float(shown[0]) == pytest.approx(value, rel=1e-3)
    assert str(rounded(number, uncertain)) in text
    if len(shown) > 1:
        assert str(uncertainty(number, uncertain)) in text


def test_absent_numbers_are_a_dash() -> None:
    assert rounded(None, None) == digits(None) == both(None, None) == uncertainty(None, None) == "–"


def test_pointers_escape_keys_and_hide_none() -> None:
    branch = wrap({"a/b": {"~": 1}, "at": 2, "get": 3, "content": 4}, "model:")
    assert branch["a/b"]["~"].at == "model:/a~1b/~0"
    assert branch["at"] == Number(2, "model:/at")
    with pytest.raises(TypeError, match="set is nothing that JSON holds"):
        wrap({1}, "/x")


def test_lines_put_other_ways_of_reduction_beside_the_default() -> None:
    rows = wrap([row("bias", "x", 1.0), row("bias", "x", 2.0, **fields("as_published")), row("bias", "y", None)], "")
    lines, ways = table(rows)
    assert ways == [Case(Method.TEXTBOOK)]
    assert lines[0].row is not None
    assert lines[0].row["value"].raw == 1.0
    assert lines[0].alternatives[Case(Method.TEXTBOOK)]["value"].raw == 2.0
    assert [len(found) for _, found in missing(rows)] == [1]


def test_anchors_differ_where_names_do_not_fit_an_id() -> None:
    assert anchor("test", "rate_x", 0) == "test-rate_x"
    assert anchor("test", "a b", 1) != anchor("test", "a.b", 2)


def test_counts_are_words() -> None:
    assert wording.counted(1, "warning") == "one warning"
    assert wording.severities(["info", "error", "info"]) == "one error and two notes"
    assert wording.count(100) == "a hundred"


@pytest.mark.parametrize(
    ("judged", "verdict", "words"),
    [
        (True, "PASS", "Model judged on hold-out readings: PASS"),
        (False, "INCONCLUSIVE", "Hold-out readings cannot show whether the model improves them"),
        (False, "not run", "Model not judged on hold-out readings"),
    ],
)
def test_what_readings_held_out_say_of_a_model(judged: bool, verdict: str, words: str) -> None:
    assert (
        "".join(map(str, findings.of_model(Branch({"judged": judged}, ""), Branch({"verdict": verdict}, "")))) == words
    )


def test_each_condition_has_its_own_judgement() -> None:
    rows = [{"condition": "air", "verdict": "INCONCLUSIVE"}, {"condition": "vacuum", "verdict": "PASS"}]
    loop = Branch({"verdict": "INCONCLUSIVE", "axes": rows, "over_temperature": []}, "")
    said = {
        name: "".join(map(str, findings.of_model(Branch({"judged": name == "vacuum"}, ""), loop, name)))
        for name in ("air", "vacuum", "orbit")
    }
    assert said["air"] == "Hold-out readings cannot show whether the model improves them"
    assert said["vacuum"] == "Model judged on hold-out readings: PASS"
    assert said["orbit"] == "Model not judged on hold-out readings"
