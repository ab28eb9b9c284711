"""Requirements on what every recording gives: sampling, saves, built-in test; and on what nothing gives."""

from __future__ import annotations

from pathlib import Path

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.engine.whole import check
from inertialcal.core.errors import PlanError
from ran_campaigns import TEST_LOW, lossy_twin

REQUIREMENTS = """
[[requirements]]
id = "often"
quantity = "save_interval"
lower = "1.9 s"
upper = "2.1 s"

[[requirements]]
id = "fast"
quantity = "sample_rate"
lower = "1 Hz"

[[requirements]]
id = "tested"
quantity = "built_in_test"
lower = "99.99 %"
tests = ["fit"]
"""


@pytest.mark.usefixtures("undrawn")
def test_a_test_is_judged_by_its_worst_recording(tmp_path: Path) -> None:
    folder = lossy_twin(tmp_path)
    file = folder / "campaign.toml"
    file.write_text(file.read_text() + REQUIREMENTS)
    results = run(folder, write=False).results
    found = {(one["requirement"], one["test"], one["axis"]): one for one in results["verdicts"]}
    assert found["often", "fit", ""]["verdict"] == "PASS"
    assert found["fast", "fit", ""]["verdict"] == "FAIL"
    assert [found["tested", "fit", axis]["verdict"] for axis in "xyz"] == ["FAIL", "PASS", "PASS"]
    assert "x_run1" in found["tested", "fit", "x"]["reason"]
    rows = [row for row in results["results"] if row["quantity"] == "built_in_test"]
    low = next(row for row in rows if row["axis"] == "x" and row["member"]["label"] == "x_run1")
    saves = next(one for one in results["sequence"] if one["test"] == "fit")["recordings"][0]["rows"]
    assert low["value"] == pytest.approx(100.0 * (1.0 - TEST_LOW / saves))
    assert found["tested", "fit", "x"]["reason"] == f"recording x_run1: {saves - TEST_LOW} of {saves} samples, counted"
    assert {row["test"] for row in rows} == {"fit"}


def test_a_quantity_that_nothing_gives_is_refused_with_its_line(tmp_path: Path) -> None:
    folder = lossy_twin(tmp_path)
    file = folder / "campaign.toml"
    text = file.read_text() + '\n[[requirements]]\nid = "R9"\nquantity = "g_rms"\nupper = "8 g"\n'
    file.write_text(text)
    with pytest.raises(PlanError) as refused:
        check(folder)
    (problem,) = refused.value.problems
    assert problem.code == "unknown_quantity"
    given = problem.do.removeprefix("The tests here give: ").split(", ")
    assert {"rate_error", "misalignment", "save_interval"} < set(given)
    assert "hysteresis" not in given  # of a thermal test, which this campaign has not
    line = text.splitlines().index('quantity = "g_rms"') + 1
    assert problem.where == f"campaign.toml:{line}"
