"""A procedure of another package, registered by an entry point: no file of ours knows it, and everything works."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

TOY = Path(__file__).parent / "toy_procedure"
TRUE = {"x": 0.02, "y": -0.01}
CAMPAIGN = """\
schema = 1
[campaign]
id = "toy"
[sensors.suite]
kind = "gyro"
axes = ["x", "y"]
unit = "deg/s"
chain = { kind = "none" }
"""
RECORDING = """\
[recordings.r%d]
sensor = "suite"
file = "r%d.csv"
channels = { x = { column = "gyro_x [deg/s]", unit = "deg/s" }, y = { column = "gyro_y [deg/s]", unit = "deg/s" } }
"""
TEST = """\
[[tests]]
id = "rest"
procedure = "mean_reading"
recordings = [%s]
plan = { skip = "2 s" }
[[requirements]]
id = "R1"
quantity = "mean_reading"
limit = "0.1 deg/s"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("toy")
    rng = np.random.default_rng(1)
    names = range(1, 7)
    for number in names:
        lines = ["time [s],gyro_x [deg/s],gyro_y [deg/s]"]
        offset = {axis: true + rng.normal(0.0, 1e-3) for axis, true in TRUE.items()}
        for i in range(100):
            lines.append(f"{0.1 * i:.1f},{offset['x'] + rng.normal(0.0, 1e-4):.8f},{offset['y']:.8f}")
        (made / f"r{number}.csv").write_text("\n".join(lines) + "\n")
    recordings = "".join(RECORDING % (number, number) for number in names)
    (made / "campaign.toml").write_text(CAMPAIGN + recordings + TEST % ", ".join(f'"r{number}"' for number in names))
    return made


def inertialcal(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(TOY), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "inertialcal.cli", *words]
    return subprocess.run(
        command,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_check_and_run_take_it(folder: Path) -> None:
    checked = inertialcal("check", ".", cwd=folder)
    assert checked.returncode == 0, checked.stderr
    done = inertialcal("run", ".", "--json", cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    content = json.loads(done.stdout)
    rows = {(row["quantity"], row["axis"]): row for row in content["results"]}
    for axis, true in TRUE.items():
        row = rows["mean_reading", axis]
        assert row["unit"] == "deg/s"
        assert row["value"] == pytest.approx(true, abs=5e-3)
    assert [one["verdict"] for one in content["verdicts"]] == ["PASS", "PASS"]


def test_its_samples_left_out_are_counted_and_its_report_is_written(folder: Path) -> None:
    inertialcal("run", ".", "--quiet", cwd=folder)
    results = json.loads((folder / "out" / "results.json").read_text(encoding="utf-8"))
    (left_out,) = results["exclusions"]
    assert (left_out["test"], left_out["rule"], left_out["count"]) == ("rest", "skip", 120)
    assert {curve["curve"] if "curve" in curve else curve["name"] for curve in results["curves"]} == {"mean_readings"}
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "rest" in page


def test_it_makes_a_model_that_is_judged_on_what_is_held_out(folder: Path, tmp_path: Path) -> None:
    for path in folder.glob("*.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / "campaign.toml").read_text()
    fit = 'id = "rest"\nprocedure = "mean_reading"\nrecordings = ["r1", "r2", "r3"]\nuse = "fit"\n'
    held = fit.replace("rest", "unseen").replace('"r1", "r2", "r3"', '"r4", "r5", "r6"').replace("fit", "hold_out")
    head = text[: text.index("[[tests]]")]
    (tmp_path / "campaign.toml").write_text(f"{head}[[tests]]\n{fit}[[tests]]\n{held}")
    done = inertialcal("run", ".", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    content = json.loads(done.stdout)
    assert [one["verdict"] for one in content["closed_loop"]["axes"]] == ["PASS", "PASS"]
    model = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert "unseen" not in json.dumps(model)
    rows = {row["axis"]: row for row in content["results"] if (row["test"], row["quantity"]) == ("model", "bias")}
    for axis, true in TRUE.items():
        assert rows[axis]["value"] == pytest.approx(true, abs=5e-3)


def test_without_the_package_there_is_no_such_procedure(folder: Path) -> None:
    found = subprocess.run(
        [sys.executable, "-m", "inertialcal.cli", "check", "."],
        cwd=folder, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert found.returncode == 3
    assert "no procedure 'mean_reading'" in found.stderr


def test_a_wrong_setting_of_it_is_refused_with_its_line(folder: Path, tmp_path: Path) -> None:
    for path in folder.glob("*.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(text.replace('skip = "2 s"', 'skip = "2 m"'))
    found = inertialcal("check", ".", cwd=tmp_path)
    assert found.returncode == 3
    assert "campaign.toml:" in found.stderr
    assert "skip" in found.stderr
