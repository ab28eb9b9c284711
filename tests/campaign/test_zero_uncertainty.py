"""A standard of exactly zero uncertainty asks for a reason, in campaigns and in options, and shows it."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load, standards_of
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.core.errors import PlanError, Problem
from inertialcal.core.schema.standards import STANDARDS, StandardEntry
from typed_commands import call_json

Write = Callable[..., Path]
ZERO = ("0 %", "0", "0.0 ppm", "-0 %")
REASON = "compared with itself"


@pytest.mark.parametrize("u", ZERO)
def test_zero_without_a_reason_is_refused_with_its_line(campaign: Write, u: str) -> None:
    for reason in ("", ', reason = " "'):
        with pytest.raises(PlanError) as refused:
            load(campaign(('u = "0.05 %", certificate = "C-1"', f'u = "{u}"{reason}')))
        (problem,) = refused.value.problems
        assert (problem.code, problem.where) == ("zero_uncertainty", "campaign.toml:7")
        assert "standards.rate_table.rate" in problem.what
        assert "reason" in problem.do


def test_a_zero_half_width_is_a_zero_uncertainty(campaign: Write) -> None:
    with pytest.raises(PlanError, match="exactly zero"):
        load(campaign(('u = "0.05 %", certificate = "C-1"', 'half_width = "0 %"')))


def test_zero_with_a_reason_is_shown_in_results_budget_and_report(campaign: Write) -> None:
    folder = campaign(('u = "0.05 %", certificate = "C-1"', f'u = "0 %", reason = "{REASON}"'))
    run(folder)
    results = json.loads((folder / "out" / "results.json").read_text())
    (standard,) = (one for one in results["standards"] if (one["standard"], one["influence"]) == ("rate_table", "rate"))
    assert (standard["u"], standard["reason"]) == (0.0, REASON)
    assert any(one["code"] == "zero_uncertainty" and REASON in one["what"] for one in results["remarks"])
    rows = [one for one in results["budgets"] if one["influence"] == "rate_table.rate"]
    assert rows
    assert all(REASON in one["source"] and one["share"] == 0.0 for one in rows)
    assert REASON in (folder / "out" / "report.html").read_text()


def test_an_option_asks_for_the_reason_too(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    file = str(campaign() / "one.csv")
    words = [file, "--axis", "x", "--column", "x=x", "--unit", "deg/s", "--applied", "rate", "--standard"]
    found = call_json(capsys, "rate-table", *words, "rate_table.rate=0 %")
    assert found["exit"] in (2, 3)
    assert [one["code"] for one in found["errors"]] == ["zero_uncertainty"]
    found = call_json(capsys, "rate-table", *words, f'rate_table.rate={{ u = "0 %", reason = "{REASON}" }}')
    assert found["exit"] == 0
    assert any(one["code"] == "zero_uncertainty" and REASON in one["what"] for one in found["remarks"])
    found = call_json(capsys, "rate-table", *words, "rate_table.rate={ u = 0")
    assert [one["code"] for one in found["errors"]] == ["not_toml"]


@pytest.mark.parametrize("name", [f"{one}.{two}" for one, inner in STANDARDS.items() for two in inner])
def test_an_uncertainty_that_is_no_quantity_is_answered_with_one_that_is(name: str) -> None:
    standard, _, quantity = name.partition(".")

    def problems(u: str) -> list[Problem]:
        standards = {standard: {quantity: StandardEntry(u=u)}}
        return standards_of(CampaignFile.model_construct(standards=standards), lambda *_: "")[1]

    for wrong in ("small", "3 V/s"):
        (problem,) = problems(wrong)
        assert problem.code == "wrong_value"
        assert not problems(problem.do.split('"')[1])
