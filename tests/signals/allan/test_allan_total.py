"""Total deviations: NIST SP 1065, allantools, the definition written out, and what they must be indifferent to."""

from __future__ import annotations

from typing import Any

import allantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Allan, allan
from inertialcal.signals.allan import _kernels_total as loops
from inertialcal.signals.allan.deviations import KINDS
from inertialcal.signals.allan.edf import bias_of, degrees_of_freedom
from inertialcal.signals.allan.total import TOTALS, Total, total_deviations

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


# variance over that without mirrors: Howe et al. (2000), table 1, of 0, -1, -2, -3, -4; of the modified one the same by
# definition for noise two powers bluer, where SP 1065 rounds to 0.94, 0.83, 0.73, 0.70 and 0.69
HOWE = (0.995, 0.851, 0.771, 0.717, 0.679)
ROUNDED = 1e-3


def suite() -> Array:
    n, found = 1234567890, []
    for _ in range(1000):
        found.append(n / 2147483647.0)
        n = 16807 * n % 2147483647
    return np.array(found)


@pytest.mark.parametrize("kind", TOTALS)
def test_published_values(kind: Total) -> None:
    found = total_deviations(suite(), [1, 10, 100], kind) / np.sqrt(BIAS[kind])
    assert found == pytest.approx(PUBLISHED[kind], rel=2e-6)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", TOTALS)
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


@pytest.mark.parametrize("kind", TOTALS)
def test_threads_change_nothing(kind: Total, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.random.default_rng(4).normal(size=100_000)
    found = total_deviations(x, [1, 20, 1000], kind)
    monkeypatch.setattr("inertialcal.signals.threads.cores", lambda: 1)
    assert np.array_equal(found, total_deviations(x, [1, 20, 1000], kind))


@pytest.mark.parametrize("kind", TOTALS)
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


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", TOTALS)
@pytest.mark.parametrize("quantity", ["rate", "increment", "angle"])
def test_with_intervals_it_is_the_same_deviation_less_its_bias(kind: Total, quantity: Any) -> None:
    x = np.random.default_rng(6).normal(size=300) + 3.0
    factors = [1, 2, 5, 17, 60]
    found = allan(np.cumsum(np.append(0.0, x)) if quantity == "angle" else x, 1.0, quantity=quantity, deviation=kind,
                  factors=factors)  # fmt: skip
    assert found.deviation[:, 0] * np.sqrt(biases(kind, found)) == pytest.approx(
        total_deviations(x, factors, kind), rel=1e-9
    )
    expected = getattr(allantools, PEERS[kind])(x, rate=1.0, data_type="freq", taus=np.array(factors, dtype=float))[1]
    assert found.deviation[:, 0] * np.sqrt(biases(kind, found)) == pytest.approx(expected, rel=1e-9)
    assert np.all(found.lo < found.deviation)
    assert np.all(found.deviation < found.hi)


def biases(kind: Total, found: Allan) -> Array:
    sizes = zip(found.m.tolist(), found.n[:, 0].tolist(), found.power[:, 0].astype(int).tolist(), strict=True)
    return np.array([bias_of(KINDS[kind], *one) for one in sizes])


@pytest.mark.parametrize("kind", TOTALS)
def test_counts_are_those_of_their_floats(kind: Total) -> None:
    x = np.random.default_rng(7).integers(30_000, 30_100, 500).astype(np.uint16)
    whole, floats = (allan(one, 1.0, quantity="rate", deviation=kind) for one in (x, x.astype(float)))
    assert whole.deviation == pytest.approx(floats.deviation, rel=1e-11)


@pytest.mark.parametrize(("place", "published"), list(enumerate(HOWE)))
def test_published_bias(place: int, published: float) -> None:
    assert bias_of(KINDS["hadamard_total"], 40, 1000, -place) == pytest.approx(published, abs=ROUNDED)
    assert bias_of(KINDS["modified_total"], 40, 1000, 2 - place) == pytest.approx(published, abs=ROUNDED)


@pytest.mark.parametrize(("power", "slope"), [(0, 0.0), (-1, 1.0 / (3.0 * np.log(2.0))), (-2, 0.75)])
def test_bias_of_the_total_variance(power: int, slope: float) -> None:  # Greenhall, Howe and Percival (1999)
    assert bias_of(KINDS["total"], 100, 999, power) == pytest.approx(1.0 - slope * 0.1)


def test_bias_of_short_windows() -> None:
    x = np.random.default_rng(8).normal(size=200_000)
    for kind, plain in (("modified_total", "modified"), ("hadamard_total", "overlapping_hadamard")):
        ratio = (
            total_deviations(x, [1, 2, 3], kind)
            / allan(x, 1.0, quantity="rate", deviation=plain, factors=[1, 2, 3]).deviation[:, 0]
        )  # type: ignore[arg-type]
        expected = [bias_of(KINDS[kind], m, 10_000, 0) for m in (1, 2, 3)]
        assert ratio**2 == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("kind", "power", "ratio", "published"), [
    ("total", 0, 10, 15.0), ("total", -1, 10, 11.48), ("total", -2, 10, 8.94),
    ("modified_total", 2, 10, 16.9), ("modified_total", 0, 10, 9.8), ("modified_total", -2, 10, 7.19),
    ("hadamard_total", 0, 10, 15.166), ("hadamard_total", -4, 4, 1.9386),
])  # fmt: skip
def test_published_degrees_of_freedom(kind: Total, power: int, ratio: int, published: float) -> None:
    m, n = 50, 50 * ratio
    terms = {"total": n - 1, "modified_total": n + 2 - 3 * m, "hadamard_total": n + 1 - 3 * m}[kind]
    assert degrees_of_freedom(KINDS[kind], m, terms, power) == pytest.approx(published, rel=1e-3)


def test_no_interval_where_none_is_published() -> None:
    blue = np.diff(np.random.default_rng(9).normal(size=5_001))
    found = allan(blue, 1.0, quantity="rate", deviation="total", noise=2)
    assert np.isnan(found.lo).all()
    assert np.isnan(found.hi).all()
    assert np.isfinite(found.deviation).all()
    assert [remark.code for remark in found.remarks] == ["no_interval"]
    assert np.isfinite(allan(blue, 1.0, quantity="rate", deviation="modified_total", noise=2).lo).all()


@pytest.mark.parametrize("kind", TOTALS)
def test_gaps_and_lengths_that_are_refused(kind: Total, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.random.default_rng(9).normal(size=500)
    with pytest.raises(DataError, match="100 of 500 samples are missing"):
        allan(x, 1.0, quantity="rate", deviation=kind, present=np.arange(500) % 5 > 0)
    monkeypatch.setattr("inertialcal.signals.allan.total.LONGEST", 400)
    with pytest.raises(DataError, match="takes 400 at most"):
        allan(x, 1.0, quantity="rate", deviation=kind)
