"""Recordings of heads beside the file of their body: what `info` says to type, and the campaign that `init` writes."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from independent.orbit.heads import made, on_line
from inertialcal.procedures.heads.suggest import body_of
from typed_commands import call, call_json


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with three heads, the file of their body above them."""
    one = made(on_line(seconds=1200.0), np.random.default_rng(1))
    (tmp_path / "station" / "recordings").mkdir(parents=True)
    one.write(tmp_path / "station" / "recordings")
    (tmp_path / "station" / "body.toml").write_text(one.toml(biases=True), encoding="utf-8", newline="\n")
    monkeypatch.chdir(tmp_path)
    return Path("station")


def test_info_says_the_whole_command_and_it_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = call(capsys, "info", str(folder / "recordings" / "b.csv"))
    typed = " ".join(out.split("next: ")[1].split())
    assert typed.endswith(
        "heads station/recordings/b.csv station/recordings/a.csv station/recordings/c.csv --body station/body.toml"
    )
    found = call_json(capsys, *shlex.split(typed)[1:])
    assert found["exit"] == 0
    assert {row["axis"] for row in found["results"] if row["quantity"] == "bias"} == {"x", "y", "z"}


def test_init_makes_one_test_of_all_heads_and_it_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, _ = call(capsys, "init", str(folder), "--yes")
    assert status == 0
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert 'procedure = "heads"' in text
    assert 'recordings = ["a", "b", "c"]' in text
    assert text.count('head = { file = "body.toml" }') == 3
    assert call(capsys, "run", str(folder))[0] == 0


def test_without_its_body_or_with_two_heads_nothing_is_said_of_heads(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert body_of(folder / "recordings" / "other.csv") is None
    (folder / "recordings" / "c.csv").unlink()
    assert "inertialcal heads" not in call(capsys, "info", str(folder / "recordings" / "a.csv"))[1]
    (folder / "body.toml").write_text("heads = 3", encoding="utf-8")
    assert body_of(folder / "recordings" / "a.csv") is None
    (folder / "body.toml").write_bytes(b"\xff\xfe")
    assert body_of(folder / "recordings" / "a.csv") is None
