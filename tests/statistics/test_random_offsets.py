"""Least squares with an offset in each group: against the explicit covariance, and where it changes nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics.clustered import clustered_covariance
from inertialcal.statistics.least_squares import fit, fit_correlated
from inertialcal.statistics.random_offsets import (
    TOLERANCE,
    Grouped,
    deviance_of,
    fit_with_offsets,
    group_moments,
    offset_ratio,
    restricted_deviance,
    whitened,
    whitening,
)

SMALL = 1e-9


def line(x: Array) -> Array:
    return np.column_stack([np.ones_like(x), x])


@given(ratio=st.floats(0.0, 1e3), seed=st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_whitening_is_that_of_the_explicit_covariance(ratio: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    numbers = np.repeat([0, 1, 2], [4, 6, 5])
    weights = rng.uniform(0.2, 3.0, numbers.size)
    x, y = rng.normal(size=numbers.size), rng.normal(size=numbers.size)
    covariance = np.diag(1.0 / weights) + ratio * (numbers[:, None] == numbers)
    white = whitened(np.column_stack([line(x), y]), weights, numbers, ratio)
    found = fit(white[:, :2], white[:, 2])
    expected = fit_correlated(line(x), y, covariance)
    assert found.coefficients == pytest.approx(expected.coefficients, abs=1e-8)
    solve = whitening(found.transform @ found.basis.T, weights, numbers, ratio)
    assert solve @ y == pytest.approx(found.coefficients, abs=1e-8)


@given(ratio=st.floats(1e-3, 1e3), seed=st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_the_likelihood_is_that_of_the_explicit_covariance(ratio: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    numbers = np.repeat([0, 1, 2], [4, 6, 5])
    weights, x, y = rng.uniform(0.2, 3.0, 15), rng.normal(size=15), rng.normal(size=15)
    X = line(x)

    def explicit(of: float) -> float:
        inverse = np.linalg.inv(np.diag(1.0 / weights) + of * (numbers[:, None] == numbers))
        left = y - X @ np.linalg.solve(X.T @ inverse @ X, X.T @ inverse @ y)
        square = np.log(left @ inverse @ left)
        return float(np.linalg.slogdet(X.T @ inverse @ X)[1] - np.linalg.slogdet(inverse)[1] + 13.0 * square)

    moments = group_moments(X, y, weights, numbers)
    change = restricted_deviance(moments, ratio) - restricted_deviance(moments, 1.0)
    assert change == pytest.approx(explicit(ratio) - explicit(1.0), rel=1e-8, abs=1e-8)


@given(power=st.floats(-4.0, 6.0), seed=st.integers(0, 10_000), groups=st.integers(2, 4), powers=st.integers(1, 4))
@settings(max_examples=60, deadline=None)
def test_the_likelihood_as_a_function_is_that_of_each_ratio(power: float, seed: int, groups: int, powers: int) -> None:
    rng = np.random.default_rng(seed)
    numbers = np.arange(12 * groups) % groups
    x, y = rng.normal(size=(2, numbers.size))
    weights = rng.uniform(0.2, 3.0, numbers.size)
    moments = group_moments(np.vander(np.tanh(x), powers), y, weights, numbers)
    assert deviance_of(moments)(10.0**power) == pytest.approx(restricted_deviance(moments, 10.0**power), rel=1e-7)


@pytest.mark.parametrize("design", [line(np.arange(6.0)), np.ones((6, 2))])
def test_the_likelihood_where_nothing_is_left_or_the_design_is_singular(design: Array) -> None:
    moments = group_moments(design, design @ np.array([2.0, 3.0]), np.ones(6), np.repeat([0, 1], 3))
    values = [restricted_deviance(moments, ratio) for ratio in (0.0, 0.1, 10.0)]
    # What is left is rounding
    assert [deviance_of(moments)(ratio) for ratio in (0.1, 10.0)] == pytest.approx(values[1:], rel=0.2)
    assert np.all(np.isfinite(values))
    assert (values[0] > 1e100) == (np.linalg.matrix_rank(design) < 2)


def test_with_equal_designs_the_ratio_changes_nothing_and_the_uncertainty_is_that_of_the_groups_own_fits() -> None:
    rng = np.random.default_rng(3)
    x = np.tile(np.linspace(-1.0, 1.0, 9), 5)
    groups = np.repeat(list("abcde"), 9)
    y = 2.0 + 3.0 * x + np.repeat(rng.normal(0.0, 4.0, 5), 9) + rng.normal(0.0, 0.1, x.size)
    found = fit_with_offsets(line(x), y, np.ones(x.size), groups)
    plain = fit(line(x), y)
    assert found.coefficients == pytest.approx(plain.coefficients, abs=SMALL)
    own = np.array([fit(line(x[:9]), part).coefficients for part in y.reshape(5, 9)])
    covariance, dof = clustered_covariance(found, groups)
    assert covariance == pytest.approx(np.cov(own.T) / 5.0, rel=1e-6)
    assert dof == pytest.approx([4.0, 4.0], rel=1e-6)


def test_groups_on_different_parts_of_the_range_do_not_bend_the_line_by_their_offsets() -> None:
    """Two groups, each on one half of the range, 10 apart: the slope is what each shows by itself."""
    rng = np.random.default_rng(5)
    x = np.linspace(-1.0, 1.0, 80)
    groups = np.where(x < 0.0, "low", "high")
    y = 0.5 * x + np.where(x < 0.0, 0.0, 10.0) + rng.normal(0.0, 0.01, x.size)
    plain = fit(line(x), y).coefficients[1]
    found = fit_with_offsets(line(x), y, np.ones(x.size), groups).coefficients[1]
    assert plain > 7.0
    assert found == pytest.approx(0.5, abs=0.05)


def test_without_offsets_it_is_plain_least_squares() -> None:
    rng = np.random.default_rng(8)
    x = rng.normal(size=60)
    y = 1.0 - x + rng.normal(0.0, 1.0, x.size)
    found = fit_with_offsets(line(x), y, np.ones(60), np.repeat([1, 2, 3], 20))
    assert found.coefficients == pytest.approx(fit(line(x), y).coefficients, abs=0.05)


def test_weights_must_be_positive() -> None:
    with pytest.raises(DataError, match="need one above zero for each"):
        fit_with_offsets(np.ones((3, 1)), np.ones(3), np.array([1.0, 0.0, 1.0]), np.array([1, 1, 2]))


@pytest.mark.parametrize("size", [0.5, 2.0, 20.0])
def test_the_ratio_of_a_balanced_design_is_that_of_the_analysis_of_variance(size: float) -> None:
    """One mean, g groups of n: restricted likelihood gives (MS between / MS within - 1) / n (Searle et al., 1992)."""
    groups, n = 3, 8
    rng = np.random.default_rng(5)
    y = rng.normal(size=(groups, n))
    y += size * np.array([[-1.0], [0.2], [0.8]])
    within = float(np.sum((y - y.mean(axis=1, keepdims=True)) ** 2)) / (groups * (n - 1))
    between = n * float(np.var(y.mean(axis=1), ddof=1))
    columns = np.column_stack([np.ones(y.size), y.ravel()])
    means = np.column_stack([np.ones(groups), y.mean(axis=1)])
    found = offset_ratio(Grouped(columns.T @ columns, means, np.full(groups, float(n)), y.size))
    assert np.log10(found * n / (between / within - 1.0)) == pytest.approx(0.0, abs=TOLERANCE)
