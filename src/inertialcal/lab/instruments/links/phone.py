"""The motion sensors of a phone, as the page of a guide sends them from its browser.

A browser gives its accelerometers and gyros rounded, as a rule to 0.1 m/s^2 and 0.1 deg/s, 60 times a second at most;
that is what a calibration by them is of. Axes are those of the W3C [1]_: x to the right of the screen, y to its top, z
out of it; what is turned about x is ``alpha``, about y ``beta``, about z ``gamma``.

References
----------
.. [1] W3C, Device Orientation and Motion, sections on ``DeviceMotionEvent``.
"""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np

from ...clock import Clock
from ..dialect import Dialect, FieldEntry, FrameEntry
from .link import LinkEntry, LinkKind, LinkLostError

NUMBERS = 7  # of a sample that a page sends, float64, little endian: time [ms], force [m/s^2], rate [deg/s]
MOST = 512  # samples that wait
LOOK = 0.02  # [s]
AWAY = 3.0  # [s] without a sample, after which the page is closed, or the phone asleep
SYNC = b"\xaa\x55"
DIALECT = Dialect(
    title="motion sensors of a phone, from its browser",
    source="W3C, Device Orientation and Motion",
    frame=FrameEntry(kind="packets", sync=SYNC.hex(" ")),
    fields=(
        FieldEntry(name="t", unit="s", scale=1e-3, role="time"),
        *(FieldEntry(name=f"acc_{axis}", unit="m/s^2", axis=axis) for axis in ("x", "y", "z")),
        *(FieldEntry(name=f"gyro_{axis}", unit="deg/s", axis=axis) for axis in ("x", "y", "z")),
    ),
)


class PhoneLink:
    """What a page sends, for as long as it does."""

    whole = True
    begins_whole = True

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.served = False  # Whether there is a page that could send
        self._waiting: deque[bytes] = deque(maxlen=MOST)
        self._came: float | None = None  # When the last sample came; None before the first, and while it is away [s]
        self._lost = False

    def put(self, data: bytes) -> bool:
        """Take samples of a page; return whether they are some."""
        if not data or len(data) % (8 * NUMBERS) or not np.isfinite(np.frombuffer(data, "<f8")).all():
            return False
        self._came = self.clock.seconds()
        for first in range(0, len(data), 8 * NUMBERS):
            self._waiting.append(SYNC + data[first : first + 8 * NUMBERS])
        return True

    def open(self) -> None:
        """Be there: from the beginning, and again once samples come after it was lost."""
        if not self.served:
            raise LinkLostError("a phone sends over the page of: inertialcal guide --phone")
        if self._lost and self._came is None:
            raise LinkLostError("the page on the phone sends nothing")
        self._lost = False

    def read(self, wait: float) -> list[bytes]:
        """Return the samples that came."""
        until = self.clock.seconds() + wait
        while not self._waiting:
            now = self.clock.seconds()
            if self._came is not None and now - self._came > AWAY:
                self._came, self._lost = None, True
                raise LinkLostError("the page on the phone sends nothing: open it, and keep its screen on")
            if now >= until:
                return []
            self.clock.wait(min(LOOK, until - now))
        return [self._waiting.popleft() for _ in range(len(self._waiting))]

    def write(self, data: bytes) -> None:
        """Refuse: a page takes no commands."""
        raise LinkLostError("nothing can be sent to a phone")

    def close(self, again: bool = False) -> None:
        """End."""


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> PhoneLink:
    return PhoneLink(clock)


KIND = LinkKind("phone", (), 0, _make, lambda entry, folder: DIALECT)
