"""A second package with a procedure, a rig and a reader, installed by pip: no file of ours knows it, and all works."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from served import Command, served

PLUGIN = Path(__file__).parent
TRUE = {"x": 0.02, "y": -0.01}
CAMPAIGN = """\
schema = 2
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


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the package where nothing else is."""
    folder, copy = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("source") / "plugin"
    shutil.copytree(PLUGIN, copy, ignore=shutil.ignore_patterns("__pycache__"))
    install = (
        "install",
        "--quiet",
        "--no-deps",
        "--no-index",
        "--no-build-isolation",
        "--target",
        str(folder),
        str(copy),
    )
    subprocess.run([sys.executable, "-m", "pip", *install], check=True, timeout=120)
    return folder


@pytest.fixture(scope="module", name="inertialcal")
def _inertialcal(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Command]:
    with served(site, tmp_path_factory.mktemp("printed")) as command:
        yield command


def test_a_process_of_its_own_takes_it(site: Path, folder: Path) -> None:
    path = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])
    words = [sys.executable, "-m", "inertialcal.cli", "check", "."]
    done = subprocess.run(words, cwd=folder, env={**os.environ, "PYTHONPATH": path}, timeout=120, check=False)
    assert done.returncode == 0


def test_check_and_run_take_it(inertialcal: Command, folder: Path) -> None:
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


def test_its_samples_left_out_are_counted_and_its_report_is_written(inertialcal: Command, folder: Path) -> None:
    inertialcal("run", ".", "--quiet", cwd=folder)
    results = json.loads((folder / "out" / "results.json").read_text(encoding="utf-8"))
    (left_out,) = results["exclusions"]
    assert (left_out["test"], left_out["rule"], left_out["count"]) == ("rest", "skip", 120)
    names = pyarrow.parquet.read_table(folder / "out" / "curves.parquet").column("name").unique().to_pylist()
    assert set(names) == {"mean_readings", "mean_steps"}
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "rest" in page


def test_it_makes_a_model_that_is_judged_on_what_is_held_out(
    inertialcal: Command, folder: Path, tmp_path: Path
) -> None:
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


def test_a_wrong_setting_of_it_is_refused_with_its_line(inertialcal: Command, folder: Path, tmp_path: Path) -> None:
    for path in folder.glob("*.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(text.replace('skip = "2 s"', 'skip = "2 m"'))
    found = inertialcal("check", ".", cwd=tmp_path)
    assert found.returncode == 3
    assert "campaign.toml:" in found.stderr
    assert "skip" in found.stderr


def test_its_command_has_help_and_gives_the_rows_of_the_campaign(
    inertialcal: Command, folder: Path, tmp_path: Path
) -> None:
    shown = inertialcal("mean-reading", "--help", cwd=folder)
    assert shown.returncode == 0
    assert all(option in shown.stdout for option in ("--skip", "--upside-down", "--standard", "--like", "--hold-out"))
    assert "mean-reading" in inertialcal("--help", cwd=folder).stdout
    files = [f"r{number}.csv" for number in range(1, 7)]
    done = inertialcal("mean-reading", *files, "--skip", "2 s", "--json", "--campaign", str(tmp_path / "c"), cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(done.stdout)["results"]
    again = inertialcal("run", str(tmp_path / "c"), "--json", cwd=folder)
    own = [row for row in json.loads(again.stdout)["results"] if row["test"] == "mean_reading"]
    assert rows == own
    there = inertialcal("run", ".", "--json", cwd=folder)
    rest = [row for row in json.loads(there.stdout)["results"] if row["test"] == "rest"]
    assert [row["value"] for row in rest] == [row["value"] for row in rows]


def test_a_recording_says_how_the_unit_lay(inertialcal: Command, folder: Path) -> None:
    files = [f"r{number}.csv" for number in range(1, 7)]
    values = []
    for words in ((), ("--upside-down",)):
        done = inertialcal("mean-reading", *files, *words, "--json", cwd=folder)
        values.append([row["value"] for row in json.loads(done.stdout)["results"]])
    assert values[0] == [-value for value in values[1]]


def test_it_takes_a_table_of_rows(inertialcal: Command, tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("mean_x,mean_y\n0.02,0.1\n0.03,0.2\n0.04,0.3\n")
    done = inertialcal("mean-reading", "t.csv", "--unit", "deg/s", "--json", "--campaign", "c", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = json.loads(done.stdout)["results"]
    assert [row["value"] for row in rows] == pytest.approx([0.03, 0.2])
    again = inertialcal("run", "c", "--json", cwd=tmp_path)
    assert [row for row in json.loads(again.stdout)["results"] if row["test"] == "mean_reading"] == rows


def test_it_takes_what_a_thermal_test_found_off_its_readings(inertialcal: Command, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for number in range(1, 6):
        time = np.arange(3000) * 2.0
        ramp = 20.0 + 30.0 * np.sin(2 * np.pi * time / time[-1])
        warm = np.full(3000, 20.0 + 4.0 * number)
        for name, temperature in (("ramp", ramp), ("rest", warm)):
            rate = 0.05 + 0.002 * (temperature - 20.0) + 1e-3 * rng.standard_normal(3000)
            lines = [f"{t:.1f},{v:.9f},{c:.6f}" for t, v, c in zip(time, rate, temperature, strict=True)]
            (tmp_path / f"{name}{number}.csv").write_text("\n".join(["time [s],x,temp", *lines, ""]))
    head = CAMPAIGN.replace('["x", "y"]', '["x"]')
    channels = '{ x = { column = "x", unit = "deg/s" }, temperature = { column = "temp", unit = "degC" } }'
    names = [f"{name}{number}" for name in ("ramp", "rest") for number in range(1, 6)]
    entry = '[recordings.%s]\nsensor = "suite"\nfile = "%s.csv"\nchannels = %s\nrun = "%s"\n'
    text = head + "".join(entry % (name, name, channels, name[-1]) for name in names)
    test = '[[tests]]\nid = "%s"\nprocedure = "%s"\nrecordings = [%s]\n%s'
    ramps, rests = (", ".join(f'"{name}{number}"' for number in range(1, 6)) for name in ("ramp", "rest"))
    for after in ("", 'after = ["warm"]\n'):
        tests = test % ("warm", "thermal", ramps, "") + test % (
            "mean",
            "mean_reading",
            rests,
            after + 'use = "report_only"\n',
        )
        (tmp_path / "campaign.toml").write_text(text + tests)
        done = inertialcal("run", ".", "--json", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr
        (row,) = (one for one in json.loads(done.stdout)["results"] if one["quantity"] == "mean_reading")
        # 0.05 at 20 degC and 0.002 a degree: at 32 degC on average without the correction, nothing is left with it
        assert row["value"] == pytest.approx(0.0 if after else 0.074, abs=2e-3)
        assert (row["u"] < 2e-3) == bool(after)


def test_it_plans(inertialcal: Command, tmp_path: Path) -> None:
    shown = inertialcal("plan", "--help", cwd=tmp_path)
    assert "mean-reading" in shown.stdout
    words = ("plan", "mean-reading", "--scatter", "0.1 deg/s", "--target", "0.02 deg/s")
    assert inertialcal(*words, cwd=tmp_path).stdout.strip() == "25 recordings"
    assert json.loads(inertialcal(*words, "--json", cwd=tmp_path).stdout)["results"][0]["value"] == 25.0
    wrong = inertialcal(*words[:-1], "0.02 s", cwd=tmp_path)
    assert (wrong.returncode, "target" in wrong.stderr) == (2, True)


@pytest.mark.parametrize("name", ["means", "mean_steps"])
def test_it_draws_two_figures_also_in_the_report(inertialcal: Command, folder: Path, tmp_path: Path, name: str) -> None:
    files = [f"r{number}.csv" for number in range(1, 7)]
    figure = tmp_path / f"{name}.svg"
    done = inertialcal("mean-reading", *files, "-o", str(figure), "--figure", name, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert figure.read_text(encoding="utf-8").startswith("<")
    inertialcal("run", ".", "--quiet", cwd=folder)
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert {"means": "Means of <bdi>x</bdi>", "mean_steps": "Changes of <bdi>x</bdi>"}[name] in page


def test_info_suggests_it_and_init_writes_its_campaign(inertialcal: Command, folder: Path, tmp_path: Path) -> None:
    for number in range(1, 4):
        (tmp_path / f"mean_{number}.csv").write_bytes((folder / f"r{number}.csv").read_bytes())
    assert "inertialcal mean-reading" in inertialcal("info", "mean_1.csv", cwd=tmp_path).stdout
    assert inertialcal("init", ".", cwd=tmp_path).returncode == 0
    text = (tmp_path / "campaign.toml").read_text()
    assert 'procedure = "mean_reading"' in text
    kept = [line for line in text.splitlines() if "FILL IN" not in line]
    (tmp_path / "campaign.toml").write_text("\n".join(kept) + "\n")
    done = inertialcal("run", ".", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_its_reader_serves_every_command(inertialcal: Command, tmp_path: Path) -> None:
    time, rng = np.arange(400) * 0.01, np.random.default_rng(1)
    for number in range(1, 4):
        rows = np.column_stack([time, rng.normal(0.02, 1e-3, time.size)])
        (tmp_path / f"r{number}.toy").write_bytes(b"TOY1" + rows.astype("<f8").tobytes())
    assert "Toy, little endian, 400 rows" in inertialcal("info", "r1.toy", cwd=tmp_path).stdout
    done = inertialcal("mean-reading", "r1.toy", "r2.toy", "r3.toy", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    (row,) = (one for one in json.loads(done.stdout)["results"] if one["quantity"] == "mean_reading")
    assert (row["value"], row["unit"]) == (pytest.approx(0.02, abs=3e-4), "deg/s")
    assert inertialcal("convert", "r1.toy", "r1.csv", cwd=tmp_path).returncode == 0
    assert len((tmp_path / "r1.csv").read_text().splitlines()) == 401


def test_its_rig_is_simulated_run_and_scored(inertialcal: Command, tmp_path: Path) -> None:
    assert inertialcal("simulate", "toy_rest", "-o", "twin", "--seed", "2", cwd=tmp_path).returncode == 0
    assert inertialcal("run", "twin", cwd=tmp_path).returncode == 0
    assert "of 1 stated 95 % intervals" in inertialcal("score", "twin", cwd=tmp_path).stdout.replace("\n", " ")
    many = inertialcal("score", "--rig", "toy_rest", "--n", "40", "--json", cwd=tmp_path)
    assert many.returncode == 0, many.stdout + many.stderr
