"""Forecast of a mass-attraction test: closed forms, the published comparison of drives, and what simulation gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, stats

from inertialcal.core.errors import PlanError
from inertialcal.procedures.mass_attraction.planning.forecast import (
    Cycle,
    difference_covariance,
    forecast,
    relative_noise,
    takeover,
    time_to,
)
from inertialcal.sensors.noise import BiasInstability, RandomWalk, RateRamp, RateRandomWalk, Term, simulate
from inertialcal.sensors.noise.terms import total_phase

RESPONSE = 0.235  # pulses/s: 23 ng at 10.21 pulses/s/ug
SD, STEP = 0.056, 0.05  # of a sample, of a random walk from sample to sample [pulses/s]
ROUNDING = 0.04  # of a percentage with three digits, and of the response
ORDERS = {"sine": (0.0, 1.0, 0.0, -1.0), "abab": (1.0, -1.0), "abba": (1.0, -1.0, -1.0, 1.0)}
MOMENT = 1e-6  # a dwell so short that a mean is a value, as in those figures
NA = 23e-9 * 9.80665
MESA = RandomWalk(55e-9 * 9.80665)
MIXED: tuple[Term, ...] = (MESA, BiasInstability(2e-9 * 9.80665), RateRandomWalk(1e-10 * 9.80665))


def at_moments(order: str, dwells: int = 100) -> Cycle:
    values = ORDERS[order] if order in ORDERS else (1.0,) * (dwells // 2) + (-1.0,) * (dwells // 2)
    return Cycle(tuple(RESPONSE * value for value in values), MOMENT, 1.0 - MOMENT)


def dwells(order: str) -> Cycle:
    return Cycle(tuple(NA * value for value in ORDERS[order]), 100.0, 20.0)


@pytest.mark.parametrize(("order", "percent"), [("sine", 3.38), ("abab", 2.39)])
def test_white_noise_follows_the_published_figures_and_the_closed_form(order: str, percent: float) -> None:
    cycle = at_moments(order)
    found = relative_noise(cycle, (RandomWalk(SD * MOMENT**0.5),), 100 // len(cycle.applied))
    assert 100.0 * found == pytest.approx(percent, abs=ROUNDING)
    assert found == pytest.approx(SD / np.sqrt(100 // len(cycle.applied) * np.sum(np.square(cycle.applied))))


@pytest.mark.parametrize(("order", "percent"), [("sine", 4.01), ("abab", 2.62), ("abba", 2.82), ("step", 16.7)])
def test_random_walk_follows_the_published_figures_and_plain_least_squares(order: str, percent: float) -> None:
    cycle = at_moments(order)
    terms = RandomWalk(SD * MOMENT**0.5), RateRandomWalk(STEP)
    found = relative_noise(cycle, terms, 100 // len(cycle.applied))
    i = np.arange(100)
    covariance = SD**2 * np.eye(100) + STEP**2 * np.minimum.outer(i, i)
    design = np.column_stack([np.tile(cycle.applied, 100 // len(cycle.applied)), np.ones(100)])
    direct = np.linalg.inv(design.T @ np.linalg.solve(covariance, design))[0, 0]
    assert found == pytest.approx(np.sqrt(direct), rel=1e-4)
    assert 100.0 * found == pytest.approx(percent, abs=ROUNDING)


def test_a_line_that_is_free_costs_a_slow_drive_more() -> None:
    cost = {}
    for order in ("abab", "step"):
        cycle = at_moments(order)
        count = 100 // len(cycle.applied)
        terms = (RandomWalk(SD * MOMENT**0.5),)
        cost[order] = relative_noise(cycle, terms, count, line=True) / relative_noise(cycle, terms, count)
        ramped = relative_noise(cycle, (*terms, RateRamp(1e-3)), count)
        assert ramped == pytest.approx(relative_noise(cycle, terms, count, line=True))
    assert 1.0 < cost["abab"] < 1.001
    assert cost["step"] == pytest.approx(2.0, rel=0.01)  # a step and a line: 1 / (1 - 3/4) of the variance


@pytest.mark.parametrize("order", ["sine", "abab"])
def test_what_is_forecast_is_what_simulated_tests_scatter_by(order: str) -> None:
    """Scale factors of simulated tests, by the weights of least squares, scatter by what was forecast; 95 % hit."""
    cycle, n, draws = dwells(order), 100, 1000
    rng = np.random.default_rng(1)
    applied = np.diff(np.tile(cycle.applied, n // len(cycle.applied)))
    W = linalg.inv(linalg.toeplitz(difference_covariance(total_phase(MIXED, 120.0, 100.0), n - 1)))
    weights = W @ applied / (applied @ W @ applied)
    errors = np.array([weights @ np.diff(simulate(MIXED, n, 120.0, rng, 100.0)) for _ in range(draws)])
    u = relative_noise(cycle, MIXED, n // len(cycle.applied))
    low, high = stats.chi2.ppf([0.0005, 0.9995], draws) / draws
    assert low < np.mean(errors**2) / u**2 < high
    hits = stats.binomtest(int(np.sum(np.abs(errors) < 1.96 * u)), draws).proportion_ci(0.999)
    assert hits.low < 0.97
    assert hits.high > 0.93


@pytest.mark.parametrize("terms", [(MESA,), MIXED, (BiasInstability(1e-8),)], ids=["white", "mixed", "flicker"])
@pytest.mark.parametrize("order", ["sine", "abab", "abba"])
def test_beyond_what_is_solved_information_grows_by_the_cycle(order: str, terms: tuple[Term, ...]) -> None:
    cycle = dwells(order)
    count = 2048 // len(cycle.applied)
    applied = np.diff(np.tile(cycle.applied, count))
    covariance = difference_covariance(total_phase(terms, 120.0, 100.0), len(applied))
    solved = applied @ linalg.solve_toeplitz(covariance, applied)
    assert relative_noise(cycle, terms, count) == pytest.approx(solved**-0.5, rel=1e-5)


def test_one_on_one_off_takes_half_the_time_of_the_sine_or_less() -> None:
    times = {order: time_to(dwells(order), MIXED, 0.01) for order in ("sine", "abab")}
    assert times["sine"] is not None
    assert times["abab"] is not None
    assert times["sine"] / times["abab"] > 1.99


def test_the_time_to_a_target_is_the_first_cycle_that_reaches_it() -> None:
    cycle = dwells("sine")
    found = time_to(cycle, MIXED, 0.01, u_applied=0.003)
    assert found is not None
    around = forecast(cycle, MIXED, [found - cycle.period, found], u_applied=0.003)
    assert around.u[1] <= 0.01 < around.u[0]


def test_the_budget_takes_over_where_both_are_equal_and_no_time_beats_it() -> None:
    cycle = dwells("abab")
    over = takeover(cycle, MIXED, 0.005)
    assert over is not None
    assert relative_noise(cycle, MIXED, round(over / cycle.period)) == pytest.approx(0.005, rel=1e-3)
    assert takeover(cycle, MIXED, 0.0) is None
    assert time_to(cycle, MIXED, 0.005, u_applied=0.005) is None
    assert forecast(cycle, MIXED, [1e9], u_applied=0.005).u[0] == pytest.approx(0.005, rel=1e-3)


def test_times_are_those_of_whole_cycles() -> None:
    assert forecast(dwells("sine"), MIXED, [1.0, 480.0, 959.0, 960.0]).time.tolist() == [480.0, 480.0, 480.0, 960.0]


def test_without_noise_or_drive_nothing_is_forecast() -> None:
    with pytest.raises(PlanError, match="no noise is given"):
        forecast(dwells("sine"), (), [1e5])
    with pytest.raises(PlanError, match="two or more dwells that apply different accelerations"):
        Cycle((NA, NA), 100.0, 20.0)
    with pytest.raises(PlanError, match="a dwell of 0 s with moves of 20 s"):
        Cycle((NA, -NA), 0.0, 20.0)
