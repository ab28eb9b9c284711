"""Loops that are compiled where their code is at hand: the same results, and nothing is compiled for it."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.dispatcher import Dispatcher
from numpy.typing import NDArray

from inertialcal.core.show.compiling import compiling
from inertialcal.signals.screening import _kernels, loops
from inertialcal.signals.segmentation import _kernels_levels
from inertialcal.signals.segmentation import loops as loops_of_levels
from inertialcal.statistics._kernels import AtHand, compiled

jit = pytest.mark.skipif(not isinstance(_kernels.fill_pieces, Dispatcher), reason="numba compiles nothing here")


def doubled(x: Any) -> Any:
    return x + x


@jit
def test_what_is_not_at_hand_is_not_compiled() -> None:
    kernel = compiled(doubled)
    before = list(compiling.names)
    loop = AtHand(SimpleNamespace(run=kernel), SimpleNamespace(run=lambda x: ("numpy", x))).run
    kernel._cache.flush()  # type: ignore[attr-defined]  # of an earlier run
    assert (loop(2.0), loop(3)) == (("numpy", 2.0), ("numpy", 3))
    assert kernel.signatures == []  # type: ignore[attr-defined]
    assert compiling.names == before
    kernel(1)
    other = AtHand(SimpleNamespace(run=kernel), SimpleNamespace(run=lambda x: ("numpy", x))).run
    assert (other(2), other(2.0)) == (4, ("numpy", 2.0))  # whole numbers alone were compiled
    again = AtHand(SimpleNamespace(run=compiled(doubled)), SimpleNamespace(run=lambda x: ("numpy", x))).run
    assert again(2) == 4  # from disk
    assert compiling.started


def test_a_function_that_is_not_compiled_gives_way_to_numpy() -> None:
    assert AtHand(SimpleNamespace(run=doubled), SimpleNamespace(run=len)).run([1, 2]) == 2


@given(st.integers(0, 2**16), st.sampled_from([np.float64, np.float32, np.int32]))
@settings(max_examples=20)
def test_short_records_take_what_is_at_hand_to_the_last_bit(seed: int, kind: type) -> None:
    rng = np.random.default_rng(seed)
    x: NDArray[Any] = np.round(20.0 * rng.normal(size=640)).astype(kind)
    if kind is not np.int32:
        x[rng.integers(640, size=3)] = np.nan
    first, found = np.arange(0, 640, 64), np.empty((2, 10, 64))
    _kernels.fill_pieces(x, first, found[0])  # now it is at hand
    loops.loops_for.at_hand.fill_pieces(x, first, found[1])
    expected = np.empty((10, 64))
    loops.Loops.fill_pieces(x, first, expected)
    np.testing.assert_array_equal(found, [expected, expected])


@given(st.integers(0, 2**16))
@settings(max_examples=20)
def test_moments_of_stretches_are_those_of_the_definition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = 100.0 + rng.normal(size=300)
    x[rng.integers(300, size=seed % 4)] = np.nan
    edges = np.unique(np.concatenate(([0, 300], rng.integers(300, size=9))))
    x[edges[0] : edges[1]] = np.nan if seed % 5 == 0 else x[edges[0] : edges[1]]
    for own in (loops_of_levels, _kernels_levels, loops_of_levels.loops_for.at_hand):
        found = np.empty((4, len(edges) - 1))
        count = np.empty(len(edges) - 1, dtype=np.int64)
        own.fill_moments(x, edges[:-1], edges[1:], *found, count)
        for k, (a, b) in enumerate(pairwise(edges)):
            good = x[a:b][~np.isnan(x[a:b])]
            assert count[k] == len(good)
            expected = [np.nan] * 4
            if len(good):
                variance = good.var(ddof=1) if len(good) > 1 else np.nan
                expected = [good.mean(), variance, good.min(), good.max()]
            np.testing.assert_allclose(found[:, k], expected, rtol=1e-11)
