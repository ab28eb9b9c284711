"""Noise of a record in which much happens."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import PlanError
from inertialcal.signals.segmentation.noise_scale import noise_scale


def white(n: int, seed: int = 1) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.random.default_rng(seed).normal(size=(n, 1))


def test_white_noise() -> None:
    noise = noise_scale(white(20_000) * np.array([3.0, 0.001]))
    # Clipping keeps all but 1e-3 of the blocks; 17,500 degrees of freedom leave 0.5 %.
    assert noise.scale == pytest.approx([3.0, 0.001], rel=0.02)
    assert np.all(noise.dof > 0.95 * 20_000 * 7 / 8)
    assert noise.live.all()
    assert noise.feigned.tolist() == [0.0, 0.0]
    assert not noise.stated


@pytest.mark.parametrize(("moving", "within"), [(0.3, 0.05), (0.6, 0.12)])
def test_motion_for_a_part_of_the_time_does_not_count(moving: float, within: float) -> None:
    # Where a motion turns round it is nearly still for a block: that much it does raise the noise.
    x = white(8000)
    first = int(8000 * (1.0 - moving))
    x[first:] += 30.0 * np.sin(np.arange(8000 - first) / 9.0)[:, None]
    assert noise_scale(x).scale == pytest.approx([1.0], rel=within)


def test_spikes_do_not_count() -> None:
    x = white(8000)
    x[::100] += 1000.0
    assert noise_scale(x).scale == pytest.approx([1.0], rel=0.03)


@pytest.mark.parametrize("step", [0.1, 0.5, 1.0])
def test_fine_counts_add_their_rounding(step: float) -> None:
    # Blocks in which many neighbours are equal are not used: at a step as large as the noise, 6 % too much.
    x = np.round(white(20_000) / step) * step
    noise = noise_scale(x)
    assert noise.scale == pytest.approx([np.hypot(1.0, step / np.sqrt(12.0))], rel=0.07)
    assert noise.step == pytest.approx([step])


def test_coarse_counts_hide_the_noise() -> None:
    # At 0.2 steps of noise most neighbours are equal: half a step stands in.
    noise = noise_scale(np.round(0.2 * white(4000) + 0.1))
    assert noise.scale.tolist() == [0.5]
    assert not noise.live.any()
    assert noise.feigned.tolist() == [1.0]


def test_nothing_varies() -> None:
    noise = noise_scale(np.full((40, 1), 7.0))
    assert (noise.scale[0], noise.step[0]) == (0.0, 0.0)


def test_stated() -> None:
    noise = noise_scale(white(100) * np.ones(2), (2.0, 3.0))
    assert noise.scale.tolist() == [2.0, 3.0]
    assert noise.stated
    with pytest.raises(PlanError, match=r"1 value\(s\) of noise stated for 2 channel\(s\)"):
        noise_scale(np.zeros((100, 2)), (1.0,))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(-30, 30), st.integers(16, 200))
def test_scales_with_the_unit(seed: int, power: int, n: int) -> None:
    x = white(n, seed)
    assert noise_scale(x * 2.0**power).scale == pytest.approx(2.0**power * noise_scale(x).scale)


def test_each_block_has_a_degree_of_freedom_less_than_samples() -> None:
    """Blocks that are all alike are all kept: seven degrees of freedom of eight samples, and their pooled variance."""
    block = white(8)
    noise = noise_scale(np.tile(block, (500, 1)))
    assert noise.dof == pytest.approx([500 * 7.0])
    assert noise.scale == pytest.approx([float(block.std(ddof=1))])
