"""The rig of an IMU laid by hand: motion that closes, a truth that physics shows, mistakes as they are told."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Array
from inertialcal.rigs.hand_held.motion import carried, turn_between
from inertialcal.rigs.hand_held.rig import CHANNELS, FAULTS, RIG, Bench, Held, Unit, build, draw_unit, held

QUIET = replace(
    Bench(), acc_noise=0.0, gyro_noise=0.0, acc_between=0.0, gyro_between=0.0, lift=0.0, latitude=0.0, positions=8
)
IDEAL = replace(QUIET, scale=0.0, misalignment=0.0, acc_bias=0.0, gyro_bias=0.0, g_sensitivity=0.0)


def made(bench: Bench, seed: int = 1) -> tuple[Held, Unit, Array]:
    rng = np.random.default_rng(seed)
    unit = draw_unit(bench, rng)
    one = held(bench, unit, bench.gravity, bench.pace, 0, rng)
    return one, unit, one.recording.array(CHANNELS)


def still(one: Held) -> list[slice]:
    return [slice(part.start, part.stop) for part in one.parts if part.angle is None]


@pytest.mark.parametrize("spin", [0.0, 0.7, -2.0])
def test_a_turn_takes_up_where_it_should(spin: float) -> None:
    rng = np.random.default_rng(3)
    pairs = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(20, 2, 3))]
    for up, then in [*pairs, np.array([[0, 0, 1.0], [0, 0, -1.0]]), np.array([[0, 0, 1.0], [0, 0, 1.0]])]:
        vector = turn_between(up, then, spin)
        np.testing.assert_allclose(carried(up, vector, np.ones(1))[0], then, atol=1e-12)


def test_a_body_that_turns_left_sees_the_world_turn_right() -> None:
    """Turned by +90 degrees about z, what was along x lies along -y."""
    np.testing.assert_allclose(
        carried(np.array([1.0, 0, 0]), np.array([0, 0, np.pi / 2]), np.ones(1))[0], [0, -1, 0], atol=1e-15
    )


@pytest.mark.parametrize("variant", ["tumble", "ferraris"])
def test_an_ideal_unit_reads_gravity_and_rates_that_carry_it(variant: Any) -> None:
    """Integrated with the fine steps of the samples, the rates take gravity from position to position."""
    bench = replace(IDEAL, variant=variant)
    one, _, data = made(bench)
    acc, gyro = data[:, :3], data[:, 3:]
    places = still(one)
    for place in places:
        np.testing.assert_allclose(np.linalg.norm(acc[place], axis=1), bench.gravity, atol=1e-6)
        assert np.ptp(acc[place], axis=0).max() < 1e-5
    for here, there in pairwise(places):
        up = acc[here.start]
        for row in gyro[here.stop : there.start]:
            up = carried(up, row / bench.sample_rate, np.ones(1))[0]
        np.testing.assert_allclose(up, acc[there.start], atol=8e-3)  # the earth turns on meanwhile


def test_readings_are_the_sensor_equation() -> None:
    one, unit, data = made(replace(QUIET, latitude=0.8))
    force, rate = one.motion.force, one.motion.rate
    acc = [unit.acc_matrix @ f + unit.acc_bias for f in force[::50]]
    gyro = [
        unit.gyro_matrix @ w + unit.g_sensitivity @ f + unit.gyro_bias
        for w, f in zip(rate[::50], force[::50], strict=True)
    ]
    np.testing.assert_allclose(data[::50], np.hstack([acc, gyro]), atol=1e-7)
    assert not np.any(np.triu(unit.acc_matrix, 1))


def test_still_intervals_have_the_scatter_that_was_asked_for() -> None:
    bench = replace(Bench(), positions=60, dwell=2.0, spread=0.1)
    one, unit, data = made(bench)
    places = still(one)
    clean = one.motion.force @ unit.acc_matrix.T + unit.acc_bias
    off = np.array([np.mean(data[p, :3] - clean[p], axis=0) for p in places])
    n = np.mean([p.stop - p.start for p in places])
    expected = np.hypot(bench.acc_between, bench.acc_noise / np.sqrt(n))
    assert np.std(off) == pytest.approx(expected, rel=0.2)
    assert np.std(data[places[0], 0]) == pytest.approx(bench.acc_noise, rel=0.05)
    assert np.std(data[places[0], 4]) == pytest.approx(bench.gyro_noise, rel=0.05)


def test_ferraris_turns_have_the_angle_and_the_axis_that_are_told() -> None:
    bench = replace(IDEAL, variant="ferraris")
    one, _, data = made(bench)
    turns = [part for part in one.parts if part.angle is not None]
    assert [part.axis for part in turns] == [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)] * 2
    assert [part.angle for part in turns] == [2 * np.pi] * 3 + [-2 * np.pi] * 3
    for part in turns:
        angle = data[part.start : part.stop, 3:].sum(axis=0) / bench.sample_rate
        np.testing.assert_allclose(angle, part.angle * np.array(part.axis), atol=0.06)
    faces = [part.direction for part in one.parts if part.direction is not None]
    assert (len(faces), len(set(faces))) == (12, 6)
    for part in one.parts:
        if part.direction is not None:
            mean = data[part.start : part.stop, :3].mean(axis=0) / bench.gravity
            assert mean @ np.array(part.direction) > 0.9999


def test_truth_has_every_parameter_that_the_test_can_tell() -> None:
    values = RIG.twin(1).truth
    kinds = [value.sensor for value in values]
    # The bias of the gyros in the test of the fit and in that held out, which is the next record of the other
    assert (kinds.count("accelerometer"), kinds.count("gyro")) == (9, 12 + 9 + 3 + 3)
    assert len({(v.quantity, v.axis, v.sensor, v.test) for v in values}) == len(values)
    truth = {(v.quantity, v.axis, v.test): v.value for v in values if v.sensor == "gyro"}
    assert truth["bias_next_record", "x", "imu"] == truth["bias", "x", "imu_held_out"] != truth["bias", "x", "imu"]
    full = build(replace(Bench(), variant="ferraris"), 1).truth
    assert sum(v.sensor == "accelerometer" for v in full) == 12


def test_the_same_seed_is_the_same_to_the_bit_and_another_is_not() -> None:
    one, two, other = (build(replace(Bench(), positions=6), seed) for seed in (4, 4, 5))
    lots = [next(iter(t.recordings.values())).array(CHANNELS).tobytes() for t in (one, two, other)]
    assert lots[0] == lots[1] != lots[2]
    assert one.truth == two.truth


def test_campaign_file_is_toml_and_says_nothing_of_the_truth() -> None:
    for bench in (Bench(positions=5), Bench(variant="ferraris")):
        texts = {build(bench, seed).campaign for seed in (1, 2)}
        assert len(texts) == 1
        tomllib.loads(texts.pop())


def test_mistakes_do_what_they_say() -> None:
    plain = made(replace(Bench(), positions=8))
    acc, gyro = plain[2][:, :3], plain[2][:, 3:]

    def wrong(name: str) -> Array:
        return made(FAULTS[name].put_into(replace(Bench(), positions=8)))[2]

    np.testing.assert_allclose(wrong("acc_in_g")[:, :3] * 9.80665, acc, atol=1e-5)
    np.testing.assert_allclose(np.radians(wrong("gyro_in_deg")[:, 3:]), gyro, atol=1e-6)
    np.testing.assert_allclose(wrong("swapped_axes")[:, 3:], gyro[:, [1, 0, 2]])
    np.testing.assert_allclose(wrong("inverted_axis")[:, 3:], gyro * [1, 1, -1])
    knocked = np.flatnonzero(np.any(wrong("knocked") != plain[2], axis=1))
    part = plain[0].parts[4]
    assert part.start < knocked[0] < knocked[-1] < part.stop
    level = made(FAULTS["one_plane"].put_into(Bench()))[0]
    assert max(abs(level.motion.force[p, 2]).max() for p in still(level)) < 1e-9
    assert len(still(made(replace(Bench(), positions=3))[0])) == 3
    fast = build(replace(Bench(), positions=3, pace=0.5), 1)
    assert next(iter(fast.recordings.values())).sample_interval == pytest.approx(0.005, rel=1e-3)
    both = list(build(replace(Bench(), positions=3, copies=2), 1).recordings.values())
    assert both[0].array(CHANNELS).tobytes() == both[1].array(CHANNELS).tobytes()
    with pytest.raises(UsageError, match="no fault 'dropped'"):
        RIG.twin(1, "dropped")
