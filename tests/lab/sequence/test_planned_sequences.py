"""Programmes of planners, rehearsed: a plan's own steps on a simulated unit, in accelerated time, end in the report."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from inertialcal.core.units import factor
from inertialcal.files.text.table import read_table
from inertialcal.lab.instruments.links.planned import rehearsal_of
from typed_commands import call, call_json

GYRO = ("--noise", "0.2 deg/sqrt(h)", "--instability", "5 deg/h")
PLANS: dict[str, tuple[str, ...]] = {
    "allan": (*GYRO, "--walk", "5 deg/h/sqrt(h)", "--sample-rate", "20 Hz", "--wanted", "instability=20 %"),
    "flip": ("--noise", "5 ug/sqrt(Hz)", "--ambient", "1 ug", "--swing", "0.5 ug", "--u-angle", "0.2 deg",
             "--u-axis", "0.2 deg", "--u-zero", "0.1 ug", "--wanted", "bias=1 ug"),
    "rate-table": (*GYRO, "--turn-on", "0.005 deg/s", "--turn-on-scale", "100 ppm", "--fastest", "100 deg/s",
                   "--latitude", "36.6 deg", "--u-rate", "0.005 %", "--u-mounting", "0.01 deg",
                   "--wanted", "bias=0.003 deg/s"),
    "thermal": (*GYRO, "--turn-on", "0.005 deg/s", "--turn-on-slope", "1e-5 deg/s/degC", "--coefficient",
                "3e-3 deg/s/degC", "--u-thermometer", "0.2 K", "--coldest", "-30 degC", "--hottest", "65 degC",
                "--latitude", "36.6 deg", "--wanted", "bias_over_temperature=0.0012 deg/s"),
    "positions": ("--scatter", "0.2 mg", "--target", "bias=0.15 mg", "--target", "misalignment=0.02 deg",
                  "--target", "scale_factor_error=300 ppm", "--gravity-u", "0.1 mg"),
}  # fmt: skip
SAYS = {"allan": "angle_random_walk", "flip": "ambient_acceleration", "rate-table": "scale_factor_error",
        "thermal": "bias", "positions": "misalignment"}  # fmt: skip
SLOW = [pytest.mark.slow]


def rehearsed(capsys: pytest.CaptureFixture[str], word: str, folder: Path, *more: str) -> Path:
    """Plan and rehearse; return the folder of the sequence."""
    simulate = () if word == "positions" else ("--simulate", "0")
    status, out, err = call(capsys, "plan", word, *PLANS[word], *simulate, "--lab", str(folder), *more)
    assert status == 0, err
    assert "inertialcal sequence" in out
    made = folder / "made"
    status, _, err = call(capsys, "sequence", str(folder / "LAB.toml"), "-o", str(made), "--yes", "-q")
    assert status in (0, 4), err
    return made


@pytest.mark.parametrize("word", [pytest.param(one, marks=[] if one == "allan" else SLOW) for one in PLANS])
def test_a_planned_programme_runs_and_ends_in_the_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], word: str
) -> None:
    made = rehearsed(capsys, word, tmp_path / "lab")
    steps = read_table(tmp_path / "lab" / "schedule.csv")
    log = list(csv.DictReader((made / "as_run.csv").read_text().splitlines()[1:]))
    assert [one["name"] for one in log] == list(steps.text("name"))
    assert {one["status"] for one in log} == {"PASS"}
    found = json.loads((made / "campaign" / "out" / "results.json").read_text())["results"]
    assert SAYS[word] in {row["quantity"] for row in found if row["status"] == "estimated"}
    assert (made / "campaign" / "out" / "report.html").stat().st_size > 10_000
    scored = call_json(capsys, "score", str(made / "campaign"))
    assert scored["known"] > 0
    assert scored["inside"] >= scored["expected"]["lo"]


@pytest.mark.slow
def test_what_was_planned_is_what_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The uncertainty that a plan forecasts is that of its own rehearsal, within what few power-ups tell of it."""
    plan = call_json(capsys, "plan", "rate-table", *PLANS["rate-table"], "--simulate", "0")
    forecast = next(row for row in plan["results"] if row["quantity"] == "bias_uncertainty" and not row["condition"])
    rehearsed(capsys, "rate-table", tmp_path / "lab", "--seed", "2")
    results = json.loads((tmp_path / "lab" / "made" / "campaign" / "out" / "results.json").read_text())["results"]
    found = [row for row in results if (row["quantity"], row["test"]) == ("bias", "rate")]
    planned = forecast["value"] * factor(forecast["unit"], found[0]["unit"])
    assert len(found) == 3
    assert all(0.3 < row["u"] / planned < 3.0 for row in found)


def test_each_seed_is_a_unit_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    call(capsys, "plan", "flip", *PLANS["flip"], "--simulate", "0", "--lab", str(tmp_path / "lab"))
    one, same, other = (rehearsal_of(tmp_path / "lab" / "plan.toml", seed) for seed in (1, 1, 2))
    first = next(iter(one.recordings))
    x = [made.recordings[first].channel("y").data for made in (one, same, other)]
    assert (x[0] == x[1]).all()
    assert abs(x[0].mean() - x[2].mean()) > 1e-6
    assert one.truth == same.truth != other.truth


@pytest.mark.parametrize(
    ("more", "code"),
    [(("--seed", "3"), "contradiction"), (("--lab", "there"), "exists")],
)
def test_what_cannot_be_meant_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: tuple[str, ...], code: str
) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "a").touch()
    words = [str(tmp_path / one) if one == "there" else one for one in more]
    found = call_json(capsys, "plan", "allan", *PLANS["allan"], "--simulate", "0", *words)
    assert found["exit"] == 2
    assert [one["code"] for one in found["errors"]] == [code]


def test_positions_that_were_taken_have_no_rehearsal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["plan", "positions", *PLANS["positions"], "--have", "faces"]
    status, _, err = call(capsys, *words, "--lab", str(tmp_path / "lab"))
    assert (status, (tmp_path / "lab").exists()) == (2, False)
    assert "no recording here" in err
    assert call(capsys, *words, "--schedule", str(tmp_path / "s.csv"))[0] == 0
    assert read_table(tmp_path / "s.csv").text("name")[0] == "position 7"
