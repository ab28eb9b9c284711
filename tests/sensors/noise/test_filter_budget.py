"""Budget of a filter: each line by its closed form, and a textbook filter that is consistent with it, and not without.

The filter and the twins stand in ``attitude_filter`` and share nothing with the package.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from attitude_filter import Flight, Gyros, band, nees, rotations
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, PlanError, UsageError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import AXES, Key, Kind, Origin
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import INPUT_UNIT, SensorModel
from inertialcal.sensors.noise import BiasInstability, GaussMarkov, RandomWalk, RateRandomWalk, expected_variance
from inertialcal.sensors.noise.filter_budget import (
    AT_REST,
    TARGETS,
    Budget,
    Use,
    filter_budget,
    settings_of,
    vibration_levels,
)
from inertialcal.signals.spectrum.psd import psd

DEG = np.pi / 180.0
N, K = 0.01 * DEG, 1e-4 * DEG
REST = {axis: (RandomWalk(N), RateRandomWalk(K)) for axis in AXES}
U_SCALE, U_CROSS, U_BIAS, U_SLOPE, U_FORCE, TURN_ON = (
    0.003,
    0.002,
    0.01 * DEG,
    0.003 * DEG,
    0.004 * DEG / 9.80665,
    0.05 * DEG,
)
PAIRS = [a + b for a in AXES for b in AXES if a != b]
KEYS = (
    *(Key("scale_factor_error", a) for a in AXES), *(Key("misalignment", p) for p in PAIRS),
    *(Key("bias", a) for a in AXES), *(Key("bias_temperature", a, power=1) for a in AXES),
    *(Key("g_sensitivity", a + f) for a in AXES for f in AXES),
)  # fmt: skip
SIZES = np.array([U_SCALE] * 3 + [U_CROSS] * 6 + [U_BIAS] * 3 + [U_SLOPE] * 3 + [U_FORCE] * 9)
UNITS = ("1",) * 3 + ("rad",) * 6 + ("rad/s",) * 3 + ("rad/s/degC",) * 3 + ("(rad/s)/(m/s^2)",) * 9
REFERENCE, MIDDLE = 20.0, 30.0


def gyro(covariance: Array | None = None) -> SensorModel:
    """Gyros of which a calibration knows all terms, with these uncertainties; bias and slope are correlated."""
    matrix = np.diag(SIZES**2) if covariance is None else covariance
    if covariance is None:
        for i in range(3):
            matrix[9 + i, 12 + i] = matrix[12 + i, 9 + i] = -0.5 * U_BIAS * U_SLOPE
    parts = (Component(Origin("scatter"), "A", matrix),)
    estimate = Estimate(KEYS, np.zeros(len(KEYS)), UNITS, parts)
    return model_from(estimate, "gyro", AXES, reference_temperature=np.full(3, REFERENCE),
                      temperature_range=(20.0, 40.0), bias_run_to_run=np.full(3, TURN_ON))  # fmt: skip


USE = Use(
    temperature_span=20.0,
    temperature_time=600.0,
    motion=0.5,
    motion_time=0.4,
    force=9.80665 / np.sqrt(3.0),
    force_time=5.0,
)


def size(budget: Budget, source: str, carried: str) -> Array:
    (line,) = [one for one in budget.lines if (one.source, one.carried) == (source, carried)]
    return line.size


# Closed forms


def test_every_line_by_its_closed_form() -> None:
    budget = filter_budget(gyro(), USE, REST)
    assert size(budget, AT_REST, "white") == pytest.approx(N)
    assert size(budget, AT_REST, "walk") == pytest.approx(K)
    assert size(budget, "turn-on", "start") == pytest.approx(TURN_ON)
    away = MIDDLE - REFERENCE
    mean = np.sqrt(U_BIAS**2 + away**2 * U_SLOPE**2 - 2 * 0.5 * away * U_BIAS * U_SLOPE)
    assert size(budget, "bias of the model", "start") == pytest.approx(mean)
    sd = U_SLOPE * 20.0 / np.sqrt(12.0)
    assert size(budget, "temperature", "gauss_markov") == pytest.approx(sd, rel=0.01)
    assert size(budget, "scale factor", "white") == pytest.approx(U_SCALE * 0.5 * np.sqrt(2 * 0.4))
    square = U_CROSS / np.sqrt(2.0) * np.sqrt(2.0)  # two axes, the symmetric half of each pair
    assert size(budget, "misalignment", "white") == pytest.approx(square * 0.5 * np.sqrt(2 * 0.4))
    force = np.sqrt(3.0) * U_FORCE * 9.80665 / np.sqrt(3.0)
    assert size(budget, "g-sensitivity", "white") == pytest.approx(force * np.sqrt(2 * 5.0))
    whites = [line.size for line in budget.lines if line.carried == "white"]
    assert budget.white == pytest.approx(np.sqrt(np.sum(np.square(whites), axis=0)))
    assert budget.drive == pytest.approx(np.sqrt(K**2 + 2 * size(budget, "temperature", "gauss_markov") ** 2 / 600.0))
    assert budget.inflation["white"] == pytest.approx(budget.white / N)
    assert budget.inflation["drive"] == pytest.approx(budget.drive / K)


def test_without_compensation_a_straight_line_counts_with_its_slope() -> None:
    slope = np.array([0.001, -0.002, 0.003]) * DEG
    warm = replace(gyro(), estimate=None, bias_temperature=slope[np.newaxis])
    use = replace(USE, without=("temperature",))
    found = size(filter_budget(warm, use, REST), "temperature, not compensated", "gauss_markov")
    assert found == pytest.approx(np.abs(slope) * 20.0 / np.sqrt(12.0), rel=0.01)
    assert "uncertainty of the calibration" in " ".join(filter_budget(warm, use, REST).not_counted)


def test_parts_that_are_not_applied_count_in_full() -> None:
    matrix = np.array([[1.01, 0.004, 0.0], [0.002, 1.0, 0.0], [0.0, 0.0, 0.99]])
    model = replace(gyro(), estimate=None, matrix=matrix, bias=np.array([1.0, 2.0, 3.0]) * 1e-3,
                    g_sensitivity=np.diag([1e-4, 0.0, 0.0]))  # fmt: skip
    budget = filter_budget(model, replace(USE, without=("bias", "matrix", "g_sensitivity")), REST)
    assert size(budget, "scale factor", "white") == pytest.approx(np.array([0.01, 0.0, 0.01]) * 0.5 * np.sqrt(0.8))
    assert size(budget, "misalignment", "white") == pytest.approx(np.array([0.003, 0.003, 0.0]) * 0.5 * np.sqrt(0.8))
    assert size(budget, "bias of the model", "start") == pytest.approx(np.array([1.0, 2.0, 3.0]) * 1e-3)
    assert size(budget, "g-sensitivity", "white")[0] == pytest.approx(1e-4 * 9.80665 / np.sqrt(3.0) * np.sqrt(10.0))


@given(s=st.floats(1e-6, 1.0), time=st.floats(0.01, 10.0), times=st.floats(1.0, 1e4))
def test_white_noise_in_place_of_slow_errors_is_never_too_small(s: float, time: float, times: float) -> None:
    """Variance of the integral of s n(t), by its closed form, against N^2 t; equal for times well beyond t_c."""
    t = times * time
    exact = 2.0 * s**2 * time * (t - time * -np.expm1(-t / time))
    assert exact <= 2.0 * s**2 * time * t * (1.0 + 1e-12)
    assert exact >= 2.0 * s**2 * time * t * (1.0 - 1.0 / times) * (1.0 - 1e-9)


def test_a_common_turn_of_the_axes_does_not_add_up() -> None:
    """Of an antisymmetric matrix the error of the attitude stays below twice its angle; of a symmetric one it grows."""
    rng = np.random.default_rng(1)
    n, dt = 400, 0.05
    apart = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    errors = {"turn": apart, "square": np.abs(apart)}
    total = {name: np.zeros((n, 3)) for name in errors}
    turned, rate = np.tile(np.eye(3), (n, 1, 1)), rng.normal(0.0, 0.5, (n, 3))
    for _ in range(1200):
        rate = np.exp(-dt / 0.4) * rate + rng.normal(0.0, 0.5 * np.sqrt(-np.expm1(-2 * dt / 0.4)), (n, 3))
        middle = turned @ rotations(0.5 * rate * dt)
        for name, matrix in errors.items():
            total[name] += np.einsum("nij,jk,nk->ni", middle, matrix, rate) * dt
        turned = turned @ rotations(rate * dt)
    sizes = {name: np.linalg.norm(one, axis=1) for name, one in total.items()}
    assert sizes["turn"].max() < 2.02
    grown = np.mean(total["square"] ** 2) / (2 * 0.5**2 * 0.4 * 60.0 * 2.0 / 3.0)
    assert grown == pytest.approx(1.0, abs=0.25)


def test_of_accelerometers_all_cross_terms_count_with_the_force() -> None:
    keys = (*(Key("scale_factor_error", a) for a in AXES), *(Key("misalignment", p) for p in PAIRS))
    parts = (Component(Origin("scatter"), "A", np.diag([1e-3] * 3 + [2e-3] * 6) ** 2),)
    model = model_from(Estimate(keys, np.zeros(9), ("1",) * 3 + ("rad",) * 6, parts), "accelerometer", AXES)
    budget = filter_budget(model, Use(force=3.0, motion_time=0.5), {a: (RandomWalk(1e-3),) for a in AXES})
    assert size(budget, "scale factor", "white") == pytest.approx(1e-3 * 3.0)
    assert size(budget, "misalignment", "white") == pytest.approx(2e-3 * np.sqrt(2.0) * 3.0)
    text = " ".join(budget.not_counted)
    for words in (
        "temperature",
        "turn-on",
        "vibration",
        "wandering of the bias",
        "bias of x, y, z: the model has no unc",
    ):
        assert words in text
    estimate = gyro().estimate
    assert estimate is not None
    unknown = " ".join(filter_budget(replace(gyro(), estimate=estimate.select(KEYS[9:12])), USE, REST).not_counted)
    for words in ("scale factor of x, y, z: the model has no uncertainty", "misalignment of x, y, z: the model has no"):
        assert words in unknown, "what has no uncertainty is not exact"


def test_a_vibration_is_folded_back_from_beyond_half_the_rate() -> None:
    t = np.arange(40_000) / 1000.0
    low, high = 2.0 * np.sin(2 * np.pi * 30.0 * t), 4.0 * np.sin(2 * np.pi * 140.0 * t)
    rms, folded = vibration_levels(psd(low + high, 1e-3), 200.0)
    assert (rms, folded) == pytest.approx((np.sqrt(2.0 + 8.0), np.sqrt(8.0)), rel=1e-3)
    use = Use(vibration=rms, folded=folded, sample_rate=200.0, rectification=1e-5)
    budget = filter_budget(gyro(), use, REST)
    assert size(budget, "vibration folded back", "white") == pytest.approx(np.sqrt(8.0 / 200.0), rel=1e-3)
    assert size(budget, "rectified vibration", "start") == pytest.approx(1e-5 * 10.0, rel=1e-3)


def test_bias_instability_needs_a_horizon_and_is_then_exact_there() -> None:
    terms = {"x": (RandomWalk(N), BiasInstability(1e-4))}
    bare = filter_budget(gyro(), Use(), terms)
    assert "give a horizon" in " ".join(bare.not_counted)
    assert bare.drive == pytest.approx(0.0)
    walk = filter_budget(gyro(), Use(horizon=100.0), terms).drive
    assert walk**2 * 100.0 / 3.0 == pytest.approx(expected_variance(BiasInstability(1e-4), [4096], 100.0 / 4096)[0])


def test_a_gauss_markov_bias_at_rest_stays_one_and_drives_as_much() -> None:
    budget = filter_budget(gyro(), Use(), {"x": (RandomWalk(N), GaussMarkov(1e-4, 50.0))})
    assert size(budget, AT_REST, "gauss_markov") == pytest.approx(1e-4)
    assert budget.drive == pytest.approx(1e-4 * np.sqrt(2.0 / 50.0))
    assert GaussMarkov(pytest.approx(1e-4), 50.0) in budget.terms(0)  # type: ignore[arg-type]


def test_matrices_of_a_step_hold_all_lines() -> None:
    budget = filter_budget(gyro(), USE, REST)
    space = budget.state_space(0, 0.01)
    assert space.names == ("integral", "rate_random_walk", "gauss_markov")
    spread = float(size(budget, "temperature", "gauss_markov")[0])
    assert space.F is not None
    assert space.Q is not None
    np.testing.assert_allclose(space.F, np.array([[0, 1, 1], [0, 0, 0], [0, 0, -1 / 600.0]]), atol=1e-15)
    wanted = np.array([budget.white[0] ** 2, K**2, 2 * spread**2 / 600.0])
    np.testing.assert_allclose(np.diag(space.Q), wanted, rtol=1e-12)
    assert space.Qd[0, 0] == pytest.approx(budget.white[0] ** 2 * 0.01, rel=1e-4)


# Settings


@pytest.mark.parametrize("target", TARGETS)
def test_settings_carry_the_totals(target: str) -> None:
    budget = filter_budget(gyro(), USE, REST)
    block = settings_of(target, budget, None, 200.0)
    values = {one.key: one.values for one in block.settings}
    white, drive, start = (float(one.max()) for one in (budget.white, budget.drive, budget.start))
    if target in {"kalibr", "openvins"}:
        assert values["gyroscope_noise_density"] == pytest.approx((white,))
        assert values["gyroscope_random_walk"] == pytest.approx((drive,))
        assert "  gyroscope_noise_density: " in block.text or target == "kalibr"
    elif target == "px4":
        assert values["EKF2_GYR_NOISE"] == pytest.approx((white / 0.1,))
        assert values["EKF2_GBIAS_INIT"] == pytest.approx((start,))
    elif target == "gtsam":
        assert values["setGyroscopeCovariance"] == pytest.approx(tuple(budget.white**2))
    elif target == "kf-gins":
        without = np.sqrt(budget.white**2 - size(budget, "scale factor", "white") ** 2)
        assert values["arw"] == pytest.approx(tuple(np.degrees(without) * 60.0))
        assert values["gsstd"] == pytest.approx((U_SCALE * 1e6,) * 3)
        assert values["gbstd"] == pytest.approx(tuple(np.degrees(budget.drive) * 3600.0 * np.sqrt(300.0)), rel=1e-6)
        assert values["initbgstd"] == pytest.approx(tuple(np.degrees(budget.start) * 3600.0))
    else:
        held = np.reshape(values["angular_velocity_covariance"], (3, 3))
        np.testing.assert_allclose(held, np.diag(np.asarray(budget.white**2 * 200.0 + budget.start**2)))


def test_what_a_filter_needs_is_asked_for() -> None:
    budget = filter_budget(gyro(), USE, REST)
    with pytest.raises(UsageError, match="sample rate"):
        settings_of("ros", budget, None)
    with pytest.raises(UsageError, match="There are"):
        settings_of("rocket", budget, None)
    with pytest.raises(DataError, match="no noise of every axis"):
        filter_budget(gyro(), USE)
    with pytest.raises(DataError, match="no white noise"):
        filter_budget(gyro(), USE, {"x": (RateRandomWalk(K),)})
    for wrong in ({"motion": -1.0}, {"motion": 1.0}, {"temperature_span": 5.0}, {"rectification": 1.0}, {"force": 1.0}):
        with pytest.raises(PlanError):
            Use(**wrong)  # type: ignore[arg-type]


@given(scale=st.floats(0.01, 100.0))
def test_a_budget_scales_with_its_sensor(scale: float) -> None:
    own = gyro()
    assert own.estimate is not None
    larger = gyro(own.estimate.covariance * scale**2)
    larger = replace(larger, bias_run_to_run=np.full(3, TURN_ON * scale))
    rest = {axis: (RandomWalk(N * scale), RateRandomWalk(K * scale)) for axis in AXES}
    one, other = filter_budget(own, USE, REST), filter_budget(larger, USE, rest)
    for name in ("white", "drive", "start"):
        assert getattr(other, name) == pytest.approx(scale * getattr(one, name))
    assert other.inflation["white"] == pytest.approx(one.inflation["white"])


def test_kinds_have_their_units() -> None:
    kinds: tuple[Kind, ...] = ("gyro", "accelerometer")
    for kind in kinds:
        model = SensorModel(kind, AXES, np.ones(3), INPUT_UNIT[kind], np.eye(3), np.zeros(3))
        assert filter_budget(model, Use(), {"x": (RandomWalk(1.0),)}).unit == INPUT_UNIT[kind]


# A filter with these settings


def consistency(twins: int, duration: float, seed: int) -> tuple[float, float, Budget]:
    """Mean normalised squared error of a filter with the settings of the budget, and with the figures at rest alone.

    Twins are drawn from the covariance of the model, and fly with other motions and temperatures each.
    """
    model, rng = gyro(), np.random.default_rng(seed)
    assert model.estimate is not None
    drawn = rng.multivariate_normal(np.zeros(len(KEYS)), model.estimate.covariance, twins, method="cholesky")
    matrix = np.zeros((twins, 3, 3))
    for i in range(3):
        matrix[:, i, i] = drawn[:, i]
    for k, pair in enumerate(PAIRS):
        matrix[:, "xyz".index(pair[0]), "xyz".index(pair[1])] = drawn[:, 3 + k]
    gyros = Gyros(
        matrix, drawn[:, 15:].reshape(twins, 3, 3), np.stack([drawn[:, 9:12], drawn[:, 12:15]], axis=1),
        rng.normal(0.0, TURN_ON, (twins, 3)), N, K,
    )  # fmt: skip
    flight = Flight(duration, 0.2, 0.5, 0.4, MIDDLE - REFERENCE, 20.0 / np.sqrt(12.0), 600.0, 20.0, 0.3 * DEG)
    budget = filter_budget(model, USE, REST)
    bare = budget.at_rest
    means = [float(np.mean(nees(gyros, flight, one.white, one.drive, budget.start, np.random.default_rng(seed))))
             for one in (budget, bare)]  # fmt: skip
    return means[0], means[1], budget


def test_a_filter_with_the_budget_is_consistent_and_without_is_not() -> None:
    twins = 30
    with_budget, bare, budget = consistency(twins, 240.0, 1)
    low, high = band(twins)
    assert low < with_budget < high
    assert bare > 10.0 * high
    assert np.all(budget.inflation["white"] > 8.0)
    assert np.all(budget.inflation["drive"] > 8.0)


@pytest.mark.slow
def test_of_100_twins_the_filter_is_inside_its_95_percent_band() -> None:
    """Expected 6, the number of states; the figures at rest alone, 10 times smaller, give more than 100."""
    with_budget, bare, _ = consistency(100, 900.0, 1)
    low, high = band(100)
    assert (round(low, 2), round(high, 2)) == (5.34, 6.7)
    assert low < with_budget < high
    assert bare > 100.0
