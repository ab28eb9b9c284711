"""simulate and score as a user meets them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_type_hints

import pytest
from typer import Context
from typer.core import TyperCommand

from inertialcal.cli.options import faults_beginning
from inertialcal.cli.verbs.twins import simulate
from inertialcal.rigs import RIGS
from inertialcal.rigs.faults import FAULTS
from inertialcal.rigs.faults.scene import Scene
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.rigs.twin import Changes, Fault, Twin
from typed_commands import call, call_json

SHORT = Bench(rates_deg_s=(0.0, 2.0, -2.0, 4.5, -4.5, 0.0), dwell=24.0, runs=5, fit_runs=3)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rig with short recordings, and one whose truth is not the truth."""

    def lying(seed: int, changes: Changes) -> Twin:
        twin = rate_table.build(SHORT, seed)
        return replace(twin, truth=tuple(replace(one, value=1.0) for one in twin.truth))

    small = Rig("small", "", lambda seed, changes: rate_table.build(SHORT, seed), tests=("rate_table",))
    monkeypatch.setitem(RIGS, "small", small)
    monkeypatch.setitem(RIGS, "liar", Rig("liar", "", lying))


def test_simulate_run_score(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = str(tmp_path / "twin")
    status, out, _ = call(capsys, "simulate", "small", "-o", folder, "--seed", "3")
    assert status == 0
    assert "15 recordings" in out
    assert f"Next: inertialcal run {folder}, then inertialcal score {folder}" in out
    call(capsys, "run", folder, "--quiet")
    status, out, _ = call(capsys, "score", folder)
    assert status == 0
    assert "stated 95 % intervals hold the truth" in out
    found = call_json(capsys, "score", folder)
    assert found["seed"] == 3
    assert {"truth", "inside"} <= set(found["results"][0])
    assert found["inside"] == sum(row["inside"] is True for row in found["results"])
    assert call(capsys, "score", folder, "--quiet")[1] == ""


def test_help_and_manual_name_every_rig_and_its_mistakes() -> None:
    own = {name: rig for name, rig in RIGS.items() if name not in ("small", "liar")}
    said = get_type_hints(simulate, include_extras=True)["rig"].__metadata__[0].help
    assert sorted(said.removeprefix("lot (many units), or a rig: ").removesuffix(".").split(", ")) == sorted(RIGS)
    page = (Path(__file__).parents[2] / "docs" / "commands" / "simulate.md").read_text(encoding="utf-8")
    named = [*own, *(fault for rig in own.values() for fault in rig.faults)]
    assert not [name for name in named if f"`{name}`" not in page]


def test_simulate_in_json_and_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / "twin"
    found = call_json(capsys, "simulate", "small", "-o", str(folder))
    assert (found["written"], found["seed"], len(found["recordings"])) == (str(folder), 1, 15)
    assert len(found["truth_sha256"]) == 64
    assert call_json(capsys, "simulate", "small", "-o", str(folder))["exit"] == 2
    assert call_json(capsys, "simulate", "nothing", "-o", str(folder / "new"))["exit"] == 2
    other = call_json(capsys, "simulate", "rate_table", "-o", str(folder / "new"), "--fault", "gremlin")
    assert "wrong_sign" in other["errors"][0]["do"]


def test_faults_are_listed_with_what_is_expected(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = call(capsys, "simulate", "still_gyro", "--faults")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()[1:]] == list(RIGS["still_gyro"].every_fault)
    assert "3000 sigma" in out
    listed = call_json(capsys, "simulate", "still_gyro", "--faults")["faults"]
    assert {"fault": "zero_uncertainty", "size": None, "expects": "refused"}.items() <= listed[-1].items()
    assert call(capsys, "simulate", "small")[0] == 2


def test_faults_are_completed_by_name() -> None:
    context = Context(TyperCommand("simulate"))
    context.params["rig"] = "small"
    assert [name for name, _ in faults_beginning(context, "run_")] == ["run_in_rad_s", "run_sign", "run_gain"]


def test_a_campaign_with_a_fault_is_scored_by_its_entry(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = str(tmp_path / "twin")
    written = call_json(capsys, "simulate", "small", "-o", folder, "--fault", "backward_stamps=20")
    assert (written["fault"], written["size"]) == ("backward_stamps", "20 samples")
    found = call_json(capsys, "score", folder)  # refused: there is no out/
    assert (found["exit"], found["results"]) == (0, [])
    assert {one["code"] for one in found["refused"]} == {"time_backwards"}
    assert found["verdicts"][0]["verdict"] == "PASS"
    status, out, _ = call(capsys, "score", folder)
    assert status == 0
    assert "fault backward_stamps = 20 samples: expected named: time_backwards; refused: time_backwards" in out


def test_a_fault_that_is_not_named_ends_with_one(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(FAULTS, "harmless", Fault("nothing is wrong", "gremlin", tests=("rate_table",), spoil=chosen))
    folder = str(tmp_path / "twin")
    call(capsys, "simulate", "small", "-o", folder, "--fault", "harmless")
    status, out, _ = call(capsys, "score", folder)
    assert status == 1
    assert "verdict: FAIL" in out
    counted = call_json(capsys, "score", "--rig", "small", "--fault", "harmless", "--n", "2")
    assert (counted["exit"], counted["hits"], counted["n"]) == (1, 0, 2)
    status, out, _ = call(capsys, "score", "--rig", "small", "--fault", "run_sign", "--n", "2")
    assert status == 0
    assert "2 of 2 named as expected" in out


def chosen(scene: Scene, size: float) -> None:
    """Spoil nothing."""
    scene.chosen()


def test_a_fault_that_intervals_cover_is_counted_by_quantity(capsys: pytest.CaptureFixture[str]) -> None:
    found = call_json(capsys, "score", "--rig", "small", "--fault", "lost_samples=1 %", "--n", "2")
    assert {row["quantity"] for row in found["results"]} >= {"bias", "scale_factor_error"}
    assert (found["exit"], found["hits"]) == (0, 2)


def test_score_of_a_rig(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = call(capsys, "score", "--rig", "small", "--n", "3", "--seed-from", "5")
    assert status == 0
    assert "seeds 5 to 7" in out
    assert "of 3" in out
    assert "3/3 done" in err
    rows = call_json(capsys, "score", "--rig", "small", "--n", "2")["results"]
    assert {row["n"] for row in rows} == {2}


def test_score_of_a_rig_whose_intervals_do_not_hold_ends_with_one(capsys: pytest.CaptureFixture[str]) -> None:
    found = call_json(capsys, "score", "--rig", "liar", "--n", "8")
    assert found["exit"] == 1
    assert {one["verdict"] for one in found["verdicts"]} == {"FAIL"}


@pytest.mark.parametrize("words", [[], ["here", "--rig", "small"]])
def test_score_needs_a_folder_or_a_rig(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    status, _, err = call(capsys, "score", *words)
    assert status == 2
    assert "a folder or --rig" in err


def test_score_of_a_folder_that_is_no_twin(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status, _, err = call(capsys, "score", str(tmp_path))
    assert status == 3
    assert "No campaign here" in err
