"""Readings against the acceleration of the control, band by band: response, coherence, noise.

Welch's cross-spectra of the highest level, segments of one window (Hann) overlapping by half; every second line, so
that lines are nearly independent. In a band of L lines, with n effective averages, noise density N from what is not
coherent::

    S = sum 2 n |Gxy|^2 / (Gxx N)  ~  noncentral chi-square, 2 L degrees of freedom, lambda = sum 2 n |H|^2 Gxx / N

so that the gain of a band, ``g^2 = sum |H|^2 Gxx / sum Gxx``, is ``lambda N / (2 n sum Gxx)``: unbiased by what noise
adds, and not lessened where the phase turns within a band. Its interval is that of lambda; a band is significant by the
central chi-square, Bonferroni over the bands. Noise at rest and under vibration are compared by F, 2 L n degrees of
freedom each, less what neighbouring lines have in common.
Assumed: noise that is normal and even within a band. What lies above half the sample rate folds into all of it.

References
----------
.. [1] J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010, 9.2.
.. [2] P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array

THIRD = 2.0 ** (1.0 / 6.0)  # from the middle of a third of an octave to its end
OVERLAP = 1.0 + 2.0 / 36.0  # variance of averages of Hann windows that overlap by half, against independent ones
# The same for the lines of a band, every second one: neighbours in a window, and in the windows that overlap with it.
NEIGHBOURS = 2.0 / 36.0 + 4.0 / 144.0
FEWEST = 8  # windows of an average
LEAST = 4  # lines of a band
STRIDE = 2
SHAKEN, ABOVE = 1e-3, 10.0  # of the highest density, and of that at rest: the control vibrates in a band
P = 0.95


@dataclass(frozen=True, eq=False)
class Spectra:
    """Densities on lines, shape (m,), summed over windows; effective number of averages."""

    frequency: Array
    xx: Array
    yy: Array
    xy: NDArray[np.complexfloating]
    averages: float


@dataclass(frozen=True)
class Band:
    """One band: middle [Hz], what was found there."""

    low: float
    high: float
    middle: float
    lines: int
    gain: float  # [unit/(m/s^2)]
    lo: float
    hi: float
    u: float
    coherence: float
    significant: bool
    noise: float  # Density under vibration without what is coherent [unit/sqrt(Hz)]
    quiet: float  # At rest; NaN without rest
    ratio: float  # Of both
    ratio_lo: float
    ratio_hi: float
    u_ratio: float
    dof: float
    shaken: bool  # Whether the control vibrates there at all


def summed(pairs: Sequence[tuple[Array, Array]], interval: float, window: int) -> Spectra | None:
    """Return the spectra of stretches (control, reading) together; None where there are too few windows."""
    taper = np.hanning(window + 1)[:-1]
    scale = 2.0 * interval / float(np.sum(taper**2))
    lines = window // 2 + 1
    xx, yy, xy = np.zeros(lines), np.zeros(lines), np.zeros(lines, dtype=np.complex128)
    count = 0.0
    for x, y in pairs:
        starts = range(0, len(x) - window + 1, window // 2)
        for start in starts:
            a, b = x[start : start + window], y[start : start + window]
            if not (np.isfinite(a).all() and np.isfinite(b).all()):
                continue
            fa, fb = np.fft.rfft(taper * (a - a.mean())), np.fft.rfft(taper * (b - b.mean()))
            xx, yy, xy = xx + np.abs(fa) ** 2, yy + np.abs(fb) ** 2, xy + np.conj(fa) * fb
            count += 1.0
    if count < FEWEST:
        return None
    frequency: Array = np.fft.rfftfreq(window, interval).astype(float)
    keep = slice(2, None, STRIDE)  # the mean is gone, and the first line has lost to it
    averages = count / OVERLAP
    scale /= count
    return Spectra(frequency[keep], xx[keep] * scale, yy[keep] * scale, xy[keep] * scale, averages)


def bands_of(vibration: Spectra, quiet: Spectra | None) -> list[Band]:
    """Return all thirds of an octave that have lines enough."""
    edges = []
    middle = 1000.0
    while middle / THIRD > vibration.frequency[0]:
        middle /= 2.0 ** (1.0 / 3.0)
    while middle / THIRD < vibration.frequency[-1]:
        edges.append((middle / THIRD, middle, middle * THIRD))
        middle *= 2.0 ** (1.0 / 3.0)
    inside = [(edge, (vibration.frequency >= edge[0]) & (vibration.frequency < edge[2])) for edge in edges]
    inside = [(edge, mask) for edge, mask in inside if np.count_nonzero(mask) >= LEAST]
    return [_band(vibration, quiet, edge, mask, len(inside)) for edge, mask in inside]


def _band(
    vibration: Spectra, quiet: Spectra | None, edge: tuple[float, float, float], mask: NDArray[np.bool_], bands: int
) -> Band:
    xx, yy, xy, n = vibration.xx[mask], vibration.yy[mask], vibration.xy[mask], vibration.averages
    lines = len(xx)
    coherent = np.abs(xy) ** 2 / xx
    noise = float(np.sum(yy - coherent)) / lines * n / (n - 1.0)
    power = float(np.sum(xx))
    s = float(np.sum(2.0 * n * coherent)) / noise if noise > 0.0 else np.inf
    dof = 2.0 * lines
    per = noise / (2.0 * n * power)  # gain^2 a lambda
    lo, hi = (_noncentral(s, dof, q) for q in (0.5 * (1.0 + P), 0.5 * (1.0 - P)))
    gain = float(np.sqrt(max(s - dof, 0.0) * per))
    significant = bool(special.chdtrc(dof, s) < (1.0 - P) / bands)
    u = float(np.sqrt(4.0 * (dof / 2.0 + max(s - dof, 0.0))) * per / (2.0 * gain)) if gain else np.nan
    apart = lines / (1.0 + NEIGHBOURS / OVERLAP * (lines - 1.0) / lines)  # as many independent lines scatter so
    rest, ratio, ends, u_ratio, free = np.nan, np.nan, (np.nan, np.nan), np.nan, 2.0 * apart * (n - 1.0)
    shaken = power / lines > SHAKEN * float(np.max(vibration.xx))
    if quiet is not None:
        other = float(np.mean(quiet.yy[mask]))
        rest, ratio = float(np.sqrt(other)), float(np.sqrt(noise / other))
        m = 2.0 * apart * quiet.averages
        u_ratio = ratio * float(np.sqrt(0.5 / free + 0.5 / m))
        shaken = shaken and power / lines > ABOVE * float(np.mean(quiet.xx[mask]))
        ends = tuple(ratio / float(np.sqrt(special.fdtri(free, m, q))) for q in (0.975, 0.025))  # type: ignore[assignment]
    return Band(
        edge[0], edge[2], edge[1], lines, gain, float(np.sqrt(lo * per)), float(np.sqrt(hi * per)), u,
        float(np.sum(coherent) / np.sum(yy)), significant, float(np.sqrt(noise)), rest, ratio, ends[0], ends[1],
        u_ratio, free, shaken,
    )  # fmt: skip


def _noncentral(s: float, dof: float, q: float) -> float:
    """Return the noncentrality at which a chi-square stays below s with probability q; 0 where none is so low."""
    if special.chdtr(dof, s) <= q:
        return 0.0
    if s > 1e4:  # normal: mean dof + lambda, variance 2 (dof + 2 lambda)
        z = float(special.ndtri(1.0 - q))
        return float(max(s - dof + z * np.sqrt(2.0 * (2.0 * s - dof)) + z**2, 0.0))
    return float(special.chndtrinc(s, dof, q))
