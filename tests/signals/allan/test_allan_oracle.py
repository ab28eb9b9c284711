"""Deviations against allantools and against long double, on random data; digits beside large offsets."""

from __future__ import annotations

from typing import Any

import allantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Deviation, allan

PEERS: dict[Deviation, str] = {
    "non_overlapping": "adev",
    "overlapping": "oadev",
    "modified": "mdev",
    "hadamard": "hdev",
    "overlapping_hadamard": "ohdev",
}
AGREES = 1e-10  # relative
FACTORS = [1, 2, 3, 4, 5, 8, 10, 16, 32, 64, 100, 128, 511, 512, 513, 700, 1024, 2048, 4000]


def peer(name: Deviation, x: Array, factors: list[int]) -> tuple[Array, Array]:
    _, deviation, _, n = getattr(allantools, PEERS[name])(
        x, rate=1.0, data_type="freq", taus=np.array(factors, dtype=float)
    )
    return deviation, n


@pytest.mark.parametrize("deviation", PEERS)
@pytest.mark.parametrize("walk", [False, True], ids=["white", "walk"])
def test_allantools_on_random_data(deviation: Deviation, walk: bool) -> None:
    x = np.random.default_rng(3).normal(size=20_001) + 5.0
    x = np.cumsum(x - 5.0) if walk else x
    found = allan(x, 1.0, quantity="rate", deviation=deviation, factors=FACTORS)
    expected, n = peer(deviation, x, FACTORS)
    assert found.n[:, 0].tolist() == n.tolist()
    assert found.deviation[:, 0] == pytest.approx(expected, rel=AGREES)


@pytest.mark.parametrize("deviation", PEERS)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(5, 400), walk=st.booleans())
def test_allantools_on_any_length_and_factor(deviation: Deviation, seed: int, n: int, walk: bool) -> None:
    x = np.random.default_rng(seed).normal(size=n)
    x = np.cumsum(x) if walk else x
    factors = list(range(1, n // 4 + 1))
    found = allan(x, 1.0, quantity="rate", deviation=deviation, factors=factors)
    expected, terms = peer(deviation, x, factors)
    kept = found.n[:, 0] > 1  # the peer drops single terms
    assert found.n[kept, 0].tolist() == terms.tolist()
    assert found.deviation[kept, 0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("deviation", PEERS)
@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int16, np.uint16, np.int32, np.int64])
def test_counts_are_summed_exactly(deviation: Deviation, kind: type[np.signedinteger]) -> None:
    rng = np.random.default_rng(4)
    middle = np.iinfo(kind).max // 2
    x = (middle + rng.integers(-50, 50, 9_000)).astype(kind)
    factors = [1, 2, 4, 8, 16, 100, 600, 2048]
    exact = [variance(x, m, deviation) for m in factors]
    found = allan(x, 1.0, quantity="rate", deviation=deviation, factors=factors, scale=0.25)
    assert found.deviation[:, 0] / 0.25 == pytest.approx(np.sqrt(exact), rel=1e-13)


def test_unsigned_counts_of_64_bits_are_summed_exactly() -> None:
    x = 2**45 + np.random.default_rng(4).integers(-50, 50, 9_000)
    plain = allan(x, 1.0, quantity="rate")
    assert np.array_equal(allan(x.astype(np.uint64), 1.0, quantity="rate").deviation, plain.deviation)
    assert plain.deviation[3, 0] == pytest.approx(np.sqrt(variance(x, 8, "overlapping")), rel=1e-13)


def variance(x: NDArray[Any], m: int, deviation: Deviation) -> float:
    """Return the variance by its definition, in whole numbers of any length."""
    total, phase = 0, [0]
    for value in x.tolist():
        total += value
        phase.append(total)
    p = np.array(phase, dtype=object)
    order = 3 if "hadamard" in deviation else 2
    stride = 1 if deviation in {"overlapping", "modified", "overlapping_hadamard"} else m
    weights = [1, -2, 1] if order == 2 else [-1, 3, -3, 1]
    count = len(p) - order * m
    terms: Any = sum(w * p[i * m : i * m + count] for i, w in enumerate(weights))
    if deviation == "modified":
        sums = np.concatenate([[0], np.cumsum(terms)])
        terms = sums[m:] - sums[:-m]
        return float(sum(int(t) ** 2 for t in terms)) / (2.0 * len(terms) * m**4)
    terms = terms[::stride]
    return float(sum(int(t) ** 2 for t in terms)) / ((2.0 if order == 2 else 6.0) * len(terms) * m**2)


@pytest.mark.parametrize("deviation", PEERS)
def test_scatter_of_1e_3_beside_1e6(deviation: Deviation) -> None:
    steps = np.random.default_rng(5).integers(-4000, 4000, 30_000)  # a grid of 2^-20: both offsets hold it exactly
    small = steps * 2.0**-20
    factors = [1, 2, 4, 64, 512, 1024, 4096]
    beside = allan(small + 1e6, 1.0, quantity="rate", deviation=deviation, factors=factors)
    exact = allan(steps, 1.0, quantity="rate", deviation=deviation, factors=factors, scale=2.0**-20)
    assert beside.deviation == pytest.approx(exact.deviation, rel=1e-13)


@pytest.mark.parametrize("deviation", PEERS)
@pytest.mark.parametrize(("offset", "drift"), [(0.0, 0), (1000.0, 3), (-1e6, 0)])
def test_long_averaging_times_keep_all_digits(deviation: Deviation, offset: float, drift: int) -> None:
    n = 15_000
    steps = np.random.default_rng(9).integers(-(2**20), 2**20, n) + drift * np.arange(n)  # a grid of 2^-20
    factors = [1, 7, 1024, 3_001, 4_999]
    exact = [variance(steps, m, deviation) for m in factors]
    found = allan(steps * 2.0**-20 + offset, 1.0, quantity="rate", deviation=deviation, factors=factors)
    digits = 1e-12 if deviation in {"non_overlapping", "hadamard"} else 1e-14  # those add squares one by one
    assert found.deviation[:, 0] * 2.0**20 == pytest.approx(np.sqrt(exact), rel=digits)


@pytest.mark.parametrize("deviation", ["overlapping", "modified"])
def test_millions_of_samples_beside_an_offset_keep_all_digits(deviation: Deviation) -> None:
    n, m = 2_000_000, 600_000
    steps = np.random.default_rng(10).integers(-(2**20), 2**20, n)
    p = np.concatenate([[0], np.cumsum(steps)])
    terms = p[2 * m :] - 2 * p[m:-m] + p[: -2 * m]
    if deviation == "modified":
        sums = np.concatenate([[0], np.cumsum(terms)])
        terms = sums[m:] - sums[:-m]
    size = float(m) ** (2 if deviation == "modified" else 1)
    exact = np.sqrt(np.mean((terms.astype(np.longdouble) / size) ** 2) / 2)
    found = allan(steps * 2.0**-20 + 1000.0, 1.0, quantity="rate", deviation=deviation, factors=[m])
    assert found.deviation[0, 0] * 2.0**20 == pytest.approx(float(exact), rel=1e-14)


@pytest.mark.parametrize("power", [-500, -60, 60, 400])
def test_modified_deviation_of_any_size(power: int) -> None:
    x = np.random.default_rng(11).normal(size=3000)
    plain = allan(x, 1.0, quantity="rate", deviation="modified")
    found = allan(np.ldexp(x, power), 1.0, quantity="rate", deviation="modified")
    assert np.ldexp(found.deviation, -power) == pytest.approx(plain.deviation, rel=1e-14)


@pytest.mark.parametrize("step", [1, 2**37])
def test_modified_deviation_of_counts_whose_sums_do_not_fit(step: int) -> None:
    x = step * np.random.default_rng(12).integers(-200, 200, 6_000)  # 2^37: third differences reach 2^63
    factors = [1, 3, 100, 700, 1999]
    found = allan(x, 1.0, quantity="rate", deviation="modified", factors=factors)
    assert found.deviation[:, 0] == pytest.approx(np.sqrt([variance(x, m, "modified") for m in factors]), rel=1e-14)


def test_a_ramp_to_1e6() -> None:
    rng = np.random.default_rng(6)
    x = np.linspace(0.0, 1e6, 200_000) + rng.normal(size=200_000)
    found = allan(x, 1.0, quantity="rate", factors=[1, 16, 1024])
    exact = allan(x.astype(np.longdouble).astype(np.float64), 1.0, quantity="rate", factors=[1])
    first = np.diff(x.astype(np.longdouble))
    assert found.deviation[0, 0] == pytest.approx(float(np.sqrt(np.mean(first**2) / 2)), rel=1e-8)
    assert exact.deviation[0, 0] == found.deviation[0, 0]


def test_float32_is_summed_in_float64() -> None:
    x = (np.random.default_rng(7).normal(size=5000) + 9.8).astype(np.float32)
    found = allan(x, 0.01, quantity="rate")
    assert found.deviation == pytest.approx(allan(x.astype(np.float64), 0.01, quantity="rate").deviation, rel=1e-13)


def test_axes_are_independent_and_in_order() -> None:
    x = np.random.default_rng(8).normal(size=(4000, 3)) * [1.0, 10.0, 0.1]
    together = allan(x, 0.01, quantity="rate")
    for i in range(3):
        alone = allan(np.ascontiguousarray(x[:, i]), 0.01, quantity="rate")
        for name in ("deviation", "lo", "hi", "edf", "power", "n"):
            assert np.array_equal(getattr(together, name)[:, i], getattr(alone, name)[:, 0])


@given(offset=st.floats(-1e3, 1e3), factor=st.floats(1e-3, 1e3), seed=st.integers(0, 1000))
def test_offset_does_nothing_and_scale_scales(offset: float, factor: float, seed: int) -> None:
    x = np.random.default_rng(seed).normal(size=300)
    one = allan(x, 1.0, quantity="rate")
    other = allan(factor * x + offset, 1.0, quantity="rate")
    assert other.deviation == pytest.approx(factor * one.deviation, rel=1e-9)
    assert other.edf == pytest.approx(one.edf)


def test_reversed_record_has_the_same_overlapping_deviation() -> None:
    x = np.random.default_rng(9).normal(size=3000).cumsum()
    for deviation in ("overlapping", "modified", "overlapping_hadamard"):
        one, other = (allan(y, 1.0, quantity="rate", deviation=deviation) for y in (x, x[::-1]))
        assert other.deviation == pytest.approx(one.deviation, rel=1e-10)


def test_closed_forms() -> None:
    line = allan(3.0 * np.arange(1000.0), 0.5, quantity="rate")  # rate ramp R: R tau / sqrt 2 (IEEE 952)
    assert line.deviation[:, 0] == pytest.approx(6.0 * line.tau / np.sqrt(2.0), rel=1e-12)
    line = allan(np.arange(1000.0), 0.5, quantity="rate", deviation="overlapping_hadamard")
    assert np.all(line.deviation < 1e-12)
    turn = np.sin(2.0 * np.pi * 0.01 * np.arange(100_000))  # averages over whole periods vanish
    assert allan(turn, 1.0, quantity="rate", factors=[100]).deviation[0, 0] < 1e-12
