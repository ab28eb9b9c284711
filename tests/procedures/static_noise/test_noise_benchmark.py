"""Speed of `allan` against reading the same file in the same process. Run by ``make bench``."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv

import inertialcal as ic

ROWS = 10_000_000
ROUNDS = 3
LIMIT = 1.5  # time of the noise alone over that of reading the text


def seconds(action: Callable[[], object]) -> float:
    started = time.perf_counter()
    action()
    return time.perf_counter() - started


@pytest.mark.bench
def test_noise_costs_about_what_reading_the_file_costs(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    rate = np.round(rng.normal(0.0, 0.1, ROWS) + np.cumsum(rng.normal(0.0, 1e-5, ROWS)), 5)
    path = tmp_path / "long.csv"
    csv.write_csv(pa.table({"time [s]": np.arange(ROWS) / 1000.0, "gyro_x [deg/s]": rate}), path)
    recording = ic.read(path)
    ic.allan(recording)  # compiled, and in memory
    reading = median(seconds(lambda: ic.read(path)) for _ in range(ROUNDS))
    noise = median(seconds(lambda: ic.allan(recording)) for _ in range(ROUNDS))
    print(f"\n1e7 samples: read {reading:.2f} s, noise {noise:.2f} s, ratio {noise / reading:.2f}")
    assert noise < LIMIT * reading
