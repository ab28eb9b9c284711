"""What a campaign says of a recording: conditions that are no channel of their own name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from ...core.schema.quantities import Strict, Text, Unit
from ..entries import Entry, EntryKey


class Condition(Strict):
    """NAME = { column, unit } in ``conditions``: a channel that readings are set against."""

    column: Text
    unit: Unit


class SensitivityEntry(Entry, Protocol):
    """A recording whose conditions are recorded with it."""

    @property
    def conditions(self) -> Mapping[str, Condition] | None:
        """Columns of conditions by their name; None where there are none beside the channels."""
        ...


KEYS = (EntryKey("conditions", dict[Text, Condition]),)


def conditions_of(entry: SensitivityEntry) -> Iterator[tuple[str, Condition]]:
    """Yield the conditions of an entry with their names."""
    yield from (entry.conditions or {}).items()
