"""Whether a record at rest is fit for noise terms: bad segments and bumps, and drift beyond its slow noise.

*Bad segments* are what the one detector of still and moving stretches takes for a disturbance (``stillness``). Noise
terms fitted across them are wrong; ``RecordQuality.cleaned`` has NaN there, for estimators that allow gaps.

*Drift* is tested on block means: a smooth curve (a cubic) whose rise from the first to the last block is larger than
white and 1/f noise of the same record explain (``slow_noise``: restricted maximum likelihood, which does not see the
curve), by Student's t. In white noise false alarms are as rare as stated; in 1/f noise alone, whose size so few
contrasts tell badly, about one or two in a hundred records were seen. A random walk of the rate is told as drift too:
from one record nobody can tell them apart. Where more than half of the rise falls in the first third, warm-up is the
likely cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.rounding import number
from ..statistics.slow_noise import SlowNoise, blocks_of, slow_noise
from .stillness import Disturbance, judge

DEGREE = 3  # of the curve
BLOCKS = 64  # of which drift is told
FILLED = 0.5  # part of a block that must have values
EARLY = 0.5  # of the rise, in the first third, from which warm-up is named
FALSE_ALARM = 1e-3  # of drift, an axis


@dataclass(frozen=True)
class BadSegment:
    """A disturbance of one axis.

    Parameters
    ----------
    axis : int
        Which.
    first, last : int
        Samples of the record.
    start, stop : float
        The same since the first sample [s].
    peak : float
        Largest deviation from the level around, in standard deviations of the noise.
    """

    axis: int
    first: int
    last: int
    start: float
    stop: float
    peak: float


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


@dataclass(frozen=True, eq=False)
class RecordQuality:
    """What stands in the way of noise terms.

    Parameters
    ----------
    bad : tuple of BadSegment
        By axis and time.
    moving : tuple of int
        Axes that are not at rest at all.
    drifts : tuple of Drift
        Of the axes that could be tested.
    values : ndarray, shape (n, axes)
        The record.
    interval : float
        From sample to sample [s].
    """

    bad: tuple[BadSegment, ...]
    moving: tuple[int, ...]
    drifts: tuple[Drift, ...]
    values: Array
    interval: float

    def cleaned(self) -> Array:
        """Return the record with NaN in the bad segments, shape (n, axes)."""
        out = self.values.copy()
        for one in self.bad:
            out[one.first : one.last + 1, one.axis] = np.nan
        return out

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """One remark an axis and kind."""
        found = []
        for axis in range(self.values.shape[1]):
            bad = [one for one in self.bad if one.axis == axis]
            if axis in self.moving:
                what = f"axis {axis} is not at rest"
                do = "Noise terms need a record of a sensor that stands still"
                found.append(Remark("not_at_rest", "warning", what, do=do))
            if bad:
                worst = max(bad, key=lambda one: one.peak)
                lost = sum(one.last - one.first + 1 for one in bad) * self.interval
                what = (
                    f"axis {axis} is disturbed for {number(lost, 3)} s in all, by up to {number(worst.peak, 3)} "
                    "standard deviations of the noise"
                )
                do = "Leave it out, or record again undisturbed"
                where = f"{number(bad[0].start, 6)} s"
                found.append(Remark("disturbed", "warning", what, where, len(bad), do))
        for drift in self.drifts:
            if drift.found:
                warm = ", most of it early: the sensor warms up" if drift.early > EARLY else ""
                what = (
                    f"axis {drift.axis} drifts by {number(drift.rise, 3)} over the record, more than its slow noise "
                    f"explains{warm}"
                )
                do = "Cut the warm-up, or read slow terms from a Hadamard deviation"
                found.append(Remark("warm_up" if warm else "drift", "warning", what, do=do))
        return tuple(found)


def record_quality(x: NDArray[Any], interval: float, floor: float = 0.0) -> RecordQuality:
    """Look a record at rest through for bad segments and drift.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, axes)
        Evenly spaced samples of a rate or acceleration, NaN where one is missing.
    interval : float
        From sample to sample [s].
    floor : float
        Smallest standard deviation that the noise may have: the resolution step.

    Returns
    -------
    RecordQuality
        With remarks, and the record without its bad segments.

    Raises
    ------
    DataError
        If the record has another shape, or the interval is not positive.
    """
    values = np.asarray(x, dtype=np.float64)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or not values.shape[1]:
        raise DataError(f"a signal of shape {np.shape(x)}, need (n,) or (n, axes)", code="bad_shape")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")
    bad: list[BadSegment] = []
    moving: list[int] = []
    drifts: list[Drift] = []
    for axis in range(values.shape[1]):
        rows = np.flatnonzero(np.isfinite(values[:, axis]))
        judged = judge(np.ascontiguousarray(values[rows, axis]), floor)
        if judged is not None:
            bad += [_placed(one, axis, rows, interval) for one in judged.disturbances]
            moving += [] if judged.at_rest else [axis]
        left = values[:, axis].copy()
        for one in bad:
            if one.axis == axis:
                left[one.first : one.last + 1] = np.nan
        drifts += _drift(left, axis, interval)
    return RecordQuality(tuple(bad), tuple(moving), tuple(drifts), values, interval)


def _placed(one: Disturbance, axis: int, rows: NDArray[np.int64], interval: float) -> BadSegment:
    first, last = int(rows[one.first]), int(rows[one.last])
    return BadSegment(axis, first, last, first * interval, last * interval, one.peak)


def _drift(x: Array, axis: int, interval: float) -> list[Drift]:
    """Curve through the block means of one axis; nothing where there are too few, or they do not scatter."""
    size = len(x) // BLOCKS
    if size < 1:
        return []
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
        return []
    third = int(np.argmin(np.abs(place - 1.0 / 3.0)))
    curve = design @ np.linalg.pinv(design)  # means to the curve through them
    weights = curve[-1] - curve[0]
    rise, u, dof = float(weights @ means), *_uncertainty(noise, weights)
    chance = 2.0 * float(special.stdtr(dof, -abs(rise) / u) if np.isfinite(dof) else special.ndtr(-abs(rise) / u))
    early = float((curve[third] - curve[0]) @ means) / rise if rise else 0.0
    return [Drift(axis, rise, u, chance, early)]


def _uncertainty(noise: SlowNoise, weights: Array) -> tuple[float, float]:
    """Return the standard uncertainty of a contrast and its degrees of freedom, never less than of its white noise."""
    variance, dof = noise.variance(weights)
    white = noise.white * float(weights @ weights) / (2.0 * noise.blocks.length)
    if variance < white:  # flicker came out negative, as it may where there is none
        variance, dof = white, float(len(weights) - DEGREE - 1)
    return float(np.sqrt(variance)), dof
