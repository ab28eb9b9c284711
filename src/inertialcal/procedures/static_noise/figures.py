"""Figures of noise at rest: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.static_noise."

FIGURES = (
    FigureSpec(
        "allan",
        DRAWN + "allan",
        "Deviation of {axis} over averaging time with 95 % intervals, and the terms fitted to it.",
        curves={
            "allan": "allan {axis}{record}",
            "allan_terms": "allan_terms {axis}",
            "allan_line": "allan_line {axis}",
        },
        order=700,
        top=90,
        partner="spectrum",
    ),
    FigureSpec(
        "spectrum",
        DRAWN + "spectrum",
        "Density of {axis} with 95 % intervals, and the terms that were fitted to its Allan deviation.",
        curves={"spectrum": "spectrum {axis}{record}"},
        order=710,
    ),
)
