"""Figures of the effects of vibration: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.vibration_effects."

FIGURES = (
    FigureSpec(
        "rectification",
        DRAWN + "rectification",
        "Mean reading of {axis} (axis of the gyro, axis of the vibration), even drift taken off, against the mean"
        " square of the control; 95 % intervals.",
        curves={"vibration_effect_means": "means of segments {axis}"},
        order=600,
        top=110,
    ),
    FigureSpec(
        "vibration_response",
        DRAWN + "response",
        "Response of {axis} (axis of the gyro, axis of the vibration) to the acceleration of the control, and its"
        " noise under vibration and at rest, in thirds of an octave.",
        curves={"vibration_effect_bands": "bands {axis}"},
        order=610,
        rank=1,
    ),
)
