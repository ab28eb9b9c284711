"""Deviations of a signal at averaging factors: differences of neighbouring averages, squared and averaged.

With P[j] the sum of all samples before j ("phase"), ybar_j = (P[j + m] - P[j]) / m the mean of m samples from j on,
and n the number of terms, the variances at tau = m times the sample interval are [1]_ (total ones: ``total``)::

    Allan      sum (ybar_{j+m} - ybar_j)^2 / (2 n)
    modified   sum (mean over m neighbouring j of (ybar_{j+m} - ybar_j))^2 / (2 n)
    Hadamard   sum (ybar_{j+2m} - 2 ybar_{j+m} + ybar_j)^2 / (6 n)

with j = 0, 1, 2, ... where windows overlap, and 0, m, 2m, ... where not.

An integrated signal (angle, velocity) is P itself.

Missing samples: a window takes part if at least half of its samples are there, and stands for their mean; a term
takes part if all its windows do; half the second differences behind a term of the modified deviation must be there.
The mean of fewer samples scatters more: with c_i of m samples there, white noise is raised by the mean of
``m (1/c_1 + 1/c_2) / 2`` over the terms (Hadamard: ``m (1/c_1 + 4/c_2 + 1/c_3) / 6``), the ``inflation``, which is
divided out where the noise is white or bluer. Redder noise hardly changes over a window, and is left as it is.

References
----------
.. [1] Riley, Handbook of frequency stability analysis, NIST SP 1065, 2008, section 5.2, eq. (6) to (20).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Numbers
from .gaps import COMPLETE
from .loops import loops_for, loops_with_gaps
from .prefix import Phase

SAFE = 2.0**62  # whole numbers of int64 that sums of four may reach
ALLAN = 2  # order
APART = 128  # ratio of the averaging factors of modified deviations whose sums have the same steps
FINEST = 1000.0  # power of 2


@dataclass(frozen=True)
class Kind:
    """What a deviation does: order of its differences, whether they overlap and are averaged, its name in words."""

    order: int
    overlapping: bool
    modified: bool
    words: str
    total: bool = False  # whether the record goes on beyond its ends, mirrored (``total``)

    @property
    def windows(self) -> int:
        """Windows that one term spans."""
        return self.order + self.modified

    @property
    def divisor(self) -> float:
        """Mean square of the difference of independent averages of variance 1, but for the order 2 or 6."""
        return 2.0 if self.order == 2 else 6.0

    @property
    def reddest(self) -> int:
        """Exponent of the reddest noise that the deviation converges for."""
        return -2 if self.order == 2 else -4


KINDS: dict[str, Kind] = {
    "overlapping": Kind(2, True, False, "overlapping Allan deviation"),
    "non_overlapping": Kind(2, False, False, "Allan deviation"),
    "modified": Kind(2, True, True, "modified Allan deviation"),
    "hadamard": Kind(3, False, False, "Hadamard deviation"),
    "overlapping_hadamard": Kind(3, True, False, "overlapping Hadamard deviation"),
    "total": Kind(2, True, False, "total deviation", total=True),
    "modified_total": Kind(2, True, True, "modified total deviation", total=True),
    "hadamard_total": Kind(3, True, False, "Hadamard total deviation", total=True),
}


@dataclass(frozen=True, eq=False)
class Variances:
    """Variances of one channel, in squares of the unit of the samples."""

    variance: Array  # NaN where no term is there, shape (k,)
    terms: NDArray[np.int64]  # number of terms, shape (k,)
    inflation: Array  # by how much missing samples raise white noise; not yet divided out, shape (k,)
    ends: Array  # squared weights of errors of the running sum, as `curve.Allan` has them, shape (k,)


def terms_of(kind: Kind, points: int, factors: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many terms a complete record of ``points`` phase points has, shape (k,)."""
    if kind.total:  # squares about every point but both ends, or stretches of three windows; of the rate for Hadamard
        stretches = points - (kind.order - ALLAN) + 1 - 3 * factors
        terms = stretches if kind.modified or kind.order > ALLAN else np.full(len(factors), points - 2)
        return np.asarray(np.where(3 * factors < points, terms, 0))
    if kind.modified:
        return np.asarray(points + 1 - 3 * factors)
    left = points - 1 - kind.order * factors
    return np.asarray(left + 1 if kind.overlapping else left // factors + 1)


def variances(phase: Phase, kind: Kind, factors: NDArray[np.int64]) -> Variances:
    """Return the variances at rising averaging factors, each small enough for a term; the phase may be used up."""
    sums, inflation = np.empty(len(factors)), np.ones(len(factors))
    ends = np.full(len(factors), COMPLETE)
    terms = terms_of(kind, len(phase.values), factors)
    if phase.complete:
        kernels = loops_for(len(phase.values))
        if kind.modified:
            _sum_modified(phase.values, factors, sums)
        elif not kind.overlapping:
            kernels.sum_strides(phase.values, factors, kind.order, sums)
        else:
            kernels.sum_overlapping(phase.values, factors, kind.order, sums)
    else:
        terms = np.empty(len(factors), dtype=np.int64)
        shared, missing = (phase.values, phase.count, phase.pointwise, factors), loops_with_gaps(len(phase.values))
        if kind.modified:
            missing.sum_present_modified(*shared, sums, terms, inflation)
        else:
            missing.sum_present(*shared, kind.order, kind.overlapping, sums, terms, inflation)
            if kind.order == ALLAN and not phase.pointwise:
                missing.weights_of_ends(phase.count, factors, kind.overlapping, ends)
    size = factors.astype(np.float64) ** (4 if kind.modified else 2)
    if phase.complete and len(terms) and terms[-1] > 0:  # fewer of longer ones
        return Variances(sums / (kind.divisor * terms * size), terms, inflation, ends)
    with np.errstate(invalid="ignore", divide="ignore"):
        return Variances(np.where(terms > 0, sums / (kind.divisor * terms * size), np.nan), terms, inflation, ends)


def _sum_modified(p: Numbers, factors: NDArray[np.int64], sums: Array) -> None:
    """Averages of m second differences of P are third differences of the sums of P.

    Over a whole record these grow so large that floats would have no digits left: they are whole numbers, which may
    run over, in steps so fine that the largest third difference just fits. Short windows have finer steps than long.
    """
    kernels = loops_for(len(p))
    largest = float(kernels.largest_beside_line(p))
    whole = p.dtype == np.int64 and 4.0 * max(int(p.max()), -int(p.min())) * float(factors[-1]) < SAFE
    running, few = np.empty(len(p) + 1, dtype=np.int64), 0
    while few < len(factors):
        more = len(factors) if whole else int(np.searchsorted(factors, int(factors[few]) * APART, side="right"))
        steps = SAFE / (4.0 * largest * float(factors[more - 1])) if largest else np.inf
        scale = 0.0 if whole else 2.0 ** min(np.floor(np.log2(steps)), FINEST)
        kernels.sum_again(p, scale, running)
        kernels.sum_overlapping(running, factors[few:more], 3, sums[few:more])
        if not whole:
            sums[few:more] = sums[few:more] / scale / scale
        few = more
