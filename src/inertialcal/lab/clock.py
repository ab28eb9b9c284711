"""The one clock of an acquisition: it counts, tells UTC and waits; nothing else in the lab does.

A clock may run faster than time, so that a rehearsal of hours takes seconds: everything that counts or waits by it is
faster alike. Real instruments need a clock at speed 1.

Two readings are taken together wherever something is stamped: monotonic (never set back, its zero has no meaning) and
UTC (may be stepped by whoever disciplines the computer). Differences of time are those of the monotonic reading.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Instant:
    """Two readings of one moment."""

    monotonic_ns: int
    utc_ns: int  # Since 1970


class Clock:
    """A clock that all of an acquisition share.

    Parameters
    ----------
    speed : int
        Seconds that it counts in a second.
    """

    def __init__(self, speed: int = 1) -> None:
        self.speed = speed
        self._monotonic, self._utc = time.monotonic_ns(), time.time_ns()

    def now(self) -> Instant:
        """Return both readings."""
        monotonic, utc = time.monotonic_ns(), time.time_ns()
        return Instant(
            self._monotonic + (monotonic - self._monotonic) * self.speed, self._utc + (utc - self._utc) * self.speed
        )

    def seconds(self) -> float:
        """Return the monotonic reading [s]."""
        return self.now().monotonic_ns / 1e9

    def real(self, seconds: float) -> float:
        """Return how long an operating system has to wait while the clock counts so many seconds [s]."""
        return max(seconds, 0.0) / self.speed

    def wait(self, seconds: float, stop: threading.Event | None = None) -> bool:
        """Wait so many seconds of the clock, or until ``stop`` is set; return whether it is."""
        if stop is not None:
            return stop.wait(self.real(seconds))
        time.sleep(self.real(seconds))
        return False

    def pause(self, stop: threading.Event | None = None, many: int = 1) -> bool:
        """Wait so many milliseconds of the machine, whatever the speed: for another process or thread to go on."""
        return self.wait(0.001 * many * self.speed, stop)
