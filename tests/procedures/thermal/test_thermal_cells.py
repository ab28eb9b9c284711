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

    count, sums, squares = np.zeros(bins), np.zeros((4, bins)), np.zeros((7, bins))
    run.add_sums(columns, found, count, sums)
    assert count.tolist() == np.bincount(at, minlength=bins).tolist()
    expected = np.array([np.bincount(at, row[used], bins) for row in columns])
    np.testing.assert_array_equal(sums, expected)
    means = sums / count
    run.add_squares(columns, 2, found, means, squares)
    away = columns[:, used] - means[:, at]
    products = [away[0] ** 2, away[1] ** 2, away[0] * away[1], away[2] ** 2, away[3] ** 2, away[0] * away[2],
                away[0] * away[3]]  # fmt: skip
    np.testing.assert_array_equal(squares, [np.bincount(at, one, bins) for one in products])
