"""Profile of a random vibration: nodes of spectral density joined by straight lines on logarithmic axes.

Between two nodes the density is a power of the frequency, ``S = S_1 (f / f_1)^n`` with
``n = ln(S_2/S_1) / ln(f_2/f_1)``: a slope of ``10 lg 2 n`` dB/octave. With ``L = ln(f_2/f_1)`` its integral, weighted
by a power of the frequency, is exactly::

    int S f^q df = S_1 f_1^(q+1) (exp(m L) - 1) / m          m = n + q + 1

which goes over into ``S_1 f_1^(q+1) L`` where m is zero (the segment of -3.01 dB/octave, for q = 0). The mean square of
acceleration is that of q = 0; of velocity ``(2 pi)^-2`` times that of q = -2; of displacement ``(2 pi)^-4`` times that
of q = -4. Outside of its nodes a profile is zero; two nodes at one frequency are a step.

Assumed: the density is the profile, and nothing outside of it. What lies below the lowest node of a real run has little
acceleration and may have most of the displacement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError
from ...core.estimate import Array

DECIBEL = 10.0  # of a ratio of densities
OCTAVE = math.log(2.0)
FLAT = 1e-8  # exponent times logarithm, below which the series of the integral is taken


def decibels(ratio: ArrayLike) -> Array:
    """Return a ratio of densities, or of mean squares, in decibels; minus infinity of none."""
    with np.errstate(divide="ignore"):
        return np.asarray(DECIBEL * np.log10(ratio))


def ratio(level: ArrayLike) -> Array:
    """Return decibels as a ratio of densities, or of mean squares."""
    return np.asarray(10.0 ** (np.asarray(level) / DECIBEL))


@dataclass(frozen=True, eq=False)
class Profile:
    """Spectral density at nodes.

    Parameters
    ----------
    frequency : ndarray, shape (k,)
        Ascending; two equal ones are a step [Hz].
    density : ndarray, shape (k,)
        One-sided, positive [unit^2/Hz].

    Raises
    ------
    DataError
        ``profile`` if there are fewer than two nodes, or they are not as said.
    """

    frequency: Array
    density: Array

    def __post_init__(self) -> None:
        f, s = (np.asarray(one, dtype=np.float64) for one in (self.frequency, self.density))
        object.__setattr__(self, "frequency", f)
        object.__setattr__(self, "density", s)
        if f.ndim != 1 or f.shape != s.shape or len(f) < 2:
            raise DataError(f"{f.size} node(s) of a profile, need two or more", code="profile")
        good = np.isfinite(f) & np.isfinite(s) & (f > 0.0) & (s > 0.0)
        if not good.all():
            i = int(np.argmin(good))
            raise DataError(f"node {i + 1}: {f[i]:g} Hz, {s[i]:g}: both must be positive", code="profile")
        if np.any(np.diff(f) < 0.0) or f[0] == f[-1]:
            i = int(np.argmin(np.diff(f)))
            do = "List the nodes from the lowest frequency to the highest"
            raise DataError(f"node {i + 2} at {f[i + 1]:g} Hz does not lie above {f[i]:g} Hz", do=do, code="profile")

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]."""
        return float(self.frequency[0]), float(self.frequency[-1])

    @cached_property
    def exponents(self) -> Array:
        """Power of the frequency on each segment, shape (k - 1,); 0 at a step."""
        lengths = np.log(self.frequency[1:] / self.frequency[:-1])
        rises = np.log(self.density[1:] / self.density[:-1])
        return np.divide(rises, lengths, out=np.zeros_like(rises), where=lengths > 0.0)

    @property
    def slopes(self) -> Array:
        """Slope of each segment, shape (k - 1,) [dB/octave]; 0 at a step."""
        return self.exponents * float(decibels(2.0))

    def at(self, frequency: ArrayLike) -> Array:
        """Return the density at frequencies [Hz], of any shape; zero outside."""
        f = np.asarray(frequency, dtype=np.float64)
        i = np.clip(np.searchsorted(self.frequency, f, side="right") - 1, 0, len(self.exponents) - 1)
        with np.errstate(divide="ignore"):
            found = self.density[i] * (np.maximum(f, 1e-300) / self.frequency[i]) ** self.exponents[i]
        return np.asarray(np.where((f >= self.frequency[0]) & (f <= self.frequency[-1]), found, 0.0))

    def power(self, low: float | None = None, high: float | None = None, order: float = 0.0) -> float:
        """Return the integral of the density times the frequency to a power, from one frequency to another.

        Parameters
        ----------
        low, high : float, optional
            [Hz]; the whole profile where not given.
        order : float
            Power of the frequency.

        Returns
        -------
        float
            [unit^2 Hz^order]

        Examples
        --------
        >>> f"{Profile(np.array([1.0, math.e]), np.array([2.0, 2.0 / math.e])).power():.12g}"
        '2'
        """
        low = self.frequency[0] if low is None else low
        high = self.frequency[-1] if high is None else high
        start = np.clip(self.frequency[:-1], low, high)
        stop = np.clip(self.frequency[1:], low, high)
        used = stop > start
        start, stop, n = start[used], stop[used], self.exponents[used]
        first = self.density[:-1][used] * (start / self.frequency[:-1][used]) ** n
        length, m = np.log(stop / start), n + order + 1.0
        product = m * length
        small = np.abs(product) < FLAT
        shape = np.where(small, length * (1.0 + 0.5 * product), np.expm1(product) / np.where(small, 1.0, m))
        return float(np.sum(first * start ** (order + 1.0) * shape))

    def rms(self, low: float | None = None, high: float | None = None, integrals: int = 0) -> float:
        """Return the root mean square, after so many integrations over time (1: velocity, 2: displacement)."""
        return math.sqrt(self.power(low, high, -2.0 * integrals)) / (2.0 * math.pi) ** integrals

    @property
    def width(self) -> float:
        """Statistical bandwidth ``(int S df)^2 / int S^2 df`` [Hz]: ``2 width T`` degrees of freedom in a time T."""
        squared = Profile(self.frequency, self.density**2)
        return self.power() ** 2 / squared.power()

    def scaled(self, level: float) -> Profile:
        """Return the profile so many decibels higher."""
        return Profile(self.frequency, self.density * float(ratio(level)))

    def smoothed(self, frequency: Array, offsets: Array, weights: Array) -> Array:
        """Return the density as an estimate sees it: weighted over neighbouring frequencies.

        Parameters
        ----------
        frequency : ndarray, shape (m,)
            [Hz]
        offsets, weights : ndarray, shape (j,)
            Distances [Hz], and weights that add up to 1.

        Returns
        -------
        ndarray, shape (m,)
        """
        return np.asarray(self.at(frequency[:, None] + offsets) @ weights)


def octaves(low: float, high: float) -> float:
    """Return how many octaves lie from one frequency to another."""
    return math.log(high / low) / OCTAVE


def fractional_octaves(low: float, high: float, parts: int) -> Array:
    """Return the edges of bands of 1/parts octave about 1 kHz that lie wholly between two frequencies, shape (b + 1,).

    Centres are ``1000 2^(k/parts)`` Hz (IEC 61260-1 has powers of ``10^(3/10)`` for 2: 0.24 % an octave apart).
    """
    first = math.ceil(parts * octaves(1000.0, low) + 0.5 - 1e-9)
    last = math.floor(parts * octaves(1000.0, high) + 0.5 + 1e-9)
    return np.asarray(1000.0 * 2.0 ** ((np.arange(first, last + 1) - 0.5) / parts))


__all__: Sequence[str] = ("Profile", "decibels", "fractional_octaves", "octaves", "ratio")
