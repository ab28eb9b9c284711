"""What a campaign says of a rate table's recordings: columns of a reduced table, a schedule of the table."""

from __future__ import annotations

from ...core.quantities import Unit
from ...core.schema_words import Axis, Strict, Text

Columns = Text | dict[Axis, Text]


class Rows(Strict):
    """rows = {...}: which column of a reduced table is what; a row is a dwell."""

    applied: Text
    reading: Columns
    unit: Unit
    applied_unit: Unit | None = None
    scatter: Columns | None = None
    samples: Text | None = None
    axis: Text | None = None
    group: Text | None = None
    run: Text | None = None
    time: Text | None = None


class Schedule(Strict):
    """schedule = {...}: a table of the dwells of a recording, a row a dwell, on its clock."""

    file: Text
    start: Text = "start"
    stop: Text = "stop"
    rate: Text = "rate"
    unit: Unit
