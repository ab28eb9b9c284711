"""What a campaign says of a recording of a vibration: the profile that it was run to."""

from __future__ import annotations

from typing import Protocol

from ...core.schema.quantities import Text
from ..entries import Entry, EntryKey


class VibrationEntry(Entry, Protocol):
    """A recording of a vibration."""

    @property
    def profile(self) -> str | None:
        """File with the profile."""
        ...


KEYS = (EntryKey("profile", Text, file=lambda profile: profile),)
