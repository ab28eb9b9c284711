"""Ramps of a temperature: turns, paths, steady temperatures, noise."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, cast

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation import _kernels_ramps as kernels
from inertialcal.signals.segmentation.ramps import find_ramps


def profile(*points: float, n: int = 200) -> Array:
    """Straight lines from point to point."""
    parts = [np.linspace(a, b, n, endpoint=False) for a, b in pairwise(points)]
    return np.concatenate([*parts, [points[-1]]])


def test_a_loop_has_its_ramps_and_the_start_of_each_is_on_no_path() -> None:
    T = profile(23.0, -30.0, 67.0, 23.0)
    found = find_ramps(T, 5.0)
    assert found.ways == (-1, 1, -1)
    for way, start, stop, begin in ((-1, 0, 200, 23.0), (1, 200, 400, -30.0), (-1, 400, 601, 67.0)):
        part, path = T[start:stop], found.path[start:stop]
        settled = np.abs(part - begin) >= 5.5
        assert np.all(path[settled] == way)
        assert np.all(path[np.abs(part - begin) < 4.5] == 0)


def test_a_steady_temperature_keeps_the_path_by_which_it_was_reached() -> None:
    T = np.concatenate([profile(20.0, 60.0), np.full(300, 60.0), profile(60.0, 20.0)])
    found = find_ramps(T, 4.0)
    assert found.ways == (1, -1)
    assert np.all(found.path[60:190] == 1)
    assert found.path[201] == 1  # the first of the steady ones
    assert np.all(found.path[-150:] == -1)


@pytest.mark.parametrize("seed", range(5))
def test_noise_and_small_wander_are_no_turns(seed: int) -> None:
    rng = np.random.default_rng(seed)
    T = profile(-20.0, 70.0, -20.0, n=2000) + 0.3 * np.sin(np.arange(4001) / 15.0) + rng.normal(0.0, 0.2, 4001)
    found = find_ramps(T, 3.0)
    assert found.ways == (1, -1)
    assert abs(found.starts[1] - 2000) < 60


def test_the_other_way_round_gives_the_other_paths() -> None:
    T = profile(10.0, 50.0, 0.0, 30.0)
    assert np.array_equal(find_ramps(-T, 4.0).path, -find_ramps(T, 4.0).path)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_turn_counts_from_the_reversal_on_whichever_way(sign: float) -> None:
    """Back by 4 degC and on by 10: three ramps where 4 degC make a turn, one where it takes 4.5."""
    T = sign * np.array([0.0, 5.0, 10.0, 8.0, 6.0, 8.0, 11.0, 16.0])
    up = int(sign)
    assert find_ramps(T, 4.0).ways == (up, -up, up)
    assert find_ramps(T, 4.5).ways == (up,)


def test_steps_of_a_chamber_are_one_ramp() -> None:
    T = np.concatenate([np.full(50, level) for level in (0.0, 10.0, 20.0, 30.0, 20.0, 10.0)])
    assert find_ramps(T, 5.0).ways == (1, -1)


def test_nothing_moves_and_missing_samples() -> None:
    still = find_ramps(np.full(100, 23.0), 1.0)
    assert len(still) == 0
    assert not still.path.any()
    T = profile(0.0, 40.0)
    T[50:60] = np.nan
    assert np.all(find_ramps(T, 2.0).path[50:60] == 0)


def test_refusals() -> None:
    with pytest.raises(DataError, match="no valid temperature"):
        find_ramps(np.full(5, np.nan), 1.0)
    with pytest.raises(PlanError, match="need more than 0"):
        find_ramps(np.zeros(5), 0.0)


@pytest.mark.parametrize("cuts", [[], [5], [1, 2, 40]])
def test_levels_of_a_record_in_batches_are_means_of_blocks(cuts: list[int]) -> None:
    x = np.random.default_rng(4).normal(size=61)
    x[[0, 9, 30]] = np.nan
    good = np.flatnonzero(np.isfinite(x))
    level, begins, held = np.empty(12), np.empty(12, dtype=np.int64), np.zeros(2, dtype=np.int64)
    for add in (kernels.add_levels, cast("Any", kernels.add_levels).py_func):
        held[:] = 0
        for first, stop in pairwise([0, *cuts, len(x)]):
            add(x[first:stop], first, 5, held, level, begins)
        assert held.tolist() == [11, 3]
        assert begins.tolist() == good[::5].tolist()
        assert level[:11] == pytest.approx([x[good[k : k + 5]].mean() for k in range(0, 55, 5)])
        assert level[11] == pytest.approx(x[good[55:]].sum())


@pytest.mark.parametrize("seed", range(5))
def test_turns_are_those_of_the_plain_loop(seed: int) -> None:
    level = np.cumsum(np.random.default_rng(seed).normal(size=300))
    found, plain = (np.zeros((2, 300), dtype=np.int64) for _ in range(2))
    count = kernels.fill_turns(level, 4.0, 0.1, found[0], found[1])
    assert cast("Any", kernels.fill_turns).py_func(level, 4.0, 0.1, plain[0], plain[1]) == count > 5
    assert found[:, :count].tolist() == plain[:, :count].tolist()
    assert np.all(np.diff(found[1, :count]) != 0)
