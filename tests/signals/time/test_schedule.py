"""Dwells cut by what is known beforehand."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.recording import SECOND
from inertialcal.signals.segmentation.dwells import tally
from inertialcal.signals.time.schedule import dwells_by_reference, dwells_by_windows

APPLIED = np.concatenate([np.zeros(30), [0.002, 0.004], np.full(30, 0.006), [0.003], np.full(30, -0.006)])
READING = APPLIED + 0.004 * np.random.default_rng(1).normal(size=93)
STAMPS = np.arange(93) * 2 * SECOND


def test_steps_below_the_noise_are_cut_exactly() -> None:
    read = dwells_by_reference(APPLIED, READING, STAMPS)
    assert [(d.start, d.stop) for d in read] == [(1, 29), (33, 61), (64, 92)]
    assert [float(d.applied[0]) for d in read if d.applied is not None] == pytest.approx([0.0, 0.006, -0.006])
    for dwell in read:
        assert dwell.mean == pytest.approx([READING[dwell.start : dwell.stop].mean()])
        assert dwell.edge_dropped == 2
    assert tally(read, 93).outside == 3


def test_a_reference_with_noise_of_its_own() -> None:
    encoder = APPLIED + 1e-5 * np.random.default_rng(2).uniform(-1.0, 1.0, size=93)
    read = dwells_by_reference(encoder, READING, tolerance=3e-5)
    assert [(d.start, d.stop) for d in read] == [(1, 29), (33, 61), (64, 92)]
    with pytest.raises(DataError, match=r"never constant \(within 0\) for 6 samples"):
        dwells_by_reference(encoder, READING)


def test_a_slow_ramp_is_no_dwell() -> None:
    ramp = np.concatenate([np.zeros(300), np.arange(1, 50) * 0.001, np.full(20, 0.05)])
    read = dwells_by_reference(ramp, ramp, tolerance=0.001, min_samples=10)
    assert [(d.start, d.stop) for d in read] == [(1, 301), (348, 368)]
    # Two samples of the ramp lie within the tolerance of the first dwell, one of the second.
    assert len(dwells_by_reference(ramp, ramp, tolerance=0.001, min_samples=3, drop_edge=0)) == 2 + 46 // 3


def test_missing_reference_leaves_the_sample_out() -> None:
    applied = APPLIED.copy()
    applied[10:13] = np.nan
    read = dwells_by_reference(applied, READING, STAMPS)
    assert next((d.start, d.stop, d.missing, d.n) for d in read) == (1, 29, 3, 25)
    with pytest.raises(DataError, match="never constant"):
        dwells_by_reference(np.full(93, np.nan), READING)


def test_a_long_gap_ends_a_dwell() -> None:
    stamps = STAMPS.copy()
    stamps[15:] += 60 * SECOND
    assert [(d.start, d.stop) for d in dwells_by_reference(APPLIED, READING, stamps)][:2] == [(1, 14), (16, 29)]


def test_shortest_dwell() -> None:
    applied = np.r_[np.zeros(10), np.ones(30)]
    assert len(dwells_by_reference(applied, applied, min_samples=11)) == 1
    assert len(dwells_by_reference(applied, applied, sample_interval=2.0, min_duration=20.0)) == 2
    with pytest.raises(PlanError, match="a length of 20 s, but no sample interval"):
        dwells_by_reference(applied, applied, min_duration=20.0)
    with pytest.raises(DataError, match="40 samples, 39 of the reference"):
        dwells_by_reference(applied[1:], applied)


def test_windows() -> None:
    windows = [(64 * 2 * SECOND, 94 * 2 * SECOND), (0, 30 * 2 * SECOND)]
    late, early = dwells_by_windows(windows, READING, STAMPS)
    assert (late.start, late.stop, early.start, early.stop) == (65, 92, 1, 29)
    (whole,) = dwells_by_windows([(0, 60 * SECOND)], READING, STAMPS, drop_edge=0)
    assert (whole.start, whole.stop) == (0, 30)  # half-open: the stamp at 60 s is outside


def test_windows_that_cannot_be() -> None:
    with pytest.raises(PlanError, match="window 5 to 5 ns ends before it starts"):
        dwells_by_windows([(5, 5)], READING, STAMPS)
    with pytest.raises(PlanError, match="windows 0 to 10 and 9 to 20 ns overlap"):
        dwells_by_windows([(9, 20), (0, 10)], READING, STAMPS)
    with pytest.raises(DataError, match=r"holds 2 sample\(s\).*need 4 or more.*record runs from 0 to"):
        dwells_by_windows([(0, 4 * SECOND)], READING, STAMPS)
