"""Figures of a turned mass and of its plan: data, caption and place in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.turned_mass."

FIGURES = (
    FigureSpec(
        "turned_runs",
        DRAWN + "turned_runs",
        "Response of each run over the rate of its recoil, with its 95 % interval; line: attraction less recoil, as"
        " fitted to all runs. Where the line crosses zero, recoil and attraction cancel.",
        curves={"turned_runs": "runs of the turned mass"},
        order=430,
        top=62,
    ),
    FigureSpec(
        "turned_turn",
        DRAWN + "turned_turn",
        "One run over the angle of its mass: means of the readings without drift, with their 95 % intervals, and the"
        " harmonics that were fitted.",
        curves={"turned_turn": "turn of {record}"},
        order=440,
        most=2,
    ),
    FigureSpec(
        "turned_forecast",
        DRAWN + "turned_forecast",
        curves={"turned_null": "", "turned_planned": ""},
        order=820,
        place="",
    ),
)
