"""Thirds of an octave, and the power of a spectrum in them with its degrees of freedom.

Bands are those of base ten [1]_: middle ``10^(k/10)`` Hz, edges ``10^((k +- 1/2)/10)``; their nominal frequencies are
the rounded ones (1, 1.25, 1.6, ...). A line of the spectrum stands for the cell of one resolution about it, and a band
has the share of each cell that lies in it, so that bands side by side add to the whole.

A band narrower than the noise bandwidth of the window, 1.5 lines of a Hann window, is not estimated: its power would
be that of its neighbours. Nor is one whose upper edge lies above the cut-off of the low pass.

The uncertainty is that of noise of the spectrum found: lines of one Hann window go together, neighbours with 4/9, the
next but one with 1/36, and so do windows that overlap by half; the power of a band then has the degrees of freedom
``2 P^2 / var(P)``, and chi-square gives its interval. Of axes together, the squared cross spectra say how far their
powers go together. A steady sine has less scatter than this says, so that its interval is too wide; where blocks
differ by more than such noise does (crew, pumps that start), their own scatter takes its place.

References
----------
.. [1] IEC 61260-1:2014, octave-band and fractional-octave-band filters: middle and edge frequencies, G = 10^(3/10).
.. [2] P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70: variance of averaged, overlapping periodograms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...core.estimate import Array
from ...core.results import Interval
from ...statistics.intervals import chi_square_interval

BANDWIDTH = 1.5  # lines: noise bandwidth of a Hann window
LAGS = 3  # lines that go together
LOWEST, HIGHEST = -20, 30  # bands from 0.01 Hz to 1 kHz
NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
ENOUGH = 20  # blocks, from which their own scatter is looked at
SURE = 4.0  # standard deviations by which that scatter is more than noise makes


@dataclass(frozen=True)
class Band:
    """One third of an octave."""

    number: int

    @property
    def middle(self) -> float:
        """Middle [Hz]."""
        return float(10.0 ** (self.number / 10.0))

    @property
    def low(self) -> float:
        """Lower edge [Hz]."""
        return float(10.0 ** ((self.number - 0.5) / 10.0))

    @property
    def high(self) -> float:
        """Upper edge [Hz]."""
        return float(10.0 ** ((self.number + 0.5) / 10.0))

    @property
    def nominal(self) -> float:
        """As it is called [Hz]."""
        decade, step = divmod(self.number, 10)
        return float(f"{NOMINAL[step]}e{decade}")


BANDS = tuple(Band(number) for number in range(LOWEST, HIGHEST + 1))


def refused(band: Band, step: float, top: float) -> str:
    """Return why a band is not estimated with lines a ``step`` apart up to ``top`` [Hz]; empty where it is."""
    if band.high - band.low < BANDWIDTH * step:
        return "narrower than the resolution"
    return "above the pass band" if band.high > top * (1.0 + 1e-9) else ""


def share(low: float, high: float, lines: int, step: float) -> Array:
    """Return what share of each line's cell lies between two frequencies, shape (lines,)."""
    middle = np.arange(lines) * step
    inside = np.minimum(high, middle + 0.5 * step) - np.maximum(low, middle - 0.5 * step)
    return np.asarray(np.clip(inside, 0.0, step) / step)


@cache
def _together() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return how far powers of lines go together, by their distance: of one window, and of windows half over."""
    n = 1024
    window = 0.5 - 0.5 * np.cos(2.0 * math.pi * np.arange(n) / n)
    total = float(np.sum(window**2)) ** 2
    over = np.zeros(n)
    over[: n // 2] = window[: n // 2] * window[n // 2 :]
    own, half = (np.abs(np.fft.fft(one))[: LAGS + 1] ** 2 / total for one in (window**2, over))
    return tuple(own.tolist()), tuple(half.tolist())


def variance(weights: Array, squares: Array, blocks: int, pairs: int) -> float:
    """Return the variance of the mean power in a band.

    Parameters
    ----------
    weights : ndarray, shape (lines,)
        Share of each line.
    squares : ndarray, shape (lines,)
        Squared power of each line, or sum over axes of squared cross powers.
    blocks, pairs : int
        Windows that were averaged; how many of them overlap the next by half.
    """
    own, half = _together()
    root = np.sqrt(squares)
    found = 0.0
    for lag in range(LAGS + 1):
        each = (own[lag] + 2.0 * pairs / blocks * half[lag]) / blocks
        products = weights[: len(weights) - lag] * weights[lag:] * root[: len(root) - lag] * root[lag:]
        found += (1.0 if lag == 0 else 2.0) * each * float(np.sum(products))
    return found / (1.0 + (own[0] + 2.0 * pairs / blocks * half[0]) / blocks)  # squares of noisy powers are too large


def block_variance(powers: Array) -> float:
    """Return the variance of the mean of powers of blocks, shape (k,), by their scatter and how far it lasts."""
    k = len(powers)
    left = powers - np.mean(powers)
    own = float(np.mean(left**2))
    if own <= 0.0:
        return 0.0
    total = 1.0
    for lag in range(1, max(k // 4, 2)):
        correlation = float(np.sum(left[lag:] * left[:-lag])) / (k * own)
        if correlation <= 0.0:
            break
        total += 2.0 * correlation
    return own / (k - 1) * min(total, k / 2.0)


@dataclass(frozen=True)
class Power:
    """Mean power in a band, or over the whole range."""

    power: float  # [(m/s^2)^2]
    dof: float  # Of it
    u: float = 0.0  # Relative standard uncertainty of the scale factor
    steady: bool = True  # Whether blocks scatter as noise does

    @property
    def rms(self) -> float:
        """Root mean square [m/s^2]."""
        return math.sqrt(self.power)

    @property
    def u_rms(self) -> float:
        """Standard uncertainty of it [m/s^2]."""
        return self.rms * math.hypot(1.0 / math.sqrt(2.0 * self.dof), self.u)

    def interval(self, p: float) -> Interval:
        """Return the interval of the root mean square: that of chi-square, widened by the scale factor."""
        found = chi_square_interval(self.rms, self.dof, p)
        low, high = float(found.lo or 0.0), float(found.hi or 0.0)
        if self.u <= 0.0 or self.rms <= 0.0:
            return Interval(low, high, p)
        from scipy.special import ndtri  # noqa: PLC0415 - starts slowly

        z = float(ndtri(0.5 + 0.5 * p)) * self.u
        down = math.hypot(math.log(self.rms / low), z)
        up = math.hypot(math.log(high / self.rms), z)
        return Interval(self.rms * math.exp(-down), self.rms * math.exp(up), p)


def power(weights: Array, lines: Array, squares: Array, each: Array, blocks: tuple[int, int], u: float) -> Power:
    """Return the mean power in a band with its degrees of freedom.

    Parameters
    ----------
    weights, lines, squares : ndarray, shape (n,)
        Share of each line, its mean power, and as `variance` takes them.
    each : ndarray, shape (k,)
        Power of each block.
    blocks : tuple of int
        Blocks, and pairs that overlap.
    u : float
        Relative standard uncertainty of the scale factor.
    """
    total = float(weights @ lines)
    by_noise = variance(weights, squares, *blocks)
    steady = True
    if len(each) >= ENOUGH:
        by_blocks = block_variance(each)
        tail = 2.0 + 6.0 * by_noise * len(each) / total**2 if total > 0.0 else 2.0  # chi-square: excess 12 / dof
        steady = not by_blocks > by_noise * (1.0 + SURE * math.sqrt(tail / len(each)))
        by_noise = by_noise if steady else by_blocks
    dof = 2.0 * total**2 / by_noise if by_noise > 0.0 else 2.0
    return Power(total, max(dof, 0.5), u, steady)
