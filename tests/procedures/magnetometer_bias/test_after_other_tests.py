"""A gyro against a magnetometer after what earlier tests found: bias, scale factors, misalignment, with covariance."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import t as student

from independent.coverage import keeps
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key, Origin
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.corrections import BiasCorrection, MatrixCorrection
from inertialcal.procedures.magnetometer_bias.plan import INFLUENCES, Plan
from inertialcal.procedures.magnetometer_bias.procedure import PROCEDURE
from inertialcal.procedures.magnetometer_bias.readings import Readings, after, matrix_of, track
from inertialcal.procedures.magnetometer_bias.reduction import Result, reduce
from inertialcal.procedures.protocol import Correction

pytest.importorskip("ppigrf")
from independent.orbit.magnetometer import DEG, Orbit, recorded
from sized import sized

Array = NDArray[np.float64]
START = 1_772_323_200_000_000_000  # 2026-03-01 [ns]
AXES = "xyz"
SCALES = tuple(Key("scale_factor_error", axis) for axis in AXES)
PAIRS = tuple(Key("misalignment", f"{a}{b}") for a in AXES for b in AXES if a != b)
SIZES = np.array([5e-3] * 3 + [2e-3] * 6)  # standard uncertainties of what a rate table found


def recording(made: Orbit) -> Recording:
    channels = [Channel(axis, made.rates[:, i], "rad/s") for i, axis in enumerate(AXES)]
    channels += [Channel(f"magnetometer_{axis}", made.field[:, i], "T") for i, axis in enumerate(AXES)]
    channels += [Channel(f"position_{axis}", made.position[:, i], "m") for i, axis in enumerate(AXES)]
    stamps = np.rint(made.time * 1e9).astype(np.int64) + START
    return Recording(tuple(channels), stamps, float(made.time[1] - made.time[0]), epoch="utc")


def reduced(made: Orbit, *corrections: Correction, **settings: Any) -> Result:
    matrix = matrix_of(corrections)
    rates, off = after(recording(made), "one", corrections, matrix)
    one = replace(track(rates, "one", "one.csv", None), taken_off=off)
    return reduce(Plan(**settings), Readings((one,), matrix=matrix))


def matrix_correction(found: Array, sizes: Array = SIZES, keys: tuple[Key, ...] = SCALES + PAIRS) -> MatrixCorrection:
    parts = (Component(Origin("scatter of dwells", level="dwell"), "A", np.diag(sizes**2), 20.0),)
    return MatrixCorrection(("table",), (Estimate(keys, found, ("1",) * len(keys), parts),))


def matrix_of_truth(truth: Array) -> Array:
    made = np.diag(1.0 + truth[:3])
    for value, key in zip(truth[3:], PAIRS, strict=True):
        i, j = (AXES.index(axis) for axis in key.axis)
        made[i, j] = made[i, i] * value
    return made


def after_both(seed: int, sizes: Array = SIZES) -> tuple[Result, Array]:
    """Return a result after a rate table and a bias, each off as it states, and what is left to find."""
    rng = np.random.default_rng([seed, 77])
    truth = np.concatenate([rng.normal(0.0, 0.03, 3), rng.normal(0.0, 5e-3, 6)])
    made = recorded(rng, 3600.0, 2.0, gyro=matrix_of_truth(truth))
    u = np.array([1e-3, 5e-4, 2e-4]) * DEG
    ground = made.bias - np.array([0.02, -0.01, 0.03]) * DEG + rng.normal(0.0, u)
    parts = (Component(Origin("scatter of runs", level="run"), "A", np.diag(u**2)),)
    bias = BiasCorrection("chamber", Estimate(tuple(Key("bias", axis) for axis in AXES), ground, ("rad/s",) * 3, parts))
    found = reduced(made, bias, matrix_correction(truth + rng.normal(0.0, sizes), sizes))
    return found, np.array([0.02, -0.01, 0.03]) * DEG


def hits(seeds: range) -> Counter[str]:
    counted: Counter[str] = Counter()
    for seed in seeds:
        found, truth = after_both(seed)
        estimate = found.estimate
        inside = np.abs(estimate.values - np.concatenate([truth, np.zeros(3)])) <= (
            student.ppf(0.975, estimate.dof) * estimate.u
        )
        counted.update(dict(zip(estimate.names[:3], inside[:3].astype(int).tolist(), strict=True)))
    return counted


def test_intervals_of_what_is_left_hold() -> None:
    counted = hits(range(1, 4))
    assert all(keeps("holds", one, 3) for one in counted.values()), counted


@pytest.mark.slow
def test_intervals_of_what_is_left_hold_in_200() -> None:
    n = sized(200, 60)
    counted = hits(range(1, n + 1))
    assert all(keeps("holds", one, n) for one in counted.values()), counted


def test_a_matrix_that_is_known_makes_the_bias_right_and_the_standards_needless() -> None:
    truth = np.array([0.04, -0.03, 0.02, 5e-3, -4e-3, 3e-3, 2e-3, -5e-3, 4e-3])
    made = recorded(
        np.random.default_rng(3), 2400.0, 2.0, gyro=matrix_of_truth(truth), noise_rate=1e-9, noise_field=1e-11
    )
    stated = {"sensor.scale_factor": Influence(0.05), "sensor.misalignment": Influence(5e-3, "rad")}
    without, found = reduced(made), reduced(made, matrix_correction(truth, np.full(9, 1e-7)), standards=stated)
    assert np.max(np.abs(without.estimate.values[:3] - made.bias)) > 1e-3 * DEG
    assert np.max(np.abs(found.estimate.values[:3] - made.bias)) < 2e-5 * DEG  # the bias as the gyro reads it, 4 % off
    assert np.max(found.estimate.u[:3]) < 1e-4 * DEG  # not by what the standards state
    missing = next(one.what for one in found.remarks if one.code == "relative_to_fixture")
    assert "sensor.scale_factor" not in missing
    assert "magnetometer.mounting" in missing
    assert [name for name in INFLUENCES if PROCEDURE.needs(name, found)] == list(INFLUENCES)[2:]


@pytest.mark.parametrize("key", [SCALES[1], PAIRS[3]])
def test_an_error_of_the_matrix_moves_the_bias_as_said(key: Key) -> None:
    made = recorded(np.random.default_rng(5), 2400.0, 2.0)
    sizes = np.zeros(9)
    at = (SCALES + PAIRS).index(key)
    sizes[at] = 2e-3
    wrong = np.zeros(9)
    wrong[at] = 2e-3
    exact, moved = reduced(made, matrix_correction(np.zeros(9), sizes)), reduced(made, matrix_correction(wrong, sizes))
    part = next(one for one in exact.estimate.components if one.origin.test == "table")
    assert part.changes is not None
    change = moved.estimate.values[:3] - exact.estimate.values[:3]
    row = part.changes[np.argmax(np.abs(part.changes).sum(axis=1)), :3]  # of the one unknown, of either sign
    assert change == pytest.approx(row * np.sign(change @ row), abs=0.1 * np.max(np.abs(change)))


def test_tests_of_one_axis_each_are_one_matrix() -> None:
    truth = np.array([0.04, -0.03, 0.02, 5e-3, -4e-3, 3e-3, 2e-3, -5e-3, 4e-3])
    keys = SCALES + PAIRS
    whole = matrix_correction(truth)
    parts = []
    for axis in AXES:
        own = [i for i, key in enumerate(keys) if key.axis[-1] == axis]
        parts.append(
            replace(matrix_correction(truth[own], SIZES[own], tuple(keys[i] for i in own)), tests=(f"rate_{axis}",))
        )
    joined = matrix_of(parts)
    assert joined is not None
    assert joined.matrix == pytest.approx(whole.matrix)
    assert joined.test == "rate_x, rate_y, rate_z"
    made = recorded(np.random.default_rng(6), 2400.0, 2.0, gyro=matrix_of_truth(truth))
    one, other = reduced(made, whole), reduced(made, *parts)
    assert other.estimate.values == pytest.approx(one.estimate.values)
    assert other.estimate.u == pytest.approx(one.estimate.u, rel=1e-6)
    with pytest.raises(DataError, match="both found scale_factor_error_x"):
        matrix_of([parts[0], parts[0]])


def test_a_curvature_that_a_rate_table_leaves_open_counts_by_its_size() -> None:
    """Its changes are for one unit of the curvature, of which it may have none."""
    change = np.array([[3.0] + [0.0] * 8])
    parts = tuple(
        Component(f"curvature of {size}", "B", size**2 * change.T @ change, stated=(size, "s/rad"), changes=change,
                  term="second_order_x")
        for size in (0.0, 1e-3)
    )  # fmt: skip
    correction = MatrixCorrection(("table",), (Estimate(SCALES + PAIRS, np.zeros(9), ("1",) * 9, parts),))
    _, (unknowns,) = correction.apply([("one", recording(recorded(np.random.default_rng(1), 400.0, 2.0)))])
    (law,) = [one.law for one in unknowns.values()]
    assert np.abs(law) == pytest.approx(1e-3 * change)
