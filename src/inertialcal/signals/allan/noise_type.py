"""Noise type at each averaging time, by the lag-1 autocorrelation of the averages.

Averages of m samples side by side, a line taken off, are differenced until their lag-1 autocorrelation r is below 0.2
(``rho = r / (1 + r)`` below about 1/4 [1]_, where after d differences alpha is -2 (rho + d)). That relation is of
fractionally differenced noise, which averages are not: averages of a random walk have r = 1/4 after one difference,
not 0. So alpha is interpolated between the values that averages of m samples of each noise have, by the
autocovariances of ``edf``, rounded to a whole number and cut to what the deviation converges for. The line lowers r of
n averages by 2 / n on average (white noise), which is given back.

Of a long record 2,048 averages are looked at, in 32 stretches spread evenly: they tell alpha to 0.05. Of a short
one the same averages are taken from up to four starting points. Fewer than 30 averages cannot tell the type [1]_:
there, of the types of the two longest averaging times that tell, the one stands that leaves fewer degrees of freedom.

Of two terms the bluer fades with longer averaging. So noise bluer than white is believed at an averaging time only
if it was found at all shorter ones; else few averages of white noise would pass for it by chance, and its
intervals would be far too narrow.

References
----------
.. [1] Riley and Greenhall, Power law noise identification using the lag 1 autocorrelation, Proc. 18th EFTF, 2004.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from . import _kernels_noise_type as kernels
from .deviations import Kind
from .edf import BLUEST, all_degrees
from .prefix import Phase

WHITE = 0.0


def identified_powers(phase: Phase, kind: Kind, factors: NDArray[np.int64]) -> Array:
    """Return the exponent at each averaging factor, shape (k,); NaN where there are too few averages to tell.

    Parameters
    ----------
    phase : Phase
        Of one channel.
    kind : Kind
        The deviation, which limits the exponent.
    factors : ndarray of int64, shape (k,)
        Rising.
    """
    found = np.empty(len(factors))
    kernels.identify(phase.values, phase.count, phase.pointwise, factors, -kind.reddest // 2, found)
    power = np.clip(np.rint(found), kind.reddest, BLUEST)
    bluest = np.fmin.accumulate(np.fmax(power, WHITE))
    return np.asarray(np.where(np.isnan(power), np.nan, np.fmin(power, bluest)))


def carried_on(power: Array, kind: Kind, factors: NDArray[np.int64], terms: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the exponent everywhere, and the degrees of freedom with it, both of shape (k,).

    Parameters
    ----------
    power : ndarray, shape (k,)
        NaN where it could not be told; white is taken where none could.
    kind : Kind
        Which deviation.
    factors, terms : ndarray of int64, shape (k,)
        Samples a window, and squares averaged.
    """
    told = power[np.isfinite(power)]
    last, before = (told[-1], told[-2:][0]) if len(told) else (WHITE, WHITE)
    one, other = (np.where(np.isnan(power), value, power) for value in (last, before))
    edf = all_degrees(kind, factors, terms, one)
    if last == before:
        return one, edf
    fewer = all_degrees(kind, factors, terms, other)
    lower = fewer < edf
    return np.where(lower, other, one), np.where(lower, fewer, edf)
