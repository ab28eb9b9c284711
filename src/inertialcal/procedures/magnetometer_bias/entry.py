"""Key of a recording's entry for an orbit by two-line elements, in place of channels of the position."""

from __future__ import annotations

from typing import Protocol

from ...core.schema.quantities import Strict, Text
from ..entries import Entry, EntryKey


class Tle(Strict):
    """tle = {...}: file of two-line elements, and the name or number of the satellite where it holds several."""

    file: Text
    satellite: Text | None = None


class OrbitEntry(Entry, Protocol):
    """A recording in orbit."""

    @property
    def tle(self) -> Tle | None:
        """Elements of the orbit."""
        ...


KEYS = (EntryKey("tle", Tle, file=lambda tle: tle.file),)
