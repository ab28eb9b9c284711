"""What is refused, remarked and printed: bad input, gaps, dead time, averaging times."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import DataError, InertialcalError, PlanError
from inertialcal.core.recording import SECOND
from inertialcal.signals.allan import Deviation, allan, on_grid, prefix
from inertialcal.signals.allan.prefix import give_back, phase_of

RNG = np.random.default_rng
WHITE = RNG(1).normal(size=4000)
GAPS_TAKEN: tuple[Deviation, ...] = (
    "overlapping",
    "non_overlapping",
    "modified",
    "hadamard",
    "overlapping_hadamard",
)


def codes(found: Any) -> set[str]:
    return {remark.code for remark in found.remarks}


@pytest.mark.parametrize(
    ("x", "options", "words"),
    [
        (WHITE, {"quantity": "phase"}, "quantity 'phase'"),
        (WHITE, {"deviation": "theo1"}, "deviation 'theo1'"),
        (np.append(WHITE, np.nan), {"deviation": "total"}, "1 of 4001 samples are missing: no total deviation"),
        (WHITE, {"p": 95.0}, "probability 95.0"),
        (WHITE, {"noise": -3}, "noise type -3 .* from -2 to 2"),
        (WHITE, {"noise": "white"}, "noise type 'white'"),
        (WHITE, {"interval": 0.0}, "sample interval of 0.0"),
        (WHITE, {"interval": np.nan}, "sample interval of nan"),
        (WHITE, {"scale": -1.0}, "scale of -1.0"),
        (WHITE, {"averaging": 0.02}, "averaging time of 0.02 s at a sample interval of 0.01 s"),
        (WHITE, {"averaging": 0.0}, "averaging time of 0 s"),
        (WHITE, {"taus": "octaves"}, "averaging times 'octaves'"),
        (WHITE, {"taus": []}, "averaging times of no samples"),
        (WHITE, {"factors": [0, 1]}, "averaging times of 0, 1 samples"),
        (WHITE, {"factors": [1.5]}, "averaging times of 1.5 samples"),
        (WHITE, {"factors": [1], "taus": "all"}, "averaging times and averaging factors"),
        (WHITE, {"taus": [1e9]}, "no averaging time up to 1e\\+09 s fits into a record of 40 s"),
        (WHITE, {"names": ("x", "y")}, "2 name\\(s\\) for 1 channel"),
        (WHITE, {"present": np.ones(3, dtype=bool)}, "present of shape \\(3,\\)"),
        (WHITE[:1], {}, "a record of 1 sample"),
        (WHITE[:2], {"deviation": "hadamard"}, "one term of the Hadamard deviation spans 3"),
        (np.full(100, np.nan), {}, "no valid sample"),
        (np.array(["a", "b"]), {}, "samples of type <U1"),
        (WHITE + 1j, {}, "samples of type complex128"),
        (np.zeros((2, 2, 2)), {}, "samples of shape \\(2, 2, 2\\)"),
        (np.zeros(0), {}, "samples of shape \\(0,\\)"),
        (np.array([0, 2**60] * 50), {}, "whole numbers from 0 to 1152921504606846976"),
        (np.full(50, 2**64 - 1, dtype=np.uint64), {}, "do not fit into 64 bits"),
    ],
)
def test_refused(x: Any, options: dict[str, Any], words: str) -> None:
    settings: dict[str, Any] = {"interval": 0.01, "quantity": "rate"} | options
    with pytest.raises(InertialcalError, match=words) as caught:
        allan(x, settings.pop("interval"), **settings)
    assert caught.value.problems[0].code != "refused"
    assert isinstance(caught.value, DataError | PlanError)


def test_quantity_has_no_default() -> None:
    with pytest.raises(TypeError, match="quantity"):
        allan(WHITE, 0.01)  # type: ignore[call-arg]


@pytest.mark.parametrize("value", [0.1, 7, 1e6 + 1e-3])
@pytest.mark.parametrize("deviation", GAPS_TAKEN)
def test_constant_channel(value: float, deviation: Deviation) -> None:
    x = np.stack([np.full(500, value), RNG(1).normal(size=500)], axis=1)
    found = allan(x, 0.01, quantity="rate", deviation=deviation)
    assert np.all(found.deviation[:, 0] == 0.0)
    assert np.all(np.isnan(found.hi[:, 0]))
    assert np.all(found.lo[:, 1] > 0.0)
    assert [remark.code for remark in found.remarks] == ["constant"]
    assert "x: all samples are equal" in str(found.remarks[0])


def test_three_seconds_are_remarked() -> None:
    found = allan(WHITE[:60], 0.05, quantity="rate")
    assert "too_short" in codes(found)
    assert found.tau[-1] <= 1.0
    assert "too_short" not in codes(allan(WHITE, 0.01, quantity="rate"))


# Averaging times


def test_words() -> None:
    n = WHITE[:1200]
    assert allan(n, 0.5, quantity="rate").m.tolist() == [1, 2, 4, 8, 16, 32, 64, 128, 256]
    decade = allan(n, 0.5, quantity="rate", taus="decade")
    assert decade.m.tolist() == [1, 2, 4, 10, 20, 40, 100, 200, 400]
    assert decade.tau.tolist() == (0.5 * decade.m).tolist()
    assert allan(n, 0.5, quantity="rate", taus="all").m.tolist() == list(range(1, 401))
    assert allan(n, 0.5, quantity="rate", deviation="modified", taus="all").m[-1] == 300


def test_list_in_seconds_is_rounded_with_a_remark_and_cut_with_another() -> None:
    found = allan(WHITE, 0.01, quantity="rate", taus=[0.1, 0.054, 0.02, 0.1, 30.0])
    assert found.m.tolist() == [2, 5, 10]
    assert codes(found) == {"tau_rounded", "tau_too_long"}
    assert codes(allan(WHITE, 0.01, quantity="rate", taus=[0.1, 0.07])) == set()


# Missing samples


@pytest.mark.parametrize("deviation", GAPS_TAKEN)
@pytest.mark.parametrize("whole", [False, True])
def test_nothing_missing_is_the_same_on_both_ways(deviation: Deviation, whole: bool) -> None:
    x = np.rint(100 * WHITE[:1500]).astype(np.int32) if whole else WHITE[:1500]
    there = np.ones(1502, dtype=bool)
    there[0] = there[-1] = False  # outside, where a term of single samples has nothing to lose
    wide = np.concatenate([[0], x, [0]]).astype(x.dtype)
    plain = allan(x, 1.0, quantity="rate", deviation=deviation, factors=[1])
    gaps = allan(wide, 1.0, quantity="rate", deviation=deviation, factors=[1], present=there)
    assert gaps.deviation == pytest.approx(plain.deviation, rel=1e-12)
    assert gaps.n.tolist() == plain.n.tolist()
    assert codes(gaps) == {"gaps"}
    assert gaps.missing.tolist() == [2]


@pytest.mark.parametrize("deviation", GAPS_TAKEN)
@pytest.mark.parametrize("power", [0, -2])
def test_bursts_missing_hardly_move_the_curve(deviation: Deviation, power: int) -> None:
    rng, n, records = RNG(3), 4000, 60
    x = rng.normal(size=(n, records))
    x = np.cumsum(x, axis=0) if power else x
    broken = x.copy()
    for start in rng.integers(0, n - 40, 12):
        broken[start : start + 40] = np.nan
    factors = [1, 4, 16, 64, 256]
    full, gaps = (allan(y, 1.0, quantity="rate", deviation=deviation, factors=factors) for y in (x, broken))
    ratio = np.sqrt(np.mean(gaps.variance, axis=1) / np.mean(full.variance, axis=1))
    assert ratio == pytest.approx(np.ones(5), abs=0.08)
    assert np.all(gaps.missing > 400)
    assert str(gaps.remarks[0]).startswith("warning: 0: ")


def test_single_samples_missing_at_random_leave_white_noise_unbiased() -> None:
    rng = RNG(4)
    x = rng.normal(size=(20_000, 20))
    x[rng.uniform(size=x.shape) < 0.3] = np.nan
    found = allan(x, 1.0, quantity="rate", factors=[1, 2, 8, 64, 256])
    assert np.sqrt(found.variance.mean(axis=1) * found.m) == pytest.approx(np.ones(5), abs=0.03)
    assert found.inflation[3] == pytest.approx(np.full(20, 1.0 / 0.7), rel=0.02)
    assert found.inflation[0].tolist() == [1.0] * 20


def test_missing_points_of_an_angle_are_left_out() -> None:
    angle = np.cumsum(WHITE)
    broken = angle.copy()
    broken[100:103] = np.nan
    found = allan(broken, 1.0, quantity="angle", factors=[1, 10])
    terms = [broken[2 * m :] - 2 * broken[m:-m] + broken[: -2 * m] for m in (1, 10)]
    expected = [np.sqrt(np.nanmean(t**2) / 2) / m for t, m in zip(terms, (1, 10), strict=True)]
    assert found.deviation[:, 0] == pytest.approx(expected, rel=1e-10)
    assert found.n[:, 0].tolist() == [int(np.isfinite(t).sum()) for t in terms]


@pytest.mark.parametrize("deviation", GAPS_TAKEN)
def test_windows_that_are_just_half_filled_take_part(deviation: Deviation) -> None:
    x = WHITE.copy()
    x[1::2] = np.nan
    found = allan(x, 1.0, quantity="rate", deviation=deviation, factors=[2, 4])
    assert found.n.tolist() == allan(WHITE, 1.0, quantity="rate", deviation=deviation, factors=[2, 4]).n.tolist()
    assert np.isfinite(found.deviation).all()


def test_windows_that_are_never_half_filled_are_said_so() -> None:
    x = np.full(3000, np.nan)
    x[::3] = WHITE[:1000]
    found = allan(x, 1.0, quantity="rate", factors=[1, 300])
    assert np.isnan(found.deviation).all()
    assert found.n.tolist() == [[0], [0]]
    assert "gaps_too_many" in codes(found)


def test_grid() -> None:
    stamps = np.array([0, 1, 2, 5, 6]) * SECOND // 100 + np.array([0, 200_000, -300_000, 0, 100])
    counts = np.array([1, 2, 3, 4, 5], dtype=np.int16)
    values, present = on_grid(counts, stamps, 0.01)
    assert values.tolist() == [1, 2, 3, 0, 0, 4, 5]
    assert values.dtype == np.int16
    assert present.tolist() == [True, True, True, False, False, True, True]


@pytest.mark.parametrize(
    ("places", "words", "code"),
    [
        ([0, 1, 1, 2], "1 repeated timestamp\\(s\\), 0 out of order", "time_repeated"),
        ([0, 2, 1, 3], "sample 2: 0 repeated timestamp\\(s\\), 1 out of order", "time_backwards"),
        ([0, 1, 1.3, 2], "1 sample\\(s\\) come within half a sample interval", "off_grid"),
        ([0, 1, 2, 1000], "4 samples over 1001 intervals", "all_missing"),
    ],
)
def test_stamps_that_are_refused(places: list[float], words: str, code: str) -> None:
    with pytest.raises(DataError, match=words) as caught:
        on_grid(np.zeros(4), (np.array(places) * SECOND / 100).astype(np.int64), 0.01)
    assert caught.value.problems[0].code == code


def test_stamps_of_another_length_are_refused() -> None:
    with pytest.raises(DataError, match="4 samples, time of shape"):
        on_grid(np.zeros(4), np.arange(3), 0.01)


# Memory that goes from one record to the next


def test_records_one_after_the_other_do_not_meet() -> None:
    rng = RNG(6)
    records = [rng.normal(size=n) for n in (50_000, 3_000, 60_000, 50_000)]
    first = [allan(x, 1.0, quantity="rate").deviation for x in records]
    again = [allan(x, 1.0, quantity="rate").deviation for x in reversed(records)]
    together = allan(np.stack([records[0], records[3]], axis=1), 1.0, quantity="rate").deviation
    for one, other in zip(first, reversed(again), strict=True):
        assert np.array_equal(one, other)
    assert np.array_equal(together, np.hstack([first[0], first[3]]))


def full_of_nan(shape: Any, dtype: Any = np.float64) -> Any:
    """Fresh memory as bad as it can be: 0xFF in every byte, NaN as a float and -1 as a whole number."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return np.full(size, 0xFF, dtype=np.uint8).view(dtype).reshape(shape)


@pytest.mark.parametrize("deviation", GAPS_TAKEN)
@pytest.mark.parametrize("quantity", ["rate", "angle"])
@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("whole", [False, True])
def test_what_memory_held_before_does_not_matter(
    deviation: Deviation, quantity: Any, gaps: bool, whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = np.rint(1e3 * WHITE).astype(np.int64) if whole else WHITE
    present = np.arange(len(x)) % 7 > 0 if gaps else None
    clean = allan(x, 1.0, quantity=quantity, deviation=deviation, present=present)  # compiles what is not yet
    monkeypatch.setattr(np, "empty", full_of_nan)
    for _ in range(2):
        prefix._spare[:] = [full_of_nan(9 * len(x), np.uint8)]
        found = allan(x, 1.0, quantity=quantity, deviation=deviation, present=present)
        for name in ("deviation", "lo", "hi", "edf", "n"):
            assert np.array_equal(getattr(found, name), getattr(clean, name))
    assert np.all(np.isfinite(clean.deviation))


def test_phases_that_are_not_given_back_keep_their_memory() -> None:
    one, other = phase_of(WHITE, "rate"), phase_of(WHITE[::-1], "rate")
    kept = one.values.copy()
    give_back(other)
    third = phase_of(np.ascontiguousarray(WHITE[::-1]), "rate")
    assert np.array_equal(one.values, kept)
    assert not np.shares_memory(one.values, third.values)
    assert np.array_equal(third.values, phase_of(WHITE[::-1], "rate").values)


@pytest.mark.parametrize("overlapping", [True, False])
def test_the_weights_of_errors_at_gaps_are_those_of_the_term_itself(overlapping: bool) -> None:
    """Unit errors of the running sum, one at a time, through the deviation of the record with its gaps."""
    n, m = 40, 4
    rng = np.random.default_rng(1)
    there = rng.uniform(size=n) > 0.3
    there[10:15] = False
    found = allan(
        np.where(there, rng.normal(size=n), np.nan), 1.0, quantity="rate", taus=[float(m)],
        deviation="overlapping" if overlapping else "non_overlapping",
    )  # fmt: skip
    terms: list[float] = []
    for j in range(0, n - 2 * m + 1, 1 if overlapping else m):
        a, b = np.flatnonzero(there[j : j + m]) + j, np.flatnonzero(there[j + m : j + 2 * m]) + j + m
        if 2 * len(a) < m or 2 * len(b) < m:
            continue
        weights = np.zeros(n + 1)
        for window, sign in ((a, -1.0), (b, 1.0)):
            weights[window + 1] += sign / len(window)
            weights[window] -= sign / len(window)
        terms.append(float(np.sum(weights**2)))
    assert int(found.n[0, 0]) == len(terms)
    assert found.ends[0, 0] == pytest.approx(m**2 / 2.0 * np.mean(terms), rel=1e-12)


def test_without_gaps_a_term_has_three_errors() -> None:
    assert (allan(np.random.default_rng(1).normal(size=100), 1.0, quantity="rate").ends == 3.0).all()
