"""Loops of short records and of long ones: numpy and the kernels agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.estimate import Array
from inertialcal.signals import threads
from inertialcal.signals.allan import _kernels, _kernels_missing, loops, noise_type

ROUNDING = 1e-11  # relative: sums of squares of the kernels are not pairwise


@st.composite
def records(draw: st.DrawFn) -> tuple[NDArray[Any], NDArray[np.bool_], NDArray[np.int64]]:
    """Samples, whole numbers or not, which of them are there, and averaging factors."""
    n, rng = draw(st.integers(10, 3000)), np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    x = (
        rng.normal(draw(st.sampled_from([0.0, 1e3])), 1.0, n)
        + draw(st.sampled_from([0.0, 0.1])) * rng.normal(size=n).cumsum()
    )
    there = rng.random(n) > draw(st.sampled_from([0.02, 0.3]))
    there[n // 2 : n // 2 + draw(st.integers(0, n // 4))] = False
    there[0] |= not there.any()
    factors = np.unique(draw(st.lists(st.integers(1, (n - 2) // 3), min_size=1, max_size=6)))
    return (np.rint(100.0 * x).astype(np.int64) if draw(st.booleans()) else x), there, factors.astype(np.int64)


def both_phases(
    x: NDArray[Any], there: NDArray[np.bool_] | None = None
) -> list[tuple[NDArray[Any], NDArray[np.int32]]]:
    """The integrated signal, and how many samples there are before each point, of either module."""
    kind = np.int64 if x.dtype == np.int64 else np.float64
    found: list[tuple[NDArray[Any], NDArray[np.int32]]] = []
    level = kind(x.mean())
    for module in (_kernels, loops):
        phase, count = np.empty(len(x) + 1, dtype=kind), np.empty(len(x) + 1, dtype=np.int32)
        if there is None:
            module.integrate(x, level, phase)
        else:
            module.integrate_present(x, there, level, phase, count)
        found.append((phase, count))
    return found


@settings(max_examples=60, deadline=None)
@given(records())
def test_sums_of_complete_records_agree(
    record: tuple[NDArray[Any], NDArray[np.bool_], NDArray[np.int64]],
) -> None:
    x, _, factors = record
    (phase, _), (other, _) = both_phases(x)
    assert other == pytest.approx(phase, rel=1e-13, abs=1e-12 * float(np.ptp(phase)))
    for order in (2, 3):
        for name in ("sum_overlapping", "sum_strides"):
            one, two = np.empty((2, len(factors)))
            getattr(_kernels, name)(phase, factors, order, one)
            getattr(loops, name)(phase, factors, order, two)
            assert two == pytest.approx(one, rel=ROUNDING)
    assert loops.largest_beside_line(phase) == pytest.approx(_kernels.largest_beside_line(phase), rel=1e-12)
    once, again = np.empty((2, len(phase) + 1), dtype=np.int64)
    for scale in (2.0**20, 0.0) if phase.dtype == np.int64 else (2.0**20,):
        _kernels.sum_again(phase, scale, once)
        loops.sum_again(phase, scale, again)
        assert np.max(np.abs(np.diff(once) - np.diff(again))) <= (scale > 0.0)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 20), st.integers(1, 4), st.sampled_from([0.0, 0.1, 1.0]))
def test_autocorrelations_of_averages_agree(seed: int, m: int, many: int, walk: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.normal(1e3, 1.0, 3000) + walk * rng.normal(size=3000).cumsum()
    phase = both_phases(x)[0][0]
    size, apart = 3000 // m // many - 1, max(m // many, 1)
    one, two = (module.lag_one(phase, m, many, size, apart, 0.01, 0.2, 2) for module in (_kernels, loops))
    assert two == pytest.approx(one, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("walk", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_exponents_of_averages_agree(walk: float, kind: type[np.floating[Any]]) -> None:
    rng = np.random.default_rng(3)
    x = (rng.normal(1e3, 1.0, 3000) + walk * rng.normal(size=3000).cumsum()).astype(kind)
    factors, phases, found = 2 ** np.arange(10), np.empty((2, 3001)), np.empty((2, 10))
    where, lost, known = noise_type.looked_at(3001, factors.tobytes(), 1)
    for module, phase, out in zip((_kernels, loops), phases, found, strict=True):
        module.integrate_all(x, 7, phase)
        module.fill_exponents(phase, factors, where, lost, noise_type.SMALL_ENOUGH, known, out)
    assert phases[1] == pytest.approx(phases[0], abs=1e-9)
    assert found[1] == pytest.approx(found[0], rel=1e-9, abs=1e-9, nan_ok=True)
    assert np.isfinite(found[0]).tolist() == (3000 // factors >= noise_type.FEWEST).tolist()


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("longest", [[7], [2**16, 2**17], [40_000, 90_001]])
def test_all_cores_sum_a_long_record(monkeypatch: pytest.MonkeyPatch, order: int, longest: list[int]) -> None:
    p = np.random.default_rng(4).normal(size=threads.LARGE + 3).cumsum()
    factors = np.array([1, 2, 4, 5, *longest])
    one, two, plain = np.full((3, len(factors)), np.nan)
    loops.sum_overlapping(p, factors, order, plain)
    for cores, found in ((1, one), (3, two)):
        monkeypatch.setattr(threads, "cores", lambda number=cores: number)
        _kernels.sum_overlapping(p, factors, order, found)
    assert one.tolist() == two.tolist()
    assert one == pytest.approx(plain, rel=1e-13)


@settings(max_examples=60, deadline=None)
@given(records(), st.booleans())
def test_sums_of_records_with_gaps_agree(
    record: tuple[NDArray[Any], NDArray[np.bool_], NDArray[np.int64]], pointwise: bool
) -> None:
    x, there, factors = record
    (phase, count), (other, same) = both_phases(x, there)
    assert (count == same).all()
    assert other == pytest.approx(phase, rel=1e-13, abs=1e-12 * float(np.ptp(phase)))
    if pointwise:
        phase, factors = np.where(there, x, 0), factors[3 * factors < len(x) - 1]

    def agree(name: str, *args: object) -> None:
        found: list[tuple[Array, NDArray[np.int64], Array]] = []
        for module in (_kernels_missing, loops):
            found.append((np.empty(len(factors)), np.empty(len(factors), dtype=np.int64), np.empty(len(factors))))
            getattr(module, name)(phase, count, pointwise, factors, *args, *found[-1])
        (one, terms, raised), (two, as_many, raised_too) = found
        assert (terms == as_many).all()
        size = float(np.max(np.abs(one), initial=0.0))
        assert two == pytest.approx(one, rel=ROUNDING, abs=1e-13 * size)
        assert raised_too == pytest.approx(raised, rel=ROUNDING)

    for overlapping in (True, False):
        agree("sum_present", 2, overlapping)
        agree("sum_present", 3, overlapping)
        if not pointwise:
            one, two = np.empty((2, len(factors)))
            _kernels_missing.weights_of_ends(count, factors, overlapping, one)
            loops.weights_of_ends(count, factors, overlapping, two)
            assert two == pytest.approx(one, rel=ROUNDING)
    agree("sum_present_modified")


def test_short_records_do_without_a_compiler() -> None:
    assert loops.loops_for(loops.FEW) is loops.loops_with_gaps(loops.SHORT) is loops
    assert loops.loops_for(loops.FEW + 1) is _kernels
    assert loops.loops_with_gaps(loops.SHORT + 1) is _kernels_missing
