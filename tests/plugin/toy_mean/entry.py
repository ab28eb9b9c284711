"""What a campaign says of a recording that a mean is taken of."""

from __future__ import annotations

from typing import Protocol

from inertialcal.core.schema.quantities import Strict, Text, Unit
from inertialcal.procedures.entries import Entry, EntryKey


class Means(Strict):
    """mean_table = {...}: a table of means, a row a recording."""

    x: Text | None = None
    y: Text | None = None
    unit: Unit


class MeanEntry(Entry, Protocol):
    """A recording, or a table of means."""

    @property
    def upside_down(self) -> bool | None:
        """Whether the unit lay upside down."""
        ...

    @property
    def mean_table(self) -> Means | None:
        """Columns of a table."""
        ...


KEYS = (EntryKey("mean_table", Means, table=True), EntryKey("upside_down", bool))
