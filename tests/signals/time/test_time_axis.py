"""Time axis: intervals, gaps and order against axes that were made by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.signals.time.time_axis import analyse, step_ends

MS = 1_000_000  # [ns]
S = 1_000 * MS


def test_an_even_axis() -> None:
    axis = analyse(np.arange(1001) * 10 * MS)
    assert (axis.n, axis.pattern, axis.interval, axis.duration) == (1001, "regular", 0.01, 10.0)
    assert axis.jitter_rms == axis.jitter_max == 0.0
    assert len(axis.gaps) == len(axis.repeated) == len(axis.backward) == 0
    assert axis.steps == ((0.01, 1000),)


def test_the_shortest_and_the_longest_step_are_those_of_the_stamps_as_they_are() -> None:
    stamps = np.array([0, 10, 15, 40])
    assert step_ends(stamps) == (5.0, 25.0)
    stamps[3] = 12
    assert step_ends(stamps) == (-3.0, 10.0)
    stamps.flags.writeable = False
    assert step_ends(stamps) == step_ends(stamps) == (-3.0, 10.0)
    assert step_ends(stamps[:3]) == (5.0, 10.0)
    assert step_ends(stamps[:1]) == (np.inf, -np.inf)


def test_saves_every_two_seconds_with_seventeen_late_by_one() -> None:
    # The thesis's telemetry: 1 s averages saved every 2 s, now and then 3 s apart.
    steps = np.full(3000, 2 * S)
    late = np.arange(17) * 150 + 70
    steps[late] = 3 * S
    axis = analyse(np.concatenate([[0], np.cumsum(steps)]), averaging=1.0)
    assert axis.interval == 2.0
    assert axis.steps == ((2.0, 2983), (3.0, 17))
    assert len(axis.gaps) == 17
    assert axis.lost == 0  # late, not lost
    assert axis.dead_time == 1.0
    np.testing.assert_array_equal(axis.gaps.after, late)


def test_lost_samples_are_counted_with_their_place() -> None:
    keep = np.ones(500, dtype=bool)
    keep[100:103] = keep[300] = False
    axis = analyse(np.flatnonzero(keep) * 10 * MS)
    assert axis.interval == 0.01
    np.testing.assert_array_equal(axis.gaps.after, [99, 296])
    np.testing.assert_allclose(axis.gaps.length, [0.04, 0.02])
    np.testing.assert_array_equal(axis.gaps.missing, [3, 1])
    assert axis.lost == 4


def test_one_sample_in_three_lost_at_random_keeps_the_interval() -> None:
    rng = np.random.default_rng(1)
    axis = analyse(np.flatnonzero(rng.random(9000) > 1 / 3) * 10 * MS)
    assert axis.pattern == "regular"
    assert axis.interval == 0.01


def test_jitter_is_that_of_the_steps_and_no_gap() -> None:
    rng = np.random.default_rng(2)
    jitter = rng.normal(0.0, 0.2 * MS, 20_000)
    axis = analyse((np.arange(20_000) * 10 * MS + jitter).astype(np.int64))
    assert axis.pattern == "regular"
    assert axis.interval == pytest.approx(0.01, rel=1e-3)
    assert axis.jitter_rms == pytest.approx(np.sqrt(2.0) * 0.2e-3, rel=0.03)  # a step holds two deviations
    assert len(axis.gaps) == 0


def test_packets_of_ten_have_the_interval_of_their_count() -> None:
    # Ten samples arrive within 9 ms every 100 ms: 100 Hz, though the median step is 1 ms.
    packets = np.arange(500)[:, None] * 100 * MS + np.arange(10) * MS
    axis = analyse(packets.reshape(-1))
    assert axis.pattern == "bursts"
    assert axis.median_step == 0.001
    assert axis.interval == pytest.approx(0.01, rel=0.002)
    assert len(axis.gaps) == 0
    assert axis.steps == ()


def test_stamps_of_one_second_for_a_sensor_of_ten_hertz() -> None:
    axis = analyse(np.repeat(np.arange(100), 10) * S)
    assert axis.pattern == "bursts"
    assert axis.interval == pytest.approx(0.1, rel=0.02)
    assert len(axis.repeated) == 900


def test_repeated_and_backward_stamps_are_placed() -> None:
    stamps = np.arange(100) * S
    stamps[50] = stamps[49]
    stamps[70] = stamps[68] - S // 2
    axis = analyse(stamps)
    np.testing.assert_array_equal(axis.repeated, [50])
    np.testing.assert_array_equal(axis.backward, [70])
    assert axis.interval == 1.0


def test_stamps_that_are_all_equal_have_no_interval() -> None:
    axis = analyse(np.full(5, 7 * S))
    assert (axis.pattern, axis.interval, axis.dead_time) == ("single", None, None)
    assert len(axis.repeated) == 4


def test_windows_that_overlap_have_a_negative_dead_time() -> None:
    axis = analyse(np.arange(20) * S, averaging=10.0)
    assert axis.dead_time == -9.0


def test_one_stamp_is_no_axis() -> None:
    with pytest.raises(DataError, match=r"a time axis of 1 stamp\(s\), need 2 or more"):
        analyse(np.array([5]))


def test_stamps_beyond_int64_nanoseconds() -> None:
    far = np.array([-(2**62) - 2**61, 2**62 + 2**61])
    with pytest.raises(DataError, match=r"stamps span .* more than 292 years"):
        analyse(far)


@given(
    start=st.integers(-(10**18), 10**18),
    interval=st.integers(1000, 10 * S),
    n=st.integers(30, 300),
    scale=st.integers(2, 9),
)
def test_shifting_the_origin_changes_nothing_and_scaling_scales(start: int, interval: int, n: int, scale: int) -> None:
    rng = np.random.default_rng(n)
    steps = interval + rng.integers(-interval // 20, interval // 20 + 1, n)
    steps[n // 2] += 5 * interval
    stamps = np.concatenate([[0], np.cumsum(steps)])
    here, there, scaled = analyse(stamps), analyse(stamps + start), analyse(stamps * scale)
    assert there.interval == here.interval
    np.testing.assert_array_equal(there.gaps.after, here.gaps.after)
    assert here.interval is not None
    assert scaled.interval == pytest.approx(scale * here.interval)
    np.testing.assert_array_equal(scaled.gaps.missing, here.gaps.missing)
    assert here.lost == 5


@given(st.lists(st.integers(-(2**62), 2**62 - 1), min_size=2, max_size=60))
def test_any_stamps_give_counts_that_add_up(stamps: list[int]) -> None:
    axis = analyse(np.array(stamps, dtype=np.int64))
    steps = np.diff(np.array(stamps, dtype=object))
    assert len(axis.repeated) == sum(step == 0 for step in steps)
    assert len(axis.backward) == sum(step < 0 for step in steps)
    assert axis.interval is None or axis.interval > 0.0
    assert np.isfinite([axis.duration, axis.jitter_rms, axis.jitter_max, axis.median_step]).all()
