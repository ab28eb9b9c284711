"""Bands in which a run does not have the shape of its profile: a notch that is missing, one that nobody asked for.

Lines that follow each other on one side of the profile, the median over all lines taken off, make a band where their
mean is `DEEP` or more and is not made by chance: neighbours of a Hann window share a part, so that k lines count as
``k / 1.5``. Above the profile, where the profile itself lies below the straight line between its surroundings, a notch
of it is missing. Below the profile, a response was limited, or the table could not follow.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from ...core.show.rounding import number
from ...signals.vibration.profile import decibels

if TYPE_CHECKING:
    from ...core.estimate import Array
    from .reduction import Result

LINE, DEEP = 1.0, 2.0  # deviation of a line, and of a band on the mean, from which it counts [dB]
OVERLAP = 1.5  # lines that count as one
SIDE = 0.25  # octaves beside a band, where the profile's surroundings are
OWN = 0.5  # level of a run that is told with its bands, as they lie so much elsewhere without it [dB]
CARVED = 2.0  # of the profile, below its surroundings: a notch [dB]
STANDS_OUT = 3.0  # a response in a band, over its surroundings [dB]


@dataclass(frozen=True)
class Departure:
    """A band on one side of the profile.

    Parameters
    ----------
    low, high : float
        Ends [Hz].
    mean, most : float
        Deviation on the mean, and of the line that is furthest away, against the level of the run [dB].
    carved : float
        How far the profile lies below its surroundings there [dB].
    open_low, open_high : bool
        Whether it reaches to the lowest, the highest line.
    level : float
        Of the run against the profile, median over all lines: it is taken off [dB].
    """

    low: float
    high: float
    mean: float
    most: float
    carved: float
    open_low: bool
    open_high: bool
    level: float

    def __str__(self) -> str:
        """Return where, and how much."""
        side = "above" if self.mean > 0.0 else "below"
        own = f" moved by {number(self.level, 2)} dB to the run's own level" if abs(self.level) > OWN else ""
        size = f"{number(abs(self.mean), 2)} dB {side} the profile{own} ({number(abs(self.most), 2)} dB at most)"
        return f"from {number(self.low, 4)} to {number(self.high, 4)} Hz the control lies {size}"


def departures(result: Result, chance: float) -> Iterator[Departure]:
    """Yield the bands, by a chance of one that is none."""
    one = result.deviation
    level = float(np.median(one.value))
    away = one.value - level
    scatter = np.hypot(np.sqrt(one.u_value**2 - one.u**2), 0.0)
    z = -float(special.ndtri(0.5 * chance / len(one)))
    start = 0
    for stop in range(1, len(away) + 1):
        same = stop < len(away) and np.sign(away[stop]) == np.sign(away[start]) and abs(away[stop]) > LINE
        if same and abs(away[start]) > LINE:
            continue
        own, u = away[start:stop], scatter[start:stop]
        mean = float(np.mean(own))
        if abs(mean) > DEEP and abs(mean) > z * float(np.mean(u)) * math.sqrt(OVERLAP / len(own)):
            at = int(np.argmax(np.abs(own)))
            low, high = float(one.low[start]), float(one.high[stop - 1])
            carved = _carved(result, low, high)
            yield Departure(low, high, mean, float(own[at]), carved, start == 0, stop == len(away), level)
        start = stop


def _carved(result: Result, low: float, high: float) -> float:
    """Return how far the profile lies below the straight line between its surroundings, at its lowest [dB]."""
    beside = np.array([low * 2.0**-SIDE, high * 2.0**SIDE])
    levels = result.target.at(beside)
    if not np.all(levels > 0.0):
        return 0.0
    f = np.geomspace(low, high, 50)
    line = np.exp(np.interp(np.log(f), np.log(beside), np.log(levels)))
    return float(np.max(decibels(line) - decibels(result.target.at(f))))


def standing_out(result: Result, one: Departure) -> list[str]:
    """Return the responses that are largest, over the control, inside a band."""
    f = result.spectra.frequency
    count = len(result.readings.controls)
    inside = (f >= one.low) & (f <= one.high)
    beside = ~inside & (f >= one.low * 2.0**-SIDE) & (f <= one.high * 2.0**SIDE)
    if not inside.any() or not beside.any():
        return []
    control, _ = result.controlled(result.spectra)
    ratio: Array = result.spectra.density[:, count:] / control[:, np.newaxis]
    over = decibels(np.max(ratio[inside], axis=0) / np.median(ratio[beside], axis=0))
    names = [each.column for each in result.channels[count:]]
    return [name for name, size in zip(names, over.tolist(), strict=True) if size > STANDS_OUT]


__all__ = ["CARVED", "Departure", "departures", "standing_out"]
