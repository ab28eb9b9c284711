"""Values of a record at the stamps of another: straight lines between neighbours, nothing beyond and nothing over gaps.

A straight line halfway between two samples is their mean: it halves the variance of white noise. Means, scatters and
noise are therefore taken from the samples as they were recorded; only what needs both sensors at one time comes from
here.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.recording import Times
from .time_axis import analyse


def interpolated(values: Array, time_ns: Times, onto_ns: Times) -> Array:
    """Return values at other stamps, linearly between the two samples around each.

    Parameters
    ----------
    values : ndarray, shape (n, channels)
        May hold NaN.
    time_ns : ndarray of int64, shape (n,)
        Their stamps, which do not run backwards [ns].
    onto_ns : ndarray of int64, shape (m,)
        Wanted stamps [ns].

    Returns
    -------
    ndarray, shape (m, channels)
        NaN before the first sample, after the last, in a gap, and where one of the two samples is NaN.
    """
    if len(time_ns) < 2:
        return np.full((len(onto_ns), values.shape[1]), np.nan)
    after = np.clip(np.searchsorted(time_ns, onto_ns, side="right"), 1, len(time_ns) - 1)
    before = after - 1
    step = (time_ns[after] - time_ns[before]).astype(np.float64)
    share = (onto_ns - time_ns[before]) / np.where(step > 0.0, step, 1.0)
    share = np.where(np.abs(share - np.rint(share)) * step < 1.0, np.rint(share), share)  # on a stamp: its own sample
    found = values[before] * (1.0 - share[:, None]) + values[after] * share[:, None]
    found = np.where((share == 0.0)[:, None], values[before], found)
    found = np.where((share == 1.0)[:, None], values[after], found)
    gap = np.zeros(len(time_ns), dtype=bool)
    gap[analyse(time_ns).gaps.after] = True
    nothing = (share < 0.0) | (share > 1.0) | (gap[before] & (share > 0.0) & (share < 1.0))
    found[nothing] = np.nan
    return np.asarray(found, dtype=np.float64)
