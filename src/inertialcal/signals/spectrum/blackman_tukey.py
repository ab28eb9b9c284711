"""Spectrum from correlations (Blackman and Tukey): raw, smoothed by Hanning's weights, and amplitudes from it.

One-sided, of M correlations at an interval H, at the frequencies ``k / (2 M H)``, k = 0 ... M::

    G_k = 2 H [ R_0 + 2 sum over L = 1 ... M - 1 of R_L cos(pi L k / M) + (-1)^k R_M ]

A line of amplitude A on one of these frequencies, with unbiased correlations over whole cycles, has ``G_k = A^2 / B``
there, where ``B = 1 / (M H)`` is the bandwidth: ``amplitude = sqrt(B |G|)``. Smoothing with the weights 1/4, 1/2, 1/4
halves such a value, and its amplitude needs a root of two in return.

Raw values of white noise scatter as much as their mean, and those of unbiased correlations are negative now and then:
the sign is kept here. ``spectrum.psd`` has intervals and is better for noise; this is what older reports give.

References
----------
.. [1] R. B. Blackman and J. W. Tukey, The Measurement of Power Spectra, Dover, 1959, B.5.
.. [2] K. Reinel, NASA TM X-53857, 1969, appendices A and B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array


@dataclass(frozen=True, eq=False)
class CorrelationSpectrum:
    """One-sided density from correlations."""

    frequency: Array  # from 0 to half of the sampling frequency [Hz], shape (M + 1,)
    density: Array  # may be negative [unit^2/Hz], shape (M + 1,)
    bandwidth: float  # of one value, B [Hz]
    smoothed: bool = False  # whether Hanning's weights were applied

    @property
    def amplitude(self) -> Array:
        """Amplitude of a line that makes each value, shape (M + 1,) [unit]."""
        return np.sqrt((2.0 if self.smoothed else 1.0) * self.bandwidth * np.abs(self.density))


def correlation_spectrum(correlations: Array, interval: float) -> CorrelationSpectrum:
    """Return the raw spectrum of correlations at lags 0 to M, shape (M + 1,), of samples an interval apart [s].

    Raises
    ------
    DataError
        If there are less than two, one is missing, or the interval is not positive.
    """
    R = np.asarray(correlations, dtype=np.float64)
    if R.ndim != 1 or len(R) < 3 or not np.all(np.isfinite(R)):
        raise DataError(f"correlations of shape {R.shape}", do="Need three finite ones or more, from lag 0 on")
    if not (np.isfinite(interval) and interval > 0.0):
        raise DataError(f"a sample interval of {interval} s", do="It must be positive", code="bad_interval")
    M = len(R) - 1
    k = np.arange(M + 1)
    twice = R.copy()
    twice[1:M] *= 2.0
    cosines = np.cos(np.pi / M * (np.outer(k, k) % (2 * M)))
    return CorrelationSpectrum(k / (2.0 * M * interval), 2.0 * interval * (cosines @ twice), 1.0 / (M * interval))


def hanning_smoothed(raw: CorrelationSpectrum) -> CorrelationSpectrum:
    """Return the spectrum smoothed with the weights 1/4, 1/2, 1/4; at both ends the spectrum goes on as its mirror.

    Raises
    ------
    DataError
        If it is smoothed already.
    """
    if raw.smoothed:
        raise DataError("the spectrum is smoothed already")
    G = np.concatenate([raw.density[1:2], raw.density, raw.density[-2:-1]])
    smooth = 0.25 * G[:-2] + 0.5 * G[1:-1] + 0.25 * G[2:]
    return CorrelationSpectrum(raw.frequency, smooth, raw.bandwidth, smoothed=True)
