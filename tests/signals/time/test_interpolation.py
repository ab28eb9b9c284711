"""Values at other stamps: straight lines between neighbours, nothing beyond and nothing over gaps."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.recording import SECOND
from inertialcal.signals.time.interpolation import interpolated

STAMPS = np.arange(0, 100) * (SECOND // 100)
READINGS = np.column_stack([np.arange(100.0), -2.0 * np.arange(100.0)])


@given(st.integers(1, 10_000), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_a_straight_line_stays_one(seed: int, slope: float, offset: float) -> None:
    rng = np.random.default_rng(seed)
    stamps = np.cumsum(rng.integers(9_000_000, 11_000_000, 50))
    onto = np.sort(rng.integers(stamps[0], stamps[-1] + 1, 30))
    values = np.asarray(slope * stamps / 1e8 + offset, dtype=np.float64)[:, None]
    found = interpolated(values, stamps, onto)
    np.testing.assert_allclose(found[:, 0], slope * onto / 1e8 + offset, atol=1e-12 * 50)


def test_own_stamps_give_the_samples_also_beside_one_that_is_missing() -> None:
    values = READINGS.copy()
    values[7] = np.nan
    np.testing.assert_array_equal(interpolated(values, STAMPS, STAMPS), values)


def test_nothing_is_extrapolated() -> None:
    found = interpolated(READINGS, STAMPS, np.array([STAMPS[0] - 1, STAMPS[0], STAMPS[-1], STAMPS[-1] + 1]))
    np.testing.assert_array_equal(np.isnan(found[:, 0]), [True, False, False, True])
    assert np.isnan(interpolated(READINGS[:1], STAMPS[:1], STAMPS)).all()


def test_a_gap_stays_one() -> None:
    kept = np.delete(np.arange(100), slice(40, 45))
    found = interpolated(READINGS[kept], STAMPS[kept], STAMPS + STAMPS[1] // 4)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found[:, 1])), [39, 40, 41, 42, 43, 44, 99])


def test_half_way_between_two_samples_the_noise_is_that_of_their_mean() -> None:
    rng = np.random.default_rng(1)
    stamps = np.arange(20_000) * 10_000_000
    found = interpolated(rng.standard_normal((20_000, 1)), stamps, stamps[:-1] + 5_000_000)
    np.testing.assert_allclose(found.var(), 0.5, rtol=0.05)
