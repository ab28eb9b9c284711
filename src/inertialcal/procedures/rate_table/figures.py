"""Figures of the rate table: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.rate_table."

FIGURES = (
    FigureSpec(
        "input_output",
        DRAWN + "input_output",
        "Reading of {axis} against the applied input, and residuals of the fitted line.",
        curves={"input_output": "input_output {axis}"},
        order=100,
        top=30,
    ),
    FigureSpec(
        "rate_error",
        DRAWN + "rate_error",
        "Error of {axis} against the applied rate{note}.",
        curves={"rate_error": "rate_error {axis}"},
        order=110,
        top=20,
    ),
    FigureSpec(
        "linearity",
        DRAWN + "linearity",
        "Deviation of {axis} from the best straight line, in percent of the largest rate.",
        curves={"linearity": "linearity {axis}"},
        order=115,
        rank=1,
    ),
    FigureSpec(
        "dwells",
        DRAWN + "dwells",
        "The dwells found in one recording with {axis} turned.{note}",
        curves={"dwells": "dwells {axis}", "trace": "trace {axis}"},
        order=120,
        rank=2,
        most=1,
    ),
)
