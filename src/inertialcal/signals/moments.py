"""Number, mean, scatter and extremes of a record in one pass."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.batches import release
from ..core.batches.summaries import Moments, moments
from .threads import each_of, shares

SHORT = 100_000  # samples up to which numpy takes less time than the start of numba


def moments_of(x: NDArray[Any]) -> Moments:
    """Return number, mean, scatter and extremes of the finite numbers of an array, shape (n,)."""
    if len(x) <= SHORT:
        return moments(x)
    from . import _kernels  # noqa: PLC0415 - starts slowly

    def own(share: tuple[int, int]) -> Moments:
        part = x[slice(*share)]
        found = Moments(*_kernels.moments_of(np.require(part, np.float64, ("C", "W"))))
        release(part)
        return found

    return reduce(Moments.joined, each_of(own, shares(len(x)), len(x)))
