"""Pipes, links to themselves and files that give errors, where a command takes the path of a small file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.campaign.file.load import load
from inertialcal.campaign.twins.twin import TRUTH, read_truth
from inertialcal.core.errors import InertialcalError
from inertialcal.files.info.motion import is_laid
from inertialcal.files.write.atomic import atomic_write
from inertialcal.procedures.positions.orientations import sections_of


def refusal(call: Callable[[], object]) -> str:
    with pytest.raises(InertialcalError) as caught:
        call()
    return str(caught.value)


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_a_pipe_is_never_replaced(pipe: Path) -> None:
    def write() -> None:
        with atomic_write(pipe) as aside:
            aside.write_text("x", encoding="utf-8")

    assert "a device or a pipe" in refusal(write)
    assert pipe.is_fifo()
    assert [*pipe.parent.iterdir()] == [pipe]


def test_a_link_to_itself_is_no_file(tmp_path: Path) -> None:
    loop = tmp_path / "loop.csv"
    loop.symlink_to("loop.csv")
    assert "loop.csv" in refusal(lambda: ic.allan(loop))


def test_a_pipe_for_a_chain_or_sections_is_not_waited_for(pipe: Path, tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    table.write_text("t,x\n" + "".join(f"{number},1\n" for number in range(20)), encoding="utf-8")
    assert "not a regular file" in refusal(lambda: ic.allan(table, chain=str(pipe), units={"x": "deg/s"}))
    pipe.rename(pipe.with_suffix(".json"))
    assert "not a regular file" in refusal(lambda: sections_of(pipe.with_suffix(".json")))


def test_a_pipe_for_the_truth_is_not_waited_for(tmp_path: Path) -> None:
    ic.simulate("mesa", tmp_path / "made", seed=1)
    (tmp_path / "made" / TRUTH).unlink()
    os.mkfifo(tmp_path / "made" / TRUTH)
    assert "not a regular file" in refusal(lambda: read_truth(tmp_path / "made"))


def test_a_campaign_file_that_gives_an_error_is_named(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").symlink_to("/proc/self/mem")
    assert "campaign.toml: cannot be read" in refusal(lambda: load(tmp_path))


def test_a_path_without_a_name_is_refused() -> None:
    assert refusal(lambda: ic.allan(""))


def test_numbers_that_nothing_has_claim_no_test(tmp_path: Path) -> None:
    turns = [("9.8e160", "0", "0"), ("0", "9.8e160", "0"), ("0", "0", "9.8e160")] * 3
    rows = [f"{t / 10},{','.join(turns[t // 40])}" for t in range(40 * len(turns))]
    head = "t_s,acc_x [m/s^2],acc_y [m/s^2],acc_z [m/s^2]"
    (tmp_path / "laid.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    recording = ic.read(tmp_path / "laid.csv")
    assert not is_laid(recording)
