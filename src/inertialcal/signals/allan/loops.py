"""The loops of ``_kernels`` for short records, in numpy: a compiler takes longer to start than they take to run.

Which runs is told by the length alone, so that a record gives the same bits each time.
"""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array, Numbers

SHORT = 2**15  # points


def loops_for(points: int) -> ModuleType:
    """Return the module whose loops take less time for so many points: this one, or the kernels."""
    if points <= SHORT:
        return sys.modules[__name__]
    from . import _kernels  # noqa: PLC0415 - starts slowly

    return _kernels


def integrate(x: Numbers, level: np.float64 | np.int64, phase: Numbers) -> None:
    """Fill ``phase``, one longer than ``x``, with the sums of all samples before each, less a level a sample."""
    phase[0] = 0
    np.cumsum(x - level, out=phase[1:])


def integrate_present(
    x: Numbers, present: NDArray[np.bool_], level: np.float64 | np.int64, phase: Numbers, count: NDArray[np.int32]
) -> None:
    """Fill ``phase`` and ``count`` with the sums and numbers of the samples that are present."""
    phase[0], count[0] = 0, 0
    np.cumsum(np.where(present, np.where(present, x, level) - level, 0), out=phase[1:])
    np.cumsum(present, out=count[1:])


def sum_overlapping(p: Numbers, factors: NDArray[np.int64], order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over all starting points."""
    for k, m in enumerate(factors.tolist()):
        out[k] = _squares(p, m, order)


def sum_strides(p: Numbers, factors: NDArray[np.int64], order: int, out: Array) -> None:
    """Fill ``out`` with the sums of squared differences of an order, 2 or 3, over windows that do not overlap."""
    for k, m in enumerate(factors.tolist()):
        out[k] = _squares(p[::m], 1, order)


def _squares(p: Numbers, m: int, order: int) -> float:
    d = p
    for _ in range(order):
        d = d[m:] - d[:-m]
    d = d.astype(np.float64, copy=False)
    return float(d @ d)
