"""Turns of a head and quiet windows beside them: synthetic truth, noise in which there are none, a whole day."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Sequence

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND, Times
from inertialcal.rigs.parts.noise import flicker
from inertialcal.signals.segmentation.block_statistics import block_statistics
from inertialcal.signals.segmentation.level_changes import Change, Series, _scores, at_spike
from inertialcal.signals.segmentation.turn_windows import quiet_part, turn_windows
from inertialcal.signals.segmentation.turns import Turn, TurnPlan, Turns, _taken, find_turns

RATE = 25.0  # samples a second
NOISE = 3.0  # ug, of a sample
AMBIENT = (3.0, 4.0, -2.0)  # ug
TURNS = ((1200.3, 1204.8), (2400.6, 2405.1))  # s
BLOCK = 1.0  # s
EPOCH = 824_817_600 * SECOND


def record(
    seed: int = 1,
    ambient: tuple[float, float, float] = AMBIENT,
    turns: tuple[tuple[float, float], ...] = TURNS,
    corner: float = 0.0,
    seconds: float = 3600.0,
    spike: float = 1000.0,
) -> tuple[Array, Times]:
    """Readings [ug] of a head that is turned by half a turn about x at each of the turns, (n, 3), and their stamps."""
    rng = np.random.default_rng(seed)
    n = round(seconds * RATE)
    x = rng.normal([1000.0, -900.0, 1200.0], NOISE, (n, 3))
    if corner > 0.0:
        x += flicker(2.0 * NOISE**2 / RATE * corner, n, 3, rng)
    t = np.arange(n) / RATE
    sign = np.ones(n)
    for start, stop in turns:
        inside = (t >= start) & (t < stop)
        x[inside] += spike * np.cos(np.pi * (t[inside, None] - start) / (stop - start)) * [0.3, -1.0, 0.7]
        sign[t >= 0.5 * (start + stop)] *= -1.0
    x += np.column_stack([np.full(n, ambient[0]), ambient[1] * sign, ambient[2] * sign])
    return x, EPOCH + np.rint(t * SECOND).astype(np.int64)


def pushed(x: Array, at: float, size: float, seconds: float = 4.0) -> None:
    """Add a push by the crew to a record, at a time [s]."""
    a = round(at * RATE)
    since = np.arange(round(seconds * RATE)) / RATE
    x[a : a + len(since)] += (size * np.exp(-since) * np.sin(2.0 * np.pi * 1.7 * since + 1.0))[:, None]


def times(found: Turns) -> list[tuple[float, float]]:
    return [((one.start_ns - EPOCH) / SECOND, (one.stop_ns - EPOCH) / SECOND) for one in found.turns]


@pytest.mark.parametrize("corner", [0.0, 0.01, 0.1])
def test_turns_are_found_within_a_block(corner: float) -> None:
    for seed in range(5):
        found = find_turns(*record(seed, corner=corner))
        assert len(found.turns) == 2
        for (start, stop), (true_start, true_stop) in zip(times(found), TURNS, strict=True):
            assert abs(start - true_start) <= BLOCK
            assert abs(stop - true_stop) <= BLOCK
        assert not found.others
        assert not found.remarks


def test_the_step_is_twice_the_ambient_acceleration_and_the_control_keeps_its_level() -> None:
    first, second = find_turns(*record()).turns
    u = NOISE / np.sqrt(1200.0 * RATE) * np.sqrt(2.0)  # of the difference of the means of two dwells
    assert first.step == pytest.approx([0.0, -2.0 * AMBIENT[1], -2.0 * AMBIENT[2]], abs=8.0 * u)
    assert second.step == pytest.approx(-first.step, abs=12.0 * u)
    assert u < max(first.u_step) < 3.0 * u  # a drift is allowed for


def test_counts_give_the_same_turns_as_readings() -> None:
    x, stamps = record()
    counts = np.rint(x / 0.163).astype(np.int16)
    assert times(find_turns(counts, stamps)) == times(find_turns(x, stamps))
    assert times(find_turns(list(counts.T), stamps)) == times(find_turns(x, stamps))


def nothing_is_found(corner: float, records: int) -> None:
    """Find nothing in so many records of ten hours."""
    for seed in range(records):
        x, stamps = record(100 + seed, turns=(), corner=corner, seconds=36_000.0)
        found = find_turns(x, stamps)
        assert not found.turns
        assert not found.others
        assert found.quiet.mean() > 0.98


@pytest.mark.parametrize("corner", [0.0, 0.01, 0.1])
def test_no_turn_is_invented_in_quiet_noise(corner: float) -> None:
    nothing_is_found(corner, 1)


@pytest.mark.slow
@pytest.mark.parametrize("corner", [0.0, 0.01, 0.1])
def test_no_turn_is_invented_in_a_hundred_hours_of_quiet_noise(corner: float) -> None:
    nothing_is_found(corner, 10)


def test_a_push_by_the_crew_is_no_turn_and_is_remarked() -> None:
    x, stamps = record()
    for at in (300.0, 700.0, 1800.0, 3100.0):
        pushed(x, at, 400.0)
    found = find_turns(x, stamps)
    assert len(found.turns) == 2
    assert [round((one.start_ns - EPOCH) / SECOND) for one in found.others] == [300, 700, 1800, 3100]
    remark = found.remarks[0]
    assert (remark.code, remark.count) == ("spike_without_step", 4)
    assert "give the windows" in remark.do
    assert found.certain  # the level stays: a turn there is excluded


def test_pushes_alone_are_no_turns() -> None:
    rng = np.random.default_rng(5)
    for seed in range(5):
        x, stamps = record(seed, turns=(), corner=0.1)
        for at in rng.uniform(50.0, 3500.0, 8):
            pushed(x, float(at), 500.0 * float(rng.normal()))
        assert not find_turns(x, stamps).turns


def at(found: Sequence[Turn]) -> list[float]:
    return [(one.middle_ns - EPOCH) / SECOND for one in found]


MIDDLES = [0.5 * (a + b) for a, b in TURNS]


def test_turns_to_and_fro_need_no_spike() -> None:
    found = find_turns(*record(spike=0.0))
    assert at(found.turns) == pytest.approx(MIDDLES, abs=12.0)
    for one, middle in zip(found.turns, MIDDLES, strict=True):
        assert abs((one.middle_ns - EPOCH) / SECOND - middle) < 3.0 * one.u
        assert not one.felt
    assert not found.doubt


def test_a_single_change_without_a_spike_may_be_a_turn_or_a_jump_of_the_bias() -> None:
    found = find_turns(*record(spike=0.0, turns=TURNS[:1]))
    assert not found.turns
    assert at(found.shifts) == pytest.approx(MIDDLES[:1], abs=12.0)
    assert "once, without a spike" in found.doubt


def test_a_bias_that_jumps_between_turns_is_named() -> None:
    x, stamps = record()
    x[round(1800 * RATE) :, 1] += 6.0
    found = find_turns(x, stamps)
    assert at(found.turns) == pytest.approx(MIDDLES, abs=3.0)
    assert at(found.shifts) == pytest.approx([1800.0], abs=12.0)
    assert not found.doubt


def test_levels_that_do_not_go_to_and_fro_are_left_to_whoever_knows() -> None:
    x, stamps = record(turns=())
    for k, start in enumerate((700.0, 1400.0, 2100.0, 2800.0)):
        x[round(start * RATE) :, 1] += (4.0, -1.0, -7.0, 2.0)[k]
        x[round(start * RATE) :, 2] += (-2.0, -5.0, 2.0, 6.0)[k]
    found = find_turns(x, stamps)
    assert not found.turns
    assert "not to and fro" in found.doubt
    assert at(found.shifts) == pytest.approx([700.0, 1400.0, 2100.0, 2800.0], abs=12.0)


@pytest.mark.parametrize("length", [20.0, 60.0, 120.0])
@pytest.mark.parametrize("spike", [0.0, 100.0])
def test_turns_of_any_length_are_found_with_the_whole_dwell(length: float, spike: float) -> None:
    turns = tuple((start, start + length) for start in (500.0, 1100.0, 1700.0, 2300.0, 2900.0))
    x, stamps = record(3, ambient=(1.0, 1.5, 0.0), turns=turns, spike=spike)
    found = find_turns(x, stamps)
    assert at(found.turns) == pytest.approx([a + 0.5 * length for a, _ in turns], abs=15.0)


def test_slow_noise_drift_and_waves_are_no_turns() -> None:
    for seed in range(2):
        x, stamps = record(seed, turns=(), corner=0.5, seconds=5400.0)
        t = (stamps - EPOCH) / SECOND
        wave = 2.0 * np.sin(2.0 * np.pi * t / 5400.0 + seed)
        assert not find_turns(x, stamps).turns
        assert not find_turns(x + (3.0 * t / 3600.0)[:, None], stamps).turns
        assert not find_turns(x + wave[:, None], stamps).turns


def test_a_change_goes_with_the_spike_that_it_lies_in_not_with_a_shorter_one_near_it() -> None:
    push, turn = Change(1650.0, 1700.0), Change(1725.0, 1830.0)
    assert at_spike(Change(1725.0, 1725.0), (push, turn)) == turn


def test_no_window_reaches_into_a_smooth_turn_that_only_means_show() -> None:
    start, stop = 1200.0, 1320.0
    x, stamps = record(seconds=2400.0, turns=())
    s = np.clip(((stamps - EPOCH) / SECOND - start) / (stop - start), 0.0, 1.0)
    angle = np.pi * s - 0.5 * np.sin(2.0 * np.pi * s)
    x += np.column_stack([0.0 * s, 20.0 * np.cos(angle), -20.0 * np.sin(angle)])
    (pair,) = turn_windows(find_turns(x, stamps))
    assert pair.before is not None
    assert pair.after is not None
    assert (pair.before.stop_ns - EPOCH) / SECOND < start + 5.0
    assert (pair.after.start_ns - EPOCH) / SECOND > stop - 5.0


def test_two_changes_within_a_minute_are_no_turns() -> None:
    step, u = np.array([0.0, 8.0, -6.0]), np.ones(3)

    def turn(at: float, sign: float) -> Turn:
        ns = round(at * SECOND)
        return Turn(ns, ns + 5 * SECOND, ns + 2 * SECOND, 1.0, 30.0, sign * step, u, felt=True)

    assert _taken([turn(3425.0, 1.0), turn(3600.0, -1.0)])[0]
    turns, changes, why = _taken([turn(3425.0, 1.0), turn(3445.0, -1.0)])
    assert not turns
    assert len(changes) == 2
    assert "twice in less than a minute" in why


def test_a_turn_in_no_acceleration_is_not_certain() -> None:
    found = find_turns(*record(ambient=(2.0, 0.0, 0.0)))
    assert not found.turns
    assert not found.certain
    assert [one.code for one in found.remarks] == ["spike_without_step"]


def test_gaps_do_not_shift_a_turn_nor_make_one() -> None:
    x, stamps = record()
    t = (stamps - EPOCH) / SECOND
    kept = ~((t > 500.0) & (t < 800.0)) & ~((t > 3000.0) & (t < 3000.7))
    x[(t > 1500.0) & (t < 1503.0), 1] = np.nan
    found = find_turns(x[kept], stamps[kept])
    assert times(found) == times(find_turns(*record()))
    x, stamps = record(turns=())
    assert not find_turns(x[kept], stamps[kept]).turns


def test_windows_are_equally_long_equally_far_and_quiet() -> None:
    found = find_turns(*record())
    for pair in turn_windows(found):
        assert pair.quiet
        assert pair.before is not None
        assert pair.after is not None
        assert pair.before.length == pair.after.length == found.plan.widest
        assert pair.turn.start_ns - pair.before.stop_ns == pair.after.start_ns - pair.turn.stop_ns
        assert pair.turn.start_ns - pair.before.stop_ns == found.plan.settle * SECOND
    first = turn_windows(found)[0]
    assert first.before is not None
    assert first.after is not None
    half = 0.5 * (first.before.mean - first.after.mean)
    u = NOISE / np.sqrt(600.0 * RATE) / np.sqrt(2.0)
    assert half == pytest.approx([0.0, AMBIENT[1], AMBIENT[2]], abs=5.0 * u)
    x, _ = record()
    inside = x[first.before.start : first.before.stop]
    assert inside.mean(axis=0) == pytest.approx(first.before.mean, rel=1e-12)


def test_windows_stop_short_of_a_push_and_say_so_where_they_cannot() -> None:
    x, stamps = record()
    pushed(x, 1000.0, 300.0)
    short = turn_windows(find_turns(x, stamps))[0]
    assert short.quiet
    assert short.before is not None
    assert 180.0 <= short.before.length <= 186.0
    fixed = turn_windows(find_turns(x, stamps, plan=TurnPlan(window=300.0)))[0]
    assert not fixed.quiet
    assert [one.code for one in fixed.problems] == ["disturbed"]
    assert fixed.before is not None
    assert fixed.before.length == 300.0
    assert "(before), need 300 s quiet" in fixed.problems[0].what


def test_a_dwell_too_short_to_be_seen_is_passed_over() -> None:
    found = find_turns(*record(turns=((1200.0, 1204.0), (1234.0, 1238.0))))
    assert not found.turns  # the level before and after is one


def test_drift_louder_noise_and_warming_are_named() -> None:
    x, stamps = record()
    t = (stamps - EPOCH) / SECOND
    plan = TurnPlan(window=300.0, temperature_slope=1e-4)
    drifting = x + 5.0 * np.clip((t - 1250.0) / 250.0, 0.0, 1.0)[:, None]
    problems = turn_windows(find_turns(drifting, stamps, plan=plan))[0].problems
    assert {one.code for one in problems} <= {"not_stationary", "disturbed"}
    assert problems
    cold = block_statistics(18.0 + 5e-4 * t, plan.block, stamps)
    slope = turn_windows(find_turns(x, stamps, plan=plan), cold)[0].problems
    assert [one.code for one in slope] == ["temperature_slope"]
    assert "0.0005 degC/s" in slope[0].what
    steady = block_statistics(18.0 + 5e-5 * t, plan.block, stamps)
    assert turn_windows(find_turns(x, stamps, plan=plan), steady)[0].quiet
    with pytest.raises(DataError, match=r"different blocks"):
        turn_windows(find_turns(x, stamps, plan=plan), block_statistics(t, 2.0, stamps))
    louder = find_turns(x, stamps, plan=TurnPlan(window=300.0, variance_ratio=1.01))
    assert [one.code for one in turn_windows(louder)[0].problems] == ["not_stationary"]


def test_the_quiet_part_of_a_stretch() -> None:
    x, stamps = record()
    a = round(1500.0 * RATE)
    x[a : a + round(100.0 * RATE)] += 15.0 * np.sin(np.arange(round(100.0 * RATE))[:, None] * 0.05)
    found = find_turns(x, stamps)
    inside, whole, none = ((1500, 1600), (1400, 1700), (300, 900))
    parts = [quiet_part(found, EPOCH + a * SECOND, EPOCH + b * SECOND) for a, b in (inside, whole, none)]
    assert parts[0] < 0.1
    assert parts[1] == pytest.approx(2.0 / 3.0, abs=0.03)
    assert parts[2] == 1.0


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"block": 0.0}, "block 0, need a positive number"),
        ({"settle": -1.0}, "settle -1 s"),
        ({"variance_ratio": 1.0}, "variance_ratio 1, need more than 1"),
        ({"window": 1.0}, "a window needs two blocks or more"),
        ({"widest": 10.0}, "a window needs two blocks or more"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(change: dict[str, float], text: str) -> None:
    with pytest.raises(PlanError, match=text):
        TurnPlan(**change)


def test_a_record_that_is_too_short_is_refused() -> None:
    x, stamps = record(seconds=10.0, turns=())
    with pytest.raises(DataError, match=r"10 good sample\(s\) of 10, need 16 or more"):
        find_turns(x, stamps)


def test_shift_and_scale_of_the_readings_change_nothing() -> None:
    x, stamps = record()
    found = find_turns(x, stamps)
    other = find_turns(-9.8e-6 * x[:, ::-1] + 3.0, stamps)
    assert times(other) == times(found)
    assert other.turns[0].step == pytest.approx(-9.8e-6 * found.turns[0].step[::-1], rel=1e-6, abs=1e-12)
    assert np.array_equal(other.quiet, found.quiet)


def test_a_day_of_three_axes_at_250_samples_a_second() -> None:
    rate, hours = 250, 24
    rng = np.random.default_rng(8)
    n = hours * 3600 * rate
    counts = np.empty((3, n), dtype=np.int16)
    part = np.rint(rng.normal(0.0, 30.0, n // hours)).astype(np.int16)
    for axis in range(3):
        for hour in range(hours):
            counts[axis, hour * len(part) : (hour + 1) * len(part)] = np.roll(part, int(rng.integers(len(part))))
    turns = [(h * 3600.0 + 1800.0, h * 3600.0 + 1804.0) for h in range(1, hours, 4)]
    for start, stop in turns:
        a, b = round(start * rate), round(stop * rate)
        counts[:, a:b] += np.rint(3000.0 * np.cos(np.pi * np.arange(b - a) / (b - a))).astype(np.int16)
        counts[1:, a:] += np.int16(20 if start // 14400 % 2 else -20)
    stamps = np.arange(n, dtype=np.int64) * (SECOND // rate)
    find_turns(counts[:, : 400 * rate].T, stamps[: 400 * rate])  # compile
    tracemalloc.start()
    begin = time.process_time()
    found = find_turns(list(counts), stamps)
    pairs = turn_windows(found)
    used = time.process_time() - begin
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert at(found.turns) == pytest.approx([0.5 * (a + b) - EPOCH // SECOND for a, b in turns], abs=2.0)
    assert len(pairs) == len(turns)
    assert all(pair.before is not None and pair.after is not None for pair in pairs)
    assert used < 15.0  # a busy machine takes three times the 2 s of an idle one
    assert peak < 200 * 2**20  # beside the record itself


def test_the_score_of_a_step_is_what_least_squares_gain() -> None:
    """Without a walk: the fall of the sum of squares by a step before each block, beside a level and a line."""
    n, rng = 60, np.random.default_rng(1)
    seconds: Array = 10.0 * np.arange(n, dtype=np.float64)
    y = rng.standard_normal(n) + (np.arange(n) >= 30)
    found = _scores(Series(seconds, y[:, None], np.ones((n, 1)), 10.0), (), np.zeros(1))

    def squares(*columns: Array) -> float:
        X = np.column_stack([np.ones(n), seconds, *columns])
        return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=None)[0]) ** 2))

    gain = np.array([squares() - squares((np.arange(n) >= i).astype(np.float64)) for i in range(n)])
    np.testing.assert_allclose(found, gain / (squares() / (n - 1)), atol=1e-6)
