"""Fits against NIST's certified values, the GUM's thermometer, closed forms and refits."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics.least_squares import Fit, decompose, fit, fit_correlated, fit_each, symmetric_inverse

STRD = Path(__file__).parent / "strd"

# As NIST prints them: powers of x (none: columns as given, with a constant), certified estimates, their standard
# deviations, residual standard deviation; and digits that must agree at least.
CERTIFIED = json.loads((STRD / "certified.json").read_text(encoding="utf-8"))

# JCGM 100:2008, Table H.6: thermometer reading [degC] and observed correction [degC]
THERMOMETER = np.array(
    [
        (21.521, -0.171), (22.012, -0.169), (22.512, -0.166), (23.003, -0.159), (23.507, -0.164),
        (23.999, -0.165), (24.513, -0.156), (25.002, -0.157), (25.503, -0.159), (26.010, -0.161),
        (26.511, -0.160),
    ]
)  # fmt: skip


def line(x: Array) -> Array:
    return np.column_stack([np.ones_like(x), x])


def scattered(seed: int = 1, n: int = 12) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    x = rng.uniform(-2.0, 3.0, n)
    return np.column_stack([np.ones(n), x, x**2]), 1.0 + 2.0 * x + rng.normal(0.0, 0.3, n)


def digits(found: Array, certified: list[float]) -> float:
    """Significant digits that agree, in the worst of the figures; a certified zero counts digits after the point."""
    size = np.where(np.array(certified) == 0.0, 1.0, np.abs(certified))
    return float(-np.log10(np.max(np.abs(found - certified) / size) + 1e-16))


def problem(name: str, powers: Sequence[int] | None) -> tuple[Array, Array]:
    """Design and observations of a data set of NIST."""
    columns = np.loadtxt(STRD / f"{name}.txt")
    y, x = columns[:, 0], columns[:, 1:]
    return np.column_stack([np.ones(len(y)), x]) if powers is None else x ** np.array(powers), y


@pytest.mark.parametrize("certified", CERTIFIED, ids=lambda one: one["dataset"])
def test_certified_values_of_nist(certified: dict[str, Any]) -> None:
    design, y = problem(certified["dataset"], certified["powers"])
    found, estimates, at_least = fit(design, y), certified["estimates"], certified["digits"]
    wide = np.finfo(np.longdouble).eps < np.finfo(float).eps
    need = at_least if wide else at_least - 4  # a machine without extended precision refines in double
    assert digits(found.coefficients, estimates) >= need
    assert digits(found.u, certified["standard_deviations"]) >= min(need, 12)
    assert digits(np.array([found.scatter]), [certified["residual"]]) >= min(need, 12)
    assert found.dof == len(y) - len(estimates)


def test_thermometer_of_the_gum() -> None:
    """JCGM 100, H.3.3 and H.3.4: coefficients at 20 degC and the correction at 30 degC."""
    t, b = THERMOMETER.T
    found = fit(line(t - 20.0), b)
    assert found.coefficients == pytest.approx([-0.1712, 0.00218], abs=6e-6 + 5e-5)
    assert found.coefficients[1] == pytest.approx(0.00218, abs=5e-6)
    assert found.u[0] == pytest.approx(0.0029, abs=5e-5)
    assert found.u[1] == pytest.approx(0.00067, abs=5e-6)
    assert found.need_covariance()[0, 1] / found.u.prod() == pytest.approx(-0.930, abs=5e-4)
    assert found.scatter == pytest.approx(0.0035, abs=5e-5)
    at_30 = np.array([1.0, 10.0])
    assert at_30 @ found.coefficients == pytest.approx(-0.1494, abs=5e-5)
    assert math.sqrt(at_30 @ found.need_covariance() @ at_30) == pytest.approx(0.0041, abs=5e-5)
    assert found.dof == 9.0


def test_mean_as_a_fit() -> None:
    y = np.array([1.0, 2.0, 4.0, 9.0])
    found = fit(np.ones((4, 1)), y)
    assert found.coefficients[0] == pytest.approx(4.0)
    assert found.u[0] == pytest.approx(y.std(ddof=1) / 2.0, rel=1e-12)
    assert found.leverage == pytest.approx(np.full(4, 0.25), rel=1e-12)


def test_weights_stand_for_repeated_readings() -> None:
    X, y = scattered()
    times = np.array([1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3])
    weighted = fit(X, y, weights=times.astype(float))
    repeated = fit(np.repeat(X, times, axis=0), np.repeat(y, times))
    assert weighted.coefficients == pytest.approx(repeated.coefficients, rel=1e-10)
    assert weighted.dof == 9.0
    # the covariance differs by the number of readings alone
    ratio = repeated.dof / weighted.dof
    assert weighted.covariance == pytest.approx(ratio * repeated.need_covariance(), rel=1e-9)


def test_only_the_ratio_of_weights_counts() -> None:
    X, y = scattered()
    w = np.linspace(0.5, 3.0, 12)
    one, other = fit(X, y, weights=w), fit(X, y, weights=1e6 * w)
    assert other.coefficients == pytest.approx(one.coefficients, rel=1e-10)
    assert other.covariance == pytest.approx(one.covariance, rel=1e-9)


@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9), st.floats(-1e3, 1e3))
def test_fit_follows_the_units_of_columns(first: float, second: float, shift: float) -> None:
    X, y = scattered()
    one = fit(X, y)
    scale = np.array([1.0, first, second])
    other = fit(X / scale, y + shift)
    assert other.coefficients == pytest.approx(one.coefficients * scale + [shift, 0.0, 0.0], rel=1e-7, abs=1e-9)
    assert other.u == pytest.approx(one.u * scale, rel=1e-7)


@pytest.mark.parametrize("method", ["plain", "weighted", "correlated"])
def test_leverage_is_the_change_of_the_fitted_value_with_its_reading(method: str) -> None:
    X, y = scattered()
    w = np.linspace(0.5, 3.0, 12)
    V = np.exp(-np.abs(np.subtract.outer(np.arange(12.0), np.arange(12.0))) / 2.0)

    def fitted(readings: Array) -> Fit:
        if method == "correlated":
            return fit_correlated(X, readings, V)
        return fit(X, readings, weights=w if method == "weighted" else None)

    base = fitted(y)
    for i in range(12):
        moved = y.copy()
        moved[i] += 1.0
        change = X[i] @ (fitted(moved).coefficients - base.coefficients)
        assert base.leverage[i] == pytest.approx(change, rel=1e-9)
    assert base.leverage.sum() == pytest.approx(3.0, rel=1e-9)


def test_residuals_carry_nothing_that_the_columns_could() -> None:
    X, y = scattered()
    w = np.linspace(0.5, 3.0, 12)
    found = fit(X, y, weights=w)
    assert X.T @ (w * found.residuals) == pytest.approx(np.zeros(3), abs=1e-12)
    assert X @ found.coefficients + found.residuals == pytest.approx(y, rel=1e-12)


def test_as_many_coefficients_as_readings() -> None:
    found = fit(line(np.array([0.0, 2.0])), np.array([1.0, 5.0]))
    assert found.coefficients == pytest.approx([1.0, 2.0], rel=1e-12)
    assert found.dof == 0.0
    assert found.covariance is None
    assert found.mean_square is None
    with pytest.raises(DataError, match="2 readings for 2 coefficients leave no scatter"):
        _ = found.u
    with pytest.raises(DataError, match="leave no scatter"):
        _ = found.scatter


def test_known_covariance_of_independent_readings_is_weighting() -> None:
    X, y = scattered()
    sigma = np.linspace(0.1, 0.4, 12)
    found = fit_correlated(X, y, np.diag(sigma**2))
    weighted = fit(X, y, weights=sigma**-2)
    assert found.coefficients == pytest.approx(weighted.coefficients, rel=1e-10)
    assert found.covariance == pytest.approx(weighted.need_covariance() / weighted.scatter**2, rel=1e-9)
    assert found.mean_square == pytest.approx(weighted.mean_square, rel=1e-9)
    assert found.dof == math.inf


def test_common_error_of_all_readings_stays_whole_in_their_mean() -> None:
    """Variance s² of each and c² of all: the mean has s²/n + c², however many readings."""
    n, s2, c2 = 50, 0.04, 0.01
    found = fit_correlated(np.ones((n, 1)), np.arange(float(n)), s2 * np.eye(n) + c2)
    assert found.need_covariance()[0, 0] == pytest.approx(s2 / n + c2, rel=1e-10)
    assert found.coefficients[0] == pytest.approx((n - 1) / 2.0, rel=1e-12)


def test_correlated_fit_without_residual_degrees_of_freedom_keeps_its_covariance() -> None:
    found = fit_correlated(line(np.array([0.0, 1.0])), np.array([1.0, 2.0]), np.diag([0.01, 0.04]))
    assert found.mean_square is None
    assert found.u == pytest.approx([0.1, math.sqrt(0.05)], rel=1e-12)


def test_columns_that_the_data_cannot_tell_apart_are_named() -> None:
    x = np.array([1.0, 2.0, 3.0, 4.0])
    with pytest.raises(DataError) as caught:
        fit(np.column_stack([np.ones(4), x, 2.0 * x]), x, names=("bias", "scale_factor", "asymmetry"))
    problem = caught.value.problems[0]
    assert problem.code == "rank_deficient"
    assert "scale_factor -0.5 * asymmetry = 0" in problem.what
    assert "bias" not in problem.what


def test_two_vanishing_combinations_are_told_singly() -> None:
    x = np.array([1.0, 2.0, 3.0, 5.0])
    columns = np.column_stack([x, 3.0 * x, np.ones(4), np.full(4, -2.0)])
    with pytest.raises(DataError) as caught:
        fit(columns, x, names=("a", "b", "c", "d"))
    what = caught.value.problems[0].what
    assert "a -0.333333 * b = 0" in what
    assert "c +0.5 * d = 0" in what


def test_only_positive_rates_cannot_show_an_asymmetry() -> None:
    rate = np.array([1.0, 2.0, 5.0, 10.0])
    design = np.column_stack([np.ones(4), rate, np.abs(rate)])
    with pytest.raises(DataError, match="scale_factor -1 \\* asymmetry = 0"):
        fit(design, rate, names=("bias", "scale_factor", "asymmetry"))


def test_a_column_of_zeros_is_named() -> None:
    with pytest.raises(DataError, match="misalignment_xz = 0"):
        fit(np.column_stack([np.ones(3), np.zeros(3)]), np.arange(3.0), names=("bias", "misalignment_xz"))


def test_other_refusals_by_their_words() -> None:
    X, y = scattered(n=4)
    with pytest.raises(DataError, match=r"2 readings for 3 coefficients \(column 0, column 1, column 2\)"):
        fit(X[:2], y[:2])
    with pytest.raises(DataError, match="1 readings or rows of the design are not finite, the first is number 3"):
        fit(X, np.where(np.arange(4) == 2, math.nan, y))
    with pytest.raises(DataError, match=r"design of shape \(4, 3\) for readings of shape \(3,\)"):
        fit(X, y[:3])
    with pytest.raises(DataError, match="2 names for 3 columns"):
        fit(X, y, names=("a", "b"))
    with pytest.raises(DataError, match="weight 0 of reading 2"):
        fit(X, y, weights=np.array([1.0, 0.0, 1.0, 1.0]))
    with pytest.raises(DataError, match=r"weights of shape \(2,\) for 4 readings"):
        fit(X, y, weights=np.ones(2))
    with pytest.raises(DataError, match="covariance of the 4 readings is not positive definite"):
        fit_correlated(X, y, np.ones((4, 4)))
    with pytest.raises(DataError, match=r"covariance of shape \(3, 3\)"):
        fit_correlated(X, y, np.eye(3))


def test_inverse_of_symmetric_matrices_leaves_out_what_nothing_tells_of() -> None:
    Q = np.linalg.qr(np.random.default_rng(1).normal(size=(2, 4, 4)))[0]
    values = np.array([[3.0, 1.0, -0.5, 1e-13], [2.0, 1.0, 1e-3, 1e-11]])
    matrix = np.einsum("gik,gk,gjk->gij", Q, values, Q)
    kept = np.array([[1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 1.0]])
    expected = np.einsum("gik,gk,gjk->gij", Q, kept / values, Q)
    found = symmetric_inverse(matrix, 1e-12)
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(matrix[1] @ found[1], np.eye(4), atol=1e-4)
    assert np.array_equal(symmetric_inverse(matrix[0], 1e-12), found[0])


@pytest.mark.parametrize("apart", [1.0, 1e-3, 1e-9])
def test_a_design_with_one_column_more_is_that_design(apart: float) -> None:
    rng = np.random.default_rng(3)
    design, y = rng.normal(size=(40, 3)) * [1.0, 1e3, 1e-3], rng.normal(size=40)
    column = design @ [1.0, 1e-3, 1e3] + apart * rng.normal(size=40)
    designs = np.array([rng.normal(size=design.shape), design])
    both = decompose(designs, "abc").with_columns(np.array([1, 0, 1]), np.array([column, y, y]))
    more = fit_each(both, np.array([1, 0]), np.array([column, y]), "abcd")[1]
    whole = fit(np.column_stack([design, column]), y)
    assert more.coefficients == pytest.approx(whole.coefficients, rel=1e-6)
    assert more.residuals == pytest.approx(whole.residuals, abs=1e-9)
    assert more.transform @ more.transform.T == pytest.approx(whole.transform @ whole.transform.T, rel=1e-5)
    assert more.basis @ more.basis.T == pytest.approx(whole.basis @ whole.basis.T, abs=1e-6)


def test_a_column_that_the_others_give_is_refused_as_in_one_fit() -> None:
    design = np.random.default_rng(4).normal(size=(9, 2))
    with pytest.raises(DataError, match="cannot tell"):
        decompose(design[None], "ab").with_columns(np.array([0]), design[None] @ [1.0, -2.0])
