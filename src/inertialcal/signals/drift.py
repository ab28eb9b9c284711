"""Drift of a record at rest beyond its slow noise.

Tested on block means: a smooth curve (a cubic) whose rise from the first to the last block is larger than the noise of
the same record explains, by Student's t. Of noise there are two models, white with 1/f noise and white with a random
walk. How much of it is slow is told by contrasts that no polynomial of degree 4 enters (restricted likelihood [1]_),
and told badly: the rise must be too large for every share that these contrasts leave possible at 70 %, in both models
(the largest chance over a confidence set, after [2]_). So a random walk of the rate is no drift: only what is smoother
than it, as warm-up and temperature are. False alarms are one in a hundred at most, in the worst random walk
(simulated), and fewer elsewhere. Where more than half of the rise falls in the first third, warm-up is likely.

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted maximum likelihood).
.. [2] R. L. Berger and D. D. Boos, J. Am. Stat. Assoc. 89 (1994) 1012 (P values over a confidence set).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from scipy import special

from ..core.batches import SIZE, batches
from ..core.estimate import Array
from ..core.remarks import Remark
from ..core.show.rounding import number
from ..statistics.slow_noise import flicker_covariance, walk_covariance
from .time.samples import Flags

DEGREE = 3  # of the curve
SMOOTH = 4  # of what is too smooth to tell of noise
LEAST = 16  # contrasts beyond, from which noise is told
ROUNDING = 1e-15  # of a contrast of equal means, relative to their size and number
SHARES = np.geomspace(1e-3, 1e9, 121)  # of slow noise, in its largest contrast, over that of white noise
POSSIBLE = 0.5 * float(special.chdtri(1.0, 0.3))  # rise of the cost within which a share is possible
BLOCKS = 64  # of which drift is told
FILLED = 0.5  # part of a block that must have values
EARLY = 0.5  # of the rise, in the first third, from which warm-up is named
FALSE_ALARM = 0.01  # of drift, an axis


@dataclass(frozen=True)
class Drift:
    """A smooth curve through one axis."""

    axis: int  # which
    # rise, u: from the first to the last block, and its standard uncertainty from noise, rather too large than too
    # small [unit]
    rise: float
    u: float
    chance: float  # probability that noise shows such a rise
    early: float  # part of the rise that falls in the first third

    @property
    def significant(self) -> bool:
        """Whether it is more than noise."""
        return self.chance < FALSE_ALARM

    @property
    def warms(self) -> bool:
        """Whether most of it falls early."""
        return self.early > EARLY

    def remark(self, name: str, times: float = 1.0, unit: str = "", early: str = "the start") -> Remark:
        """Return what is said of it.

        Parameters
        ----------
        name : str
            Of the axis.
        times, unit : float, str
            Unit in which the rise is said, and how many there are in one of the samples.
        early : str
            How much to leave out of a warm-up.
        """
        rise = f"{number(float(number(self.rise * times, 3)))} {unit}".rstrip()  # -1430, not -1.43e+03
        what = f"{name}: drifts by {rise} over the record, more than its slow noise can explain"
        if self.warms:
            do = f"Leave the warm-up out, say {early}, and compare"
            return Remark("warm_up", "warning", f"{what}, most of it early: the sensor warms up", do=do)
        do = "Slow terms may be drift: check the temperature, or use a Hadamard deviation"
        return Remark("drift", "warning", what, do=do)


def drift_of(x: Array, axis: int, interval: float) -> tuple[Drift, ...]:
    """Return the curve through the block means of one axis; nothing where there are too few, or they do not scatter.

    ``x`` (n,) is evenly spaced, NaN where a sample is missing.
    """
    size = len(x) // BLOCKS
    if size < 1:
        return ()
    from ._kernels import fill_sums_of_blocks  # noqa: PLC0415 - numba starts slowly

    means = np.empty(BLOCKS)
    if BLOCKS * size <= SIZE and x.dtype == np.float64 and fill_sums_of_blocks(x, size, means):
        return _drifts(means[None] / size, *_whole_blocks(), axis)[0]
    means, kept = _block_means(x, size)
    if len(means) - SMOOTH - 1 < LEAST:
        return ()
    return _drifts(means[None], _blocks(kept.tobytes()), _slow_noise(kept.tobytes()), axis)[0]


def drifts_of(series: Sequence[Array], interval: float) -> list[tuple[Drift, ...]]:
    """Return the curve through each of many records of one length, shape (n,), as `drift_of` finds it."""
    from ._kernels import fill_sums_of_blocks  # noqa: PLC0415 - numba starts slowly

    size = len(series[0]) // BLOCKS
    if not 0 < BLOCKS * size <= SIZE:
        return [drift_of(x, 0, interval) for x in series]
    sums = np.empty((len(series), BLOCKS))
    whole = [x.dtype == np.float64 and fill_sums_of_blocks(x, size, own) for x, own in zip(series, sums, strict=True)]
    if not all(whole):
        return [drift_of(x, 0, interval) for x in series]
    return _drifts(sums / size, *_whole_blocks(), 0)


def _drifts(means: Array, blocks: _Blocks, models: tuple[_Slow, ...], axis: int) -> list[tuple[Drift, ...]]:
    """Return the curve through the block means of each record, shape (records, blocks)."""
    from ._kernels import explained  # noqa: PLC0415 - numba starts slowly

    left = ((means @ blocks.rest) ** 2).sum(axis=1)
    scatters = left > (ROUNDING * means.shape[1]) ** 2 * (means * means).sum(axis=1)
    rise, early = ((means * one).sum(axis=1) for one in (blocks.weights, blocks.early))
    found = [
        [explained(own, one.modes, one.shape, one.logs, one.rise, POSSIBLE) for one in models] if clear else []
        for own, clear in zip(means, scatters.tolist(), strict=True)
    ]
    most = np.array([max(one[2] for one in own) if own else np.nan for own in found])
    chance = 2.0 * special.stdtr(len(blocks.rest.T), -np.abs(rise) / most)
    return [
        (Drift(axis, whole, min(own)[1], likely, third / whole if whole else 0.0),) if own else ()
        for own, whole, likely, third in zip(found, rise.tolist(), chance.tolist(), early.tolist(), strict=True)
    ]


def _block_means(x: Array, size: int) -> tuple[Array, Flags]:
    """Return the means of the blocks that are filled, and which are."""
    count, total = np.zeros((2, BLOCKS))
    many = max(SIZE // size, 1)  # blocks that are summed together
    for b in range(0, BLOCKS, many):
        own = slice(b, min(b + many, BLOCKS))
        rows = x[own.start * size : own.stop * size].reshape(-1, size)
        for first, stop in batches(rows.T):
            part = rows[:, first:stop]
            with np.errstate(over="ignore", invalid="ignore"):
                sums, there = np.sum(part, axis=1), np.full(len(part), stop - first)
            if not np.isfinite(sums).all():
                good = np.isfinite(part)
                sums, there = np.sum(np.where(good, part, 0.0), axis=1), np.count_nonzero(good, axis=1)
            count[own] += there
            total[own] += sums
    kept = count >= FILLED * size
    return total[kept] / count[kept], kept


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Which blocks are kept: what a smooth curve leaves of their means, and how it rises, in all and in a third."""

    place: Array
    rest: Array
    weights: Array  # of the means in the rise of the curve
    early: Array  # in that of the first third


@lru_cache(8)
def _blocks(kept: bytes) -> _Blocks:
    """Return what hangs on the blocks that are kept alone, all in most records; not to be changed."""
    place = (np.flatnonzero(np.frombuffer(kept, dtype=bool)) + 0.5) / BLOCKS
    smooth = np.polynomial.legendre.legvander(2.0 * place - 1.0, SMOOTH)
    design = smooth[:, : DEGREE + 1]
    rest = np.linalg.qr(smooth, mode="complete")[0][:, SMOOTH + 1 :]
    curve = design @ np.linalg.pinv(design)  # means to the curve through them
    third = int(np.argmin(np.abs(place - 1.0 / 3.0)))
    return _Blocks(place, rest, curve[-1] - curve[0], curve[third] - curve[0])


@dataclass(frozen=True, eq=False)
class _Slow:
    """White noise with shares of slow noise, in block means: what a smooth curve leaves of it as independent modes.

    ``shape``, (modes, shares): variance of each mode over that of white noise, the sum of its logarithms (shares,), and
    the variance of the rise (shares,) over the same.
    """

    modes: Array
    shape: Array
    logs: Array
    rise: Array


@lru_cache(8)
def _slow_noise(kept: bytes) -> tuple[_Slow, ...]:
    """Return flicker and random walk of the blocks that are kept, all in most records."""
    blocks = _blocks(kept)
    place, rest = blocks.place, blocks.rest
    found = []
    for covariance in (flicker_covariance(place, 1.0 / BLOCKS), walk_covariance(place, 1.0 / BLOCKS)):
        sizes, axes = np.linalg.eigh(rest.T @ covariance @ rest)
        share = np.concatenate([[0.0], SHARES]) / sizes.max()
        shape = 1.0 + np.maximum(sizes, 0.0)[:, None] * share
        weights = blocks.weights
        slow = share * max(float(weights @ covariance @ weights), 0.0)
        modes = np.ascontiguousarray(axes.T @ rest.T)
        found.append(_Slow(modes, shape, np.sum(np.log(shape), axis=0), weights @ weights + slow))
    return tuple(found)


@cache
def _whole_blocks() -> tuple[_Blocks, tuple[_Slow, ...]]:
    """Return both where all blocks are kept."""
    kept = np.ones(BLOCKS, dtype=bool).tobytes()
    return _blocks(kept), _slow_noise(kept)
