"""Figures of a known drive in drift: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.sine."

FIGURES = (
    FigureSpec(
        "sine",
        DRAWN + "sine",
        "Readings of {axis} with their drift, what is left with the line of the drive, and that line among its"
        " neighbours.",
        curves={"sine_series": "sine series {axis}", "sine_lines": "sine lines {axis}"},
        order=500,
        top=100,
    ),
)
