"""Figures of a random vibration: what each is drawn from, where it stands in a report."""

from __future__ import annotations

from ...core.figure import FigureSpec

DRAWN = "inertialcal.report.figures.vibration."

FIGURES = (
    FigureSpec(
        "vibration",
        DRAWN + "control",
        "Spectral density of the control at full level, with its profile, the tolerance, and the 95 % band for all "
        "lines together.",
        curves={"vibration_control": "control {axis}"},
        order=400,
        top=70,
    ),
    FigureSpec(
        "vibration_channels",
        DRAWN + "channels",
        "Spectral density of each channel at full level.",
        curves={"vibration_channel": "channel {axis}"},
        order=405,
        rank=1,
    ),
    FigureSpec(
        "vibration_levels",
        DRAWN + "levels",
        "Level of the control over time, against full level.",
        curves={"vibration_levels": "level {axis}"},
        order=410,
        rank=1,
    ),
    FigureSpec(
        "vibration_bands",
        DRAWN + "bands",
        "Level by third of an octave, against the profile.",
        curves={"vibration_bands": "bands {axis}"},
        order=415,
        rank=2,
    ),
    FigureSpec(
        "vibration_profile",
        DRAWN + "profile",
        "Profile on logarithmic axes, with its slopes and overall level.",
        curves={"vibration_profile": "profile"},
        order=420,
        place="",
    ),
    FigureSpec(
        "vibration_plan",
        DRAWN + "plan",
        "Chance of a PASS over the duration of a run, for several resolutions.",
        curves={"vibration_plan": "plan {of}"},
        order=425,
        place="",
    ),
)
