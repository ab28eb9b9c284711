"""The recording: what was acknowledged survives kills, lost power and says where a bit was flipped."""

from __future__ import annotations

import io
import json
import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from lab_replays import LAYOUT, START, killed, lot, power_lost

from inertialcal.core.errors import DataError
from inertialcal.files import read
from inertialcal.files.loggers.bags import bag_of
from inertialcal.files.loggers.rows import reads
from inertialcal.files.source import load
from inertialcal.lab.acquisition.recorder import File, Recorder


class Memory:
    """A disk in memory."""

    def __init__(self) -> None:
        self.data = io.BytesIO()

    def write(self, data: bytes) -> None:
        self.data.write(data)

    def sync(self) -> None:
        pass

    def close(self) -> None:
        pass


def recorded(chunks: int = 10, finish: bool = True) -> bytes:
    disk = Memory()
    recorder = Recorder(disk, {"imu": LAYOUT}, {"LAB.toml": "schema = 1"})
    for i in range(chunks):
        for j in range(5):
            recorder.add("imu", lot(100 * i + 20 * j, 20))
        recorder.commit()
    if finish:
        recorder.finish()
    return disk.data.getvalue()


def test_it_reads_back_as_it_was_and_by_the_formats_own_library(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    path = tmp_path / "a.mcap"
    path.write_bytes(recorded())
    found = read(path)
    assert len(found) == 1000
    np.testing.assert_array_equal(found.channel("counter").data, np.arange(1000))
    np.testing.assert_array_equal(found.channel("c2").data, 0.5 * ((5 * np.arange(1000)) % 100_003))
    assert found.channel("c2").unit == "deg/s"
    assert found.channel("counter").data.dtype == np.uint32
    assert found.epoch == "utc"
    assert found.time_ns is not None
    np.testing.assert_array_equal(np.diff(found.time_ns[20:]), 1_000_000)
    with path.open("rb") as stream:
        messages = [*reader.NonSeekingReader(stream, validate_crcs=True).iter_messages()]
    rows = np.frombuffer(b"".join(one.data for _, _, one in messages), LAYOUT.dtype)
    np.testing.assert_array_equal(rows["counter"], np.arange(1000))
    schema = messages[0][0]
    assert schema is not None
    assert json.loads(schema.data)["channels"][1]["unit"] == "deg/s"


def test_rows_that_came_together_are_spread_over_the_time_between(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(recorded(3))
    stamps = read(path).time_ns
    assert stamps is not None
    assert np.all(np.diff(stamps) > 0)
    assert stamps[19] == START  # the last of the first lot: when it came


def test_an_unfinished_file_is_read_to_its_last_whole_chunk(tmp_path: Path) -> None:
    path, whole = tmp_path / "a.mcap", recorded(finish=False)
    ends = [len(recorded(i, finish=False)) for i in range(1, 11)]
    for cut in (*ends, *(end - 1 for end in ends[1:]), *(end + 7 for end in ends[:-1])):
        path.write_bytes(whole[:cut])
        found = read(path)
        assert len(found) == 100 * sum(end <= cut for end in ends)
        np.testing.assert_array_equal(found.channel("counter").data, np.arange(len(found)))
        assert "torn_file" in {one.code for one in found.remarks}


def outcome(path: Path, data: bytes) -> tuple[bool, bool]:
    """Return whether something was found wrong, and whether what was read is right as far as it goes."""
    path.write_bytes(data)
    try:
        found = read(path)
    except DataError:
        return True, True
    codes = {one.code for one in found.remarks} & {"torn_file", "wrong_checksum", "messages_missing", "damaged_records"}
    counter = found.channel("counter").data
    right = all(
        np.array_equal(found.channel(f"c{i}").data, 0.5 * ((counter.astype(np.int64) * (i + 3)) % 100_003))
        for i in range(12)
    )
    return bool(codes), right and np.array_equal(counter, np.arange(len(counter)))


def flips(data: bytes, count: int, seed: int) -> Sequence[bytes]:
    rng = random.Random(seed)
    found = []
    for _ in range(count):
        bad = bytearray(data)
        bad[rng.randrange(len(bad))] ^= 1 << rng.randrange(8)
        found.append(bytes(bad))
    return found


def test_forty_flipped_bits_are_found(tmp_path: Path) -> None:
    found = [outcome(tmp_path / "a.mcap", one) for one in flips(recorded(), 40, 1)]
    assert [wrong for wrong, _ in found] == [True] * 40


def test_each_bit_of_the_frame_is_found_too(tmp_path: Path) -> None:
    """All bytes around the rows: beginning, heads of chunks and messages, the end."""
    data = recorded(3)
    edges = {*range(150), *range(len(data) - 60, len(data))}
    ends = [len(recorded(i, finish=False)) for i in range(1, 3)]
    edges |= {end + i for end in ends for i in range(80)}
    missed = []
    for at in sorted(edges):
        bad = bytearray(data)
        bad[at] ^= 1 << (at % 8)
        wrong, _ = outcome(tmp_path / "a.mcap", bytes(bad))
        if not wrong:
            missed.append(at)
    assert missed == []


def test_no_flipped_bit_of_an_unfinished_file_gives_a_wrong_number(tmp_path: Path) -> None:
    found = [outcome(tmp_path / "a.mcap", one) for one in flips(recorded(finish=False), 60, 2)]
    assert all(right for _, right in found)


def test_a_chunk_that_is_missing_inside_is_said(tmp_path: Path) -> None:
    path, ends = tmp_path / "a.mcap", [len(recorded(i, finish=False)) for i in range(1, 6)]
    data = recorded(5, finish=False)
    path.write_bytes(data[: ends[1]] + data[ends[2] :])
    codes = {one.code: one.count for one in read(path).remarks}
    assert codes["messages_missing"] == 5


def test_what_was_acknowledged_survives_twenty_kills(tmp_path: Path) -> None:
    assert killed(tmp_path, range(1, 21)) == []


def test_what_was_acknowledged_survives_lost_power(tmp_path: Path) -> None:
    assert power_lost(tmp_path, range(1, 51)) == []


def test_a_file_is_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"mine")
    with pytest.raises(FileExistsError):
        File(path)
    assert path.read_bytes() == b"mine"


def test_reads_say_when_each_lot_came(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(recorded(2))
    bag = bag_of(load(path))
    found = [*reads(bag, "imu", LAYOUT)]
    assert sum(len(one.rows) for one in found) == 200
    assert found[0].last.tolist() == [19, 39, 59, 79, 99]
    assert found[0].monotonic_ns.tolist() == [0, 20_000_000, 40_000_000, 60_000_000, 80_000_000]
