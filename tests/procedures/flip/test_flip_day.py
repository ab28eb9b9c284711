"""A day of three axes at 250 samples/s through ``flip``: how long it takes, and how much memory."""

from __future__ import annotations

import json
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.physics.attitude import from_roll_pitch_yaw
from pad_pairs_made import START, header, pair, stamp, systems

RATE = 250
DAY = 86_400 * RATE
GIBIBYTE = 2**30
PROGRAM = 250 * 2**20  # what the interpreter and its libraries take, and a little
BLOCK = 10**6  # records
TURN = 5.0  # [s]
BIAS, AMBIENT = (980.0, -1254.0, -1265.0), (3.0, -5.3, 4.6)  # ug, along the axes of the sensor
ANGLES = (0.0, 30.0, -90.0)  # roll, pitch and yaw of the sensor [deg]
SENSOR = systems(ANGLES, ANGLES)
TURNED = systems(ANGLES)


def samples(first: int, n: int, turns: tuple[float, float], seed: int, more: str = SENSOR) -> NDArray[np.float32]:
    """Return records of time [s] and three axes [g] of a head that is turned about x of the sensor, and back."""
    t = (first + np.arange(n)) / RATE
    table = np.random.default_rng(seed).standard_normal((n, 4), dtype=np.float32) * np.float32(30e-6)
    table[:, 0] = t
    reverse = (t >= turns[0]) & (t < turns[1])
    for i in range(3):
        table[:, 1 + i] += 1e-6 * (BIAS[i] + AMBIENT[i] * np.where(reverse & (i > 0), -1.0, 1.0))
        for at in turns:
            turning = (t >= at) & (t < at + TURN)
            table[turning, 1 + i] += 3e-3 * np.sin(2.0 * np.pi * (t[turning] - at) / TURN)
    if more == TURNED:  # in axes of the station
        to_station = from_roll_pitch_yaw(*np.radians(ANGLES)).astype(np.float32)
        table[:, 1:] = table[:, 1:] @ to_station.T
    return table


def record(folder: Path, n: int, more: str = TURNED) -> Path:
    """Write a pair of the archive with n records, piece by piece; it is turned in the middle."""
    middle = n / RATE / 2.0
    turns = (middle, middle + min(600.0, 0.25 * middle))
    path = pair(
        folder, samples(0, 1, turns, 1, more), stop=stamp(START, (n - 1) / RATE), text=header(rate="250.00", more=more)
    )
    with path.open("wb") as stream:
        for seed, first in enumerate(range(0, n, BLOCK)):
            stream.write(samples(first, min(BLOCK, n - first), turns, seed, more).tobytes())
    return path


def peak(path: Path) -> int:
    """Return the most memory that the flip takes [bytes], its libraries loaded before."""
    ic.flip(path)
    tracemalloc.start()
    try:
        ic.flip(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("more", [SENSOR, TURNED])
def test_a_day_takes_less_than_a_gibibyte_by_what_shorter_records_take(tmp_path: Path, more: str) -> None:
    n = 300_000
    for length in (n, 2 * n):
        (tmp_path / str(length)).mkdir()
    once, twice = (peak(record(tmp_path / str(length), length, more)) for length in (n, 2 * n))
    assert twice + (twice - once) / n * (DAY - 2 * n) < GIBIBYTE - PROGRAM


def test_what_is_read_is_kept_as_wide_as_it_was(tmp_path: Path) -> None:
    found = ic.flip(record(tmp_path, 150_000, SENSOR))
    rows = {(row.quantity, row.axis): row for row in found.rows if str(row.case) == ""}
    for i, axis in ((1, "y"), (2, "z")):
        for quantity, true in (("ambient_acceleration", AMBIENT[i]), ("bias", BIAS[i])):
            row = rows[quantity, axis]
            assert row.value is not None
            assert row.u is not None
            assert abs(row.value - true) < 4.0 * row.u + 1e-4  # ug; a float of 32 bits is known to 1e-4 ug here


LAUNCH = """
import json, resource, subprocess, sys
command = [sys.executable, "-m", "inertialcal.cli", "flip", sys.argv[1], "--quiet"]
code = subprocess.run(command, stdout=subprocess.DEVNULL).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({"code": code, "seconds": used.ru_utime + used.ru_stime, "most": used.ru_maxrss * 1024}))
"""  # a small parent: a process starts with the most memory that its parent ever had, and reports no less


def ran(path: Path) -> tuple[float, int]:
    """Run the command on a file; return what it took: processor time [s], and most memory [bytes]."""
    done = subprocess.run([sys.executable, "-c", LAUNCH, str(path)], capture_output=True, text=True, check=True)
    used = json.loads(done.stdout)
    assert used["code"] == 0
    return used["seconds"], used["most"]


@pytest.mark.slow
def test_a_day_in_a_process_of_its_own_takes_less_than_a_gibibyte(tmp_path: Path) -> None:
    _, most = ran(record(tmp_path, DAY))
    assert most < GIBIBYTE
    found = ic.flip(tmp_path)
    assert [one.what for one in found.remarks if one.code == "turns_found"]
    assert "short_record" not in {one.code for one in found.remarks}


@pytest.mark.bench
def test_a_day_takes_less_than_ten_seconds(tmp_path: Path) -> None:
    path = record(tmp_path, DAY)
    ran(path)  # loops compiled, files in memory
    seconds, most = min(ran(path) for _ in range(3))
    print(f"\n{seconds:.1f} s of processor time, {most / 2**20:.0f} MiB")
    assert seconds < 10.0
