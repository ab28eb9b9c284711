"""Bodies that stay level: gravity times what calibration left is a bias, and the filter must start with it.

Twins integrate one error an axis (velocity of accelerometers, angle of gyros); the filter is that of a textbook, two
states an axis. Nothing of the simulation is of the package.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import AXES, Key, Kind, Origin
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import INPUT_UNIT, SensorModel
from inertialcal.sensors.noise import GaussMarkov, RandomWalk, RateRandomWalk
from inertialcal.sensors.noise.filter_budget import Budget, Use, filter_budget, settings_of
from inertialcal.sensors.noise.terms import Term

Array = NDArray[np.float64]
GRAVITY, DEG = 9.80665, np.pi / 180.0
PAIRS = [a + b for a in AXES for b in AXES if a != b]
N, K, U_ROW, TURN_ON = 1e-3, 1e-5, 1e-3, 2e-3  # of accelerometers, SI
FORCE, FORCE_TIME = 1.0, 2.0
REST = {axis: (RandomWalk(N), RateRandomWalk(K)) for axis in AXES}


def accelerometers() -> SensorModel:
    """Scale factors and cross terms are known to 1e-3 each."""
    keys = (*(Key("scale_factor_error", a) for a in AXES), *(Key("misalignment", p) for p in PAIRS))
    parts = (Component(Origin("scatter"), "A", U_ROW**2 * np.eye(9)),)
    own = Estimate(keys, np.zeros(9), ("1",) * 3 + ("rad",) * 6, parts)
    return model_from(own, "accelerometer", AXES, bias_run_to_run=np.full(3, TURN_ON))


def gyros(sensitivity: float) -> SensorModel:
    """Each entry of the g-sensitivity is known to this."""
    keys = tuple(Key("g_sensitivity", a + f) for a in AXES for f in AXES)
    parts = (Component(Origin("scatter"), "A", sensitivity**2 * np.eye(9)),)
    own = Estimate(keys, np.zeros(9), ("(rad/s)/(m/s^2)",) * 9, parts)
    return model_from(own, "gyro", AXES, bias_run_to_run=np.full(3, 0.003 * DEG))


def nees(
    budget: Budget, left: Array, turn_on: Array, white: float, walk: float, seed: int, measured: float
) -> tuple[float, float]:
    """Mean normalised squared error of all epochs, and that of the first update; 6 is expected.

    ``left`` are the rows that calibration left, shape (n, 3, 3), of a body that stays level and shakes.
    """
    rng, n, step, updates, each = np.random.default_rng(seed), len(left), 0.1, 60, 50
    keep = np.exp(-step / FORCE_TIME)
    force = FORCE * rng.standard_normal((n, 3))
    bias, true, found = turn_on.copy(), np.zeros((n, 3)), np.zeros((n, 3, 2))
    P = np.zeros((3, 2, 2))
    P[:, 0, 0], P[:, 1, 1] = measured**2, budget.start**2
    true += measured * rng.standard_normal((n, 3))
    Phi, each_epoch = np.array([[1.0, step], [0.0, 1.0]]), []
    Qd = np.array([np.diag([w**2 * step, q**2 * step]) for w, q in zip(budget.white, budget.drive, strict=True)])
    for _ in range(updates):
        for _ in range(each):
            force = keep * force + FORCE * np.sqrt(1.0 - keep**2) * rng.standard_normal((n, 3))
            bias = bias + walk * np.sqrt(step) * rng.standard_normal((n, 3))
            steady = np.array([0.0, 0.0, GRAVITY])
            error = np.einsum("nij,nj->ni", left, force + steady) + bias
            true += error * step + white * np.sqrt(step) * rng.standard_normal((n, 3))
            found = found @ Phi.T
            P = Phi @ P @ Phi.T + Qd
        seen = true + measured * rng.standard_normal((n, 3))
        gain = P[:, :, 0] / (P[:, 0, 0] + measured**2)[:, np.newaxis]
        found = found + gain * (seen - found[:, :, 0])[:, :, np.newaxis]
        P = P - gain[:, :, np.newaxis] * P[:, np.newaxis, 0, :]
        off = np.stack([true, np.einsum("nij,j->ni", left, steady) + bias], axis=2) - found
        each_epoch.append(float(np.mean(np.einsum("nia,iab,nib->n", off, np.linalg.inv(P), off))))
    return float(np.mean(each_epoch)), each_epoch[0]


def without_gravity(model: SensorModel, use: Use, rest: dict[str, tuple[RandomWalk, RateRandomWalk]]) -> Budget:
    return filter_budget(model, replace(use, steady_force=0.0), rest)


def band(n: int) -> tuple[float, float]:
    low, high = stats.chi2.ppf([0.025, 0.975], 6 * n) / n
    return float(low), float(high)


USE = Use(force=FORCE, force_time=FORCE_TIME)


def test_accelerometers_of_a_level_body_start_with_what_gravity_makes() -> None:
    """Without it the first update alone is ten times outside: z reads 1 g with an unknown scale factor."""
    n, rng = 100, np.random.default_rng(3)
    left, turn_on = U_ROW * rng.standard_normal((n, 3, 3)), TURN_ON * rng.standard_normal((n, 3))
    budget = filter_budget(accelerometers(), USE, REST)
    row = np.sqrt(3.0) * U_ROW * GRAVITY
    assert budget.start == pytest.approx([np.hypot(row, TURN_ON)] * 3)
    mean, first = nees(budget, left, turn_on, N, K, 4, 0.05)
    bare = nees(without_gravity(accelerometers(), USE, REST), left, turn_on, N, K, 4, 0.05)
    low, high = band(n)
    assert low < mean < high
    assert first < high  # the start is that of gravity in any direction: a little cautious
    assert bare[0] > 2.0 * high
    assert bare[1] > 5.0 * high


def test_gyros_of_a_level_body_start_with_their_g_sensitivity() -> None:
    n, rng = 100, np.random.default_rng(5)
    u, white, walk = 0.02 * DEG / GRAVITY, 0.003 * DEG, 1e-5 * DEG
    rest = {axis: (RandomWalk(white), RateRandomWalk(walk)) for axis in AXES}
    left, turn_on = u * rng.standard_normal((n, 3, 3)), 0.003 * DEG * rng.standard_normal((n, 3))
    budget = filter_budget(gyros(u), USE, rest)
    assert budget.start == pytest.approx([np.hypot(np.sqrt(3.0) * 0.02, 0.003) * DEG] * 3)
    mean, first = nees(budget, left, turn_on, white, walk, 6, 0.01 * DEG)
    bare = nees(without_gravity(gyros(u), USE, rest), left, turn_on, white, walk, 6, 0.01 * DEG)
    low, high = band(n)
    assert low < mean < high
    assert first < high
    assert bare[0] > 2.0 * high


def test_in_orbit_there_is_no_gravity() -> None:
    assert without_gravity(accelerometers(), USE, REST).start == pytest.approx([TURN_ON] * 3)
    stated = filter_budget(gyros(1e-9), replace(USE, g_sensitivity=1e-5), REST)
    assert max(stated.start) == pytest.approx(np.hypot(1e-5 * GRAVITY, 0.003 * DEG))


# Axes that differ, and models of one axis


def one_axis() -> SensorModel:
    own = Estimate(
        (Key("scale_factor_error", "x"),), np.zeros(1), ("1",), (Component(Origin("s"), "A", np.eye(1) * 1e-6),)
    )
    return model_from(own, "gyro", ("x",))


@pytest.mark.parametrize("kind", INPUT_UNIT)
def test_axes_without_gauss_markov_noise_do_not_count_in_its_time(kind: Kind) -> None:
    """Of one axis of 3600 s and two walks the time is an hour, and each keeps what drives it."""
    model = gyros(1e-9) if kind == "gyro" else accelerometers()
    mixed: dict[str, tuple[Term, ...]] = {
        "x": (RandomWalk(N), GaussMarkov(1e-3, 3600.0)),
        "y": REST["y"],
        "z": REST["z"],
    }
    budget = filter_budget(model, Use(), mixed)
    pair = (budget, None) if kind == "gyro" else (None, budget)
    values = {one.key: one.values for one in settings_of("kf-gins", *pair).settings}
    assert values["corrtime"] == pytest.approx((1.0,))


def test_an_axis_without_wandering_has_that_of_the_worst_and_it_is_said() -> None:
    rest: dict[str, tuple[Term, ...]] = {
        "x": REST["x"],
        "y": (RandomWalk(N),),
        "z": (RandomWalk(N), RateRandomWalk(2.0 * K)),
    }
    budget = filter_budget(gyros(1e-9), Use(), rest)
    for target in ("kalibr", "px4", "gtsam", "kf-gins", "openvins"):
        block = settings_of(target, budget, None, 100.0)
        assert any("no wandering of y" in one for one in block.cannot_hold), target
    values = {one.key: one.values for one in settings_of("gtsam", budget, None).settings}
    assert values["setBiasOmegaCovariance"] == pytest.approx((K**2, 4.0 * K**2, 4.0 * K**2))


def test_one_axis_stands_for_all_and_that_is_said() -> None:
    budget = filter_budget(one_axis(), replace(USE, motion=0.1, motion_time=1.0), {"x": REST["x"]})
    assert any("one axis has none" in one for one in budget.not_counted)
    for target in ("kalibr", "px4", "gtsam", "kf-gins", "openvins"):
        assert any("stands for all three" in one for one in settings_of(target, budget, None, 100.0).cannot_hold)


def test_the_first_bias_is_told_or_said() -> None:
    """GTSAM takes it as the prior of the first bias, accelerometers first; Kalibr and OpenVINS have no word for it."""
    first, second = filter_budget(gyros(1e-5), USE, REST), filter_budget(accelerometers(), USE, REST)
    block = settings_of("gtsam", first, second)
    (prior,) = [one.values for one in block.settings if one.key == "bias_prior"]
    assert prior == pytest.approx((*second.start, *first.start))
    assert not any("first covariance" in one for one in block.missing)
    for target in ("kalibr", "openvins"):
        said = [one for one in settings_of(target, first, second, 100.0).cannot_hold if "bias at the start" in one]
        assert len(said) == 2
    wild = filter_budget(gyros(1.0), USE, REST)
    assert any("EKF2_GBIAS_INIT" in one for one in settings_of("px4", wild, None).cannot_hold)


def test_temperatures_beyond_the_model_are_said() -> None:
    keys = tuple(Key("bias_temperature", a, power=1) for a in AXES)
    own = Estimate(keys, np.zeros(3), ("rad/s/degC",) * 3, (Component(Origin("s"), "A", 1e-12 * np.eye(3)),))
    model = model_from(own, "gyro", AXES, reference_temperature=20.0, temperature_range=(-20.0, 60.0))
    inside = filter_budget(model, Use(temperature_span=80.0, temperature_time=600.0), REST)
    beyond = filter_budget(model, Use(temperature_span=300.0, temperature_time=600.0), REST)
    moved = filter_budget(model, Use(temperature_span=10.0, temperature_time=600.0, temperature=58.0), REST)
    said = ["goes beyond" in " ".join(one.not_counted) for one in (inside, beyond, moved)]
    assert said == [False, True, True]
