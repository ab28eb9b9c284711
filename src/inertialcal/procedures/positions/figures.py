"""Figures of positions and rotations: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.positions."

FIGURES = (
    FigureSpec(
        "positions_residuals",
        DRAWN + "positions_residuals",
        "Residual of each position, with it in the fit and from a fit without it.",
        curves={"positions": "positions {axis} {of}"},
        order=600,
        top=80,
        rank=1,
    ),
    FigureSpec(
        "positions_sphere",
        DRAWN + "positions_sphere",
        "Direction of up in each position, in body axes, on an equal-area map: z at the top, x in the middle; larger"
        " marks have larger residuals.",
        curves={"positions": "positions {axis} {of}"},
        order=610,
        rank=1,
    ),
    FigureSpec(
        "transitions",
        DRAWN + "transitions",
        "Angle between gravity carried by the gyros through each rotation and gravity found by the accelerometers after"
        " it.",
        curves={"transitions": "transitions {axis} {of}"},
        order=620,
        top=70,
        rank=1,
    ),
)
