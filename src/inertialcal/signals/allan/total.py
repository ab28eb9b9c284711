"""Total deviations: as if the record went on beyond its ends, mirrored, so that long averaging times scatter less.

With P the integrated signal (n points), and m the averaging factor::

    total            P mirrored at both ends with the sign turned [1]_, eq. (25): the mean of n - 2 squares over 2 m^2
    modified total   each 3 m points of P in a row, less a line, mirrored [1]_, eq. (27)
    Hadamard total   each 3 m samples of the rate in a row, less a line, mirrored [1]_, eq. (29); at m = 1 the
                     overlapping Hadamard deviation [2]_

They are as published: without the factors that correct the bias of each noise type.

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
from ...core.estimate import Array
from ..threads import LARGE, each_of
from . import _kernels as kernels
from . import _kernels_total as loops
from .prefix import phase_of

Total = Literal["total", "modified_total", "hadamard_total"]
KINDS = ("total", "modified_total", "hadamard_total")
SHARE = 2**16  # stretches that are summed by themselves: the same whatever the number of threads


def total_deviations(x: ArrayLike, factors: Sequence[int] | NDArray[np.integer], kind: Total = "total") -> Array:
    """Return total deviations of a complete record of a rate, in its unit, shape (k,).

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
        If the record is not a channel of finite numbers (``bad_shape``, ``gaps``), or shorter than 3 samples.
    PlanError
        If the kind is not known, or an averaging factor is not from 1 to a third of the record, or they do not rise.
    """
    rate = np.asarray(x, dtype=np.float64)
    m = np.asarray(factors, dtype=np.int64)
    if kind not in KINDS:
        raise PlanError(f"deviation {kind!r}", do=f"There are: {', '.join(KINDS)}", code="wrong_deviation")
    if rate.ndim != 1 or len(rate) < 3:
        raise DataError(f"a record of shape {rate.shape}", do="Need (n,), three samples or more", code="bad_shape")
    if not np.isfinite(rate).all():
        raise DataError("samples are missing", do="Give a stretch without gaps", code="gaps")
    if m.ndim != 1 or not len(m) or m[0] < 1 or np.any(np.diff(m) <= 0) or m[-1] > len(rate) // 3:
        what = f"averaging factors {m.tolist()}"
        raise PlanError(what, do=f"Give rising ones, 1 to a third of the record: {len(rate) // 3}", code="wrong_taus")
    phase = np.ascontiguousarray(phase_of(rate, "rate").values, dtype=np.float64)
    sums, size = np.empty(len(m)), m.astype(np.float64)
    if kind == "total":
        kernels.sum_overlapping(phase, m, 2, sums)
        loops.add_edges(phase, m, sums)
        return np.asarray(np.sqrt(sums / (2.0 * (len(phase) - 2) * size**2)))
    y, divisor = (phase, 2.0 * size**2) if kind == "modified_total" else (rate, np.full(len(m), 6.0))
    starts = len(y) - 3 * m + 1
    sums[:] = [_summed(y, int(factor), int(many)) for factor, many in zip(m, starts, strict=True)]
    found = np.sqrt(sums / (6.0 * size**3 * starts * divisor))
    if kind == "hadamard_total" and m[0] == 1:
        kernels.sum_overlapping(phase, m[:1], 3, sums[:1])
        found[0] = np.sqrt(sums[0] / (6.0 * (len(phase) - 3)))
    return np.asarray(found)


def _summed(y: Array, m: int, starts: int) -> float:
    """Return the sum of squares over all stretches of 3 m samples."""
    one = loops.stretches_one_by_one if m <= loops.DIRECT else loops.stretches_at_once
    share = max(SHARE, 4 * loops.REACH * m)
    bounds = [(a, min(a + share, starts)) for a in range(0, starts, share)]
    return sum(each_of(lambda part: float(one(y, m, *part)), bounds, starts if starts > LARGE // 8 else 0))
