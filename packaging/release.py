"""A release: built, checked, installed into an empty environment, tried there, and tagged.

    python packaging/release.py          build everything and try it, no tag
    python packaging/release.py --tag    the same on a clean tree, then the tag of this version

The wheel is built from the unpacked source distribution, so that what that lacks is noticed. It is tried in an
environment with the pins of requirements-run.txt alone; the tests come from the source distribution.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
SUBSET = (
    "tests/statistics",
    "tests/physics",
    "tests/core",
    "tests/cli/test_commands.py",
    "tests/report/test_page.py",
)  # tests of what is installed


def main() -> None:
    """Run the steps, each named on a line of its own."""
    wanted = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    wanted.add_argument("--tag", action="store_true", help="tag this version when all of it passed")
    tag = wanted.parse_args().tag
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    problems = unready(version) if tag else []
    if problems:
        sys.exit("\n".join(["not ready for a release:", *problems]))
    with tempfile.TemporaryDirectory() as folder:
        source, wheel = build(Path(folder))
        checked(source, wheel)
        tried(wheel, Path(folder))
    if tag:
        run("git", "tag", "-a", f"v{version}", "-m", f"inertialcal {version}", cwd=ROOT)
    print(f"{wheel.name} and {source.name} are in {DIST}" + (f", tagged v{version}" if tag else ""))


def unready(version: str) -> list[str]:
    """Return what speaks against this version, one line each."""
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    problems = []
    if not re.search(rf"^## {re.escape(version)} - \d{{4}}-\d\d-\d\d$", changes, re.MULTILINE):
        problems.append(f"CHANGELOG.md has no section '## {version} - YYYY-MM-DD'")
    if re.search(r"^## Unreleased$", changes, re.MULTILINE):
        problems.append("CHANGELOG.md has a section '## Unreleased': what stands there belongs to no version")
    if run("git", "status", "--porcelain", cwd=ROOT):
        problems.append("there are changes that are not committed")
    if run("git", "tag", "--list", f"v{version}", cwd=ROOT):
        problems.append(f"there is a tag v{version} already")
    return problems


def build(folder: Path) -> tuple[Path, Path]:
    """Return the source distribution, and the wheel that is built from it alone."""
    step("build")
    shutil.rmtree(DIST, ignore_errors=True)
    run(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(DIST), cwd=ROOT)
    source = next(DIST.glob("*.tar.gz"))
    with tarfile.open(source) as packed:
        packed.extractall(folder, filter="data")
    unpacked = next(folder.glob("inertialcal-*"))
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(DIST), cwd=unpacked)
    return source, next(DIST.glob("*.whl"))


def checked(source: Path, wheel: Path) -> None:
    """Have the index's own checks read both."""
    step("check")
    run(sys.executable, "-m", "twine", "check", "--strict", str(source), str(wheel))
    run(sys.executable, "-m", "check_wheel_contents", str(wheel))


def tried(wheel: Path, folder: Path) -> None:
    """Install the wheel where nothing else is, and use it without a network."""
    step("install into an empty environment")
    venv.create(folder / "env", with_pip=True)
    python = next(path for path in (folder / "env/bin/python", folder / "env/Scripts/python.exe") if path.exists())
    pip = (str(python), "-m", "pip", "install", "--quiet")
    run(*pip, "--require-hashes", "-r", str(ROOT / "requirements-run.txt"))
    run(*pip, "--no-deps", "--no-index", str(wheel))
    step("use it, without a network" if offline() else "use it (this machine cannot take the network away)")
    empty = folder / "empty"
    empty.mkdir()
    run(*offline(), str(python), "-c", "import inertialcal; print(inertialcal.__version__)", cwd=empty)
    print(run(*offline(), str(python.with_name("inertialcal")), "demo", cwd=empty))
    step(f"tests of {', '.join(SUBSET)} against what is installed")
    run(*pip, "--require-hashes", "-r", str(ROOT / "requirements.txt"))
    tests = next(folder.glob("inertialcal-*"))
    for module in (tests / "src").rglob(
        "*.py"
    ):  # what is tested is what is installed; tests read files of examples there
        module.unlink()
    fast = ("-m", "not slow and not bench", "-n", "2", "-q", "--benchmark-disable")
    print(run(str(python), "-m", "pytest", *fast, *SUBSET, cwd=tests).splitlines()[-1])


def offline() -> tuple[str, ...]:
    """Return what to put before a command so that it has no network, or nothing where that cannot be had."""
    without = ("unshare", "--map-root-user", "--net")
    able = (
        shutil.which("unshare") and subprocess.run([*without, "true"], check=False, capture_output=True).returncode == 0
    )
    return without if able else ()


def run(*command: str, cwd: Path | None = None) -> str:
    """Return what a command prints; end with all of it where it fails."""
    clean = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")}
    done = subprocess.run(
        command, check=False, cwd=cwd, env=clean, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    if done.returncode:
        sys.exit(f"{done.stdout}\nfailed with status {done.returncode}: {' '.join(command)}")
    return done.stdout.strip()


def step(name: str) -> None:
    """Say what goes on."""
    print(f"== {name}", flush=True)


if __name__ == "__main__":
    main()
