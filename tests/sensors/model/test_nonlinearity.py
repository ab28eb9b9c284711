from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.estimate import Array
from inertialcal.sensors.model.nonlinearity import (
    STEEP,
    Curve,
    approached,
    bracketed,
    endless_slope,
    inverse,
    rising_branch,
    smallest_slope,
)


def coefficient(most: float) -> st.SearchStrategy[float]:
    return st.floats(-most, most).map(lambda c: 0.0 if abs(c) < 1e-6 else c)


COEFFICIENT = coefficient(1.5)
WEAK = st.tuples(coefficient(0.1), coefficient(0.1), coefficient(0.02))
ROUNDING = 8.0 * np.finfo(float).eps  # of u, where the slope is 1


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


def safeguarded(one: Curve, readings: Array) -> Array:
    branch = rising_branch(one)
    return bracketed(one, branch, endless_slope(one, branch), readings)


def assert_both_ways_agree(one: Curve, readings: Array) -> Array:
    """Where the fast steps settle they give the root in the bracket, to rounding; return where they do."""
    fast = approached(one, rising_branch(one), readings)
    settled = ~np.isnan(fast)
    slow = safeguarded(one, readings)[settled]
    assert not np.isnan(slow).any()
    slope = np.abs(one.slope(slow[:, np.newaxis])[:, 0])
    assert np.all(slope >= 0.9 * STEEP)
    size = np.abs(slow) * (1.0 + slope)  # terms of g that cancel, over the slope
    size += np.abs(one.second * slow**2) + np.abs(one.third * slow**3)
    assert np.all(np.abs(fast[settled] - slow) <= ROUNDING * size / slope)
    return settled


@settings(max_examples=200, deadline=None)
@given(WEAK, st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=20))
def test_fast_steps_settle_on_the_safeguarded_root_all_over_a_usual_range(
    terms: tuple[float, float, float], places: list[float]
) -> None:
    one = curve(*terms)
    r = one.reading(np.array([[-1.0], [1.0], [0.0], [-0.0], *([place] for place in places)]))
    assert np.all(assert_both_ways_agree(one, r))


@pytest.mark.parametrize("terms", list(product((-0.1, 0.1), (-0.1, 0.1), (-0.02, 0.02))))
def test_fast_steps_give_the_truth_up_to_the_corners_of_a_usual_range(terms: tuple[float, float, float]) -> None:
    one = curve(*terms)
    u = np.linspace(-1.0, 1.0, 41)[:, np.newaxis]
    np.testing.assert_allclose(approached(one, rising_branch(one), one.reading(u)), u, rtol=1e-14, atol=1e-16)


@settings(max_examples=200, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT, st.lists(st.floats(-14.0, 3.0), min_size=1, max_size=20))
def test_fast_steps_near_the_turn_give_the_safeguarded_root_or_nothing(
    asymmetry: float, second: float, third: float, powers: list[float]
) -> None:
    one = curve(asymmetry, second, third)
    ends = rising_branch(one)
    turns = one.reading(np.where(np.isfinite(ends), ends, 3.0 * np.sign(ends)).T)[:, 0]
    beside = np.concatenate([[1.0], *([1.0 - 10.0**p, 1.0 + 10.0**p] for p in powers)])
    r = (turns * beside[:, np.newaxis]).reshape(-1, 1)
    assert_both_ways_agree(one, r)
    found = inverse(one, r)
    lost = np.isnan(found)
    np.testing.assert_array_equal(lost, np.isnan(safeguarded(one, r)))
    np.testing.assert_allclose(one.reading(found[~lost]), r[~lost], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_root_on_a_second_rising_branch_is_not_taken(side: float) -> None:
    """u - u^2 + 0.3 u^3 turns at 0.76, falls to 1.46 and rises again: 0.32 to 3 are read beyond the branch alone."""
    one = curve(0.0, -side, 0.3)
    r = side * np.linspace(0.32, 3.0, 2000)[:, np.newaxis]
    assert np.isnan(approached(one, rising_branch(one), r)).all()
    assert np.isnan(inverse(one, r)).all()


@settings(max_examples=100, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT)
def test_missing_and_infinite_readings_have_no_inverse_by_either_way(
    asymmetry: float, second: float, third: float
) -> None:
    one = curve(asymmetry, second, third or 0.1)
    r = np.array([[np.nan], [np.inf], [-np.inf]])
    for found in (approached(one, rising_branch(one), r), safeguarded(one, r), inverse(one, r)):
        assert np.isnan(found).all()


@settings(max_examples=200, deadline=None)
@given(COEFFICIENT, COEFFICIENT, COEFFICIENT, st.floats(allow_nan=False, allow_infinity=False))
def test_reading_of_any_size_has_its_own_inverse_or_none(
    asymmetry: float, second: float, third: float, reading: float
) -> None:
    one = curve(asymmetry, second, third or 0.1)
    u = inverse(one, np.array([[reading]]))
    assert np.isnan(u).all() or one.reading(u)[0, 0] == pytest.approx(reading, rel=1e-9, abs=1e-300)


def test_error_left_by_a_step_has_its_third_power() -> None:
    """Three steps with wider and wider starts: Halley's error constant is c^2/s^2 - K3/s, in exact fractions."""
    second, third, root = Fraction(1, 10), Fraction(-1, 50), Fraction(1, 2)
    reading = root + second * root**2 + third * root**3
    for start in (Fraction(1, 100), Fraction(1, 1000)):
        u = root + start
        excess = u + second * u**2 + third * u**3 - reading
        slope, curvature = 1 + 2 * second * u + 3 * third * u**2, second + 3 * third * u
        step = excess * slope / (slope**2 - excess * curvature)
        left = (curvature**2 - third * slope) * step**3 / slope**2
        assert float(u - step - root) == pytest.approx(float(left), rel=5.0 * float(start))
