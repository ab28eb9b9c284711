"""Columns that run like time and are not used as time."""

from pathlib import Path

import numpy as np
import pytest

from inertialcal.files import read
from inertialcal.files.time.unused import irregularities

N = 3_000
RNG = np.random.default_rng(20)
TIME = 0.05 * np.arange(N)
NOISE = RNG.normal(size=N)


def shifted(by: float) -> np.ndarray:
    return TIME + np.where(np.arange(N) < 1_500, 0.0, by)


def put(index: int, value: float) -> np.ndarray:
    out = TIME.copy()
    out[index] = value
    return out


FINE = {
    "time": TIME,
    "time with jitter": TIME + 0.002 * NOISE,
    "whole milliseconds": np.rint(9.765 * np.arange(N)),
    "an index": np.arange(1, N + 1),
    "a counter of 8 bits": np.arange(N) % 256,
    "a sample in its packet": np.arange(N) % 25,
    "the angle of a turning table": (20.0 * TIME + 0.01 * NOISE) % 360.0,
    "a table that starts and stops": np.cumsum(np.clip(np.minimum(np.arange(N), N - np.arange(N)) / 50.0, 0.0, 1.0)),
    "a table that turns to and fro": np.abs(TIME % 20.0 - 10.0),
    "a temperature": 20.0 + 0.01 * TIME + 0.01 * NOISE,
    "a coarse temperature": np.round(20.0 + 0.01 * TIME, 2),
    "pulses, one glitch": 100.0 * np.arange(N) + 5_000.0 * (np.arange(N) == 77),
    "readings": NOISE,
    "a constant": np.full(N, 3.0),
}
WRONG = {
    "back": (shifted(-2.5), "time_backwards", 1_500, "goes back"),
    "back, with jitter": (shifted(-2.5) + 0.002 * NOISE, "time_backwards", 1_500, "goes back"),
    "again from the start": (np.concatenate((TIME[:2_000], TIME[:1_000])), "time_backwards", 2_000, "second recording"),
    "a gap": (shifted(0.5), "stamps_not_used", 1_500, "jumps ahead"),
    "a repeat": (put(800, TIME[799]), "stamps_not_used", 800, "repeats its value"),
}


@pytest.mark.parametrize("name", FINE)
def test_no_alarm(name: str) -> None:
    assert irregularities(FINE[name]) is None


@pytest.mark.parametrize("name", WRONG)
def test_an_irregular_clock_that_is_not_used_is_named_with_its_row(tmp_path: Path, name: str) -> None:
    column, code, index, words = WRONG[name]
    file = tmp_path / "a.csv"
    np.savetxt(file, np.column_stack((column, NOISE)), "%.6f", ",", header="q1,gyro_x", comments="")
    (remark,) = read(file, sample_rate=20.0).remarks
    assert (remark.code, remark.where) == (code, f"{file}:{index + 2}")
    assert words in remark.what
    assert "--time-column q1" in remark.do
    used = read(file, time_column="q1", units={"q1": "s"}).remarks
    assert not any("not used" in one.what for one in used)
