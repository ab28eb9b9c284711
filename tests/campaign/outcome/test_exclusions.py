"""What was left out: counted as the remarks count it, decided by the rule that is named."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.outcome.exclusions import SAMPLES
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError
from inertialcal.procedures.rate_table import reduction as rate_table
from inertialcal.procedures.rate_table.exclusions import RULES
from ran_campaigns import TEST_LOW, Ran, ran

pytestmark = pytest.mark.usefixtures("undrawn")


def test_counts_are_those_of_the_remarks(campaign_ran: Ran) -> None:
    counted: Counter[tuple[str, str]] = Counter()
    for one in campaign_ran.prepared:
        for remark in rate_table.reduce(one.plan, one.readings).remarks:
            if remark.code in RULES or remark.code in SAMPLES:
                counted[one.test.id, remark.code] += remark.count
    found: Counter[tuple[str, str]] = Counter()
    for row in campaign_ran.results["exclusions"]:
        if row["rule"] in RULES or row["rule"] in SAMPLES:
            found[row["test"], row["rule"]] += row["count"]
    assert found == counted
    assert counted


def test_the_simulated_campaign_loses_what_was_put_in(simulated: Ran) -> None:
    rows = [row for row in simulated.results["exclusions"] if row["test"] == "fit"]
    low = [row for row in rows if row["rule"] == "test_low"]
    assert [(row["count"], row["counts"], row["decided_by"]) for row in low] == [
        (TEST_LOW, "sample", "rule: validity_minimum = 2.4 V")
    ]
    assert low[0]["place"].startswith("recordings/x_run1.csv:")
    incomplete = [row for row in rows if row["rule"] == "dwell_incomplete"]
    at_six = [row for row in incomplete if row["applied"] == 6.0]
    assert len(at_six) == 9  # three axes in three runs: beyond the converter
    assert {(row["unit"], row["decided_by"], row["count"]) for row in at_six} == {("deg/s", "rule: missing = 0.1", 1)}
    rail = sum(row["count"] for row in rows if row["rule"] == "rail")
    assert rail > 0
    assert {row["decided_by"] for row in rows if row["rule"] == "rail"} == {"rule: counts = [0, 4095]"}


def test_edges_are_counted_as_the_remark_says(simulated: Ran) -> None:
    for test in ("fit", "check"):
        rows = [row for row in simulated.results["exclusions"] if (row["test"], row["rule"]) == (test, "edge")]
        said = next(r for r in simulated.results["remarks"] if (r["code"], r["where"]) == ("dwells", test))
        assert f"{sum(row['count'] for row in rows)} dropped at their edges" in said["what"]
        assert {row["counts"] for row in rows} == {"sample"}


def test_the_wild_dwell_of_table_10_is_named(published: Ran) -> None:
    found = [r for r in published.results["exclusions"] if (r["test"], r["rule"]) == ("rate_x", "odd_scatter")]
    assert [(row["axis"], row["applied"], row["unit"]) for row in found] == [("x", 2.0, "deg/s")]
    assert found[0]["place"].startswith("table10_x.csv:")
    assert found[0]["decided_by"] == "rule: scatter_ratio = 3"
    assert "more than 3 times" in found[0]["reason"]
    rails = [r for r in published.results["exclusions"] if (r["test"], r["rule"]) == ("rate_x", "at_rail")]
    assert sorted(row["applied"] for row in rails) == [-5.0, -5.0, 5.0, 5.0]


def test_a_plan_that_decides_otherwise_is_named(campaign: Callable[..., Path]) -> None:
    folder = campaign(("zero_reference = true }", "zero_reference = true, rail_scatters = 2000.0 }"))
    rows = ran(folder).results["exclusions"]
    assert {row["decided_by"] for row in rows} == {"rule: rail_scatters = 2000"}
    assert {abs(row["applied"]) for row in rows} == {2.0, 4.0}  # 2000 * 0.004 = 8 of 10 deg/s


def test_groups_that_the_campaign_did_not_choose_are_one_row(campaign: Callable[..., Path]) -> None:
    found = ran(campaign(('recordings = ["one"]', 'recordings = ["one"]\ngroups = ["2"]')))
    (row,) = found.results["exclusions"]
    assert (row["rule"], row["decided_by"], row["count"], row["counts"]) == (
        "not_chosen",
        "campaign: groups",
        48,
        "row",
    )
    assert (row["place"], row["applied"], row["axis"]) == ("one.csv", None, "")


def test_rows_without_a_rate_are_counted(campaign: Callable[..., Path]) -> None:
    data = "rate,x,std,set,run\n" + "".join(
        f"{rate or ''},{1.01 * (rate or 1.0)},0.004,1,{run}\n"
        for run in range(1, 6)
        for rate in (-4.0, -2.0, 2.0, 4.0, None)
    )
    found = ran(campaign(data=data))
    (row,) = found.results["exclusions"]
    assert (row["rule"], row["count"], row["counts"]) == ("no_rate", 5, "row")
    remark = next(r for r in found.results["remarks"] if r["code"] == "missing_cells")
    assert remark["count"] == row["count"]


def test_a_group_that_no_row_is_in_is_refused(campaign: Callable[..., Path]) -> None:
    folder = campaign(('recordings = ["one"]', 'recordings = ["one"]\ngroups = ["1", "c"]'))
    with pytest.raises(DataError, match="no row of 'one' is in group 'c' of test 'first'") as refused:
        run(folder, write=False)
    assert refused.value.problems[0].do == "There are: '1', '2'"


def test_a_flip_counts_what_it_did_not_read(tmp_path: Path) -> None:
    simulate("sams_tsh", tmp_path / "flip", 1, fault="gain_changed")
    found = run(tmp_path / "flip").results
    told = {(one["rule"], one["axis"], one["counts"]): one["count"] for one in found["exclusions"]}
    assert told == {("settling", "", "window"): 4, ("gain_changed", "y", "dwell"): 1}
    assert [one["place"] for one in found["exclusions"][1:]] == [f"flip: window {i}" for i in (1, 2, 3, 4)]
    assert found["sequence"][0]["left_out"] == 4
