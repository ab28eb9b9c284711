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

from ...core.errors import DataError, PlanError
from ...core.estimate import Array

NEAR = 0.03  # of the reversal: as near a turn the temperature still stays there
BLOCKS = 500  # that a record is cut into at most, to find its turns
WARMING, COOLING, NO_PATH = 1, -1, 0


@dataclass(frozen=True, eq=False)
class Ramps:
    """Samples of a record by their path."""

    path: NDArray[np.int64]  # 1 warming, -1 cooling, 0 on no path, shape (n,)
    # number of the ramp that a sample belongs to, from 0; samples on no path have that of the ramp they begin, shape
    # (n,)
    ramp: NDArray[np.int64]
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
    good = np.flatnonzero(np.isfinite(temperature))
    if not len(good):
        raise DataError("no valid temperature", code="no_valid_sample")
    size = -(-len(good) // BLOCKS)
    starts = np.arange(0, len(good), size)
    level = np.add.reduceat(temperature[good], starts) / np.diff(np.append(starts, len(good)))
    turns, ways = _turns(level, reversal)
    path = np.zeros(len(temperature), dtype=np.int64)
    ramp = np.zeros(len(temperature), dtype=np.int64)
    ends = [*(int(good[starts[at]]) for at in turns[1:]), *([len(temperature)] if turns else [])]
    for number, (at, stop, way) in enumerate(zip(turns, ends, ways, strict=True)):
        start = int(good[starts[at]]) if number else 0
        away = way * (temperature[start:stop] - level[at])
        path[start:stop] = np.where(away >= reversal, way, NO_PATH)
        ramp[start:stop] = number
    return Ramps(path, ramp, tuple(ways))


def _turns(level: Array, reversal: float) -> tuple[list[int], list[int]]:
    """Return where each ramp begins and which way it goes; none where nothing moves."""
    turns: list[int] = []
    ways: list[int] = []
    lowest = highest = 0
    for i, value in enumerate(level.tolist()):
        way = ways[-1] if ways else NO_PATH
        if value < level[lowest]:
            lowest = i
        if value > level[highest]:
            highest = i
        if way != WARMING and value - level[lowest] >= reversal:
            turns.append(_leaves_turn(level, lowest, i, reversal))
            ways.append(WARMING)
            highest = i
        elif way != COOLING and level[highest] - value >= reversal:
            turns.append(_leaves_turn(level, highest, i, reversal))
            ways.append(COOLING)
            lowest = i
    return turns, ways


def _leaves_turn(level: Array, turn: int, stop: int, reversal: float) -> int:
    """Return where the temperature leaves a turn for good: it may stay there for long."""
    near = np.abs(level[turn:stop] - level[turn]) <= NEAR * reversal
    return turn + int(np.flatnonzero(near)[-1])
