"""``run`` replaces its own files in ``out/``, keeps all others and says so; inputs that change are refused."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.calls.call import _placed
from inertialcal.campaign.calls.given import Files
from inertialcal.campaign.engine import whole as engine
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.inputs import sources
from inertialcal.campaign.models.find import find_model
from inertialcal.campaign.outcome.results_file import find_results
from inertialcal.campaign.twins.twin import simulate
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, StoreError
from inertialcal.files import read_table
from inertialcal.files.write.exchange import Manifest
from inertialcal.files.write.recording import write
from inertialcal.procedures.given import Said

Write = Callable[..., Path]
LEFT = (".out-", ".inertialcal-")


def codes(folder: Path) -> list[str]:
    return [one.code for one in run(folder).notes]


def nothing_left(folder: Path) -> bool:
    return not [one for one in os.listdir(folder) if one.startswith(LEFT)]


def test_a_file_of_the_user_is_kept_and_told(campaign: Write, capsys: pytest.CaptureFixture[str]) -> None:
    folder = campaign()
    assert codes(folder) == []
    before = (folder / "out" / "results.json").read_bytes()
    (folder / "out" / "mynotes.txt").write_text("mine")
    with pytest.raises(SystemExit):
        main(["run", str(folder)])
    said = capsys.readouterr().out
    assert "info: kept in out/: mynotes.txt (not written by inertialcal)" in said
    with pytest.raises(SystemExit):
        main(["run", str(folder), "--json"])
    remarks = json.loads(capsys.readouterr().out)["remarks"]
    assert [one["code"] for one in remarks if one["code"].startswith("file_")] == ["file_kept"]
    assert (folder / "out" / "mynotes.txt").read_text() == "mine"
    assert (folder / "out" / "results.json").read_bytes() == before
    assert nothing_left(folder)


def test_edited_results_are_kept_and_give_no_changes(campaign: Write) -> None:
    folder = campaign()
    run(folder)
    path = folder / "out" / "results.json"
    edited = path.read_text().replace("1.0", "2.0")
    path.write_text(edited)
    outcome = run(folder)
    assert outcome.changed == []
    assert [one.what for one in outcome.notes] == [
        "moved to out/kept-1/: results.json (edited since the last run, or not written by one)"
    ]
    assert (folder / "out" / "kept-1" / "results.json").read_text() == edited
    assert codes(folder) == []  # told once


def test_a_pipe_in_the_place_of_results_does_not_hold_a_run_up(campaign: Write) -> None:
    folder = campaign()
    run(folder)
    (folder / "out" / "results.json").unlink()
    os.mkfifo(folder / "out" / "results.json")
    assert codes(folder) == ["file_moved"]
    assert (folder / "out" / "kept-1" / "results.json").is_fifo()


@pytest.mark.parametrize("place", ["out", "out/plots"])
def test_a_folder_that_cannot_be_written_is_refused_before_the_work(
    campaign: Write, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = campaign()
    run(folder)
    (folder / "out" / "plots").mkdir()
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: str(path) != str(folder / place) and access(path, mode))
    monkeypatch.setattr(engine, "reduce_campaign", lambda *_: pytest.fail("worked"))
    with pytest.raises(StoreError) as caught:
        run(folder)
    assert caught.value.problems[0].code == "not_writable"


def test_a_full_device_is_refused(campaign: Write) -> None:
    folder = campaign()
    run(folder)
    before = (folder / "out" / "report.html").read_bytes()
    campaign(('limit = "5 %"', 'limit = "4 %"'))  # without a change nothing is written
    program = "from inertialcal.cli.__main__ import entry; entry()"
    line = f"ulimit -f 40; exec {sys.executable} -c '{program}' run {folder} --json"
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    (error,) = json.loads(done.stdout)["errors"]
    assert (done.returncode, error["code"], error["do"]) == (3, "not_writable", "Make room, then run again")
    assert (folder / "out" / "report.html").read_bytes() == before
    assert nothing_left(folder)


# ---- after a kill -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("read", ["results", "out", "model"])
def test_what_reads_results_finishes_what_a_kill_left(campaign: Write, read: str) -> None:
    folder = campaign()
    run(folder)
    manifest = Manifest.read(folder / "out")
    assert manifest is not None
    (folder / "out").rename(folder / f".out-ready-{manifest.run}")  # killed between its two renames
    if read == "model":
        assert find_model(folder).path == str(folder / "out" / "model.json")
    else:
        assert find_results(folder / "out" if read == "out" else folder, of_campaign=read == "results") is not None
    assert nothing_left(folder)


# ---- inputs that change -------------------------------------------------------------------------------------------


def changed(folder: Path, monkeypatch: pytest.MonkeyPatch, change: Callable[[], Any]) -> list[str]:
    """Run with a change after the inputs were read; return the inputs that were refused."""
    before = sorted(os.listdir(folder))
    reduce = engine.reduce_campaign

    def reduced(*given: Any) -> Any:
        found = reduce(*given)
        change()
        return found

    monkeypatch.setattr(engine, "reduce_campaign", reduced)
    with pytest.raises(DataError) as caught:
        run(folder)
    assert {one.code for one in caught.value.problems} == {"input_changed"}
    assert sorted({*os.listdir(folder)} - {"out-cache"}) == before
    return [one.where for one in caught.value.problems]


def test_a_recording_that_grows_is_refused(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()

    def grow() -> None:
        with (folder / "one.csv").open("a") as file:
            file.write("1.0,1.02,0.004,2,6\n")

    assert changed(folder, monkeypatch, grow) == ["one.csv"]


def test_one_byte_changed_with_its_time_set_back_is_refused(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()
    path = folder / "one.csv"
    found = path.stat()

    def change() -> None:
        path.write_bytes(path.read_bytes().replace(b"1", b"2", 1))
        os.utime(path, ns=(found.st_atime_ns, found.st_mtime_ns))

    assert changed(folder, monkeypatch, change) == ["one.csv"]


def test_a_campaign_edited_during_its_run_is_refused(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()
    path = folder / "campaign.toml"
    assert changed(folder, monkeypatch, lambda: path.write_text(path.read_text() + "\n")) == ["campaign.toml"]


def test_an_input_that_becomes_a_pipe_is_refused(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()

    def pipe() -> None:
        (folder / "one.csv").unlink()
        os.mkfifo(folder / "one.csv")

    assert changed(folder, monkeypatch, pipe) == ["one.csv"]


def test_a_copy_with_the_same_bytes_is_no_change(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()

    def copy() -> None:
        shutil.copy(folder / "one.csv", folder / "copy.csv")
        (folder / "copy.csv").replace(folder / "one.csv")

    with pytest.raises(pytest.fail.Exception, match="DID NOT RAISE"):
        changed(folder, monkeypatch, copy)


def test_a_file_that_two_tests_read_differently_is_refused(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    one = 'id = "first"\nprocedure = "rate_table"\nrecordings = ["one"]\n'
    more = one.replace("first", "second") + 'groups = ["2"]\nplan = { axis = "x", zero_reference = true }\n'
    folder = campaign((one, f'{one}groups = ["1"]\n'), ("[[requirements]]", f"[[tests]]\n{more}[[requirements]]"))
    read, path = read_table, folder / "one.csv"
    text = path.read_text()

    def reading(given: Any, **said: Any) -> Any:
        found = read(given, **said)
        path.write_text(text if path.read_text() != text else f"{text}4.0,4.05,0.004,2,6\n")  # and back again
        return found

    monkeypatch.setattr(sources, "read_table", reading)
    with pytest.raises(DataError) as caught:
        run(folder)
    assert {one.code for one in caught.value.problems} == {"input_changed"}


SLOW = """
import sys, time
from inertialcal.campaign.calls.call import _placed
from inertialcal.campaign.calls.given import Files
from inertialcal.campaign.engine import whole as engine
from inertialcal.cli.__main__ import main
def tell(done, total, what):
    print(done, total, flush=True)
    sys.stdin.readline()
real = engine.reduce_campaign
engine.reduce_campaign = lambda campaign, store, progress, cache: real(campaign, store, tell, cache)
main(["run", sys.argv[1]])
"""


def test_a_recording_written_by_another_process_during_a_run_is_refused(campaign: Write) -> None:
    folder = campaign()
    with subprocess.Popen(
        [sys.executable, "-c", SLOW, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        for _ in range(2):  # before the test, and after it
            process.stdout.readline()
            process.stdin.write("\n")
            process.stdin.flush()
            (folder / "one.csv").write_text((folder / "one.csv").read_text() + "4.0,4.05,0.004,2,6\n")
        error = process.communicate()[1]
    assert process.returncode == 3
    assert "one.csv: the file changed while it was read" in error
    assert not (folder / "out").exists()


# ---- two at once ----------------------------------------------------------------------------------------------------


def test_two_runs_at_once_leave_one_whole(campaign: Write) -> None:
    folder = campaign()
    run(folder)
    (folder / "out" / "mynotes.txt").write_text("mine")
    program = "from inertialcal.cli.__main__ import entry; entry()"
    line = [sys.executable, "-c", program, "run", str(folder), "-q"]
    ran = [subprocess.Popen(line) for _ in range(2)]
    assert [one.wait() for one in ran] == [4, 4]
    manifest = Manifest.read(folder / "out")
    assert manifest is not None
    assert all(manifest.lists(folder / "out" / name) for name in manifest.files)
    assert {one.name for one in (folder / "out").iterdir()} == {*manifest.files, "SHA256SUMS", "mynotes.txt"}
    assert nothing_left(folder)


# ---- simulated campaigns -------------------------------------------------------------------------------------------


def test_a_killed_simulation_leaves_no_half_campaign(tmp_path: Path) -> None:
    code = (
        "import os, sys\nfrom pathlib import Path\nfrom inertialcal.campaign.twins.twin import simulate\n"
        "real, calls = os.fsync, []\n"
        "def fsync(handle):\n    calls.append(1)\n    os._exit(9) if len(calls) == 3 else real(handle)\n"
        "os.fsync = fsync\nsimulate('mesa', sys.argv[1], 1)"
    )
    target = tmp_path / "campaign"
    done = subprocess.run([sys.executable, "-c", code, str(target)], check=False)
    assert done.returncode == 9
    assert not target.exists()
    assert not nothing_left(tmp_path)
    simulate("mesa", target, 1)
    assert nothing_left(tmp_path)
    assert (target / ".truth" / "truth.json").is_file()


def test_a_campaign_written_into_a_folder_overwrites_no_recording_of_it(tmp_path: Path) -> None:
    source, folder = tmp_path / "a.csv", tmp_path / "campaign"
    (folder / "recordings").mkdir(parents=True)
    source.write_text("of the call")
    (folder / "recordings" / "a.csv").write_text("of the user")
    for _ in range(2):  # the second time it is there
        assert _placed(str(source), Files(Said()), folder, set(), write) == "recordings/2_a.csv"
    assert (folder / "recordings" / "a.csv").read_text() == "of the user"
    assert sorted(os.listdir(folder / "recordings")) == ["2_a.csv", "a.csv"]
