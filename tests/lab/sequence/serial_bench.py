"""Three instruments on serial lines whose state outlives who drives them: a gyro, a rate table and a chamber.

Nothing of the package is used. The table slews, the chamber comes to its temperature by and by; both go on when nobody
listens, and the gyro counts on.
"""

from __future__ import annotations

import contextlib
import os
import random
import select
import threading
import time
import tty

SLEW, TAU = 60.0, 0.15  # [deg/s^2], [s]
PACE = 0.01  # of the gyro [s]
SCALE, DRIFT, NOISE = 1.01, 0.002, 0.01  # of the gyro; [deg/s/degC], [deg/s]

IMU = """[frame]
kind = "lines"
[[fields]]
name = "counter"
type = "uint32"
role = "counter"
[[fields]]
name = "t"
unit = "s"
role = "time"
[[fields]]
name = "gyro_x"
unit = "deg/s"
axis = "x"
[[fields]]
name = "temperature"
unit = "degC"
"""
MACHINE = """timeout = "2 s"
[frame]
kind = "answers"
every = "0.05 s"
[[fields]]
name = "{name}"
unit = "{unit}"
ask = "{name}?"
[commands]
start = ["ON"]
safe = ["SAFE"]
[settings.{name}]
unit = "{unit}"
set = ["{name} {{value:.6f}}"]
read = "{name}?"
"""
DIALECTS = {
    "imu": IMU, "table": MACHINE.format(name="rate", unit="deg/s"),
    "chamber": MACHINE.format(name="temperature", unit="degC"),
}  # fmt: skip


class Line:
    """A pty; its other end stays open, so that who opens and closes it is not noticed."""

    def __init__(self) -> None:
        self.fd, self.kept = os.openpty()
        tty.setraw(self.kept)
        os.set_blocking(self.fd, False)
        self.address = os.ttyname(self.kept)

    def close(self) -> None:
        for one in (self.fd, self.kept):
            os.close(one)


class SerialBench:
    """The instruments, until they are closed."""

    def __init__(self) -> None:
        self.lines = {name: Line() for name in DIALECTS}
        self.told: list[tuple[str, str]] = []  # Instrument, command
        self.rate = self.wanted_rate = 0.0
        self.temperature = self.wanted_temperature = 20.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> SerialBench:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._end.set()
        self._thread.join()
        for one in self.lines.values():
            one.close()

    def _run(self) -> None:
        noise, counter, begin, last = random.Random(1), 0, time.monotonic(), time.monotonic()
        half: dict[str, bytes] = dict.fromkeys(self.lines, b"")
        machines = {self.lines[name].fd: name for name in ("table", "chamber")}
        while not self._end.is_set():
            readable, _, _ = select.select(list(machines), [], [], PACE / 4)
            now = time.monotonic()
            self._move(now - last)
            last = now
            for fd in readable:
                name = machines[fd]
                *lines, half[name] = (half[name] + os.read(fd, 4096)).split(b"\n")
                for line in lines:
                    self._hear(name, line.decode().strip())
            while counter * PACE <= now - begin:
                value = SCALE * self.rate + DRIFT * self.temperature + noise.gauss(0.0, NOISE)
                row = f"{counter},{counter * PACE:.3f},{value:.5f},{self.temperature:.3f}\n"
                self._send("imu", row)
                counter += 1

    def _move(self, passed: float) -> None:
        left = self.wanted_rate - self.rate
        self.rate += max(-SLEW * passed, min(SLEW * passed, left))
        self.temperature += (self.wanted_temperature - self.temperature) * min(passed / TAU, 1.0)

    def _hear(self, name: str, line: str) -> None:
        word, _, number = line.partition(" ")
        if word.endswith("?"):
            self._send(name, f"{self.rate if word == 'rate?' else self.temperature:.4f}\n")
            return
        self.told.append((name, line))
        if word == "rate":
            self.wanted_rate = float(number)
        elif word == "temperature":
            self.wanted_temperature = float(number)
        elif word == "SAFE" and name == "table":
            self.wanted_rate = 0.0
        elif word == "SAFE":
            self.wanted_temperature = 20.0

    def _send(self, name: str, text: str) -> None:
        with contextlib.suppress(BlockingIOError):  # nobody reads: it is lost, as on a line
            os.write(self.lines[name].fd, text.encode())
