"""`flip` and the flip rig on the command line: output, exit status, one clear message for bad input."""

from __future__ import annotations

from pathlib import Path

import pytest

from inertialcal.core.show.rows import case_name
from typed_commands import call, call_json

TABLE = """\
axis,time,orientation,mean [ug]
y,2,forward,973.77
y,2,reverse,984.33
z,2,forward,-1249.69
z,2,reverse,-1258.82
x,2,forward,-1264.74
x,2,reverse,-1264.98
"""
POSITIONS = ("--position", "forward=0 deg", "--position", "reverse=180 deg")


@pytest.fixture
def means(tmp_path: Path) -> Path:
    path = tmp_path / "table03.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


def test_a_table_of_means(capsys: pytest.CaptureFixture[str], means: Path) -> None:
    status, out, err = call(capsys, "flip", str(means), *POSITIONS)
    assert (status, err) == (0, "")
    assert "no record of the noise" in out
    content = call_json(capsys, "flip", str(means), *POSITIONS)
    rows = {(row["quantity"], row["axis"]): row for row in content["results"] if case_name(row) == ""}
    assert rows["ambient_acceleration", "y"]["value"] == pytest.approx(-5.282, abs=0.005)  # TM-106980, Table 4
    assert rows["ambient_acceleration", "y"]["u"] is None
    assert content["inputs"][0]["path"] == str(means)
    assert call(capsys, "flip", str(means), *POSITIONS, "--quiet") == (0, "", "")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "position 'forward' has no angle"),
        ((*POSITIONS, "--axis", "w"), "'w' is not one of 'x', 'y', 'z'"),
        ((*POSITIONS, "--unit", "furlong"), "furlong"),
        (("--position", "forward"), "--position"),
        (("--window", "yesterday"), "a table of means has no windows"),
    ],
)
def test_wrong_usage_is_told_in_one_message(
    capsys: pytest.CaptureFixture[str], means: Path, words: tuple[str, ...], told: str
) -> None:
    status, out, err = call(capsys, "flip", str(means), *words)
    assert status in (2, 3)
    assert out == ""
    assert told in err


def test_a_file_that_is_not_there_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    content = call_json(capsys, "flip", str(tmp_path / "nothing.csv"))
    assert content["exit"] == 3
    assert content["errors"]


def test_a_rig_is_simulated_run_and_scored(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = str(tmp_path / "flip")
    assert call(capsys, "simulate", "sams_tsh", "-o", folder, "--seed", "1")[0] == 0
    status, out, _ = call(capsys, "run", folder)
    assert status == 0
    assert "closed loop: not run (no test is held out)" in out
    status, out, _ = call(capsys, "score", folder)
    assert status == 0
    assert "of 8 stated 95 % intervals hold the truth" in out
    assert "1 not estimated" in out  # bias along the turn


def test_a_rig_is_scored_over_seeds(capsys: pytest.CaptureFixture[str]) -> None:
    content = call_json(capsys, "score", "--rig", "sams_tsh", "--n", "2")
    assert {(row["quantity"], row["axis"]) for row in content["results"]} >= {("bias", "y"), ("control_error", "x")}
    assert all(row["n"] == 2 for row in content["results"])


def test_the_demonstrations_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status, out, err = call(capsys, "demo", "sams1996", "-o", str(tmp_path / "demo"))
    assert status == 0
    assert "SAMS triaxial sensor head" in err
    assert "INCONCLUSIVE" in out
    status, out, _ = call(capsys, "demo", "sams_tsh", "-o", str(tmp_path / "simulated"))
    assert status == 0
    assert "the model and the simulated truth" in out
    assert "stated 95 % intervals hold the truth" in out
