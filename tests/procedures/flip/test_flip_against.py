"""A flip set beside another: what a campaign file may say, and what is refused with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.core.errors import InertialcalError
from inertialcal.core.show.rows import reason_text

pytestmark = pytest.mark.usefixtures("undrawn")

TABLE = "axis,orientation,mean_ug,predicted_mg\ny,0,{0},1.0\ny,180,{1},1.002\nz,0,{2},\nz,180,{3},\n"
TOML = """
schema = 2
[campaign]
id = "two"
[sensors.head]
kind = "accelerometer"
axes = ["x", "y", "z"]
unit = "ug"
[recordings.a]
sensor = "head"
file = "a.csv"
means = {{ axis = "axis", position = "orientation", mean = "mean_ug", unit = "ug", predicted = "predicted_mg", angles = {{ 0 = "0 deg", 180 = "180 deg" }} }}
[recordings.b]
sensor = "head"
file = "b.csv"
means = {{ axis = "axis", position = "orientation", mean = "mean_ug", unit = "ug", angles = {{ 0 = "0 deg", 180 = "180 deg" }} }}
[[tests]]
id = "new"
procedure = "flip"
recordings = ["a"]
use = "report_only"
against = "{against}"
plan = {{ axis = "{axis}", corrected = true }}
[[tests]]
id = "old"
procedure = "flip"
recordings = ["b"]
use = "report_only"
plan = {{ axis = "x", corrected = {corrected} }}
"""  # noqa: E501 - an inline table of TOML is one line


def campaign(folder: Path, against: str = "old", axis: str = "x", corrected: str = "true") -> Path:
    (folder / "a.csv").write_text(TABLE.format(4.0, 2.0, -5.0, -7.0))
    (folder / "b.csv").write_text(TABLE.format(-9.0, -11.0, 6.0, 4.0))
    (folder / "campaign.toml").write_text(TOML.format(against=against, axis=axis, corrected=corrected))
    return folder


def test_one_flip_of_means_has_values_and_the_reason_why_no_uncertainty(tmp_path: Path) -> None:
    found = run(campaign(tmp_path)).results
    rows = {(row["quantity"], row["axis"]): row for row in found["results"] if row["test"] == "new"}
    assert rows["model_bias_error_change", "y"]["value"] == pytest.approx(3.0 - -10.0)
    assert rows["model_bias_error_reduction", "y"]["value"] == pytest.approx(10.0 - 3.0)
    assert rows["model_bias_error_reduction", "z"]["value"] == pytest.approx(5.0 - 6.0)
    assert "no record of the noise" in reason_text(rows["model_bias_error_change", "y"])
    assert [step["against"] for step in found["sequence"]] == ["old", None]


def test_a_prediction_has_the_unit_of_its_head(tmp_path: Path) -> None:
    rows = {(row["quantity"], row["axis"]): row for row in run(campaign(tmp_path)).results["results"]}
    assert rows["predicted_bias", "y"]["value"] == pytest.approx(1001.0)
    assert rows["corrected_bias", "y"]["value"] == pytest.approx(1004.0)
    assert ("predicted_bias", "z") not in rows


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"against": "nobody"}, "against = 'nobody' is no other flip test of this campaign"),
        ({"against": "new"}, "against = 'new' is no other flip test of this campaign"),
        ({"corrected": "false"}, "old has the bias in its readings"),
        ({"axis": "y"}, "turned about y, old about x"),
    ],
)
def test_what_cannot_be_set_side_by_side_is_refused_with_its_place(
    tmp_path: Path, changes: dict[str, str], words: str
) -> None:
    with pytest.raises(InertialcalError, match=words) as caught:
        run(campaign(tmp_path, **changes))
    assert "campaign.toml" in caught.value.problems[0].where
