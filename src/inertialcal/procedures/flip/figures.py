"""Figures and tables of the flip: what each is made of, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec
from ...core.show.rows import Compared

DRAWN = "inertialcal.report.figures.flip."

COMPARED = Compared(
    "model_bias_error",
    "other_model_bias_error",
    "model_bias_error_change",
    "model_bias_error_reduction",
    "remaining bias errors of both ground models",
    "Two ground models side by side, in the same dwells: the remaining bias error of each, and their difference",
)
FIGURES = (
    FigureSpec(
        "side_by_side",
        DRAWN + "side_by_side",
        "Remaining bias errors of two ground models in orbit, and their difference, with 95 % intervals; strokes"
        " are single flips.",
        order=200,
    ),
    FigureSpec(
        "flip",
        DRAWN + "flip",
        "{note}",
        curves={"flip_dwells": "flip_dwells {axis}", "quiet": "quiet {axis}", "turns": "turns"},
        order=210,
        top=40,
    ),
)
