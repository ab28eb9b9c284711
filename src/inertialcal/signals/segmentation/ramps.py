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
from ..remembered import remembered

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


@remembered
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
    valid = count(temperature, np.isfinite)
    if not valid:
        raise DataError("no valid temperature", code="no_valid_sample")
    level, begins = _levels(temperature, -(-valid // BLOCKS))
    turns, ways = _turns(level, reversal)
    path = zeros(len(temperature), np.int8)
    starts = [0, *(int(begins[at]) for at in turns[1:])][: len(turns)]
    ends = [*starts[1:], len(temperature)][: len(turns)]
    for at, start, stop, way in zip(turns, starts, ends, ways, strict=True):
        own, warm = path[start:stop], temperature[start:stop]
        for first, last in batches(own, warm, size=near()):
            own[first:last] = np.where(way * (warm[first:last] - level[at]) >= reversal, way, NO_PATH)
    return Ramps(path, tuple(starts), tuple(ways))


def _levels(temperature: Array, size: int) -> tuple[Array, NDArray[np.int64]]:
    """Return the means of blocks of so many valid samples, the last one shorter, and the first sample of each."""
    means, begins = [], []
    warm, at = np.empty(0), np.empty(0, dtype=np.int64)
    for first, stop in batches(temperature):
        here = np.flatnonzero(np.isfinite(temperature[first:stop]))
        warm, at = np.append(warm, temperature[first:stop][here]), np.append(at, first + here)
        whole = len(at) // size * size if stop < len(temperature) else len(at)
        starts = np.arange(0, whole, size)
        if whole:
            means.append(np.add.reduceat(warm[:whole], starts) / np.diff(np.append(starts, whole)))
            begins.append(at[starts])
        warm, at = warm[whole:], at[whole:]
    return np.concatenate(means), np.concatenate(begins)


def _turns(level: Array, reversal: float) -> tuple[list[int], list[int]]:
    """Return where each ramp begins and which way it goes; none where nothing moves."""
    turns: list[int] = []
    ways: list[int] = []
    at, way = 0, NO_PATH
    while True:  # from where one ramp is seen to where the next one is
        rest = level[at:]
        far = {WARMING: rest - np.minimum.accumulate(rest), COOLING: np.maximum.accumulate(rest) - rest}
        seen = [
            (int(np.argmax(off >= reversal)), one) for one, off in far.items() if one != way and off.max() >= reversal
        ]
        if not seen:
            return turns, ways
        stop, way = min(seen, key=lambda one: one[0])
        until = rest[: stop + 1]
        turn = at + int(until.argmin() if way == WARMING else until.argmax())
        turns.append(_leaves_turn(level, turn, at + stop, reversal))
        ways.append(way)
        at += stop


def _leaves_turn(level: Array, turn: int, stop: int, reversal: float) -> int:
    """Return where the temperature leaves a turn for good: it may stay there for long."""
    near = np.abs(level[turn:stop] - level[turn]) <= NEAR * reversal
    return turn + int(np.flatnonzero(near)[-1])
