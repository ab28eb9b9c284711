"""Spectra of several channels on one clock, with what they have in common: Welch's method, Hann, half overlapping.

Segments lie in the stretches without a missing sample, in which all channels have a value; each has its mean removed.
The degrees of freedom of a value are those of overlapping windows (``signals.spectrum.tapers``), for noise whose
spectrum is level across the bandwidth, ``1.5`` lines.

The mean of C channels is of the power that they have at that line. Its relative variance is that of correlated
chi-square values: with the coherence ``g_ij`` (its bias by chance taken off)::

    edf_mean = edf (sum S_i)^2 / sum_ij S_i S_j g_ij

so that channels that read one noise give no more degrees of freedom than one of them.

References
----------
.. [1] P. D. Welch, IEEE Trans. Audio Electroacoustics AU-15 (1967) 70-73.
.. [2] J. S. Bendat and A. G. Piersol, Random Data, 4th ed., Wiley 2010, chapters 8 and 9 (coherence and its bias).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...core.errors import DataError
from ...core.estimate import Array
from ..names import Method
from ..spectrum.density import Spectrum
from ..spectrum.psd import stretches_of
from ..spectrum.tapers import correlations, hann

AT_ONCE = 2**16  # samples transformed together
FEWEST = 2  # segments
LOBE = 2  # half width of what a line makes [lines]


@dataclass(frozen=True, eq=False)
class CrossSpectra:
    """Densities of c channels and of their products.

    Parameters
    ----------
    frequency : ndarray, shape (k,)
        From the first line above zero to below half of the sampling frequency [Hz].
    matrix : ndarray, shape (k, c, c)
        Complex; its diagonal are the densities [unit^2/Hz].
    edf : float
        Degrees of freedom of a value.
    neighbours : ndarray, shape (5,)
        Correlation of values 0, 1, ... lines apart.
    enbw : float
        Bandwidth [Hz].
    interval : float
        From sample to sample [s].
    segment, segments, used, missing : int
        Samples of a segment; how many; samples in them; samples without a value.
    """

    frequency: Array
    matrix: NDArray[np.complex128]
    edf: float
    neighbours: Array
    enbw: float
    interval: float
    segment: int
    segments: int
    used: int
    missing: int

    @property
    def spacing(self) -> float:
        """From line to line [Hz]."""
        return 1.0 / (self.segment * self.interval)

    @property
    def density(self) -> Array:
        """Densities, shape (k, c)."""
        return np.asarray(np.real(np.einsum("kii->ki", self.matrix)))

    @property
    def coherence(self) -> Array:
        """Squared coherence without its bias by chance, shape (k, c, c); 1 on the diagonal."""
        s, chance = self.density, min(2.0 / self.edf, 0.999)
        product = s[:, :, None] * s[:, None, :]
        raw = np.divide(np.abs(self.matrix) ** 2, product, out=np.zeros_like(product), where=product > 0.0)
        found = np.clip((raw - chance) / (1.0 - chance), 0.0, 1.0)
        at = np.arange(found.shape[1])
        found[:, at, at] = 1.0
        return np.asarray(found)

    def mean(self, channels: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return the mean density of channels and its degrees of freedom at each line, both shape (k,)."""
        s, shared = self.density[:, channels], self.coherence[:, channels][:, :, channels]
        spread = np.einsum("ki,kij,kj->k", s, shared, s)
        total = s.sum(axis=1)
        ratio = np.divide(total**2, spread, out=np.ones_like(total), where=spread > 0.0)
        return np.asarray(total / len(channels)), np.asarray(self.edf * ratio)

    def as_spectrum(self) -> Spectrum:
        """Return the densities alone."""
        method: Method = "welch"
        return Spectrum(self.frequency, self.density, self.edf, self.neighbours, LOBE, self.enbw, self.interval,
                        self.segment, self.segments, self.used, self.missing, method)  # fmt: skip

    def band(self, density: Array, edf: Array, low: float, high: float) -> tuple[float, float]:
        """Return the power between two frequencies and its degrees of freedom.

        Parameters
        ----------
        density, edf : ndarray, shape (k,)
            Of one channel, or of a mean.
        low, high : float
            [Hz]: lines at the edges count by the part of their cell that lies inside.
        """
        half = 0.5 * self.spacing
        inside = np.minimum(self.frequency + half, high) - np.maximum(self.frequency - half, low)
        parts = np.clip(inside, 0.0, None) * density
        total, scaled = float(parts.sum()), parts / np.sqrt(edf)
        spread = float(np.square(scaled).sum())
        for lag in range(1, min(len(self.neighbours), len(parts))):
            spread += 2.0 * float(self.neighbours[lag]) * float(np.sum(scaled[lag:] * scaled[:-lag]))
        return total, total**2 / spread if spread > 0.0 else 0.0


def cross_spectra(x: Array, interval: float, segment: int, chosen: NDArray[np.bool_] | None = None) -> CrossSpectra:
    """Return densities and cross densities.

    Parameters
    ----------
    x : ndarray, shape (n, c)
        Evenly spaced samples; NaN where one is missing.
    interval : float
        From sample to sample [s].
    segment : int
        Samples of a segment, 8 or more.
    chosen : ndarray of bool, shape (n,), optional
        Samples that are used; all by default.

    Raises
    ------
    DataError
        ``too_short`` where fewer than two segments fit between the gaps.
    """
    values = np.asarray(x, dtype=np.float64)
    marked = values if chosen is None else np.where(chosen[:, None], values, np.nan)
    gaps, tapers = stretches_of(marked), hann(segment)
    starts = gaps.starts(segment, tapers.step)
    every = np.concatenate([np.zeros(0, dtype=np.int64), *starts])
    if len(every) < FEWEST:
        what = f"{gaps.longest * interval:.4g} s without a gap, a segment is {segment * interval:.4g} s long"
        raise DataError(what, why="a spectrum needs two segments", do="Record longer, or take a coarser resolution",
                        code="too_short")  # fmt: skip
    lines, c = segment // 2 + 1, values.shape[1]
    total = np.zeros((lines, c, c), dtype=np.complex128)
    windows = np.lib.stride_tricks.sliding_window_view(values, segment, axis=0)  # (n - segment + 1, c, segment)
    at_once = max(1, AT_ONCE // (segment * c))
    for i in range(0, len(every), at_once):
        part = windows[every[i : i + at_once]]
        part = (part - part.mean(axis=2, keepdims=True)) * tapers.weights[0]
        turned = fft.rfft(part, axis=2)
        total += np.einsum("mik,mjk->kij", turned, np.conj(turned))
    total *= 2.0 * interval / len(every)
    edf, neighbours = correlations(tapers, tuple(map(len, starts)))
    used = sum(int(one[-1] - one[0]) + segment for one in starts)
    stop = (segment + 1) // 2
    frequency = np.arange(1, stop) / (segment * interval)
    missing = len(values) - int(np.count_nonzero(np.isfinite(values).all(axis=1)))
    return CrossSpectra(frequency, total[1:stop], edf, neighbours, tapers.enbw / (segment * interval), interval,
                        segment, len(every), used, missing)  # fmt: skip


def hann_kernel(spacing: float, points: int = 16) -> tuple[Array, Array]:
    """Return offsets [Hz] and weights of the spectral window of a Hann window, out to two lines and a half.

    Parameters
    ----------
    spacing : float
        From line to line [Hz].
    points : int
        A line.
    """
    offset = (np.arange(-2.5 * points, 2.5 * points) + 0.5) / points
    window = np.sinc(offset) + 0.5 * (np.sinc(offset - 1.0) + np.sinc(offset + 1.0))
    weight = window**2
    return offset * spacing, weight / weight.sum()


__all__ = ["CrossSpectra", "cross_spectra", "hann_kernel"]
