"""What is said while loops are compiled, and which were; imports nothing that starts slowly.

A loop is compiled when it is first called, and its code kept on disk (``_kernels``): the next process loads it.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

PATIENCE = 1.0  # s of compiling after which it is said


class Compiling:
    """The loops that this process compiled, and a word to say once where that takes long."""

    def __init__(self) -> None:
        self.say: Callable[[], None] | None = None
        self.names: list[str] = []
        self.started = False  # whether a loop was loaded or compiled: the next one from disk takes some milliseconds
        self._depth, self._spent, self._since = 0, 0.0, 0.0
        self._timer: threading.Timer | None = None

    def begin(self, name: str) -> None:
        """Note that a loop begins to be compiled; those that it calls are compiled within."""
        self.names.append(name)
        self._depth += 1
        if self._depth > 1 or self.say is None:
            return
        self._since = time.monotonic()
        self._timer = threading.Timer(max(0.0, PATIENCE - self._spent), self._said)
        self._timer.daemon = True
        self._timer.start()

    def end(self) -> None:
        """Note that a loop is compiled."""
        self.started = True
        self._depth -= 1
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()
            self._spent += time.monotonic() - self._since
            self._timer = None

    def _said(self) -> None:
        """Say it, once."""
        say, self.say = self.say, None
        if say is not None:
            say()


compiling = Compiling()
