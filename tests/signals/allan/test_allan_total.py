"""Total deviations: NIST SP 1065, allantools, the definition written out, and what they must be indifferent to."""

from __future__ import annotations

import allantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import _kernels_total as loops
from inertialcal.signals.allan.total import KINDS, Total, total_deviations

PEERS: dict[Total, str] = {"total": "totdev", "modified_total": "mtotdev", "hadamard_total": "htotdev"}
PUBLISHED: dict[Total, tuple[float, float, float]] = {  # SP 1065, Table 31, 1000 points: m = 1, 10, 100
    "total": (2.922319e-01, 9.134743e-02, 3.406530e-02),
    "modified_total": (2.418528e-01, 6.499161e-02, 2.287774e-02),
    "hadamard_total": (2.943883e-01, 9.614787e-02, 3.058103e-02),
}
BIAS: dict[Total, tuple[float, float, float]] = {  # of white noise, divided out there: SP 1065, 5.2.13 and 5.2.14
    "total": (1.0, 1.0, 1.0),
    "modified_total": (0.73, 0.73, 0.73),
    "hadamard_total": (1.0, 0.995, 0.995),  # that at m = 1 is the overlapping Hadamard deviation
}


def suite() -> Array:
    n, found = 1234567890, []
    for _ in range(1000):
        found.append(n / 2147483647.0)
        n = 16807 * n % 2147483647
    return np.array(found)


@pytest.mark.parametrize("kind", KINDS)
def test_published_values(kind: Total) -> None:
    found = total_deviations(suite(), [1, 10, 100], kind) / np.sqrt(BIAS[kind])
    assert found == pytest.approx(PUBLISHED[kind], rel=2e-6)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("walk", [False, True], ids=["white", "walk"])
def test_allantools_at_every_factor(kind: Total, walk: bool) -> None:
    x = np.random.default_rng(2).normal(size=70) + 3.0
    x = np.cumsum(x) if walk else x
    factors = np.arange(1, 24)
    tau, expected, _, _ = getattr(allantools, PEERS[kind])(x, rate=1.0, data_type="freq", taus=factors.astype(float))
    found = total_deviations(x, factors, kind)[np.searchsorted(factors, tau)]
    assert len(tau) > 15
    assert found == pytest.approx(expected, rel=1e-11)


def by_definition(y: Array, m: int) -> float:
    """Sum of squares over all stretches, each mirrored and summed in numpy alone."""
    total, at = 0.0, np.arange(3.0 * m)
    half = 3 * m // 2
    for i in range(len(y) - 3 * m + 1):
        x = y[i : i + 3 * m]
        x = x - (x[-half:].mean() - x[:half].mean()) / (3 * m - half) * at
        whole = np.concatenate((x[::-1], x, x[::-1]))
        means = np.lib.stride_tricks.sliding_window_view(whole, m).sum(axis=1)
        z = means[: 6 * m] - 2.0 * means[m : 7 * m] + means[2 * m : 8 * m]
        total += float(z @ z)
    return total


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), m=st.integers(1, 40), more=st.integers(0, 300), walk=st.booleans())
def test_both_loops_are_the_definition(seed: int, m: int, more: int, walk: bool) -> None:
    y = np.random.default_rng(seed).normal(size=3 * m + more)
    y = np.cumsum(y) if walk else y
    expected = by_definition(y, m)
    for loop in (loops.stretches_at_once, loops.stretches_one_by_one):
        assert loop(y, m, 0, more + 1) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("m", [17, 300, 4_000])
def test_many_stretches_at_once_keep_the_digits_of_one_by_one(m: int) -> None:
    y = np.cumsum(np.random.default_rng(3).normal(size=30_000)) + 1e4
    expected = loops.stretches_one_by_one(y, m, 5_000, 5_400)
    assert loops.stretches_at_once(y, m, 5_000, 5_400) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_threads_change_nothing(kind: Total, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.random.default_rng(4).normal(size=100_000)
    found = total_deviations(x, [1, 20, 1000], kind)
    monkeypatch.setattr("inertialcal.signals.threads.cores", lambda: 1)
    assert np.array_equal(found, total_deviations(x, [1, 20, 1000], kind))


@pytest.mark.parametrize("kind", KINDS)
def test_a_level_and_the_direction_of_time_change_nothing_and_a_factor_comes_out(kind: Total) -> None:
    x, factors = np.random.default_rng(5).normal(size=500), [1, 2, 30, 166]
    found = total_deviations(x, factors, kind)
    assert total_deviations(x + 10.0, factors, kind) == pytest.approx(found, rel=1e-10)
    assert total_deviations(-2.5 * x[::-1], factors, kind) == pytest.approx(2.5 * found, rel=1e-10)


@pytest.mark.parametrize("factors", [[], [0], [2, 1], [34]])
def test_factors_that_are_not_possible_are_refused(factors: list[int]) -> None:
    with pytest.raises(PlanError, match="averaging factors"):
        total_deviations(np.zeros(100), factors)


def test_records_that_have_none_are_refused() -> None:
    with pytest.raises(PlanError, match="There are: total"):
        total_deviations(np.zeros(9), [1], "all")  # type: ignore[arg-type]
    with pytest.raises(DataError, match="samples are missing"):
        total_deviations([0.0, 1.0, np.nan, 2.0], [1])
    with pytest.raises(DataError, match="shape"):
        total_deviations([0.0, 1.0], [1])
