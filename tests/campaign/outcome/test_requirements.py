"""Requirements: OPEN without a test, simultaneous over a range, and a false PASS no more often than stated."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import ReducedTest
from inertialcal.campaign.file.schema import Requirement
from inertialcal.campaign.file.schema import Test as Entry
from inertialcal.campaign.outcome.requirements import judge, worst
from inertialcal.core.judging import Verdict
from inertialcal.core.key import Key, Reason
from inertialcal.core.results import Row
from inertialcal.procedures.protocol import Tested as Done
from inertialcal.procedures.rate_table.reduction import Plan, Truth, reduce, simulate
from inertialcal.statistics.intervals import binomial_interval
from sized import sized

ENTRY = Entry(id="one", procedure="rate_table", recordings=["a"])
PLAN = Plan(zero_reference=True)  # no earth rate, so that the true error is the sensor's alone
RISK = 0.05


def requirement(**given: object) -> Requirement:
    return Requirement.model_validate({"id": "R", "quantity": "rate_error", "limit": "5 %"} | given)


def with_rows(result: object, *rows: Row) -> ReducedTest:
    return ReducedTest(ENTRY, Done("one", "", "fit", PLAN, None, result), rows)


def reduced(error: float, seed: int) -> ReducedTest:
    """A unit whose scale factor error is the same at every rate."""
    truth = Truth(np.eye(3) * (1.0 + error), run_scale_std=2e-3, axes=("x",))
    result = reduce(PLAN, simulate(PLAN, truth, np.random.default_rng(seed)))
    return with_rows(result)


@cache
def overall(error: float, seed: int, **given: str) -> str:
    return worst(judge(requirement(axis="x", **given), [reduced(error, seed)])[0])


def test_a_requirement_that_no_test_speaks_to_is_open_and_no_pass() -> None:
    verdicts, rows = judge(requirement(quantity="angle_random_walk"), [reduced(0.0, 1)])
    assert [one.verdict for one in verdicts] == ["OPEN"]
    assert not rows
    assert worst(verdicts) == "INCONCLUSIVE"


def test_fail_goes_before_inconclusive_before_pass() -> None:
    def of(word: str) -> Verdict:
        return Verdict("R", "t", "x", None, "", 0.0, 0.0, "1", None, None, None, word)

    assert worst([of("PASS"), of("INCONCLUSIVE"), of("FAIL")]) == "FAIL"
    assert worst([of("PASS"), of("OPEN")]) == "INCONCLUSIVE"
    assert worst([of("PASS")]) == "PASS"


def test_far_inside_passes_and_far_outside_fails() -> None:
    assert overall(0.0, 1) == "PASS"
    assert overall(0.08, 1) == "FAIL"


def test_a_requirement_speaks_to_tests_of_its_kind_only() -> None:
    assert judge(requirement(condition="vacuum"), [reduced(0.0, 1)])[0][0].verdict == "OPEN"
    assert judge(requirement(tests=["other"]), [reduced(0.0, 1)])[0][0].verdict == "OPEN"


def test_the_band_over_several_rates_is_wider_than_at_one() -> None:
    one = judge(requirement(axis="x", where="rate > 3 deg/s"), [reduced(0.0, 1)])[0]
    many = judge(requirement(axis="x"), [reduced(0.0, 1)])[0]
    alone = one[0].interval
    together = next(v for v in many if v.at == one[0].at).interval
    assert alone is not None
    assert together is not None
    assert together.p == pytest.approx(0.95 ** (1.0 / len(many)))
    assert together.hi is not None
    assert alone.hi is not None
    assert together.hi > alone.hi


def test_single_figures_are_judged_by_their_interval() -> None:
    row = Row(Key("bias", "x"), 0.01, 0.001, "rad/s", 10.0)
    at = with_rows(object(), row)
    for limit, word in (("0.02 rad/s", "PASS"), ("0.005 rad/s", "FAIL"), ("0.0105 rad/s", "INCONCLUSIVE")):
        assert judge(requirement(quantity="bias", limit=limit), [at])[0][0].verdict == word
    unknown = Row(
        Key("bias", "x"), None, None, "rad/s", status="not_estimated", reason=Reason("not_turned", "never turned")
    )
    verdict = judge(requirement(quantity="bias", limit="1 rad/s"), [with_rows(object(), unknown)])[0][0]
    assert (verdict.verdict, verdict.reason) == ("INCONCLUSIVE", "never turned")
    wrong = judge(requirement(quantity="bias", limit="1 V"), [at])[0][0]
    assert wrong.verdict == "INCONCLUSIVE"


@pytest.mark.parametrize("error", [0.05, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.0505, 0.052))])
def test_a_false_pass_is_no_more_frequent_than_stated(error: float) -> None:
    passed = sum(overall(error, seed, of="expected") == "PASS" for seed in range(1, 101))
    assert binomial_interval(passed, 100)[0] <= RISK


@pytest.mark.parametrize("error", [0.05, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.0495, 0.048))])
def test_a_false_fail_is_no_more_frequent_than_stated(error: float) -> None:
    failed = sum(overall(error, seed, of="expected") == "FAIL" for seed in range(1, 201))
    assert binomial_interval(failed, 200)[0] <= RISK


@pytest.mark.slow
def test_false_verdicts_long() -> None:
    n = sized(1000, 400)
    found = [overall(0.05, seed, of="expected") for seed in range(1, n + 1)]
    for word in ("PASS", "FAIL"):
        assert binomial_interval(found.count(word), n)[0] <= RISK


def test_an_axis_that_was_not_turned_is_no_pass() -> None:
    verdicts, _ = judge(requirement(), [reduced(0.0, 1)])
    assert {v.axis: v.verdict for v in verdicts if v.at is None} == {"y": "INCONCLUSIVE", "z": "INCONCLUSIVE"}
    assert worst(verdicts) == "INCONCLUSIVE"


def test_a_sense_of_rotation_that_was_not_turned_is_no_pass() -> None:
    truth = Truth(np.eye(3), run_scale_std=2e-3, axes=("x",))
    readings = simulate(PLAN, truth, np.random.default_rng(1))
    result = reduce(PLAN, readings.take(readings.applied >= 0.0))
    one = with_rows(result)
    (missing,) = [v for v in judge(requirement(axis="x"), [one])[0] if v.at is None]
    assert (missing.verdict, missing.reason) == ("INCONCLUSIVE", "negative rates were not turned")
    assert all(v.at is not None for v in judge(requirement(axis="x", where="rate > 0 deg/s"), [one])[0])
