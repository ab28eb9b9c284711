"""An acquisition that is followed: what the other process knows of itself, and how it ended, is what is shown."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from lab_devices import REHEARSAL, lab_folder, rehearsed
from lab_replays import LAYOUT, lot

from inertialcal.core.errors import DataError
from inertialcal.core.remarks import Remark
from inertialcal.files.loggers.bags import Growing
from inertialcal.files.loggers.rows import read_of
from inertialcal.lab.acquisition import followed as module
from inertialcal.lab.acquisition.followed import Followed
from inertialcal.lab.acquisition.recorder import RECORDING, File, Recorder, event_of
from inertialcal.lab.clock import Clock, Instant

COMMAND = [sys.executable, "-m", "inertialcal"]
FOLDER = REHEARSAL.replace("speed = 1000", "speed = 50").replace('"60 s"', '"5 s"')


def until(holds: Callable[[], object], seconds: float = 60.0) -> bool:
    """Wait until something holds; return whether it does."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if holds():
            return True
        time.sleep(0.02)
    return False


@contextmanager
def acquiring(folder: Path, faults: str = "") -> Iterator[subprocess.Popen[bytes]]:
    """Give a process that records, once its recording is there."""
    lab_folder(folder, FOLDER.format(over="tcp", faults=faults))
    made = subprocess.Popen([*COMMAND, "acquire", "LAB.toml", "-o", "out", "--quiet"], cwd=folder, env=os.environ)
    try:
        assert until((folder / "out" / RECORDING).exists)
        yield made
    finally:
        if made.poll() is None:
            made.send_signal(signal.SIGINT)
        made.wait()


def test_what_is_followed_is_what_the_acquisition_says_of_itself(tmp_path: Path) -> None:
    """In the end, of a recording with every fault: rows, counts, save intervals, remarks and samples are equal."""
    made = rehearsed(tmp_path, "tcp", '"late", "torn", "doubled", "lost"')
    with Followed(tmp_path / "out") as found:
        assert until(lambda: found.view().state == "done")
        own, other = made.view(), found.view()
        (mine,), (his,) = own.instruments, other.instruments
        for name in ("name", "channels", "rows", "damaged", "doubled", "late", "lost", "intervals"):
            assert getattr(mine, name) == getattr(his, name), name
        assert mine.damaged > 0
        assert "3 s x" in mine.intervals
        assert other.title == "rehearsal"
        assert [one.remark for one in other.remarks] == [one.remark for one in own.remarks]
        for one, two in zip(made.samples("suite", 500), found.samples("suite", 500), strict=True):
            np.testing.assert_allclose(one, two, atol=1e-6)
        assert other.written == (tmp_path / "out" / RECORDING).stat().st_size - 29 - 8  # but for the footer


def test_a_running_acquisition_is_followed_and_its_end_is_said(tmp_path: Path) -> None:
    with acquiring(tmp_path) as made, Followed(tmp_path / "out") as found:
        assert until(lambda: found.view().state == "running" and found.view().instruments)
        assert until(lambda: found.view().instruments[0].rows > 10)
        assert found.view().instruments[0].connected
        made.send_signal(signal.SIGINT)
        assert until(lambda: found.view().state == "done")
        assert not found.view().instruments[0].connected


def test_a_kill_is_seen_by_the_lock_and_a_new_recording_is_followed(tmp_path: Path) -> None:
    with acquiring(tmp_path) as made, Followed(tmp_path / "out") as found:
        assert until(lambda: found.view().state == "running" and found.view().instruments)
        assert until(lambda: found.view().instruments[0].rows > 0)
        run = found.view().run
        made.kill()
        begin = time.monotonic()
        assert until(lambda: found.view().state == "died")
        assert time.monotonic() - begin < module.STALLED  # not by a sign of life that stays away
        assert "inertialcal acquire --seal" in found.view().why
        rows = found.view().instruments[0].rows
        made.wait()
        shutil.rmtree(tmp_path / "out")
        assert until(lambda: "removed" in found.view().why)
        with acquiring(tmp_path):
            assert until(lambda: found.view().state == "running" and found.view().run > run)
        assert rows > 0


def test_a_process_that_hangs_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STALLED", 1.0)
    with acquiring(tmp_path) as made, Followed(tmp_path / "out") as found:
        assert until(lambda: found.view().state == "running")
        made.send_signal(signal.SIGSTOP)
        try:
            assert until(lambda: found.view().state == "stalled")
            assert "no sign of life" in found.view().why
        finally:
            made.send_signal(signal.SIGCONT)
        assert until(lambda: found.view().state == "running")


def test_without_locks_the_sign_of_life_tells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STALLED", 1.0)
    monkeypatch.setattr(module, "is_written", lambda fd: None)
    with acquiring(tmp_path) as made, Followed(tmp_path / "out") as found:
        assert until(lambda: found.view().state == "running")
        made.kill()
        assert until(lambda: found.view().state == "died")


def test_a_folder_without_a_recording_is_refused(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(DataError) as refused:
            Followed(folder)
        assert refused.value.problems[0].code == "missing_file"
        assert f"inertialcal acquire LAB.toml -o {folder}" in refused.value.problems[0].do


def test_steps_status_and_links_are_shown(tmp_path: Path) -> None:
    """A recording by `Recorder` alone: what was said in it, in order."""
    recorder = Recorder(File(tmp_path / RECORDING), {"imu": LAYOUT}, {})
    second = 1_000_000_000

    def at(seconds: float) -> Instant:
        return Instant(round(seconds * second), round((1e9 + seconds) * second))

    recorder.event(at(1.0), "begun", {"title": "of a test", "speed": 1, "sync": 0.5})
    recorder.event(at(1.0), "identified", {"instrument": "imu", "identity": "number 7"})
    recorder.event(at(2.0), "status", {"text": "face 2 of 6: hold still"})
    values = [["table.rate", 10.0, "deg/s"]]
    recorder.event(at(3.0), "step", {"number": 2, "count": 3, "name": "turn", "hold": 60.0, "values": values})
    recorder.event(at(4.0), "remark", event_of(Remark("unplugged", "error", "gone", where="imu")))
    recorder.event(at(5.0), "of a later version", {"x": 1})
    recorder.commit()
    with Followed(tmp_path) as found:
        assert until(lambda: found.view().state == "running")
        view = found.view()
        assert (view.title, view.status) == ("of a test", "face 2 of 6: hold still")
        assert view.step is not None
        assert (view.step.number, view.step.count, view.step.name) == (2, 3, "turn")
        assert view.step.values == (("table.rate", 10.0, "deg/s"),)
        assert 0.0 < view.step.left <= 58.0
        assert 4.0 <= view.elapsed < 60.0
        (one,) = view.instruments
        assert (one.identity, one.connected) == ("number 7", False)
        recorder.event(at(6.0), "remark", event_of(Remark("connected_again", "warning", "back", where="imu")))
        recorder.event(at(7.0), "ended", {"state": "failed", "why": "imu: the interlock is open"})
        recorder.commit()
        assert until(lambda: found.view().state == "stopping")
        assert found.view().instruments[0].connected
        recorder.finish()
        assert until(lambda: found.view().state == "failed")
        assert found.view().why == "imu: the interlock is open"
    recorder.disk.close()


@pytest.mark.parametrize("seed", range(20))
def test_a_file_that_grows_byte_by_byte_gives_each_row_once(tmp_path: Path, seed: int) -> None:
    """Cut anywhere, gone on with anywhere; a chunk whose bits were flipped is left out, and counted."""
    rng = np.random.default_rng(seed)
    path = tmp_path / RECORDING
    recorder, first, ends = Recorder(File(path), {"imu": LAYOUT}, {}), 0, []
    for _ in range(8):
        recorder.add("imu", lot(first, 30))
        first += 30
        recorder.commit()
        ends.append(path.stat().st_size)
    recorder.finish()
    recorder.disk.close()
    data = bytearray(path.read_bytes())
    flipped = int(rng.integers(1, 7)) if seed % 2 else 0
    if flipped:
        data[ends[flipped - 1] + int(rng.integers(60, 500))] ^= 1 << int(rng.integers(8))
    growing, rows = Growing("grown"), list[int]()
    target, done = tmp_path / "grown", 0
    target.touch()
    while done < len(data):
        step = int(rng.integers(1, 3000))
        with target.open("ab") as out:
            out.write(data[done : done + step])
        done += step
        with target.open("rb") as stream:
            for part in growing.messages(stream):
                found = read_of(part, growing.bag, "imu", LAYOUT)
                rows += [] if found is None else found[0].rows["counter"].tolist()
    assert growing.ended
    assert growing.damaged == bool(flipped)
    left_out = set(range(30 * flipped, 30 * flipped + 30)) if flipped else set()
    assert rows == [i for i in range(240) if i not in left_out]


def test_the_clock_goes_on_between_two_chunks(tmp_path: Path) -> None:
    recorder = Recorder(File(tmp_path / RECORDING), {"imu": LAYOUT}, {})
    recorder.add("imu", lot(0, 30))
    recorder.commit()
    with Followed(tmp_path, Clock()) as found:
        assert until(lambda: found.view().instruments)
        first = found.seconds()
        assert until(lambda: found.seconds() > first)
    recorder.disk.close()
