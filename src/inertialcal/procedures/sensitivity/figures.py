"""Figures of a sensitivity test: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.sensitivity."

FIGURES = (
    FigureSpec(
        "sensitivity",
        DRAWN + "sensitivity",
        "Bias against {note}, other terms taken off; the fit with its 95 % band.",
        curves={"sensitivity": "sensitivity {axis} {of}", "sensitivity_levels": "levels {axis} {of}"},
        order=320,
        top=60,
    ),
    FigureSpec(
        "sensitivity_pressure",
        DRAWN + "pressure_levels",
        "Bias at levels of pressure less that of the lowest, with 95 % intervals.",
        curves={"pressure_levels": "pressure {axis}"},
        order=322,
        top=58,
    ),
    FigureSpec(
        "sensitivity_residuals",
        DRAWN + "residuals",
        "What the fit leaves of each level, by power-up.",
        curves={"sensitivity_residuals": "residuals {axis}"},
        order=325,
        rank=1,
    ),
    FigureSpec(
        "sensitivity_warm_up",
        DRAWN + "warm_up",
        "Warm-up: power-ups less their settled levels, with the joint fit.",
        curves={"warm_up_joint": "warm-up {axis} {of}"},
        order=318,
        top=55,
    ),
)
