"""Changes of gain: level and scatter by one factor, and what is none."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND
from inertialcal.rigs.sams_tsh import rig as sams_tsh
from inertialcal.rigs.sams_tsh.campaign import BEGIN, FILE
from inertialcal.signals.segmentation.block_statistics import block_statistics
from inertialcal.signals.segmentation.gain_changes import GainChange, gain_changes

RATE, NOISE = 25.0, 3.0
STAMPS = np.rint(np.arange(45_000) / RATE * SECOND).astype(np.int64)


def record() -> Array:
    """Half an hour at three levels, a turn at 900 s."""
    x = np.random.default_rng(1).normal([1000.0, -900.0, 4.0], NOISE, (45_000, 3))
    x[22_500:22_600] += 800.0
    x[22_550:, 1:] += 5.0
    return x


def changes(x: Array) -> tuple[GainChange, ...]:
    return gain_changes(block_statistics(x, 1.0, STAMPS))


@pytest.mark.parametrize("factor", [0.1, 10.0, 100.0])
def test_level_and_scatter_change_by_the_factor(factor: float) -> None:
    x = record()
    x[30_000:, 1] *= factor
    (one,) = changes(x)
    assert one.channel == 1
    assert abs(one.time_ns / SECOND - 1200.0) <= 1.0
    assert one.level == pytest.approx(factor, rel=1e-2)
    assert one.scatter == pytest.approx(factor, rel=2e-2)


def test_turns_are_none_nor_is_acceleration_nor_vibration() -> None:
    x = record()
    assert not changes(x)
    x[30_000:, 2] += 200.0
    x[35_000:, 0] += 30.0 * np.sin(np.arange(10_000) * 1.3)
    x[5_000:6_000, 1] += 500.0
    assert not changes(x)


def test_the_mistake_of_the_rig_is_found_and_nothing_without_it() -> None:
    for fault, number in (("gain_changed", 1), ("", 0), ("robot_arm", 0), ("other_axis", 0)):
        recording = sams_tsh.RIG.twin(7, fault).recordings[FILE]
        found = gain_changes(block_statistics(recording.array(("x", "y", "z")), 1.0, recording.time_ns))
        assert len(found) == number
        assert all(abs(one.time_ns / SECOND - BEGIN - 1350.0) <= 1.0 for one in found)


def test_a_channel_that_never_varies_or_has_no_level_is_not_judged() -> None:
    x = np.random.default_rng(2).normal(0.0, 1.0, (45_000, 2))
    x[:, 1] = 7.0
    assert not changes(x)
