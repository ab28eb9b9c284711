"""Cluster-robust covariance: the exact balanced case, its definition written out, counted coverage."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics import _kernels_levels as kernels
from inertialcal.statistics.clustered import clustered_contrasts, clustered_covariance, members_of
from inertialcal.statistics.intervals import contains, covers, t_interval
from inertialcal.statistics.least_squares import fit, fit_correlated
from sized import sized

EXACT = 1e-9  # relative


def unequal(seed: int, clusters: int = 8) -> tuple[Array, Array, NDArray[np.intp]]:
    """Intercept 1 and slope 2 with random errors of both in each run; runs of 4 to 12 readings."""
    rng = np.random.default_rng(seed)
    sizes = np.linspace(4, 12, clusters).astype(int)
    g = np.repeat(np.arange(clusters), sizes)
    x = rng.uniform(-1.0, 1.0, g.size) + np.linspace(-0.5, 0.5, clusters)[g]
    y = 1.0 + rng.normal(0.0, 0.5, clusters)[g] + (2.0 + rng.normal(0.0, 0.5, clusters)[g]) * x
    return np.column_stack([np.ones(g.size), x]), y + rng.normal(0.0, 0.3, g.size), g


def written_out(X: Array, y: Array, g: NDArray[np.intp], w: Array) -> tuple[Array, Array]:
    """The definition with full matrices, and the trace formula from I - H itself."""
    root = np.sqrt(w)
    X, y = X * root[:, None], y * root
    M = np.linalg.inv(X.T @ X)
    R = np.eye(len(y)) - X @ M @ X.T
    middle, arms = np.zeros_like(M), []
    for label in np.unique(g):
        at = np.flatnonzero(g == label)
        values, vectors = np.linalg.eigh(R[np.ix_(at, at)])
        A = vectors @ np.diag(values**-0.5) @ vectors.T
        score = X[at].T @ A @ (R @ y)[at]
        middle += np.outer(score, score)
        arms.append(R[:, at] @ A @ X[at] @ M)
    dof = []
    for j in range(X.shape[1]):
        P = np.column_stack([arm[:, j] for arm in arms])
        inner = P.T @ P
        dof.append(np.trace(inner) ** 2 / np.sum(inner**2))
    return M @ middle @ M, np.array(dof)


@given(seed=st.integers(0, 10_000), runs=st.integers(2, 9), order=st.integers(0, 3))
def test_identical_designs_give_the_scatter_of_the_fits_of_each_run(seed: int, runs: int, order: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.array([-10.0, -4.0, -1.0, 0.0, 2.0, 7.0])
    design = np.vander(x, order + 1, increasing=True)
    y = rng.normal(size=(runs, x.size)) + rng.normal(size=(runs, 1)) * (1.0 + x)
    single = np.array([fit(design, readings).coefficients for readings in y])
    whole = fit(np.tile(design, (runs, 1)), y.ravel())
    covariance, dof = clustered_covariance(whole, np.repeat(np.arange(runs), x.size))
    between = np.atleast_2d(np.cov(single, rowvar=False)) / runs
    scale = np.sqrt(np.outer(np.diag(between), np.diag(between)))
    assert whole.coefficients == pytest.approx(single.mean(axis=0), rel=1e-7, abs=1e-9)
    assert covariance / scale == pytest.approx(between / scale, rel=1e-6, abs=1e-7)
    assert dof == pytest.approx(np.full(order + 1, runs - 1.0), rel=EXACT)


@pytest.mark.parametrize("weighted", [False, True])
def test_definition_written_out(weighted: bool) -> None:
    X, y, g = unequal(4)
    w = np.linspace(0.3, 2.0, y.size) if weighted else np.ones(y.size)
    covariance, dof = clustered_covariance(fit(X, y, weights=w if weighted else None), g)
    expected, expected_dof = written_out(X, y, g, w)
    assert covariance == pytest.approx(expected, rel=EXACT)
    assert dof == pytest.approx(expected_dof, rel=EXACT)


def test_two_groups_of_single_readings_are_those_of_welch_with_equal_variances() -> None:
    """Dof of a difference of means of n and m readings under equal variances, Satterthwaite's formula."""
    n, m = 3, 9
    X = np.column_stack([np.ones(n + m), np.arange(n + m) < n]).astype(float)
    y = np.random.default_rng(1).normal(size=n + m)
    covariance, dof = clustered_covariance(fit(X, y), np.arange(n + m))
    welch = (1 / n + 1 / m) ** 2 / (1 / (n**2 * (n - 1)) + 1 / (m**2 * (m - 1)))
    assert dof[1] == pytest.approx(welch, rel=EXACT)
    assert covariance[1, 1] == pytest.approx(y[:n].var(ddof=1) / n + y[n:].var(ddof=1) / m, rel=EXACT)


def test_each_reading_its_own_cluster_divides_by_what_it_leaves_free() -> None:
    X, y, _ = unequal(2)
    found = fit(X, y)
    M = np.linalg.inv(X.T @ X)
    meat = X.T @ np.diag(found.residuals**2 / (1.0 - found.leverage)) @ X
    assert clustered_covariance(found, np.arange(y.size))[0] == pytest.approx(M @ meat @ M, rel=EXACT)


def test_names_and_order_of_clusters_do_not_matter() -> None:
    X, y, g = unequal(3)
    covariance, dof = clustered_covariance(fit(X, y), g)
    shuffled = np.random.default_rng(1).permutation(y.size)
    words = np.array([f"run {9 - label}" for label in g])
    other, other_dof = clustered_covariance(fit(X[shuffled], y[shuffled]), words[shuffled])
    assert other == pytest.approx(covariance, rel=EXACT)
    assert other_dof == pytest.approx(dof, rel=EXACT)


def test_unit_of_a_column_changes_only_its_own_figures() -> None:
    X, y, g = unequal(3)
    covariance, dof = clustered_covariance(fit(X, y), g)
    scale = np.array([1.0, 1e-6])
    other, other_dof = clustered_covariance(fit(X / scale, y), g)
    assert other == pytest.approx(covariance * np.outer(scale, scale), rel=EXACT)
    assert other_dof == pytest.approx(dof, rel=EXACT)


def test_contrasts_are_the_coefficients_of_a_design_written_in_them() -> None:
    X, y, g = unequal(5)
    T = np.array([[1.0, 1.0], [1.0, -1.0]])  # fitted values at x = 1 and x = -1
    covariance, dof = clustered_contrasts(fit(X, y), g, T)
    other, other_dof = clustered_covariance(fit(X @ np.linalg.inv(T), y), g)
    assert covariance == pytest.approx(other, rel=EXACT)
    assert dof == pytest.approx(other_dof, rel=EXACT)


def test_covariance_is_unbiased_if_the_working_model_is_true() -> None:
    """Independent readings: the mean of CR2 is s² (X'X)^-1, also for few and unequal clusters."""
    X, _, g = unequal(1, clusters=4)
    rng = np.random.default_rng(2)
    n = 2000
    found = np.array([clustered_covariance(fit(X, rng.normal(size=g.size)), g)[0] for _ in range(n)])
    error = found.std(axis=0) / math.sqrt(n)
    assert np.all(np.abs(found.mean(axis=0) - np.linalg.inv(X.T @ X)) <= 4.0 * error)


def test_a_coefficient_that_one_run_decides_is_not_estimated() -> None:
    """Only run 0 turned the other way: no other run can confirm the asymmetry."""
    rate = np.concatenate([[-5.0, -2.0, 1.0, 3.0, 6.0], *[[1.0, 2.0, 4.0, 5.0, 7.0]] * 3])
    run = np.repeat(np.arange(4), 5)
    design = np.column_stack([np.ones(20), rate, np.where(rate < 0.0, rate, 0.0)])
    y = rate + np.random.default_rng(1).normal(size=20)
    covariance, dof = clustered_covariance(fit(design, y), run)
    assert dof[2] == 0.0
    assert np.all(dof[:2] >= 1.0)
    assert np.all(np.isfinite(covariance))
    with pytest.raises(DataError, match="0 degrees of freedom"):
        t_interval(1.0, math.sqrt(covariance[2, 2]), dof[2])


def test_an_own_constant_of_each_run_leaves_the_slope_estimated() -> None:
    X, y, g = unequal(6)
    design = np.column_stack([g[:, None] == np.arange(8), X[:, 1]]).astype(float)
    covariance, dof = clustered_covariance(fit(design, y), g)
    assert np.all(dof[:-1] == 0.0)
    assert 1.0 <= dof[-1] <= 7.0
    centred = X[:, 1] - (np.bincount(g, X[:, 1]) / np.bincount(g))[g]
    alone, alone_dof = clustered_covariance(fit(centred[:, None], y), g)
    assert covariance[-1, -1] == pytest.approx(alone[0, 0], rel=EXACT)
    assert dof[-1] == pytest.approx(alone_dof[0], rel=EXACT)


@pytest.mark.parametrize("n", [300, pytest.param(sized(3000, 1000), marks=pytest.mark.slow)])
def test_intervals_from_unequal_runs_keep_their_promise(n: int) -> None:
    hits = np.zeros(2, dtype=int)
    for seed in range(1, n + 1):
        X, y, g = unequal(seed)
        found = fit(X, y)
        covariance, dof = clustered_covariance(found, g)
        for j, truth in enumerate((1.0, 2.0)):
            interval = t_interval(found.coefficients[j], math.sqrt(covariance[j, j]), dof[j])
            hits[j] += contains(interval, truth)
    assert covers(int(hits[0]), n)
    assert covers(int(hits[1]), n)


def test_intervals_that_forget_the_runs_do_not() -> None:
    hits = 0
    for seed in range(1, 301):
        X, y, _ = unequal(seed)
        found = fit(X, y)
        interval = t_interval(found.coefficients[0], found.u[0], found.dof)
        hits += contains(interval, 1.0)
    assert not covers(hits, 300)


def test_refusals_by_their_words() -> None:
    X, y, g = unequal(1)
    with pytest.raises(DataError, match=r"1 cluster\(s\), need 2 or more"):
        clustered_covariance(fit(X, y), np.zeros(y.size))
    with pytest.raises(DataError, match=r"labels of shape \(3,\) for"):
        clustered_covariance(fit(X, y), g[:3])
    with pytest.raises(DataError, match="clusters of a fit with given covariance"):
        clustered_covariance(fit_correlated(X, y, np.eye(y.size)), g)


class Plain:
    """The Python that the kernels are compiled from."""

    def __getattr__(self, name: str) -> Any:
        return getattr(kernels, name).py_func


@pytest.fixture(params=[kernels, Plain()], ids=["compiled", "plain"])
def run(request: pytest.FixtureRequest) -> Any:
    return request.param


@pytest.mark.parametrize("count", [1, 5, 70])
def test_inverse_roots_are_those_of_the_eigenvalues(run: Any, count: int) -> None:
    rng, p = np.random.default_rng(count), 4
    Q = np.linalg.qr(rng.normal(size=(count, p, p)))[0]
    values = rng.uniform(0.02, 1.0, (count, p))
    values[0] = [1.0, 1.0, 1e-13, 0.5]  # one cluster alone decides a direction
    squares, found = np.einsum("gik,gk,gjk->gij", Q, values, Q), np.empty((count, p, p))
    run.fill_inverse_roots(squares, found)
    assert np.isnan(found[0]).all()
    np.testing.assert_allclose(found[1:], np.einsum("gik,gk,gjk->gij", Q, values**-0.5, Q)[1:], rtol=1e-9, atol=1e-9)
    alone = np.empty((1, p, p))
    run.fill_inverse_roots(squares[-1:], alone)
    np.testing.assert_array_equal(alone[0], found[-1])  # whatever stands beside it


def test_sums_of_clusters_are_those_of_numpy(run: Any) -> None:
    rng = np.random.default_rng(3)
    basis, left = rng.normal(size=(3, 9, 2)), rng.normal(size=(3, 9))
    labels = rng.permuted(np.tile([0, 0, 0, 1, 1, 2, 2, 2, 2], (3, 1)), axis=1)
    order, starts = (np.array(one) for one in zip(*map(members_of, labels), strict=True))
    gram, sums = np.zeros((2, 3, 2, 2)), np.zeros((3, 3, 2))
    run.fill_sums(basis, order, starts, left, np.array([2, 0]), gram, sums)
    for g in range(3):
        for s in range(3):
            own = labels[s] == g
            np.testing.assert_allclose(sums[s, g], basis[s][own].T @ left[s][own])
        for u, s in enumerate((2, 0)):
            own = basis[s][labels[s] == g]
            np.testing.assert_allclose(gram[u, g], own.T @ own)


def test_degrees_of_freedom_are_those_of_the_whole_matrix(run: Any) -> None:
    rng = np.random.default_rng(4)
    half = rng.normal(size=(2, 5, 3, 3))
    gram, adjust, along = half @ half.swapaxes(2, 3), rng.normal(size=(2, 5, 3, 3)), rng.normal(size=(2, 3, 4))
    found = np.zeros((2, 2, 4))
    run.fill_dof(gram, adjust, along, found)
    for s in range(2):
        for k in range(4):
            z = adjust[s] @ along[s, :, k]
            seen = np.einsum("gij,gj->gi", gram[s], z)
            B = np.diag(np.sum(z * seen, axis=1)) - seen @ seen.T
            np.testing.assert_allclose(found[s, :, k], [np.trace(B) ** 2 / np.sum(B**2), np.trace(B)], rtol=1e-9)


def test_fits_by_several_bases_are_those_of_numpy(run: Any) -> None:
    rng = np.random.default_rng(5)
    x, of = rng.normal(size=(2, 8, 3)), np.array([1, 0, 1])
    y, column = rng.normal(size=(2, 3, 8))
    basis, upper = np.linalg.qr(x)
    transform = np.linalg.inv(upper)
    coefficients, residuals = np.empty((3, 3)), np.empty((3, 8))
    run.fill_fits(basis, transform, of, y, coefficients, residuals)
    wide, turned = np.empty((3, 8, 4)), np.empty((3, 4, 4))
    assert 0.1 < run.fill_wider(basis, transform, of, column, wide, turned) < 1.0
    for s in range(3):
        np.testing.assert_allclose(coefficients[s], np.linalg.lstsq(x[of[s]], y[s])[0], rtol=1e-9)
        np.testing.assert_allclose(residuals[s], y[s] - x[of[s]] @ coefficients[s], atol=1e-12)
        np.testing.assert_allclose(np.column_stack([x[of[s]], column[s]]) @ turned[s], wide[s], atol=1e-12)
        np.testing.assert_allclose(wide[s].T @ wide[s], np.eye(4), atol=1e-12)
    assert run.fill_wider(basis, transform, of, np.zeros((3, 8)), wide, turned) == 0.0
