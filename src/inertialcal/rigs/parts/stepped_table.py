"""Motion of a table that steps through set rates: dwells at a rate, linear ramps between.

Angles and rates are positive right-handed about the axis of the table; the angle is zero where a recording begins.
A logger saves the mean over a window of ``averaging`` seconds every ``interval`` seconds, the first window at the
start.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.estimate import Array


@dataclass(frozen=True, eq=False)
class Motion:
    """What the table does in each averaging window; all of shape (n,).

    Parameters
    ----------
    start : ndarray
        Start of the window, from the start of the recording [s].
    rate : ndarray
        Mean rate over the window [rad/s].
    angle : ndarray
        At the start of the window [rad].
    turned : ndarray
        From start to end of the window [rad].
    dwell : ndarray of int64
        Which dwell the window begins in, or which it ramps to.
    """

    start: Array
    rate: Array
    angle: Array
    turned: Array
    dwell: NDArray[np.int64]


def motion(rates: ArrayLike, dwell: float, ramps: ArrayLike, interval: float, averaging: float) -> Motion:
    """Return the motion of a table that goes through set rates.

    Parameters
    ----------
    rates : array_like, shape (d,)
        Of the dwells, in order [rad/s].
    dwell : float
        Length of each [s].
    ramps : array_like, shape (d - 1,)
        Time from each rate to the next [s].
    interval, averaging : float
        Time from save to save, and length of the window that is averaged [s].
    """
    held = np.repeat(np.asarray(rates, dtype=np.float64), 2)
    begin = np.concatenate([[0.0], np.cumsum(dwell + np.asarray(ramps, dtype=np.float64))])
    knots = np.column_stack([begin, begin + dwell]).ravel()  # start and end of each dwell in turn
    start = np.asarray(interval * np.arange(int((knots[-1] - averaging) / interval) + 1), dtype=np.float64)
    angle = _angle(knots, held, start)
    turned = _angle(knots, held, start + averaging) - angle
    within = np.searchsorted(knots[1::2], start, side="right")
    return Motion(start, turned / averaging, angle, turned, np.minimum(within, len(begin) - 1))


def _angle(knots: Array, rates: Array, at: Array) -> Array:
    """Angle at given times of a rate that is linear between knots, shape (n,) [rad]."""
    passed = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(knots))])
    before = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    since = at - knots[before]
    return np.asarray(passed[before] + 0.5 * (rates[before] + np.interp(at, knots, rates)) * since)
