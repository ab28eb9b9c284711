"""What a thermal test found, in one sentence."""

from __future__ import annotations

from collections.abc import Sequence

from ...core.results import WrittenRow
from ...core.show.rows import Cited, Quoted, Sentence, estimated, largest, reason_code

OFFSETS = ("vacuum_offset", "bias_shift")


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say over which temperatures the bias is known, what power-ups scatter by, and which axes show hysteresis."""
    lowest, highest = (
        [row for row in rows if row["quantity"] == name and row["value"] is not None]
        for name in ("temperature_lowest", "temperature_highest")
    )
    if not lowest or not highest:
        return ("No bias over temperature estimated",)
    low, high = max(lowest, key=_value), min(highest, key=_value)  # where all axes are known
    said: Sentence = ("Bias over ", Cited(low, u=False, unit=False), " to ", Cited(high, u=False))
    offset = largest([row for name in OFFSETS for row in estimated(rows, name, any_case=True)])
    if offset is not None:
        name = offset["quantity"].replace("_", " ")
        said = (*said, "; ", name, " up to ", Cited(offset), ", on ", Quoted(offset["axis"]))
    scatter = largest(estimated(rows, "scatter_run", any_case=True))
    if scatter is not None:
        said = (*said, "; power-ups scatter by up to ", Cited(scatter), ", on ", Quoted(scatter["axis"]))
    shown = [Quoted(row["axis"]) for row in rows if row["quantity"] == "hysteresis" and (reason_code(row) == "yes")]
    if not shown:
        return (*said, "; no hysteresis seen")
    named = [part for axis in shown for part in (", ", axis)][1:]
    return (*said, "; hysteresis seen on ", *named)


def _value(row: WrittenRow) -> float:
    return float(row["value"])
