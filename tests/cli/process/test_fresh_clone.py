"""The set-up of a fresh clone: the demo installs what a user gets, every other job adds the tools, pins are one."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PIN = re.compile(r"^([a-z0-9.-]+)==(.*?)(?=^[a-z0-9]|\Z)", re.MULTILINE | re.DOTALL)


def pins(name: str) -> dict[str, set[str]]:
    """Return version, marker and hashes of every package in a file of pins."""
    text = re.sub(r"^ *#.*\n", "", (ROOT / name).read_text(), flags=re.MULTILINE)
    found: dict[str, set[str]] = {}
    for package, pinned in PIN.findall(text):
        found.setdefault(package, set()).add(" ".join(pinned.replace("\\", "").split()))
    return found


def required(words: list[str]) -> set[str]:
    return {re.split(r"[>=]", word)[0] for word in words}


def test_the_pins_of_a_user_are_those_of_the_tests() -> None:
    few, every = pins("requirements-run.txt"), pins("requirements.txt")
    assert len(few) > 30
    for package, pinned in few.items():
        assert pinned == every[package], package
        assert all("--hash=sha256:" in one for one in pinned), package


def test_the_pins_of_a_user_hold_what_the_package_needs_and_no_tool() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    few, extras = set(pins("requirements-run.txt")), project["optional-dependencies"]
    assert required(project["dependencies"]) | required(extras["build"]) <= few
    assert not few & required(extras["test"] + extras["docs"] + extras["dev"])


def test_pins_name_no_index() -> None:
    for name in ("requirements.txt", "requirements-run.txt"):
        assert not re.search(r"https?:|index", (ROOT / name).read_text())


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
@pytest.mark.parametrize(("job", "tools"), [("demo", False), ("test", True), ("check", True), ("bench", True)])
def test_a_fresh_clone_sets_up_what_a_job_needs(job: str, tools: bool, tmp_path: Path) -> None:
    planned = subprocess.run(
        ["make", "--dry-run", job, f"VENV={tmp_path / 'new'}"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert ("-r requirements.txt" in planned) is tools
    (parted,) = (line for line in planned.splitlines() if line.startswith("awk "))  # what is unpacked side by side
    (tmp_path / "new").mkdir()
    subprocess.run(parted, shell=True, cwd=ROOT, check=True)  # of our own Makefile
    parts = [tmp_path / "new" / name for name in ("large", "others")]
    assert all(f"--require-hashes -r {part}" in planned for part in parts)
    texts = [part.read_text(encoding="utf-8") for part in parts]
    assert sorted("".join(texts).splitlines()) == sorted((ROOT / "requirements-run.txt").read_text().splitlines())
    assert set(re.findall(r"^([a-z0-9.-]+)==", texts[0], re.MULTILINE)) == {"llvmlite", "scipy"}


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_the_tools_are_added_where_the_demo_was_first(tmp_path: Path) -> None:
    (tmp_path / "installed").touch()
    planned = subprocess.run(
        ["make", "--dry-run", "test", f"VENV={tmp_path}"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert "-r requirements.txt" in planned
    assert "requirements-run.txt" not in planned
