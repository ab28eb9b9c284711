"""Compiled loops under the segmentation: against numpy and scipy, with and without the compiler."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import find_peaks

from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation import _kernels_levels as kernels
from inertialcal.signals.segmentation.change_points import Jumps, _highest

NAMES = [name for name in vars(kernels) if hasattr(getattr(kernels, name), "py_func")]


class Plain:
    """The Python that the kernels are compiled from."""

    def __getattr__(self, name: str) -> Any:
        return getattr(kernels, name).py_func


@pytest.fixture(params=[kernels, Plain()], ids=["compiled", "plain"])
def run(request: pytest.FixtureRequest) -> Any:
    return request.param


def noise(n: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).normal(size=n)


@pytest.mark.parametrize("room", [2, 400])
def test_jumps_are_differences_of_means(run: Any, room: int) -> None:
    x, w, limit = noise(400) + np.repeat([0.0, 5.0], 200), 4, 1.0
    total = np.concatenate([[0.0], np.cumsum(x)])
    expected = np.array([abs(x[i : i + w].mean() - x[i - w : i].mean()) for i in range(w, len(x) - w + 1)])
    assert Jumps(total[:, None], w).at(np.arange(len(expected)))[0] == pytest.approx(expected)
    assert int(np.argmax(expected)) + w == 200
    above = np.flatnonzero(expected > limit)
    at = np.empty(room, dtype=np.int64)
    assert run.fill_above(total, w, limit, at) == len(above) > 2
    assert at[: len(above)].tolist() == above[:room].tolist()


def test_jumps_of_any_channel_count() -> None:
    x = np.column_stack([noise(20_000), noise(20_000, 2)])
    total = np.concatenate([np.zeros((1, 2)), np.cumsum(x, axis=0)])
    jumps, limit = Jumps(np.asfortranarray(total), 2), np.array([0.5, 2.0])  # more places than there is room at first
    every = jumps.at(np.arange(len(jumps)))
    assert jumps.above(limit).tolist() == np.flatnonzero((every > limit[:, None]).any(axis=0)).tolist()


def test_a_sample_far_from_calm_neighbours(run: Any) -> None:
    x = np.array([0.0, 9.0, 0.0, 0.0, 9.0, 9.0])
    calm, far = np.array([True, True, True, False]), np.array([False, False, True, False])
    run.mark_alone(x, 1.0, 5.0, calm, far)
    assert calm.tolist() == [True, False, False, False]
    assert far.tolist() == [True, False, True, False]
    run.mark_alone(x, 10.0, 4.0, calm, far)
    assert far.tolist() == [True, True, True, True]


def test_clear_of_cuts(run: Any) -> None:
    at, cuts = np.arange(0, 40), np.array([0, 9, 11, 30])
    clear = np.empty(40, dtype=bool)
    run.fill_clear(at, 4, cuts, clear)
    assert clear.tolist() == [bool(np.abs(cuts - i).min() >= 4) for i in at]


@pytest.mark.parametrize("steps", [2, 5, 1000], ids=["mostly ties", "ties", "none"])
def test_highest_are_the_peaks_of_scipy(steps: int) -> None:
    rng = np.random.default_rng(steps)
    for _ in range(60):
        at = np.flatnonzero(rng.random(300) < 0.6) + 1
        score = rng.integers(1, steps + 1, len(at)).astype(float)
        w = int(2 ** rng.integers(1, 5))
        dense = np.zeros(at[-1] + 2)
        dense[at] = score
        assert at[_highest(at, score, w)].tolist() == find_peaks(dense, distance=w)[0].tolist()


def test_peaks_and_what_is_left_of_them(run: Any) -> None:
    at = np.array([1, 2, 3, 7, 9, 10, 11, 12])
    score = np.array([1.0, 3.0, 2.0, 5.0, 2.0, 4.0, 4.0, 1.0])
    room = np.empty(8, dtype=np.int64)
    peaks = room[: run.fill_peaks(at, score, room)]
    assert at[peaks].tolist() == [2, 7, 10]
    kept = np.empty(3, dtype=bool)
    run.drop_lower(at[peaks], np.argsort(score[peaks]), 4, kept)
    assert kept.tolist() == [True, True, False]  # 10 is less than 4 from 7, which is higher


def test_loud_windows_by_the_level_of_their_piece(run: Any) -> None:
    n, w, limit = 9_000, 12, 1.5
    y, cuts = noise(n) + np.repeat([1e6, -1e6], [20, n - 20]), np.array([0, 20, 20, n])
    level = np.repeat([y[:20].mean(), y[20:].mean()], [20, n - 20])
    variance = np.lib.stride_tricks.sliding_window_view(y - level, w).var(axis=1, ddof=1)
    hot = np.zeros(n - w + 1, dtype=bool)
    hot[3] = True
    run.mark_loud(y, cuts, w, limit, hot)
    expected = variance > limit
    expected[3] = True
    assert np.abs(variance - limit).min() > 1e-9
    assert hot.tolist() == expected.tolist()


@pytest.mark.parametrize("w", [1, 2, 12, 13, 31])
def test_sums_of_windows(run: Any, w: int) -> None:
    x = noise(50)
    room, out = np.empty((2, 50)), np.empty(50 - w + 1)
    run.fill_sums(x, w, room[0], room[1], out)
    assert out == pytest.approx(np.convolve(x, np.ones(w), "valid"), abs=1e-13)
    assert run.sum_of(x[:w]) == pytest.approx(float(x[:w].sum()), abs=1e-13)


@pytest.mark.parametrize("w", [4095, 4096, 5000])
def test_loud_windows_longer_than_a_batch(w: int) -> None:
    y = noise(15_000)
    variance = np.lib.stride_tricks.sliding_window_view(y, w).var(axis=1, ddof=1)
    limit = 0.5 * float(np.sum(np.quantile(variance, (0.5, 0.51))))
    hot = np.zeros(len(variance), dtype=bool)
    kernels.mark_loud(y, np.array([0, len(y)]), w, limit, hot)
    assert np.count_nonzero(hot != (variance > limit)) <= np.count_nonzero(np.abs(variance - limit) < 1e-12)


def test_blocks(run: Any) -> None:
    y = np.round(4.0 * noise(83)) / 4.0
    variance, different = np.empty(10), np.empty(10, dtype=np.int64)
    assert run.fill_blocks(y, 8, variance, different) == 0.25
    blocks = y[:80].reshape(10, 8)
    assert variance == pytest.approx(blocks.var(axis=1, ddof=1))
    assert different.tolist() == np.count_nonzero(np.diff(blocks, axis=1), axis=1).tolist()
    assert run.fill_blocks(np.ones(16), 8, variance[:2], different[:2]) == 0.0


MOVES = [((), (10, 10)), ((25,), (40, 10)), ((-5, -27), (10, 40)), ((4,), (20, 10)), ((45,), (50, 10))]


@pytest.mark.parametrize(("slow", "expected"), MOVES)
def test_margin_reaches_a_block_beyond_what_moves(run: Any, slow: tuple[int, ...], expected: tuple[int, int]) -> None:
    rates = np.asfortranarray(0.01 * noise(3 * 420, seed=4).reshape(420, 3))
    for at in slow:
        rates[10 + at if at >= 0 else 410 + at, 1] += 1.0
    assert run.margin(rates, 10, 410, 50, 10, 4.0) == expected


def test_every_kernel_is_here() -> None:
    assert sorted(NAMES) == ["drop_lower", "fill_above", "fill_blocks", "fill_clear", "fill_moments", "fill_peaks",
                             "fill_sums", "margin", "mark_alone", "mark_loud", "sum_of"]  # fmt: skip
