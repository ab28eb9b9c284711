"""A plan of a source mass as tables: body, drive, budget, forecast; each figure where it belongs."""

from __future__ import annotations

from collections.abc import Sequence

from ....core.results import Row
from ....core.show.rounding import with_uncertainty
from ....core.show.tables import Block, Table

BLOCKS: dict[str, tuple[str, ...]] = {
    "body": (
        "cells", "mass", "size", "attraction", "attraction_bound", "attraction_gap", "attraction_sphere",
        "inventory_gap", "stated_attraction", "stated_excess", "mass_needed", "radius", "smallest_gradient",
        "smallest_acceleration", "distance",
    ),
    "drive": (
        "drive_position", "amplitude", "best_window_start", "best_window_amplitude", "motion_harmonic",
        "proof_mass_effect", "pointlike_length", "mercury_amplitude",
    ),
    "budget of the amplitude": ("amplitude_uncertainty",),
    "forecast: standard uncertainty of the scale factor": (
        "scale_factor_uncertainty", "time_to_target", "time_to_budget",
    ),
}  # fmt: skip
PREDICTED = (
    "amplitude_uncertainty", "scale_factor_uncertainty", "time_to_target", "time_to_budget", "motion_harmonic",
    "proof_mass_effect", "attraction_gap", "inventory_gap", "stated_excess",
)  # fmt: skip
HEADS = ("quantity", "", "value ± u", "unit")
DIGITS, ROUGH = 5, 3


def mass_parts(rows: Sequence[Row]) -> tuple[Block, ...]:
    """Return the figures, block by block."""
    found: list[Block] = []
    for caption, names in BLOCKS.items():
        mine = [row for row in rows if row.quantity in names and row.status == "estimated"]
        cells = [
            (row.quantity, " ".join(filter(None, (row.axis, str(row.case)))), _value(row), row.unit) for row in mine
        ]
        found += [Table(HEADS, cells, caption, (2,))] if cells else []
        left = [row for row in rows if row.quantity in names and row.status == "not_estimated"]
        found += [f"  not estimated: {row.quantity} ({row.case}): {row.reason}" for row in left]
    return tuple(found)


def _value(row: Row) -> str:
    if row.u is None:
        digits = ROUGH if row.quantity in PREDICTED else DIGITS
        return "-" if row.value is None else f"{row.value:.{digits}g}"
    return with_uncertainty(row.value, row.u)
