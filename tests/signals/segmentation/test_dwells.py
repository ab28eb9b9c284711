"""Dwells as readings: closed forms, accounting, worth of correlated samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal as scipy_signal

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.recording import SECOND
from inertialcal.signals.segmentation.dwells import dwell_of, effective_size, tally
from inertialcal.signals.time.samples import samples_of


def test_reading_of_a_dwell() -> None:
    x = np.array([[9.0], [1.0], [2.0], [3.0], [6.0], [9.0]])
    dwell = dwell_of(samples_of(x), 0, 6)
    assert dwell is not None
    assert (dwell.start, dwell.stop, dwell.n, dwell.edge_dropped) == (1, 5, 4, 2)
    assert dwell.mean.tolist() == [3.0]
    assert dwell.scatter == pytest.approx([np.sqrt(14.0 / 3.0)])
    assert dwell.u == pytest.approx(dwell.scatter / 2.0)  # too short to tell a correlation
    assert dwell.time_ns is None
    assert dwell.stuck.tolist() == [False]


def test_edges_are_the_first_and_last_good_samples() -> None:
    x = np.array([np.nan, 5.0, 1.0, np.nan, 2.0, 3.0, 7.0, np.nan])
    dwell = dwell_of(samples_of(x, np.arange(8) * SECOND), 0, 8)
    assert dwell is not None
    assert (dwell.start, dwell.stop, dwell.n, dwell.missing) == (2, 6, 3, 1)
    assert dwell.mean.tolist() == [2.0]
    assert dwell.time_ns == (2 * SECOND, 5 * SECOND)
    count = tally([dwell], 8)
    assert (count.used, count.edge_dropped, count.missing, count.outside) == (3, 2, 1, 2)


def test_too_few_samples_are_no_dwell() -> None:
    assert dwell_of(samples_of(np.arange(3.0)), 0, 3) is None
    assert dwell_of(samples_of(np.arange(3.0)), 0, 3, drop_edge=0) is not None
    with pytest.raises(PlanError, match="drop_edge -1, need 0 or more"):
        dwell_of(samples_of(np.arange(3.0)), 0, 3, drop_edge=-1)


def test_gaps_inside_are_counted() -> None:
    stamps = np.r_[0:5, 7:10, 11:40] * 2 * SECOND
    dwell = dwell_of(samples_of(np.arange(37.0), stamps), 0, 37)
    assert dwell is not None
    assert dwell.gaps == 2


def test_stuck_in_spite_of_rounding() -> None:
    dwell = dwell_of(samples_of(np.full((50, 1), 0.1)), 0, 50)
    assert dwell is not None
    assert dwell.stuck.tolist() == [True]
    assert dwell.n_effective.tolist() == [48.0]


def test_shapes() -> None:
    with pytest.raises(DataError, match=r"a signal of shape \(2, 0\), need \(n,\) or \(n, channels\)"):
        samples_of(np.zeros((2, 0)))
    assert samples_of(np.arange(3)).values.shape == (3, 1)


class TestEffectiveSize:
    def test_white_noise_is_worth_nearly_all(self) -> None:
        x = np.random.default_rng(1).normal(size=(100, 2000))
        worth = effective_size(x)
        assert np.all((worth >= 1.0) & (worth <= 100.0))
        # Half of the estimated correlations are below zero and count as none: the rest costs some 7 %.
        assert 88.0 < worth.mean() < 100.0

    @pytest.mark.parametrize("rho", [0.165, 0.5, 0.8])  # 0.165: Xsens, neighbours of a static interval
    @pytest.mark.parametrize(("n", "low", "high"), [(28, 1.05, 1.7), (400, 0.95, 1.1)])
    def test_variance_of_the_mean_of_correlated_noise(self, rho: float, n: int, low: float, high: float) -> None:
        rng = np.random.default_rng(2)
        innovations = rng.normal(size=(n + 200, 3000)) * np.sqrt(1.0 - rho**2)
        x = scipy_signal.lfilter([1.0], [1.0, -rho], innovations, axis=0)[200:]
        claimed = float(np.mean(x.var(axis=0, ddof=1) / effective_size(x)))
        # Short dwells claim too much rather than too little; s/sqrt(n) would claim 0.1 to 0.7 of the variance.
        assert low < claimed / float(x.mean(axis=0).var()) < high

    def test_neighbours_across_a_gap_do_not_count(self) -> None:
        # Pairs of equal samples, a gap after each pair: within a pair the correlation is full, across none.
        x = np.repeat(np.random.default_rng(3).normal(size=(200, 1)), 2, axis=0)
        within = np.resize([True, False], 399)
        assert effective_size(x, within)[0] < 20.0
        assert effective_size(x, ~within)[0] > 300.0
