"""Fourier coefficients of a complete record.

They count from its first sample::

    x_i = a_0 + sum over k of a_k cos(2 pi k i / n) + b_k sin(2 pi k i / n),    i = 0 ... n - 1

for k = 1 ... n/2. The highest line of a record of even length, that at half of the sampling frequency, has half the
weight of the others (1/n, not 2/n), and its sine cannot be told: it is zero at every sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import fft

from ...core.errors import DataError
from ...core.estimate import Array


@dataclass(frozen=True, eq=False)
class FourierCoefficients:
    """Coefficients of one record."""

    # cosine, sine: of line 0 (the mean), 1, ... [unit], shape (n // 2 + 1,) or (n // 2 + 1, k)
    cosine: Array
    sine: Array
    samples: int  # of the record

    @property
    def amplitude(self) -> Array:
        """Root of the sum of both squares [unit]."""
        return np.hypot(self.cosine, self.sine)

    def frequency(self, interval: float) -> Array:
        """Frequencies of the lines [Hz], the samples being an interval apart [s]; shape (n // 2 + 1,)."""
        return np.arange(len(self.cosine)) / (self.samples * interval)


def fourier_coefficients(x: ArrayLike) -> FourierCoefficients:
    """Return the Fourier coefficients of a record, shape (n,), or of several of equal length, (n, k).

    Raises
    ------
    DataError
        ``gaps`` if a sample is missing; ``too_short`` if there are less than two.
    """
    values = np.asarray(x, dtype=np.float64)
    n = len(values) if values.ndim else 0
    if values.ndim not in {1, 2} or n < 2:
        raise DataError(f"a record of shape {values.shape}", do="Need two samples or more", code="too_short")
    missing = int(np.count_nonzero(~np.isfinite(values)))
    if missing:
        do = "Fit the line instead: signals.sine"
        raise DataError(f"{missing} of {n} samples are missing", why="lines would mix", do=do, code="gaps")
    turned = fft.rfft(values, axis=0) * (2.0 / n)
    turned[0] *= 0.5
    if n % 2 == 0:
        turned[-1] *= 0.5
    return FourierCoefficients(np.ascontiguousarray(turned.real), -turned.imag, n)
