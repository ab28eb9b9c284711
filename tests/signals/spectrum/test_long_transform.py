"""Power of long segments in pairs and steps: as a real transform of each has it, whatever length and number."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.estimate import Array
from inertialcal.signals.spectrum import _kernels as kernels
from inertialcal.signals.spectrum import long_transform
from inertialcal.signals.spectrum.long_transform import Room, columns_of, folded, power_of

AGREES = 1e-11


def directly(x: Array, starts: list[int], weights: Array) -> Array:
    n = weights.shape[1]
    parts = [x[a : a + n] - x[a : a + n].mean() for a in starts]
    total: Array = np.sum([np.abs(np.fft.rfft(one * taper)) ** 2 for one in parts for taper in weights], axis=0)
    return total


def test_divisors_near_the_root() -> None:
    assert [columns_of(n) for n in (2**17, 125_000, 1_250_000)] == [256, 250, 1_000]
    assert columns_of(2**15 - 1) == 1  # short
    assert columns_of(32_771) == 1  # prime
    assert columns_of(2 * 32_771) == 1


@settings(deadline=None, max_examples=20)
@given(st.data())
def test_the_power_of_real_transforms(data: st.DataObject) -> None:
    p, q = data.draw(st.integers(32, 40)), data.draw(st.integers(41, 50))
    tapers, count = data.draw(st.integers(1, 3)), data.draw(st.integers(1, 5))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    n = p * q
    x = data.draw(st.sampled_from([0.0, 1e4])) + rng.normal(size=3 * n)
    starts = sorted(rng.integers(0, 2 * n, count).tolist())
    weights = rng.normal(size=(tapers, n))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(long_transform, "LONG", 2)
        columns_of.cache_clear()
        assert columns_of(n) >= 32
        rooms = list[Room]()
        shares = (starts[:2], starts[2:])  # the second in the room of the first
        found = sum(folded(power_of(x, np.array(some, dtype=np.int64), weights, rooms)) for some in shares)
        assert len(rooms) == 1
    columns_of.cache_clear()
    expected = directly(x, starts, weights)
    np.testing.assert_allclose(found, expected, rtol=AGREES, atol=AGREES * float(expected.max()))


def test_a_weak_half_of_a_spectrum_beside_a_strong_line_keeps_its_digits() -> None:
    n = 2**15
    at = np.arange(2 * n)
    x = 1e3 * np.sin(2.0 * np.pi * 0.25 * at) + 1e-3 * np.random.default_rng(2).normal(size=2 * n)
    weights = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, n + 1)[:-1])
    found, expected = folded(power_of(x, np.array([0, n]), weights[None], [])), directly(x, [0, n], weights[None])
    weak = np.abs(np.arange(n // 2 + 1) - n // 4) > 100
    np.testing.assert_allclose(found[weak], expected[weak], rtol=1e-4)  # 1e-16 of a line that is 1e6 times stronger


def test_kernels_without_the_compiler() -> None:
    pair, power, plain = np.zeros((2, 6)), np.ones((2, 2)), cast("Any", kernels)
    plain.fill_pair.py_func(
        np.array([2.0, 3.0, 4.0, 5.0]), np.arange(4.0), np.array([1.0, 0.5]), np.array([1.0, 2.0, 3.0, 4.0]), pair
    )
    assert pair.tolist() == [[1.0, -0.5, 4.0, 1.0, 0.0, 0.0], [9.0, 4.5, 16.0, 10.0, 0.0, 0.0]]  # a row ends apart
    plain.add_power.py_func(pair.view(np.complex128)[:, :2], power)
    assert power.tolist() == [[2.25, 18.0], [1.0 + 81.0 + 20.25, 1.0 + 256.0 + 100.0]]
