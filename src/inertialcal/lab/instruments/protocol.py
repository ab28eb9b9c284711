"""What an instrument is, and what it gives: rows of a fixed layout, each lot stamped with the moment at which it came.

An acquisition knows this protocol and nothing else of an instrument. Whoever has another kind of instrument gives an
object with these methods; `device.Device` is that of everything that speaks by lines, packets, questions and answers.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

from ...core.remarks import Remark
from ...files.loggers.rows import RowLayout, Rows
from ..clock import Instant

Say = Callable[[Remark], None]


@dataclass(frozen=True, eq=False)
class Batch:
    """Rows that came together."""

    rows: Rows  # shape (n,)
    at: Instant  # When the last of them had come
    asked: Instant | None = None  # When the reading that brought them began; None: not known


class Instrument(Protocol):
    """An instrument that is connected for as long as an acquisition goes on."""

    @property
    def name(self) -> str:
        """As LAB.toml calls it."""
        ...

    @property
    def layout(self) -> RowLayout | None:
        """What its rows hold; None of one that gives none."""
        ...

    @property
    def settable(self) -> Mapping[str, str]:
        """Unit of each quantity that can be set, by name."""
        ...

    def open(self) -> None:
        """Connect. Raises InstrumentError."""
        ...

    def identify(self) -> str:
        """Return who it says it is; empty where it cannot be asked. Raises InstrumentError."""
        ...

    def configure(self) -> None:
        """Send what it needs before it is used. Raises InstrumentError."""
        ...

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        """Yield rows as they come until ``stop`` is set, or there will be no more; connect again where it is lost."""
        ...

    def set(self, quantity: str, value: float) -> Instant:
        """Set a quantity, in its unit; what is asked for from the returned moment on came after it.

        Raises InstrumentError, after the safe state was brought about.
        """
        ...

    def read(self, quantity: str) -> float:
        """Return a quantity, in its unit. Raises InstrumentError."""
        ...

    def check(self, quantity: str, value: float) -> str:
        """Return why a value cannot be set, and empty where it can; nothing is sent."""
        ...

    def safe(self) -> None:
        """Bring about the safe state. Raises InstrumentError where that cannot be done."""
        ...

    def close(self) -> None:
        """Disconnect; never raises."""
        ...
