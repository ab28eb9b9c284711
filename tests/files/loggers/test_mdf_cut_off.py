"""MDF 4 laid out as a logger writes it while it runs: descriptions first, one block of data last; cut off anywhere."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.files import apart, read

ROWS, RECORD = 200, 20
CHANNELS = (("time", "s", 0, 64), ("gyro_x", "deg/s", 8, 32), ("gyro_y", "deg/s", 12, 32), ("gyro_z", "deg/s", 16, 32))


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read in this process: starting Python anew for each file takes seconds."""
    monkeypatch.setattr(apart, "is_possible", lambda: False)


def block(name: bytes, links: list[int], data: bytes) -> bytes:
    length = 24 + 8 * len(links) + len(data)
    return struct.pack("<4sIQQ", name, 0, length, len(links)) + struct.pack(f"<{len(links)}Q", *links) + data


def text(words: str) -> bytes:
    content = words.encode() + b"\0"
    return block(b"##TX", [], content + bytes(-len(content) % 8))


def records() -> np.ndarray:
    rng = np.random.default_rng(2)
    kind = [("time", "<f8"), ("gyro_x", "<f4"), ("gyro_y", "<f4"), ("gyro_z", "<f4")]
    made = np.zeros(ROWS, dtype=kind)
    made["time"] = np.arange(ROWS) / 100.0
    for name in ("gyro_x", "gyro_y", "gyro_z"):
        made[name] = rng.standard_normal(ROWS)
    return made


def logger_file(unfinished: bool = False) -> tuple[bytes, int]:
    """Return a file, and the first byte of its records."""
    at, place = {"group": 168, "records": 264 - 40}, 0
    at["records"] = at["group"] + 24 + 4 * 8 + 8
    place = at["records"] + 24 + 6 * 8 + 32
    for name, unit, *_ in CHANNELS:
        at[name], place = place, place + 24 + 8 * 8 + 72
        at[f"{name} called"], place = place, place + len(text(name))
        at[f"{name} unit"], place = place, place + len(text(unit))
    state = b"UnFinMF " if unfinished else b"MDF     "
    made = struct.pack("<8s8s8s4xH30xHH", state, b"4.10    ", b"LOGGER  ", 410, 5 * unfinished, 0)
    made += block(b"##HD", [at["group"], 0, 0, 0, 0, 0], struct.pack("<QhhBBBxdd", 1_710_234_900 * 10**9, *[0] * 7))
    made += block(b"##DG", [0, at["records"], place, 0], bytes(8))
    rows = 0 if unfinished else ROWS
    made += block(b"##CG", [0, at["time"], 0, 0, 0, 0], struct.pack("<QQHHIII", 0, rows, 0, 0, 0, RECORD, 0))
    for k, (name, unit, first, bits) in enumerate(CHANNELS):
        following = at[CHANNELS[k + 1][0]] if k + 1 < len(CHANNELS) else 0
        kind = struct.pack("<BBBBIIII", 2 * (k == 0), k == 0, 4, 0, first, bits, 0, 0) + bytes(52)
        made += block(b"##CN", [following, 0, at[f"{name} called"], 0, 0, 0, at[f"{name} unit"], 0], kind)
        made += text(name) + text(unit)
    assert len(made) == place
    return made + block(b"##DT", [], records().tobytes()), place + 24


@pytest.mark.parametrize("unfinished", [False, True])
@pytest.mark.parametrize("share", [0.0, 0.31, 0.999, 1.0])
def test_records_that_are_whole_are_read(unfinished: bool, share: float, tmp_path: Path) -> None:
    data, first = logger_file(unfinished)
    end = first + round(share * (len(data) - first))
    path = tmp_path / "log.mf4"
    path.write_bytes(data[:end])
    there = (end - first) // RECORD
    if there < 2:
        with pytest.raises(DataError):
            read(path)
        return
    found, true = read(path), records()
    assert len(found) == there
    assert found.names == tuple(name for name, *_ in CHANNELS[1:])
    for name in found.names:
        np.testing.assert_array_equal(found.channel(name).data, true[name][:there])
        assert found.channel(name).unit == "deg/s"
    assert found.sample_interval == pytest.approx(0.01)
    assert [one.code for one in found.remarks].count("torn_file") == (unfinished or there < ROWS)


def test_a_file_without_its_descriptions_says_so(tmp_path: Path) -> None:
    data, _ = logger_file()
    path = tmp_path / "log.mf4"
    path.write_bytes(data[:200])
    with pytest.raises(DataError, match="cut off: what says its channels stood behind byte 200"):
        read(path)
