"""Arrays a batch at a time, in memory and on the disk."""

from __future__ import annotations

import gc
import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core import batches as b
from inertialcal.core.batches import extremes, keep_unchanged, known_finite, unchanged
from inertialcal.core.errors import DataError


@pytest.fixture(params=["memory", "disk"])
def stored(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    if request.param == "disk":
        monkeypatch.setattr(b, "HELD", 0)
    return bool(request.param == "disk")


def test_arrays_are_stored_beyond_a_size_and_go_with_their_last_view(stored: bool) -> None:
    x = b.empty(10_000, float)
    assert b.is_stored(x) == stored
    x[:] = np.arange(10_000.0)
    view = x[5000:5010]
    del x
    gc.collect()
    b.release(view)
    assert view.tolist() == list(map(float, range(5000, 5010)))
    assert b.is_stored(view) == stored
    del view
    gc.collect()
    assert not b._mapped


@given(n=st.integers(1, 300), size=st.integers(1, 400), seed=st.integers(0, 1000))
def test_figures_do_not_hang_on_the_size_of_a_batch(n: int, size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=n)
    x[rng.random(n) < 0.2] = np.nan
    x[rng.random(n) < 0.1] = np.inf
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(b, "SIZE", size)
        fine = np.isfinite(x)
        assert b.count(x, np.isfinite) == fine.sum()
        assert b.where(x, np.isnan).tolist() == np.flatnonzero(np.isnan(x)).tolist()
        np.testing.assert_array_equal(b.kept(x, fine), x[fine])
        np.testing.assert_array_equal(b.changed(x, lambda part: 2.0 * part), 2.0 * x)
        np.testing.assert_array_equal(b.finite(x), fine)
        if fine.any():
            assert b.extremes(x, infinite=False) == (x[fine].min(), x[fine].max())
            assert b.mean(x[fine]) == pytest.approx(x[fine].mean(), rel=1e-12, abs=1e-14)
        steps = np.diff(np.rint(x[fine]))
        assert (
            b.where_steps(np.rint(x[fine]), lambda step: step < 0).tolist() == (np.flatnonzero(steps < 0) + 1).tolist()
        )
        assert b.any_step(np.rint(x[fine]), lambda step: step < 0) == bool((steps < 0).any())


def test_blocks_are_not_cut() -> None:
    assert list(b.batches(np.empty(10), size=5, whole=4)) == [(0, 4), (4, 8), (8, 10)]
    assert list(b.batches(np.empty(10), size=2, whole=4)) == [(0, 4), (4, 8), (8, 10)]


def test_some_samples(stored: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(b, "SIZE", 7)
    x = b.made(100, np.int64, np.arange)
    at = np.array([0, 1, 6, 7, 8, 50, 99])
    assert b.taken(x, at).tolist() == at.tolist()
    assert b.is_stored(x) == stored


def test_no_room_is_said_with_the_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(b, "HELD", 0)
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(DataError, match="room for temporary files") as caught:
        b.empty(1000, float)
    assert caught.value.problems[0].code == "no_room"
    assert "TMPDIR" in caught.value.problems[0].do


CODE = """
import resource, numpy as np
from inertialcal.core.batches import batches, changed, empty, extremes
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
x = empty(2**26, float)
for first, stop in batches(x):
    x[first:stop] = 1.0
assert extremes(changed(x, lambda part: 2.0 * part)) == (2.0, 2.0)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.skipif(not hasattr(resource, "getrusage") or sys.platform != "linux", reason="peak memory in kilobytes")
def test_passes_over_a_gigabyte_take_the_memory_of_a_batch() -> None:
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 150_000  # of 1,048,576 kB


@pytest.mark.parametrize("mode", ["r", "r+", "c"])
@pytest.mark.parametrize("offset", [0, 24, 5000])
def test_a_map_of_the_user_is_let_go_of_and_not_changed(
    tmp_path: Path, mode: Literal["r", "r+", "c"], offset: int
) -> None:
    path = tmp_path / "m.bin"
    path.write_bytes(bytes(offset) + np.arange(30_000.0).tobytes())
    mapped = np.memmap(path, dtype=float, mode=mode, offset=offset, shape=(10_000, 3))
    if mode != "r":
        mapped[7, 1] = -1.0
    for x in (np.asarray(mapped), mapped[5:, 1], np.asarray(mapped[100:])[:, 2]):
        b.adopt(x)
        assert b.is_stored(x) == (mode != "c")
        before = x.copy()
        for _ in b.batches(x, size=999):
            pass
        np.testing.assert_array_equal(x, before)
    del x, mapped
    gc.collect()
    assert not b._mapped


@given(first=st.integers(0, 900), n=st.integers(0, 100), at=st.integers(0, 50))
@pytest.mark.parametrize("kind", ["f8", "i4", "M8[ns]", "?"])
def test_what_is_put_into_a_stored_array_stands_there_at_once(kind: str, first: int, n: int, at: int) -> None:
    x = b.empty(1_100, kind, stored=True)
    x[:] = np.zeros(1_100).astype(kind)
    expected = x.copy()
    values = np.arange(1, n + 1).astype("i8" if kind == "i4" else kind)
    expected[at + first : at + first + n] = values
    b.put(x[at:], first, values)
    np.testing.assert_array_equal(x, expected)


def test_what_is_unchanged_is_looked_through_once() -> None:
    x, y = np.arange(5.0), np.array([1.0, np.nan, np.inf])
    with unchanged([x, y]):
        assert extremes(x) == extremes(x[:]) == (0.0, 4.0)
        assert extremes(x[1:4]) == (1.0, 3.0)
        assert extremes(y) == (1.0, np.inf)
        assert extremes(y, infinite=False) == (1.0, 1.0)  # nothing is kept of what is not finite
        x[0] = -9.0
        assert extremes(x) == (0.0, 4.0)
    assert extremes(x) == (-9.0, 4.0)


def test_what_is_unchanged_and_finite_is_known() -> None:
    x, y, room = np.arange(9.0), np.array([1.0, np.nan]), np.arange(8.0)
    with unchanged([x, y, room[2:6]]):
        assert not known_finite(x)  # not yet looked through
        for one in (x, y, room[2:6]):
            extremes(one)
        assert known_finite(x)
        assert known_finite(x[3:7])
        assert known_finite(room[3:6])
        for other in (
            y,
            x[::2],
            x[::-1],
            x.view(np.int64),
            x.view(np.float32)[1:9],
            x.copy(),
            room,
            room[1:3],
            room[5:7],
        ):
            assert not known_finite(other)
        more = np.ones(3)
        keep_unchanged(more)
        extremes(more)
        assert known_finite(more)
    assert not known_finite(x)
    keep_unchanged(x)  # of nothing
    extremes(x)
    assert not known_finite(x)
