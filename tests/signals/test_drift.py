"""Drift of a record at rest: the curve it was made with, and no false alarms."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.signals.drift import drift_of

N, INTERVAL = 8_000, 0.01


def test_rise_is_found_with_its_uncertainty() -> None:
    rng = np.random.default_rng(1)
    ramp = 0.1 * np.arange(N) / N
    found = [drift_of(ramp + 0.3 * rng.normal(size=N), 2, INTERVAL)[0] for _ in range(100)]
    off = np.array([(one.rise - 0.1 * 63 / 64) / one.u for one in found])
    assert abs(off.mean()) < 4.0 / 10.0
    assert 0.6 < off.std() < 1.1  # rather too large than too small
    assert {one.axis for one in found} == {2}


def test_white_noise_has_none() -> None:
    rng = np.random.default_rng(2)
    assert not any(drift_of(rng.normal(size=N), 0, INTERVAL)[0].significant for _ in range(200))


@pytest.mark.parametrize("walk", [2e-3, 0.01, 1.0])
def test_a_random_walk_is_none(walk: float) -> None:
    """Steps from sample to sample, of white noise: its own rise is hidden, about as large as blocks scatter, alone."""
    rng = np.random.default_rng(4)
    records = (rng.normal(size=N) + walk * np.cumsum(rng.normal(size=N)) for _ in range(60))
    assert sum(drift_of(x, 0, INTERVAL)[0].significant for x in records) <= 3  # 0.6 expected at most


def test_one_that_falls_early_is_a_warm_up_and_missing_samples_do_no_harm() -> None:
    rng, t = np.random.default_rng(3), np.linspace(0.0, 1.0, N)
    x = 0.3 * rng.normal(size=N) - 2.0 * np.exp(-t / 0.15)
    (whole,) = drift_of(x, 0, INTERVAL)
    assert whole.significant
    assert whole.remark("x").code == "warm_up"
    x[2_000:2_700] = np.nan
    (gaps,) = drift_of(x, 0, INTERVAL)
    assert gaps.rise == pytest.approx(whole.rise, abs=3.0 * whole.u)
    (line,) = drift_of(0.3 * rng.normal(size=N) + 2.0 * t, 0, INTERVAL)
    assert line.remark("x").code == "drift"
    assert "x: drifts by " in line.remark("x").what


@pytest.mark.parametrize("x", [np.ones(N), np.full(N, np.nan), np.arange(40.0)])
def test_nothing_is_said_of_records_that_do_not_scatter_or_are_short(x: np.ndarray) -> None:
    assert drift_of(x, 0, INTERVAL) == ()
