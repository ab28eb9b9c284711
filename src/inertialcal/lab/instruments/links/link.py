"""What a link is, what LAB.toml may say of one, and how a missing package is named."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Annotated, Literal, Protocol

from pydantic import Field
from pydantic import Strict as Strictly

from ....core.errors import InstrumentError
from ....core.schema.quantities import Strict, Text
from ...clock import Clock
from ..dialect import Dialect


class LinkLostError(Exception):
    """A link is there no longer; it may come back."""


class LinkEndedError(Exception):
    """A link has nothing more to give."""


Fault = Literal["late", "torn", "doubled", "lost", "unplugged"]


class LinkEntry(Strict):
    """What LAB.toml says of a link; each kind takes some of it."""

    address: Text = ""
    baud: int = Field(default=115_200, ge=50, le=12_000_000)
    library: Text = ""  # of VISA
    rig: Text = ""
    recording: Text = ""
    seed: int = Field(default=1, ge=0)
    plan: Text = ""  # file of a plan
    over: Literal["serial", "tcp", "udp"] = "serial"
    faults: Annotated[tuple[Fault, ...], Strictly(False), Field(max_length=5)] = ()


class Link(Protocol):
    """Bytes from and to an instrument."""

    whole: bool  # Each piece that is read is a line or packet of its own
    begins_whole: bool  # What comes first after opening is the beginning of a line

    def open(self) -> None:
        """Connect; raises LinkLostError."""
        ...

    def read(self, wait: float) -> list[bytes]:
        """Return the pieces that came, none after so many seconds; raises LinkLostError, LinkEndedError."""
        ...

    def write(self, data: bytes) -> None:
        """Send; raises LinkLostError."""
        ...

    def close(self, again: bool = False) -> None:
        """Disconnect, to connect again or for good; never raises."""
        ...


@dataclass(frozen=True)
class LinkKind:
    """A kind of link.

    Parameters
    ----------
    name : str
        As LAB.toml has it.
    takes : tuple of str
        Keys that it takes, those that it needs first.
    needs : int
        How many of them it needs.
    make : callable
        Entry, folder of LAB.toml, clock -> link.
    dialect : callable, optional
        Entry, folder of LAB.toml -> dialect, of a kind that knows it.
    paced : bool
        It keeps to the clock, also to one that is faster than time.
    """

    name: str
    takes: tuple[str, ...]
    needs: int
    make: Callable[[LinkEntry, Path, Clock], Link]
    dialect: Callable[[LinkEntry, Path], Dialect] | None = None
    paced: bool = False


def package(name: str, what: str) -> ModuleType:
    """Return a module of the extra ``lab``.

    Raises
    ------
    InstrumentError
        ``missing_extra``.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InstrumentError(
            f"{what} needs the package {name}, which is not installed",
            do="Type: pip install 'inertialcal[lab]'",
            code="missing_extra",
        ) from None
