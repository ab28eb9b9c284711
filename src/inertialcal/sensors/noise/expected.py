"""What sampled noise terms give: Allan, Hadamard and modified variance, exact for the windows taken, and spectrum.

With x the running sum of the samples, C its covariance and m the samples in a mean [1]_::

    Allan      (3 C(0) - 4 C(m) + C(2m)) / m^2
    Hadamard   (10 C(0) - 15 C(m) + 6 C(2m) - C(3m)) / (3 m^2)
    modified   the mean over m second differences: sum_d (m - |d|) c(d) / (2 m^4),
               c(d) = 6 C(d) - 4 C(d + m) - 4 C(d - m) + C(d + 2m) + C(d - 2m)

The means are taken as if the samples were neighbours, as every program does; dead time changes C. A ramp adds
(ramp m)^2 / 2 to the Allan and modified variance, nothing to the Hadamard variance.

``continuous_spectrum`` is the one-sided density of the table in ``terms``, before any averaging. ``sampled_spectrum``
is what a spectrum estimated from the samples tends to: the sum of all bands that averaging leaves and sampling folds
together, in closed form from the covariance of the samples (flicker: summed, with its tail). A ramp and a sinusoid are
no noise and have no density: they give zero; lines are drawn by their amplitude.

References
----------
.. [1] Follows from the definitions in NIST SP 1065 (Riley, 2008), clause 5.2, by writing them as contrasts of x.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError
from ...core.estimate import Array
from .terms import BiasInstability, GaussMarkov, Phase, RandomWalk, RateRandomWalk, Term, total_phase

Deviation = Literal["allan", "hadamard", "modified"]
BANDS = 300  # folded bands of flicker that are summed on either side
AT_A_TIME = 256  # frequencies whose bands are summed in one go


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
        return np.reshape(np.array([_modified(phase, int(size)) for size in np.ravel(m)]), np.shape(m))
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


def sampled_spectrum(
    terms: Term | tuple[Term, ...], frequency: ArrayLike, interval: float, averaging: float | None = None
) -> Array:
    """Return the one-sided density of samples of the terms, shape of ``frequency`` [unit^2/Hz].

    Parameters
    ----------
    terms : Term, or tuple of Term
        Independent of each other.
    frequency : array_like
        Above zero, up to half the sample rate [Hz].
    interval, averaging : float
        Time from sample to sample, and that of one mean [s]; without dead time where ``averaging`` is absent.

    Raises
    ------
    DataError
        If a frequency is outside that range, or the averaging time is not positive or longer than the interval.
    """
    phase = total_phase(terms if isinstance(terms, tuple) else (terms,), interval, averaging)
    f = np.asarray(frequency, dtype=float)
    cycles = f * interval
    if not np.all((cycles > 0.0) & (cycles <= 0.5 * (1.0 + 1e-9))):
        raise DataError(
            f"a frequency outside 0 to {0.5 / interval:g} Hz",
            why="samples have no other frequencies",
            do="Give frequencies above zero, up to half the sample rate",
            code="frequency_range",
        )
    return np.asarray(2.0 * interval * density_of_samples(phase, cycles))


def density_of_samples(phase: Phase, cycles: Array) -> Array:
    """Return the Fourier transform of the covariance of samples, at cycles a sample up to 1/2; lines left out."""
    found = density_of_steps(phase, 4.0 * np.sin(np.pi * cycles) ** 2)
    return np.asarray(found + phase.flicker * _folded_flicker(cycles, phase.duty) if phase.flicker else found)


def density_of_steps(phase: Phase, steps: Array) -> Array:
    """Return the same without flicker, at frequencies f given as 4 sin^2(pi f)."""
    found = phase.point * steps + phase.linear if phase.point else np.full(np.shape(steps), phase.linear)
    if phase.cubic:
        found = found + phase.cubic * (1.0 / steps - 1.0 / 6.0)
    for size, u in phase.exponentials:
        ahead = np.exp(-u)
        found = found + size * (1.0 - ahead**2) / ((1.0 - ahead) ** 2 + ahead * steps)
    return np.asarray(found)


def _folded_flicker(cycles: Array, duty: float) -> Array:
    """Sum of 1 / (2 |f|) and the averaging over all bands, and the tail of the sum; a few frequencies at a time."""
    bands, each = np.arange(-BANDS, BANDS + 1.0), np.ravel(cycles)
    total = np.empty(len(each))
    for first in range(0, len(each), AT_A_TIME):
        at = each[first : first + AT_A_TIME, np.newaxis] + bands
        total[first : first + AT_A_TIME] = np.sum(np.sinc(at * duty) ** 2 / (2.0 * np.abs(at)), axis=-1)
    return np.asarray(total.reshape(np.shape(cycles)) + 1.0 / (4.0 * (np.pi * duty * (BANDS + 0.5)) ** 2))


def continuous_spectrum(terms: Term | tuple[Term, ...], frequency: ArrayLike) -> Array:
    """Return the one-sided density of the terms before sampling, shape of ``frequency`` [unit^2/Hz].

    Quantisation exists in samples alone, and is left out, as a ramp and a sinusoid are.
    """
    f = np.asarray(frequency, dtype=float)
    total = np.zeros_like(f)
    for term in terms if isinstance(terms, tuple) else (terms,):
        if isinstance(term, RandomWalk):
            total = total + 2.0 * term.coefficient**2
        elif isinstance(term, BiasInstability):
            total = total + term.coefficient**2 / (np.pi * f)
        elif isinstance(term, RateRandomWalk):
            total = total + 2.0 * term.coefficient**2 / (2.0 * np.pi * f) ** 2
        elif isinstance(term, GaussMarkov):
            time = term.correlation_time
            total = total + 4.0 * term.sigma**2 * time / (1.0 + (2.0 * np.pi * f * time) ** 2)
    return np.asarray(total)
