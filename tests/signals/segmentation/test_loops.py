"""Loops of the detector in numpy against the compiled ones: equal to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.signals.segmentation import _kernels_levels as kernels
from inertialcal.signals.segmentation import loops


@pytest.fixture(params=[300, 5_000], name="signal")
def _signal(request: pytest.FixtureRequest) -> np.ndarray:
    rng = np.random.default_rng(1)
    signal = rng.normal(size=request.param) + np.repeat(10.0 * rng.normal(size=request.param // 50), 50)
    signal[::3] = np.round(signal[::3], 1)
    return np.asarray(signal)


@pytest.mark.parametrize("w", [1, 4, 32])
def test_changes_of_level(signal: np.ndarray, w: int) -> None:
    running = np.concatenate(([0.0], np.cumsum(signal)))
    jumps = [np.empty(len(running) - 2 * w) for _ in range(2)]
    for module, jump in zip((kernels, loops), jumps, strict=True):
        module.fill_jump(running, w, jump)
    np.testing.assert_array_equal(jumps[0], jumps[1])
    over = [np.zeros(len(jumps[0]), dtype=bool) for _ in range(2)]
    for module, flags in zip((kernels, loops), over, strict=True):
        module.mark_above(jumps[0], 0.4, flags)
    np.testing.assert_array_equal(over[0], over[1])
    at = np.flatnonzero(over[0])
    score = np.round(jumps[0][at], 1)  # neighbours that score alike
    room = [np.empty(len(at), dtype=np.int64) for _ in range(2)]
    counts = [module.fill_peaks(at, score, one) for module, one in zip((kernels, loops), room, strict=True)]
    assert counts[0] == counts[1]
    peaks = room[0][: counts[0]]
    np.testing.assert_array_equal(peaks, room[1][: counts[1]])
    kept = [np.zeros(len(peaks), dtype=bool) for _ in range(2)]
    for module, flags in zip((kernels, loops), kept, strict=True):
        module.drop_lower(at[peaks], np.argsort(score[peaks]), w, flags)
    np.testing.assert_array_equal(kept[0], kept[1])
    cuts = np.unique(np.concatenate(([0, len(signal)], np.random.default_rng(2).integers(1, len(signal), 9))))
    clear = [np.zeros(len(at), dtype=bool) for _ in range(2)]
    for module, flags in zip((kernels, loops), clear, strict=True):
        module.fill_clear(at, w, cuts, flags)
    np.testing.assert_array_equal(clear[0], clear[1])


def test_variances_and_moments(signal: np.ndarray) -> None:
    n, w, size = len(signal), 12, 8
    cuts = np.array([0, 17, n // 2, n])
    variance = [np.empty(n - w + 1) for _ in range(2)]
    blocks = [(np.empty(n // size), np.empty(n // size, dtype=np.int64)) for _ in range(2)]
    holed = np.where(np.arange(n) % 7 == 0, np.nan, signal)
    holed[17:20] = np.nan
    edges = np.array([0, 17, 19, 20, 22, n // 2, n])
    moments = [[*(np.empty(6) for _ in range(4)), np.empty(6, dtype=np.int64)] for _ in range(2)]
    steps = []
    for i, module in enumerate((kernels, loops)):
        module.fill_window_variance(signal, cuts, w, np.empty(n), variance[i])
        steps.append(module.fill_blocks(signal, size, *blocks[i]))
        module.fill_moments(holed, edges[:-1], edges[1:], *moments[i])
    np.testing.assert_array_equal(variance[0], variance[1])
    assert steps[0] == steps[1] > 0.0
    for one, other in zip((*blocks[0], *moments[0]), (*blocks[1], *moments[1]), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_signal_without_steps() -> None:
    room = np.empty(2), np.empty(2, dtype=np.int64)
    assert loops.fill_blocks(np.full(16, 3.0), 8, *room) == kernels.fill_blocks(np.full(16, 3.0), 8, *room) == 0.0
