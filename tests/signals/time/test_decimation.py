"""Min/max per bin: every extreme survives, gaps stay gaps, jitter makes none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.recording import SECOND
from inertialcal.signals.time.samples import min_max

VALUES = hnp.arrays(
    np.float64,
    st.tuples(st.integers(1, 200), st.integers(1, 3)),
    elements=st.one_of(st.floats(-1e6, 1e6), st.just(np.nan), st.just(np.inf)),
)


@given(VALUES, st.integers(1, 60), st.lists(st.integers(0, 40), min_size=200, max_size=200))
def test_every_sample_lies_in_one_bin_and_every_extreme_survives(
    values: np.ndarray, bins: int, steps: list[int]
) -> None:
    time_ns = np.cumsum(steps)[: len(values)].astype(np.int64)
    found = min_max(values, time_ns, bins)
    assert len(found.time) == len(found.lo) == len(found.hi) <= bins
    assert np.all(np.diff(found.time) >= 0.0)
    seconds = (time_ns - time_ns[0]) / SECOND
    assert np.all((found.time >= 0.0) & (found.time <= seconds[-1]))
    for column in range(values.shape[1]):
        lo, hi, x = found.lo[:, column], found.hi[:, column], values[:, column]
        known = x[np.isfinite(x)]
        assert np.array_equal(np.isnan(lo), np.isnan(hi))
        assert np.all(lo[~np.isnan(lo)] <= hi[~np.isnan(hi)])
        assert set(lo[~np.isnan(lo)]) | set(hi[~np.isnan(hi)]) <= set(known)
        if len(known):
            assert np.nanmin(lo) == known.min()
            assert np.nanmax(hi) == known.max()
        else:
            assert np.isnan(lo).all()


@given(hnp.arrays(np.float64, st.integers(1, 50), elements=st.floats(-10, 10)), st.integers(1, 9))
def test_each_bin_holds_the_extremes_of_its_own_samples(values: np.ndarray, size: int) -> None:
    bins = -(-len(values) // size)
    time_ns = np.arange(len(values)) * SECOND
    found = min_max(values[:, None], time_ns, bins)
    size = -(-len(values) // bins)
    parts = [values[i : i + size] for i in range(0, len(values), size)]
    assert found.lo[:, 0].tolist() == [part.min() for part in parts]
    assert found.hi[:, 0].tolist() == [part.max() for part in parts]
    middles = [np.arange(i, min(i + size, len(values)))[[0, -1]].mean() for i in range(0, len(values), size)]
    assert found.time.tolist() == middles


def test_fewer_samples_than_bins_stand_alone_and_a_gap_stays_one() -> None:
    time_ns = np.array([0, 2, 4, 10, 12]) * SECOND  # two saves are missing
    found = min_max(np.arange(5.0)[:, None], time_ns)
    expected = [0.0, 1.0, 2.0, np.nan, np.nan, 3.0, 4.0]
    assert np.array_equal(found.lo[:, 0], expected, equal_nan=True)
    assert np.array_equal(found.hi[:, 0], expected, equal_nan=True)
    assert found.time.tolist() == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]


def test_a_gap_of_whole_bins_stays_one_after_decimation() -> None:
    time_ns = np.concatenate([np.arange(1000), np.arange(2000, 3000)]) * SECOND
    found = min_max(np.ones((2000, 1)), time_ns, 30)
    assert np.array_equal(np.isnan(found.lo[:, 0]), [False] * 10 + [True] * 10 + [False] * 10)


def test_jitter_and_a_slow_clock_make_no_gap() -> None:
    rng = np.random.default_rng(1)
    steps = np.rint(2.003 * SECOND + rng.uniform(-0.2, 0.2, 599) * SECOND).astype(np.int64)
    found = min_max(np.ones((600, 1)), np.concatenate([[0], np.cumsum(steps)]))
    assert len(found.time) == 600
    assert not np.isnan(found.lo).any()


def test_invalid_samples_are_a_gap_where_nothing_else_is_in_the_bin() -> None:
    values = np.array([1.0, np.nan, 3.0, np.nan, np.nan, 6.0])[:, None]
    found = min_max(values, np.arange(6) * SECOND, 3)
    assert np.array_equal(found.lo[:, 0], [1.0, 3.0, 6.0])
    whole = min_max(values, np.arange(6) * SECOND, 6)
    assert np.array_equal(whole.lo[:, 0], values[:, 0], equal_nan=True)


def test_what_cannot_be_drawn_is_refused() -> None:
    one = np.zeros((2, 1))
    with pytest.raises(PlanError, match="0 bins, need 1 or more"):
        min_max(one, np.arange(2), 0)
    with pytest.raises(DataError, match=r"shape \(2, 1\) and time of shape \(3,\)"):
        min_max(one, np.arange(3))
    with pytest.raises(DataError, match="no samples to draw"):
        min_max(np.zeros((0, 1)), np.arange(0))
    with pytest.raises(DataError, match="time goes back"):
        min_max(one, np.array([1, 0]))
