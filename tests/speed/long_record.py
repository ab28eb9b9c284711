"""A record longer than memory through the commands that a user gives: ``make long``, ``ROWS=1e9``.

    python tests/speed/long_record.py [ROWS] [--folder build]

One axis in a Parquet file, made and written in pieces: white noise, and a random walk of the rate that shows in a
record of that length. ``info``, ``psd``, ``convert`` and ``allan`` go through it, beside a plain reading of the file
by Arrow. Ends with 1 where one takes more than 1 GiB or fails, or where an interval of a noise term does not hold the
truth.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

RATE = 200.0  # Hz
WHITE = 2e-3  # deg/s/sqrt(Hz): one-sided density
PIECE = 2**20
MOST = 2**30  # bytes


def made(path: Path, rows: int) -> dict[str, float]:
    """Write the record; return its true terms [deg/sqrt(h), deg/h/sqrt(h)]."""
    density = WHITE / np.sqrt(2.0)
    walk = density * 300.0 / (rows / RATE)  # as large as white noise at a 170th of the record
    rng = np.random.default_rng(1)
    last = 0.0
    with pq.ParquetWriter(path, pa.schema([("gyro_x [deg/s]", pa.float64())]), compression="none") as file:
        for first in range(0, rows, PIECE):
            n = min(PIECE, rows - first)
            steps = last + np.cumsum(rng.normal(0.0, walk / np.sqrt(RATE), n))
            last = steps[-1]
            column = steps + rng.normal(0.0, density * np.sqrt(RATE), n)
            file.write_table(pa.table({"gyro_x [deg/s]": column}))
    return {"angle_random_walk": 60.0 * density, "rate_random_walk": 3600.0 * 60.0 * walk}


@dataclass(frozen=True)
class Taken:
    """What a command took."""

    status: int
    seconds: float
    most: int  # bytes of resident memory

    @property
    def failed(self) -> bool:
        """Whether it was refused, or took more than it may."""
        return self.status not in (0, 1) or self.most > MOST


def run(words: list[str], folder: Path) -> Taken:
    """Run Python with some words in a process of its own."""
    start = time.monotonic()
    with subprocess.Popen([sys.executable, *words], env=os.environ | {"TMPDIR": str(folder)}) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return Taken(process.returncode, time.monotonic() - start, 1024 * used.ru_maxrss)


READING = "import sys, pyarrow.parquet as pq; [*map(len, pq.ParquetFile(sys.argv[1]).iter_batches())]"


def main() -> int:
    """Print time, memory, and each term beside its truth."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("rows", nargs="?", type=float, default=1e8)
    words.add_argument("--folder", type=Path, default=Path("build"))
    given = words.parse_args()
    rows = int(given.rows)
    given.folder.mkdir(parents=True, exist_ok=True)
    path, out = given.folder / f"long_{rows}.parquet", given.folder / f"long_{rows}"
    copy = given.folder / f"long_{rows}_copy.parquet"
    try:
        truth = made(path, rows)
        size = path.stat().st_size
        rated = [str(path), "--sample-rate", f"{RATE:g}"]
        taken = {"plain reading": run(["-c", READING, str(path)], given.folder)}
        commands = {"info": rated, "psd": rated, "convert": [str(path), str(copy)], "allan": [*rated, "-o", str(out)]}
        for word, more in commands.items():
            taken[word] = run(["-m", "inertialcal", word, *more], given.folder)
            copy.unlink(missing_ok=True)
    finally:
        path.unlink(missing_ok=True)
        copy.unlink(missing_ok=True)
    print(f"{rows:.3g} samples, {size / 2**30:.2f} GiB")
    for word, one in taken.items():
        print(f"  {word}: {one.seconds:.0f} s, peak {one.most / 2**20:.0f} MiB")
    wrong = any(one.failed for one in taken.values())
    found = {one["quantity"]: one for one in json.loads((out / "terms.json").read_text(encoding="utf-8"))["results"]}
    for quantity, true in truth.items():
        one = found[quantity]
        low, high = one["interval"]["lo"], one["interval"]["hi"]
        wrong |= not low <= true <= high
        print(f"  {quantity}: {one['value']:.6g} ({low:.6g} to {high:.6g}) {one['unit']}, truth {true:.6g}")
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
