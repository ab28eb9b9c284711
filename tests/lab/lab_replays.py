"""Kills and lost power of a recording, over and over: what was acknowledged must be there, and nothing wrong.

``python tests/lab/lab_replays.py 1000`` replays both 1,000 times; ``--resume`` goes on where an earlier run was ended.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from inertialcal.core.errors import DataError
from inertialcal.files import read
from inertialcal.files.loggers.rows import RowChannel, RowLayout
from inertialcal.lab.acquisition.recorder import File, Recorder
from inertialcal.lab.clock import Instant
from inertialcal.lab.instruments.protocol import Batch

LAYOUT = RowLayout(
    (RowChannel("counter", "uint32", role="counter"), *(RowChannel(f"c{i}", "int32", "deg/s", 0.5) for i in range(12)))
)
START = 1_700_000_000_000_000_000
PAGE = 4096  # bytes that a disk writes at once
LONGEST = 0.05  # [s] until a kill
AT_ONCE = 20  # kills of which one process is the parent


def lot(first: int, count: int, layout: RowLayout = LAYOUT) -> Batch:
    """Return rows whose numbers follow from their count."""
    rows = np.zeros(count, layout.dtype)
    rows["counter"] = np.arange(first, first + count)
    for i in range(12):
        rows[f"c{i}"] = (rows["counter"].astype(np.int64) * (i + 3)) % 100_003
    return Batch(rows, Instant(first * 1_000_000, START + first * 1_000_000))


def write_for_ever(path: Path) -> None:
    """Record, and print how many rows were acknowledged after each writing: the process that is killed."""
    rng = random.Random(str(path))
    recorder = Recorder(File(path), {"imu": LAYOUT}, {"LAB.toml": "schema = 1"})
    first = 0
    while True:
        for _ in range(rng.randrange(1, 6)):
            count = rng.randrange(1, 400)
            recorder.add("imu", lot(first, count))
            first += count
        done = recorder.commit()["imu"]
        os.write(1, f"{done}\n".encode())


def wrong_in(path: Path, acknowledged: int) -> str:
    """Return what is wrong with a recording of `lot` that was cut off; empty where nothing is."""
    try:
        found = read(path)
    except DataError as error:
        return f"refused, {acknowledged} acknowledged: {error}" if acknowledged else ""
    counter = found.channel("counter").data.astype(np.int64)
    if len(counter) < acknowledged:
        return f"{len(counter)} rows, {acknowledged} acknowledged"
    if not np.array_equal(counter, np.arange(len(counter))):
        return "the counter does not go up by one"
    for i in range(12):
        if not np.array_equal(found.channel(f"c{i}").data, 0.5 * ((counter * (i + 3)) % 100_003)):
            return f"c{i} is wrong"
    return ""


def killed(folder: Path, seeds: Iterable[int]) -> list[str]:
    """Return what is wrong after a kill -9 for each seed, at a time that follows from it."""
    found = []
    for seed in seeds:
        path = folder / f"killed_{seed}.mcap"
        read_end, write_end = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                os.dup2(write_end, 1)
                write_for_ever(path)
            finally:
                os._exit(1)
        os.close(write_end)
        os.read(read_end, 1)  # the first acknowledgement
        heard = b"".join(_heard(read_end, random.Random(seed).uniform(0.0, LONGEST)))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        with os.fdopen(read_end, "rb") as rest:
            heard += rest.read()
        lines = [line for line in heard.split(b"\n")[1:] if line]
        whole = lines if heard.endswith(b"\n") else lines[:-1]
        wrong = wrong_in(path, int(whole[-1]) if whole else 0)
        found += [f"seed {seed}: {wrong}"] if wrong else []
        path.unlink()
    return found


def _heard(descriptor: int, seconds: float) -> Iterable[bytes]:
    import select
    import time

    until = time.monotonic() + seconds
    while (left := until - time.monotonic()) > 0:
        if select.select([descriptor], [], [], left)[0]:
            yield os.read(descriptor, 65536)


@dataclass
class PowerDisk:
    """A disk that remembers what was written, and what of it was brought down."""

    data: bytearray = field(default_factory=bytearray)
    synced: list[tuple[int, int]] = field(default_factory=list)  # bytes, rows acknowledged by then
    writes: list[int] = field(default_factory=list)  # ends

    def write(self, data: bytes) -> None:
        """Write."""
        self.data += data
        self.writes.append(len(self.data))

    def sync(self) -> None:
        """Bring down."""
        self.synced.append((len(self.data), 0))

    def close(self) -> None:
        """Close."""


def power_lost(folder: Path, seeds: Iterable[int]) -> list[str]:
    """Return what is wrong after lost power, for each seed.

    What was synced is there; of the pages behind it some are there, some are torn, some hold zeros, some never came.
    """
    found = []
    path = folder / "lost.mcap"
    for seed in seeds:
        rng = random.Random(seed)
        disk = PowerDisk()
        recorder, first, acknowledged = Recorder(disk, {"imu": LAYOUT}, {"LAB.toml": "schema = 1"}), 0, []
        for _ in range(rng.randrange(2, 12)):
            for _ in range(rng.randrange(1, 4)):
                count = rng.randrange(1, 300)
                recorder.add("imu", lot(first, count))
                first += count
            recorder.commit()
            acknowledged.append((len(disk.data), first))
        if rng.random() < 0.2:
            recorder.finish()
        at = rng.randrange(len(acknowledged))  # the power is lost while what follows this one is written
        safe, rows = acknowledged[at]
        rest = bytes(disk.data[safe : acknowledged[min(at + rng.randrange(1, 3), len(acknowledged) - 1)][0]])
        path.write_bytes(bytes(disk.data[:safe]) + _of_a_lost_tail(rest, safe, rng))
        wrong = wrong_in(path, rows)
        found += [f"seed {seed}: {wrong}"] if wrong else []
    return found


def _of_a_lost_tail(rest: bytes, begin: int, rng: random.Random) -> bytes:
    """Return what may be left of bytes that were not brought down: page by page."""
    edges = [0, *range(PAGE - begin % PAGE, len(rest), PAGE), len(rest)]
    pages = [rest[a:b] for a, b in pairwise(edges)]
    kept = rng.randrange(len(pages) + 1) if pages else 0  # the file's length was brought down to there
    found = []
    for page in pages[:kept]:
        fate = rng.random()
        torn = rng.randrange(len(page) + 1)
        found.append(page if fate < 0.4 else bytes(len(page)) if fate < 0.7 else page[:torn] + bytes(len(page) - torn))
    tail = b"".join(found)
    return tail[: rng.randrange(len(tail) + 1)] if tail and rng.random() < 0.5 else tail


def main(count: int, resume: bool) -> int:
    """Replay both so many times, in slices; return an exit status."""
    kept = Path("build/lab_replays.json")
    kept.parent.mkdir(exist_ok=True)
    following, wrong = 1, list[str]()
    if resume and kept.exists():
        said = json.loads(kept.read_text())
        following, wrong = int(said["next"]), [str(one) for one in said["wrong"]]
    with tempfile.TemporaryDirectory() as folder:
        while following <= count:
            seeds = range(following, min(following + AT_ONCE, count + 1))
            wrong += [*killed(Path(folder), seeds), *power_lost(Path(folder), seeds)]
            following = seeds.stop
            kept.write_text(json.dumps({"next": following, "wrong": wrong}))
            if (following - 1) % 100 == 0:
                print(f"{following - 1} of {count}: {len(wrong)} wrong", flush=True)
    for line in wrong:
        print(line)
    print(f"{count} kills and {count} losses of power: {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdecimal()]
    sys.exit(main(numbers[0] if numbers else 1000, "--resume" in sys.argv))
