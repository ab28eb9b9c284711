"""simulate and score as a user meets them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_type_hints

import pytest

from inertialcal.cli.verbs.twins import simulate
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.rigs.twin import Changes, Twin
from typed_commands import call, call_json

SHORT = Bench(rates_deg_s=(0.0, 2.0, -2.0, 4.5, -4.5, 0.0), dwell=24.0, runs=5, fit_runs=3)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rig with short recordings, and one whose truth is not the truth."""

    def lying(seed: int, changes: Changes) -> Twin:
        twin = rate_table.build(SHORT, seed)
        return replace(twin, truth=tuple(replace(one, value=1.0) for one in twin.truth))

    monkeypatch.setitem(RIGS, "small", Rig("small", "", lambda seed, changes: rate_table.build(SHORT, seed)))
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
    assert sorted(said.removeprefix("Of a rig: ").removesuffix(".").split(", ")) == sorted(RIGS)
    page = (Path(__file__).parents[2] / "docs" / "commands" / "simulate.md").read_text(encoding="utf-8")
    named = [*own, *(fault for rig in own.values() for fault in rig.every_fault)]
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
