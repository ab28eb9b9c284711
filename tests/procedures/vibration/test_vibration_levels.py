"""Level over time: steps up, pauses and ramps are told by when, how long and how much, and are not taken for a gain.

Truth is a run of the independent simulator times a gain over time that is written here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from vibration_runs import PLAN, QUICK, codes, lines_verdict, readings_of, step_verdict

from independent.vibration.random_run import Array, simulate
from inertialcal.core.remarks import Remark
from inertialcal.procedures.vibration.reduction import Result, reduce

BASE = replace(QUICK, error=0.3)
SEEDS = (1, 2, 3)
Part = tuple[float, float, float]  # level at its beginning and at its end [dB], how long [s]
FULL: Part = (0.0, 0.0, 10.0)


def at(level: float, seconds: float) -> Part:
    return level, level, seconds


def run(seed: int, *parts: Part) -> Result:
    """Return a run reduced whose level is that of the parts, one after another."""
    x: Array = simulate(replace(BASE, duration=sum(one[2] for one in parts)), seed)[0]
    each = [np.linspace(first, last, round(seconds * BASE.rate)) for first, last, seconds in parts]
    level = np.resize(np.concatenate(each), len(x))
    return reduce(PLAN, readings_of(BASE, seed, control=x * 10.0 ** (level[:, None] / 20.0)))


def told(result: Result, code: str) -> Remark:
    (found,) = [one for one in result.remarks if one.code == code]
    return found


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("parts", "when", "seconds"),
    [
        ((FULL, at(6.0, 4.0), FULL), 10.0, 20.0),
        ((at(0.0, 20.0), at(6.0, 4.0)), 20.0, 20.0),
        ((at(6.0, 3.0), at(0.0, 20.0)), 0.0, 20.0),
        ((at(-6.0, 4.0), FULL, at(6.0, 4.0), FULL), 14.0, 20.0),
    ],
    ids=["amid", "last", "first", "after a step"],
)
def test_a_step_up_is_the_cause_and_full_level_is_what_was_meant(
    seed: int, parts: tuple[Part, ...], when: float, seconds: float
) -> None:
    result = run(seed, *parts)
    (one,) = result.excursions
    assert one.stretch.start == pytest.approx(when, abs=2.0 * result.levels.window)
    assert one.value == pytest.approx(6.0, abs=1.0)
    remark = told(result, "above_level")
    assert str(one) in remark.what
    assert "level" not in codes(result)
    assert result.levels.duration == pytest.approx(seconds, abs=2.0)
    verdict = lines_verdict(result, "3 dB")
    assert verdict.verdict == "FAIL"
    assert verdict.reason.startswith("the level steps up from")
    assert step_verdict(result, "10 %") == "FAIL"
    assert lines_verdict(result, "9 dB").verdict == "PASS"
    assert not step_verdict(result, "200 %")


@pytest.mark.parametrize("seed", SEEDS)
def test_a_step_down_does_not_count_and_does_not_fail(seed: int) -> None:
    result = run(seed, FULL, at(-6.0, 3.0), FULL)
    assert result.levels.duration == pytest.approx(20.0, abs=4.0 * result.levels.window)
    remark = told(result, "interrupted")
    (one,) = result.levels.left
    assert (one.start, one.stop) == pytest.approx((10.0, 13.0), abs=2.0 * result.levels.window)
    assert f"{one.level:.2g} dB" in remark.what
    assert lines_verdict(result, "3 dB").verdict == "PASS"


def test_a_pause_is_rest() -> None:
    for parts in ((FULL, at(-80.0, 5.0), FULL), (FULL, at(-80.0, 3.0), at(-6.0, 3.0), FULL)):
        result = run(1, *parts)
        assert "at rest from" in told(result, "interrupted").what
        assert result.levels.duration == pytest.approx(20.0, abs=4.0 * result.levels.window)
        assert lines_verdict(result, "3 dB").verdict == "PASS"


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("parts", "full"),
    [
        ((at(-12.0, 5.0), at(-6.0, 5.0), at(-3.0, 5.0), at(0.0, 20.0)), 20.0),
        ((at(-12.0, 20.0), at(-6.0, 20.0), at(-3.0, 30.0), at(0.0, 15.0)), 15.0),
        (((-25.0, 0.0, 10.0), at(0.0, 20.0)), 20.0),
        (((-25.0, 0.0, 30.0), at(0.0, 30.0), (0.0, -25.0, 10.0)), 30.0),
        (((-6.0, 0.0, 10.0), at(0.0, 30.0)), 30.0),
    ],
    ids=["steps", "long steps", "ramp", "slow ramps", "ramp of 6 dB"],
)
def test_a_start_does_not_fail_a_run_nor_lengthen_it(seed: int, parts: tuple[Part, ...], full: float) -> None:
    result = run(seed, *parts)
    assert lines_verdict(result, "3 dB").verdict == "PASS"
    assert codes(result) == {"edges", "level_steps"}
    assert result.levels.duration == pytest.approx(full, abs=0.1 * full)
    ramps = any(first != last for first, last, _ in parts)
    assert ("a ramp from" in told(result, "level_steps").what) is ramps


def test_a_high_run_is_not_taken_for_a_step_of_its_start() -> None:
    """The start lies nearer to the profile, and lasts longer: full level is still the highest."""
    for parts in ((at(-1.0, 30.0), at(2.0, 15.0)), (at(-10.0, 5.0), at(-4.0, 5.0), at(2.0, 20.0))):
        result = run(1, *parts)
        assert result.away == pytest.approx(2.0, abs=0.3)
        assert "level" in codes(result)
        assert lines_verdict(result, "1 dB").verdict == "FAIL"


def test_a_small_step_at_full_level_is_told_where_it_is() -> None:
    result = run(1, FULL, at(1.2, 10.0))
    assert "at 10" in told(result, "not_stationary").what
    assert result.levels.step()[1] == pytest.approx(1.2, abs=0.3)
