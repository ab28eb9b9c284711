"""What differs on Windows, in a process that is like one: commands write whole files, with the bytes that they hash."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SOURCE = HERE.parents[2] / "src"
STEPS = (
    "demo npsat2011 --quiet",
    "convert inertialcal-demo/table10_x.csv copy.csv",
    "export inertialcal-demo --to json -o gyro.json --unjudged",
)
LONG = (
    "demo rate_table --quiet",
    "convert inertialcal-demo-rate_table/recordings/x_run1.csv copy.parquet",
    "info copy.parquet",
    "export inertialcal-demo-rate_table --to c -o flight --unjudged",
    "simulate still_gyro -o still --quiet",
    "allan still/recordings/still1.csv -o a.svg",
)


def played(folder: Path, *lines: str) -> dict[str, int]:
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(SOURCE), "OMP_NUM_THREADS": "1", "HOME": str(folder)}
    found = subprocess.run(
        [sys.executable, "-X", "warn_default_encoding", "-W", "error::EncodingWarning:inertialcal",
         str(HERE / "as_windows.py"), *lines],
        cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8", check=False,
    )  # fmt: skip
    ended = [line.split(" ", 2) for line in found.stdout.splitlines() if line.startswith("STATUS ")]
    assert len(ended) == len(lines), found.stderr
    return {line: int(status) for _, status, line in ended}


def test_commands_write_what_they_hash(tmp_path: Path) -> None:
    assert played(tmp_path, *STEPS) == dict.fromkeys(STEPS, 0)
    out = tmp_path / "inertialcal-demo" / "out"
    lines = (out / "SHA256SUMS").read_text("utf-8").splitlines()
    sums = dict(reversed(line.split("  ")) for line in lines if not line.startswith("#"))
    assert set(sums) >= {"results.json", "model.json", "report.html"}
    for name, expected in sums.items():
        assert hashlib.sha256((out / name).read_bytes()).hexdigest() == expected, name
    written = [
        path for path in tmp_path.rglob("*") if path.is_file() and path.suffix in (".csv", ".json", ".c", ".html")
    ]
    assert written
    assert not [path.name for path in written if b"\r\n" in path.read_bytes()]
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.slow
def test_a_simulated_campaign_and_a_record(tmp_path: Path) -> None:
    assert played(tmp_path, *LONG) == dict.fromkeys(LONG, 0)
