"""The integrated signal ("phase") behind all deviations: sums of the samples before each point.

Float samples have a level taken off first, so that 1e-3 of scatter beside an offset of 1e6 keeps its digits, and are
summed in float64 whatever their type. Whole numbers (raw counts) are summed as int64, without any rounding; numbers so
large that the sums might not fit are refused.

A quantity is one of three, which only the unit tells apart; each is known or asked for, never assumed:

``rate``       mean over the sample of an angular rate or acceleration [rad/s, m/s^2]
``increment``  what was added during the sample interval [rad, m/s]
``angle``      the integral itself, angle or velocity, at the stamp [rad, m/s]
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, empty, thinned
from ...core.errors import DataError
from ...core.estimate import Numbers
from ..names import Quantity
from ..threads import LARGE
from .loops import loops_for

QUANTITIES = ("rate", "increment", "angle")
LEVEL_FROM = 8192  # samples, spread over the record, that the level is the mean of
LINE = 64  # bytes of a cache line
LARGEST = 2**60  # sum of whole numbers that is still safe for differences of four

KEPT = 2**24  # bytes of the memory that is kept

NOTHING_MISSING = np.empty(0, dtype=np.int32)
_spare: list[NDArray[np.uint8]] = []


@dataclass(frozen=True, eq=False)
class Phase:
    """The integrated signal of one channel."""

    values: Numbers  # one point more than samples, or as many for an integrated signal, shape (points,)
    # number of samples (or points) there before each point, shape (points,) (or (points + 1,)); empty if none misses
    count: NDArray[np.int32]
    pointwise: bool  # whether points themselves are missing, as in an integrated signal, rather than samples
    missing: int = 0  # samples that are not there

    @property
    def complete(self) -> bool:
        """Whether no sample misses."""
        return not len(self.count)


def phase_of(x: Numbers, quantity: Quantity, present: NDArray[np.bool_] | None = None) -> Phase:
    """Return the phase of one channel, shape (n,); samples that are NaN, infinite or not ``present`` are missing.

    Raises
    ------
    DataError
        If no sample is there, or sums of whole numbers do not fit into int64.
    """
    whole = x.dtype.kind in "iub"
    there = None if present is None or present.all() else present
    if not whole and there is None:
        found = _complete(x, quantity)
        if np.isfinite(found.values[-1]) and (quantity != "angle" or np.isfinite(found.values.sum())):
            return found
    if not whole:
        finite = np.isfinite(x)
        there = finite if there is None else there & finite
    if there is not None and not there.any():
        raise DataError("no valid sample: all are missing or not finite", code="all_missing")
    return _complete(x, quantity) if there is None or there.all() else _with_gaps(x, quantity, there)


def _complete(x: Numbers, quantity: Quantity) -> Phase:
    if x.dtype.kind == "f" and quantity != "angle" and len(x) < LARGE:
        short = np.empty(len(x) + 1)
        loops_for(len(short)).integrate_all(x, max(1, len(x) // LEVEL_FROM), short)
        return Phase(short, NOTHING_MISSING, pointwise=False)
    level = level_of(x)
    if quantity == "angle":
        return Phase(_less(x, level), NOTHING_MISSING, pointwise=True)
    # Empty array that starts on a cache line: so do windows of 8, 16, ... samples, which are read faster
    kind = summed_as(x)
    size = (len(x) + 1) * np.dtype(kind).itemsize
    try:
        owner = _spare.pop()
    except IndexError:
        owner = np.empty(0, dtype=np.uint8)
    if len(owner) < size + LINE:
        owner = np.empty(size + LINE, dtype=np.uint8)
    skip = -owner.ctypes.data % LINE
    phase = owner[skip : skip + size].view(kind)
    loops_for(len(phase)).integrate(x, level, phase)
    return Phase(phase, NOTHING_MISSING, pointwise=False)


def give_back(phase: Phase) -> None:
    """Keep the memory of a phase that nobody reads any more, for the next channel.

    The first touch of fresh memory takes as long as the sums of a phase. One array of up to 16 MB is kept.
    """
    owner = phase.values.base
    if isinstance(owner, np.ndarray) and owner.dtype == np.uint8 and LINE < len(owner) <= KEPT:
        _spare[:] = [owner]


def _with_gaps(x: Numbers, quantity: Quantity, there: NDArray[np.bool_]) -> Phase:
    missing = int(len(x) - np.count_nonzero(there))
    level = level_of(x, there)
    if quantity == "angle":
        count = np.concatenate([[0], np.cumsum(there)]).astype(np.int32)
        return Phase(np.where(there, _less(np.where(there, x, level), level), 0), count, True, missing)
    phase, count = empty(len(x) + 1, summed_as(x)), empty(len(x) + 1, np.int32)
    loops_for(len(phase)).integrate_present(x, there, level, phase, count)
    return Phase(phase, count, False, missing)


def summed_as(x: Numbers) -> type[np.generic]:
    """Return the type that samples are summed in."""
    return np.int64 if x.dtype.kind in "iub" else np.float64


def _less(x: Numbers, level: Any) -> Numbers:
    less: Numbers = x.astype(summed_as(x)) - level
    return less


def level_of(x: Numbers, there: NDArray[np.bool_] | None = None) -> np.int64 | np.float64:
    """Return what is taken off each sample: about their mean; exactly their value where all are equal."""
    step = max(1, len(x) // LEVEL_FROM)
    sample = thinned(x, step)
    if there is not None:
        sample = sample[thinned(there, step)]
    if x.dtype.kind in "iub":
        ends = [(int(part.min()), int(part.max())) for part in (x[a:b] for a, b in batches(x))]
        least, most = min(low for low, _ in ends), max(high for _, high in ends)
        first = int(sample[0]) if len(sample) else least
        level = first + sum(int(value) - first for value in sample) // max(1, len(sample))
        largest = max(most - level, level - least)
        if largest * (len(x) + 1) > LARGEST or most > np.iinfo(np.int64).max:
            raise DataError(
                f"whole numbers from {least} to {most} in {len(x)} samples",
                why="their sums do not fit into 64 bits",
                do="Give them as floats, or cut the record",
                code="counts_too_large",
            )
        return np.int64(level)
    sample = sample.astype(np.float64)
    if not len(sample) and there is not None:
        sample = x[there][:1].astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.float64(sample[0] + (sample - sample[0]).sum() / len(sample))
