"""A whole campaign by one command: sequenced, acquired live and reported; and the same after a kill at any moment."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import short_rig

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import write_twin
from inertialcal.lab.sequence.as_run import AsRun, Log
from inertialcal.rigs import RIGS
from typed_commands import call, call_json

COMMAND = [sys.executable, str(Path(short_rig.__file__))]
PATIENCE = 120.0  # [s] of this machine
ENV = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}  # the helpers of tests, as here


def log_rows(folder: Path) -> list[dict[str, str]]:
    """Return the rows of an as-run log."""
    lines = (folder / "as_run.csv").read_text().splitlines()
    assert lines[0].startswith("# LAB.toml SHA-256 ")
    return list(csv.DictReader(lines[1:]))


def results_of(folder: Path) -> list[dict[str, Any]]:
    """Return the rows of the results of a sequence."""
    found = json.loads((folder / "campaign" / "out" / "results.json").read_text())
    assert (folder / "campaign" / "out" / "report.html").stat().st_size > 10_000
    rows: list[dict[str, Any]] = found["results"]
    return rows


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a rehearsal, and what it makes without a kill in ``made``."""
    folder = tmp_path_factory.mktemp("rehearsal")
    lab = short_rig.rehearsal(folder / "lab")
    made = subprocess.run([*COMMAND, "sequence", str(lab), "-o", str(folder / "made"), "-q"], check=False,
                          capture_output=True, text=True, env=ENV, timeout=PATIENCE)  # fmt: skip
    assert made.returncode in (0, 4), made.stderr
    return folder


def test_a_rate_table_campaign_runs_from_one_command(table: Path) -> None:
    rows = log_rows(table / "made")
    assert [int(row["step"]) for row in rows] == list(range(1, 2 * 3 * len(short_rig.RATES) + 1))
    assert {row["status"] for row in rows} == {"PASS"}
    assert {row["attempt"] for row in rows} == {"1"}
    quantities = {row["quantity"] for row in results_of(table / "made")}
    assert {"scale_factor", "misalignment", "bias"} <= quantities


def test_the_schedule_is_what_was_told(table: Path) -> None:
    with (table / "made" / "campaign" / "schedules" / "y_run2.csv").open() as stream:
        found = list(csv.DictReader(stream))
    assert [float(one["rate"]) for one in found] == list(short_rig.RATES)
    assert all(one["start"] < one["stop"] for one in found)


def test_its_results_are_those_of_the_recorded_campaign_within_their_uncertainty(table: Path, tmp_path: Path) -> None:
    """The same unit, other samples of each dwell: 40 of its 60 s."""
    write_twin(RIGS[short_rig.TABLE].twin(1), tmp_path / "recorded")
    recorded = {(one["quantity"], one["axis"], str(one["test"]), str(one["condition"])): one
                for one in run(tmp_path / "recorded", write=False).results["results"]}  # fmt: skip
    compared = 0
    for one in results_of(table / "made"):
        other = recorded.get((one["quantity"], one["axis"], str(one["test"]), str(one["condition"])))
        if other is None or one["quantity"] not in {"scale_factor", "misalignment", "bias"} or one["u"] is None:
            continue
        compared += 1
        assert abs(one["value"] - other["value"]) < 3.0 * np.hypot(one["u"], other["u"])
    assert compared >= 9


def killed_and_resumed(folder: Path, name: str, rng: np.random.Generator) -> int:
    """Kill a sequence at a random moment, then go on with it; return how many rows its log had by then."""
    made, last = folder / name, len(log_rows(folder / "made"))
    command = [*COMMAND, "sequence", str(folder / "lab" / "LAB.toml"), "-o", str(made), "-q"]
    process = subprocess.Popen(command, env=ENV)
    wanted, until = int(rng.integers(0, last + 5)), time.monotonic() + PATIENCE
    path = made / "as_run.csv"
    while process.poll() is None and time.monotonic() < until:
        if path.exists() and path.read_bytes().count(b"\n") - 2 >= min(wanted, last):
            break
        time.sleep(0.005)
    time.sleep(float(rng.uniform(0.0, 0.1 if wanted < last else 2.0)))
    process.kill()
    process.wait()
    done = path.read_bytes().count(b"\n") - 2 if path.exists() else 0
    again = subprocess.run([*command, "--resume"], check=False, capture_output=True, text=True, env=ENV,
                           timeout=PATIENCE)  # fmt: skip
    assert again.returncode in (0, 4), again.stderr
    return done


@pytest.mark.parametrize("number", [pytest.param(i, marks=[] if i < 1 else pytest.mark.slow) for i in range(20)])
def test_killed_and_resumed_gives_the_same_results(table: Path, number: int) -> None:
    done = killed_and_resumed(table, f"killed_{number}", np.random.default_rng(number))
    rows = log_rows(table / f"killed_{number}")
    assert len(rows) >= done
    last = {int(row["step"]): row for row in rows}
    assert {row["status"] for row in last.values()} == {"PASS"}
    assert len(last) == len(log_rows(table / "made"))
    assert results_of(table / f"killed_{number}") == results_of(table / "made")


def test_what_is_complete_is_not_done_again(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (table / "made" / "as_run.csv").read_bytes()
    status, _, err = call(capsys, "sequence", str(table / "lab" / "LAB.toml"), "-o", str(table / "made"))
    assert status == 2
    assert "--resume" in err
    status, out, _ = call(capsys, "sequence", str(table / "lab" / "LAB.toml"), "-o", str(table / "made"), "--resume")
    assert status in (0, 4)
    assert "steps are PASS" in out
    assert (table / "made" / "as_run.csv").read_bytes() == before


def test_its_results_are_archived(table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    archive = str(tmp_path / "lab.db")
    words = ["sequence", str(table / "lab" / "LAB.toml"), "-o", str(table / "made"), "--resume", "--archive", archive]
    assert call(capsys, *words)[0] in (0, 4)
    (kept,) = call_json(capsys, "archive", "list", "--archive", archive)["campaigns"]
    assert "rate_table-1" in kept.values()


def test_a_record_that_was_changed_is_made_anew(table: Path, tmp_path: Path) -> None:
    """PASS holds as long as the record is as it was: its whole recording is redone, and nothing else."""
    made = tmp_path / "made"
    subprocess.run(["cp", "-r", str(table / "made"), str(made)], check=True)
    spoiled = next(made.glob("records/0008_*.parquet"))
    spoiled.write_bytes(spoiled.read_bytes()[:-1])
    command = [*COMMAND, "sequence", str(table / "lab" / "LAB.toml"), "-o", str(made), "-q", "--resume"]
    assert subprocess.run(command, check=False, env=ENV, timeout=PATIENCE).returncode in (0, 4)
    rows = log_rows(made)
    again = [int(row["step"]) for row in rows if row["status"] == "REDONE"]
    assert again == list(range(7, 13))  # y_run1
    assert results_of(made) == results_of(table / "made")


def test_another_lab_toml_is_refused(table: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab = tmp_path / "LAB.toml"
    lab.write_text((table / "lab" / "LAB.toml").read_text().replace('campaign = "campaign"\n', ""))
    status, _, err = call(capsys, "sequence", str(lab), "-o", str(table / "made"), "--resume")
    assert status == 3
    assert "is not that of this sequence" in err


def test_a_row_that_was_cut_off_is_not_believed(tmp_path: Path) -> None:
    log = Log(tmp_path, "0" * 64)
    row = AsRun("2026-11-30T00:00:00Z", 1, 'a, "b"\nc', "r", 1, "PASS", rows=3)
    log.add(row)
    log.add(row)
    log.close()
    path = tmp_path / "as_run.csv"
    whole = path.read_bytes()
    for cut in range(whole.rfind(b"\n", 0, -1) + 1, len(whole)):
        path.write_bytes(whole[:cut])
        again = Log(tmp_path, "0" * 64)
        assert len(again.rows) == 1
        again.close()
        assert path.read_bytes() == whole[: whole.rfind(b"\n", 0, -1) + 1]


@pytest.mark.slow
def test_the_campaign_of_the_suite_runs_from_one_command(tmp_path: Path) -> None:
    """Thermal runs and the record at rest are those of the rig sample by sample; the rate table in parts of dwells."""
    lab = short_rig.rehearsal(tmp_path / "lab", short_rig.SUITE)
    command = [*COMMAND, "sequence", str(lab), "-o", str(tmp_path / "made"), "-q"]
    made = subprocess.run(command, check=False, capture_output=True, text=True, env=ENV, timeout=900)
    assert made.returncode in (0, 1, 4), made.stderr
    write_twin(RIGS[short_rig.SUITE].twin(1), tmp_path / "recorded")
    recorded = run(tmp_path / "recorded", write=False).results["results"]
    live = results_of(tmp_path / "made")
    same = 0
    for one, other in zip(live, recorded, strict=True):
        assert (one["quantity"], one["axis"], one["test"]) == (other["quantity"], other["axis"], other["test"])
        if "thermal" in str(one["test"]) or one["test"] == "noise":
            same += 1
            for key in ("value", "u"):
                assert one[key] == (None if other[key] is None else pytest.approx(other[key], rel=1e-9))
    assert same > 20


@pytest.mark.slow
@pytest.mark.parametrize("rig", ["six_faces", "still_gyro"])
def test_campaigns_of_other_rigs_run_from_one_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rig: str
) -> None:
    """Positions and noise: what is recorded is what the rig has, whole."""
    assert call(capsys, "simulate", rig, "--lab", "-o", str(tmp_path / "lab"))[0] == 0
    status, _, err = call(capsys, "sequence", str(tmp_path / "lab" / "LAB.toml"), "-o", str(tmp_path / "made"), "-q")
    assert status in (0, 1, 4), err
    recorded = run_twin(rig, tmp_path / "recorded")
    live = results_of(tmp_path / "made")
    assert len(live) == len(recorded) > 5
    for one, other in zip(live, recorded, strict=True):
        for key in ("value", "u"):
            assert one[key] == (None if other[key] is None else pytest.approx(other[key], rel=1e-6))


def run_twin(rig: str, folder: Path) -> list[dict[str, Any]]:
    """Return the rows of the results of the recorded campaign of a rig."""
    write_twin(RIGS[rig].twin(1), folder)
    rows: list[dict[str, Any]] = run(folder, write=False).results["results"]
    return rows
