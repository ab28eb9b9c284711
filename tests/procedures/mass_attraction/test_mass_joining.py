"""Several runs of a moved mass: the wider of noise and scatter, and drives whose phase differs from run to run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.estimate import Array
from inertialcal.physics.motion.schedule import repeated
from inertialcal.procedures.mass_attraction.agreement import agreement
from inertialcal.procedures.mass_attraction.joining import between_variance, join, quiet_runs
from inertialcal.procedures.mass_attraction.plan import Plan
from inertialcal.procedures.mass_attraction.readings import Readings, Run
from inertialcal.procedures.mass_attraction.reduction import Result, reduce
from inertialcal.procedures.mass_attraction.response import response_of
from inertialcal.statistics.intervals import coverage_factor, covers
from sized import sized

A, S, NOISE, DWELLS = 2.25e-7, 1.04e6, 0.056, 100  # [m/s^2], [count/s/(m/s^2)], [count/s]
PLAN = Plan(tilt="ignored")
DOF = 16.0


def campaign(seed: int, starts: list[int], drift: Array, gains: list[float] | None = None) -> Readings:
    """Return runs whose drives start by so many degrees ahead; the same drift in each [responses]."""
    rng, runs = np.random.default_rng(seed), []
    for k, start in enumerate(starts):
        cycle = np.roll([0.0, 1.0, 0.0, -1.0], -start // 90)
        schedule = repeated(cycle, A * cycle, cycles=DWELLS // 4, dwell=100.0, move=20.0, u_applied=0.0)
        gain = 1.0 if gains is None else gains[k]
        reading = 150.0 + gain * S * (schedule.applied + A * drift) + NOISE * rng.standard_normal(DWELLS)
        runs.append(Run(str(k), schedule, reading))
    return Readings(tuple(runs))


def scale_factor(result: Result) -> tuple[float, float, float]:
    assert result.estimate is not None
    return tuple(float(one[0]) for one in (result.estimate.values, result.estimate.u, result.estimate.dof))  # type: ignore[return-value]


SAWTOOTH = 20.0 * (np.arange(DWELLS) / DWELLS * 7.3 % 1.0)


def test_equal_runs_that_differ_give_what_textbooks_give() -> None:
    found = join(np.array([1.0, 2.0, 3.0]), np.full(3, 0.1), np.full(3, DOF))
    assert found.between is not None
    assert (found.between.value, found.between.u, found.between.dof) == pytest.approx((2.0, 1.0 / np.sqrt(3.0), 2.0))
    assert found.within.u == pytest.approx(0.1 / np.sqrt(3.0))
    assert found.within.dof == pytest.approx(DOF)  # one noise, fitted to all
    assert found.p_value < 1e-6
    assert found.scatter == "between_runs"


def test_the_variance_between_runs_brings_the_residuals_to_their_lower_quartile() -> None:
    values = np.array([1.0, 2.0, 3.0, 6.0])  # squares about their mean: 14
    found = between_variance(values, np.full(4, 0.5), np.ones((4, 1)))
    assert 14.0 / (0.25 + found) == pytest.approx(stats.chi2.ppf(0.25, 3.0), rel=1e-5)


def test_degrees_of_freedom_of_the_noise_are_satterthwaites() -> None:
    """Weights by 1 / u^2: variances 100 and 25, of a whole of 125."""
    found = join(np.ones(2), np.array([0.1, 0.2]), np.array([4.0, 20.0])).within
    assert found.u == pytest.approx(125.0**-0.5)
    assert found.dof == pytest.approx(125.0**2 / (100.0**2 / 4.0 + 25.0**2 / 20.0))


def test_a_run_keeps_its_noise_where_the_mean_of_both_is_taken_out() -> None:
    ratios = []
    for seed in range(10):
        runs = campaign(seed, [0, 180], np.zeros(DWELLS)).series
        u = [(one.response(PLAN).u, response_of(PLAN, one.run).u) for one in quiet_runs(runs)]
        ratios += [own / quiet for own, quiet in u]
        assert np.mean([own for own, _ in u]) == pytest.approx(NOISE * np.sqrt(2.0 / DWELLS), rel=0.5)
    assert ratios == pytest.approx(np.full(20, np.sqrt(2.0)))


def test_runs_that_agree_better_than_their_noise_have_the_uncertainty_of_their_noise() -> None:
    found = join(np.array([1.0, 1.001, 0.999, 1.0]), np.full(4, 0.1), np.full(4, DOF))
    assert found.scatter == "within_runs"
    assert found.by(found.scatter).u == pytest.approx(0.05)


@pytest.mark.parametrize("runs", [2, 4, 10])
@pytest.mark.parametrize("scatter", [0.0, 1.0, 5.0])
@pytest.mark.parametrize("worst", [1.0, 3.0])
def test_intervals_hold_the_mean_whether_runs_scatter_or_not(runs: int, scatter: float, worst: float) -> None:
    rng, n, held, widths = np.random.default_rng(runs), 300, 0, []
    sigma = np.where(np.arange(runs) < runs // 2, worst, 1.0)
    for _ in range(n):
        values = np.hypot(sigma, scatter) * rng.standard_normal(runs)
        u = sigma * np.sqrt(rng.chisquare(DOF, runs) / DOF)
        found = join(values, u, np.full(runs, DOF))
        mean = found.by(found.scatter)
        held += abs(mean.value) <= stats.t.ppf(0.975, mean.dof) * mean.u
        widths.append(mean.u)
    assert covers(held, n), held
    assert np.median(widths) < 1.35 / np.sqrt(np.sum(1.0 / (sigma**2 + scatter**2)))


@pytest.mark.parametrize("starts", [[0, 180, 0, 180], [0, 90, 0, 90], [90, 0, 90, 0], [0, 90, 180, 90]])
def test_what_repeats_cancels_if_the_phase_of_the_drive_differs(starts: list[int]) -> None:
    alone = scale_factor(reduce(PLAN, campaign(1, starts, np.zeros(DWELLS))))
    result = reduce(PLAN, campaign(1, starts, SAWTOOTH))
    assert scale_factor(result) == pytest.approx(alone, rel=0.02)
    (remark,) = [one for one in result.remarks if one.code == "repeating_drift"]
    assert "% of the response" in remark.what
    assert not agreement(PLAN, campaign(1, starts, SAWTOOTH))
    alike = reduce(PLAN, campaign(1, [0] * len(starts), SAWTOOTH))
    assert scale_factor(alike)[0] / S - 1.0 > 0.05


def test_with_two_phases_the_parts_that_repeat_have_opposite_signs() -> None:
    found = reduce(PLAN, campaign(2, [0, 180, 180], SAWTOOTH)).joined
    assert found is not None
    assert found.repeats[1:] == pytest.approx(-found.repeats[0] * np.ones(2))
    assert found.phases == pytest.approx([0.0, np.pi, np.pi])


def test_phases_that_would_cost_too_much_are_not_used() -> None:
    cycle = np.sin(2.0 * np.pi * np.arange(8) / 8.0)
    rng, runs = np.random.default_rng(1), []
    for k in range(4):
        one = np.roll(cycle, -(k % 2))
        schedule = repeated(one, A * one, cycles=12, dwell=100.0, move=20.0, u_applied=0.0)
        runs.append(Run(str(k), schedule, S * schedule.applied + NOISE * rng.standard_normal(96)))
    found = reduce(PLAN, Readings(tuple(runs))).joined
    assert found is not None
    assert found.phases is None


def hits(n: int, starts: list[int], spread: float = 0.0, grows: float = 0.0) -> tuple[int, float]:
    """Return how many intervals hold the scale factor; gains scatter, and the drift grows, from run to run."""
    held, off = 0, []
    for seed in range(n):
        rng = np.random.default_rng([3, seed])
        gains = list(1.0 + spread * rng.standard_normal(len(starts)))
        readings = campaign(seed, starts, SAWTOOTH, gains)
        if grows:
            each = [Run(one.name, one.schedule, one.reading + grows * k * S * A * SAWTOOTH)
                    for k, one in enumerate(readings.series)]  # fmt: skip
            readings = Readings(tuple(each))
        value, u, dof = scale_factor(reduce(PLAN, readings))
        held += abs(value - S) <= coverage_factor(dof) * u
        off.append(value / S - 1.0)
    return held, float(np.mean(off))


def test_intervals_with_an_alternating_phase_hold_the_truth() -> None:
    held, bias = hits(15, [0, 180, 0, 180])
    assert covers(held, 15)
    assert abs(bias) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("starts", [[0, 180, 0, 180], [0, 180, 0], [0, 90, 180, 270], [0, 90, 0, 90, 0, 90]])
@pytest.mark.parametrize(("spread", "grows"), sized([(0.0, 0.0), (0.05, 0.0), (0.0, 0.02)], [(0.05, 0.02)]))
def test_intervals_with_phases_hold_the_truth_if_gains_differ_or_the_drift_grows(
    starts: list[int], spread: float, grows: float
) -> None:
    n = sized(1000, 100)
    held, _ = hits(n, starts, spread, grows)
    assert covers(held, n), held


def test_a_gain_that_differs_with_the_phase_looks_like_drift_and_is_remarked() -> None:
    readings = campaign(1, [0, 180, 0, 180], np.zeros(DWELLS), [1.2, 0.8, 1.2, 0.8])
    result = reduce(PLAN, readings)
    assert scale_factor(result)[0] == pytest.approx(S, rel=0.03)
    assert "repeating_drift" in [one.code for one in result.remarks]


@pytest.mark.slow
def test_runs_of_another_length_count_what_repeats_as_scatter() -> None:
    held, n = 0, sized(1000, 80)
    for seed in range(n):
        runs = campaign(seed, [0, 180, 0, 180], SAWTOOTH).series
        longer = runs[0].schedule
        short = type(longer)(longer.start[:60], 100.0, 20.0, longer.position[:60], longer.applied[:60],
                             "custom", 4, 0.0)  # fmt: skip
        cut = Run("short", short, runs[0].reading[:60])
        value, u, dof = scale_factor(reduce(PLAN, Readings((cut, *runs[1:]))))
        held += abs(value - S) <= coverage_factor(dof) * u
    assert covers(held, n), held


@pytest.mark.parametrize("runs", [2, 3])
def test_a_gross_jump_of_one_run_stays_in_that_run(runs: int) -> None:
    readings = campaign(5, [0, 180, 0][:runs], np.zeros(100))
    whole = [one.run.reading for one in quiet_runs(readings.series)]
    jump = 500.0 * (np.arange(100) >= 37)
    series = list(readings.series)
    series[1] = replace(series[1], reading=series[1].reading + jump)
    faulty = [one.run.reading for one in quiet_runs(series)]
    for k in range(runs):
        change = faulty[k] - whole[k] - (jump if k == 1 else 0.0)
        assert abs(change[40:].mean() - change[:34].mean()) < 2.0  # of 250 or 167 without the repair


def test_without_any_meter_the_missing_tilt_is_said_once() -> None:
    result = reduce(Plan(), campaign(6, [0, 180, 0], np.zeros(100)))
    assert [one.code for one in result.remarks].count("missing_tilt") == 1
