"""Ramps of a temperature: where it turns, and which samples lie on a path of warming or of cooling.

A turn counts when the temperature has come back from it by the distance ``reversal``: noise and the wander of a chamber
are no turns. What lies within that distance of a turn, after it, is on no path yet: the unit is still on its way from
one to the other. A steady temperature belongs to the path by which it was reached, up to where it turns, because
hysteresis keeps the side that the last ramp left it on.

The start of a record is taken as a turn: which way it was reached is not known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, count, near, zeros
from ...core.errors import DataError, PlanError
from ...core.estimate import Array

NEAR = 0.03  # of the reversal: as near a turn the temperature still stays there
BLOCKS = 500  # that a record is cut into at most, to find its turns
WARMING, COOLING, NO_PATH = 1, -1, 0


@dataclass(frozen=True, eq=False)
class Ramps:
    """Samples of a record by their path."""

    path: NDArray[np.int8]  # 1 warming, -1 cooling, 0 on no path, shape (n,)
    starts: tuple[int, ...]  # First sample of each ramp; that of the first one is 0
    ways: tuple[int, ...]  # 1 or -1 of each ramp

    def __len__(self) -> int:
        return len(self.ways)


def find_ramps(temperature: Array, reversal: float) -> Ramps:
    """Return the ramps of a record.

    Parameters
    ----------
    temperature : ndarray, shape (n,)
        In order of time [degC]; NaN where missing, which is on no path.
    reversal : float
        Way back from a turn that makes it one [degC].

    Returns
    -------
    Ramps
        None at all where the temperature never moves by so much.

    Raises
    ------
    DataError
        If no temperature is finite.
    PlanError
        If ``reversal`` is not positive.
    """
    if not reversal > 0.0:
        raise PlanError(f"reversal {reversal:g} degC: need more than 0")
    from ._kernels_ramps import fill_path  # noqa: PLC0415 - numba starts slowly

    valid = count(temperature, np.isfinite)
    if not valid:
        raise DataError("no valid temperature", code="no_valid_sample")
    level, begins = _levels(temperature, valid)
    turns, ways = _turns(level, reversal)
    path = zeros(len(temperature), np.int8)
    starts = [0, *(int(begins[at]) for at in turns[1:])][: len(turns)]
    ends = [*starts[1:], len(temperature)][: len(turns)]
    for at, start, stop, way in zip(turns, starts, ends, ways, strict=True):
        own, warm = path[start:stop], temperature[start:stop]
        for first, last in batches(own, warm, size=near()):
            fill_path(np.array(warm[first:last], dtype=np.float64), level[at], way, reversal, own[first:last])
    return Ramps(path, tuple(starts), tuple(ways))


def _levels(temperature: Array, valid: int) -> tuple[Array, NDArray[np.int64]]:
    """Return the means of blocks of the valid samples, the last one shorter, and the first sample of each."""
    from ._kernels_ramps import add_levels  # noqa: PLC0415 - numba starts slowly

    size = -(-valid // BLOCKS)
    level, held = np.empty(-(-valid // size)), np.zeros(2, dtype=np.int64)
    begins = np.empty(len(level), dtype=np.int64)
    for first, stop in batches(temperature):
        part = temperature[first:stop]
        add_levels(np.array(part, dtype=np.float64), first, size, held, level, begins)
    if held[1]:
        level[-1] /= held[1]
    return level, begins


def _turns(level: Array, reversal: float) -> tuple[list[int], list[int]]:
    """Return where each ramp begins and which way it goes; none where nothing moves."""
    from ._kernels_ramps import fill_turns  # noqa: PLC0415 - as above

    turns, ways = np.empty((2, len(level)), dtype=np.int64)
    count = fill_turns(level, reversal, NEAR * reversal, turns, ways)
    return turns[:count].tolist(), ways[:count].tolist()
