"""An error in the remarks of a test: no model, no verdict, and the exit status says so."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.campaign.engine.engine import in_order, prepare, reduce_test
from inertialcal.campaign.file.load import load
from inertialcal.campaign.models.find import find_model
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.core.remarks import Remark
from inertialcal.procedures import procedure_of

WRONG = Remark("sign_disagrees", "error", "recording one: x reads with the wrong sign", "one.csv", do="Check it")


@pytest.fixture
def disagreeing(monkeypatch: pytest.MonkeyPatch) -> None:
    rate_table = type(procedure_of("rate_table"))
    monkeypatch.setattr(rate_table, "agreement", lambda self, plan, readings: [WRONG])
    monkeypatch.setattr(rate_table, "agreement_many", None)


def ended(*words: str) -> int:
    with pytest.raises(SystemExit) as status:
        main([*words])
    return int(status.value.code or 0)


def test_a_campaign_makes_no_model_and_is_inconclusive(
    disagreeing: None, campaign: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = campaign()
    assert ended("run", str(folder), "--json") == 4
    content = json.loads(capsys.readouterr().out)
    assert content["remarks"][0]["code"] == "sign_disagrees"
    assert {one["verdict"] for one in content["verdicts"]} == {"INCONCLUSIVE"}
    assert all(WRONG.what in one["reason"] for one in content["verdicts"] if one["test"])
    assert WRONG.what in content["closed_loop"]["reason"]
    assert not (folder / "out" / "model.json").exists()
    with pytest.raises(DataError, match="the last run of this campaign gave no model") as error:
        find_model(folder)
    assert error.value.problems[0].why == f"first: one.csv: {WRONG.what}"


def test_check_says_so_and_ends_with_the_same_status(
    disagreeing: None, campaign: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = campaign()
    assert ended("check", str(folder)) == 4
    said = capsys.readouterr().out
    assert WRONG.what in said
    assert "recordings disagree, no model is made: 1 test, 1 recording" in said
    assert ended("check", str(folder), "--json") == 4
    assert json.loads(capsys.readouterr().out)["exit"] == 4


def test_what_a_test_disagrees_by_stands_before_why_it_cannot_be_reduced(
    disagreeing: None, campaign: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(self: object, plan: object, readings: object) -> None:
        raise DataError("no line", code="no_line")

    prepared = prepare(load(campaign()), 0)
    monkeypatch.setattr(type(procedure_of("rate_table")), "reduce", refused)
    with pytest.raises(DataError) as error:
        reduce_test(prepared)
    assert [one.code for one in error.value.problems] == ["sign_disagrees", "no_line"]


def test_a_command_prints_figures_and_refuses_the_model(
    disagreeing: None, campaign: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = campaign()
    table, model = str(folder / "one.csv"), folder / "model.json"
    assert ended("rate-table", table, "--unit", "deg/s", "--axis", "x") == 4
    said = capsys.readouterr().out
    assert "scale factor" in said
    assert "error: one.csv: recording one: x reads with the wrong sign" in said
    assert ended("rate-table", table, "--unit", "deg/s", "--axis", "x", "-o", str(model)) == 3
    assert WRONG.what in capsys.readouterr().err
    assert not model.exists()
    found = ic.rate_table(table, units="deg/s", axis="x")
    assert (found.models, found.exit_status) == ({}, 4)


def test_a_change_in_mid_record_comes_first_and_stands_for_what_follows_from_it() -> None:
    change = Remark("unit_changed", "error", "recording one: the unit changes", "one.csv:700", recording="one")
    following = [
        Remark("gain_disagrees", "error", "one reads less", "one.csv"),
        Remark("level_step", "warning", "x: the level steps", "one.csv:698", recording="one, window 1"),
    ]
    of_another = [
        WRONG,
        Remark("gain_disagrees", "error", "two reads less", "two.csv"),
        Remark("not_at_rest", "warning", "x: not at rest"),
    ]
    assert in_order([*of_another, *following, change], ["one", "two"]) == (change, *of_another)
    assert in_order([*of_another, *following, change], ["one"]) == (change, *of_another[:2])
    assert in_order([*following, *of_another], ["one", "two"])[0] is following[0]
