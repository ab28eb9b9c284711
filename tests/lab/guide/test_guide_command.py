"""The command: what it prints, how it ends, and what it refuses before anything is recorded."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lab_devices import lab_folder

from typed_commands import call

REHEARSAL = """schema = 1
[lab]
title = "IMU on the desk"
speed = 40
[instruments.imu]
link = "rig"
rig = "hand_held"
recording = "hand1"
"""


def test_it_says_line_by_line_what_the_page_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab, folder = lab_folder(tmp_path, REHEARSAL.replace("40", "15")), tmp_path / "imu"
    words = ("guide", str(lab), "-o", str(folder), "--no-page", "--gravity", "9.807 m/s2", "--for", "px4")
    status, out, err = call(capsys, *words)
    assert status == 0, err
    for text in ("Hold still: Good. Leave it", "Turn now: ", "positions, about", "bias", " u = "):
        assert text in err
    assert "every figure is known as well as was asked for" in out
    assert "reached" in out
    assert "px4: " in out, err
    assert "CAL_GYRO0_XOFF" in (folder / "calibration.px4").read_text()
    assert json.loads((folder / "out" / "results.json").read_text())["results"]
    status, _, err = call(capsys, *words)
    assert status == 3
    assert "not empty" in err


def test_what_ends_before_it_is_enough_is_no_pass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lab = lab_folder(tmp_path, REHEARSAL.replace("speed = 40", 'speed = 40\nduration = "40 s"'))
    words = ("guide", str(lab), "-o", str(tmp_path / "imu"), "--no-page", "--json")
    status, out, _ = call(capsys, *words)
    found = json.loads(out)
    assert status == found["exit"] == 4
    assert not found["reached"]
    assert found["target"] == {"bias": "1 mg", "scale_factor_error": "0.1 %", "misalignment": "0.1 deg"}
    assert found["acquisition"]["finished"]


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ((), "one source"),
        (("LAB.toml",), "guide needs a new folder"),
        (("LAB.toml", "--phone", "-o", "x"), "one source"),
        (("--phone", "-o", "x", "--no-page"), "Leave that option out"),
        (("LAB.toml", "-o", "x", "--target", "bias"), "need NAME=SOMETHING"),
        (("LAB.toml", "-o", "x", "--rest", "3"), "--rest"),
        (("LAB.toml", "-o", "x", "--rest", "3 min"), "Say 0.5 to 60 s"),
        (("LAB.toml", "-o", "x", "--label", "up=plug"), "--label 'up'"),
        (("LAB.toml", "-o", "x", "--side", "w=long"), "--side 'w'"),
        (("LAB.toml", "-o", "x", "--for", "px5"), "no such format"),
        (("nothing.bin", "-o", "x"), "no such source"),
    ],
)
def test_wrong_usage_is_said(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    what: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    lab_folder(tmp_path, REHEARSAL)
    status, _, err = call(capsys, "guide", *words)
    assert status == 2, err
    assert what in err
    assert not (tmp_path / "x").exists()


def test_a_source_that_is_no_imu_is_refused_and_what_came_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = lab_folder(tmp_path, REHEARSAL.replace("hand_held", "npsat1").replace("hand1", "x_run1"))
    status, _, err = call(capsys, "guide", str(lab), "-o", str(tmp_path / "imu"), "--no-page")
    assert status == 2, err
    assert "acc_x" in err
