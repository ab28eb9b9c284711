"""Amplitude from alternating differences of half periods: a check that needs no model of drift.

The record is cut into half periods of the drive; each gives ``u_j``, the mean of its readings weighted by the drive,
over the mean of the drive's square. Of half periods one after another the sums::

    sum over k = 0 ... n of C(n, k) u_(j+k) / 2^n

keep the amplitude and take out drift that is a polynomial of a degree below n: the drive changes its sign each time,
so that a level enters neighbours with opposite signs. Their mean over all j is the estimate. Half periods with a
missing sample are left out, with the sums that they are in.

References
----------
.. [1] H. E. Swanson and S. Schlamminger, Meas. Sci. Technol. 21 (2010) 115104, arXiv:1009.1894.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from .drive import Drive

ORDER = 2  # differences of three half periods
EVEN = 1e-3  # of a sample interval, by which samples may be off an even grid
ANTISYMMETRIC = 0.02  # of the drive's size, by which half periods may differ


def difference_weights(drive: Drive, order: int = ORDER) -> Array:
    """Return what the estimate weighs each reading with, shape (n,).

    Parameters
    ----------
    drive : Drive
        At the samples that there are.
    order : int
        n, 1 or more.

    Raises
    ------
    DataError
        ``no_half_periods`` if a half period is no whole number of samples, samples are not evenly spaced but for
        gaps, the drive does not just change its sign from one half period to the next, or no sum is complete.
    """
    size = _half_period(drive)
    at = np.round((drive.times - drive.times[0]) / drive.step).astype(np.int64)
    n = int(at[-1]) + 1
    count = n // size
    signal, there = np.zeros(n), np.zeros(n, dtype=np.bool_)
    signal[at], there[at] = drive.in_phase, True
    halves = signal[: count * size].reshape(count, size)
    complete = there[: count * size].reshape(count, size).all(axis=1)
    sums = np.convolve(complete, np.ones(order + 1), "valid") > order + 0.5
    if not sums.any():
        raise _impossible(f"no {order + 1} half periods in a row are complete")
    sign = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    pattern = _pattern(halves[complete] * sign[complete, None])
    binomial = special.comb(order, np.arange(order + 1)) / 2.0**order
    share = np.convolve(sums / sums.sum(), binomial)
    spread = np.zeros(n)
    spread[: count * size] = ((share * sign)[:, None] * pattern / (pattern @ pattern)).ravel()
    return np.asarray(spread[at])


def _half_period(drive: Drive) -> int:
    """Return the samples of a half period."""
    ticks = (drive.times - drive.times[0]) / drive.step
    size = 0.5 / (drive.frequency * drive.step)
    if np.abs(ticks - np.round(ticks)).max() > EVEN or round(size) < 1:
        raise _impossible("samples are not evenly spaced")
    if abs(size - round(size)) * drive.cycles * 2.0 > EVEN * len(ticks) or abs(size - round(size)) > EVEN:
        raise _impossible(f"a half period is {size:.6g} samples")
    return round(size)


def _pattern(halves: Array) -> Array:
    """Drive of a half period, its sign aside; every other half period is given with its sign changed."""
    mean = halves.mean(axis=0)
    if not np.abs(halves - mean).max() < ANTISYMMETRIC * np.abs(mean).max():
        raise _impossible("the drive does not just change its sign from one half period to the next")
    return np.asarray(mean)


def _impossible(why: str) -> DataError:
    return DataError("alternating differences cannot be formed", why=why, code="no_half_periods")
