"""Drift of a record at rest beyond its slow noise.

Tested on block means: a smooth curve (a cubic) whose rise from the first to the last block is larger than white and
1/f noise of the same record explain (``slow_noise``: restricted maximum likelihood, which does not see the curve), by
Student's t. In white noise false alarms are as rare as stated; in 1/f noise alone, whose size so few contrasts tell
badly, about one or two in a hundred records were seen. A random walk of the rate is told as drift too: from one record
nobody can tell them apart. Where more than half of the rise falls in the first third, warm-up is the likely cause.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.rounding import number
from ..statistics.slow_noise import SlowNoise, blocks_of, slow_noise

DEGREE = 3  # of the curve
BLOCKS = 64  # of which drift is told
FILLED = 0.5  # part of a block that must have values
EARLY = 0.5  # of the rise, in the first third, from which warm-up is named
FALSE_ALARM = 1e-3  # of drift, an axis


@dataclass(frozen=True)
class Drift:
    """A smooth curve through one axis.

    Parameters
    ----------
    axis : int
        Which.
    rise, u : float
        From the first to the last block, and its standard uncertainty from white and 1/f noise [unit].
    chance : float
        Probability that these noises show such a rise.
    early : float
        Part of the rise that falls in the first third.
    """

    axis: int
    rise: float
    u: float
    chance: float
    early: float

    @property
    def found(self) -> bool:
        """Whether it is more than noise."""
        return self.chance < FALSE_ALARM

    def remark(self, name: str) -> Remark:
        """Return what is said of it, under the name of its axis."""
        warm = ", most of it early: the sensor warms up" if self.early > EARLY else ""
        what = f"{name}: drifts by {number(self.rise, 3)} over the record, more than its slow noise explains{warm}"
        do = "Cut the warm-up, or read slow terms from a Hadamard deviation"
        return Remark("warm_up" if warm else "drift", "warning", what, do=do)


def drift_of(x: Array, axis: int, interval: float) -> tuple[Drift, ...]:
    """Return the curve through the block means of one axis; nothing where there are too few, or they do not scatter.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Evenly spaced, NaN where a sample is missing.
    axis : int
        Which.
    interval : float
        From sample to sample [s].
    """
    size = len(x) // BLOCKS
    if size < 1:
        return ()
    cut = x[: size * BLOCKS].reshape(BLOCKS, size)
    good = np.isfinite(cut)
    kept = good.sum(axis=1) >= FILLED * size
    means = np.where(good, cut, 0.0).sum(axis=1)[kept] / good.sum(axis=1)[kept]
    place = (np.arange(BLOCKS)[kept] + 0.5) / BLOCKS
    design = np.polynomial.legendre.legvander(2.0 * place - 1.0, DEGREE)
    try:
        blocks = blocks_of(place * BLOCKS * size * interval, size * interval, design)
        noise = slow_noise(means, blocks)
    except DataError:
        return ()
    third = int(np.argmin(np.abs(place - 1.0 / 3.0)))
    curve = design @ np.linalg.pinv(design)  # means to the curve through them
    weights = curve[-1] - curve[0]
    rise, u, dof = float(weights @ means), *_uncertainty(noise, weights)
    chance = 2.0 * float(special.stdtr(dof, -abs(rise) / u) if np.isfinite(dof) else special.ndtr(-abs(rise) / u))
    early = float((curve[third] - curve[0]) @ means) / rise if rise else 0.0
    return (Drift(axis, rise, u, chance, early),)


def _uncertainty(noise: SlowNoise, weights: Array) -> tuple[float, float]:
    """Return the standard uncertainty of a contrast and its degrees of freedom, never less than of its white noise."""
    variance, dof = noise.variance(weights)
    white = noise.white * float(weights @ weights) / (2.0 * noise.blocks.length)
    if variance < white:  # flicker came out negative, as it may where there is none
        variance, dof = white, float(len(weights) - DEGREE - 1)
    return float(np.sqrt(variance)), dof
