"""Figures of an alignment: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.alignment."

FIGURES = (
    FigureSpec(
        "alignment_rates",
        DRAWN + "rates",
        "What the gyros read of the level part of the rate of the earth, position by position, and the circle that it"
        " must lie on.",
        curves={"alignment_rates": "level rate by position"},
        order=670,
        top=130,
    ),
    FigureSpec(
        "alignment_forming",
        DRAWN + "forming",
        "The heading from the first part of each position, over the length of this part.",
        curves={"alignment_forming": "heading by time"},
        order=675,
        rank=1,
    ),
)
