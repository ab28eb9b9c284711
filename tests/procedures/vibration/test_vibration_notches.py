"""A notch that a run lacks, and one that its profile has not, are told by band and size; clean runs have neither."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from vibration_runs import PLAN, QUICK, SHORT, codes, lines_verdict, readings_of

from independent.vibration.random_run import Array, simulate
from inertialcal.core.remarks import Remark
from inertialcal.procedures.vibration.reduction import Result, reduce

BASE = replace(QUICK, error=0.3)
CARVED = (*SHORT[:2], (120.0, 0.04), (125.0, 0.01), (150.0, 0.01), (156.0, 0.04), *SHORT[2:])
SEEDS = (1, 2, 3)


def of(run_nodes: tuple[tuple[float, float], ...], asked: tuple[tuple[float, float], ...], seed: int,
       responses: Array | None = None) -> Result:  # fmt: skip
    """Return a run driven with some nodes and judged by others."""
    x = simulate(replace(BASE, nodes=run_nodes), seed)[0]
    return reduce(PLAN, readings_of(replace(BASE, nodes=asked), seed, control=x, responses=responses))


def told(result: Result, code: str) -> Remark:
    (found,) = [one for one in result.remarks if one.code == code]
    return found


def ends(text: str) -> tuple[float, float]:
    """Return the band that a remark names [Hz]."""
    low, high = text.removeprefix("from ").partition(" Hz")[0].split(" to ")
    return float(low), float(high)


def size(text: str) -> float:
    """Return the mean deviation that a remark names [dB]."""
    return float(text.partition("the control lies ")[2].partition(" dB")[0])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_notch_that_the_run_lacks_is_told_with_its_band_and_depth(seed: int) -> None:
    result = of(SHORT, CARVED, seed)
    what = told(result, "notch_missing").what
    assert ends(what) == pytest.approx((121.0, 155.0), abs=8.0)
    assert size(what) == pytest.approx(5.0, abs=1.0)
    assert "its notch of 6 dB there" in what
    assert lines_verdict(result, "3 dB").verdict == "FAIL"
    assert not codes(result) & {"level", "notch_not_asked", "band_off", "low_pass"}


@pytest.mark.parametrize("seed", SEEDS)
def test_a_notch_that_was_not_asked_for_is_told_with_the_response_that_was_limited(seed: int) -> None:
    rng = np.random.default_rng([seed, 7])
    f = np.fft.rfftfreq(25_600, 1.0 / BASE.rate)
    x = simulate(replace(BASE, nodes=CARVED), seed)[0][:, 0]
    r = f / 137.0
    swings = np.fft.irfft(np.fft.rfft(x) * (1.0 + 1j * r / 12.0) / (1.0 - r * r + 1j * r / 12.0), len(x))
    both = np.column_stack([swings, 0.8 * x + 0.05 * x.std() * rng.standard_normal(len(x))])
    result = of(CARVED, SHORT, seed, both)
    what = told(result, "notch_not_asked").what
    assert ends(what) == pytest.approx((121.0, 155.0), abs=8.0)
    assert size(what) == pytest.approx(5.0, abs=1.0)
    assert "there x stands out over the control" in what
    assert lines_verdict(result, "3 dB").verdict == "FAIL"
    assert not codes(result) & {"level", "notch_missing", "band_off", "low_pass"}


def test_a_run_with_the_notch_of_its_profile_has_no_remark() -> None:
    for seed in SEEDS:
        result = of(CARVED, CARVED, seed)
        assert codes(result) == {"edges"}
        assert lines_verdict(result, "3 dB").verdict == "PASS"


def test_a_band_that_is_high_and_one_that_falls_off_at_an_end_are_told() -> None:
    high = ((20.0, 0.01), (80.0, 0.04), (120.0, 0.04), (122.0, 0.1), (150.0, 0.1), (152.0, 0.04), (200.0, 0.04),
            (500.0, 0.01))  # fmt: skip
    assert ends(told(of(high, SHORT, 1), "band_off").what) == pytest.approx((120.0, 152.0), abs=8.0)
    low = ((20.0, 0.001), (40.0, 0.004), (60.0, 0.03), *SHORT[1:])
    what = told(of(low, SHORT, 1), "band_off").what
    assert "below" in what
    assert ends(what)[1] == pytest.approx(60.0, abs=10.0)
