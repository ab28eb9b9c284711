"""What a suite sees of an orbit: against closed forms, and against draws that use nothing of the check."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key, Origin
from inertialcal.physics.orbit import orbital_rate
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.sensors.orbit_check import band_holds, dwell_check, orbit_check

DEG = math.pi / 180.0
U_BIAS, U_SCALE, RUN, WALK = 0.004 * DEG, 2e-3, 0.008 * DEG, 0.0045 * DEG  # rad/s, 1, rad/s, rad/sqrt(s)
TAU = 25.0  # [s]


def suite(noise: bool = True) -> SensorModel:
    names = ("bias_x", "scale_factor_error_x")
    scatter = Component("scatter", "A", np.diag([U_BIAS**2, U_SCALE**2]), np.inf)
    model = model_from(Estimate(names, np.zeros(2), ("rad/s", "1"), (scatter,)), "gyro", ("x",), 1.0, "rad/s")
    model = replace(model, bias_run_to_run=np.array([RUN]))
    if not noise:
        return model
    spread = Component("fit", "A", np.array([[1e-12]]), np.inf)
    keys = (Key("angle_random_walk", "x"),)
    return replace(model, noise=Estimate(keys, np.array([WALK]), ("rad/sqrt(s)",), (spread,)))


@pytest.mark.parametrize(("kilometres", "deg_s"), [(560.0, 0.0627), (319.0, 0.0660), (35786.0, 0.004178)])
def test_rate_of_an_orbit(kilometres: float, deg_s: float) -> None:
    """560 km and 319 km as the errata of the thesis have them; the third is the day of the stars."""
    rate = orbital_rate(kilometres * 1e3)
    assert float(rate.values[0]) == pytest.approx(deg_s * DEG, abs=2.0 * float(rate.u[0]))
    assert float(rate.u[0]) / float(rate.values[0]) < 2e-3


def test_uncertainty_is_that_of_the_closed_form() -> None:
    found = orbit_check(suite(), 560e3, TAU)
    n = float(found.rate.values[0])
    direct, less_rest = found.checks
    u = math.sqrt(U_BIAS**2 + (n * U_SCALE) ** 2 + RUN**2 + WALK**2 / TAU)
    assert direct.u == pytest.approx(u, rel=1e-12)
    assert direct.half == pytest.approx(1.959964 * u, rel=1e-6)
    assert direct.orbit_ratio == pytest.approx(n / direct.half, rel=1e-12)
    assert less_rest.u == pytest.approx(math.hypot(n * U_SCALE, math.sqrt(2.0 / TAU) * WALK), rel=1e-12)
    assert (direct.orbit_seen, less_rest.orbit_seen, less_rest.earth_seen) == (True, True, True)
    assert not direct.earth_seen


def with_few_runs(runs: int, scatter: float) -> SensorModel:
    """A suite whose bias is the mean of a few power-ups: the same scatter is its run-to-run."""
    model = suite()
    bias = Component(
        Origin("runs", level="run"), "A", np.diag([scatter**2 / runs, 0.0]), np.array([runs - 1.0, np.inf])
    )
    scale = Component("scale", "A", np.diag([0.0, U_SCALE**2]), np.inf)
    estimate = Estimate(("bias_x", "scale_factor_error_x"), np.zeros(2), ("rad/s", "1"), (bias, scale))
    return replace(model, estimate=estimate, bias_run_to_run=np.array([scatter]))


def test_intervals_of_a_suite_with_few_power_ups_hold_the_rate() -> None:
    """Bias and run-to-run from 4 power-ups each: Student's factor, else 86 % of stated 95 % intervals held it."""
    rng, draws, runs = np.random.default_rng(4), 1000, 4
    biases = rng.normal(0.0, RUN, (draws, runs))
    readings = rng.normal(0.0, RUN, draws) - biases.mean(axis=1) + rng.normal(0.0, WALK / math.sqrt(TAU), draws)
    held = [
        abs(error) <= orbit_check(with_few_runs(runs, scatter), 560e3, TAU).checks[0].half
        for error, scatter in zip(readings, biases.std(axis=1, ddof=1), strict=True)
    ]
    assert np.mean(held) == pytest.approx(0.95, abs=3.3 * math.sqrt(0.95 * 0.05 / draws))


def test_a_bias_without_uncertainty_leaves_a_direct_reading_open() -> None:
    model = suite()
    scale = Component("scatter", "A", np.array([[U_SCALE**2]]), np.inf)
    estimate = Estimate(("scale_factor_error_x",), np.zeros(1), ("1",), (scale,))
    found = orbit_check(replace(model, estimate=estimate), 560e3, TAU)
    direct, less_rest = found.checks
    assert math.isnan(direct.u)
    assert (direct.orbit_seen, direct.earth_seen) == (False, False)
    assert less_rest.orbit_seen
    assert any(one.startswith("bias of x: ") for one in found.not_counted)
    near = dwell_check(found, "x", np.array([0.06]) * DEG, np.zeros(1), ["1"])
    assert math.isnan(near.band)
    assert band_holds([near])


def test_fewer_runs_inside_than_the_band_states_are_told() -> None:
    found = orbit_check(suite(), 560e3, TAU)
    runs = [str(i) for i in range(14)]

    def near(outside: int) -> bool:
        error = np.where(np.arange(14) < outside, 1.5, 0.5) * found.checks[0].half
        return band_holds([dwell_check(found, "x", np.full(14, 0.06 * DEG), error, runs)])

    assert [near(outside) for outside in (0, 1, 4, 7)] == [True, True, True, False]


def test_noise_that_was_not_estimated_is_named() -> None:
    lacking = orbit_check(suite(), 560e3, TAU).not_counted
    assert "noise, bias instability of x: not estimated" in lacking
    assert not any(one.startswith("noise, angle random walk") for one in lacking)


def test_intervals_hold_the_rate_in_draws() -> None:
    """Suites drawn from the model's uncertainty, each in an orbit: r = b + (1 + s) n + noise."""
    rng, draws = np.random.default_rng(23), 4000
    found = orbit_check(suite(), 560e3, TAU)
    n = float(found.rate.values[0])
    bias = rng.normal(0.0, math.hypot(U_BIAS, RUN), draws)
    scale = rng.normal(0.0, U_SCALE, draws)
    noise = rng.normal(0.0, WALK / math.sqrt(TAU), (2, draws))
    moved = bias + (1.0 + scale) * n + noise[0]
    for one, reading in zip(found.checks, (moved, moved - bias - noise[1]), strict=True):
        held = np.count_nonzero(np.abs(reading - n) <= one.half)
        assert held == pytest.approx(0.95 * draws, abs=3.3 * math.sqrt(0.95 * 0.05 * draws))


def test_what_is_lacking_is_said_and_what_makes_no_sense_refused() -> None:
    assert "noise: the model has none" in orbit_check(suite(noise=False), 560e3).not_counted
    for model, altitude, averaging, code in (
        (suite(), -1.0, 100.0, "altitude"),
        (suite(), 560e3, 0.0, "averaging"),
        (replace(suite(), estimate=None), 560e3, 100.0, "no_covariance"),
    ):
        with pytest.raises(DataError) as caught:
            orbit_check(model, altitude, averaging)
        assert caught.value.problems[0].code == code


def test_at_a_latitude_the_vertical_part_of_the_earths_rate_counts() -> None:
    whole, there = orbit_check(suite(), 560e3, TAU), orbit_check(suite(), 560e3, TAU, 36.6 * DEG, 0.01)
    ratio = math.sin(36.6 * DEG)
    assert float(there.earth.values[0]) == pytest.approx(7.292115e-5 * ratio, rel=1e-6)
    assert float(there.earth.u[0]) == pytest.approx(7.292115e-5 * 0.01 * math.cos(36.6 * DEG), rel=1e-6)
    assert float(whole.earth.u[0]) == 0.0
    for one, other in zip(whole.checks, there.checks, strict=True):
        assert other.earth_ratio == pytest.approx(one.earth_ratio * ratio, rel=1e-6)
        assert other.orbit_ratio == one.orbit_ratio


def test_dwells_near_the_orbits_rate_stand_beside_the_band() -> None:
    found = orbit_check(suite(), 560e3, TAU)
    band = found.checks[0].half
    applied = np.array([0.06, -0.06, 0.0, 0.5, 0.06, 0.06]) * DEG
    error = np.array([0.5, 0.7, 9.0, 9.0, 2.0, np.nan]) * band
    near = dwell_check(found, "x", applied, error, ["1", "1", "1", "1", "2", "2"])
    assert (near.dwells, near.runs, near.inside, near.band) == (3, 2, 1, band)
    assert near.error == pytest.approx(1.3 * band)
    assert near.u == pytest.approx(0.7 * band)  # (2.0 - 0.6) / 2
    none = dwell_check(found, "x", applied[2:4], error[2:4], ["1", "1"])
    assert (none.dwells, none.u, math.isnan(none.error)) == (0, None, True)
