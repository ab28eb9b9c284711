"""Figures of positions and rotations: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.positions."

FIGURES = (
    FigureSpec(
        "positions_residuals",
        DRAWN + "positions_residuals",
        "What each position leaves, with it in the fit and from the fit without it.",
        curves={"positions": "positions {axis} {of}"},
        order=600,
        top=80,
        rank=1,
    ),
    FigureSpec(
        "positions_sphere",
        DRAWN + "positions_sphere",
        "Where up was in each position, seen from the body, on the whole sphere of directions: equal areas, z at the"
        " top, x in the middle; larger marks have larger residuals.",
        curves={"positions": "positions {axis} {of}"},
        order=610,
        rank=1,
    ),
    FigureSpec(
        "transitions",
        DRAWN + "transitions",
        "Where the gyros carry gravity to in each rotation, against where the accelerometers then find it.",
        curves={"transitions": "transitions {axis} {of}"},
        order=620,
        top=70,
        rank=1,
    ),
)
