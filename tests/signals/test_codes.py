"""Codes: resolution steps, rails and stuck values that were put in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from inertialcal.signals.codes import Rail, coarse_steps, is_stuck, levels_of, longest_run, rails, resolution


def _step(values: ArrayLike) -> float | None:
    return resolution(levels_of(np.asarray(values)))


def _rails(values: ArrayLike) -> tuple[Rail, ...]:
    return rails(levels_of(np.asarray(values)))


@given(
    step=st.sampled_from([0.00875, 1 / 131, 2000 / 2**15, 1 / 16384, 1.0, 5 / 4095]),
    spread=st.integers(3, 60),
    offset=st.integers(-30000, 30000),
    seed=st.integers(0, 10**6),
)
def test_the_step_of_a_converter_is_found(step: float, spread: int, offset: int, seed: int) -> None:
    codes = np.random.default_rng(seed).normal(offset, spread, 3000).round()
    assert _step(codes * step) == pytest.approx(step, rel=1e-6)


def test_the_step_is_found_where_no_two_levels_are_neighbours() -> None:
    assert _step(np.tile([0.0, 0.2, 0.5], 100)) == pytest.approx(0.1)


def test_the_step_survives_printing_with_six_digits() -> None:
    codes = np.random.default_rng(3).normal(0.0, 40.0, 5000).round()
    printed = np.array([float(f"{code / 131:.6f}") for code in codes])
    assert _step(printed) == pytest.approx(1 / 131, rel=1e-4)


def test_numbers_that_hardly_repeat_have_no_step() -> None:
    assert _step(np.random.default_rng(4).normal(size=5000)) is None
    assert _step([1.5, 1.5, 1.5]) is None


def test_clipping_is_a_pile_at_the_extreme() -> None:
    signal = 1.3 * np.sin(np.arange(5000) * 0.01)
    high = _rails(np.minimum(signal, 1.0))
    assert [(rail.value, rail.is_code) for rail in high] == [(1.0, False)]
    assert high[0].count == np.count_nonzero(signal >= 1.0)
    assert len(_rails(np.clip(signal, -1.0, 1.0))) == 2


def test_the_end_of_a_converter_shows_from_two_samples() -> None:
    codes = np.random.default_rng(5).normal(0, 9000, 5000).round().astype(np.int64)
    codes = codes[np.abs(codes) < 32767]
    codes[[10, 20]] = 32767
    assert [(rail.value, rail.count, rail.is_code) for rail in _rails(codes)] == [(32767.0, 2, True)]


def test_noise_and_switches_are_not_clipped() -> None:
    rng = np.random.default_rng(6)
    for values in (rng.normal(size=5000), rng.normal(0, 5, 5000).round(), rng.integers(0, 2, 500)):
        assert _rails(values) == ()


def test_the_longest_run() -> None:
    run = longest_run(np.array([1, 2, 2, 2, 3, 3]))
    assert (run.start, run.length, run.value) == (1, 3, 2.0)


def test_a_stretch_that_stays_is_stuck() -> None:
    values = np.random.default_rng(7).normal(0, 5, 5000).round()
    assert not is_stuck(values)
    values[2000:2040] = values[2000]
    assert is_stuck(values)


def test_a_slow_channel_is_not_stuck() -> None:
    # A thermometer of coarse steps repeats its codes for long.
    slow = np.round(np.sin(np.arange(20_000) * 3e-4) * 10 + np.random.default_rng(8).normal(0, 0.05, 20_000))
    assert longest_run(slow).length > 100
    assert not is_stuck(slow)


def test_a_constant_channel_is_stuck_unless_it_is_short() -> None:
    assert is_stuck(np.zeros(10))
    assert not is_stuck(np.zeros(9))


def test_false_alarms_are_rare() -> None:
    rng = np.random.default_rng(9)
    quantised = (np.round(rng.normal(0, spread, 2000)) for spread in np.linspace(0.4, 5, 300))
    assert sum(is_stuck(values) for values in quantised) == 0


def test_a_rate_that_is_set_in_steps_is_not_clipped() -> None:
    levels = np.repeat([0.0, 1.5, -1.5, 3.0, -3.0, 4.5, -4.5, 0.0], 30)
    ramps = np.linspace(-4.0, 4.0, 23)
    assert _rails(np.concatenate([levels, ramps])) == ()
    assert len(_rails(np.clip(np.random.default_rng(1).normal(0.0, 3.0, 2000), -4.5, 4.5))) == 2


def test_noise_far_below_the_step_is_not_stuck_though_one_code_lasts_long() -> None:
    rng = np.random.default_rng(8)
    for _ in range(50):
        assert not is_stuck(np.rint(0.3 * rng.normal(size=20_000) + 0.2))


@pytest.mark.parametrize(
    ("scatter", "told"), [(0.48, "% too large"), (0.15, "cannot be estimated"), (0.6, ""), (5.0, "")]
)
def test_coarse_steps_are_told_with_what_they_do_to_white_noise(scatter: float, told: str) -> None:
    """Scatter before rounding, in steps; the size that is read is compared with it."""
    x = 0.37 + scatter * np.random.default_rng(1).normal(size=50_000)
    x[100:200] = np.nan
    remarks = coarse_steps(0.0025 * np.rint(x), "x")
    assert bool(remarks) == bool(told)
    for one in remarks:
        assert one.code == "coarse_codes"
        assert told in one.what
    if told.startswith("%"):
        read = np.nanstd(np.rint(x)) / scatter
        assert float(remarks[0].what.split("about ")[1].split()[0]) == pytest.approx(100.0 * (read - 1.0), abs=3.0)
    assert coarse_steps(x, "x") == coarse_steps(np.ones(9), "x") == ()


def test_the_largest_numbers_have_no_step() -> None:
    assert _step(np.repeat([-1.7e308, 0.0, 1.7976931348623157e308], 40)) is None
