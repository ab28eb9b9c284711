"""Figures of a sine survey: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

FIGURES = (
    FigureSpec(
        "transmissibility",
        "inertialcal.report.figures.sine_survey.transmissibility",
        "Transmissibility of {axis}: as the modes give it (line), as the tracking filter reads it (dots), and as"
        " an earlier survey has it, where it is set against one (dashed).",
        curves={"transmissibility": "transmissibility {axis}", "transmissibility_tracked": "tracked {axis}"},
        order=520,
        top=95,
    ),
)
