"""Places that cannot be written: the package, the caches of numba and matplotlib, the folder for temporary files."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import inertialcal

# A file stands where each folder would go, so that nobody, not even root, can make it.
NOWHERE = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "TMPDIR"), "/dev/null")
LOOP = """
import numpy as np
from inertialcal.signals.allan._kernels_missing import mean_of
print(mean_of(np.array([1.0, 2.0, 6.0]), np.array([0, 1, 2], dtype=np.int32), 0, 2), mean_of.stats.cache_hits.values())
"""
TWO = "(2.5, 0.5)"


@pytest.fixture(name="closed")
def _closed(tmp_path: Path) -> Path:
    """A copy of the package in which no folder for compiled code can be made."""
    source = Path(inertialcal.__file__).parent
    shutil.copytree(source, tmp_path / "inertialcal", ignore=shutil.ignore_patterns("__pycache__", "examples"))
    for folder in [path for path in tmp_path.rglob("*") if path.is_dir()]:
        (folder / "__pycache__").touch()
    return tmp_path


def environment(**more: str) -> dict[str, str]:
    """Return the environment without the places that this machine names."""
    kept = {name: value for name, value in os.environ.items() if name not in {"MPLCONFIGDIR", "NUMBA_CACHE_DIR"}}
    return kept | more


def ran(*words: str, source: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run Python with a copy of the package."""
    env = environment(PYTHONPATH=str(source), **more)
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, env=env, timeout=300)


def test_loops_are_compiled_where_no_cache_can_be_written(closed: Path) -> None:
    done = ran("-c", LOOP, source=closed, **NOWHERE)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split(")")[0] + ")" == TWO


@pytest.mark.parametrize(
    ("damage", "kind"),
    [("half", "nbi")]
    + [
        pytest.param(*one, marks=pytest.mark.slow)
        for one in (("nothing", "nbi"), ("garbage", "nbi"), ("half", "nbc"), ("nothing", "nbc"), ("garbage", "nbc"))
    ],
)
def test_a_damaged_cache_is_compiled_again_and_mended(damage: str, kind: str, tmp_path: Path) -> None:
    source, cache = Path(inertialcal.__file__).parents[1], str(tmp_path)
    assert ran("-c", LOOP, source=source, NUMBA_CACHE_DIR=cache).stdout.startswith(TWO)
    (path,) = tmp_path.rglob(f"*mean_of*.{kind}")
    content = path.read_bytes()
    path.write_bytes({"half": content[: len(content) // 2], "nothing": b"", "garbage": b"\x80\x05" + b"?" * 99}[damage])
    done = ran("-c", LOOP, source=source, NUMBA_CACHE_DIR=cache)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(TWO)
    again = ran("-c", LOOP, source=source, NUMBA_CACHE_DIR=cache)
    assert again.stdout.strip().endswith("([1])"), again.stdout  # from the cache


def test_figures_without_a_place_for_their_cache(tmp_path: Path) -> None:
    path = tmp_path / "rest.csv"
    readings = np.random.default_rng(1).normal(scale=0.1, size=(2_000, 1))
    table = np.column_stack([np.arange(2_000) / 100.0, readings])
    np.savetxt(path, table, fmt="%.5f", delimiter=",", header="time [s],gyro_x [deg/s]", comments="")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    places = NOWHERE | {"TMPDIR": str(scratch)}
    words = ["-m", "inertialcal", "psd", str(path), "-o", str(tmp_path / "psd.png"), "--quiet"]
    done = ran(*words, source=Path(inertialcal.__file__).parents[1], **places)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "psd.png").stat().st_size > 1000
    assert list(scratch.iterdir()) == []  # what matplotlib makes for the time of a process


def test_a_figure_without_any_folder_for_temporary_files_is_refused(tmp_path: Path) -> None:
    code = (
        "import sys, tempfile; tempfile._candidate_tempdir_list = lambda: []\n"
        "from inertialcal.cli.__main__ import entry; sys.argv = ['inertialcal', *sys.argv[1:]]; entry()"
    )
    path = tmp_path / "rest.csv"
    path.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{i},0.{i * 7919 % 1000}\n" for i in range(500)))
    words = ["-c", code, "psd", str(path), "-o", str(tmp_path / "psd.png")]
    done = ran(*words, source=Path(inertialcal.__file__).parents[1], **NOWHERE)
    assert done.returncode == 3
    assert done.stderr.startswith("error: no folder for temporary files")


@pytest.mark.parametrize(
    "options",
    [["-OO"], *(pytest.param(one, marks=pytest.mark.slow) for one in (["-W", "error"], ["-O"], ["-P"], ["-X", "dev"]))],
)
def test_options_of_python(options: list[str], tmp_path: Path) -> None:
    path = tmp_path / "rest.csv"
    path.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{i},0.{i * 7919 % 1000}\n" for i in range(500)))
    source = Path(inertialcal.__file__).parents[1]
    for words in (["info", str(path)], ["psd", "--help"] if "-OO" in options else ["psd", str(path)]):
        done = ran(*options, "-m", "inertialcal", *words, source=source)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout == ran("-m", "inertialcal", *words, source=source).stdout
