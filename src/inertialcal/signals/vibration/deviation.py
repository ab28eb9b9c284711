"""Deviation of measured spectra from a profile: intervals of each line, and what an averaging of channels means.

A value of ``edf`` degrees of freedom is distributed as ``S chi^2(edf) / edf``. In decibels its error is that of the
scale factor, common to all lines and normal, on top of it. An interval adds the two in quadrature, each side by
itself::

    upper side = hypot(10 lg(edf / chi^2_low), z u)          lower side = hypot(10 lg(chi^2_high / edf), z u)

What this is good for is checked by its coverage. *Mean* of channels: ``CrossSpectra.mean``. *Maximum*: the largest of
the true densities lies between the largest lower ends and the largest upper ends of the channels, each with a chance of
``(1 - p) / C`` to miss; the value that is shown is the largest, which chance makes too large.

Decision over m lines. PASS says that *every* line is inside: each must be shown inside by itself (an intersection-union
test), so that one line outside is passed with the risk of a single line, and no correction for their number is due.
FAIL says that *some* line is outside: chance has m attempts, and intervals hold for all lines together (Sidak,
``p^(1/m)`` each; the correlation of neighbours makes it safer).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...core.estimate import Array
from .profile import decibels
from .spectra import CrossSpectra

ROUNDING = 0.05  # of a line: stamps are rounded, and lines lie beside the nodes that they were meant to lie on
NEPER = float(decibels(math.e))  # relative change of a density in decibels


@dataclass(frozen=True, eq=False)
class Deviation:
    """Measured density against a profile, at m lines or bands.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        [Hz]
    low, high : ndarray, shape (m,)
        Ends of each line's band [Hz].
    density, profile : ndarray, shape (m,)
        As measured, and as an estimate of a run on the profile would read [unit^2/Hz].
    edf : ndarray, shape (m,)
        Degrees of freedom; of a maximum, those of one channel.
    each : ndarray, shape (m, c)
        Densities of the channels that a maximum is of; shape (m, 0) for a mean.
    u : float
        Standard uncertainty that all lines have in common [dB].
    """

    frequency: Array
    low: Array
    high: Array
    density: Array
    profile: Array
    edf: Array
    each: Array
    u: float = 0.0

    def __len__(self) -> int:
        return len(self.frequency)

    @property
    def value(self) -> Array:
        """Deviation, shape (m,) [dB]."""
        return decibels(self.density / self.profile)

    @property
    def u_value(self) -> Array:
        """Its standard uncertainty, shape (m,) [dB]."""
        return np.asarray(np.hypot(NEPER * np.sqrt(special.polygamma(1, 0.5 * self.edf)), self.u))

    def interval(self, p: float) -> tuple[Array, Array]:
        """Return both ends of the interval of each deviation, of probability ``p`` each, shape (m,) [dB]."""
        c = self.each.shape[1]
        if c < 2:
            return self._ends(self.value, p)
        every = [self._ends(decibels(own / self.profile), 1.0 - (1.0 - p) / c) for own in self.each.T]
        return np.max([lo for lo, _ in every], axis=0), np.max([hi for _, hi in every], axis=0)

    def _ends(self, value: Array, p: float) -> tuple[Array, Array]:
        tail = 0.5 * (1.0 - p)
        common = -float(special.ndtri(tail)) * self.u
        up = decibels(self.edf / special.chdtri(self.edf, 1.0 - tail))
        down = decibels(special.chdtri(self.edf, tail) / self.edf)
        return value - np.hypot(down, common), value + np.hypot(up, common)

    def together(self, p: float) -> float:
        """Return the probability of each interval that makes all of them hold with probability ``p``."""
        return float(p ** (1.0 / max(len(self), 1)))


def lines_against(
    spectra: CrossSpectra, density: Array, edf: Array, profile: Array, band: tuple[float, float], edges: Array | None,
    each: Array, u: float,
) -> Deviation:  # fmt: skip
    """Return the deviation at the lines whose bandwidth lies in a band, or over bands between edges.

    Parameters
    ----------
    spectra : CrossSpectra
        Of the run.
    density, edf : ndarray, shape (k,)
        Of what is judged at each line.
    profile : ndarray, shape (k,)
        What an estimate of the profile would read.
    band : (float, float)
        That is judged [Hz]: lines whose window, two lines wide on each side, lies inside.
    edges : ndarray, shape (b + 1,), optional
        Of bands [Hz]; a band without two lines is left out.
    each : ndarray, shape (k, c)
        Channels that a maximum is of, shape (k, 0) for a mean.
    u : float
        Common standard uncertainty [dB].
    """
    f, width = spectra.frequency, (2.0 - ROUNDING) * spectra.spacing
    inside = (f - width >= band[0]) & (f + width <= band[1])
    if edges is None:
        half = 0.5 * spectra.enbw
        return Deviation(f[inside], f[inside] - half, f[inside] + half, density[inside], profile[inside], edf[inside],
                         each[inside], u)  # fmt: skip
    low, high = edges[:-1], edges[1:]
    found: list[tuple[float, ...]] = []
    rows: list[Array] = []
    for a, b in zip(low.tolist(), high.tolist(), strict=True):
        own = inside & (f >= a) & (f < b)
        if np.count_nonzero(own) < 2:
            continue
        total, dof = spectra.band(np.where(own, density, 0.0), edf, 0.0, math.inf)
        expected, _ = spectra.band(np.where(own, profile, 0.0), edf, 0.0, math.inf)
        size = spectra.spacing * int(np.count_nonzero(own))
        found.append((math.sqrt(a * b), a, b, total / size, expected / size, dof))
        rows.append(each[own].mean(axis=0))
    columns = np.array(found).reshape(-1, 6).T
    channels = np.array(rows).reshape(len(found), each.shape[1])
    return Deviation(columns[0], columns[1], columns[2], columns[3], columns[4], columns[5], channels, u)


__all__ = ["NEPER", "Deviation", "lines_against"]
