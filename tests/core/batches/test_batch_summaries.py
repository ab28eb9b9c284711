"""Number, scatter, extremes and median of long arrays: those of numpy, whatever the size of a batch."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from inertialcal.core import batches as b
from inertialcal.core.batches import summaries
from inertialcal.core.batches.summaries import median, medians, moments, quantile
from inertialcal.core.estimate import Array

ROUNDING = 1e-12
NUMBERS = arrays.arrays(
    np.float64,
    st.integers(0, 60),
    elements=st.one_of(
        st.sampled_from([0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 5e-324, -1.7e308]), st.floats(-10.0, 10.0)
    ),
)


@given(x=NUMBERS, size=st.integers(1, 70), held=st.integers(1, 20), digit=st.integers(1, 16))
def test_the_median_is_that_of_all_numbers(x: Array, size: int, held: int, digit: int) -> None:
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setattr(b, "SIZE", size)
        patch.setattr(summaries, "AT_ONCE", held)
        patch.setattr(summaries, "DIGIT", digit)
        there = x[~np.isnan(x)]
        true = float(np.median(there)) if len(there) else np.nan
        np.testing.assert_equal(median(x), true)


@given(level=st.floats(-1e9, 1e9), n=st.integers(1, 200), size=st.integers(1, 220), seed=st.integers(0, 999))
def test_moments_are_those_of_all_finite_numbers(level: float, n: int, size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.asarray(level + rng.normal(size=n))
    x[rng.random(n) < 0.2] = np.nan
    x[rng.random(n) < 0.1] = -np.inf
    fine = x[np.isfinite(x)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(b, "SIZE", size)
        found = moments(x)
    assert found.count == len(fine)
    if not len(fine):
        assert np.isnan(found.mean)
        return
    assert (found.low, found.high) == (fine.min(), fine.max())
    assert found.mean == pytest.approx(fine.mean(), rel=ROUNDING, abs=ROUNDING)
    if len(fine) == 1:
        assert found.std is None
    else:
        rounding = ROUNDING + 1e-15 * abs(level)  # of the numbers themselves
        assert found.std == pytest.approx(fine.std(ddof=1), rel=rounding, abs=rounding)


def test_integers_and_the_largest_numbers() -> None:
    assert moments(np.array([1, 2, 4], dtype=np.int16)).mean == pytest.approx(7 / 3)
    assert not np.isfinite(moments(np.array([1.7e308, 1.7e308])).std or 0.0)


@given(rows=st.integers(1, 3), values=st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=40))
@settings(max_examples=60, deadline=None)
def test_medians_are_those_of_each_row(rows: int, values: list[float]) -> None:
    x = np.stack([np.roll(values, k) + k for k in range(rows)])
    np.testing.assert_array_equal(medians(x), np.median(x, axis=1))


@pytest.mark.parametrize("kind", ["smooth", "few", "sorted", "periodic"])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.999, 1.0])
def test_quantile_of_many_numbers_is_that_of_all(kind: str, share: float) -> None:
    n = 2**17 + 5
    x = np.random.default_rng(1).normal(size=n)
    if kind == "few":
        x = np.round(x)
    if kind == "sorted":
        x.sort()
    if kind == "periodic":  # every 32nd tells nothing of the others
        x[::32] = 100.0
    ordered = np.sort(x)
    rank = int(share * (n - 1))
    after = ordered[min(rank + 1, n - 1)]
    assert quantile(x, share) == ordered[rank] + (share * (n - 1) - rank) * (after - ordered[rank])
