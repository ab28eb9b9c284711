"""Codes: resolution steps that were put in, and coarse ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from inertialcal.signals.codes import (
    MARKED,
    REPEATS,
    SORTED,
    _hardly_repeats,
    coarse_steps,
    levels_of,
    resolution,
    resolution_of_values,
)


def _step(values: ArrayLike) -> float | None:
    return resolution(levels_of(np.asarray(values)))


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


@pytest.mark.parametrize("step", [0.0, 1e-9, 1e-3, 0.25])
def test_a_long_record_has_the_step_of_its_levels(step: float) -> None:
    x = np.random.default_rng(1).normal(size=SORTED + 1)
    x = np.round(x / step) * step if step else x
    assert resolution_of_values(x) == resolution(levels_of(x))
    assert (resolution_of_values(x) is None) == (step < 1e-3)


@pytest.mark.parametrize("kind", ["floats", "codes", "whole numbers"])
def test_a_look_at_part_of_the_values_says_that_they_hardly_repeat_only_where_they_do(kind: str) -> None:
    rng, n = np.random.default_rng(3), 2 * MARKED
    for share, marked in ((0.49, False), (0.5, False), (0.6, True), (1.0, True)):
        many = int(share * n)
        each = {"floats": rng.normal(size=many), "codes": 1.2e-5 * np.arange(many) - 3.0}.get(
            kind, np.arange(many) * 1.0
        )
        assert _hardly_repeats(rng.permutation(np.resize(each, n)), int(n / REPEATS) + 1) == marked


def test_codes_of_a_long_record_are_found_however_their_last_digits_are_rounded() -> None:
    rng = np.random.default_rng(3)
    codes = np.rint(rng.normal(0.0, 300.0, 150_000)) * 0.1
    rounded = codes * (1.0 + rng.integers(-1, 2, len(codes)) * 2.0**-52)
    assert resolution_of_values(codes) == pytest.approx(0.1)
    assert resolution_of_values(rounded) == pytest.approx(0.1)
    assert resolution_of_values(rng.normal(0.0, 300.0, 150_000)) is None
