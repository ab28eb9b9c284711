"""Covariance of overlapping Allan variances across averaging times, as a model of the noise implies it.

The noise is normal. For differences d_k(m) of neighbouring means, whose covariance s at any distance follows from that
of the running sum (``phase``), means of d^2 / 2 have the covariance [1]_::

    cov = sum over pairs of ( s^2 / 2 + mu mu' s ) / (number of pairs)

where mu is what is not noise, a ramp or a line. The sum runs over the windows that the record has; between distances
that matter it is taken by trapezoids, which costs about 1 %. Neighbouring octaves are correlated by 0.5 to 0.7, and
edf alone, with octaves as if independent, makes intervals of fitted terms too short.

With gaps the number of pairs is scaled to the number of terms that were there.

References
----------
.. [1] L. Isserlis, Biometrika 12 (1918) 134: fourth moments of normal quantities; used for Allan variances in
   C. A. Greenhall and W. J. Riley, Proc. 35th PTTI (2003) 267.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ._kernels import fill_covariance
from .phase import SERIES_FROM, Phase, dead_time_part, exponential_gain

TAIL = 8.0  # of a correlation time, and of both averaging times, beyond which nothing is summed


def covariance_of_allan(phase: Phase, m: Array, n: Array) -> Array:
    """Return the covariance of overlapping Allan variances, shape (k, k) [unit^4].

    Parameters
    ----------
    phase : Phase
        Of all terms together.
    m : ndarray, shape (k,)
        Samples in a mean, ascending.
    n : ndarray, shape (k,)
        Terms that were averaged.
    """
    slope = dead_time_part(np.array([float(SERIES_FROM) * 100.0]), phase.duty)[0] / (SERIES_FROM * 100.0)
    linear = phase.linear + 2.0 * phase.flicker * slope  # what dead time adds to flicker is short, and taken as white
    parts = np.array([phase.point, linear, phase.cubic, phase.flicker])
    exponentials = np.array([(size, u, *exponential_gain(u)) for size, u in phase.exponentials]).reshape(-1, 4)
    cosines = np.array(
        [(variance / (2.0 * np.sin(np.pi * cycles)) ** 2, cycles) for variance, cycles in phase.cosines]
    ).reshape(-1, 2)
    slowest = float(exponentials[:, 1].min()) if len(exponentials) else np.inf
    wanders = TAIL * float(m[-1]) * (phase.flicker > 0.0)
    out = np.zeros((len(m), len(m)))
    reach = max(TAIL / slowest, wanders, 2.0)
    fill_covariance(
        np.asarray(m, dtype=float), np.asarray(n, dtype=float), reach, parts, phase.ramp, exponentials, cosines, out
    )
    return out


def model_edf(variance: Array, covariance: Array) -> Array:
    """Return the equivalent degrees of freedom 2 variance^2 / var of Allan variances, shape (k,)."""
    return np.asarray(2.0 * variance**2 / np.diag(covariance))
