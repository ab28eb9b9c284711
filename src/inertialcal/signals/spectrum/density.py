"""Spectrum: a one-sided spectral density with its equivalent degrees of freedom, intervals and remarks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from ..names import Method


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided spectral density of one or several axes."""

    frequency: Array  # ascending and equally spaced, above 0 and below half of the sampling frequency [Hz], shape (k,)
    density: Array  # one-sided, of the samples as they are [unit^2/Hz], shape (k, axes)
    # equivalent degrees of freedom of each value: it is distributed about as chi-square of so many, over them
    edf: float
    # correlation of two values that lie 0, 1, ... spacings apart, in noise of a level spectrum, shape (j,)
    neighbours: Array
    lobe: int  # half width, in spacings, of the peak that a line makes
    enbw: float  # equivalent noise bandwidth of the window [Hz]
    interval: float  # from sample to sample [s]
    segment: int  # samples of each segment
    segments: int  # segments averaged
    # used, missing: samples that lie in a segment; samples without a value in at least one axis
    used: int
    missing: int
    method: Method  # of estimation
    p: float = 0.6827  # probability of the intervals ``lo`` to ``hi``
    remarks: tuple[Remark, ...] = ()  # what was left out, and axes that do not vary

    def apart(self) -> list[Spectrum]:
        """Return the spectrum of each axis by itself; each with the remarks of all."""
        return [Spectrum(**{**vars(self), "density": own}) for own in self.density.T[:, :, None]]

    @property
    def spacing(self) -> float:
        """From one frequency to the next [Hz]."""
        return 1.0 / (self.segment * self.interval)

    @property
    def lo(self) -> Array:
        """Lower ends of the intervals, shape (k, axes)."""
        return self.interval_of(self.p)[0]

    @property
    def hi(self) -> Array:
        """Upper ends of the intervals, shape (k, axes)."""
        return self.interval_of(self.p)[1]

    def interval_of(self, p: float) -> tuple[Array, Array]:
        """Return both ends of the interval of probability ``p`` of each value, equal tails.

        Raises
        ------
        PlanError
            If ``p`` is not between 0 and 1.
        """
        if not 0.0 < p < 1.0:
            raise PlanError(f"probability {p}", do="Need more than 0 and less than 1, such as 0.95")
        tail = 0.5 * (1.0 - p)
        largest, smallest = special.chdtri(self.edf, tail), special.chdtri(self.edf, 1.0 - tail)
        return self.density * (self.edf / largest), self.density * (self.edf / smallest)

    def smoothed(self, per_decade: int = 20) -> tuple[Array, Array, Array]:
        """Return means over bands of equal width on a logarithmic axis, as a figure shows them.

        Parameters
        ----------
        per_decade : int
            Bands in a decade; a band holds one value at least.

        Returns
        -------
        frequency : ndarray, shape (b,)
            Mean frequency of each band [Hz].
        density : ndarray, shape (b, axes)
            Mean density.
        edf : ndarray, shape (b,)
            Equivalent degrees of freedom of the mean, where the spectrum is level across the band.

        Raises
        ------
        PlanError
            If fewer than one band is asked for.
        """
        if per_decade < 1:
            raise PlanError(f"{per_decade} bands a decade, need 1 or more")
        band = np.floor(np.log10(self.frequency / self.frequency[0]) * per_decade + 1e-9)
        start = np.flatnonzero(np.diff(band, prepend=-1.0))
        size = np.diff(np.append(start, len(band)))
        mean = np.add.reduceat(self.density, start, axis=0) / size[:, None]
        edf = self.edf * size**2 / np.array([self._pairs(n) for n in size])
        return np.add.reduceat(self.frequency, start) / size, mean, edf

    def _pairs(self, n: int) -> float:
        """Sum of the correlations of n neighbouring values, each with each."""
        lag = np.arange(1, min(n, len(self.neighbours)))
        return float(n + 2.0 * np.sum((n - lag) * self.neighbours[lag]))

    def summed(self, weights: Array) -> tuple[Array, Array]:
        """Return weighted sums over frequency and their equivalent degrees of freedom, both shape (..., axes).

        Parameters
        ----------
        weights : ndarray, shape (..., k)
            Not negative.
        """
        total, spread = np.empty((2, *weights.shape[:-1], self.density.shape[1]))
        for axis, density in enumerate(self.density.T):
            parts = weights * density
            total[..., axis], spread[..., axis] = parts.sum(axis=-1), np.einsum("...i,...i", parts, parts)
            for lag in range(1, min(len(self.neighbours), len(density))):
                pairs = np.einsum("...i,...i", parts[..., lag:], parts[..., :-lag])
                spread[..., axis] += 2.0 * self.neighbours[lag] * pairs
        with np.errstate(invalid="ignore"):
            return total, np.asarray(self.edf * total**2 / spread)

    def without(self, lines: NDArray[np.bool_]) -> Spectrum:
        """Return the spectrum with some values taken out of one axis and bridged, for a fit of the noise alone.

        Parameters
        ----------
        lines : ndarray of bool, shape (k, axes)
            Values that are no noise; each is replaced by the straight line between its neighbours, on logarithmic axes.

        Raises
        ------
        DataError
            If the marks have another shape, or nothing is left of an axis.
        """
        if lines.shape != self.density.shape or np.any(lines.all(axis=0)):
            raise DataError(f"marks of shape {lines.shape} for values of shape {self.density.shape}, or all marked")
        density, place = self.density.copy(), np.log(self.frequency)
        for axis in range(density.shape[1]):
            out = lines[:, axis]
            if out.any() and np.all(density[~out, axis] > 0.0):
                level = np.log(density[~out, axis])
                density[out, axis] = np.exp(np.interp(place[out], place[~out], level))
        return replace(self, density=density)
