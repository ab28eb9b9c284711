"""Figures of bias over temperature: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.thermal."

FIGURES = (
    FigureSpec(
        "conditions",
        DRAWN + "conditions",
        "Bias over temperature in this test (line) and in the one it is set beside (dashed).",
        curves={"thermal_law": "thermal law {axis} {of}"},
        order=300,
        rank=1,
    ),
    FigureSpec(
        "overlay",
        DRAWN + "overlay",
        "Bias on power-ups that no polynomial was fitted to: as read, and after what was found is taken off.",
        curves={"overlay": "overlay {axis} {of}"},
        order=310,
        rank=1,
        first=True,
    ),
    FigureSpec(
        "thermal",
        DRAWN + "thermal",
        "Bias of {axis} over temperature with its polynomial, and what is left: the gap between the paths.",
        curves={"thermal_cells": "thermal cells {axis} {of}", "thermal_law": "thermal law {axis} {of}"},
        order=320,
        top=50,
    ),
    FigureSpec(
        "thermal_order",
        DRAWN + "thermal_order",
        "Error on what was held out, order by order: R2 of the fit itself would always grow.",
        curves={"thermal_order": "thermal order {axis} {of}"},
        order=330,
        rank=1,
    ),
    FigureSpec(
        "start_up",
        DRAWN + "start_up",
        "What the reading does after power-up, and what is left out for it (hollow).",
        curves={"start_up": "start up {axis} {of}"},
        order=340,
        rank=1,
    ),
    FigureSpec(
        "reference_voltage",
        DRAWN + "reference_voltage",
        "Reference voltages of the converter over temperature, each less its mean.",
        curves={"reference_voltage": "reference voltage {axis} {of}"},
        order=350,
        rank=1,
    ),
)
