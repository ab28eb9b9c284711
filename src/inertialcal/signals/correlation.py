"""Correlation of sampled signals with themselves and with each other, at lags of whole samples.

    R_xy(L) = sum over i of x_i y_(i+L), over the pairs that there are (unbiased), or over n (biased)

so that a positive lag says that ``y`` comes later. The mean of each signal, over its own samples, is removed first
unless it is told not to be. Pairs with a missing sample are left out and counted at each lag: gaps stay gaps, nothing
is closed up or filled. Signals longer than a few thousand multiplications a lag go through the Fourier transform, ``O(n
log n)``.

Unbiased values of a record with a mean removed are still a little low: by the variance of that mean. At lags near the
length of the record they are means of few pairs and scatter wildly; biased ones do not, and no spectrum made of them
is negative where no sample is missing.

References
----------
.. [1] G. M. Jenkins and D. G. Watts, Spectral Analysis and its Applications, Holden-Day, 1968, 5.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from ..core.errors import DataError
from ..core.estimate import Array

Kind = Literal["unbiased", "biased"]

SUMMED = 4096  # samples up to which each lag is summed as it stands


@dataclass(frozen=True, eq=False)
class Correlation:
    """Correlation at lags from zero on."""

    values: Array  # NaN at a lag without any pair [product of the units], shape (lags + 1,)
    pairs: NDArray[np.int64]  # behind each, shape (lags + 1,)
    scale: float  # root of the product of both mean squares: what `normalised` divides by

    @property
    def normalised(self) -> Array:
        """Values over ``scale``; that of a signal with itself is 1 at lag 0. Shape (lags + 1,).

        Raises
        ------
        DataError
            If a signal does not vary.
        """
        if not self.scale > 0.0:
            raise DataError("a signal does not vary", why="it has no correlation", code="no_scatter")
        return self.values / self.scale


def autocorrelation(x: ArrayLike, lags: int, kind: Kind = "unbiased", *, centred: bool = True) -> Correlation:
    """Return the correlation of a signal with itself.

    Parameters
    ----------
    x : array_like, shape (n,)
        NaN where a sample is missing.
    lags : int
        Largest lag, 0 to n - 1.
    kind : {"unbiased", "biased"}
        Divided by the pairs that there are, or by the samples.
    centred : bool
        Whether the mean is removed first.

    Raises
    ------
    DataError
        As `cross_correlation`.
    """
    return cross_correlation(x, x, lags, kind, centred=centred)


def cross_correlation(
    x: ArrayLike, y: ArrayLike, lags: int, kind: Kind = "unbiased", *, centred: bool = True
) -> Correlation:
    """Return the correlation of a signal with a later part of another; arguments are those of `autocorrelation`.

    Raises
    ------
    DataError
        If the signals differ in length, are empty or infinite, or the record has no such lag (``too_short``).
    """
    first, there = _checked(x, centred)
    second, known = (first, there) if y is x else _checked(y, centred)
    if len(first) != len(second):
        raise DataError(f"signals of {len(first)} and {len(second)} samples", do="Give two of one length")
    if not 0 <= lags < len(first):
        what = f"correlation at lags up to {lags} of {len(first)} samples"
        raise DataError(what, do=f"There are 0 to {len(first) - 1}", code="too_short")
    sums, pairs = _sums(first, second, lags), np.rint(_sums(there, known, lags)).astype(np.int64)
    both = int(pairs[0])
    counts = pairs if kind == "unbiased" else np.where(pairs > 0, both, 0)
    values = np.where(pairs > 0, sums / np.maximum(counts, 1), np.nan)
    squares = np.sum(first**2) / max(there.sum(), 1.0) * np.sum(second**2) / max(known.sum(), 1.0)
    return Correlation(values, pairs, float(np.sqrt(squares)))


def _checked(x: ArrayLike, centred: bool) -> tuple[Array, Array]:
    """Return the signal with zeros where samples are missing, and 1 where they are not."""
    values = np.asarray(x, dtype=np.float64)
    there = ~np.isnan(values)
    if values.ndim != 1 or not there.any() or np.isinf(values).any():
        what = f"a signal of shape {values.shape} with {int(there.sum())} sample(s)"
        raise DataError(what, do="Need finite numbers, shape (n,), NaN where a sample is missing", code="bad_shape")
    mean = float(values[there].mean()) if centred else 0.0
    return np.where(there, values - mean, 0.0), there.astype(np.float64)


def _sums(x: Array, y: Array, lags: int) -> Array:
    """Return the sums of products at each lag, shape (lags + 1,)."""
    n = len(x)
    if n <= SUMMED:
        return np.array([x[: n - lag] @ y[lag:] for lag in range(lags + 1)])
    length = fft.next_fast_len(n + lags, real=True)
    turned = fft.rfft(x, length)
    other = turned if y is x else fft.rfft(y, length)
    return np.asarray(fft.irfft(turned.conj() * other, length)[: lags + 1])
