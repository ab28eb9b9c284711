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
    FigureSpec(
        "lot_distribution",
        "inertialcal.report.figures.lots.distribution",
        "Units of the lot by value, with the limits; the line is the population without what the tests scatter.",
        curves={"lot_distribution": "{of}, units", "lot_population": "{of}, population"},
        order=842,
        place="",
    ),
    FigureSpec(
        "lot_stations",
        "inertialcal.report.figures.lots.levels",
        "Means of the units of each station less those of the others, with what standards and units allow.",
        curves={"lot_stations": "{of}, stations"},
        order=843,
        place="",
    ),
    FigureSpec(
        "lot_along",
        "inertialcal.report.figures.lots.along",
        "Means of units that follow each other along the lot, with the middle 90 % of the units.",
        curves={"lot_along": "{of}, along the lot"},
        order=844,
        place="",
    ),
    FigureSpec(
        "lot_distance",
        "inertialcal.report.figures.lots.distance",
        "How far each unit lies from the rest on all parameters together, in standard deviations.",
        curves={"lot_distance": "distances of units"},
        order=845,
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
