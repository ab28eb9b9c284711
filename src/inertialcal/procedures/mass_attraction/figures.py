"""Figures of a moved mass and of its plan: data, caption and place in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.mass_attraction."

FIGURES = (
    FigureSpec(
        "mass_runs",
        DRAWN + "mass_runs",
        "Scale factor of each run with the 95 % interval from its noise, of all runs (line, band), and as published.",
        curves={"mass_runs": "mass runs"},
        order=400,
        top=60,
    ),
    FigureSpec(
        "mass_series",
        DRAWN + "mass_series",
        "One run: readings with their drift, then without drift, with the line of the drive.",
        curves={"mass_series": "mass series"},
        order=410,
        most=1,
    ),
    FigureSpec(
        "mass_line",
        DRAWN + "mass_line",
        "The line of the drive and the lines next to it; below, autocorrelation over lag.",
        curves={"mass_spectrum": "mass spectrum", "mass_correlation": "mass correlation"},
        order=420,
        most=1,
    ),
    *(
        FigureSpec(name, DRAWN + name, curves={name: ""}, order=800 + number, place="")
        for number, name in enumerate(
            ("mass_body", "mass_field", "mass_growth", "proof_mass", "cube_as_point", "mass_forecast")
        )
    ),
)
