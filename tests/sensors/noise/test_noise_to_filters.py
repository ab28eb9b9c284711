"""Blocks of filters: units by hand-worked figures, the filters' own equations, what is not held or not told."""

from __future__ import annotations

import ast
import re
from typing import Any

import numpy as np
import pytest
import yaml

from inertialcal.core.errors import PlanError
from inertialcal.sensors.noise.state_space import state_space
from inertialcal.sensors.noise.terms import BiasInstability, GaussMarkov, RandomWalk, RateRandomWalk, Term
from inertialcal.sensors.noise.to_filters import FilterBlock, to_gtsam, to_kalibr, to_kf_gins, to_px4

DEG = np.pi / 180.0
HOUR = 3600.0
Axes = list[tuple[Term, ...]]
# KF-GINS' own example: 0.003 deg/sqrt(h), 0.03 m/s/sqrt(h), 0.027 deg/h, 15 mGal, 4 h
GYRO: Axes = [(RandomWalk(0.003 * DEG / 60.0), GaussMarkov(0.027 * DEG / HOUR, 4.0 * HOUR))]
ACCELEROMETER: Axes = [(RandomWalk(0.03 / 60.0), GaussMarkov(15e-5, 4.0 * HOUR))]
WALKS: Axes = [(RandomWalk(n), RateRandomWalk(k)) for n, k in ((1e-3, 2e-5), (3e-3, 1e-5), (2e-3, 4e-5))]


def values(block: FilterBlock) -> dict[str, tuple[float, ...]]:
    return {one.key: one.values for one in block.settings}


def read(text: str) -> dict[str, Any]:
    """A block, as a YAML reader that runs nothing sees it."""
    found: dict[str, Any] = yaml.safe_load(text)
    return found


def test_kf_gins_gets_its_own_example_back() -> None:
    block = to_kf_gins(GYRO, ACCELEROMETER)
    found = read(block.text)["imunoise"]
    expected = {"arw": 0.003, "vrw": 0.03, "gbstd": 0.027, "abstd": 15.0}
    for key, value in expected.items():
        assert found[key] == pytest.approx([value] * 3, rel=1e-5)
    assert found["corrtime"] == pytest.approx(4.0)
    assert read(str(block)) == {"imunoise": found}


def test_kf_gins_keeps_the_driving_noise_under_another_correlation_time() -> None:
    """Its filter drives a bias with 2 sigma^2 / t_c: K^2 of a walk, whatever the time."""
    found = to_kf_gins(WALKS, ACCELEROMETER, correlation_time=HOUR)
    gbstd = np.array(values(found)["gbstd"]) * DEG / HOUR
    assert np.sqrt(2.0 * gbstd**2 / HOUR) == pytest.approx([2e-5, 1e-5, 4e-5])
    assert any("correlation time 1.44e+04 s of its own" in one for one in found.cannot_hold)
    assert any("wanders without limit" in one for one in found.cannot_hold)


def test_kalibr_gets_densities_and_the_largest_axis() -> None:
    block = to_kalibr(WALKS, [(RandomWalk(0.01), RateRandomWalk(2e-4))], 200.0, 'imu "0"\n')
    found = read(block.text)
    assert found == {
        "gyroscope_noise_density": 3e-3,
        "gyroscope_random_walk": 4e-5,
        "accelerometer_noise_density": 0.01,
        "accelerometer_random_walk": 2e-4,
        "update_rate": 200.0,
        "rostopic": 'imu "0"?',
    }
    assert read(str(block)) == found
    assert block.cannot_hold == ("gyro: differences between axes: the largest value is used for all",)
    assert not block.missing


def test_px4_adds_the_variance_of_the_terms_each_step() -> None:
    """EKF2 adds (noise dt)^2 to an angle and (bias noise dt)^2 to a bias a step; ours are N^2 dt and K^2 dt."""
    for step in (0.004, 0.01):
        block = to_px4(WALKS, WALKS, step)
        found = {key: value[0] for key, value in values(block).items()}
        white, walk = state_space(RandomWalk(3e-3), step), state_space(RateRandomWalk(4e-5), step)
        assert (found["EKF2_GYR_NOISE"] * step) ** 2 == pytest.approx(white.R * step**2)
        assert (found["EKF2_GYR_B_NOISE"] * step) ** 2 == pytest.approx(walk.Qd[0, 0])
        written = dict(line.split()[2:] for line in block.text.splitlines() if line.startswith("param set"))
        assert float(written["EKF2_ACC_B_NOISE"]) == pytest.approx(found["EKF2_ACC_B_NOISE"], rel=1e-5)
        assert f"EKF2_PREDICT_US {round(1e6 * step)}" in block.text


def test_px4_says_which_values_its_parameters_do_not_take() -> None:
    held = to_px4(GYRO, ACCELEROMETER).cannot_hold
    assert any(one.startswith("EKF2_GYR_NOISE 8.73e-06: the parameter takes 0.0001 to 0.1") for one in held)


def test_gtsam_gets_covariances_of_each_axis_and_python_that_parses() -> None:
    block = to_gtsam(WALKS, ACCELEROMETER, 9.80665)
    ast.parse(block.text)
    found = values(block)
    assert found["setGyroscopeCovariance"] == pytest.approx((1e-6, 9e-6, 4e-6))
    assert found["setBiasOmegaCovariance"] == pytest.approx((4e-10, 1e-10, 16e-10))
    assert found["setBiasAccCovariance"] == pytest.approx((2.0 * 15e-5**2 / (4.0 * HOUR),) * 3)
    assert "MakeSharedU(9.80665)" in block.text
    assert "MakeSharedD(9.80665)" in to_gtsam(WALKS, WALKS, 9.80665, up=False).text


def test_what_is_not_told_is_a_comment_and_counted_never_a_number() -> None:
    gyro: Axes = [(RandomWalk(1e-3), BiasInstability(1e-5))]
    blocks = [
        to_kalibr(gyro, WALKS, 100.0),
        to_px4(gyro, WALKS),
        to_gtsam(gyro, WALKS, 9.8),
        to_kf_gins(gyro, WALKS, 3600.0),
    ]
    keys = ("gyroscope_random_walk", "EKF2_GYR_B_NOISE", "setBiasOmegaCovariance", "gbstd")
    for block, key in zip(blocks, keys, strict=True):
        assert key in block.missing
        assert "gyro: bias instability" in block.cannot_hold
        assert re.search(rf"^\s*# (params\.)?{key}: not found", block.text, re.MULTILINE)
        assert f"# missing: {key}" in str(block)
    untimed = to_kf_gins(gyro, WALKS)
    assert "corrtime" in untimed.missing
    assert "abstd" in untimed.missing  # a walk has no standard deviation without a correlation time


def test_a_horizon_stands_a_walk_in_for_all_that_wanders() -> None:
    """B alone has the Allan deviation 0.664 B at any time, a walk K sqrt(tau / 3)."""
    gyro: Axes = [(RandomWalk(1e-3), BiasInstability(1e-5))]
    block = to_kalibr(gyro, WALKS, 100.0, horizon=30.0)
    found = read(block.text)
    assert found["gyroscope_random_walk"] * np.sqrt(30.0 / 3.0) == pytest.approx(0.664 * 1e-5, rel=1e-3)
    assert found["accelerometer_random_walk"] == pytest.approx(4e-5, rel=1e-6)  # a walk alone stays what it is
    assert block.cannot_hold[0] == (
        "gyro: bias instability: replaced by a walk, exact at 30 s, too small below and too large above"
    )
    assert not block.missing
    several: Axes = [(BiasInstability(1e-5), RateRandomWalk(2e-6), GaussMarkov(1e-5, 10.0))]
    alone = [values(to_gtsam([(t,)], GYRO, 9.8, horizon=30.0))["setBiasOmegaCovariance"][0] for t in several[0]]
    together = values(to_gtsam(several, GYRO, 9.8, horizon=30.0))["setBiasOmegaCovariance"][0]
    assert together == pytest.approx(sum(alone))
    assert "EKF2_GYR_B_NOISE" in to_px4([(RandomWalk(1.0),)], WALKS, horizon=30.0).missing
    timed = to_kf_gins(gyro, GYRO, HOUR, horizon=30.0)
    assert values(timed)["gbstd"][0] * DEG / HOUR == pytest.approx(
        0.664e-5 * np.sqrt(3.0 / 30.0 * HOUR / 2.0), rel=1e-3
    )
    with pytest.raises(PlanError, match=r"a horizon of 0\.0 s"):
        to_kalibr(gyro, WALKS, 100.0, horizon=0.0)


def test_a_correlation_time_and_a_second_bias_are_said_to_be_lost() -> None:
    both: Axes = [(RandomWalk(1.0), RateRandomWalk(1e-3), GaussMarkov(1e-2, 10.0))]
    held = to_kalibr(both, GYRO, 100.0).cannot_hold
    assert "gyro: gauss markov next to rate random walk" in held
    assert any("correlation time 1.44e+04 s" in one for one in held)


def test_bad_input_is_refused() -> None:
    with pytest.raises(PlanError, match="2 axes of the gyro"):
        to_kalibr(WALKS[:2], WALKS, 100.0)
    with pytest.raises(PlanError, match="0 axes of the accelerometer"):
        to_px4(WALKS, [])
    with pytest.raises(PlanError, match="gyro: a term appears twice"):
        to_px4([(RandomWalk(1.0), RandomWalk(2.0))], WALKS)
    with pytest.raises(PlanError, match=r"a sample rate of 0\.0 Hz"):
        to_kalibr(WALKS, WALKS, 0.0)
    with pytest.raises(PlanError, match="a prediction step of nan s"):
        to_px4(WALKS, WALKS, np.nan)
    with pytest.raises(PlanError, match=r"a gravity of -9\.8 m/s"):
        to_gtsam(WALKS, WALKS, -9.8)
    with pytest.raises(PlanError, match=r"a correlation time of 0\.0 s"):
        to_kf_gins(WALKS, WALKS, 0.0)
