"""Total deviations: as if the record went on beyond its ends, mirrored, so that long averaging times scatter less.

With P the integrated signal (n points), and m the averaging factor::

    total            P mirrored at both ends with the sign turned [1]_, eq. (25): the mean of n - 2 squares over 2 m^2
    modified total   each 3 m points of P in a row, less a line, mirrored [1]_, eq. (27)
    Hadamard total   each 3 m samples of the rate in a row, less a line, mirrored [1]_, eq. (29); at m = 1 the
                     overlapping Hadamard deviation [2]_

Their means differ from those of the deviations without mirrors by a factor that hangs on the noise; it is left in here,
and taken out where the noise type is known (``edf.bias_of``).

A record with gaps has none: mirrored is what is there.

References
----------
.. [1] Riley, Handbook of frequency stability analysis, NIST SP 1065, 2008, sections 5.2.11 to 5.2.14.
.. [2] Howe et al., A total estimator of the Hadamard function used for GPS operations, Proc. 32nd PTTI, 2000.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Numbers
from ..names import Quantity
from ..threads import LARGE, each_of
from . import _kernels as kernels
from . import _kernels_total as loops
from .deviations import ALLAN, KINDS, Kind, Variances, terms_of
from .gaps import COMPLETE
from .prefix import Phase, level_of, phase_of

Total = Literal["total", "modified_total", "hadamard_total"]
TOTALS: tuple[Total, ...] = ("total", "modified_total", "hadamard_total")
SHARE = 2**16  # stretches that are summed by themselves: the same whatever the number of threads
LONGEST = 2**26  # samples: mirrors need the whole record in memory


def total_deviations(x: ArrayLike, factors: Sequence[int] | NDArray[np.integer], kind: Total = "total") -> Array:
    """Return total deviations of a complete record of a rate, as defined, in its unit, shape (k,).

    Parameters
    ----------
    x : array_like, shape (n,)
        Evenly spaced samples of a rate [unit].
    factors : sequence of int, shape (k,)
        Averaging times in samples, rising, up to a third of the record.
    kind : {"total", "modified_total", "hadamard_total"}
        Which one.

    Raises
    ------
    DataError
        If the record is not a channel of finite numbers (``bad_shape``, ``gaps``), shorter than 3 samples, or too
        long to be held (``too_long``).
    PlanError
        If the kind is not known, or an averaging factor is not from 1 to a third of the record, or they do not rise.
    """
    rate = np.asarray(x, dtype=np.float64)
    m = np.asarray(factors, dtype=np.int64)
    if kind not in TOTALS:
        raise PlanError(f"deviation {kind!r}", do=f"There are: {', '.join(TOTALS)}", code="wrong_deviation")
    if rate.ndim != 1 or len(rate) < 3:
        raise DataError(f"a record of shape {rate.shape}", do="Need (n,), three samples or more", code="bad_shape")
    if not np.isfinite(rate).all():
        raise DataError("samples are missing", do="Give a stretch without gaps", code="gaps")
    if m.ndim != 1 or not len(m) or m[0] < 1 or np.any(np.diff(m) <= 0) or m[-1] > len(rate) // 3:
        what = f"averaging factors {m.tolist()}"
        raise PlanError(what, do=f"Give rising ones, 1 to a third of the record: {len(rate) // 3}", code="wrong_taus")
    return np.asarray(np.sqrt(total_variances(rate, phase_of(rate, "rate"), "rate", KINDS[kind], m).variance))


def total_variances(x: Numbers, phase: Phase, quantity: Quantity, kind: Kind, m: NDArray[np.int64]) -> Variances:
    """Return total variances of one channel as defined, at rising averaging factors, each up to a third of the record.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples.
    phase : Phase
        Their integrated signal.
    quantity, kind : str, Kind
        What a sample is, and which total deviation.
    m : ndarray of int, shape (k,)
        Averaging times in samples.

    Raises
    ------
    DataError
        If samples are missing (``gaps``), or the record is too long to be held (``too_long``).
    """
    if not phase.complete:
        what = f"{phase.missing} of {len(x)} samples are missing: no {kind.words}"
        why = "it mirrors the record at its ends, which a record with gaps has in many places"
        do = "Give a stretch without gaps, keep disturbed samples, or take another deviation"
        raise DataError(what, why=why, do=do, code="gaps")
    if len(x) > LONGEST:
        what = f"a record of {len(x):,} samples: the {kind.words} takes {LONGEST:,} at most"
        do = "Give a shorter stretch, or take a deviation without mirrors"
        raise DataError(what, why="it needs the whole record in memory", do=do, code="too_long")
    values = np.ascontiguousarray(phase.values, dtype=np.float64)
    sums, size, ends = np.empty(len(m)), m.astype(np.float64), np.full(len(m), COMPLETE)
    terms = terms_of(kind, len(values), m)
    if kind.order == ALLAN and not kind.modified:
        kernels.sum_overlapping(values, m, 2, sums)
        loops.add_edges(values, m, sums)
        return Variances(sums / (kind.divisor * terms * size**2), terms, np.ones(len(m)), ends)
    y, divisor = values, 2.0 * size**2
    if not kind.modified:  # less digits are lost in samples than in differences of their sums
        y = np.diff(values) if quantity == "angle" else (x - level_of(x)).astype(np.float64)
        divisor = np.full(len(m), 6.0)
    sums[:] = [_summed(y, int(factor), int(many)) for factor, many in zip(m, terms, strict=True)]
    found = sums / (6.0 * size**3 * terms * divisor)
    if not kind.modified and m[0] == 1:
        kernels.sum_overlapping(values, m[:1], 3, sums[:1])
        found[0] = sums[0] / (6.0 * terms[0])
    return Variances(found, terms, np.ones(len(m)), ends)


def _summed(y: Array, m: int, starts: int) -> float:
    """Return the sum of squares over all stretches of 3 m samples."""
    one = loops.stretches_one_by_one if m <= loops.DIRECT else loops.stretches_at_once
    share = max(SHARE, 4 * loops.REACH * m)
    bounds = [(a, min(a + share, starts)) for a in range(0, starts, share)]
    return sum(each_of(lambda part: float(one(y, m, *part)), bounds, starts if starts > LARGE // 8 else 0))
