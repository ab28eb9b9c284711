"""The published campaign of 1969: Table 4 through `run`, as published and as it may be claimed."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.core.errors import InertialcalError
from inertialcal.core.show.rows import case_name

Rows = Mapping[tuple[str, str, str], Mapping[str, Any]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_example("reinel1969", tmp_path_factory.mktemp("published") / "reinel1969")


@pytest.fixture(scope="module")
def results(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = run(folder).results
    return found


@pytest.fixture(scope="module")
def rows(results: dict[str, Any]) -> Rows:
    return {(row["test"], row["quantity"], case_name(row)): row for row in results["results"]}


def test_the_published_scale_factor_and_that_without_subtraction(rows: Rows) -> None:
    then, now = (rows["after_work", "scale_factor", condition] for condition in ("as_published", ""))
    assert {then["unit"], now["unit"]} == {"count/s/g"}
    assert (then["value"], then["u"]) == (pytest.approx(1.0435e7, rel=1e-4), pytest.approx(0.087e7, rel=6e-3))
    assert (now["value"], now["u"]) == (pytest.approx(1.205e7, rel=1e-3), pytest.approx(0.061e7, rel=1e-2))


def test_its_disagreement_with_the_data_sheet_is_told_and_not_decided(results: dict[str, Any], rows: Rows) -> None:
    said = {(one["code"], one["where"]) for one in results["remarks"]}
    assert ("disagrees_with_high_g", "after_work") in said
    off = rows["after_work", "high_g_difference", ""]
    assert off["unit"] == "%"
    assert off["interval"]["lo"] > 0.0
    assert results["verdict"] == "INCONCLUSIVE"


def test_null_runs_are_zero_within_their_noise(rows: Rows) -> None:
    for name in ("5", "6"):
        null = rows["after_work", "null_response", f"run {name} alone"]
        assert null["interval"]["lo"] < 0.0 < null["interval"]["hi"]


def test_the_budget_adds_up_and_has_the_applied_acceleration(results: dict[str, Any]) -> None:
    mine = [one for one in results["budgets"] if (one["test"], one["quantity"]) == ("after_work", "scale_factor")]
    assert {one["source"] for one in mine} == {"noise within the runs", "acceleration applied"}
    assert sum(one["share"] for one in mine) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (",yes\n2,", ",maybe\n2,", "'maybe'"), ("0.0217,", "0,", "noise 0"), ("0.2780,", ",", "a run needs all three"),
    ],
)  # fmt: skip
def test_a_table_that_tells_less_is_refused_with_its_row(
    folder: Path, tmp_path: Path, old: str, new: str, words: str
) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("out"))
    table = copy / "table4.csv"
    table.write_text(table.read_text().replace(old, new, 1))
    with pytest.raises(InertialcalError, match=words) as caught:
        run(copy)
    assert "table4.csv:2" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('unit = "count/s"', 'unit = "V"', "responses in V, but the sensor gives count/s"),
        ('applied_unit = "ng"', 'applied_unit = "cm"', "not a unit of acceleration"),
        ('u_applied = "0.2 ng"', 'u_applied = "0.2 cm"', "u_applied"),
    ],
)
def test_a_campaign_file_that_does_not_fit_is_refused(
    folder: Path, tmp_path: Path, old: str, new: str, words: str
) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("out"))
    file = copy / "campaign.toml"
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InertialcalError, match=words):
        run(copy)
