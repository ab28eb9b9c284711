"""Figures of a whole campaign: the data of each, and its place in a report."""

from __future__ import annotations

from ....core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.campaign."

FIGURES = (
    FigureSpec(
        "compensated",
        DRAWN + "compensated",
        "Error of hold-out readings, raw and compensated, against the applied input.{note}",
        curves={"compensated": "compensated {axis}"},
        order=0,
        place="top",
        top=10,
    ),
    FigureSpec(
        "changes",
        DRAWN + "changes",
        "What figures changed by since the earlier test, with 95 % intervals, in parts of what is allowed (shaded)."
        "{note}",
        order=290,
        top=30,
    ),
    FigureSpec(
        "save_intervals",
        DRAWN + "saves",
        "Time from one save to the next, and how often, over the recordings of the test that have late saves.{note}",
        curves={"save_intervals": "save intervals{record}"},
        rank=90,
        first=True,
    ),
    FigureSpec(
        "archive_history",
        "inertialcal.report.figures.archive.history",
        "Tests of the unit over the years with their 95 % intervals{note}.",
        curves={"archive_history": "{of}, tests", "archive_line": "{of}, line"},
        order=840,
        place="",
    ),
    FigureSpec(
        "archive_trend",
        "inertialcal.report.figures.archive.trend",
        "Units, or lots, in order of time, with limits of three standard deviations; below, their spread.",
        curves={"archive_trend": "{of}"},
        order=841,
        place="",
    ),
    FigureSpec("plan_time", DRAWN + "plan_time", curves={"plan_time": ""}, order=830, place=""),
    FigureSpec(
        "matrix",
        DRAWN + "matrix",
        "Deviation of the matrix from the identity: scale factor errors on the diagonal, misalignments off it; rows ="
        " sensors, columns = input axes.",
        order=900,
        place="model",
    ),
    FigureSpec(
        "budget",
        DRAWN + "budget",
        "Share of each source in the variance of each quantity.{note}",
        order=910,
        place="budgets",
    ),
)
