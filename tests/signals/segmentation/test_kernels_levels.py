"""Compiled loops under the segmentation: against numpy and scipy, with and without the compiler."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import find_peaks

from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation import _kernels_levels as kernels
from inertialcal.signals.segmentation.change_points import Jumps, _highest, single_outliers
from inertialcal.signals.segmentation.noise_scale import Noise

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
    expected = np.array([abs(x[i : i + w].mean() - x[i - w : i].mean()) for i in range(w, len(x) - w + 1)])
    assert Jumps(x[:, None], w).at(np.arange(len(expected)))[0] == pytest.approx(expected)
    assert int(np.argmax(expected)) + w == 200
    above = np.flatnonzero(expected > limit)
    at = np.empty(room, dtype=np.int64)
    assert run.fill_above(x, w, limit, at) == len(above) > 2
    assert at[: len(above)].tolist() == above[:room].tolist()


def test_jumps_of_any_channel_count() -> None:
    x = np.column_stack([noise(20_000), noise(20_000, 2)])
    jumps, limit = Jumps(np.asfortranarray(x), 2), np.array([0.5, 2.0])  # more places than there is room at first
    every = jumps.at(np.arange(len(jumps)))
    assert jumps.above(limit).tolist() == np.flatnonzero((every > limit[:, None]).any(axis=0)).tolist()


@pytest.mark.parametrize("n", [9, 40, 13_000])
def test_jumps_at_a_few_places_are_those_at_all(run: Any, n: int) -> None:
    x, w = noise(n) + 1e6, 4
    means = np.lib.stride_tricks.sliding_window_view(x, w).mean(axis=1)
    every = np.abs(means[w:] - means[:-w])
    for step in (1, 3, 500):
        at = np.arange(0, n - 2 * w + 1, step)
        jumps = np.empty(len(at))
        run.fill_jumps(x, w, at, jumps)
        np.testing.assert_allclose(jumps, every[at], atol=1e-9)
        whole = np.empty(len(every))
        run.fill_jumps(x, w, np.arange(len(every)), whole)
        assert np.array_equal(jumps, whole[at])  # however many lie together


@pytest.mark.parametrize("n", [3, 40, 13_000])
def test_jumps_of_all_widths_are_counted_in_one_look(run: Any, n: int) -> None:
    x, limits = noise(n), np.array([2.0, np.inf, 1.0, 0.7])
    counts = np.ones(4, dtype=np.int64)
    run.count_above(x, limits, counts)
    expected = np.ones(4, dtype=np.int64)
    for k, limit in enumerate(limits):
        means = np.lib.stride_tricks.sliding_window_view(x, min(2**k, n)).mean(axis=1)
        expected[k] += np.count_nonzero(np.abs(means[2**k :] - means[: -(2**k)]) > limit) if n >= 2 * 2**k else 0
    assert counts.tolist() == expected.tolist()


@pytest.mark.parametrize("room", [1, 8])
def test_samples_far_from_the_mean_of_their_neighbours(run: Any, room: int) -> None:
    x = np.tile([0.0, 9.0, 0.0, 0.0, 9.0, 9.0], 40)
    off = np.abs(x[1:-1] - 0.5 * (x[:-2] + x[2:]))
    for away in (5.0, 4.0, 9.0):
        at, expected = np.zeros(room, dtype=np.int64), np.flatnonzero(off > away) + 1
        assert run.fill_far(x, away, at) == len(expected)
        assert at[: len(expected)].tolist() == expected[:room].tolist()


def test_an_outlier_has_neighbours_that_agree_in_every_channel() -> None:
    y = np.asfortranarray(0.1 * noise(600).reshape(300, 2))
    y[[50, 100, 150, 155], 0] += 9.0
    y[100:102, 1] += 9.0
    found = single_outliers(y, Noise(np.full(2, 0.1), np.full(2, 1e6), np.zeros(2), np.ones(2, dtype=bool)), 6.0, 12)
    assert found.tolist() == [50]  # at 100 the other channel steps; 150 and 155 are too near to each other


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
    assert np.abs(variance - limit).min() > 1e-9
    expected = np.flatnonzero(variance > limit)
    for room in (2, n):
        at = np.empty(room, dtype=np.int64)
        assert run.fill_loud(y, cuts, w, limit, at) == len(expected) > 2
        assert at[: len(expected)].tolist() == expected[:room].tolist()


@pytest.mark.parametrize("at", [5, 4_090, 4_096, 8_992])
def test_a_loud_window_among_quiet_ones_is_found_where_batches_meet(run: Any, at: int) -> None:
    n, w = 9_000, 12
    y = 0.1 * noise(n)
    y[at : at + 2] += [3.0, -3.0]
    variance = np.lib.stride_tricks.sliding_window_view(y - y.mean(), w).var(axis=1, ddof=1)
    places = np.empty(n, dtype=np.int64)
    found = run.fill_loud(y, np.array([0, n]), w, 0.5, places)
    assert places[:found].tolist() == np.flatnonzero(variance > 0.5).tolist() != []


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
    hot, at = np.zeros(len(variance), dtype=bool), np.empty(len(variance), dtype=np.int64)
    hot[at[: kernels.fill_loud(y, np.array([0, len(y)]), w, limit, at)]] = True
    assert np.count_nonzero(hot != (variance > limit)) <= np.count_nonzero(np.abs(variance - limit) < 1e-12)


@pytest.mark.parametrize("size", [5, 8])
def test_blocks(run: Any, size: int) -> None:
    y = np.round(4.0 * noise(83)) / 4.0
    variance, different = np.empty(10), np.empty(10, dtype=np.int64)
    assert run.fill_blocks(y, size, variance, different) == 0.25
    blocks = y[: 10 * size].reshape(10, size)
    assert variance == pytest.approx(blocks.var(axis=1, ddof=1))
    assert different.tolist() == np.count_nonzero(np.diff(blocks, axis=1), axis=1).tolist()
    assert run.fill_blocks(np.ones(16), size, variance[:2], different[:2]) == 0.0


MOVES = [((), (10, 10)), ((25,), (40, 10)), ((-5, -27), (10, 40)), ((4,), (20, 10)), ((45,), (50, 10))]


@pytest.mark.parametrize(("slow", "expected"), MOVES)
def test_margin_reaches_a_block_beyond_what_moves(run: Any, slow: tuple[int, ...], expected: tuple[int, int]) -> None:
    rates = np.asfortranarray(0.01 * noise(3 * 420, seed=4).reshape(420, 3))
    for at in slow:
        rates[10 + at if at >= 0 else 410 + at, 1] += 1.0
    assert run.margin(rates, 10, 410, 50, 10, 4.0) == expected


def test_the_variance_of_quiet_blocks_is_the_mean_of_those_below_its_limit(run: Any) -> None:
    variances = np.append(noise(300) ** 2 + 1.0, [400.0] * 60)
    pooled = np.quantile(variances, 0.25) / 0.8
    for _ in range(5):
        pooled = variances[variances <= 2.0 * pooled].mean()
    assert run._quiet_variance(variances, 0.25, 0.8, 2.0, 5) == pytest.approx(pooled)


@pytest.mark.parametrize("shape", ["noise", "alike", "rising", "waves"])
@pytest.mark.parametrize("rank", [0, 1, 380, 500, 2499, 2500])
def test_a_rank_and_the_next(run: Any, shape: str, rank: int) -> None:
    x = noise(2501)
    x = {"noise": x, "alike": np.round(x), "rising": np.sort(x), "waves": np.sin(2.0 * np.pi * np.arange(2501) / 19.0)}[
        shape
    ]
    ordered = np.sort(x)
    assert run._of_rank(x, rank) == (ordered[rank], ordered[min(rank + 1, 2500)])


@pytest.mark.parametrize(("disturbed", "still"), [("", True), ("spike", False), ("step", False), ("missing", False)])
def test_noise_alone_is_still(run: Any, disturbed: str, still: bool) -> None:
    x = noise(4000)
    x[1234] += 60.0 * (disturbed == "spike")
    x[2000:] += 5.0 * (disturbed == "step")
    x[7] = np.nan if disturbed == "missing" else x[7]
    assert bool(run.is_still(x, 8, 4, (0.5, 0.25, 0.7, 2.0), 10, 7.0, 6, 40, 4.0)) is still


@pytest.mark.parametrize("n", [7, 16, 403])
def test_no_loud_window_by_blocks_is_none_by_windows(run: Any, n: int) -> None:
    x, w, size = noise(n), 5, 8
    blocks = x[: n // size * size].reshape(-1, size)
    of_blocks = blocks.mean(axis=1), blocks.var(axis=1, ddof=1)
    most = max(x[i : i + w].var() * w for i in range(n - w + 1))
    for limit in (0.9 * most, 0.999 * most, 1.001 * most, 10.0 * most):
        assert bool(run._none_loud(x, x.mean(), *of_blocks, size, w, limit)) == (limit > most)


def test_every_kernel_is_here() -> None:
    assert sorted(NAMES) == ["_add", "_far_apart", "_fill_spreads", "_filled", "_least_step", "_none_above",
                             "_none_loud", "_of_eight", "_of_rank", "_quiet_variance", "_square", "_sums",
                             "count_above", "drop_lower", "fill_above", "fill_blocks", "fill_clear", "fill_far",
                             "fill_jumps", "fill_loud", "fill_moments", "fill_peaks", "fill_sums", "is_still",
                             "margin", "sum_of"]  # fmt: skip
