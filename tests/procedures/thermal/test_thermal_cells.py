"""Compiled loops of a thermal test, of samples in bins of temperature and of designs: against numpy, both ways."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.signal import lfilter

from inertialcal.core.estimate import Array
from inertialcal.procedures.thermal.fit import _kernels_cells as kernels


class Plain:
    """The Python that the kernels are compiled from."""

    def __getattr__(self, name: str) -> Any:
        return getattr(kernels, name).py_func


@pytest.fixture(params=[kernels, Plain()], ids=["compiled", "plain"])
def run(request: pytest.FixtureRequest) -> Any:
    return request.param


@pytest.mark.parametrize("pieces", [1, 7])
def test_means_and_squares_are_those_of_numpy_bin_by_bin(run: Any, pieces: int) -> None:
    rng, bins, n = np.random.default_rng(1), 7, 500
    columns = rng.normal(size=(5, n)) + 100.0
    columns[0] = np.round(rng.uniform(-10.0, 60.0, n // 4)).repeat(4)
    columns[1] = np.arange(n)
    columns[0, 3] = columns[2, 5] = columns[4, 7] = np.nan  # the last is no reading: its sample counts
    path = rng.integers(-1, 2, n // 4).repeat(4).astype(np.int8)
    low, high = np.nanmin(columns[0]), np.nanmax(columns[0])
    left = np.zeros(3, dtype=np.int64)
    count, means, squares = np.zeros((2, bins)), np.zeros((2, 5, bins)), np.zeros((2, 7, bins))
    edges = np.array([low, (high - low) / bins])
    for start, stop in pairwise(np.linspace(0, n, pieces + 1).astype(int)):  # as a long record comes
        bounds = np.clip([[0, 200], [200, n]], start, stop) - start
        own = np.ascontiguousarray(columns[:, start:stop])
        run.add_cells(own, 2, path[start:stop], bounds, edges, 20.0, count, means, squares, left)
    valid = np.isfinite(columns[0]) & np.isfinite(columns[2]) & np.isfinite(columns[3])
    late = valid & ~(columns[1] < 20.0)
    used = late & (path != 0)
    assert left.tolist() == [np.sum(~valid), np.sum(valid & ~late), np.sum(late & ~used)]
    for ramp, (start, stop) in enumerate([(0, 200), (200, n)]):
        own = used & (np.arange(n) >= start) & (np.arange(n) < stop)
        at = np.minimum(((columns[0, own] - low) / ((high - low) / bins)).astype(int), bins - 1)
        size = np.bincount(at, minlength=bins)
        assert count[ramp].tolist() == size.tolist()
        expected = np.array([np.bincount(at, row[own], bins) for row in columns]) / np.maximum(size, 1)
        np.testing.assert_allclose(means[ramp], expected, rtol=1e-13)
        away = columns[:, own] - expected[:, at]
        products = [away[0] ** 2, away[1] ** 2, away[0] * away[1], away[2] ** 2, away[3] ** 2, away[0] * away[2],
                    away[0] * away[3]]  # fmt: skip
        wanted = np.array([np.bincount(at, one, bins) for one in products])
        np.testing.assert_allclose(squares[ramp], wanted, rtol=1e-10, atol=1e-10 * np.abs(wanted).max())


def test_a_time_that_is_not_known_counts_and_leaves_no_mean(run: Any) -> None:
    columns, left = np.array([[1.0, 2.0], [np.nan, np.nan], [5.0, 7.0]]), np.zeros(3, dtype=np.int64)
    count, means, squares = np.zeros((1, 1)), np.zeros((1, 3, 1)), np.zeros((1, 5, 1))
    run.add_cells(columns, 1, np.ones(2, dtype=np.int8), np.array([[0, 2]]), np.array([1.0, 2.0]), 9.0, count, means,
                  squares, left)  # fmt: skip
    assert count.tolist() == [[2.0]]
    np.testing.assert_array_equal(means[0, :, 0], [1.5, np.nan, 6.0])
    np.testing.assert_array_equal(squares[0, :, 0], [0.5, np.nan, np.nan, 2.0, 1.0])


def test_sums_of_cubics_are_those_of_numpy(run: Any) -> None:
    rng, n = np.random.default_rng(6), 90
    columns = rng.normal(size=(4, n)) + 20.0
    ends = np.array([columns[0].min(), columns[0].max()])
    middle, cubic = columns[2:].mean(axis=1), rng.normal(size=(2, 4))
    powers, along = np.empty(7), np.empty((2, 5))
    run.fill_cubic(columns, ends, middle, cubic, powers, along)
    x = 2.0 * (columns[0] - ends[0]) / (ends[1] - ends[0]) - 1.0
    rows = chebyshev.chebvander(x, 6).T
    np.testing.assert_allclose(powers, rows.sum(axis=1), rtol=1e-11, atol=1e-11)
    left = columns[2:] - middle[:, None] - cubic @ rows[:4]
    np.testing.assert_allclose(along[:, :4], left @ rows[:4].T, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(along[:, 4], np.sum(left**2, axis=1), rtol=1e-12)


@pytest.mark.parametrize(("order", "path_order"), [(0, -1), (1, 2), (5, 2), (2, 0)])
def test_designs_are_chebyshev_rows_mean_over_the_spread(run: Any, order: int, path_order: int) -> None:
    rng = np.random.default_rng(7)
    at, spread, root = (rng.uniform(0.1, 0.9, (2, 9)) for _ in range(3))
    path = rng.choice([-1.0, 1.0], (2, 9))
    out = np.empty((2, 9, order + path_order + 2))
    run.fill_designs(at, spread, path, root, order, path_order, out)

    def rows(degree: int) -> Array:
        bent = [chebyshev.chebval(at, chebyshev.chebder(one, 2)) for one in np.eye(degree + 1)]
        return np.asarray(chebyshev.chebvander(at, degree) + 0.5 * spread[..., None] * np.stack(bent, axis=-1))

    np.testing.assert_allclose(out[..., : order + 1], root[..., None] * rows(order), rtol=1e-12)
    if path_order >= 0:
        expected = (0.5 * path * root)[..., None] * rows(path_order)
        np.testing.assert_allclose(out[..., order + 1 :], expected, rtol=1e-12)


def test_what_is_still_ends_where_the_temperature_leaves_its_noise(run: Any) -> None:
    rng, n = np.random.default_rng(2), 3000
    T = 20.0 + rng.normal(0.0, 0.01, n) + np.maximum(np.arange(n) - 1000, 0) * 0.01
    columns = np.array([np.arange(n, dtype=float), T])
    columns[1, 7] = columns[0, 9] = np.nan
    known = np.empty(n, dtype=np.int64)
    count = run.count_still(*columns, 1.0, 3.0, known)
    at = np.flatnonzero(np.isfinite(columns).all(axis=0))
    near = np.flatnonzero(np.abs(T[at] - T[at[:2]].mean()) > 1.0)[0]
    half = T[at[: near // 2]]
    assert count == np.flatnonzero(np.abs(T[at[:near]] - half.mean()) <= 3.0 * half.std())[-1] + 1
    assert 995 < count < 1010
    assert known[:count].tolist() == at[:count].tolist()
    assert run.count_still(*columns[:, ::-1].copy(), 1.0, 3.0, known) == -1  # time goes back
    assert run.count_still(*np.full((2, 5), np.nan), 1.0, 3.0, known) == 0


def test_roots_are_those_of_numpy(run: Any) -> None:
    x = np.random.default_rng(3).normal(size=(4, 9, 5))
    squares = x.swapaxes(1, 2) @ x
    squares[2, 3, 3] = -1.0
    roots = np.empty(squares.shape)
    run.fill_roots(squares, roots)
    assert np.isinf(roots[2]).all()
    for k in (0, 1, 3):
        np.testing.assert_allclose(roots[k], np.linalg.inv(np.linalg.cholesky(squares[k])), rtol=1e-12, atol=1e-14)


def test_errors_of_what_is_held_out_are_those_of_fits_to_the_rest(run: Any) -> None:
    rng, p, k, held = np.random.default_rng(8), 5, 2, np.array([1, 2])
    columns, weight = rng.normal(size=(2, 40, p + k)), rng.uniform(0.5, 1.0, (2, 40))
    number = rng.integers(0, 4, (2, 40))
    columns[1, number[1] != 2, 3] = 0.0  # one group alone tells of it
    moments, errors, told = np.zeros((2, 4, 7, 7)), np.full((2, 2, 3, k), np.nan), np.empty((2, 2))
    run.fill_errors(columns, weight, number, held, moments, errors, told)
    assert np.isinf(told).tolist() == [[False, False], [False, True]]
    assert np.isnan(errors[1, 1]).all()
    for u, h in ((0, 0), (0, 1), (1, 0)):
        own = number[u] == held[h]
        root = np.sqrt(weight[u])[:, None]
        X, y = columns[u, :, :p], columns[u, :, p:]
        for order in range(3):
            q = p - 2 + order
            found = np.linalg.lstsq((root * X)[~own, :q], (root * y)[~own])[0]
            expected = np.sum((root * (y - X[:, :q] @ found))[own] ** 2, axis=0)
            np.testing.assert_allclose(errors[u, h, order], expected, rtol=1e-9)
    white = columns[0] * np.sqrt(weight[0])[:, None]
    np.testing.assert_allclose(moments[0, 1], white[number[0] == 1].T @ white[number[0] == 1], atol=1e-12)


def test_bases_are_orthonormal_and_made_of_the_columns(run: Any) -> None:
    x = np.random.default_rng(4).normal(size=(3, 20, 6)) * 10.0 ** np.arange(6)
    x[1, :, 3] = x[1, :, 2] * (1.0 + 1e-9 * x[0, :, 0])
    basis, transform, length = x.copy(), np.empty((3, 6, 6)), np.empty((3, 6))
    least = run.fill_bases(basis, transform, length)
    assert 1e-10 < least < 1e-8  # of what the second leaves of a column that is nearly another one
    np.testing.assert_allclose(length, np.sqrt(np.sum(x**2, axis=1)))
    for k in range(3):
        np.testing.assert_allclose(basis[k].T @ basis[k], np.eye(6), atol=1e-14)
    for k in (0, 2):
        np.testing.assert_allclose(x[k] @ transform[k], basis[k], atol=1e-13)
    x[2, :, 1] = 0.0
    assert run.fill_bases(x.copy(), transform, length) == 0.0


def test_an_element_behind_is_a_filter_of_first_order(run: Any) -> None:
    of, behind = np.random.default_rng(8).normal(size=300).cumsum(), np.empty(300)
    newer, older, left = 0.02, 0.03, 0.95
    run.fill_behind(newer, older, left, of, behind)
    np.testing.assert_array_equal(behind, lfilter([newer, older], [1.0, -left], of))
