"""An IMU on a pty, in a hand that does what a guide tells it: lines of text, at the pace of a clock."""

from __future__ import annotations

import os
import pty
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from lab_devices import lab_folder
from simulated_hand import CLEAN, Habits, Hand

from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.clock import Clock
from inertialcal.lab.guide.session import Asked, Session

RATE = 50.0  # [Hz]
LAG = 1.0  # [s] by which a guide may be behind, on a busy computer and a fast clock
Change = Callable[[np.ndarray], np.ndarray]
LAB = """schema = 1
[instruments.imu]
link = "serial"
address = "{address}"
dialect = "imu.toml"
"""
IMU = """[frame]
kind = "lines"
[[fields]]
name = "t"
unit = "s"
role = "time"
""" + "".join(
    f'[[fields]]\nname = "{kind}_{axis}"\nunit = "{unit}"\naxis = "{axis}"\n'
    for kind, unit in (("acc", "{acc}"), ("gyro", "{gyro}")) for axis in "xyz"
) + '[[fields]]\nname = "temperature"\nunit = "degC"\n'  # fmt: skip


class LiveImu:
    """An IMU on a pty, in the hand of somebody who obeys a session.

    ``per`` are the units of a reading in SI, of both sensors where they are counts; ``warming`` is how fast it warms up
    [K/s]; ``change`` is what becomes of force and rate before they are sent.
    """

    def __init__(self, seed: int, habits: Habits, clock: Clock, folder: Path, per: float = 1.0,
                 counts: bool = False, warming: float = 0.0, change: Change = lambda both: both) -> None:  # fmt: skip
        self.hand = Hand(seed, habits, step=0.25, rate=RATE)
        self.clock, self.per, self.counts, self.warming, self.change = clock, per, counts, warming, change
        self.link = folder / "port"
        self.stop, self.away = threading.Event(), threading.Event()
        self.obeys: Session | None = None
        self._plug()
        folder.mkdir(exist_ok=True)
        unit = "count" if counts else ""
        text = LAB.format(address=self.link)
        self.lab = load_lab(
            lab_folder(folder, text, imu=IMU.replace("{acc}", unit or "m/s^2").replace("{gyro}", unit or "rad/s"))
        )
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _plug(self) -> None:
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(self.slave))

    def _unplug(self) -> None:
        os.close(self.master)
        os.close(self.slave)
        self.link.unlink()

    def _send(self, data: bytes) -> None:
        while data and not self.stop.is_set():
            try:
                data = data[os.write(self.master, data) :]
            except BlockingIOError:
                self.clock.pause(self.stop)

    def _run(self) -> None:
        begin = self.clock.seconds()
        while not self.stop.is_set():
            if self.away.is_set():
                self._unplug()
                while self.away.is_set() and not self.clock.pause(self.stop):
                    pass
                self._plug()
            state = self.obeys.state if self.obeys is not None else None
            code = "lay_down" if state is None else state.code
            if self.obeys is not None and self.hand.t - self.obeys._stamp / 1e9 > LAG:
                code = "hold_still"  # what is said is about what was: who looks at a page waits for it
            stamps, f, w, now = self.hand.batch(code, None if state is None else state.target)
            self.clock.wait(begin + now - self.clock.seconds(), self.stop)
            both = self.change(np.hstack([self.per * f, (self.per if self.counts else 1.0) * w]))
            both = np.rint(both) if self.counts else both
            warm = 25.0 + self.warming * now
            lines = [
                f"{t / 1e9:.4f},{','.join(f'{x:.6f}' for x in one)},{warm:.2f}\n"
                for t, one in zip(stamps, both, strict=True)
            ]
            self._send("".join(lines).encode())

    def start(self, session: Session) -> None:
        self.obeys = session
        self._thread.start()

    def end(self) -> None:
        self.stop.set()
        if self._thread.ident is not None:
            self._thread.join()
        self._unplug()


@contextmanager
def live_imu(folder: Path, seed: int = 1, habits: Habits = CLEAN, speed: int = 40, asked: Asked | None = None,
             **given: object) -> Iterator[tuple[LiveImu, Session]]:  # fmt: skip
    """Give an IMU and a session that has begun."""
    folder.mkdir(exist_ok=True)
    clock = Clock(speed)
    imu = LiveImu(seed, habits, clock, folder, **given)  # type: ignore[arg-type]
    session = Session(imu.lab, folder / "out", asked or Asked(), clock)
    try:
        session.start()
        imu.start(session)
        yield imu, session
    finally:
        session.acquisition.stop()
        imu.end()


def stepped(session: Session, most: float = 1500.0) -> np.ndarray:
    """Step until it is over, or so long by the IMU's clock [s]; return how it was told, code by code.

    A computer that is busy may take far longer than the clock says.
    """
    codes, until = [], session.clock.seconds() + 20.0 * most
    while session._stamp < most * 1e9 and session.clock.seconds() < until and session.step():
        codes.append(session.shown.code)
    return np.array(codes)
