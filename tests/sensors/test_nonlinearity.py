from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.sensors.nonlinearity import Curve, inverse, rising_branch, smallest_slope

COEFFICIENT = st.floats(-1.5, 1.5).map(lambda c: 0.0 if abs(c) < 1e-6 else c)


def curve(asymmetry: float = 0.0, second: float = 0.0, third: float = 0.0) -> Curve:
    return Curve(np.array([asymmetry]), np.array([second]), np.array([third]))


def test_reading_and_slope_by_hand() -> None:
    one = curve(0.2, 0.03, -0.004)
    u = np.array([[2.0], [-2.0]])
    np.testing.assert_allclose(one.reading(u), [[2 + 0.2 + 0.12 - 0.032], [-2 + 0.2 + 0.12 + 0.032]], rtol=1e-15)
    np.testing.assert_allclose(one.slope(u), [[1 + 0.1 + 0.12 - 0.048], [1 - 0.1 - 0.12 - 0.048]], rtol=1e-15)


@pytest.mark.parametrize(
    ("terms", "ends"),
    [
        ((0.0, 0.0, 0.0), (-np.inf, np.inf)),
        ((0.0, 0.1, 0.0), (-5.0, np.inf)),  # 1 + 0.2 u
        ((0.0, -0.1, 0.0), (-np.inf, 5.0)),
        ((0.0, 0.0, -1.0 / 12.0), (-2.0, 2.0)),  # 1 - u^2/4
        ((0.0, 0.0, 1.0), (-np.inf, np.inf)),
        ((0.4, 0.1, 0.0), (-4.0, np.inf)),  # left of zero 0.8 + 0.2 u
        ((-2.5, 0.0, 0.0), (-np.inf, 0.0)),  # right of zero the slope is -0.25
    ],
)
def test_branch_ends_where_the_slope_is_zero(terms: tuple[float, float, float], ends: tuple[float, float]) -> None:
    np.testing.assert_allclose(rising_branch(curve(*terms)), [ends], rtol=1e-14)


@settings(max_examples=200, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT, st.floats(0.01, 3.0))
def test_smallest_slope_is_that_of_a_fine_grid(asymmetry: float, second: float, third: float, end: float) -> None:
    one = curve(asymmetry, second, third)
    found = smallest_slope(one, np.array([[-end, 2.0 * end]]))[0]
    grid = np.concatenate([np.linspace(-end, -1e-12, 2001), np.linspace(1e-12, 2.0 * end, 2001)])[:, np.newaxis]
    on_grid = float(one.slope(grid).min())
    assert found <= on_grid + 1e-9
    assert found >= on_grid - 9.0 * abs(third) * (end / 1000.0) ** 2 - 1e-9


@settings(max_examples=200, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT, st.lists(st.floats(-0.95, 0.95), min_size=1, max_size=20))
def test_inverse_undoes_the_curve_on_its_branch(
    asymmetry: float, second: float, third: float, places: list[float]
) -> None:
    one = curve(asymmetry, second, third)
    lo, hi = np.clip(rising_branch(one)[0], -5.0, 5.0)
    u = np.array([[p * hi if p > 0 else -p * lo] for p in places])
    slope = np.min(one.slope(u))
    np.testing.assert_allclose(inverse(one, one.reading(u)), u, atol=1e-14 * (1.0 + np.max(np.abs(u)) ** 3) / slope)


@settings(max_examples=100, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT, st.floats(-100.0, 100.0))
def test_inverse_is_on_the_branch_or_nowhere(asymmetry: float, second: float, third: float, reading: float) -> None:
    one = curve(asymmetry, second, third)
    u = inverse(one, np.array([[reading]]))[0, 0]
    lo, hi = rising_branch(one)[0]
    if np.isnan(u):
        end = hi if reading >= 0.0 else lo
        assert np.isfinite(end)
        assert abs(one.reading(np.array([[end]]))[0, 0]) <= abs(reading) * (1 + 1e-12)
    else:
        assert lo <= u <= hi
        assert one.reading(np.array([[u]]))[0, 0] == pytest.approx(reading, rel=1e-9, abs=1e-12)


def test_missing_reading_has_no_inverse() -> None:
    assert np.isnan(inverse(curve(0.1, 0.01), np.array([[np.nan]])))[0, 0]
