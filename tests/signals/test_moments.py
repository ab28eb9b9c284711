"""Moments of a record in one pass: against numpy, however it is held."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.batches.summaries import Moments
from inertialcal.signals import _kernels
from inertialcal.signals.moments import SHORT, moments_of


def same(found: Moments, x: NDArray[Any]) -> None:
    good = x[np.isfinite(x)].astype(np.float64)
    assert (found.count, found.low, found.high) == (len(good), good.min(), good.max())
    assert found.mean == pytest.approx(good.mean(), rel=1e-13, abs=1e-13 * float(np.abs(good).max()))
    assert found.squares == pytest.approx(np.sum((good - good.mean()) ** 2), rel=1e-10)


@pytest.mark.parametrize("run", [_kernels.moments_of, _kernels.moments_of.py_func])  # type: ignore[attr-defined]
@pytest.mark.parametrize("n", [1, 2, 4095, 4096, 4097, 9001])
def test_chunks_of_finite_samples(run: Callable[[NDArray[Any]], tuple[Any, ...]], n: int) -> None:
    x = 1e3 + np.random.default_rng(1).normal(size=n)
    x[n // 3 : n // 2] = np.nan
    x[5_000:5_001] = np.inf
    same(Moments(*run(x)), x)
    assert run(np.full(n, np.nan)) == pytest.approx((0, np.nan, 0.0, np.nan, np.nan), nan_ok=True)


READ_ONLY = np.random.default_rng(2).normal(size=SHORT + 4097)
READ_ONLY.flags.writeable = False


@pytest.mark.parametrize(
    "x",
    [
        READ_ONLY,
        READ_ONLY.astype(np.float32),
        READ_ONLY[::-1],
        np.repeat(READ_ONLY, 2)[::2],
        np.rint(30.0 * READ_ONLY).astype(np.int16),
        np.full(SHORT + 1, 3.0),
        np.where(READ_ONLY > 2.0, np.nan, READ_ONLY),
        READ_ONLY[:SHORT],
        np.resize(READ_ONLY, 2**20 + 1),
    ],
    ids=["read only", "float32", "backwards", "every second", "whole", "constant", "missing", "short", "two shares"],
)
def test_however_it_is_held(x: NDArray[Any]) -> None:
    same(moments_of(x), x)


@settings(max_examples=50, deadline=None)
@given(first=st.lists(st.floats(-1e6, 1e6), max_size=9), rest=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=9))
def test_moments_are_joined(first: list[float], rest: list[float]) -> None:
    one, other = (Moments().with_more(np.array(part)) for part in (first, rest))
    every = np.array([*first, *rest])
    found = one.joined(other)
    assert (found.count, found.low, found.high) == (len(every), every.min(), every.max())
    assert found.mean == pytest.approx(every.mean(), abs=1e-9)
    assert found.squares == pytest.approx(np.sum((every - every.mean()) ** 2), rel=1e-9, abs=1e-3)
