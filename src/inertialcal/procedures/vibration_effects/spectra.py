"""Readings against the acceleration of the control, band by band: response, coherence, noise.

Welch's cross-spectra of the highest level (``signals.vibration.spectra``); every second line, so that lines are nearly
independent. In a band of L lines, with n effective averages, noise density N from what is not coherent::

    S = sum 2 n |Gxy|^2 / (Gxx N)  ~  noncentral chi-square, 2 L degrees of freedom, lambda = sum 2 n |H|^2 Gxx / N

so that the gain of a band, ``g^2 = sum |H|^2 Gxx / sum Gxx``, is ``lambda N / (2 n sum Gxx)``: unbiased by what noise
adds, and not lessened where the phase turns within a band. N is not known but found, with ``2 L (n - 1)`` degrees of
freedom: an end of the interval is the gain at which the chance of so small (or large) a sum, averaged over what N may
be, is 2.5 %. Without a gain that is the F test, by which a band is significant, Bonferroni over the bands; of a strong
one it is the t interval. Noise at rest and under vibration are compared by F, 2 L n degrees of freedom each. L counts
less for what neighbouring lines have in common.
Assumed: noise that is normal and even within a band. What lies above half the sample rate folds into all of it.

References
----------
.. [1] J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010, 9.2.
.. [2] P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from ...core.errors import DataError
from ...core.estimate import Array
from ...signals.vibration.profile import fractional_octaves
from ...signals.vibration.spectra import cross_spectra

THIRDS = 3  # of an octave
FEWEST = 8  # windows of an average
LEAST = 4  # lines of a band
STRIDE = 2
SHAKEN, ABOVE = 1e-3, 10.0  # of the highest density, and of that at rest: the control vibrates in a band
P = 0.95
CHANCES = 40  # equal chances of what the noise may be, that are averaged
NORMAL = 200.0  # degrees of freedom and noncentrality, from which a power of a chi-square is taken as normal


@dataclass(frozen=True, eq=False)
class Spectra:
    """Densities on lines, shape (m,); effective number of averages; correlation of the squares of two next lines."""

    frequency: Array
    xx: Array
    yy: Array
    xy: NDArray[np.complexfloating]
    averages: float
    shared: float


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
    gap = np.full((1, 2), np.nan)
    joined = np.concatenate([part for x, y in pairs for part in (np.column_stack([x, y]), gap)]) if pairs else gap
    try:
        found = cross_spectra(joined, interval, window)
    except DataError:
        return None
    if found.segments < FEWEST:
        return None
    keep = slice(1, None, STRIDE)  # the mean is gone, and the first line has lost to it
    density = found.density[keep]
    return Spectra(found.frequency[keep], density[:, 0], density[:, 1], found.matrix[keep, 1, 0], 0.5 * found.edf,
                   float(found.neighbours[STRIDE]))  # fmt: skip


def bands_of(vibration: Spectra, quiet: Spectra | None) -> list[Band]:
    """Return all thirds of an octave that have lines enough."""
    octaves = 2.0 ** (1.0 / THIRDS)
    edges = fractional_octaves(vibration.frequency[0] / octaves, vibration.frequency[-1] * octaves, THIRDS)
    masks = [(vibration.frequency >= low) & (vibration.frequency < high) for low, high in pairwise(edges.tolist())]
    inside = [(edge, mask) for edge, mask in zip(pairwise(edges.tolist()), masks, strict=True)
              if np.count_nonzero(mask) >= LEAST]  # fmt: skip
    return [_band(vibration, quiet, edge, mask, len(inside)) for edge, mask in inside]


def _band(
    vibration: Spectra, quiet: Spectra | None, edge: tuple[float, float], mask: NDArray[np.bool_], bands: int
) -> Band:
    xx, yy, xy, n = vibration.xx[mask], vibration.yy[mask], vibration.xy[mask], vibration.averages
    lines = len(xx)
    coherent = np.abs(xy) ** 2 / xx
    noise = float(np.sum(yy - coherent)) / lines * n / (n - 1.0)
    power = float(np.sum(xx))
    s = float(np.sum(2.0 * n * coherent)) / noise if noise > 0.0 else np.inf
    dof = 2.0 * lines
    apart = lines / (1.0 + 2.0 * vibration.shared * (lines - 1.0) / lines)  # as many independent lines scatter so
    free = 2.0 * apart * (n - 1.0)
    per = noise / (2.0 * n * power)  # gain^2 a lambda
    lo, hi = _noncentral(s * apart / lines, 2.0 * apart, free)
    gain = float(np.sqrt(max(s - dof, 0.0) * per))
    significant = bool(special.fdtrc(2.0 * apart, free, s / dof) < (1.0 - P) / bands)
    spread = (2.0 * dof + 4.0 * max(s - dof, 0.0)) * lines / apart + 2.0 * dof**2 / free  # variance of s - dof
    u = float(np.sqrt(spread)) * per / (2.0 * gain) if gain else np.nan
    rest, ratio, ends, u_ratio = np.nan, np.nan, (np.nan, np.nan), np.nan
    shaken = power / lines > SHAKEN * float(np.max(vibration.xx))
    if quiet is not None:
        other = float(np.mean(quiet.yy[mask]))
        rest, ratio = float(np.sqrt(other)), float(np.sqrt(noise / other))
        m = 2.0 * apart * quiet.averages
        u_ratio = ratio * float(np.sqrt(0.5 / free + 0.5 / m))
        shaken = shaken and power / lines > ABOVE * float(np.mean(quiet.xx[mask]))
        ends = tuple(ratio / float(np.sqrt(special.fdtri(free, m, q))) for q in (0.975, 0.025))  # type: ignore[assignment]
    scale = per * lines / apart
    return Band(
        edge[0], edge[1], float(np.sqrt(edge[0] * edge[1])), lines, gain, float(np.sqrt(lo * scale)),
        float(np.sqrt(hi * scale)), u, float(np.sum(coherent) / np.sum(yy)), significant, float(np.sqrt(noise)), rest,
        ratio, ends[0], ends[1], u_ratio, free, shaken,
    )  # fmt: skip


def _noncentral(s: float, dof: float, free: float) -> tuple[float, float]:
    """Return both ends of the interval of a noncentrality, over a noise that was found.

    Parameters
    ----------
    s : float
        Sum of squares over the noise that was found.
    dof, free : float
        Degrees of freedom of the sum, and of the noise.
    """
    if not np.isfinite(s):
        return np.inf, np.inf
    chance = (np.arange(CHANCES) + 0.5) / CHANCES
    noise = free / special.chdtri(free, chance)  # what the noise may be, over that found

    def below(wanted: float, q: float) -> float:
        return float(np.mean(_chance_below(s / noise, dof, wanted / noise))) - q

    most = 2.0 * (s + dof) + 100.0
    while below(most, 0.5 * (1.0 - P)) > 0.0:
        most *= 2.0
    ends = []
    for q in (0.5 * (1.0 + P), 0.5 * (1.0 - P)):
        ends.append(float(optimize.brentq(below, 0.0, most, args=(q,), rtol=1e-6)) if below(0.0, q) > 0.0 else 0.0)
    return ends[0], ends[1]


def _chance_below(s: Array, dof: float, wanted: Array) -> Array:
    """Return the chance that a noncentral chi-square stays below s, by the noncentrality."""
    if float(np.median(s)) < NORMAL:
        return np.asarray(special.chndtr(s, dof, wanted))
    # Sankaran, Biometrika 50 (1963) 199: a power of it is nearly normal
    one, two, three = dof + wanted, dof + 2.0 * wanted, dof + 3.0 * wanted
    h = 1.0 - 2.0 * one * three / (3.0 * two**2)
    p, m = two / one**2, (h - 1.0) * (1.0 - 3.0 * h)
    mean, sd = 1.0 + h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p), h * np.sqrt(2.0 * p) * (1.0 + 0.5 * m * p)
    return np.asarray(special.ndtr(((s / one) ** h - mean) / sd))
