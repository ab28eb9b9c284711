"""One window of a recording as a reading: mean, median, low-passed mean, sub-means of the published way.

The low-pass is a Butterworth filter of second order run forward and backward, so it has no delay (zero phase, 6 dB down
at its cut-off), on means of a hundredth of its period. It settles within one period of the cut-off, at both ends; these
are left out and counted, and a window that is no longer than both is refused.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996: ten subsets of 6 s, t-intervals at 95 and 99 %; low-pass at 0.01 Hz.
"""

from __future__ import annotations

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.intervals import coverage_factor

PROBABILITIES = (0.95, 0.99)
PER_PERIOD = 100  # means a period of the cut-off
ORDER = 2


def low_passed(seconds: Array, samples: Array, cutoff: float, interval: float) -> tuple[float, float]:
    """Return the mean of a window after a low-pass, and how much of it was left out for settling [s].

    Parameters
    ----------
    seconds, samples : ndarray, shape (n,)
        Stamps [s] and values; NaN is left out.
    cutoff : float
        Of the filter [Hz].
    interval : float
        From sample to sample [s].

    Raises
    ------
    DataError
        ``shorter_than_settling`` if the window is not longer than the settling at both ends.
    """
    from scipy import signal  # noqa: PLC0415 - heavy import, which commands on tables need not wait for

    settling = 1.0 / cutoff
    length = float(seconds[-1] - seconds[0]) + interval if len(seconds) else 0.0
    if not length > 2.0 * settling:
        what = f"a window of {length:.6g} s is not longer than the {2.0 * settling:.6g} s in which the low-pass settles"
        do = "Make the dwells longer, or give a higher plan.low_pass"
        raise DataError(what, why="nothing of it would be left", do=do, code="shorter_than_settling")
    step = max(settling / PER_PERIOD, interval)
    means = _filled(seconds, samples, step, length)
    sections = signal.butter(ORDER, cutoff, fs=1.0 / step, output="sos")
    level = float(means.mean())
    smooth = signal.sosfiltfilt(sections, means - level, padtype=None) + level
    cut = round(settling / step)
    return float(smooth[cut : len(smooth) - cut].mean()), 2.0 * settling


def _filled(seconds: Array, samples: Array, step: float, length: float) -> Array:
    """Means of equal steps; one without a sample is interpolated."""
    good = np.isfinite(samples)
    at = ((seconds - seconds[0]) / step + 1e-6).astype(np.intp)
    count = max(int(length / step + 1e-6), 1)
    inside = good & (at < count)
    n = np.bincount(at[inside], minlength=count)
    sums = np.bincount(at[inside], samples[inside], minlength=count)
    there = n > 0
    places = np.arange(count)
    return np.asarray(np.interp(places, places[there], sums[there] / n[there]))


def half_widths(seconds: Array, samples: Array, subset: float, subsets: int, interval: float) -> tuple[float, ...]:
    """Return half widths of the t-intervals of the mean of the first sub-means, one a probability.

    Parameters
    ----------
    seconds, samples : ndarray, shape (n,)
        Stamps [s] and values; NaN is left out.
    subset : float
        Length of a sub-mean [s].
    subsets : int
        How many.
    interval : float
        From sample to sample [s].

    Returns
    -------
    tuple of float
        At 95 and 99 %; NaN where the window is too short for them.
    """
    length = float(seconds[-1] - seconds[0]) + interval if len(seconds) else 0.0
    if length < subset * subsets * (1.0 - 1e-9):
        return (np.nan,) * len(PROBABILITIES)
    at = np.floor((seconds - seconds[0]) / subset + 1e-9)
    parts = [samples[(at == i) & np.isfinite(samples)] for i in range(subsets)]
    if not all(len(part) for part in parts):
        return (np.nan,) * len(PROBABILITIES)
    scatter = float(np.std([part.mean() for part in parts], ddof=1)) / np.sqrt(subsets)
    return tuple(coverage_factor(subsets - 1.0, p) * scatter for p in PROBABILITIES)
