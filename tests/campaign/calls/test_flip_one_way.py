"""`flip`: a command, Python and a campaign give the same rows of the same files, to the last bit."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import Bench, build
from pad_pairs_made import flip_records
from typed_commands import same_rows

MEANS = """\
axis,orientation,flip,mean [ug]
y,forward,1,973.77
y,reverse,1,984.33
z,forward,1,-1249.69
z,reverse,1,-1258.82
y,forward,2,973.52
y,reverse,2,984.61
z,forward,2,-1249.81
z,reverse,2,-1258.60
"""
POSITIONS = {"forward": "0 deg", "reverse": "180 deg"}
STANDARDS = {
    "turn.angle": "0.2 deg",
    "turn.axis": "0.2 deg",
    "converter.zero": "0.05 ug",
    "sensor.scale_factor": "1e-4",
}
BENCH = replace(Bench(), rate=5.0, saved="g", said="g")


def figures(rows: Any) -> list[dict[str, Any]]:
    """Return what stands in the rows of a test, but for its name; a campaign makes a model of them, too."""
    return [{**one, "test": ""} for one in json.loads(json.dumps(rows)) if one["test"] != "model"]


def test_a_table_of_means(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "means.csv"
    file.write_text(MEANS, encoding="utf-8")
    found = same_rows(capsys, "flip", [file], tmp_path / "campaign", positions=POSITIONS, standards=STANDARDS)
    assert found.result.readings.flips == ("1", "2")
    assert "relative_to_fixture" not in {one.code for one in found.remarks}


def test_recordings_with_windows_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = []
    for seed in (4, 5):
        files.append(tmp_path / f"head{seed}.csv")
        files[-1].write_text(csv_text(build(BENCH, seed).recordings[FILE]), encoding="utf-8")
    same_rows(capsys, "flip", files, tmp_path / "campaign", units={"g": "g"}, settle="20 s", standards=STANDARDS)


def test_archive_records_with_windows_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    windows = ["2014/295/09:40:00..2014/295/09:46:00=0 deg", "2014-10-22T09:47:00Z..2014-10-22T09:55:00Z=180 deg"]
    folder = flip_records(tmp_path / "records")
    found = same_rows(capsys, "flip", [folder], tmp_path / "campaign", windows=windows, axis="x", corrected=True)
    assert found.unit == "ug"


def test_an_array(tmp_path: Path) -> None:
    recording = build(BENCH, 4).recordings[FILE]
    file = tmp_path / "head.csv"
    file.write_text(csv_text(recording), encoding="utf-8")
    own = inertialcal.read(file)
    assert own.time_ns is not None
    windows = ["900..1190=0 deg", "1230..1500=180 deg"]
    of_array = inertialcal.flip(own.array("xyz"), sample_rate=5.0, units={"g": "g"}, windows=windows)
    elapsed = replace(own, time_ns=np.arange(len(own)) * 200_000_000, epoch="elapsed")
    of_recording = inertialcal.flip(elapsed, units={"g": "g"}, windows=windows)
    assert of_array.result.estimate.values == pytest.approx(of_recording.result.estimate.values, rel=1e-12)


@pytest.mark.parametrize("name", [Path(FILE).name, "renamed.csv"])
def test_like_a_campaign_in_counts(tmp_path: Path, name: str) -> None:
    """Chain, standards, channels and windows of the campaign: its figures, from the file alone."""
    inertialcal.simulate("sams_tsh", tmp_path / "twin", seed=1)
    file = tmp_path / name
    file.write_bytes((tmp_path / "twin" / FILE).read_bytes())
    found = inertialcal.flip(file, like=tmp_path / "twin")
    outcome = run(tmp_path / "twin", write=False)
    assert figures([row.to_dict() for row in found.rows]) == figures(outcome.results["results"])


def test_like_a_campaign_of_another_time(tmp_path: Path) -> None:
    """Windows that do not lie in the record are found in it."""
    inertialcal.simulate("sams_tsh", tmp_path / "twin", seed=1)
    own = inertialcal.read(tmp_path / "twin" / FILE)
    assert own.time_ns is not None
    later = replace(own, time_ns=own.time_ns + 86_400 * 1_000_000_000)
    found = inertialcal.flip(later, like=tmp_path / "twin")
    assert "turns_found" in {one.code for one in found.remarks}
    rows = run(tmp_path / "twin", write=False).results["results"]
    stated = next(row for row in rows if (row["quantity"], row["axis"], row["condition"]) == ("bias", "y", ""))
    own_bias = next(row for row in found.rows if row.quantity == "bias" and row.axis == "y")
    assert own_bias.value is not None
    assert abs(own_bias.value - stated["value"]) < 5.0 * stated["u"]
