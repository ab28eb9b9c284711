"""Expected Allan, Hadamard and modified Allan variance of sampled noise terms, exact for the windows that were taken.

With x the running sum of the samples, C its covariance and m the samples in a mean [1]_::

    Allan      (3 C(0) - 4 C(m) + C(2m)) / m^2
    Hadamard   (10 C(0) - 15 C(m) + 6 C(2m) - C(3m)) / (3 m^2)
    modified   the mean over m second differences: sum_d (m - |d|) c(d) / (2 m^4),
               c(d) = 6 C(d) - 4 C(d + m) - 4 C(d - m) + C(d + 2m) + C(d - 2m)

The means are taken as if the samples were neighbours, as every program does; what dead time changes is C. A ramp adds
(ramp m)^2 / 2 to the Allan and modified variance, nothing to the Hadamard variance.

References
----------
.. [1] Follows from the definitions in NIST SP 1065 (Riley, 2008), clause 5.2, by writing them as contrasts of x.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...core.estimate import Array
from .phase import Phase
from .terms import Term, total_phase

Deviation = Literal["allan", "hadamard", "modified"]


def expected_variance(
    terms: Term | tuple[Term, ...],
    m: ArrayLike,
    interval: float,
    averaging: float | None = None,
    deviation: Deviation = "allan",
) -> Array:
    """Return the expected variance of terms that are sampled, shape of ``m`` [unit^2].

    Parameters
    ----------
    terms : Term, or tuple of Term
        Independent of each other.
    m : array_like of int
        Samples in a mean: tau = m interval.
    interval, averaging : float
        Time from sample to sample, and that of one mean [s]; without dead time where ``averaging`` is absent.
    deviation : {"allan", "hadamard", "modified"}
        Overlapping or not makes no difference to what is expected.

    Raises
    ------
    DataError
        If the averaging time is not positive, or longer than the interval.
    """
    terms = terms if isinstance(terms, tuple) else (terms,)
    phase = total_phase(terms, interval, averaging)
    return variance_of_phase(phase, np.asarray(m, dtype=float), deviation)


def variance_of_phase(phase: Phase, m: Array, deviation: Deviation = "allan") -> Array:
    """Return the expected variance of noise of that phase at m samples in a mean, shape of ``m`` [unit^2]."""
    if deviation == "modified":
        each = [_modified(phase, int(size)) for size in np.ravel(m)]
        return np.reshape(np.array(each), np.shape(m))
    C = phase.covariance
    zero = np.zeros_like(m)
    if deviation == "hadamard":
        contrast = 10.0 * C(zero) - 15.0 * C(m) + 6.0 * C(2.0 * m) - C(3.0 * m)
        return np.asarray(contrast / (3.0 * m**2))
    return np.asarray((3.0 * C(zero) - 4.0 * C(m) + C(2.0 * m)) / m**2 + 0.5 * (phase.ramp * m) ** 2)


def _modified(phase: Phase, m: int) -> float:
    """Sum exactly over the distances of second differences."""
    d = np.arange(m, dtype=float)
    C = phase.covariance
    c = 6.0 * C(d) - 4.0 * (C(d + m) + C(d - m)) + C(d + 2 * m) + C(d - 2 * m)
    weights = np.where(d == 0.0, m, 2.0 * (m - d))
    return float(weights @ c / (2.0 * m**4) + 0.5 * (phase.ramp * m) ** 2)
