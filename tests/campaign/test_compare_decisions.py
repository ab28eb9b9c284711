"""Allowed changes by the decision rule that a contract names, and rules that cannot judge a difference."""

from __future__ import annotations

from pathlib import Path

import pytest

from inertialcal.campaign.compare.allowed_change import parse_allowed
from inertialcal.campaign.compare.compare import compare, judged
from inertialcal.campaign.compare.differences import differences
from inertialcal.campaign.file.decisions import read_decision
from inertialcal.cli.shown.model_text import comparison_text
from inertialcal.core.errors import UsageError
from inertialcal.core.key import Key
from inertialcal.core.results import Interval, Row
from written_rows import results_text

CHANGE = "0.5 deg/s"  # of a bias that changes by 0.4 with u = 0.1 sqrt 2


def bias(value: float) -> Row:
    return Row(Key("bias", "x"), value, 0.1, "deg/s", test="rate_x")


def written(folder: Path, row: Row) -> Path:
    (folder / "out").mkdir(parents=True)
    (folder / "out" / "results.json").write_text(results_text(item={"serial": "7"}, results=[row.to_dict()]))
    (folder / "out" / "provenance.json").write_text('{"inputs": []}')
    return folder


@pytest.mark.parametrize(
    ("decision", "status"),
    [
        ("", "INCONCLUSIVE"),
        ("interval", "INCONCLUSIVE"),
        ("simple_acceptance", "PASS"),
        ("guard_factor=0.3", "PASS"),
        ("false_accept_risk=2 %", "INCONCLUSIVE"),
        ("false_accept_risk=30 %", "PASS"),
        ("test_uncertainty_ratio=1.5", "PASS"),
        ("test_uncertainty_ratio=4", "INCONCLUSIVE"),
        ('{ rule = "guard_factor", factor = 1, binary = true }', "FAIL"),
    ],
)
def test_an_allowed_change_by_each_rule(tmp_path: Path, decision: str, status: str) -> None:
    found = compare(written(tmp_path / "a", bias(1.0)), written(tmp_path / "b", bias(1.4)), [CHANGE], decision)
    one = found.verdicts[0]
    assert (found.verdict, one["verdict"]) == (status, status)
    assert one["ratio"] == pytest.approx(0.5 / (1.959964 * 0.1 * 2**0.5))
    assert ("no change by" in comparison_text(found)) == (decision not in ("", "interval"))


@pytest.mark.parametrize(
    ("decision", "words"),
    [
        ("guard", "rule: "),
        ("guard_factor", "needs factor"),
        ("simple_acceptance=1", "of: Extra inputs"),
        ("guard_factor=wide", "not TOML"),
        ('{ rule = "false_accept_risk", risk = "2 %", process = { sd = "1 %" } }', "a global risk is about"),
    ],
)
def test_a_rule_that_cannot_be_read_is_refused(decision: str, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_decision(decision)
    assert caught.value.problems[0].code == "decision"
    assert words in caught.value.problems[0].what


def test_a_rule_without_an_allowed_change_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="without an allowed change"):
        compare(written(tmp_path / "a", bias(1.0)), written(tmp_path / "b", bias(1.4)), (), "simple_acceptance")


def test_a_scatter_has_its_own_interval_and_no_other_probability() -> None:
    rows = [
        Row(Key("scatter_run", "x"), value, 0.1, "deg/s", dof=10, interval=Interval(0.5, 1.9)) for value in (1.0, 1.1)
    ]
    found = differences([(rows[0], rows[1])])

    def status(decision: str) -> str:
        one = judged(found, parse_allowed(["scatter_run=0.2 deg/s"]), read_decision(decision))[0][0].no_change
        assert one is not None
        return one.status

    assert status("simple_acceptance") == "PASS"
    assert status("interval") == "INCONCLUSIVE"
    assert status("false_accept_risk=2 %") == "INCONCLUSIVE"
