"""Rig of the flip: closed forms of its parts, counts that lead back to the truth, mistakes that do what they say."""

from __future__ import annotations

import time
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.campaign.inputs.chains import build_chain
from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND
from inertialcal.core.units import convert
from inertialcal.rigs import RIGS
from inertialcal.rigs.sams_tsh import rig as sams_tsh
from inertialcal.rigs.sams_tsh.campaign import BEGIN, FILE, windows
from inertialcal.rigs.sams_tsh.record import (
    add_arm,
    add_push,
    aligned,
    hysteresis,
    line,
    low_pass,
    noise,
    polynomial,
    record,
    reduced,
    reduced_bench,
    slow_variation,
    temperature_course,
    through_filters,
)
from inertialcal.rigs.sams_tsh.rig import FAULTS, Bench, build
from inertialcal.rigs.sams_tsh.setup import CODES, UG, draw_head
from inertialcal.rigs.twin import Twin
from inertialcal.sensors.chain.conversion import convert as from_counts

RATE = 25.0
AXES = ("x", "y", "z")
NO_ERRORS = replace(Bench(), standards={})


def file_of(twin: Twin) -> CampaignFile:
    return CampaignFile.model_validate(tomllib.loads(twin.campaign.replace("@SEED@", "1")))


def readings(twin: Twin) -> tuple[Array, Array, Array]:
    """Time [s], readings [m/s^2] and temperatures [degC] of a twin by its own campaign file, as a user would."""
    recording, sensor = twin.recordings[FILE], file_of(twin).sensors["head"]
    assert recording.time_ns is not None
    seconds = (recording.time_ns - BEGIN * SECOND) / SECOND
    if sensor.chain.kind == "none":
        return seconds, convert(recording.array(AXES), "ug", "m/s^2"), recording.array(recording.names[3:])
    warm = recording.array([f"temperature_{axis}" for axis in AXES])
    found = from_counts(build_chain(sensor), recording.array(AXES), temperature=warm)
    assert found.readings is not None
    assert found.temperature is not None
    return seconds, found.readings, found.temperature


def dwell_means(twin: Twin, bench: Bench) -> Array:
    """Means of the stated windows after settling, shape (windows, 3) [m/s^2]."""
    seconds, read, _ = readings(twin)
    return np.array([read[(seconds >= a + bench.settle) & (seconds < b)].mean(axis=0) for a, b, _ in windows(bench)])


def truth(twin: Twin, quantity: str) -> Array:
    return np.array([one.value for one in twin.truth if one.quantity == quantity])


@pytest.mark.parametrize(("poles", "cut_off"), [(1, 10.0), (7, 5.0), (7, 50.0)])
def test_the_gain_of_a_filter_at_its_corner_is_the_root_of_a_half(poles: int, cut_off: float) -> None:
    rate = 5.0 * cut_off
    t = np.arange(round(400.0 * rate / cut_off)) / rate
    for frequency, gain in ((cut_off, np.sqrt(0.5)), (0.02 * cut_off, 1.0)):
        wave = np.exp(2j * np.pi * frequency * t)
        out = low_pass(np.column_stack([wave.real, wave.imag]), poles, cut_off, rate)[len(t) // 2 :]
        found = np.abs((out[:, 0] + 1j * out[:, 1]) * np.conj(wave[len(t) // 2 :]))
        assert found.mean() == pytest.approx(gain, rel=1e-3)


def test_a_filter_of_seven_poles_falls_by_42_dB_an_octave_and_lets_a_level_through() -> None:
    step = np.zeros((4000, 1))
    step[0] = 1.0
    impulse = low_pass(step - step[0] + 1.0, 7, 1.0, 25.0)  # at rest at its first sample
    assert impulse[0] == pytest.approx(1.0)
    t = np.arange(20_000) / 1000.0
    wave = np.exp(2j * np.pi * 4.0 * t)
    out = low_pass(np.column_stack([wave.real, wave.imag]), 7, 1.0, 1000.0)[15_000:]
    assert 20.0 * np.log10(np.hypot(*out.T).mean()) == pytest.approx(-84.3, abs=0.1)
    assert through_filters(np.full((50, 3), 7.0), 25.0) == pytest.approx(np.full((50, 3), 7.0))


@pytest.mark.parametrize("corner", [0.0, 0.1])
def test_the_noise_has_the_density_and_the_corner_that_are_asked_for(corner: float) -> None:
    x = noise(2.0, corner, 90_000, 6, RATE, np.random.default_rng(2))
    f, density = signal.welch(x, RATE, nperseg=4096, axis=0)
    mean = density.mean(axis=1)
    white = (f > 5.0) & (f < 12.0)
    assert mean[white].mean() == pytest.approx(4.0 * (1.0 + corner / 8.0), rel=0.03)
    if corner > 0.0:
        near = (f > 0.08) & (f < 0.125)
        assert mean[near].mean() == pytest.approx(8.0, rel=0.15)


def test_ambient_parts_have_the_means_and_sizes_that_are_asked_for() -> None:
    t = np.arange(90_000) / RATE
    slow = slow_variation(t, np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.0, 0.1]), 3600.0, 0.3)
    assert slow.mean(axis=0) == pytest.approx([1.0, 2.0, 3.0], abs=1e-4)
    assert slow.max(axis=0) == pytest.approx([1.5, 2.0, 3.1], abs=1e-4)
    assert line(t, 4.7, np.array([2.0, 0.0, 0.0]), 0.0).std(axis=0) == pytest.approx([np.sqrt(2.0), 0.0, 0.0], rel=1e-3)
    push = np.zeros((90_000, 3))
    add_push(push, t, 100.0, np.array([300.0, 100.0, 0.0]), 1.3, 2.0)
    assert not push[t < 100.0].any()
    assert not push[t > 117.0].any()
    assert abs(push[:, 0].sum()) / RATE < 0.02 * np.abs(push[:, 0]).sum() / RATE
    arm = np.zeros((90_000, 3))
    add_arm(arm, t, (500.0, 700.0), np.array([0.0, 20.0, 0.0]), 0.25, 0.0)
    assert not arm[(t < 500.0) | (t > 700.0)].any()
    assert np.abs(arm[:, 1]).max() == pytest.approx(20.0, rel=1e-3)
    assert abs(arm[:, 1].mean()) < 0.01


def test_temperature_polynomial_and_hysteresis() -> None:
    t: Array = np.arange(7200, dtype=np.float64)
    warm = temperature_course(t, np.array([18.0, 17.0, 16.0]), 2.0, 600.0, 0.0, 5400.0, 0.0)
    assert warm[0] == pytest.approx([18.0, 17.0, 16.0])
    assert warm[600] - warm[0] == pytest.approx(np.full(3, 2.0 * (1.0 - np.exp(-1.0))))
    coefficients = np.random.default_rng(1).normal(size=(5, 3))
    away = warm - 18.0
    expected = sum(coefficients[i] * away**i for i in range(5))
    assert polynomial(coefficients, away) == pytest.approx(expected)
    wave = np.sin(2.0 * np.pi * t / 3600.0)[:, None]
    loop = hysteresis(wave, 1.0, 3.0, 1e-9)
    assert np.all(loop[:890] == pytest.approx(3.0))
    assert np.all(loop[910:2690] == pytest.approx(-3.0))


def test_the_counts_lead_back_to_the_truth() -> None:
    bench = replace(NO_ERRORS, density_ug=0.01, corner=0.0, pushes=0.0, swing_ug=0.0)
    for seed in range(3):
        twin = build(bench, seed)
        forward, turned, again, back = dwell_means(twin, bench)
        ambient, bias = truth(twin, "ambient_acceleration"), truth(twin, "bias")
        found = 0.25 * (forward - turned - again + back)
        cross = 0.01 * float(np.linalg.norm(ambient))  # of the misalignment, which the campaign does not state
        assert found[1:] == pytest.approx(ambient[1:], abs=cross + 0.02 * UG)
        assert found[0] == pytest.approx(0.0, abs=cross + 0.02 * UG)
        middle = 0.25 * (forward + turned + again + back)
        assert middle[1:] == pytest.approx(bias[1:], abs=cross + 0.05 * UG)
        assert middle[0] == pytest.approx(bias[0] + ambient[0], abs=cross + 0.05 * UG)


def test_temperatures_lead_back_too() -> None:
    twin = sams_tsh.RIG.twin(3)
    _, _, warm = readings(twin)
    start = np.array(twin.drawn["temperature_start"])
    assert warm[:100].mean(axis=0) == pytest.approx(start, abs=2e-3)


def test_errors_of_the_standards_do_what_the_reduction_takes_them_to_do() -> None:
    bench = replace(reduced_bench(0.0, (1200.0, 2400.0), (180.0, 0.0)), density_ug=0.0)
    head = aligned(draw_head(bench, np.random.default_rng(1)))
    large = {name: replace(one, u=100.0 * one.u) for name, one in Bench().standards.items()}
    for name, influence in large.items():
        made = record(replace(bench, standards={name: influence}), head, np.random.default_rng(2))
        plain = record(bench, head, np.random.default_rng(2))
        change = (made.readings - plain.readings)[[100, 45_000, 80_000]]
        if name == "converter.zero":
            assert change == pytest.approx(np.tile(made.errors.zero, (3, 1)))
        elif name == "sensor.scale_factor":
            assert change == pytest.approx(plain.readings[[100, 45_000, 80_000]] * made.errors.scale)
        else:
            assert np.abs(change[[0, 2]]).max() < 1e-15  # position 0 is where it is
            assert np.abs(change[1]).max() > 0.0
        if name == "turn.angle":
            g = plain.ambient
            angle = np.pi + made.errors.angle
            expected = [0.0, np.cos(angle) * g[1] + np.sin(angle) * g[2] + g[1]]
            assert change[1, :2] == pytest.approx(expected, abs=1e-12)


def test_the_truth_is_the_mean_over_the_record() -> None:
    made = reduced(4, 0.1, turn_starts=(), positions_deg=())
    assert made.readings.mean(axis=0) == pytest.approx(made.bias + made.ambient, rel=1e-12)
    bench = replace(NO_ERRORS, turn_starts=(), positions_deg=(), stopped_deg=(), filtered=False)
    head = aligned(draw_head(bench, np.random.default_rng(1)))
    shaken = record(bench, head, np.random.default_rng(2))  # with warming, drift, lines and pushes
    assert shaken.readings.mean(axis=0) == pytest.approx(shaken.bias + shaken.ambient, abs=0.02 * UG)


def test_biases_are_of_the_order_of_a_thousand_ug_under_a_few_ug_of_acceleration() -> None:
    twins = [reduced(seed, 0.0, turn_starts=(), positions_deg=()) for seed in range(20)]
    assert np.median(np.abs([one.bias for one in twins])) / UG == pytest.approx(1000.0, rel=0.2)
    assert 1.0 < np.median(np.abs([one.ambient for one in twins])) / UG < 5.0


def test_one_flip_is_made_in_less_than_fifty_milliseconds() -> None:
    reduced(1, 0.01)
    begin = time.process_time()
    for seed in range(10):
        reduced(seed, 0.01)
    assert (time.process_time() - begin) / 10.0 < 0.08  # 0.03 where nobody else uses the machine


def test_at_250_samples_a_second_the_same_physics_comes_out() -> None:
    bench = replace(NO_ERRORS, rate=250.0, duration=1200.0, turn_starts=(600.0,), positions_deg=(180.0,))
    bench = replace(bench, stopped_deg=(0.0,), corner=0.0, pushes=0.0)
    twin = build(bench, 2)
    recording = twin.recordings[FILE]
    assert len(recording) == 300_000
    assert recording.channel("x").data.dtype == np.int16
    before, after = dwell_means(twin, bench)
    found = 0.5 * (before - after)
    assert found[1:] == pytest.approx(truth(twin, "ambient_acceleration")[1:], abs=0.3 * UG)
    _, read, _ = readings(twin)
    f, density = signal.welch(read[25_000:125_000], 250.0, nperseg=8192, axis=0)
    low, high = (f > 8.0) & (f < 15.0), (f > 100.0)
    assert density[low, 0].mean() == pytest.approx(UG**2, rel=0.1)
    assert density[high, 0].mean() < 0.02 * UG**2  # beyond the filters nothing but the converter's steps


def test_the_turn_leaves_a_spike() -> None:
    seconds, read, _ = readings(build(replace(NO_ERRORS, pushes=0.0), 1))
    level = np.median(read, axis=0)
    turning = (seconds >= 1200.0) & (seconds < 1206.0)
    assert np.abs(read[turning] - level).max() > 100.0 * UG
    assert np.abs(read[seconds < 1199.0] - level).max() < 40.0 * UG


def test_the_campaign_file_is_valid_and_says_nothing_of_the_truth() -> None:
    twin = sams_tsh.RIG.twin(1)
    file = file_of(twin)
    assert {entry.file for entry in file.recordings.values()} == set(twin.recordings)
    assert file.tests[0].procedure == "flip"
    positions = vars(file.recordings["flip"])["positions"]
    assert [one.angle for one in positions] == pytest.approx([0.0, np.pi, np.pi, 0.0])
    for one in [one for one in twin.truth if one.value != 0.0]:
        assert f"{one.value:.6g}" not in twin.campaign
    for error in ("turn_angle_error", "turn_axis_error", "converter_zero_error", "scale_factor_error"):
        assert error in twin.drawn
        assert error not in twin.campaign


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, same, other = (sams_tsh.RIG.twin(seed) for seed in (4, 4, 5))
    assert one.recordings[FILE].array().tobytes() == same.recordings[FILE].array().tobytes()
    assert one.recordings[FILE].array().tobytes() != other.recordings[FILE].array().tobytes()
    assert one.truth == same.truth
    assert one.truth != other.truth
    assert RIGS["sams_tsh"] is sams_tsh.RIG


def test_a_mistake_that_is_not_known_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no fault 'gremlin'.*There are: not_turned"):
        sams_tsh.RIG.twin(1, "gremlin")


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_leaves_the_truth_and_every_mistake_changes_what_is_handed_over(fault: str) -> None:
    good, bad = sams_tsh.RIG.twin(7), sams_tsh.RIG.twin(7, fault)
    assert truth(bad, "ambient_acceleration") == pytest.approx(truth(good, "ambient_acceleration"))
    assert truth(bad, "bias") == pytest.approx(truth(good, "bias"))
    one, other = (twin.recordings[FILE].array(AXES).tobytes() + twin.campaign.encode() for twin in (good, bad))
    assert one != other


def of(fault: str) -> tuple[Bench, Twin]:
    return FAULTS[fault].put_into(Bench()), sams_tsh.RIG.twin(7, fault)


def test_not_turned_back_and_turned_about_another_axis_show_in_the_means() -> None:
    bench, twin = of("not_turned")
    forward, _, _, back = dwell_means(twin, bench)
    assert np.abs(back - forward)[1:].max() > 1.0 * UG
    bench, twin = of("other_axis")
    forward, turned, _, back = dwell_means(twin, bench)
    g = truth(twin, "ambient_acceleration")
    assert forward - turned == pytest.approx([2.0 * g[0], 2.0 * g[1], 0.0], abs=0.6 * UG)
    assert back == pytest.approx(forward, abs=0.6 * UG)


def test_a_gain_that_changes_and_rails_show_in_the_counts() -> None:
    _, twin = of("gain_changed")
    seconds, read, _ = readings(twin)
    before, after = (np.median(read[(seconds > a) & (seconds < b), 1]) for a, b in ((1300.0, 1349.0), (1351.0, 1400.0)))
    assert after / before == pytest.approx(0.1, rel=0.01)
    _, twin = of("at_rails")
    assert np.mean(np.isin(twin.recordings[FILE].channel("x").data, CODES)) > 0.9


def test_what_is_lost_too_short_or_misnamed() -> None:
    bench, twin = of("missing_position")
    assert {angle for _, _, angle in windows(bench)} == {0.0}
    seconds, _, _ = readings(twin)
    assert not np.any((seconds > 1202.0) & (seconds < 2404.0))
    bench, twin = of("too_short")
    assert [(b - a <= bench.settle, angle) for a, b, angle in windows(bench)] == [(False, 0), (True, 180), (False, 0)]
    _, twin = of("magnitude")
    _, read, _ = readings(twin)
    assert np.abs(np.median(read, axis=0)).max() < 0.01 * UG
    bench, twin = of("wrong_sign")
    good = np.median(readings(build(replace(bench, signs=(1, 1, 1)), 7))[1], axis=0)
    assert np.median(readings(twin)[1], axis=0) == pytest.approx(good * [1.0, -1.0, 1.0], abs=0.5 * UG)


def test_the_robot_arm_moves_during_the_flip_alone() -> None:
    _, twin = of("robot_arm")
    seconds, read, _ = readings(twin)
    difference = read - readings(sams_tsh.RIG.twin(7))[1]
    moving = (seconds > 2249.0) & (seconds < 2601.0)
    assert np.abs(difference[~moving]).max() < 2.0 * UG
    assert 5.0 * UG < np.abs(difference[moving]).max() < 45.0 * UG
