"""What a campaign says of a recording of the environment: the requirement curve."""

from __future__ import annotations

from typing import Protocol

from ...core.schema.quantities import Text
from ..entries import Entry, EntryKey


class EnvironmentEntry(Entry, Protocol):
    """A recording of the environment."""

    @property
    def curve(self) -> str | None:
        """File with the requirement curve."""
        ...


KEYS = (EntryKey("curve", Text, file=lambda curve: curve),)
