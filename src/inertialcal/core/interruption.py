"""An interruption of the process: held back where a step must be whole, and what was written before it.

The command line asks for the interruption (``cli/process.py``). A library call from Python never does, so that
there ``held`` changes nothing.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


class Interruption:
    """Whether an interruption is requested, whether a step holds it back, and what is on disk."""

    def __init__(self) -> None:
        self.requested = False
        self.accepted = False  # The last request is the way to end the command
        self.holds = 0
        self.written: dict[str, bool] = {}  # Paths of this command, and whether each is complete
        self.then = ""  # What goes on with what is not complete
        self.noting = False  # Only in the command line, which ends

    def request(self) -> None:
        """Interrupt now, or at the end of the step that holds it back.

        Raises
        ------
        KeyboardInterrupt
            If nothing holds it back.
        """
        self.requested = True
        if not self.holds:
            raise KeyboardInterrupt

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold an interruption back until the end of the block.

        Raises
        ------
        KeyboardInterrupt
            At the end, if an interruption was requested in the block.
        """
        self.holds += 1
        try:
            yield
        finally:
            self.holds -= 1
        if self.requested and not self.holds:
            raise KeyboardInterrupt

    def accept(self) -> None:
        """Take what was requested as the way to end the command: it goes on to its end, held back from nothing."""
        self.requested, self.accepted = False, True

    def note(self, path: str | os.PathLike[str], complete: bool = True, then: str = "") -> None:
        """Note a file or folder that is on disk, for the message of an interruption, and what goes on with it."""
        if self.noting:
            self.written[os.fspath(path)], self.then = complete, then


interruption = Interruption()
