"""Compiled sums of samples in bins of temperature: against numpy, with and without the compiler."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inertialcal.procedures.thermal.fit import _kernels_cells as kernels


class Plain:
    """The Python that the kernels are compiled from."""

    def __getattr__(self, name: str) -> Any:
        return getattr(kernels, name).py_func


@pytest.fixture(params=[kernels, Plain()], ids=["compiled", "plain"])
def run(request: pytest.FixtureRequest) -> Any:
    return request.param


def test_sums_and_squares_are_those_of_numpy_bin_by_bin(run: Any) -> None:
    rng, bins, n = np.random.default_rng(1), 7, 500
    columns = rng.normal(size=(4, n))
    columns[0] = rng.uniform(-10.0, 60.0, n)
    columns[1] = np.arange(n)
    columns[0, 3] = columns[2, 5] = np.nan
    columns[1, 9] = np.nan  # no time is known: it counts
    path = rng.integers(-1, 2, n).astype(np.int8)
    low, high = np.nanmin(columns[0]), np.nanmax(columns[0])
    found, left = np.empty(n, dtype=np.int64), np.zeros(3, dtype=np.int64)
    run.find_bins(columns, 2, path, np.array([low, (high - low) / bins]), 20.0, found, left)
    valid = np.isfinite(columns[0]) & np.isfinite(columns[2]) & np.isfinite(columns[3])
    late = valid & ~(columns[1] < 20.0)
    used = late & (path != 0)
    assert left.tolist() == [np.sum(~valid), np.sum(valid & ~late), np.sum(late & ~used)]
    at = np.minimum(((columns[0, used] - low) / ((high - low) / bins)).astype(int), bins - 1)
    assert np.minimum(found[used], bins - 1).tolist() == at.tolist()
    assert set(found[~used].tolist()) == {-1}

    count, sums, squares = np.zeros((2, bins)), np.zeros((2, 4, bins)), np.zeros((2, 7, bins))
    bounds = np.array([[0, 200], [200, n]])
    run.add_sums(columns, bounds, found, count, sums)
    means = sums / count[:, None]
    run.add_squares(columns, 2, bounds, found, means, squares)
    for ramp, (start, stop) in enumerate(bounds):
        own = used & (np.arange(n) >= start) & (np.arange(n) < stop)
        at = np.minimum(((columns[0, own] - low) / ((high - low) / bins)).astype(int), bins - 1)
        assert count[ramp].tolist() == np.bincount(at, minlength=bins).tolist()
        np.testing.assert_array_equal(sums[ramp], [np.bincount(at, row[own], bins) for row in columns])
        away = columns[:, own] - means[ramp][:, at]
        products = [away[0] ** 2, away[1] ** 2, away[0] * away[1], away[2] ** 2, away[3] ** 2, away[0] * away[2],
                    away[0] * away[3]]  # fmt: skip
        np.testing.assert_array_equal(squares[ramp], [np.bincount(at, one, bins) for one in products])


def test_what_is_still_ends_where_the_temperature_leaves_its_noise(run: Any) -> None:
    rng, n = np.random.default_rng(2), 3000
    T = 20.0 + rng.normal(0.0, 0.01, n) + np.maximum(np.arange(n) - 1000, 0) * 0.01
    columns = np.array([np.arange(n, dtype=float), T])
    columns[1, 7] = columns[0, 9] = np.nan
    known = np.empty(n, dtype=np.int64)
    count = run.count_still(columns, 1.0, 3.0, known)
    at = np.flatnonzero(np.isfinite(columns).all(axis=0))
    near = np.flatnonzero(np.abs(T[at] - T[at[:2]].mean()) > 1.0)[0]
    half = T[at[: near // 2]]
    assert count == np.flatnonzero(np.abs(T[at[:near]] - half.mean()) <= 3.0 * half.std())[-1] + 1
    assert 995 < count < 1010
    assert known[:count].tolist() == at[:count].tolist()
    assert run.count_still(columns[:, ::-1].copy(), 1.0, 3.0, known) == -1  # time goes back
    assert run.count_still(np.full((2, 5), np.nan), 1.0, 3.0, known) == 0


def test_roots_are_those_of_numpy(run: Any) -> None:
    x = np.random.default_rng(3).normal(size=(4, 9, 5))
    squares = x.swapaxes(1, 2) @ x
    squares[2, 3, 3] = -1.0
    roots = np.empty(squares.shape)
    run.fill_roots(squares, roots)
    assert np.isinf(roots[2]).all()
    for k in (0, 1, 3):
        np.testing.assert_allclose(roots[k], np.linalg.inv(np.linalg.cholesky(squares[k])), rtol=1e-12, atol=1e-14)


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
