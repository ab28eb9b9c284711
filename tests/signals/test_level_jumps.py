"""Jumps of level that no turn explains."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.recording import SECOND
from inertialcal.signals.level_jumps import level_jumps
from inertialcal.signals.turns import find_turns

RATE, NOISE = 25.0, 3.0
STAMPS = np.rint(np.arange(45_000) / RATE * SECOND).astype(np.int64)


def record(turn: float = 5.0) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Half an hour at three levels, one turn at 900 s."""
    x = np.random.default_rng(1).normal([1000.0, -900.0, 1200.0], NOISE, (45_000, 3))
    x[22_500:22_600] += 800.0
    x[22_550:, 1:] += turn
    return x


def test_a_gain_that_changes_is_a_jump_of_level_and_scatter_by_one_factor() -> None:
    x = record()
    x[30_000:, 1] *= 0.1
    (jump,) = level_jumps(find_turns(x, STAMPS))
    assert abs(jump.time_ns / SECOND - 1200.0) <= 1.0
    assert jump.channels.tolist() == [False, True, False]
    assert jump.after[1] / jump.before[1] == pytest.approx(0.1, rel=1e-3)
    assert jump.scatter_ratio == pytest.approx([1.0, 0.1, 1.0], rel=0.02)


@pytest.mark.parametrize("turn", [0.0, 5.0, 200.0])
def test_turns_and_quiet_records_hold_no_jump(turn: float) -> None:
    assert not level_jumps(find_turns(record(turn), STAMPS))


def test_an_acceleration_that_changes_leaves_the_scatter() -> None:
    x = record()
    x[30_000:, 2] += 100.0
    (jump,) = level_jumps(find_turns(x, STAMPS))
    assert jump.after - jump.before == pytest.approx([0.0, 0.0, 100.0], abs=0.5)
    assert jump.scatter_ratio == pytest.approx(np.ones(3), rel=0.02)


def test_a_record_that_never_rests_has_none() -> None:
    assert not level_jumps(find_turns(np.random.default_rng(1).normal(size=(45_000, 1)).cumsum(axis=0), STAMPS))
