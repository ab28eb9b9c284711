"""Comparison of models and results: against Welch's test, its error rates on simulated figures, its words."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from inertialcal.campaign.compare.allowed_change import allowed_for, is_named, parse_allowed
from inertialcal.campaign.compare.compare import compare, judged
from inertialcal.campaign.compare.differences import Difference, differences, matched
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key, Method, Reason
from inertialcal.core.results import Row, not_estimated
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import Item, SensorModel
from inertialcal.statistics.intervals import binomial_interval, covers
from written_rows import results_text


def row(value: float | None, u: float | None = 0.1, dof: float | None = None, **rest: Any) -> Row:
    given = {"quantity": "bias", "axis": "x", "unit": "deg/s", "test": "rate_x"} | rest
    key = Key(given.pop("quantity"), given.pop("axis"), power=given.pop("power", 0))
    return Row(key, value, u, dof=dof, **given)


def one_difference(first: Row, second: Row) -> Difference:
    return differences([(first, second)])[0]


# One figure


@pytest.mark.parametrize(("n", "m"), [(5, 5), (4, 30), (12, 3)])
def test_a_lone_difference_is_welchs_test(n: int, m: int) -> None:
    """scipy's Welch test from means, standard deviations and numbers of readings; no surer where there are only 3."""
    found = one_difference(row(1.0, 0.3 / math.sqrt(n), n - 1), row(1.4, 0.2 / math.sqrt(m), m - 1))
    oracle = stats.ttest_ind_from_stats(1.4, 0.2, m, 1.0, 0.3, n, equal_var=False)
    assert found.p_value is not None
    few = 1.0 if min(n, m) > 3 else 2.5
    assert oracle.pvalue * (1.0 - 1e-12) <= found.p_value <= few * oracle.pvalue * (1.0 + 1e-12)
    variances = np.array([0.09 / n, 0.04 / m])
    dof = found.row.dof or math.inf
    welch = variances.sum() ** 2 / (variances**2 / [n - 1, m - 1]).sum()
    assert min(n, m) - 1 <= dof <= welch * (1.0 + 1e-12)
    assert dof == pytest.approx(welch) or min(n, m) == 3
    assert found.row.value == pytest.approx(0.4)
    assert found.row.u == pytest.approx(math.sqrt(variances.sum()))
    half = stats.t.ppf(0.975, dof) * math.sqrt(variances.sum())
    assert found.row.interval is not None
    assert found.row.interval.lo == pytest.approx(0.4 - half)
    assert found.row.interval.hi == pytest.approx(0.4 + half)
    assert found.word == ("different" if found.p_value <= 0.05 else "not shown different")


def test_known_uncertainties_give_the_normal_test() -> None:
    found = one_difference(row(0.0, 0.3), row(-1.0, 0.4))
    assert found.row.u == pytest.approx(0.5)
    assert found.row.dof is None
    assert found.p_value == pytest.approx(2.0 * stats.norm.sf(2.0))
    assert found.word == "different"
    assert one_difference(row(0.0, 0.3), row(0.9, 0.4)).word == "not shown different"


def test_one_side_may_be_exact() -> None:
    found = one_difference(row(1.0, 0.0), row(1.5, 0.1, 4))
    assert found.row.u == pytest.approx(0.1)
    assert found.row.dof == pytest.approx(4.0)


NOT_COMPARED = [
    (
        not_estimated(Key("bias", "x"), "deg/s", Reason("not_read", "no readings")),
        row(1.0),
        "first: not estimated (no readings)",
        None,
    ),
    (row(1.0), row(1.2, status="upper_limit"), "second: upper limit", 0.2),
    (row(1.0, None), row(1.2), "first: no uncertainty", 0.2),
    (row(1.0), row(1.2, 0.1, 0.0), "second: no degrees of freedom", 0.2),
    (row(1.0, 0.0), row(1.2, 0.0), "both have an uncertainty of 0", 0.2),
]


@pytest.mark.parametrize(("first", "second", "reason", "value"), NOT_COMPARED)
def test_what_cannot_be_compared_says_why(first: Row, second: Row, reason: str, value: float | None) -> None:
    found = one_difference(first, second)
    assert found.word == "not compared"
    assert found.p_value is None
    assert (found.row.status, found.row.u, found.row.interval) == ("not_estimated", None, None)
    assert found.row.value == (None if value is None else pytest.approx(value))
    assert found.row.reason.text == reason


# Several figures


def test_holm_over_the_rows_compared() -> None:
    """p of 0.01, 0.02, 0.03 and one that counts not: 0.01 <= 0.05/3, 0.02 <= 0.05/2, 0.03 <= 0.05."""
    values = [float(stats.norm.isf(p / 2.0)) for p in (0.03, 0.01, 0.02)]
    pairs = [(row(0.0, 0.0), row(value, 1.0)) for value in values]
    assert [d.word for d in differences(pairs)] == ["different"] * 3
    lost = not_estimated(Key("bias", "y"), "deg/s", Reason("not_read", "why"))
    assert [d.word for d in differences([*pairs, (lost, lost)])] == ["different"] * 3 + ["not compared"]
    more = [*pairs, (row(0.0), row(0.0))]  # now 0.01 <= 0.05/4, and 0.02 > 0.05/3 ends it
    assert [d.word for d in differences(more)] == [
        "not shown different", "different", "not shown different", "not shown different",
    ]  # fmt: skip


def simulated(seed: int, shift: float = 0.0, k: int = 12, dof: int = 5) -> tuple[Difference, ...]:
    """Figures of two campaigns with one truth (shifted in the first figure), u estimated from scatter."""
    rng = np.random.default_rng(seed)
    sides = []
    for side in range(2):
        truth = np.arange(k) + shift * (side == 1) * (np.arange(k) == 0)
        u = 0.1 * (side + 1) * np.sqrt(rng.chisquare(dof, k) / dof)
        sides.append([row(v, s, dof) for v, s in zip(truth + rng.normal(0.0, 0.1 * (side + 1), k), u, strict=True)])
    return differences(list(zip(*sides, strict=True)))


def test_equal_campaigns_are_called_different_in_at_most_5_percent() -> None:
    n = 300
    false = sum(any(one.word == "different" for one in simulated(seed)) for seed in range(1, n + 1))
    assert binomial_interval(false, n)[0] <= 0.05


def test_a_true_difference_is_found() -> None:
    assert all(simulated(seed, shift=3.0)[0].word == "different" for seed in range(1, 30))


def test_a_change_of_one_quantity_is_not_lost_among_the_others() -> None:
    """Six times its scatter, of which 4 degrees of freedom are known on each side, among 12 figures of 4 quantities."""
    rng = np.random.default_rng(5)
    names, n, found = ("bias", "scale_factor_error", "misalignment", "scale_factor_asymmetry"), 200, 0
    for _ in range(n):
        pairs = []
        for name in names:
            for axis in "xyz":
                change = 6.0 * (name == "scale_factor_error")
                values = rng.normal((0.0, change), 0.5**0.5)
                u = np.sqrt(0.5 * rng.chisquare(4, 2) / 4)
                pairs.append(tuple(row(v, s, 4.0, quantity=name, axis=axis) for v, s in zip(values, u, strict=True)))
        changed = [one for one in differences(pairs) if one.row.quantity == "scale_factor_error"]  # type: ignore[arg-type]
        found += all(one.word == "different" for one in changed)
    assert found > 0.9 * n


def test_coverage_of_the_difference() -> None:
    hits = n = 0
    for seed in range(1, 301):
        for found in simulated(seed, k=1):
            assert found.row.interval is not None
            n, hits = n + 1, hits + (found.row.interval.lo <= 0.0 <= found.row.interval.hi)  # type: ignore[operator]
    assert covers(hits, n)


VALUE, U, DOF = st.floats(-10, 10), st.floats(0.01, 1), st.floats(1, 50)
FIGURES = st.lists(st.tuples(VALUE, VALUE, U, U, DOF, DOF), min_size=1, max_size=6)


@settings(max_examples=50, deadline=None)
@given(FIGURES, st.floats(0.01, 100.0))
def test_order_and_unit_do_not_matter(figures: Sequence[tuple[float, ...]], scale: float) -> None:
    pairs = [(row(a, u, m), row(b, v, n)) for a, b, u, v, m, n in figures]
    there, back = differences(pairs), differences([(b, a) for a, b in pairs])
    scaled = differences([(row(a * scale, u * scale, m), row(b * scale, v * scale, n)) for a, b, u, v, m, n in figures])
    for one, other, big in zip(there, back, scaled, strict=True):
        assert one.row.value == -(other.row.value or 0.0) or one.row.value == other.row.value == 0.0
        assert one.row.u == pytest.approx(other.row.u)
        assert big.row.u == pytest.approx((one.row.u or 0.0) * scale)
        assert one.p_value == pytest.approx(other.p_value)
        assert big.p_value == pytest.approx(one.p_value, rel=1e-6, abs=1e-12)


# Which rows belong together


def test_rows_are_matched_by_what_they_are() -> None:
    first = [
        row(1.0, test="a"),
        row(2.0, axis="y", test="a"),
        row(3.0, condition="vacuum", test="a"),
        row(9.0, axis="z"),
    ]
    second = [
        row(1.5, test="b"),
        row(2.5, axis="y", test="a"),
        row(7.0, axis="y", test="b"),
        row(3.5, test="c", condition="vacuum"),
    ]
    pairs, remarks = matched(first, second)
    assert [(a.value, b.value) for a, b in pairs] == [(1.0, 1.5), (2.0, 2.5), (3.0, 3.5)]
    assert {(r.code, r.count) for r in remarks} == {("only_in_first", 1), ("only_in_second", 1)}
    assert differences(pairs)[0].row.test == "a / b"
    assert differences(pairs)[1].row.test == "a"


def test_a_figure_that_stands_twice_is_never_guessed() -> None:
    pairs, remarks = matched([row(1.0, test="a")], [row(1.5, test="b"), row(1.6, test="c")])
    assert pairs == []
    assert {(r.code, r.count) for r in remarks} == {("only_in_first", 1), ("only_in_second", 2)}


def test_the_second_is_turned_into_the_unit_of_the_first() -> None:
    pairs, _ = matched([row(1.0, 0.1)], [row(math.radians(2.0), math.radians(0.2), unit="rad/s")])
    assert pairs[0][1].value == pytest.approx(2.0)
    assert pairs[0][1].u == pytest.approx(0.2)
    assert pairs[0][1].unit == "deg/s"
    warm, _ = matched([row(20.0, 0.1, unit="degC")], [row(293.15, 0.2, unit="K")])
    assert warm[0][1].value == pytest.approx(20.0)
    assert warm[0][1].u == pytest.approx(0.2)


def test_units_of_two_kinds_are_counted() -> None:
    pairs, remarks = matched([row(1.0)], [row(1.0, unit="ug")])
    assert pairs == []
    assert [(r.code, r.count) for r in remarks] == [("unit_mismatch", 1)]


# What change is allowed


def test_allowed_changes_are_read_in_the_unit_of_the_figure() -> None:
    stated = parse_allowed(["0.1 %", "bias=0.01 rad/s", "scale_factor=2 mV/(deg/s)", "misalignment=5 %"])
    assert allowed_for(row(1.0), stated) == pytest.approx(math.degrees(0.01))
    assert allowed_for(row(0.5, unit="%", quantity="scale_factor_error"), stated) == pytest.approx(0.1)
    assert allowed_for(row(0.5, unit="1", quantity="scale_factor_error"), stated) == pytest.approx(0.001)
    assert allowed_for(row(0.5, unit="V/(deg/s)", quantity="scale_factor"), stated) == pytest.approx(0.002)
    assert allowed_for(row(-0.02, unit="rad", quantity="misalignment"), stated) == pytest.approx(0.001)
    assert allowed_for(row(0.02, quantity="resolution"), stated) is None
    assert is_named(row(1.0), stated)
    assert not is_named(row(1.0, quantity="resolution"), stated)


def test_percent_of_a_scale_factor_is_relative_and_of_a_bias_is_not() -> None:
    general = parse_allowed(["0.1 %"])
    assert allowed_for(row(-0.5, unit="V/(deg/s)", quantity="scale_factor"), general) == pytest.approx(5e-4)
    assert allowed_for(row(1.0), general) is None
    assert allowed_for(row(0.0, unit="V/(deg/s)", quantity="scale_factor"), general) is None
    assert allowed_for(row(1.0), parse_allowed(["0.01 deg/s"])) == pytest.approx(0.01)


@pytest.mark.parametrize("text", ["", "x", "bias=", "=1 %", "-1 %", "0 deg/s", "bias=1 furlong"])
def test_what_is_no_change_is_wrong_usage(text: str) -> None:
    with pytest.raises(UsageError, match="allowed change"):
        parse_allowed([text])


def test_two_changes_for_one_quantity_are_wrong_usage() -> None:
    with pytest.raises(UsageError, match="two allowed changes"):
        parse_allowed(["bias=1 deg/s", "bias=2 deg/s"])


def test_a_change_of_another_dimension_is_refused() -> None:
    with pytest.raises(DataError, match="allowed change of bias: 1 g for a figure in 'deg/s'") as caught:
        allowed_for(row(1.0), parse_allowed(["bias=1 g"]))
    assert caught.value.problems[0].code == "unit_mismatch"


def test_not_shown_different_is_not_unchanged() -> None:
    poor = differences([(row(1.0, 0.5), row(1.0, 0.5))])
    good = differences([(row(1.0, 0.001), row(1.0, 0.001))])
    other = differences([(row(1.0, 0.001), row(1.5, 0.001))])
    stated = parse_allowed(["0.1 deg/s"])
    statuses = [judged(found, stated)[0][0].no_change for found in (poor, good, other)]
    assert [one.status for one in statuses if one is not None] == ["INCONCLUSIVE", "PASS", "FAIL"]
    assert poor[0].word == good[0].word == "not shown different"


def test_general_changes_judge_what_was_compared_and_named_ones_all() -> None:
    lost = not_estimated(Key("bias", "y"), "deg/s", Reason("not_read", "no readings"))
    pairs = [
        (row(1.0, 0.001), row(1.0, 0.001)),
        (row(1.0, 0.001, method=Method.TEXTBOOK), row(9.0, 0.001, method=Method.TEXTBOOK)),
        (lost, lost),
    ]
    general, remarks = judged(differences(pairs), parse_allowed(["0.1 deg/s"]))
    assert [one.no_change and one.no_change.status for one in general] == ["PASS", None, None]
    assert [(one.code, one.count) for one in remarks] == [("not_judged", 2)]
    named, _ = judged(differences(pairs), parse_allowed(["bias=0.1 deg/s"]))
    assert [one.no_change and one.no_change.status for one in named] == ["PASS", "FAIL", "INCONCLUSIVE"]


def test_a_change_that_judges_nothing_is_refused() -> None:
    with pytest.raises(DataError, match="no figure in both that the allowed change can judge"):
        judged(differences([(row(1.0), row(1.0))]), parse_allowed(["1 g"]))


# Files


def results(folder: Path, *rows: Row, inputs: dict[str, str] | None = None, **rest: Any) -> Path:
    """A campaign that was run: results and provenance."""
    out = folder / "out"
    out.mkdir(parents=True)
    members: dict[str, Any] = {"item": {"serial": "7"}, "results": [one.to_dict() for one in rows]}
    (out / "results.json").write_text(results_text(**members | rest))
    listed = [{"path": path, "sha256": digest} for path, digest in (inputs or {}).items()]
    (out / "provenance.json").write_text(json.dumps({"inputs": listed}))
    return folder


def model(bias: float = 0.1, serial: str = "7", u: float = 1e-3, source: str = "table rate") -> SensorModel:
    names = ("bias_x", "scale_factor_error_x")
    parts = (Component("scatter", "A", np.eye(2) * u**2, 6.0), Component(source, "B", np.eye(2) * u**2))
    estimate = Estimate(names, np.array([bias, -0.005]), ("rad/s", "1"), parts)
    return model_from(estimate, "gyro", ("x",), 28.6, "V", item=Item(serial=serial))


def codes(found: Any) -> set[str]:
    return {remark.code for remark in found.remarks}


def test_two_campaigns(tmp_path: Path) -> None:
    one = results(tmp_path / "a", row(1.0, 0.1, 5), inputs={"campaign.toml": "0", "x.csv": "1"})
    other = results(tmp_path / "b", row(1.9, 0.1, 5), inputs={"campaign.toml": "0", "x.csv": "2"})
    found = compare(one, other)
    assert found.kind == "results"
    assert found.differences[0].word == "different"
    assert codes(found) == {"taken_as_independent"}
    assert found.exit_status == 0
    assert set(found.inputs) == {str(one / "out/results.json"), str(other / "out/results.json")}
    assert compare(one / "out/results.json", other).differences[0].p_value == found.differences[0].p_value


@pytest.mark.parametrize(
    ("allowed", "verdict", "status"),
    [("2 deg/s", "PASS", 0), ("0.1 deg/s", "FAIL", 1), ("0.5 deg/s", "INCONCLUSIVE", 4)],
)
def test_exit_status_of_an_allowed_change(tmp_path: Path, allowed: str, verdict: str, status: int) -> None:
    found = compare(results(tmp_path / "a", row(1.0, 0.1)), results(tmp_path / "b", row(1.5, 0.1)), [allowed])
    assert (found.verdict, found.exit_status) == (verdict, status)
    assert found.verdicts[0]["verdict"] == verdict
    assert found.verdicts[0]["upper"] == pytest.approx(float(allowed.removesuffix(" deg/s")))


def test_what_both_share_is_remarked(tmp_path: Path) -> None:
    blank = {"quantity": "bias", "axis": "x", "sensor": "", "power": 0, "at": None, "test": "rate_x", "influence": "",
             "distribution": "normal", "stated_u": None, "stated_unit": "", "sensitivity": None,
             "sensitivity_unit": "", "u": 0.1, "unit": "deg/s", "dof": None, "share": 0.5, "level": ""}  # fmt: skip
    budgets = [{**blank, "source": "table rate", "kind": "B"}, {**blank, "source": "scatter", "kind": "A"}]
    one = results(tmp_path / "a", row(1.0), inputs={"x.csv": "1"}, budgets=budgets)
    other = results(tmp_path / "b", row(1.0), inputs={"y.csv": "1"}, budgets=budgets, item={"serial": "8"})
    found = {remark.code: remark for remark in compare(one, other).remarks}
    assert "x.csv" in found["same_recordings"].what
    assert "table rate" in found["standards_may_be_shared"].what
    assert "scatter" not in found["standards_may_be_shared"].what
    assert "'7' and '8'" in found["different_serials"].what
    assert "same_file" in codes(compare(one, one))


def test_two_models_in_units_of_the_field(tmp_path: Path) -> None:
    write_model(tmp_path / "a.json", model(0.1))
    write_model(tmp_path / "b.json", model(0.2, serial="8"))
    found = compare(tmp_path / "a.json", tmp_path / "b.json")
    assert found.kind == "models"
    bias = next(one for one in found.differences if one.row.quantity == "bias")
    assert bias.row.unit == "deg/s"
    assert bias.row.value == pytest.approx(math.degrees(0.1))
    assert bias.row.u == pytest.approx(math.degrees(2e-3))  # two sides, A and B each: 1e-3 times 2
    assert 6.0 < (bias.row.dof or math.inf) < 4 * 4 / (2 / 6.0)  # Welch: (4 v)^2 over two Type A parts of v^2/6
    assert bias.word == "different"
    assert {"standards_may_be_shared", "different_serials"} <= codes(found)


def test_a_folder_stands_for_its_model_beside_a_model(tmp_path: Path) -> None:
    folder = results(tmp_path / "a", row(1.0))
    write_model(folder / "out/model.json", model(0.1))
    write_model(tmp_path / "b.json", model(0.1, source="tilt"))
    found = compare(folder, tmp_path / "b.json")
    assert found.kind == "models"
    assert "standards_may_be_shared" not in codes(found)
    assert {one.word for one in found.differences} == {"not shown different"}


REFUSED = [
    ("model.json", "results.json", "different_kinds", "one is a model, the other holds results"),
    ("results.json", "empty", "no_results", "no results here"),
    ("results.json", "gone.json", "missing_file", "no such file"),
    ("results.json", "text.json", "not_json", "no JSON"),
    ("results.json", "list.json", "schema", "no object"),
    ("results.json", "other.json", "schema", "neither a model nor results"),
    ("results.json", "rows.json", "schema", r"results.0.axis: Field required"),
    ("results.json", "apart.json", "no_shared_quantity", "no figure stands in both"),
    ("model.json", "edited.json", "checksum", "the checksum does not match the content"),
]


@pytest.mark.parametrize(("first", "second", "code", "words"), REFUSED)
def test_what_cannot_be_compared_is_refused(tmp_path: Path, first: str, second: str, code: str, words: str) -> None:
    (tmp_path / "empty").mkdir()
    write_model(tmp_path / "model.json", model())
    (tmp_path / "edited.json").write_text((tmp_path / "model.json").read_text().replace("-0.005", "-0.006"))
    texts = {
        "results.json": results_text(results=[row(1.0).to_dict()]),
        "apart.json": results_text(results=[row(1.0, axis="y").to_dict()]),
        "text.json": "not { json",
        "list.json": "[1]",
        "other.json": '{"a": 1}',
        "rows.json": results_text(results=[{"quantity": "bias"}, 3]),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(DataError, match=words) as caught:
        compare(tmp_path / first, tmp_path / second)
    assert caught.value.problems[0].code == code
    assert caught.value.problems[0].where


def test_provenance_that_cannot_be_read_is_no_provenance(tmp_path: Path) -> None:
    one, other = (results(tmp_path / name, replace(row(1.0), value=value)) for name, value in (("a", 1.0), ("b", 2.0)))
    (one / "out/provenance.json").write_text("{")
    assert "same_recordings" not in codes(compare(one, other))


# Standard deviations


def scatter(value: float, dof: float | None) -> Row:
    return row(value, value / math.sqrt(2.0 * (dof or 1.0)), dof, quantity="scatter_run")


def test_scatters_are_compared_by_their_ratio() -> None:
    found = one_difference(scatter(1.0, 3), scatter(3.0, 30))
    assert found.p_value == pytest.approx(2.0 * stats.f.sf(9.0, 30, 3))
    assert found.row.interval is not None
    assert (found.row.interval.lo or 0.0) < 0.0 < (found.row.interval.hi or 0.0)
    assert one_difference(scatter(1.0, None), scatter(3.0, 30)).row.reason.text.startswith(
        "first: a standard deviation"
    )


def test_no_change_of_a_scatter_goes_by_its_own_interval() -> None:
    pair = differences([(scatter(1.0, 20), scatter(1.1, 20))])
    interval = pair[0].row.interval
    assert interval is not None
    reach = max(-(interval.lo or 0.0), interval.hi or 0.0)
    for limit, status in ((reach * 1.01, "PASS"), (reach * 0.99, "INCONCLUSIVE")):
        verdict = judged(pair, parse_allowed([f"scatter_run={limit} deg/s"]))[0][0].no_change
        assert verdict is not None
        assert (verdict.status, verdict.interval) == (status, interval)
    apart = differences([(scatter(1.0, 200), scatter(9.0, 200))])
    failed = judged(apart, parse_allowed(["1 deg/s"]))[0][0].no_change
    assert failed is not None
    assert failed.status == "FAIL"
