"""Figures of bias over temperature: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.thermal."

FIGURES = (
    FigureSpec(
        "conditions",
        DRAWN + "conditions",
        "Bias over temperature in this test (line) and in the one it is compared with (dashed).",
        curves={"thermal_law": "thermal law {axis} {of}"},
        order=300,
        rank=1,
    ),
    FigureSpec(
        "overlay",
        DRAWN + "overlay",
        "Bias on hold-out power-ups: as read, and corrected with the polynomial.",
        curves={"overlay": "overlay {axis} {of}"},
        order=310,
        rank=1,
        first=True,
    ),
    FigureSpec(
        "thermal",
        DRAWN + "thermal",
        "Bias of {axis} over temperature with its polynomial, and the residuals: the gap between the paths.",
        curves={"thermal_cells": "thermal cells {axis} {of}", "thermal_law": "thermal law {axis} {of}"},
        order=320,
        top=50,
    ),
    FigureSpec(
        "thermal_order",
        DRAWN + "thermal_order",
        "Hold-out error by polynomial order; R2 of the fit itself always grows.",
        curves={"thermal_order": "thermal order {axis} {of}"},
        order=330,
        rank=1,
    ),
    FigureSpec(
        "start_up",
        DRAWN + "start_up",
        "Reading after power-up; hollow points are left out.",
        curves={"start_up": "start up {axis} {of}"},
        order=340,
        rank=1,
    ),
    FigureSpec(
        "reference_voltage",
        DRAWN + "reference_voltage",
        "Reference voltages of the converter over temperature, each minus its mean.",
        curves={"reference_voltage": "reference voltage {axis} {of}"},
        order=350,
        rank=1,
    ),
)
