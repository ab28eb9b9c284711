"""Windows, simulated: no locks, no flushing of folders or of what is read-only, no renaming onto a folder that exists.

What its system calls refuse is refused here: a folder is not opened, a descriptor that may not write is not flushed, a
name that is taken by a folder is not given again, and what only POSIX has is absent. Console and drives are not tried.
"""

from __future__ import annotations

import ast
import errno
import fcntl
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path, PureWindowsPath

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import inertialcal as ic
from inertialcal.campaign.engine.run import run
from inertialcal.core.errors import PlanError, StoreError
from inertialcal.files.write import atomic, exchange
from inertialcal.files.write.atomic import atomic_write, write_folder
from inertialcal.files.write.portable import portable_name

PACKAGE = Path(__file__).resolve().parents[3] / "src" / "inertialcal"

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Refuse what Windows refuses, and hide what it has not."""
    opened, flushed = os.open, os.fsync

    def open_file(path: str | os.PathLike[str], flags: int, mode: int = 0o777) -> int:
        if os.path.isdir(path):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return opened(path, flags, mode)

    def fsync(handle: int) -> None:
        if not fcntl.fcntl(handle, fcntl.F_GETFL) & (os.O_WRONLY | os.O_RDWR):
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        flushed(handle)

    def refusing(rename: Callable[..., None]) -> Callable[..., None]:
        def renamed(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> None:
            if os.path.isdir(target):
                raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(target))
            rename(source, target)

        return renamed

    monkeypatch.setattr(os, "open", open_file)
    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(os, "rename", refusing(os.rename))
    monkeypatch.setattr(os, "replace", refusing(os.replace))
    for name in ("geteuid", "getuid", "O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "sched_getaffinity", "uname"):
        monkeypatch.delattr(os, name)
    monkeypatch.setattr(shutil, "_use_fd_functions", False)  # as there: folders are removed by name
    monkeypatch.setattr(atomic, "fcntl", None)
    monkeypatch.setattr(atomic, "WINDOWS", True)
    monkeypatch.setattr(exchange, "_system_call", lambda: None)


@pytest.mark.usefixtures("windows")
def test_a_file_is_written_and_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    for text in ("a\n1\n", "a\n2\n"):
        with atomic_write(path) as aside:
            aside.write_text(text, encoding="utf-8", newline="\n")
        assert path.read_bytes() == text.encode()
    assert os.listdir(tmp_path) == ["out.csv"]


@pytest.mark.usefixtures("windows")
@pytest.mark.parametrize("there", [False, True], ids=["new", "empty"])
def test_a_folder_is_written(tmp_path: Path, there: bool) -> None:
    target = tmp_path / "campaign"
    if there:
        target.mkdir()
    write_folder(target, {"a/b.csv": b"x\n", "campaign.toml": b""})
    assert (target / "a" / "b.csv").read_bytes() == b"x\n"
    assert os.listdir(tmp_path) == ["campaign"]


@pytest.mark.usefixtures("windows")
def test_a_folder_that_holds_something_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(StoreError, match="cannot write"):
        write_folder(tmp_path, {"campaign.toml": b""})
    assert (tmp_path / "mine.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.usefixtures("windows")
def test_a_campaign_is_run_twice_with_the_same_results(campaign: Callable[..., Path]) -> None:
    folder = campaign()
    run(folder)
    first = (folder / "out" / "results.json").read_bytes()
    run(folder)
    assert (folder / "out" / "results.json").read_bytes() == first
    assert json.loads(first)["results"]
    assert b"\r" not in first
    assert sorted(os.listdir(folder)) == ["campaign.toml", "one.csv", "out", "out-cache"]


@pytest.mark.parametrize(
    ("name", "portable"),
    [("CON", "_CON"), ("nul.csv", "_nul.csv"), ("com1.tar.gz", "_com1.tar.gz"), ("LPT³", "_LPT³"),
     ("a:b.csv", "a_b.csv"), ("dots...", "dots"), ("end. .", "end"), ("..", "_"), ("a\tb?", "a_b_"),
     ("console.csv", "console.csv"), ("com10", "com10"), ("Messung 3 (ü).csv", "Messung 3 (ü).csv")],
)  # fmt: skip
def test_names_that_windows_has_not_are_changed(name: str, portable: str) -> None:
    assert portable_name(name) == portable


@settings(max_examples=50)
@given(st.text("CONul1 .:/\\\0é", min_size=1))
def test_a_portable_name_is_a_name_and_stays(name: str) -> None:
    once = portable_name(name)
    assert portable_name(once) == once
    assert once == PureWindowsPath(once).name
    assert not PureWindowsPath(once).is_reserved()


def test_a_campaign_of_a_call_can_be_opened_on_every_system(tmp_path: Path) -> None:
    """Files that differ in case alone, a device and a stream of Windows: all are there, under names of their own."""
    names = ("Run.csv", "run.csv", "aux.csv", "a:b.csv")
    rng = np.random.default_rng(1)
    for name in names:
        np.savetxt(tmp_path / name, rng.normal(0.0, 1e-3, 500), header="gyro_x [deg/s]", comments="", fmt="%.7f")
    target = tmp_path / "campaign"
    found = ic.allan([tmp_path / name for name in names], sample_rate=100.0)
    found.write_campaign(target)
    copies = sorted(os.listdir(target / "recordings"))
    assert copies == ["2_run.csv", "Run.csv", "_aux.csv", "a_b.csv"]
    assert sorted(ic.run(target).inputs.values())[:4] == sorted(found.inputs.values())


def test_sensors_whose_models_would_be_one_file_are_refused(campaign: Callable[..., Path]) -> None:
    file = campaign() / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    sensor = text[text.index("[sensors.suite]") : text.index("[recordings.one]")]
    file.write_text(text + sensor.replace("suite", "Suite"), encoding="utf-8")
    with pytest.raises(PlanError, match="'suite' and 'Suite' differ in upper and lower case alone"):
        ic.check(file.parent)


def untranslated(call: ast.Call) -> bool:
    """Return whether a call writes text whose ends of line depend on the system, or whose encoding does."""
    given = {one.arg for one in call.keywords}
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name == "write_text":
        return not {"encoding", "newline"} <= given
    mode = [one.value for one in call.args[:2] if isinstance(one, ast.Constant) and isinstance(one.value, str)]
    writes = any(set(one) <= set("wax+t") and set(one) & set("wax") for one in mode)
    return name == "open" and writes and not {"encoding", "newline"} <= given and "force_zip64" not in given


@pytest.mark.parametrize("code", ['p.write_text(x, encoding="utf-8")', 'open(p, "w", encoding="utf-8")', 'p.open("a")'])
def test_the_search_for_ends_of_line_finds_them(code: str) -> None:
    assert any(untranslated(node) for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call))


def test_text_that_is_written_has_one_encoding_and_one_end_of_line() -> None:
    """Its SHA-256 is stated, and compared with that of another machine."""
    found = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and untranslated(node)
    ]
    assert found == []
