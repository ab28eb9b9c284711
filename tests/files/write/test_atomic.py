"""A written file is complete or not there, whatever happens to the process that writes it."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from inertialcal.core.errors import StoreError
from inertialcal.files.write.atomic import atomic_write, lock_folder, remove_unfinished, work_folder, write_folder

KILLED = """
import os, signal, sys
from pathlib import Path
from inertialcal.files.write.atomic import atomic_write
with atomic_write(Path(sys.argv[1])) as aside:
    aside.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def written(path: Path, text: str = "whole") -> None:
    with atomic_write(path) as aside:
        aside.write_text(text)


def names(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.iterdir())


def killed_at(path: Path) -> str:
    done = subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = [name for name in names(path.parent) if name.startswith(".inertialcal-")]
    return left


def test_what_a_killed_process_left_goes_at_the_next_write(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    written(path, "before")
    killed_at(path)
    assert path.read_text() == "before"
    written(tmp_path / "b.csv")
    assert names(tmp_path) == ["a.csv", "b.csv"]


def test_what_a_live_process_is_writing_stays(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a.csv") as aside:
        aside.write_text("one")
        written(tmp_path / "a.csv", "two")
        assert aside.read_text() == "one"
    assert (tmp_path / "a.csv").read_text() == "one"
    assert names(tmp_path) == ["a.csv"]


@pytest.mark.parametrize("kind", ["file", "pipe", "link", "folder of the user"])
def test_only_what_this_tool_left_is_removed(tmp_path: Path, kind: str) -> None:
    target, name = tmp_path / "elsewhere", ".inertialcal-0123456789abcdef.part"
    target.mkdir()
    (target / "mine").touch()
    left = tmp_path / (name if kind != "folder of the user" else ".inertialcal-mine.part")
    if kind == "pipe":
        os.mkfifo(left)
    elif kind == "link":
        left.symlink_to(target)
    else:
        left.mkdir() if "folder" in kind else left.touch()
    remove_unfinished(tmp_path)
    assert os.path.lexists(left)
    assert (target / "mine").exists()


def test_permissions_of_a_replaced_file_stay(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    written(path)
    assert path.stat().st_mode & 0o777 == 0o666 & ~_umask()
    path.chmod(0o640)
    written(path, "again")
    assert path.stat().st_mode & 0o777 == 0o640


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@pytest.mark.parametrize("name", ["pipe", "link"])
def test_a_pipe_is_not_replaced(tmp_path: Path, name: str) -> None:
    """No test writes to a device itself: root would replace it, were this wrong."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    with pytest.raises(StoreError, match="a pipe"):
        written(tmp_path / name)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "link").is_symlink()


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_its_file_is_replaced(tmp_path: Path, there: bool) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "link").symlink_to("data/a.csv")
    if there:
        written(tmp_path / "data" / "a.csv", "before")
    written(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "data" / "a.csv").read_text() == "whole"
    assert names(tmp_path) == ["data", "link"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_read_only_file_is_not_replaced(tmp_path: Path) -> None:
    written(tmp_path / "a.csv")
    (tmp_path / "a.csv").chmod(0o444)
    with pytest.raises(StoreError, match="read-only"):
        written(tmp_path / "a.csv", "again")


def test_a_file_that_must_be_new_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "campaign.toml"

    def begin() -> None:
        with atomic_write(path, new=True) as aside:
            aside.write_text("ours")
            path.write_text("of the user, in the meantime")

    with pytest.raises(StoreError, match="exists"):
        begin()
    assert path.read_text() == "of the user, in the meantime"
    assert names(tmp_path) == ["campaign.toml"]


def test_a_name_of_the_longest_length_can_be_written(tmp_path: Path) -> None:
    path = tmp_path / ("n" * 251 + ".csv")
    written(path)
    assert path.read_text() == "whole"


def test_a_file_beyond_the_limit_of_the_process_is_refused(tmp_path: Path) -> None:
    path, limits = tmp_path / "a.csv", resource.getrlimit(resource.RLIMIT_FSIZE)
    written(path, "before")
    process = os.fork()
    if not process:
        status = 1
        try:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
            written(path, "x" * 5000)
        except StoreError as error:
            status = 0 if os.strerror(errno.EFBIG) in str(error) else 2
        finally:
            os._exit(status)
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
    assert path.read_text() == "before"
    assert names(tmp_path) == ["a.csv"]


def test_the_folder_of_unfinished_work_is_for_its_owner_alone(tmp_path: Path) -> None:
    with work_folder(tmp_path) as work:
        assert work.stat().st_mode & 0o777 == 0o700
        with pytest.raises(BlockingIOError):
            lock_folder(work)


def test_a_folder_is_written_whole(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    write_folder(tmp_path / "empty", {"a": b"1", ".b/c": b"2"})
    assert (tmp_path / "empty" / ".b" / "c").read_bytes() == b"2"
    with pytest.raises(StoreError, match="cannot write"):
        write_folder(tmp_path / "empty", {"a": b"3"})
    assert (tmp_path / "empty" / "a").read_bytes() == b"1"
    assert names(tmp_path) == ["empty"]
