"""The published closed form in a campaign: beside the results in every place that shows them, never one of them."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.compare.compare import Comparison, compare
from inertialcal.campaign.engine.run import Outcome, run
from inertialcal.campaign.start.starter import start
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.shown.summary import results_text
from inertialcal.core.campaign_text import MARK
from inertialcal.core.recording import Recording
from inertialcal.core.show.rows import case_name
from inertialcal.files.models.model_file import load_model_file
from inertialcal.rigs.hand_held.rig import Bench, build
from positions_truths import protocol

ONCE = Bench(variant="ferraris", rounds=1, records=1, dwell=2.5, first=2.5)
WAY = "as_published"
REQUIRED = """
[[requirements]]
id = "R1"
quantity = "bias"
limit = "1 deg/s"
tests = ["imu"]

[[requirements]]
id = "R2"
quantity = "direction_cosine"
axis = "xx"
lower = "0.5"
"""


def with_units(recording: Recording) -> Recording:
    units = {"acc": "m/s2", "gyro": "rad/s"}
    named = tuple(replace(c, name=f"{c.name} [{units[c.name[:-2]]}]") for c in recording.channels)
    return replace(recording, channels=named)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a record of six faces and three turns, its protocol, and the campaign that `init` writes for it."""
    made = tmp_path_factory.mktemp("faces")
    (recording,) = build(ONCE, 1).recordings.values()
    (made / "hand.csv").write_text(csv_text(with_units(recording)), encoding="utf-8")
    path, _, _ = start(made)
    (made / "sections.json").write_text(json.dumps(protocol(ONCE)), encoding="utf-8")
    text = path.read_text(encoding="utf-8").replace('gravity = "9.80665 m/s2"', 'gravity = "9.807 m/s2"')
    text = text.replace('file = "hand.csv"\n', 'file = "hand.csv"\nsections = "sections.json"\n')
    path.write_text(text.replace(f"  {MARK}", "") + REQUIRED, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def outcome(folder: Path) -> Outcome:
    return run(folder)


@pytest.fixture(scope="module")
def itself(folder: Path, outcome: Outcome) -> Comparison:
    """The campaign compared with itself."""
    assert outcome.results
    results = folder / "out" / "results.json"
    return compare(results, results, ["50 %", "bias=50 %"])


def test_results_hold_the_closed_form_of_both_sensors(outcome: Outcome) -> None:
    rows = [row for row in outcome.results["results"] if case_name(row) == WAY]
    counts = {
        (test, quantity): 0
        for test in ("accelerometer", "gyro")
        for quantity in ("scale_factor", "direction_cosine", "bias")
    }
    for row in rows:
        counts[row["sensor"], row["quantity"]] = counts.get((row["sensor"], row["quantity"]), 0) + 1
    assert counts == {
        ("accelerometer", "scale_factor"): 3, ("accelerometer", "direction_cosine"): 9, ("accelerometer", "bias"): 3,
        ("gyro", "scale_factor"): 3, ("gyro", "direction_cosine"): 9, ("gyro", "bias"): 3, ("gyro", "g_sensitivity"): 9,
    }  # fmt: skip
    assert {(row["u"], row["interval"], row["status"]) for row in rows} == {(None, None, "estimated")}
    found = {(row["sensor"], row["quantity"], row["axis"]): row for row in rows}
    (recording,) = build(ONCE, 1).recordings.values()
    means = {
        label: recording.array(["acc_x"])[ends["start"] : ends["end"]].mean()
        for label, ends in protocol(ONCE).items()
        if label in ("x_p", "x_a")
    }
    bias = found["accelerometer", "bias", "x"]
    assert bias["value"] == pytest.approx(0.5 * (means["x_p"] + means["x_a"]), abs=2e-4)  # ends of rests are left off
    assert bias["unit"] == "m/s^2"
    unit = np.array([found["gyro", "direction_cosine", f"y{axis}"]["value"] for axis in "xyz"])
    assert np.linalg.norm(unit) == pytest.approx(1.0)


def test_the_result_itself_has_no_such_condition(outcome: Outcome) -> None:
    own = {(r.get("sensor"), r["quantity"], r["axis"]) for r in outcome.results["results"] if case_name(r) != WAY}
    assert {("accelerometer", "bias", "x"), ("gyro", "g_sensitivity", "xz"), ("gyro", "scale_factor_error", "y")} <= own
    assert not any(quantity == "direction_cosine" for _, quantity, _ in own)


def test_requirements_are_judged_by_the_result_alone(outcome: Outcome) -> None:
    judged = [(one["requirement"], one["axis"], one["verdict"]) for one in outcome.results["verdicts"]]
    assert [one[:2] for one in judged if one[0] == "R1"] == [("R1", axis) for axis in "xyz"]
    assert [one[2] for one in judged if one[0] == "R2"] == ["OPEN"]  # the closed form alone has it
    rows = {(r.get("sensor"), r["axis"]): r["value"] for r in outcome.results["results"]
            if r["quantity"] == "bias" and case_name(r) == r.get("sensor")}  # fmt: skip
    for one in outcome.results["verdicts"]:
        if one["requirement"] == "R1":
            assert one["value"] == rows["gyro", one["axis"]]


def test_the_model_is_made_of_the_result(folder: Path, outcome: Outcome) -> None:
    model = load_model_file(folder / "out" / "model.json").model
    row = next(
        r
        for r in outcome.results["results"]
        if (r["test"], r["quantity"], case_name(r)) == ("imu", "bias", "accelerometer")
    )
    assert model.bias[0] == pytest.approx(row["value"], rel=1e-12)


def test_compare_judges_none_of_it(itself: Comparison) -> None:
    beside = [one for one in itself.differences if str(one.row.case) == WAY]
    assert len(beside) == 39
    assert {one.word for one in beside} == {"not compared"}
    assert {one.no_change for one in beside} == {None}
    assert all(case_name(verdict) != WAY for verdict in itself.verdicts)
    assert {(case_name(one), one["quantity"], one["verdict"]) for one in itself.verdicts} >= {
        ("accelerometer", "bias", "PASS"), ("gyro", "bias", "PASS"), ("accelerometer", "scale_factor_error", "PASS"),
    }  # fmt: skip
    assert itself.verdict == "PASS"


class Cells(HTMLParser):
    """Rows of the tables of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.inside = True
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.rows[-1][-1] += data


def test_report_and_terminal_show_it_beside(folder: Path, outcome: Outcome) -> None:
    cells = Cells()
    cells.feed((folder / "out" / "report.html").read_text(encoding="utf-8"))
    heads = [row for row in cells.rows if any("textbook formula" in cell for cell in row)]
    assert heads  # the one test of both: its first ten rows, and the others folded where they have room
    assert all(head == heads[0] for head in heads)
    shown = {row[0].strip() for row in cells.rows if row}
    assert any("direction_cosine" in name or "direction cosine" in name for name in shown)
    said = results_text(outcome.results)
    assert "textbook formula" in said
    line = next(one for one in said.split("\n") if one.startswith("  bias ") and " x " in one)
    assert line.split()[-1].replace("-", "").replace(".", "").isdigit()  # the closed form, in the last column
