"""Figures of a shifted ground model: data, caption and place in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.shifted_model."

FIGURES = (
    FigureSpec(
        "shifted_flights",
        DRAWN + "flights",
        "Shift of the bias from the ground model, flip by flip, with 95 % intervals; line and band: the new model, and"
        " where a flight to come will lie. Hollow: flights that were left out and predicted.",
        curves={"shifted_flights": "shifts of the flights", "shifted_trend": "shift of the new model over time"},
        order=450,
        top=64,
    ),
    FigureSpec(
        "shifted_temperature",
        DRAWN + "temperature",
        "Shift of the new model from the ground model over temperature, with the 95 % band for a flight to come;"
        " points: flips. The ground model is the line at zero.",
        curves={"shifted_temperature": "shift of the new model over temperature"},
        order=460,
    ),
)
