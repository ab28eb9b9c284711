"""Figures of the environment: data, caption and place in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.microgravity."

FIGURES = (
    FigureSpec(
        "microgravity_bands",
        DRAWN + "bands",
        "Root mean square of each third of an octave over the record with its 95 % interval, and between which levels"
        " its blocks lie; line: the requirement, where one was given.",
        curves={"microgravity_bands": "bands of {axis}"},
        order=640,
        top=130,
    ),
    FigureSpec(
        "microgravity_intervals",
        DRAWN + "intervals",
        "Least and largest value of each interval of time, and its mean. No peak is lost where intervals are joined.",
        curves={"microgravity_intervals": "intervals of {axis}"},
        order=645,
        rank=1,
    ),
    FigureSpec(
        "microgravity_spectrogram",
        DRAWN + "spectrogram",
        "Density of all axes together over time and frequency.",
        curves={"microgravity_spectrogram": "spectrogram"},
        order=650,
        rank=2,
    ),
    FigureSpec(
        "microgravity_cumulative",
        DRAWN + "cumulative",
        "Root mean square of all frequencies up to each. A step is a line of the spectrum: a pump, a fan.",
        curves={"microgravity_cumulative": "cumulative level of {axis}"},
        order=655,
        rank=3,
    ),
    FigureSpec(
        "microgravity_slow",
        DRAWN + "slow",
        "Slow acceleration: mean of each block, and of each orbit.",
        curves={"microgravity_slow": "slow acceleration", "microgravity_orbits": "means of orbits"},
        order=660,
        rank=4,
    ),
)
