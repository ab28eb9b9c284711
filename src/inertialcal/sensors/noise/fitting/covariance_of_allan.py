"""Covariance of overlapping Allan variances across averaging times, as a model of the noise implies it.

The noise is normal. For differences d_k(m) of neighbouring means, whose covariance s at any distance follows from that
of the running sum (``phase``), means of d^2 / 2 have the covariance [1]_::

    cov = sum over pairs of ( s^2 / 2 + mu mu' s ) / (number of pairs)

where mu is what is not noise, a ramp. The sum runs over the windows that the record has; away from the distances where
s has kinks it is taken by panels of distances (to a thousandth of a correlation). Of a line, whose mu mu' swings,
the sum is the spectrum of the noise there::

    cov = a P(f) h(m)^2 h(m')^2 / max(n, n'),    h(m) = (2 cos(2 pi f m T) - 2) / m

with P the density of the running sum and a the variance of the line in it. The Allan variance of a line itself swings
with its phase, by a share of sin(2 pi f n T) / (n sin(2 pi f T)) of its size. Allan variances of neighbouring octaves
are correlated by 0.5 to 0.7, and edf alone, with octaves as if independent, makes intervals of fitted terms too short.

With gaps the number of pairs is scaled to the number of terms that were there, as if gaps lay together, and the white
part of s is raised by the root of both ``inflation``: means of fewer samples scatter more, which the expected variance
holds too. Of single missing samples the variance at two samples a window, some of which rest on one alone, comes out
15 to 25 % low, that at one sample a few per cent high; at all others, and in the size of white noise, 5 % are left.

References
----------
.. [1] L. Isserlis, Biometrika 12 (1918) 134: fourth moments of normal quantities; used for Allan variances in
   C. A. Greenhall and W. J. Riley, Proc. 35th PTTI (2003) 267.
"""

from __future__ import annotations

import numpy as np

from ....core.estimate import Array
from .._kernels import fill_covariance
from ..phase import SERIES_FROM, Phase, dead_time_part, exponential_gain
from ..spectrum_of_terms import density_of_samples

NO_BEAT = 1e-9  # sine of a frequency that is no beat: the sum of two lines at the sample rate
TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed


def covariance_of_allan(phase: Phase, m: Array, n: Array, inflation: Array | None = None) -> Array:
    """Return the covariance of overlapping Allan variances, shape (k, k) [unit^4].

    Parameters
    ----------
    phase : Phase
        Of all terms together.
    m : ndarray, shape (k,)
        Samples in a mean, ascending.
    n : ndarray, shape (k,)
        Terms that were averaged.
    inflation : ndarray, shape (k,), optional
        By how much missing samples raise the variance of white noise.
    """
    slope = dead_time_part(np.array([float(SERIES_FROM) * 100.0]), phase.duty)[0] / (SERIES_FROM * 100.0)
    linear = phase.linear + 2.0 * phase.flicker * slope  # what dead time adds to flicker is short, and taken as white
    sizes = np.array([phase.point, linear, phase.cubic, phase.flicker])
    parts = np.array(phase.exponentials).reshape(-1, 2)
    exponentials = np.column_stack([parts, *exponential_gain(parts[:, 1])])
    slowest = float(exponentials[:, 1].min()) if len(exponentials) else np.inf
    wanders = TAIL * float(m[-1]) * (phase.flicker > 0.0)
    reach = max(TAIL / slowest, wanders, 2.0)
    m, n, out = np.asarray(m, dtype=float), np.asarray(n, dtype=float), np.zeros((len(m), len(m)))
    raised = np.ones(len(m)) if inflation is None else np.asarray(inflation, dtype=float)
    fill_covariance(m, n, raised, reach, sizes, phase.ramp, exponentials, out)
    for line in phase.cosines:
        out += noise_on_line(phase, line, m, n)
    for i, line in enumerate(phase.cosines):
        out += ends_of_lines(line, line, m, n)
        for other in phase.cosines[:i]:
            out += ends_of_lines(line, other, m, n)
    return out


def noise_on_line(phase: Phase, line: tuple[float, float], m: Array, n: Array) -> Array:
    """Return what noise times a line adds, shape (k, k) [unit^4]; a line as in ``phase``."""
    power = float(density_of_samples(phase, np.array([line[1]]))[0]) / (2.0 * np.sin(np.pi * line[1])) ** 2
    h = (2.0 * np.cos(2.0 * np.pi * line[1] * m) - 2.0) / m
    found = _root(line, m) * h
    return np.asarray(2.0 * power * np.outer(found, found) / np.maximum(n, n[:, None]))


def ends_of_lines(one: tuple[float, float], other: tuple[float, float], m: Array, n: Array) -> Array:
    """Return what it adds that a record holds no whole number of cycles, for lines of unknown phase, shape (k, k)."""
    total = np.zeros((len(m), len(m)))
    alike = one is other
    for cycles in (one[1] + other[1],) if alike else (one[1] + other[1], one[1] - other[1]):
        sine = np.sin(np.pi * cycles)
        share = np.sin(np.pi * cycles * n) / (n * sine) if abs(sine) > NO_BEAT else np.ones(len(n))
        swing = _root(one, m) * _root(other, m) * share
        total += (0.5 if alike else 2.0) * np.outer(swing, swing)
    return total


def _root(line: tuple[float, float], m: Array) -> Array:
    """Root of the Allan variance of a line, with the sign of its differences, shape (k,)."""
    variance, cycles = line
    h = (2.0 * np.cos(2.0 * np.pi * cycles * m) - 2.0) / m
    return np.asarray(np.sqrt(0.5 * variance) / (2.0 * np.sin(np.pi * cycles)) * h)


def model_edf(variance: Array, covariance: Array) -> Array:
    """Return the equivalent degrees of freedom 2 variance^2 / var of Allan variances, shape (k,)."""
    return np.asarray(2.0 * variance**2 / np.diag(covariance))
