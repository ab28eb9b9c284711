"""VISA resources (GPIB, USB, LAN, serial), by pyvisa; pyvisa-py where no other library is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...clock import Clock
from .link import LinkEntry, LinkKind, LinkLostError, package

LIBRARY = "@py"
SHORTEST = 1  # [ms] of a timeout: none means for ever


class VisaLink:
    """A VISA resource: what is read is a message."""

    whole = True
    begins_whole = True

    def __init__(self, address: str, library: str, clock: Clock) -> None:
        self.address, self.library, self.clock = address, library or LIBRARY, clock
        self._manager: Any = None
        self._resource: Any = None

    def open(self) -> None:
        """Open the resource."""
        visa = package("pyvisa", "a VISA resource")
        if self.library.endswith("@py"):
            package("pyvisa_py", "a VISA resource")
        try:
            self._manager = visa.ResourceManager(self.library)
            self._resource = self._manager.open_resource(self.address, read_termination="\n", write_termination=None)
        except (visa.Error, OSError, ValueError, AttributeError) as error:
            raise LinkLostError(str(error)) from None

    def read(self, wait: float) -> list[bytes]:
        """Return a message."""
        visa = package("pyvisa", "a VISA resource")
        try:
            self._resource.timeout = max(round(1000 * self.clock.real(wait)), SHORTEST)
            return [bytes(self._resource.read_raw())]
        except visa.errors.VisaIOError as error:
            if error.error_code == visa.constants.StatusCode.error_timeout:
                return []
            raise LinkLostError(str(error)) from None
        except (visa.Error, OSError) as error:
            raise LinkLostError(str(error)) from None

    def write(self, data: bytes) -> None:
        """Send."""
        visa = package("pyvisa", "a VISA resource")
        try:
            self._resource.write_raw(data)
        except (visa.Error, OSError) as error:
            raise LinkLostError(str(error)) from None

    def close(self, again: bool = False) -> None:
        """Close the resource."""
        for one in (self._resource, self._manager):
            if one is not None:
                one.close()


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> VisaLink:
    kind, at, where = entry.library.rpartition("@")
    beside = folder / kind  # a file of pyvisa-sim
    return VisaLink(entry.address, f"{beside}{at}{where}" if kind and beside.is_file() else entry.library, clock)


KIND = LinkKind("visa", ("address", "library"), 1, _make)
