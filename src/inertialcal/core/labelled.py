"""Labelled parts of a recording: which samples were a position or a turn, and what somebody called them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class LabelledPart:
    """A part of a recording with its label: from one sample to before another, or in seconds of its time."""

    label: str  # ``"x_p"``, ``"x_rot"``
    start: float  # First: samples counted from 0, or [s]
    stop: float  # One past the last
    seconds: bool = False  # Which of both
    angle: float | None = None  # Of a turn, where it is said of this one [rad]


def labelled_csv(parts: Sequence[LabelledPart]) -> str:
    """Return labelled parts, counted in samples, as a table: ``section``, ``start``, ``end``, ``angle [deg]``."""
    rows = ["section,start,end,angle [deg]"]
    for part in parts:
        angle = "" if part.angle is None else f"{math.degrees(part.angle):.15g}"
        rows.append(f"{part.label},{part.start:.0f},{part.stop:.0f},{angle}")
    return "\n".join([*rows, ""])
