"""Drift of the runs that is not smooth: what repeats and shows, what is near the drive; what noise makes of both."""

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.physics.motion.schedule import Schedule, repeated
from inertialcal.procedures.mass_attraction.drift import FALSE, drift_remarks, repeating_chance
from inertialcal.procedures.mass_attraction.plan import Plan
from inertialcal.procedures.mass_attraction.readings import Run
from inertialcal.procedures.mass_attraction.response import responses_of
from inertialcal.statistics.intervals import covers

N = 100
SIGNAL, NOISE = 0.23, 0.056  # count/s
PLAN = Plan(tilt="ignored")


def schedule(n: int = N) -> Schedule:
    return repeated(
        (0.3, 0.15, 0.3, 0.45), np.array([0.0, 2.3e-7, 0.0, -2.3e-7]), cycles=n // 4, dwell=100.0, move=20.0
    )


def runs(drift: Array, number: int = 5, seed: int = 1, lost: int = 0) -> list[Run]:
    rng, of = np.random.default_rng(seed), schedule()
    made = []
    for k in range(number):
        x = 150.0 + SIGNAL * of.applied / of.amplitude + drift + NOISE * rng.standard_normal(N)
        x[rng.choice(N, lost, replace=False)] = np.nan
        made.append(Run(f"run{k}", of, x))
    return made


def codes(made: list[Run]) -> set[str]:
    return {one.code for one in drift_remarks(made, responses_of(PLAN, made)) if one.severity == "error"}


PLACE = (np.arange(N) + 0.5) / N


@pytest.mark.parametrize("lost", [0, 3])
def test_smooth_drift_that_repeats_is_no_error_and_enters_no_response(lost: int) -> None:
    clean = [one.amplitude for one in responses_of(PLAN, runs(np.zeros(N), 2, lost=lost))]
    for drift in (np.exp(-10.0 * PLACE), 0.5 * np.sin(np.arange(N) * np.pi / 6.0)):
        made = runs(1e3 * SIGNAL * drift, 2, lost=lost)
        assert not codes(made)
        found = [one.amplitude for one in responses_of(PLAN, made)]
        np.testing.assert_allclose(found, clean, atol=0.005 * SIGNAL)


def test_drift_near_the_drive_is_an_error() -> None:
    assert "drift_near_drive" in codes(runs(50.0 * SIGNAL * np.sin(np.arange(N) * 2.0 * np.pi / 5.0 + 0.7)))


def test_what_repeats_and_is_not_smooth_is_an_error_of_runs_that_start_alike() -> None:
    wave = 2.0 * SIGNAL * np.where(np.arange(N) % 13 < 6, 1.0, -1.0)
    assert "drift_repeats" in codes(runs(wave))
    assert "drift_repeats" not in codes(runs(wave, number=1))  # nothing to compare with


def test_a_kink_in_every_run_is_an_error_where_it_biases_the_response() -> None:
    kink = 100.0 * SIGNAL * np.maximum(PLACE - 0.85, 0.0) / 0.15
    assert sum("drift_repeats" in codes(runs(kink, seed=seed)) for seed in range(4)) >= 3


def test_a_drive_of_many_dwells_a_cycle_is_no_drift_that_repeats() -> None:
    applied = 2.3e-7 * np.sin(2.0 * np.pi * np.arange(24) / 24.0)
    of = repeated(tuple(0.3 - 0.1 * applied / 2.3e-7), applied, cycles=10, dwell=100.0, move=20.0)
    rng = np.random.default_rng(4)
    made = [Run(f"run{k}", of, 150.0 + SIGNAL * of.applied / of.amplitude + NOISE * rng.standard_normal(240))
            for k in range(3)]  # fmt: skip
    assert "drift_repeats" not in codes(made)


@pytest.mark.parametrize("number", [2, 5])
def test_noise_alone_is_seldom_called_a_drift_that_repeats(number: int) -> None:
    rng = np.random.default_rng(number)
    walks = np.linspace(0.2, 0.7, 48)
    size = np.sqrt(1.0 + walks)[:, None]
    kinks = rng.standard_normal((48, 90))
    called = sum(repeating_chance(size * rng.standard_normal((48, number)), walks, kinks) < FALSE for _ in range(400))
    assert called <= 10  # 2.5 %; 0.5 % in 12,000


def test_runs_share_their_noise() -> None:
    """95 % intervals of single runs, of the noise of five."""
    hits = 0
    for seed in range(8):
        for one in responses_of(PLAN, runs(np.zeros(N), seed=seed)):
            hits += abs(one.amplitude - SIGNAL) < 2.0 * one.u
            assert one.dof > 25.0
    assert covers(hits, 40), hits
