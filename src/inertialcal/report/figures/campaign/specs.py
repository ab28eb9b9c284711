"""Figures of a whole campaign: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ....core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.campaign."

FIGURES = (
    FigureSpec(
        "compensated",
        DRAWN + "compensated",
        "Errors on readings held out, raw and compensated, at each applied input.{note}",
        curves={"compensated": "compensated {axis}"},
        order=0,
        place="top",
        top=10,
    ),
    FigureSpec(
        "matrix",
        DRAWN + "matrix",
        "How the matrix differs from the identity: scale factor errors on the diagonal, misalignments beside it; row ="
        " the sensor that reads, column = the axis that moves.",
        order=900,
        place="model",
    ),
    FigureSpec(
        "budget",
        DRAWN + "budget",
        "Share of each source in the variance of each quantity.",
        order=910,
        place="budgets",
    ),
)
