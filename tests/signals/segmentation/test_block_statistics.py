"""Block statistics: each sample once, exactly; gaps, types, blocks put together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.recording import SECOND
from inertialcal.signals.segmentation.block_statistics import block_statistics

ROUNDING = 1e-12


def test_each_block_has_the_moments_of_its_samples() -> None:
    x = np.random.default_rng(1).normal(1e4, 1.0, (1000, 3))
    blocks = block_statistics(x, 2.0, sample_interval=0.04)
    parts = x.reshape(20, 50, 3)
    assert blocks.mean == pytest.approx(parts.mean(axis=1), rel=ROUNDING)
    assert blocks.variance == pytest.approx(parts.var(axis=1, ddof=1), rel=1e-9)
    assert np.array_equal(blocks.lo, parts.min(axis=1))
    assert np.array_equal(blocks.hi, parts.max(axis=1))
    assert np.all(blocks.count == 50)
    assert np.all(np.diff(blocks.time_ns) == 2 * SECOND)


@given(st.integers(1, 400), st.floats(0.01, 3.0), st.integers(0, 2**31))
def test_every_sample_is_in_one_block(n: int, length: float, seed: int) -> None:
    time_ns = np.cumsum(np.random.default_rng(seed).integers(0, SECOND, n)).astype(np.int64)
    blocks = block_statistics(np.ones(n), length, time_ns)
    assert blocks.count.sum() == n
    assert np.array_equal(blocks.stop[:-1], blocks.first[1:])
    assert np.array_equal((time_ns[blocks.first] - time_ns[0]) // blocks.length_ns, blocks.at)
    assert np.all(np.diff(blocks.at) > 0)


@pytest.mark.parametrize("kind", [np.int16, np.int64, np.float32, np.float64])
def test_counts_and_single_precision_are_taken_as_they_are(kind: type) -> None:
    x: NDArray[Any] = np.random.default_rng(2).integers(-300, 300, 500).astype(kind)
    assert block_statistics(x, 1.0, sample_interval=0.1).mean[:, 0] == pytest.approx(x.reshape(50, 10).mean(axis=1))
    pair = block_statistics([x, x], 1.0, sample_interval=0.1)
    assert pair.mean.shape == (50, 2)


def test_what_is_not_finite_is_left_out_and_a_gap_costs_no_block() -> None:
    x, time_ns = np.ones(200), np.arange(200, dtype=np.int64) * SECOND
    x[5], x[6] = np.nan, np.inf
    time_ns[100:] += 10**6 * SECOND
    blocks = block_statistics(x, 10.0, time_ns)
    assert len(blocks) == 20
    assert blocks.count[0, 0] == 8
    assert blocks.mean[0, 0] == 1.0
    assert blocks.at[10] == 100_010
    assert blocks.full.all()


def test_what_cannot_be_cut_is_refused() -> None:
    with pytest.raises(DataError, match="time goes back"):
        block_statistics(np.ones(4), 1.0, np.array([0, 9, 1, 12], dtype=np.int64) * SECOND)
    with pytest.raises(DataError, match=r"4 samples, time of shape \(3,\)"):
        block_statistics(np.ones(4), 1.0, np.arange(3, dtype=np.int64))
    with pytest.raises(DataError, match=r"need \(n,\) or \(n, channels\) with samples"):
        block_statistics(np.ones((0, 3)), 1.0, sample_interval=1.0)
    with pytest.raises(DataError, match=r"a signal of shape \[\(4,\), \(3,\)\]"):
        block_statistics([np.ones(4), np.ones(3)], 1.0, sample_interval=1.0)
    with pytest.raises(PlanError, match=r"blocks of 0 s"):
        block_statistics(np.ones(4), 0.0, sample_interval=1.0)
    with pytest.raises(PlanError, match=r"no time and no sample interval"):
        block_statistics(np.ones(4), 1.0)
