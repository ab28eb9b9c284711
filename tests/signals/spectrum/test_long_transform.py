"""Power of long segments in pairs and steps: as a real transform of each has it, whatever length and number."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.estimate import Array
from inertialcal.signals._kernels_lanes import aligned, eight, load, store, times
from inertialcal.signals.spectrum import _kernels_transform as kernels
from inertialcal.signals.spectrum import long_transform
from inertialcal.signals.spectrum.long_transform import Room, Steps, columns_of, folded, lanes_of, power_of, steps_of
from inertialcal.statistics._kernels import compiled

AGREES = 1e-11


def directly(x: Array, starts: list[int], weights: Array) -> Array:
    n = weights.shape[1]
    parts = [x[a : a + n] - x[a : a + n].mean() for a in starts]
    total: Array = np.sum([np.abs(np.fft.rfft(one * taper)) ** 2 for one in parts for taper in weights], axis=0)
    return total


def test_divisors_near_the_root() -> None:
    assert [columns_of(n) for n in (2**17, 125_000, 1_250_000)] == [256, 250, 1_000]
    assert columns_of(2**15 - 2**7) == 1  # short
    assert columns_of(7 * 2**13) == 1  # another factor
    assert columns_of(32_771) == 1  # prime
    assert columns_of(2 * 32_771) == 1


@settings(deadline=None, max_examples=20)
@given(st.data())
def test_the_power_of_real_transforms(data: st.DataObject) -> None:
    p, q = data.draw(st.sampled_from([32, 36, 40])), data.draw(st.sampled_from([45, 48, 50, 54]))
    tapers, count = data.draw(st.integers(1, 3)), data.draw(st.integers(1, 5))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    n = p * q
    x = data.draw(st.sampled_from([0.0, 1e4])) + rng.normal(size=3 * n)
    starts = sorted(rng.integers(0, 2 * n, count).tolist())
    weights = rng.normal(size=(tapers, n))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(long_transform, "LONG", 2)
        columns_of.cache_clear()
        steps_of.cache_clear()
        assert columns_of(n) >= 32
        rooms = list[Room]()
        shares = (starts[:2], starts[2:])  # the second in the room of the first
        found = sum(folded(power_of(x, np.array(some, dtype=np.int64), weights, rooms)) for some in shares)
        assert len(rooms) == 1
    columns_of.cache_clear()
    steps_of.cache_clear()
    expected = directly(x, starts, weights)
    np.testing.assert_allclose(found, expected, rtol=AGREES, atol=AGREES * float(expected.max()))


@pytest.mark.parametrize("n", [48, 75, 2_500])
@pytest.mark.parametrize("count", [1, 9, 15, 16, 17, 40])
def test_the_power_of_short_segments(n: int, count: int) -> None:
    rng = np.random.default_rng(count)
    x = 1e3 + rng.normal(size=8 * n)
    starts, weights = rng.integers(0, 7 * n, count).tolist(), rng.normal(size=(2, n))
    lanes = lanes_of(n)
    assert lanes is not None
    found, rooms = np.zeros(n // 2 + 1), lanes.rooms()
    for taper in weights:
        lanes.add_power(x, np.array(starts), taper, rooms, found)
    expected = directly(x, starts, weights)
    np.testing.assert_allclose(found, expected, rtol=AGREES, atol=AGREES * float(expected.max()))
    assert lanes_of(7 * n) is lanes_of(2**15) is None  # another factor; long


def test_segments_side_by_side_without_the_compiler() -> None:
    n, rng = 12, np.random.default_rng(4)
    x, starts, taper = rng.normal(size=5 * n), np.array([0, 7, 30]), rng.normal(size=n)
    one, power = rng.normal(size=(2, 16 * n)), np.zeros((2, n // 2 + 1))
    plain = (cast("Any", kernels.fill_segments).py_func, cast("Any", kernels.add_whole).py_func)
    for own, total, (fill, add) in zip(one, power, ((kernels.fill_segments, kernels.add_whole), plain), strict=True):
        fill(x, starts, taper, own)
        add(own, total)
    parts = np.array([(x[a : a + n] - x[a : a + n].mean()) * taper for a in starts])
    for own in one.reshape(2, n, 16):
        np.testing.assert_allclose(own[:, :3].T, parts, rtol=1e-12)
        assert not own[:, 3:].any()
    np.testing.assert_allclose(power[1], power[0], rtol=1e-12)


def test_a_weak_half_of_a_spectrum_beside_a_strong_line_keeps_its_digits() -> None:
    n = 2**15
    at = np.arange(2 * n)
    x = 1e3 * np.sin(2.0 * np.pi * 0.25 * at) + 1e-3 * np.random.default_rng(2).normal(size=2 * n)
    weights = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, n + 1)[:-1])
    found, expected = folded(power_of(x, np.array([0, n]), weights[None], [])), directly(x, [0, n], weights[None])
    weak = np.abs(np.arange(n // 2 + 1) - n // 4) > 100
    np.testing.assert_allclose(found[weak], expected[weak], rtol=1e-4)  # 1e-16 of a line that is 1e6 times stronger


def test_axes_of_one_array() -> None:
    n, x = 2**15, np.random.default_rng(3).normal(size=(2**16, 3))
    weights = np.hanning(n)[None]
    for axis in range(3):
        found, expected = (
            folded(power_of(x[:, axis], np.array([0, n]), weights, [])),
            directly(x[:, axis], [0, n], weights),
        )
        np.testing.assert_allclose(found, expected, rtol=AGREES, atol=AGREES * float(expected.max()))


@compiled
def worked_out(x: Array, y: Array) -> None:
    for i in range(0, len(x), 8):
        store(y, i, load(x, i) * load(x, i) - eight(3.0) + load(x, i))


@compiled
def apart(x: Array, y: Array) -> None:
    for i in range(0, len(x), 8):
        store(y, i, load(x, i) + times(load(x, i), load(x, i)))


def test_eight_at_a_time_as_one_by_one() -> None:
    x = np.random.default_rng(1).normal(size=32)
    for room in (np.empty(33)[1:], aligned(32)):
        worked_out(x, room)
        np.testing.assert_allclose(room, x * x - 3.0 + x, rtol=0, atol=1e-15)
        apart(x, room)
        assert room.tolist() == (x + x * x).tolist()  # to the last bit
    assert aligned(5).ctypes.data % 64 == 0


def test_kernels_without_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = cast("Any", kernels)
    for name in ("_set", "_twos", "_threes", "_fours", "_fives", "transformed"):
        monkeypatch.setattr(plain, name, getattr(plain, name).py_func)
    p, q = 10, 12  # more than whole groups of eight
    monkeypatch.setattr(long_transform, "columns_of", lambda n: p)
    steps = Steps(p * q)
    room, power, taper = Room(steps), np.zeros((q, p + 8)), np.hanning(p * q)
    one, other = np.random.default_rng(4).normal(size=(2, p * q))
    plain.fill_columns.py_func(
        one, other, np.array([0.5, -0.25]), taper, p, q, steps.factors[0], steps.turns[0], steps.between, *room.rooms,
        room.middle, room.wide,
    )  # fmt: skip
    rest = room.middle, room.wide, p, q, steps.factors[1], steps.turns[1], *room.rooms
    plain.add_rows.py_func(*rest, power.ravel())
    expected = np.abs(np.fft.fft(((one - 0.5) + 1j * (other + 0.25)) * taper)) ** 2
    np.testing.assert_allclose(power[:, :p].ravel(), expected, rtol=AGREES, atol=AGREES * float(expected.max()))
