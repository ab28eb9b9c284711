"""An acquisition with a live page, whose truth is known: 12 channels and a temperature, what they are called and do.

``python tests/lab/shown_lab.py FOLDER PORT`` is the process that a test kills and starts again.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from lab_devices import lab_folder

from inertialcal.core.remarks import Remark
from inertialcal.files.loggers.rows import RowChannel, RowLayout
from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.clock import Clock, Instant
from inertialcal.lab.instruments.protocol import Batch
from inertialcal.lab.live.server import live_page

HOSTILE = (
    "<img src=x onerror=alert(1)>", "</script><script>alert(2)</script>", '"><svg onload=alert(3)>', "{script}{nonce}",
    "javascript:alert(4)", "__proto__", "&lt;b&gt;", "' onmouseover='alert(5)",
)  # fmt: skip
PLAIN = tuple(f"{kind}_{axis}" for kind in ("gyro", "acc", "gyro2", "acc2") for axis in "xyz")
RATE = 1000  # Hz
WHITE = 0.5  # standard deviation of every channel but the named ones
STUCK, RAIL, TOP = 1, 2, 0.8  # places of the channel that is stuck, of the one at its rail, and the rail
TEXT = """schema = 1
[lab]
title = '{title}'
sync = "0.5 s"
[instruments.imu]
link = "tcp"
address = "127.0.0.1:1"
dialect = "aerosmith"
parameters = {{ acceleration = "1" }}
"""


class Signals:
    """White noise at 1 kHz about the number of the channel; one is stuck, one at a rail; a temperature in degC."""

    name = "imu"
    settable: dict[str, str] = {}  # noqa: RUF012

    def __init__(self, clock: Clock, names: tuple[str, ...] = PLAIN) -> None:
        self.clock, self.names = clock, names
        self.layout = RowLayout((
            RowChannel("n", "uint32", role="counter"),
            *(RowChannel(one, "float64", "deg/s" if i % 6 < 3 else "m/s^2", axis="xyz"[i % 3])
              for i, one in enumerate(names)),
            RowChannel("temperature", "float64", "degC"),
        ))  # fmt: skip

    def open(self) -> None: ...

    def identify(self) -> str:
        return f"made of {self.names[0]}"

    def configure(self) -> None: ...

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        rng, count, begin = np.random.default_rng(1), 0, self.clock.seconds()
        while not self.clock.wait(0.01, stop):
            due = round((self.clock.seconds() - begin) * RATE)
            rows = np.zeros(due - count, self.layout.dtype)
            if not len(rows):
                continue
            rows["n"] = np.arange(count, due)
            for i, name in enumerate(self.names):
                rows[name] = i + WHITE * rng.normal(size=len(rows))
            rows[self.names[STUCK]] = 4.25
            rows[self.names[RAIL]] = np.minimum(rows[self.names[RAIL]], RAIL + TOP * WHITE)
            rows["temperature"] = 25.0
            count = due
            yield Batch(rows, self.clock.now())

    def set(self, quantity: str, value: float) -> Instant:
        return self.clock.now()

    def read(self, quantity: str) -> float:
        return 0.0

    def check(self, quantity: str, value: float) -> str:
        return ""

    def safe(self) -> None: ...

    def close(self) -> None: ...


def lively(
    folder: Path, names: tuple[str, ...] = PLAIN, title: str = "gyro on the desk", speed: int = 1
) -> Acquisition:
    """Return an acquisition of `Signals` that has begun."""
    folder.mkdir(exist_ok=True)
    clock = Clock(speed)
    lab = load_lab(lab_folder(folder, TEXT.format(title=title)))
    made = Acquisition(lab, folder / "out", clock, [Signals(clock, names)])
    made.start()
    return made


@contextmanager
def shown(folder: Path, port: int = 0, **given: object) -> Iterator[tuple[Acquisition, str]]:
    """Give an acquisition and the address of its page while the block runs."""
    made = lively(folder, **given)  # type: ignore[arg-type]
    try:
        with live_page(made, port) as address:
            yield made, address
    finally:
        made.stop()
        made.wait()


if __name__ == "__main__":
    with shown(Path(sys.argv[1]), int(sys.argv[2])) as (running, place):
        running.say(Remark("lost_rows", "warning", "rows that are missing by the counter", where="imu", count=3))
        print(place, flush=True)
        threading.Event().wait()
