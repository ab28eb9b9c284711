"""Figures of a test against a magnetometer: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.magnetometer_bias."

FIGURES = (
    FigureSpec(
        "magnetometer_bias_known",
        DRAWN + "known",
        "How well the bias of each axis is known by then: its standard uncertainty by the scatter of arcs so far,"
        " without what standards add.",
        curves={"magnetometer_bias_known": "uncertainty of the bias over time"},
        order=620,
        top=120,
    ),
    FigureSpec(
        "magnetometer_residuals",
        DRAWN + "residuals",
        "Magnitude of the field as read, bias taken off, less that of the model: mean and deviation of each arc.",
        curves={"magnetometer_residuals": "residuals of arcs"},
        order=625,
        rank=1,
    ),
)
