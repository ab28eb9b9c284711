"""A folder of results is replaced whole, and nothing is lost that this tool did not write."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.core.errors import StoreError
from inertialcal.files.write import exchange
from inertialcal.files.write.atomic import lock_folder, sync
from inertialcal.files.write.exchange import Kept, Manifest, recover, replace_folder

RESERVED = re.compile(r"(results|model)\.json|SHA256SUMS")
OLD = {"results.json": b"old", "model.json": b"old model"}
NEW = {"results.json": b"new", "report.html": b"new"}


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "campaign" / "out"
    folder.parent.mkdir()
    replace_folder(folder, OLD, RESERVED)
    return folder


def replaced(out: Path) -> Kept:
    kept = replace_folder(out, NEW, RESERVED)
    assert [one.name for one in out.parent.iterdir()] == ["out"]
    assert {name: (out / name).read_bytes() for name in NEW} == NEW
    manifest = Manifest.read(out)
    assert manifest is not None
    assert set(manifest.files) == set(NEW)
    return kept


def test_what_was_written_is_replaced_and_no_more_is_there(out: Path) -> None:
    assert replaced(out) == Kept()
    assert {one.name for one in out.iterdir()} == {*NEW, "SHA256SUMS"}


def test_sha256sum_takes_the_list(out: Path, need: Callable[[str], str]) -> None:
    done = subprocess.run([need("sha256sum"), "-c", "SHA256SUMS"], cwd=out, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stdout.splitlines() == ["model.json: OK", "results.json: OK"]
    assert not done.stderr


def test_a_file_of_the_user_stays_the_same_file(out: Path) -> None:
    (out / "notes.txt").write_text("mine")
    (out / "plots").mkdir(mode=0o750)
    before = [(out / name).stat() for name in ("notes.txt", "plots")]
    assert replaced(out).stayed == ["notes.txt", "plots"]
    assert [(out / name).stat().st_ino for name in ("notes.txt", "plots")] == [one.st_ino for one in before]
    assert (out / "plots").stat().st_mode == before[1].st_mode


@pytest.mark.parametrize("edit", [b"oldold", b"", b"new"])
def test_an_edited_file_is_kept_in_a_folder(out: Path, edit: bytes) -> None:
    (out / "results.json").write_bytes(edit)
    assert replaced(out).moved == {"results.json": "kept-1/results.json"}
    assert (out / "kept-1" / "results.json").read_bytes() == edit
    (out / "results.json").write_bytes(b"again")
    assert replaced(out).moved == {"results.json": "kept-2/results.json"}
    assert (out / "kept-1" / "results.json").read_bytes() == edit


def test_a_model_that_is_not_of_this_run_is_not_left_in_its_place(out: Path) -> None:
    (out / "model.json").write_bytes(b"edited")
    assert replaced(out).moved == {"model.json": "kept-1/model.json"}
    assert not (out / "model.json").exists()


def test_without_a_list_nothing_is_taken_for_ours(out: Path) -> None:
    (out / "SHA256SUMS").unlink()
    assert replaced(out).moved == {name: f"kept-1/{name}" for name in OLD}
    assert {name: (out / "kept-1" / name).read_bytes() for name in OLD} == OLD


@pytest.mark.parametrize("change", ["user's list", "added", "longer", "not text", "slash"])
def test_a_list_that_this_tool_did_not_write_claims_nothing(out: Path, change: str) -> None:
    (out / "notes.txt").write_bytes(b"mine")
    path, digest = out / "SHA256SUMS", exchange.file_digest(out / "notes.txt")
    text = path.read_text()
    path.write_bytes({
        "user's list": text.partition("\n")[2].encode() + f"{digest}  notes.txt\n".encode(),
        "added": text.encode() + f"{digest}  notes.txt\n".encode(),
        "longer": text.encode() + b"0" * 2**21,
        "not text": b"\xff\xfe" + text.encode(),
        "slash": Manifest("0" * 16, {"../out/notes.txt": digest}).text().encode(),
    }[change])  # fmt: skip
    kept = replaced(out)
    assert "notes.txt" in kept.stayed
    assert set(kept.moved) == {*OLD, "SHA256SUMS"}


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))


def _folder(path: Path) -> None:
    path.mkdir()
    (path / "inside").write_bytes(b"mine")


@pytest.mark.parametrize("name", ["results.json", "SHA256SUMS", "other"])
@pytest.mark.parametrize(
    "make",
    [os.mkfifo, _socket, _folder, lambda path: path.symlink_to("/dev/zero"), lambda path: path.symlink_to("nothing")],
    ids=["pipe", "socket", "folder", "link to a device", "broken link"],
)
def test_something_else_under_a_name_is_kept_unread(out: Path, name: str, make: Callable[[Path], None]) -> None:
    (out / name).unlink(missing_ok=True)
    make(out / name)
    mode = (out / name).lstat().st_mode
    replaced(out)
    place = out / name if name == "other" else out / "kept-1" / name
    assert place.lstat().st_mode == mode
    replaced(out)


@pytest.mark.parametrize("name", [".out-ready-0123456789abcdef", ".out-old-0123456789abcdef"])
def test_a_leftover_that_is_no_folder_is_left_alone(out: Path, name: str) -> None:
    os.mkfifo(out.with_name(name))
    replace_folder(out, NEW, RESERVED)
    assert out.with_name(name).exists()


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/tmp"), Path.touch])
def test_something_else_in_the_place_of_out_is_refused(tmp_path: Path, make: Callable[[Path], None]) -> None:
    make(tmp_path / "out")
    with pytest.raises(StoreError, match="cannot write"):
        replace_folder(tmp_path / "out", NEW, RESERVED)
    assert [one.name for one in tmp_path.iterdir()] == ["out"]


# ---- file systems that can do less --------------------------------------------------------------------------------


def _refuse(*_: Any, **__: Any) -> None:
    raise OSError(errno.EPERM, os.strerror(errno.EPERM))


@pytest.mark.parametrize("call", ["none", "refused"])
def test_without_an_exchange_in_one_call(out: Path, call: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> int:
        ctypes.set_errno(errno.EINVAL)
        return -1

    monkeypatch.setattr(exchange, "_system_call", lambda: None if call == "none" else refused)
    (out / "notes.txt").write_text("mine")
    assert replaced(out).stayed == ["notes.txt"]


def test_without_links_files_are_moved(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", _refuse)
    (out / "notes.txt").write_text("mine")
    (out / "results.json").write_text("edited")
    kept = replaced(out)
    assert kept.stayed == ["notes.txt"]
    assert kept.moved == {"results.json": "kept-1/results.json"}
    assert (out / "kept-1" / "results.json").read_text() == "edited"


def test_without_locks_a_fresh_leftover_is_anothers(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = out.with_name(".out-old-0123456789abcdef")
    other.mkdir()
    (other / "notes.txt").write_text("mine")
    with monkeypatch.context() as patch:
        patch.setattr("fcntl.flock", _refuse)
        replace_folder(out, NEW, RESERVED)
        assert other.is_dir()
        patch.setattr(exchange, "ABANDONED", -1.0)
        recover(out, RESERVED)
    assert not other.exists()
    assert (out / "notes.txt").read_text() == "mine"


def test_the_call_by_its_number_exchanges_too(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if os.uname().machine not in exchange.SYSCALL or sys.platform != "linux":
        pytest.skip("the number of the call is not known here")
    system = ctypes.CDLL(None, use_errno=True)

    class Old:
        syscall = system.syscall

    monkeypatch.setattr(ctypes, "CDLL", lambda *_, **__: Old)
    other = out.with_name("other")
    other.mkdir()
    (other / "a").touch()
    assert exchange._rename(other, out, exchange.EXCHANGE)
    assert (out / "a").exists()
    with pytest.raises(FileExistsError):
        exchange._rename(other, out, exchange.NO_REPLACE)


# ---- what comes while the exchange goes on -------------------------------------------------------------------------


@pytest.mark.parametrize("exchanging", [True, False])
def test_what_comes_between_the_links_and_the_exchange_is_kept(
    out: Path, exchanging: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    put = exchange._put_in_place

    def late(ready: Path, target: Path) -> Path:
        (target / "late.txt").write_text("late")
        (target / "report.html").write_text("of the user")
        (target / "results.json").write_text("edited late")
        (target / "notes.new").write_text("second")
        (target / "notes.new").rename(target / "notes.txt")  # as an editor saves
        return put(ready, target)

    monkeypatch.setattr(exchange, "_put_in_place", late)
    if not exchanging:
        monkeypatch.setattr(exchange, "_system_call", lambda: None)
    (out / "notes.txt").write_text("first")
    kept = replaced(out)
    assert (out / "late.txt").read_text() == "late"
    moved = {"notes.txt": "second", "report.html": "of the user", "results.json": "edited late"}
    assert {name: (out / place).read_text() for name, place in kept.moved.items()} == moved


def test_a_file_that_goes_on_growing_is_one_file(out: Path) -> None:
    with (out / "log.txt").open("w") as log:
        log.write("one\n")
        log.flush()
        replaced(out)
        log.write("two\n")
    assert (out / "log.txt").read_text() == "one\ntwo\n"


def test_what_cannot_be_moved_stays_and_is_told(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (out / "plots").mkdir()
    (out / "plots" / "a").write_text("mine")
    rename, real = exchange._rename, os.rename
    with monkeypatch.context() as patch:

        def renamed(source: Path, target: Path, how: str = "") -> bool | None:
            if source.name == "plots":
                _refuse()
            return rename(source, target, how) if how else real(source, target)

        patch.setattr(exchange, "_rename", renamed)
        patch.setattr(os, "rename", renamed)
        kept = replace_folder(out, NEW, RESERVED)
    (left,) = kept.stuck
    assert (Path(left) / "plots" / "a").read_text() == "mine"
    assert recover(out, RESERVED).stayed == ["plots"]
    assert (out / "plots" / "a").read_text() == "mine"
    assert [one.name for one in out.parent.iterdir()] == ["out"]


# ---- a full device, other processes -------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO])
@pytest.mark.parametrize("call", ["write", "fsync", "mkdir", "open"])
def test_a_full_device_leaves_the_old_results(
    out: Path, number: int, call: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = getattr(os, call)

    def full(*given: Any, **named: Any) -> Any:
        if call == "open" and not given[1] & os.O_CREAT:
            return real(*given, **named)
        raise OSError(number, os.strerror(number))

    (out / "notes.txt").write_text("mine")
    with monkeypatch.context() as patch:
        patch.setattr(os, call, full)
        with pytest.raises(StoreError, match=os.strerror(number)) as caught:
            replace_folder(out, NEW, RESERVED)
    assert caught.value.problems[0].code == "not_writable"
    assert ("Make room" in caught.value.problems[0].do) == (number != errno.EIO)
    assert {one.name for one in out.iterdir()} == {*OLD, "SHA256SUMS", "notes.txt"}
    assert [one.name for one in out.parent.iterdir()] == ["out"]


@pytest.mark.parametrize("number", [1, 2, 3, 4, 5, 6])
def test_a_flush_that_fails_loses_nothing(out: Path, number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """At whatever flush the disk fails, the results are the old or the new, and the user's files are there."""
    (out / "notes.txt").write_text("mine")
    (out / "plots").mkdir()
    (out / "plots" / "a").write_text("mine")
    real, calls = sync, []

    def failing(path: Path) -> None:
        calls.append(path)
        if len(calls) == number:
            _refuse()
        real(path)

    with monkeypatch.context() as patch:
        patch.setattr(exchange, "sync", failing)
        try:
            told = replace_folder(out, NEW, RESERVED).stuck
        except StoreError:
            assert (out / "results.json").read_bytes() == b"old"
        else:
            assert (out / "results.json").read_bytes() == b"new"
            assert told or number > len(calls) or not [*out.parent.glob(".out-*")]
    recover(out, RESERVED)
    assert (out / "notes.txt").read_text() == "mine"
    assert (out / "plots" / "a").read_text() == "mine"
    assert [one.name for one in out.parent.iterdir()] == ["out"]


def test_a_folder_that_another_run_holds_is_refused_after_a_while(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exchange, "WAIT", 0.1)
    handle = lock_folder(out.parent)
    try:
        with pytest.raises(StoreError, match="another run is writing"):
            replace_folder(out, NEW, RESERVED)
    finally:
        os.close(handle)
    replaced(out)


MANY = """
import re, sys
from pathlib import Path
from inertialcal.files.write.exchange import replace_folder
for number in range(25):
    text = f"{sys.argv[2]} {number}".encode()
    replace_folder(Path(sys.argv[1]), {"results.json": text, "model.json": text}, re.compile("results.json|model.json"))
"""


def test_processes_that_write_at_once_leave_one_whole(out: Path) -> None:
    (out / "notes.txt").write_text("mine")
    (out / "plots").mkdir()
    (out / "plots" / "a").write_text("mine")
    ran = [subprocess.Popen([sys.executable, "-c", MANY, str(out), name]) for name in ("one", "two")]
    seen = 0
    while any(one.poll() is None for one in ran):
        assert (out / "results.json").read_bytes()  # never absent
        seen += 1
    assert seen > 0
    assert [one.wait() for one in ran] == [0, 0]
    assert (out / "results.json").read_text() == (out / "model.json").read_text()
    assert {one.name for one in out.iterdir()} == {"results.json", "model.json", "SHA256SUMS", "notes.txt", "plots"}
    assert (out / "plots" / "a").read_text() == "mine"
    assert [one.name for one in out.parent.iterdir()] == ["out"]


def test_a_leftover_of_a_live_process_is_not_touched(out: Path) -> None:
    other = out.with_name(".out-ready-0123456789abcdef")
    other.mkdir()
    handle = lock_folder(out.parent)  # as the process that is at work
    try:
        recover(out, RESERVED)
        assert other.is_dir()
    finally:
        os.close(handle)
    recover(out, RESERVED)
    assert not other.exists()


def test_a_stopped_process_holds_others_up_no_longer_than_stated(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = f"import sys, time\nfrom pathlib import Path\nfrom inertialcal.files.write.atomic import lock_folder\n" \
        f"lock_folder(Path({str(out.parent)!r}))\nprint(1, flush=True)\ntime.sleep(60)"  # fmt: skip
    monkeypatch.setattr(exchange, "WAIT", 0.2)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        holder.stdout.readline()
        holder.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        with pytest.raises(StoreError):
            replace_folder(out, NEW, RESERVED)
        assert time.monotonic() - begin < 5.0
        holder.kill()
    replaced(out)


def test_a_folder_that_was_removed_meanwhile_is_written_anew(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put = exchange._put_in_place

    def removed(ready: Path, target: Path) -> Path:
        shutil.rmtree(target)
        return put(ready, target)

    monkeypatch.setattr(exchange, "_put_in_place", removed)
    assert replaced(out) == Kept()


def test_permissions_of_the_folder_stay(out: Path) -> None:
    out.chmod(0o775)
    replaced(out)
    assert out.stat().st_mode & 0o777 == 0o775
