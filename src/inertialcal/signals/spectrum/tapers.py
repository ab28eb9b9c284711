"""Tapers, and what follows from them alone: degrees of freedom, correlation of neighbours, usable frequencies.

For Gaussian noise whose spectrum is level across the window, the powers of two segments under two tapers have the
correlation of the squared size of the sum of the product of the tapers, shifted by the distance of the segments [1]_
[2]_. All figures below are sums of these.

References
----------
.. [1] P. D. Welch, IEEE Trans. Audio Electroacoustics AU-15 (1967) 70-73.
.. [2] D. B. Percival and A. T. Walden, Spectral Analysis for Physical Applications, Cambridge, 1993, chapters 6 and 7.
.. [3] D. J. Thomson, Proc. IEEE 70 (1982) 1055-1096 (several orthogonal tapers).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import fft, linalg

from ...core.estimate import Array

HANN_LOBE = 2  # half width of the main lobe of a Hann window [1 / length]
FALSIFIED = 0.01  # of the power of white noise, that removing the mean may take
RAISED = 0.1  # that smoothing may add to a spectrum that falls as 1/f^2
BEATING = 0.05  # that a mirror image may add to the variance of a value


@dataclass(frozen=True, eq=False)
class Tapers:
    """Tapers of one length, each with the sum of squares 1."""

    weights: Array  # a taper a row, shape (k, n)
    step: int  # from one segment to the next [samples]
    lobe: int  # half width of their main lobe [1 / length]

    @property
    def enbw(self) -> float:
        """Equivalent noise bandwidth [1 / length]: mean of ``n sum w^2 / (sum w)^2`` over tapers that see a line."""
        sums = self.weights.sum(axis=1) ** 2
        return float(self.weights.shape[1] * len(sums) / sums.sum())


@lru_cache(4)
def hann(n: int) -> Tapers:
    """Return the one taper of Welch's method: Hann, ``(1 - cos(2 pi k / n)) / 2``; segments overlap by half."""
    w = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, n + 1)[:-1])
    return Tapers((w / np.sqrt(np.sum(w * w)))[None, :], max(1, n // 2), HANN_LOBE)


@lru_cache(4)
def slepian(n: int, time_bandwidth: float) -> Tapers:
    """Return the first ``2 NW - 2`` Slepian tapers of a half bandwidth of ``NW / n``; segments do not overlap.

    They are the eigenvectors of the largest eigenvalues of a tridiagonal matrix ([2]_, section 8.3), of either sign.
    The next one, which is often used too, lets through so much from far away that it would raise the high end of a
    spectrum that falls as 1/f^2 by 15 %.
    """
    count, k = max(1, int(2.0 * time_bandwidth) - 2), np.arange(n, dtype=np.float64)
    diagonal = ((n - 1 - 2 * k) / 2.0) ** 2 * np.cos(2.0 * np.pi * (time_bandwidth / n))
    off_diagonal = k[1:] * (n - k[1:]) / 2.0
    _, vectors = linalg.eigh_tridiagonal(diagonal, off_diagonal, select="i", select_range=(n - count, n - 1))
    return Tapers(np.ascontiguousarray(vectors[:, ::-1].T), n, int(np.ceil(time_bandwidth)))


@lru_cache(8)
def usable(tapers: Tapers) -> tuple[int, int]:
    """Return the lowest frequency that can be told and the one above the highest, counted in ``1 / n``.

    Left out at the low end is what a removed mean changes by more than 1 %, ``|sum w exp(-2 pi i f t)|^2 / n`` of
    white noise, and where smoothing by the tapers raises a spectrum that falls as 1/f^2 by more than 10 %: by
    ``3 v / f^2``, v the variance of the spectral window. At the high end, as at the low one, power and its mirror image
    beat; left out is where that raises the variance of a value by more than 5 %.
    """
    count, n = tapers.weights.shape
    share = np.mean(np.abs(fft.rfft(tapers.weights, axis=1)) ** 2, axis=0) / n
    removed = int(np.flatnonzero(share >= FALSIFIED).max(initial=0)) + 1
    spread = np.sum(np.diff(tapers.weights, axis=1) ** 2) / count * (n / (2.0 * np.pi)) ** 2
    smoothed = int(np.ceil(np.sqrt(3.0 * spread / RAISED)))
    mirrored = _shared(tapers, 0)[::2] / count
    apart = int(np.flatnonzero(mirrored >= BEATING).max(initial=0)) + 1
    return max(removed, smoothed, apart), n // 2 - apart + 1


@lru_cache(8)
def correlations(tapers: Tapers, segments: tuple[int, ...]) -> tuple[float, Array]:
    """Return degrees of freedom of a value, and the correlation with those next to it.

    Parameters
    ----------
    tapers : Tapers
        Of each segment.
    segments : tuple of int
        How many there are in each stretch.

    Returns
    -------
    edf : float
        ``2 / (relative variance)``.
    neighbours : ndarray, shape (2 lobe + 1,)
        Correlation of values 0, 1, ... spacings apart; not to be changed.
    """
    k, n = tapers.weights.shape
    total = sum(segments)
    variance = np.zeros(2 * tapers.lobe + 1)
    for lag in range(0, n, tapers.step):
        pairs = sum(max(0, many - lag // tapers.step) for many in segments)
        if pairs:
            variance += (1.0 if lag == 0 else 2.0) * pairs * _shared(tapers, lag)
    variance /= (total * k) ** 2
    return 2.0 / float(variance[0]), variance / variance[0]


@lru_cache(16)
def _shared(tapers: Tapers, lag: int) -> Array:
    """Sum over pairs of tapers of the squared size of their shifted product, at 0, 1, ... 2 lobe spacings."""
    weights, count = tapers.weights, 2 * tapers.lobe + 1
    n = weights.shape[1]
    turn = np.exp(-2j * np.pi * np.outer(np.arange(count), np.arange(n - lag)) / n)
    shared = np.zeros(count)
    for first in weights[:, : n - lag]:
        shared += np.sum(np.abs(turn @ (first * weights[:, lag:]).T) ** 2, axis=1)
    return shared
