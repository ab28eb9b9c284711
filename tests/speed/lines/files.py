"""Files that are read whole, as a user waits for them, against the reader of the format alone.

No reader of tables judges time, gaps and missing values, or hashes the file, as ``ic.read`` does on the way. A goal of
0.77 is 1.3 times its time. A thread hashes after the reading: lines that end with "hashed" wait for it. Files are
written as other programs write them: a logger's ``printf``, pandas' Parquet. Memory is that of a process of its own,
beyond what it takes once a short file was read.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from pyarrow import parquet

import inertialcal as ic
from inertialcal.core.recording import Digest

from ..comparison import Work, line

NAMES = ["time [s]", *(f"acc_{axis} [m/s^2]" for axis in "xyz"), *(f"gyro_{axis} [rad/s]" for axis in "xyz")]
FORMATS = ["%.6f"] * 4 + ["%.9f"] * 3
BLOCK = 50_000  # rows that are written at once
GOAL = 1.0 / 1.3
HELD = 2.5  # bytes of memory for each byte of the file
PEAK = """
import sys
import inertialcal as ic

def peak():
    with open("/proc/self/status") as about:
        return next(int(one.split()[1]) for one in about if one.startswith("VmHWM"))

ic.read(sys.argv[1])
before = peak()
ic.read(sys.argv[2])
print((peak() - before) / 1024)
"""


def written(path: Path, rows: int) -> Path:
    """Write six axes at 200 Hz as CSV."""
    rng = np.random.default_rng(1)
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join(NAMES) + "\n")
        for first in range(0, rows, BLOCK):
            at = np.arange(first, min(first + BLOCK, rows)) / 200.0
            force = rng.normal((0.1, 0.2, 9.81), 0.02, (len(at), 3))
            table = np.column_stack([at, force, rng.normal(1e-3, 2e-3, (len(at), 3))])
            file.write((",".join(FORMATS) + "\n") * len(at) % tuple(table.ravel().tolist()))
    return path


@dataclass(frozen=True)
class Kept:
    """A call, and the folder of its files, which goes with it."""

    folder: TemporaryDirectory[str]
    call: Callable[[], Any]

    def __call__(self) -> Any:
        """Return what the call does."""
        return self.call()


def csv(rows: int) -> Work:
    folder = TemporaryDirectory()
    path = written(Path(folder.name) / "a.csv", rows)
    found, table = ic.read(path), pd.read_csv(path, engine="pyarrow")
    for name in NAMES[1:]:
        np.testing.assert_array_equal(found.channel(name).data, table[name])
    return compared(folder, path, partial(pd.read_csv, path, engine="pyarrow"))


def compared(folder: TemporaryDirectory[str], path: Path, peer: Callable[[], Any], hashed: bool = False) -> Work:
    """Return the reading of a file beside that of its peer."""

    def read() -> Any:
        found = ic.read(path)
        return found.source.sha256 if hashed else found

    return Work(Kept(folder, read), peer, path.stat().st_size, rest=Digest.finish)


def noise(path: Path, rows: int) -> None:
    """Write six axes of doubles whose digits are noise, as a simulation gives them: nothing of them can be packed."""
    rng = np.random.default_rng(1)
    at = np.arange(rows) / 200.0
    pd.DataFrame(dict(zip(NAMES, [at, *rng.normal(size=(6, rows))], strict=True))).to_parquet(path, index=False)


def of_parquet(rows: int, packed: bool = True, hashed: bool = False) -> Work:
    folder = TemporaryDirectory()
    path = Path(folder.name) / "a.parquet"
    if packed:
        pd.read_csv(written(path.with_suffix(".csv"), rows)).to_parquet(path, index=False)
    else:
        noise(path, rows)

    def peer() -> list[np.ndarray[tuple[int], np.dtype[np.float64]]]:
        return [one.to_numpy() for one in parquet.read_table(path).columns]

    found = ic.read(path)
    for name, values in zip(NAMES[1:], peer()[1:], strict=True):
        np.testing.assert_array_equal(found.channel(name).data, values)
    return compared(folder, path, peer, hashed)


def memory(rows: int) -> Work:
    folder = TemporaryDirectory()
    short, path = (written(Path(folder.name) / f"{n}.csv", n) for n in (BLOCK, rows))

    def peak() -> float:
        command = [sys.executable, "-c", PEAK, str(short), str(path)]
        return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    return Work(Kept(folder, peak), HELD * path.stat().st_size / 2**20, unit="MiB")


for samples, size in ((60, "4 kB"), (66_000, "5 MB"), (400_000, "30 MB"), (1_550_000, "117 MB")):
    goal = GOAL if samples > BLOCK else 0.0
    line(f"read csv, {size}", peer="pandas.read_csv, pyarrow", goal=goal)(partial(csv, samples))
    line(f"read parquet, {samples:.1e} rows", peer="pyarrow.parquet.read_table", goal=goal)(
        partial(of_parquet, samples)
    )
for samples in (66_000, 1_550_000):
    for more, hashed, goal in (("", False, GOAL), (", hashed", True, 0.0)):
        title = f"read parquet of noise, {samples:.1e} rows{more}"
        line(title, peer="pyarrow.parquet.read_table", goal=goal)(partial(of_parquet, samples, False, hashed))
line("read csv, 117 MB, memory", peer=f"{HELD} times the file", goal=1.0)(partial(memory, 1_550_000))
