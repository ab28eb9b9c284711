"""Disturbances that were put into noise, and noise without any."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation.stillness import judge, surely_still


def _noise(seed: int, n: int = 6000) -> Array:
    return np.random.default_rng(seed).normal(0.0, 1.0, n)


def test_a_disturbance_is_placed() -> None:
    values = _noise(1)
    values[3000:3060] += 25.0 * np.sin(np.arange(60) * 0.3)
    found = judge(values)
    assert found is not None
    assert found.at_rest
    (disturbance,) = found.disturbances
    assert 3000 <= disturbance.first <= 3010
    assert 3045 <= disturbance.last < 3060
    assert disturbance.peak == pytest.approx(25.0, rel=0.2)


def test_noise_alone_is_never_disturbed() -> None:
    for seed in range(200):
        found = judge(_noise(seed))
        assert found is not None
        assert found.at_rest
        assert found.disturbances == ()


def test_neither_drift_nor_a_single_spike_is_a_disturbance() -> None:
    values = _noise(2) + np.linspace(0.0, 30.0, 6000)
    values[1234] += 40.0
    found = judge(values)
    assert found is not None
    assert found.at_rest
    assert found.disturbances == ()


def test_a_sensor_that_turns_through_positions_is_not_at_rest() -> None:
    level = np.repeat(np.random.default_rng(3).normal(0.0, 100.0, 40), 150)
    found = judge(level + _noise(4))
    assert found is not None
    assert not found.at_rest


def test_a_floor_keeps_single_codes_from_being_disturbances() -> None:
    codes = np.zeros(6000)
    codes[::100] = 1.0
    assert judge(codes, floor=0.0) is None
    found = judge(codes, floor=1.0)
    assert found is not None
    assert found.disturbances == ()


def test_a_short_channel_cannot_be_judged() -> None:
    assert judge(_noise(5, 150)) is None


def test_adding_a_constant_and_scaling_change_nothing() -> None:
    values = _noise(6)
    values[100:140] += 30.0
    (here,), (scaled,), (shifted,) = (
        judged.disturbances for judged in map(judge, (values, 4.0 * values, values + 64.0)) if judged
    )
    assert (here.first, here.last) == (scaled.first, scaled.last) == (shifted.first, shifted.last)
    assert here.peak == pytest.approx(scaled.peak) == pytest.approx(shifted.peak)


def test_what_is_surely_still_is_judged_so() -> None:
    sure = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(150, 4000))
        x = rng.normal(size=n)
        one = seed % 8
        x[n // 2] += 9.0 * (one == 1)
        x[n // 2 : n // 2 + 40] += 3.0 * (one == 2)
        x[n // 3 :] += 0.5 * (one == 3)
        x = {4: np.cumsum(x), 5: np.rint(0.3 * x), 6: np.where(np.arange(n) < n // 4, 3.0 * x, x), 7: 0.0 * x}.get(
            one, x
        )
        if surely_still(x):
            found = judge(x)
            sure += 1
            assert found is None or (found.at_rest and not found.disturbances)
        assert not surely_still(np.append(x, [np.nan] * 200))
    assert 10 < sure < 30
