"""What is looked for in the samples while they come: faults that were put in are in the record, watched or not."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from lab_devices import lab_folder
from shown_lab import TEXT, Signals

from inertialcal.files.loggers.rows import Read, RowChannel, RowLayout
from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.acquisition.live import Track
from inertialcal.lab.acquisition.screening import WINDOW, Watch
from inertialcal.lab.acquisition.seal import seal
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.protocol import Batch

RATE = 1000
LAYOUT = RowLayout((
    RowChannel("x", "float64", "deg/s", axis="x"), RowChannel("y", "float64", "deg/s", axis="y"),
    RowChannel("set_point", "float64", "deg/s"),
))  # fmt: skip


class Steps(Clock):
    """A clock that is set."""

    at = 0.0

    def seconds(self) -> float:
        return self.at


def watched(
    values: np.ndarray[tuple[int, int], np.dtype[np.float64]], lot: int, looks: int = 1
) -> list[tuple[str, ...]]:
    """Return code, channel and count of what is said last of each, when samples come in lots."""
    clock, track = Steps(), Track(LAYOUT)
    watch, found = Watch("imu", track, clock), dict[tuple[str, str], int]()
    for k, first in enumerate(range(0, len(values), lot)):
        rows = np.zeros(len(values[first : first + lot]), LAYOUT.dtype)
        for i, one in enumerate(LAYOUT.channels):
            rows[one.name] = values[first : first + lot, i]
        clock.at = (first + len(rows)) / RATE
        at = np.array([round(1e9 * clock.at)])
        track.add(Read(rows, np.array([len(rows) - 1]), at, at))
        if k % looks == 0:
            found |= {(one.code, one.subject): one.count for one in watch.look()}
    found |= {(one.code, one.subject): one.count for one in watch.look(last=True)}
    return sorted((*key, str(count)) for key, count in found.items())


def noise(count: int, seed: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.random.default_rng(seed).normal(size=(count, 3))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("lot", "looks"), [(20, 100), (777, 1), (30_000, 1)])
def test_what_is_stuck_is_found_once_and_counted_whole(seed: int, lot: int, looks: int) -> None:
    """Wherever it lies: in the middle, across the ends of windows, at the end; a set point may stand still."""
    values = noise(100_000, seed)
    first, length = int(np.random.default_rng(seed).integers(1000, 60_000)), 15_000
    values[first : first + length, 1] = 0.25
    values[:, 2] = 10.0
    ((code, channel, count),) = watched(values, lot, looks)
    assert (code, channel) == ("stuck", "y")
    assert abs(int(count) - length) <= 20


def test_a_rail_and_a_channel_that_sends_zeros_are_found() -> None:
    values = noise(3 * WINDOW, 1)
    values[:, 0] = np.minimum(values[:, 0], 1.5)
    values[:, 1] = 0.0
    found = {(code, channel): int(count) for code, channel, count in watched(values, 500)}
    assert set(found) == {("saturated", "x"), ("stuck", "y")}
    assert found["stuck", "y"] == len(values)
    assert found["saturated", "x"] == pytest.approx(np.sum(values[:, 0] == 1.5), rel=0.01)


def test_a_good_record_has_no_finding() -> None:
    assert [watched(noise(100_000, seed), 500) for seed in range(10)] == [[]] * 10


def test_no_sample_that_came_is_left_out_and_what_came_too_fast_is_said() -> None:
    values = noise(400_000, 1)
    values[:, 2] = 0.0
    found = watched(values, 200_000)
    assert [code for code, *_ in found] == ["not_screened"]
    assert int(found[0][2]) == 400_000 - 2 * 2**16  # but for what is held


def test_silence_is_said_once_each_time() -> None:
    clock, track = Steps(), Track(LAYOUT)
    watch = Watch("imu", track, clock)

    def come() -> None:
        rows = np.zeros(100, LAYOUT.dtype)
        rows["x"] = np.random.default_rng(round(clock.at)).normal(size=100)
        at = np.array([round(1e9 * clock.at)])
        track.add(Read(rows, np.array([99]), at, at))

    said = []
    for second in range(60):
        clock.at = float(second)
        if not 10 <= second < 30 and not 40 <= second < 50:
            come()
        said += [(second, one.code) for one in watch.look() if one.code == "silent"]
    assert [code for _, code in said] == ["silent", "silent"]
    assert 14 <= said[0][0] <= 16
    assert 44 <= said[1][0] <= 46


class Faulty(Signals):
    """`Signals` that end after 3 s: a channel is stuck, one at its rail."""

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        begin = self.clock.seconds()
        for batch in super().stream(stop):
            yield batch
            if self.clock.seconds() > begin + 3.0:
                return


def test_it_is_in_the_record_though_nobody_watches(tmp_path: Path) -> None:
    clock = Clock()
    made = Acquisition(
        load_lab(lab_folder(tmp_path, TEXT.format(title="no page"))), tmp_path / "out", clock, [Faulty(clock)]
    )
    made.start()
    assert made.wait(60.0)
    seal(tmp_path / "out")
    remarks = json.loads((tmp_path / "out" / "acquisition.json").read_text())["remarks"]
    found = {one["code"]: one for one in remarks}
    assert set(found) == {"stuck", "saturated"}
    assert found["stuck"]["count"] > 2500
    assert found["stuck"]["what"].startswith("gyro_y: samples are stuck at 4.25 deg/s, 0.")
    assert found["saturated"]["what"].startswith("gyro_z: samples lie at the end of the range at 2.4 deg/s")
