"""Figures of a calibration of heads by others: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.heads."

FIGURES = (
    FigureSpec(
        "heads_gap",
        DRAWN + "gap",
        "What the fit leaves of the reading of a head less what the calibrated ones tell for its place, interval by"
        " interval.",
        curves={"heads_gap": "reading less what the others tell"},
        order=630,
        top=120,
    ),
    FigureSpec(
        "heads_places",
        DRAWN + "places",
        "What the place of a head costs: u of its bias by the noise of this record along the line of two calibrated"
        " heads.",
        curves={"heads_places": "uncertainty by place"},
        order=635,
        rank=1,
    ),
)
