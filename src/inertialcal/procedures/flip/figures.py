"""Figures of the flip: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.flip."

FIGURES = (
    FigureSpec(
        "side_by_side",
        DRAWN + "side_by_side",
        "What two ground models leave of the bias in orbit, and their difference, with 95 % intervals; strokes are"
        " single flips.",
        order=200,
    ),
    FigureSpec(
        "flip",
        DRAWN + "flip",
        "{note}",
        curves={"flip_dwells": "flip_dwells {axis}", "quiet": "quiet {axis}"},
        order=210,
        top=40,
    ),
)
