"""Compiled loops under the segmentation: against numpy and scipy, with and without the compiler."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import find_peaks

from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation import _kernels_levels as kernels
from inertialcal.signals.segmentation.change_points import _highest

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


def test_jumps_are_differences_of_means(run: Any) -> None:
    x, w = noise(60) + np.repeat([0.0, 5.0], 30), 4
    total = np.concatenate([[0.0], np.cumsum(x)])
    jump = np.empty(len(total) - 2 * w)
    run.fill_jump(total, w, jump)
    expected = [abs(x[i : i + w].mean() - x[i - w : i].mean()) for i in range(w, len(x) - w + 1)]
    assert jump == pytest.approx(expected)
    assert int(np.argmax(jump)) + w == 30


def test_marks_add_to_those_that_are_there(run: Any) -> None:
    over = np.array([True, False, False])
    run.mark_above(np.array([0.0, 1.0, 2.0]), 1.0, over)
    assert over.tolist() == [True, False, True]


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


def test_window_variance_from_the_level_of_its_piece(run: Any) -> None:
    y, cuts, w = noise(50) + np.repeat([1e6, -1e6], [20, 30]), np.array([0, 20, 50]), 12
    variance = np.empty(50 - w + 1)
    run.fill_window_variance(y, cuts, w, np.empty(50), variance)
    level = np.repeat([y[:20].mean(), y[20:].mean()], [20, 30])
    assert variance == pytest.approx([np.var((y - level)[i : i + w], ddof=1) for i in range(50 - w + 1)], rel=1e-6)


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
    assert sorted(NAMES) == ["drop_lower", "fill_blocks", "fill_clear", "fill_jump", "fill_moments", "fill_peaks",
                             "fill_window_variance", "margin", "mark_above"]  # fmt: skip
