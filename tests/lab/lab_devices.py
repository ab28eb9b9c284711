"""Devices, dialects and files that the tests of the lab share."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.device import Device
from inertialcal.lab.instruments.dialect import Dialect, FieldEntry, FrameEntry
from inertialcal.lab.instruments.served import Served

PACKETS = """
title = "12 channels"
[frame]
kind = "packets"
sync = "AA 55"
checksum = "crc32"
[[fields]]
name = "counter"
type = "uint16"
role = "counter"
"""
PACKETS += "".join(
    f'[[fields]]\nname = "{kind}_{axis}"\ntype = "int32"\nscale = {scale}\nunit = "{unit}"\naxis = "{axis}"\n'
    for kind, unit, scale in (
        ("gyro", "deg/s", 1e-3), ("acc", "m/s^2", 1e-4), ("acc2", "m/s^2", 1e-4), ("gyro2", "deg/s", 1e-3)
    )
    for axis in "xyz"
)  # fmt: skip
SAMPLES = 3000


def packet(counter: int, values: np.ndarray[tuple[int], np.dtype[np.int64]]) -> bytes:
    """Return a packet as the device of ``PACKETS`` sends it, by struct alone."""
    body = struct.pack("<H12i", counter % 2**16, *values.tolist())
    return b"\xaa\x55" + body + struct.pack("<I", zlib.crc32(body))


def packets(count: int = SAMPLES, seed: int = 1) -> tuple[list[bytes], np.ndarray[tuple[int, int], np.dtype[np.int64]]]:
    """Return packets, and the numbers in them, shape (count, 12)."""
    values = np.random.default_rng(seed).integers(-(2**31), 2**31, size=(count, 12))
    return [packet(i, row) for i, row in enumerate(values)], values


def line_dialect(**frame: object) -> Dialect:
    """Return a dialect of lines: counter, time, two readings."""
    fields = (
        FieldEntry(name="counter", type="uint32", role="counter"),
        FieldEntry(name="t", type="float64", unit="s", role="time"),
        FieldEntry(name="gyro_x", type="int64", unit="deg/s", scale=0.001, axis="x"),
        FieldEntry(name="temperature", unit="degC"),
    )
    return Dialect(frame=FrameEntry(kind="lines", **frame), fields=fields)  # type: ignore[arg-type]


@contextmanager
def serving(device: Served) -> Iterator[Served]:
    """Start a device, and end it."""
    device.start()
    try:
        yield device
    finally:
        device.close()


def lab_folder(folder: Path, text: str, **files: str) -> Path:
    """Write LAB.toml and dialects; return the path of the first."""
    path = folder / "LAB.toml"
    path.write_text(text)
    for name, content in files.items():
        (folder / f"{name}.toml").write_text(content)
    return path


REHEARSAL = """schema = 1
[lab]
title = "rehearsal"
speed = 1000
sync = "60 s"
[instruments.suite]
link = "rig"
rig = "npsat1"
recording = "x_run1"
interval = "2 s"
over = "{over}"
faults = [{faults}]
"""


def rehearsed(folder: Path, over: str = "serial", faults: str = "", **given: object) -> Acquisition:
    """Return a rehearsal that has ended."""
    path = lab_folder(folder, REHEARSAL.format(over=over, faults=faults))
    made = Acquisition(load_lab(path), folder / "out", **given)  # type: ignore[arg-type]
    made.start()
    assert made.wait(60.0 * made.clock.speed)
    return made


class Table:
    """A rate table that answers as the dialect acutrol asks, and remembers what it was told."""

    def __init__(self) -> None:
        self.rate, self.interlock, self.told = 0.0, "Closed", list[str]()
        self.fastest = 0.0

    def answer(self, question: str) -> str | None:
        self.told.append(question)
        word, _, rest = question.partition(" ")
        if word == ":dem:rate":
            self.rate = float(rest.partition(",")[2])
            self.fastest = max(self.fastest, abs(self.rate))
        if word == ":int:open":
            self.rate = 0.0
        answers: dict[str, Callable[[], str]] = {
            "*IDN?": lambda: "ACUTRONIC,ACT3000,1,1",
            ":read:rate?": lambda: f"{self.rate:.6f}",
            ":read:pos?": lambda: "12.5",
            ":interlock?": lambda: self.interlock,
        }
        return answers[word]() if word in answers else None


def device(name: str, link: object, dialect: Dialect, clock: Clock, **given: object) -> Device:
    """Return a device."""
    return Device(name, link, dialect, clock, **given)  # type: ignore[arg-type]
