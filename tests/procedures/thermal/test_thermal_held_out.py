"""What a polynomial leaves on power-ups held out: zero within its interval, and a verdict that is seldom wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.campaign.models.content import residual_row
from inertialcal.campaign.models.judged import ResidualLoop
from inertialcal.core.errors import DataError
from inertialcal.procedures.thermal.fit.quantities import earth_along
from inertialcal.procedures.thermal.held_out.closed_loop import AxisResidual, held_out, loops, residual_rows
from inertialcal.procedures.thermal.reduction import Attitude, Plan, Result, Truth, reduce, simulate
from inertialcal.statistics.closed_loop import judged
from inertialcal.statistics.intervals import contains, covers

DEG = float(np.radians(1.0))
PLAN = Plan(attitude=Attitude(0.1, 0.0, 0.5, 0.0), latitude=0.64, order=3)
FIT = Truth(interval=40.0, white=9e-4 * DEG)
HELD = replace(FIT, runs=2)


def reduced(truth: Truth, seed: int, plan: Plan = PLAN) -> Result:
    return reduce(plan, simulate(plan, truth, np.random.default_rng(seed)))


def left(seed: int, fit: Truth = FIT, held: Truth = HELD) -> AxisResidual:
    return held_out(reduced(fit, 2 * seed), reduced(held, 2 * seed + 1))[0]


def verdict(one: AxisResidual) -> str:
    return judged(loops([one], "rad/s"))[0].verdict


def test_the_residual_is_the_mean_offset_of_the_power_ups_held_out() -> None:
    """Nothing else is there: no noise, no hysteresis, no start-up."""
    bare = Truth(interval=40.0, white=0.0, walk=0.0, run_std=0.0, slope_std=0.0, hysteresis=0.0, lag=0.0, start_up=0.0,
                 temperature_noise=0.0)  # fmt: skip
    shift = 0.01 * DEG
    moved = replace(bare, coefficients=bare.coefficients + np.array([[shift], [0.0], [0.0], [0.0]]), runs=2)
    scattered = replace(bare, white=1e-9, run_std=1e-9)
    one = held_out(reduced(scattered, 1), reduced(moved, 2))[0]
    assert one.residual == pytest.approx(shift, rel=1e-3)
    assert one.compensated == pytest.approx(shift, rel=1e-3)
    assert one.runs == 2
    assert one.gain == pytest.approx(one.raw**2 - one.compensated**2, rel=0.05)


def test_a_body_that_was_laid_anew_is_judged_with_both_attitudes() -> None:
    tilted = replace(PLAN, attitude=Attitude(tilt=0.7, u=0.05, azimuth=0.3))
    fit, held = reduced(FIT, 2, tilted), reduced(HELD, 3, tilted)
    one, other = (held_out(fit, held, remounted)[0] for remounted in (False, True))
    tilt = earth_along(tilted)[1]["tilt of the body"].patterns[0, 0]
    assert other.u == pytest.approx(np.sqrt(one.u**2 + 2.0 * tilt**2))
    assert other.allowed == pytest.approx(one.allowed + 2.0 * tilt**2)
    assert other.u_gain > one.u_gain


def test_intervals_of_the_residual_hold_zero_and_a_right_polynomial_passes() -> None:
    n = 60
    found = [left(seed) for seed in range(1, n + 1)]
    rows = [residual_rows([one], "rad/s", "air")[0] for one in found]
    hits = sum(contains(row.interval, 0.0) for row in rows if row.interval is not None)
    assert covers(hits, n), hits
    words = [verdict(one) for one in found]
    assert words.count("FAIL") == 0
    assert words.count("PASS") > 0.9 * n  # the bias is 0.1 deg/s, power-ups differ by 0.006


def test_a_polynomial_of_nothing_is_called_worse_in_few_percent_and_hardly_ever_better() -> None:
    """The true bias is zero: what was fitted is noise, which makes readings worse by just what is allowed."""
    none = replace(FIT, coefficients=np.zeros((4, 1)), hysteresis=0.0)
    n = 100
    words = [verdict(left(seed, none, replace(none, runs=2))) for seed in range(1, n + 1)]
    assert words.count("FAIL") <= 12  # 5 %, exact 99.9 % binomial
    assert words.count("PASS") <= 12


def test_a_polynomial_of_the_other_sign_fails() -> None:
    assert verdict(left(1, replace(FIT, coefficients=-FIT.coefficients))) == "FAIL"


def test_one_power_up_in_the_fit_tells_no_uncertainty() -> None:
    one = left(3, replace(FIT, runs=1))
    row = residual_rows([one], "rad/s", "air")[0]
    assert row.status == "not_estimated"
    assert row.reason.code == "one_run"
    assert verdict(one) == "INCONCLUSIVE"


def test_ramps_elsewhere_are_refused() -> None:
    cold = replace(FIT, set_points=(-5.0, -30.0, -5.0))
    warm = replace(HELD, set_points=(23.0, 67.0, 23.0))
    with pytest.raises(DataError, match="no temperature held out lies between"):
        left(1, cold, warm)


def test_rows_come_in_the_unit_of_the_sensor() -> None:
    one = judged(loops([left(1)], "rad/s"))[0]
    row = residual_row("air", ResidualLoop("check", "air", one), "deg/s")
    assert (row["test"], row["against"], row["axis"], row["unit"], row["runs"]) == ("check", "air", "x", "deg/s", 2)
    assert 0.02 < row["raw_rms"] < 0.5
