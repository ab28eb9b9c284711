"""Loops of the detector in numpy against the compiled ones: equal to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.signals.segmentation import _kernels_levels as kernels
from inertialcal.signals.segmentation import loops
from inertialcal.signals.segmentation.change_points import Jumps


@pytest.fixture(params=[300, 5_000], name="signal")
def _signal(request: pytest.FixtureRequest) -> np.ndarray:
    rng = np.random.default_rng(1)
    signal = rng.normal(size=request.param) + np.repeat(10.0 * rng.normal(size=request.param // 50), 50)
    signal[::3] = np.round(signal[::3], 1)
    return np.asarray(signal)


@pytest.mark.parametrize("w", [1, 4, 32])
def test_changes_of_level(signal: np.ndarray, w: int) -> None:
    above = [np.zeros(len(signal), dtype=np.int64) for _ in range(2)]
    found = [module.fill_above(signal, w, 0.4, at) for module, at in zip((kernels, loops), above, strict=True)]
    assert found[0] == found[1] > 0
    np.testing.assert_array_equal(above[0], above[1])
    at = above[0][: found[0]]
    jumps, counts = np.empty((2, len(at))), np.zeros((2, 6), dtype=np.int64)
    for module, own, count in zip((kernels, loops), jumps, counts, strict=True):
        module.fill_jumps(signal, w, at, own)
        module.count_above(signal, np.full(6, 0.4), count)
    np.testing.assert_array_equal(jumps[0], jumps[1])
    np.testing.assert_array_equal(counts[0], counts[1])
    assert counts[0, w.bit_length() - 1] == len(at)
    score = np.round(Jumps(signal[:, None], w).at(at)[0], 1)  # neighbours that score alike
    room = [np.empty(len(at), dtype=np.int64) for _ in range(2)]
    many = [module.fill_peaks(at, score, one) for module, one in zip((kernels, loops), room, strict=True)]
    assert many[0] == many[1]
    peaks = room[0][: many[0]]
    np.testing.assert_array_equal(peaks, room[1][: many[1]])
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
    hot, far = np.zeros((2, 2, n), dtype=np.int64)
    blocks = [(np.empty(n // size), np.empty(n // size, dtype=np.int64)) for _ in range(2)]
    holed = np.where(np.arange(n) % 7 == 0, np.nan, signal)
    holed[17:20] = np.nan
    edges = np.array([0, 17, 19, 20, 22, n // 2, n])
    moments = [[*(np.empty(6) for _ in range(4)), np.empty(6, dtype=np.int64)] for _ in range(2)]
    steps: list[float] = []
    many: list[tuple[int, int]] = []
    for i, module in enumerate((kernels, loops)):
        many.append((module.fill_loud(signal, cuts, w, 5.0, hot[i]), module.fill_far(signal, 2.0, far[i])))
        steps.append(module.fill_blocks(signal, size, *blocks[i]))
        module.fill_moments(holed, edges[:-1], edges[1:], *moments[i])
    assert many[0] == many[1]
    assert all(0 < one < n - w + 1 for one in many[0])
    assert steps[0] == steps[1] > 0.0
    every = [(hot[i], far[i], *blocks[i], *moments[i]) for i in range(2)]
    for one, other in zip(*every, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_signal_without_steps() -> None:
    room = np.empty(2), np.empty(2, dtype=np.int64)
    assert loops.fill_blocks(np.full(16, 3.0), 8, *room) == kernels.fill_blocks(np.full(16, 3.0), 8, *room) == 0.0
