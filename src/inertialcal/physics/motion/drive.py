"""Drives of a moved mass: where it dwells, and what the sensor is given.

``sine`` dwells at middle, maximum, middle, minimum, as Reinel's mass did: half of the dwells say nothing of the
amplitude. ``square`` and ``ABAB`` dwell at maximum and minimum only; ``square`` stays two dwells at each, so that its
period is that of the sine, ``ABAB`` one, so that its line lies highest above slow noise.

The middle is where the field is the mean of both ends, not where the position is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .travel import Travel, Window, position_of

Kind = Literal["sine", "square", "ABAB"]
ORDER: dict[str, tuple[int, ...]] = {"sine": (0, 1, 0, -1), "square": (1, 1, -1, -1), "ABAB": (1, -1)}


@dataclass(frozen=True, eq=False)
class Drive:
    """One cycle of positions."""

    kind: str  # name of the drive
    positions: Array  # of each dwell [m], shape (dwells,)
    fields: Array  # there, shape (dwells,)

    @property
    def amplitude(self) -> float:
        """Half of the difference of largest and smallest field."""
        return float(np.ptp(self.fields) / 2.0)

    @property
    def mean(self) -> float:
        """Mean of both."""
        return float((np.max(self.fields) + np.min(self.fields)) / 2.0)


def drive(travel: Travel, window: Window, kind: Kind) -> Drive:
    """Return the dwells of a cycle.

    Parameters
    ----------
    travel : Travel
        Field against position.
    window : Window
        Between whose ends the mass moves.
    kind : {"sine", "square", "ABAB"}
        Which drive.

    Raises
    ------
    DataError
        If the drive has no such name, or the window lies outside of the travel.
    """
    if kind not in ORDER:
        raise DataError(f"drive {kind!r} is not known: {', '.join(ORDER)}", code="unknown_drive")
    ends = travel.at([window.start, window.end])
    high, low = (window.start, window.end) if ends[0] >= ends[1] else (window.end, window.start)
    places = {1: high, -1: low}
    if 0 in ORDER[kind]:
        places[0] = position_of(travel, float(ends.mean()), (window.start, window.end))
    positions = np.array([places[step] for step in ORDER[kind]])
    return Drive(kind, positions, travel.at(positions))


def sine_of_position(window: Window, samples: int) -> Array:
    """Return positions over one period of a sinusoidal motion, shape (samples,) [m]; from the middle to the start."""
    phase = 2.0 * np.pi * np.arange(samples) / samples
    positions: Array = (window.start + window.end) / 2.0 + (window.start - window.end) / 2.0 * np.sin(phase)
    return positions


def harmonics(travel: Travel, positions: Array, count: int = 5) -> Array:
    """Return the amplitudes of the first harmonics of the field over one period of positions.

    Parameters
    ----------
    travel : Travel
        Field against position.
    positions : ndarray, shape (n,)
        Evenly in time over one period [m].
    count : int
        How many; fewer than half of n.

    Returns
    -------
    ndarray, shape (count,)
        From the first on, in the unit of the field.

    Raises
    ------
    DataError
        If there are not more than twice as many positions as harmonics.
    """
    if len(positions) <= 2 * count:
        raise DataError(
            f"{len(positions)} positions per period: {count} harmonics need {2 * count + 1}",
            code="too_few_positions",
        )
    lines = np.fft.rfft(travel.at(positions)) / len(positions)
    amplitudes: Array = 2.0 * np.abs(lines[1 : count + 1])
    return amplitudes
