"""Serial ports, by pyserial."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...clock import Clock
from .link import LinkEntry, LinkKind, LinkLostError, package

TOGETHER = 0.02  # [s]: what comes so soon after the last piece is read together


class SerialLink:
    """A serial port."""

    whole = False
    begins_whole = False

    def __init__(self, address: str, baud: int, clock: Clock) -> None:
        self.address, self.baud, self.clock = address, baud, clock
        self._port: Any = None
        self._last = 0.0

    def open(self) -> None:
        """Open the port."""
        serial = package("serial", "a serial port")
        try:
            self._port = serial.Serial(self.address, self.baud, timeout=0.0, write_timeout=2.0)
        except (serial.SerialException, OSError, ValueError) as error:
            raise LinkLostError(str(error)) from None

    def read(self, wait: float) -> list[bytes]:
        """Return what came."""
        serial = package("serial", "a serial port")
        try:
            self._port.timeout = self.clock.real(wait)
            found = bytes(self._port.read(1))
            if found and self.clock.seconds() - self._last < TOGETHER:
                self.clock.wait(TOGETHER)
            found += bytes(self._port.read(self._port.in_waiting)) if found else b""
        except (serial.SerialException, OSError, TypeError, AttributeError) as error:  # the last two: not open
            raise LinkLostError(str(error)) from None
        if found:
            self._last = self.clock.seconds()
        return [found] if found else []

    def write(self, data: bytes) -> None:
        """Send."""
        serial = package("serial", "a serial port")
        try:
            self._port.write(data)
        except (serial.SerialException, OSError, TypeError, AttributeError) as error:
            raise LinkLostError(str(error)) from None

    def close(self, again: bool = False) -> None:
        """Close the port."""
        if self._port is not None:
            self._port.close()


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> SerialLink:
    return SerialLink(entry.address, entry.baud, clock)


KIND = LinkKind("serial", ("address", "baud"), 1, _make)
