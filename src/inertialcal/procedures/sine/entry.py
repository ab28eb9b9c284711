"""What a campaign says of a recording under a known drive: the schedule of what was applied."""

from __future__ import annotations

from typing import Protocol

from ...core.schema.quantities import Strict, Text
from ..entries import Entry, EntryKey


class KnownDrive(Strict):
    """drive = {...}: a table of the dwells of the drive, which begins with the recording."""

    schedule: Text


class SineEntry(Entry, Protocol):
    """A recording under a known drive."""

    @property
    def drive(self) -> KnownDrive | None:
        """The dwells of the drive."""
        ...


KEYS = (EntryKey("drive", KnownDrive, file=lambda drive: drive.schedule),)
