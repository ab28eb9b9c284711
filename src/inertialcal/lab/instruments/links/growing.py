"""A file that another program writes: what is added to it is read, from its beginning on."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

from ...clock import Clock
from .link import LinkEntry, LinkKind, LinkLostError

LOOK = 0.1  # [s] between two looks
LARGEST = 2**20  # bytes that are taken at once


class FileLink:
    """A file that grows."""

    whole = False
    begins_whole = True

    def __init__(self, path: Path, clock: Clock) -> None:
        self.path, self.clock = path, clock
        self._file: BinaryIO | None = None

    def open(self) -> None:
        """Open the file."""
        try:
            self._file = self.path.open("rb")
        except OSError as error:
            raise LinkLostError(error.strerror or str(error)) from None

    def read(self, wait: float) -> list[bytes]:
        """Return what was added."""
        if self._file is None:
            raise LinkLostError("not open")
        until = self.clock.seconds() + wait
        while True:
            try:
                found = self._file.read(LARGEST)
                if found:
                    return [found]
                about, named = os.fstat(self._file.fileno()), os.stat(self.path)
            except (OSError, ValueError) as error:
                raise LinkLostError(str(error)) from None
            if about.st_size < self._file.tell() or not os.path.samestat(about, named):
                raise LinkLostError("the file was cut off or replaced: it is read from its beginning again")
            left = until - self.clock.seconds()
            if left <= 0:
                return []
            self.clock.wait(min(LOOK, left))

    def write(self, data: bytes) -> None:
        """Refuse: it belongs to another program."""
        raise LinkLostError("nothing can be sent to a file")

    def close(self, again: bool = False) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> FileLink:
    return FileLink(folder / entry.address, clock)


KIND = LinkKind("file", ("address",), 1, _make)
