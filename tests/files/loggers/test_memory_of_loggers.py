"""A longer log takes no more memory: its numbers go to the disk as they are read.

Formats whose library, or layout, asks for more than a block of the file at a time are named on docs/formats.md.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Sequence
from pathlib import Path

import logger_files
import numpy as np
import pytest

from inertialcal.core import batches
from inertialcal.files.columns import Content
from inertialcal.files.loggers import bags, dataflash, json_lines, tdms, wav
from inertialcal.files.source import Loaded, load

pytestmark = pytest.mark.slow
SHORT, LONG = 2_000, 6_000  # rows
BYTES = 8  # of a number
SHARE = 0.25  # of the numbers of the rows that came on top, by which the peak may grow
Reading = Callable[[Loaded, Sequence[str] | None], Content]
BOUNDED: dict[str, tuple[Reading, str, int]] = {  # -> reader, topic, columns of numbers
    "plain.bag": (bags.read_bag, "", 6),
    "ros2.db3": (bags.read_bag, "", 6),
    "zstd.mcap": (bags.read_bag, "", 6),
    "ardu.bin": (dataflash.read_binary, "IMU[1]", 6),
    "segments.tdms": (tdms.read_tdms, "", 3),
    "sound.wav": (wav.read_wav, "", 3),
    "lines.jsonl": (json_lines.read_json_lines, "imu", 8),
}


def segments(path: Path) -> None:
    """Write a TDMS file as a logger leaves it that flushes each five seconds."""
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as writer:
        for first in range(0, len(logger_files.GYRO), 1000):
            part = logger_files.GYRO[first : first + 1000]
            writer.write_segment([ChannelObject("IMU", f"gyro_{axis}", part[:, i], {"wf_increment": 0.005})
                                  for i, axis in enumerate("xyz")])  # fmt: skip


OWN: dict[str, Callable[[Path], object]] = {
    "plain.bag": lambda path: logger_files.ros_1(path, chunk=20_000),
    "zstd.mcap": lambda path: logger_files.mcap(path, stop=len(logger_files.GYRO)),
    "segments.tdms": segments,
    "lines.jsonl": lambda path: logger_files.json_lines(path, words=False),
}


def peak(path: Path, reader: Reading, topic: str) -> tuple[int, Content]:
    """Return the most bytes that reading a file holds at once, arrays in temporary files apart."""
    loaded = load(path, in_place=True)
    assert loaded.sha256  # a thread works it out, in a block of its own
    tracemalloc.start()
    try:
        content = reader(loaded, [topic] if topic else None)
        return tracemalloc.get_traced_memory()[1], content
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", BOUNDED)
def test_a_log_of_four_times_the_length_takes_no_more_memory(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module, constant, small in (
        (batches, "HELD", 2**12), (batches, "SIZE", 2**10), (bags, "AT_ONCE", 2**8), (bags, "ROWS", 2**6),
        (dataflash, "BLOCK", 2**14), (wav, "BATCH", 2**12), (tdms, "SIZE", 2**10),
        (json_lines, "PIECE", 2**12), (json_lines, "BATCH", 2**8),
    ):  # fmt: skip
        monkeypatch.setattr(module, constant, small)
    reader, topic, columns = BOUNDED[name]
    rng, found = np.random.default_rng(1), list[tuple[int, Content]]()
    for rows in (SHORT // 4, SHORT, LONG):  # the first loads what is loaded once
        numbers = {"GYRO": rng.normal(size=(rows, 3)), "ACC": rng.normal(size=(rows, 3)),
                   "COUNTS": rng.integers(-30_000, 30_000, size=(rows, 3)), "N": rows,
                   "STAMPS": logger_files.START + logger_files.STEP * np.arange(rows)}  # fmt: skip
        for constant, value in numbers.items():
            monkeypatch.setattr(logger_files, constant, value)
        path = tmp_path / f"{len(found)}" / name
        path.parent.mkdir()
        OWN.get(name, logger_files.WRITERS.get(name, segments))(path)
        found.append(peak(path, reader, topic))
    assert len(found[-1][1]) == LONG
    grown = found[-1][0] - found[1][0]
    assert grown < SHARE * BYTES * columns * (LONG - SHORT)
