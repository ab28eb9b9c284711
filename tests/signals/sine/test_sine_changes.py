"""Jumps and changes of the response inside records of a driven sensor."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from inertialcal.signals.sine.changes import (
    MAD,
    _scale,
    contrast,
    critical,
    cycle_amplitudes,
    jumps,
    response_changes,
)

CHANCE = 5e-4


@pytest.mark.parametrize("w", [1, 2, 4])
def test_contrast_shows_two_thirds_of_a_jump_and_nothing_of_a_parabola(w: int) -> None:
    at = np.arange(60.0)
    assert contrast(np.where(at < 30, 1.0, 4.0), w)[30] == pytest.approx(2.0)
    assert np.nanmax(np.abs(contrast(0.3 * at**2 - 5.0 * at + 2.0, w))) < 1e-9


def test_contrast_of_a_record_shorter_than_its_windows_is_empty() -> None:
    assert np.isnan(contrast(np.arange(7.0), 2)).all()
    assert len(contrast(np.empty(0), 1)) == 0


def test_an_outlier_is_no_jump_and_a_step_is() -> None:
    rng = np.random.default_rng(1)
    records = [rng.standard_normal(200) for _ in range(3)]
    records[0][90] += 40.0
    records[1][120:] -= 20.0
    found = jumps(records, CHANCE)
    assert found[0] is None
    assert found[2] is None
    assert found[1] is not None
    assert found[1].at == 120
    assert found[1].size == pytest.approx(-20.0, abs=3.0)


def test_smooth_drift_is_no_jump() -> None:
    rng = np.random.default_rng(2)
    drift = 100.0 * np.exp(-np.arange(200) / 20.0)
    assert jumps([drift + rng.standard_normal(200) for _ in range(3)], CHANCE) == [None] * 3


def test_records_without_noise_or_readings_show_nothing() -> None:
    assert jumps([np.zeros(100), np.full(100, np.nan), np.empty(0)], CHANCE) == [None] * 3
    assert response_changes([np.zeros(20), np.empty(0)], CHANCE) == [None, None]
    assert response_changes([], CHANCE) == []


def test_the_response_of_each_cycle_by_the_readings_that_are_there() -> None:
    drive = np.tile([0.0, 1.0, 0.0, -1.0], 10)
    cycle = np.arange(40) // 4
    rest = 3.0 * drive
    rest[5] = np.nan  # half of its cycle
    rest[[13, 15]] = np.nan  # all of it
    amplitudes, first = cycle_amplitudes(rest, drive, cycle)
    assert amplitudes == pytest.approx(3.0)
    assert first.tolist() == [0, 8, 16, 20, 24, 28, 32, 36]


def test_a_change_of_the_response_and_where_it_is() -> None:
    rng = np.random.default_rng(3)
    each = [5.0 + 0.3 * rng.standard_normal(30) for _ in range(4)]
    each[2][18:] *= 1.5
    found = response_changes(each, CHANCE)
    assert [one is not None for one in found] == [False, False, True, False]
    assert found[2] is not None
    assert found[2].at == 18
    assert found[2].after / found[2].before == pytest.approx(1.5, rel=0.1)


def test_the_score_of_a_change_is_students_t_over_its_limit() -> None:
    each = np.random.default_rng(6).standard_normal(60) + 3.0 * (np.arange(60) >= 25)
    found = response_changes([each], 0.01)[0]
    assert found is not None
    t = abs(stats.ttest_ind(each[: found.at], each[found.at :]).statistic)
    assert 0.9 * t < found.score * critical(0.01 / 58.0, 58.0) <= t * (1.0 + 1e-9)


@given(
    st.lists(
        st.sampled_from([0.0, -0.0, 1.5, -2.0, 1e-310, -7e300, np.nan, np.inf, -np.inf]) | st.floats(), max_size=40
    )
)
def test_the_scale_is_that_of_the_median_size(values: list[float]) -> None:
    x = np.array(values, dtype=np.float64)
    sizes = np.abs(x[np.isfinite(x)])
    with np.errstate(over="ignore"):
        expected = float(np.median(sizes)) / MAD if len(sizes) else 0.0
        assert _scale(x) == expected


@given(st.lists(st.floats(-1e3, 1e3) | st.just(np.nan), max_size=40), st.sampled_from([1, 2, 4, 8]))
def test_a_contrast_is_one_of_means_over_windows_with_half_of_their_readings(values: list[float], w: int) -> None:
    x = np.array(values, dtype=np.float64)
    found = contrast(x, w)
    for i in range(len(x)):
        windows = [x[i + k * w : i + (k + 1) * w] for k in (-2, -1, 0, 1)]
        expected = np.nan
        if i >= 2 * w and i + 2 * w <= len(x) and all(np.isfinite(one).sum() >= max(0.5 * w, 1.0) for one in windows):
            a, b, c, d = (float(np.nanmean(one)) for one in windows)
            expected = (c - b) - (d - a) / 3.0
        np.testing.assert_allclose(found[i], expected, atol=1e-9)


@given(seed=st.integers(0, 10_000), cycles=st.integers(1, 60), missing=st.floats(0.0, 0.7))
def test_the_amplitude_of_a_cycle_is_that_of_its_own_least_squares(seed: int, cycles: int, missing: float) -> None:
    rng = np.random.default_rng(seed)
    cycle = np.sort(rng.integers(0, cycles, 60))  # some may have no reading
    rest, drive = rng.normal(size=60), rng.normal(size=60)
    rest[rng.random(60) < missing] = np.nan
    found, first = cycle_amplitudes(rest, drive, cycle)
    good = np.isfinite(rest)
    power = np.array([np.sum(drive[good & (cycle == k)] ** 2) for k in range(cycle[-1] + 1)])
    there = np.flatnonzero(power > 0.5 * np.median(power))
    assert first.tolist() == [int(np.flatnonzero(cycle == k)[0]) for k in there]
    own = [good & (cycle == k) for k in there]
    expected = [float(rest[one] @ drive[one] / (drive[one] @ drive[one])) for one in own]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
