"""Nouns: a command, Python and a campaign give the same rows of one file."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal
from inertialcal.campaign.engine.run import run
from one_way_in import same_rows

RATE = """rate [deg/s],x [deg/s],std [deg/s],run
-4,-4.021,0.002,1
-2,-2.013,0.002,1
0,-0.004,0.002,1
2,2.003,0.002,1
4,4.012,0.002,1
-4,-4.020,0.002,2
-2,-2.012,0.002,2
0,-0.005,0.002,2
2,2.004,0.002,2
4,4.011,0.002,2
"""


def warm_recording(path: Path, seed: int, rows: int = 4000) -> Path:
    """Write a gyro whose bias follows its temperature."""
    rng = np.random.default_rng(seed)
    time = np.arange(rows) * 2.0
    temperature = 20.0 + 30.0 * np.sin(2 * np.pi * time / time[-1]) + 0.01 * rng.standard_normal(rows)
    reading = 0.05 - 0.003 * (temperature - 20.0) + 0.003 * rng.standard_normal(rows)
    table = np.column_stack([time, reading, temperature])
    np.savetxt(path, table, fmt="%.9f", delimiter=",", header="time [s],gyro_x [deg/s],temperature [degC]", comments="")
    return path


def test_rate_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "table.csv"
    file.write_text(RATE)
    settings = {"axis": "x", "standards": {"rate_table.rate": "0.05 %"}, "latitude": "36.6 deg"}
    found = same_rows(capsys, "rate-table", [file], tmp_path / "campaign", **settings)
    assert found.plan.latitude == pytest.approx(np.radians(36.6))


def test_thermal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [warm_recording(tmp_path / f"warm_{seed}.csv", seed) for seed in (1, 2)]
    same_rows(capsys, "thermal", files, tmp_path / "campaign", at=["-5 degC"], standards={"converter.reference": "1 %"})


def test_like_a_campaign(tmp_path: Path) -> None:
    inertialcal.simulate("npsat1", tmp_path / "twin", seed=1)
    files = [tmp_path / "twin" / "recordings" / f"ambient_{number}.csv" for number in range(1, 6)]
    found = inertialcal.thermal(files, like=tmp_path / "twin")
    outcome = run(tmp_path / "twin", write=False)
    own = {figure(row) for row in outcome.results["results"] if row["test"] == "thermal_ambient"}
    assert {figure(row.to_dict()) for row in found.rows} <= own
    assert len(found.rows) > 80


def figure(row: dict[str, Any]) -> tuple[object, ...]:
    """Return what a row is of, and its numbers."""
    return row["quantity"], row["axis"], row["value"], row["u"], row["dof"], str(row["interval"])


def test_arrays_and_recordings(tmp_path: Path) -> None:
    file = warm_recording(tmp_path / "warm.csv", 3)
    of_file = inertialcal.thermal(file)
    of_recording = inertialcal.thermal(inertialcal.read(file))
    assert [row.to_dict() for row in of_file.rows] == [row.to_dict() for row in of_recording.rows]


def test_the_types_of_the_calls_are_fresh() -> None:
    script = Path(__file__).parents[3] / "docs" / "stubs.py"
    assert subprocess.run([sys.executable, str(script), "--check"], check=False).returncode == 0
