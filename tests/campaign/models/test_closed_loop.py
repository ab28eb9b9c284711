"""Closed loop: wrong models are refused, right ones pass, and no difference is seldom called a failure."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest

from inertialcal.core.influence import Influence
from inertialcal.procedures.rate_table.model.closed_loop import closed_loop
from inertialcal.procedures.rate_table.model.held_out import compensated_dwells, mixed_up
from inertialcal.procedures.rate_table.reduction import Plan, Readings, Result, Truth, reduce, simulate
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.statistics.closed_loop import judged, overall
from inertialcal.statistics.intervals import binomial_interval
from sized import sized

PLAN = Plan(standards={"rate_table.rate": Influence(3e-4)}, zero_reference=True)
PARAMETERS = ("bias", "scale_factor_error", "misalignment", "scale_factor_asymmetry")
RISK = 0.05


def fitted(readings: Readings) -> tuple[Result, SensorModel]:
    result = reduce(PLAN, readings)
    assert result.estimate is not None
    names = [name for name in result.estimate.names if name.rpartition("_")[0] in PARAMETERS]
    return result, model_from(
        result.estimate.select(names), "gyro", ("x", "y", "z"), input_range=np.full((3, 2), [-9, 9])
    )


def campaign(seed: int, matrix: np.ndarray, bias: np.ndarray, runs: int = 3) -> tuple[Result, SensorModel, Readings]:
    """Model of five power-ups, and dwells of ``runs`` others under the same errors of the table."""
    rng = np.random.default_rng(seed)
    truth = Truth(matrix, bias, runs=5 + runs)
    readings = simulate(PLAN, truth, rng)
    assert readings.run is not None
    held = np.isin(readings.run, [str(6 + i) for i in range(runs)])
    result, model = fitted(readings.take(~held))
    return result, model, simulate_earth(readings.take(held), result)


def simulate_earth(held: Readings, result: Result) -> Readings:
    """The earth rate of the held out dwells is taken as that of the fit: zero along the axes, unknown across."""
    return replace(held, earth=np.zeros((len(held), 3)))


REAL = np.eye(3) + np.array([[0.004, 0.013, -0.002], [0.0015, -0.005, 0.009], [-0.012, 0.003, 0.006]])
BIAS = np.radians([0.02, -0.03, 0.015])


@cache
def real(seed: int) -> tuple[Result, SensorModel, Readings]:
    return campaign(seed, REAL, BIAS)


def verdict(result: Result, model: SensorModel, held: Readings) -> str:
    return overall(judged(closed_loop(result.lines, held, partial(compensated_dwells, model), mixed_up(model))))


def test_a_right_model_passes_on_every_axis() -> None:
    assert [verdict(*real(seed)) for seed in range(1, 11)].count("PASS") >= 9


@pytest.mark.parametrize(
    "break_it",
    [
        np.transpose,
        lambda m: 2.0 * np.eye(3) - m,
        lambda m: m[[1, 0, 2]][:, [1, 0, 2]],
        lambda m: m[[2, 0, 1]][:, [2, 0, 1]],
    ],
    ids=["transposed", "sign flipped", "x and y exchanged", "axes shifted"],
)
def test_a_mixed_up_matrix_is_refused(break_it) -> None:  # type: ignore[no-untyped-def]
    for seed in range(1, 21):
        result, model, held = real(seed)
        broken = replace(model, matrix=break_it(model.matrix[0]), estimate=None)
        assert verdict(result, broken, held) == "FAIL"


def test_an_inverted_bias_is_refused() -> None:
    for seed in range(1, 21):
        result, model, held = real(seed)
        assert verdict(result, replace(model, bias=-model.bias, estimate=None), held) == "FAIL"


def false_alarms(n: int, runs: int) -> int:
    """How many of n campaigns with a perfect sensor FAIL: there is nothing to correct, only the fit's own noise."""
    return sum(verdict(*campaign(seed, np.eye(3), np.zeros(3), runs)) == "FAIL" for seed in range(1, n + 1))


@pytest.mark.parametrize("runs", [pytest.param(1, marks=pytest.mark.slow), 3])
def test_no_difference_seldom_fails(runs: int) -> None:
    assert binomial_interval(false_alarms(40, runs), 40)[0] <= RISK


@pytest.mark.slow
def test_no_difference_seldom_fails_long() -> None:
    n = sized(1000, 200)
    assert binomial_interval(false_alarms(n, 3), n)[0] <= RISK


def test_judged_by_its_own_readings_the_gain_is_as_uncertain_as_clusters_of_runs_make_it() -> None:
    """4 G / (G - 1) N / (N - p) times the sum over G runs of (sum of correction times residual)^2, over N^2."""
    line = real(1)[0].lines["x"]
    readings, n, p = line.readings, len(line.readings), len(line.fit.coefficients)
    (found,) = closed_loop({"x": line}, readings, lambda of: {"x": 0.999 * of.outputs["x"]}, {})
    assert readings.run is not None
    product = 0.001 * readings.outputs["x"] * line.fit.residuals
    sums = np.array([product[readings.run == run].sum() for run in np.unique(readings.run)])
    runs = len(sums)
    assert found.u == pytest.approx(np.sqrt(4.0 * runs / (runs - 1) * n / (n - p) * np.sum(sums**2)) / n)
    assert found.dof == runs - 1
