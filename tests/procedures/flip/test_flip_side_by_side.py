"""Two ground models side by side: Tables 14 and 21, what cancels in a difference, and coverage of the change."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.errors import PlanError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.results import Row
from inertialcal.core.units import factor
from inertialcal.procedures.flip.inputs import MeanOf, readings_of_means
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.readings import Readings
from inertialcal.procedures.flip.reduction import reduce
from inertialcal.procedures.flip.side_by_side import same_dwells, side_by_side
from inertialcal.procedures.flip.simulation import Truth, simulate

UG = factor("ug", "m/s^2")
LAST = 0.0016  # ug: differences of half sums of three decimals
PLAN = Plan(corrected=True)
ANGLES = (0.0, math.pi)

# TM-106980, Tables 11 (new model) and 20 (older one), filtered, (forward, reverse) [ug]. Y of time 3 is left out: a
# mean of Table 20 is misprinted (errata).
NEW = {
    "y": {"1": (-23.339, -22.691), "2": (-11.862, -22.740)},
    "z": {"1": (41.103, 39.510), "2": (41.172, 33.030), "3": (41.433, 32.581)},
}
OLD = {
    "y": {"1": (51.164, 50.703), "2": (42.054, 31.652)},
    "z": {"1": (7.227, 5.284), "2": (48.005, 39.615), "3": (47.546, 38.857)},
}
TABLE_14 = {"y": {"1": -23.015, "2": -17.301}, "z": {"1": 40.307, "2": 37.101, "3": 37.007}}
TABLE_21 = {"y": {"1": 50.934, "2": 36.853}, "z": {"1": 6.256, "2": 43.810, "3": 43.202}}
# "The new model is better by 6 to 20 ug": at times 2 and 3; at time 1 Y is 27.9 better and Z 34.1 worse (errata).
BETTER = {("y", "1"): 27.9, ("y", "2"): 19.6, ("z", "1"): -34.1, ("z", "2"): 6.7, ("z", "3"): 6.2}


def of_tables(means: Mapping[str, Mapping[str, tuple[float, ...]]]) -> Readings:
    return readings_of_means([
        MeanOf(axis, angle, pair[i] * UG, time)
        for axis, times in means.items()
        for time, pair in times.items()
        for i, angle in enumerate(ANGLES)
    ])  # fmt: skip


def by_key(rows: list[Row]) -> dict[tuple[str, str, str], Row]:
    return {(row.quantity, row.axis, str(row.case)): row for row in rows}


def number(found: float | None) -> float:
    assert found is not None
    return found


def test_the_published_models_differ_as_their_tables_do() -> None:
    for axes in ("y", "z"):
        new, old = ({axis: table[axis] for axis in axes} for table in (NEW, OLD))
        rows = by_key(side_by_side(reduce(PLAN, of_tables(new)), reduce(PLAN, of_tables(old)), "old"))
        for axis in axes:
            for time, printed in TABLE_14[axis].items():
                change = number(rows["model_bias_error_change", axis, f"flip {time}"].value) / UG
                assert change == pytest.approx(printed - TABLE_21[axis][time], abs=LAST)
                nearer = number(rows["model_bias_error_reduction", axis, f"flip {time}"].value) / UG
                assert nearer == pytest.approx(BETTER[axis, time], abs=0.06)
                other = number(rows["other_model_bias_error", axis, f"flip {time}"].value) / UG
                assert other == pytest.approx(TABLE_21[axis][time], abs=LAST)


def test_pooled_the_change_has_the_scatter_of_the_differences() -> None:
    new, old = ({"z": table["z"]} for table in (NEW, OLD))
    rows = by_key(side_by_side(reduce(PLAN, of_tables(new)), reduce(PLAN, of_tables(old)), "old"))
    each = np.array([number(rows["model_bias_error_change", "z", f"flip {n}"].value) for n in "123"])
    pooled = rows["model_bias_error_change", "z", ""]
    assert pooled.value == pytest.approx(each.mean())
    assert pooled.u == pytest.approx(each.std(ddof=1) / math.sqrt(3.0))
    assert pooled.reason.text == "less old, dwell by dwell"
    assert rows["model_bias_error_change", "z", "flip 1"].status == "not_estimated"


def test_where_the_sign_of_an_error_is_not_known_the_reduction_has_no_uncertainty() -> None:
    new, old = ({"z": table["z"]} for table in (NEW, OLD))
    rows = by_key(side_by_side(reduce(PLAN, of_tables(new)), reduce(PLAN, of_tables(old)), "old"))
    row = rows["model_bias_error_reduction", "z", ""]
    assert (row.u, row.interval, row.status) == (None, None, "not_estimated")
    assert row.reason.code == "sign_unknown"


TRUTH = Truth(np.array([10.0, -20.0, 30.0]) * UG, np.array([1.0, 4.0, -3.0]) * UG, 1e-12, 0.05)


def moved(readings: Readings, by: Mapping[str, float], rng: np.random.Generator | None = None) -> Readings:
    """The same record after another model: constants, and a little noise of its own."""

    def of(means: Mapping[str, Array]) -> dict[str, Array]:
        return {axis: one + by[axis] * UG for axis, one in means.items()}

    quiet = readings.quiet[0]
    means = of(quiet.means)
    if rng is not None:
        means = {axis: one + rng.normal(0.0, 0.01 * UG, len(one)) for axis, one in means.items()}
    return replace(readings, outputs=of(readings.outputs), quiet=(replace(quiet, means=means),))


BY = {"x": 3.0, "y": -40.0, "z": 7.0}


def test_the_noise_of_one_record_cancels_in_the_difference() -> None:
    old = simulate(PLAN, TRUTH, np.random.default_rng(4))
    new = moved(old, BY, np.random.default_rng(5))
    results = reduce(PLAN, new), reduce(PLAN, old)
    rows = by_key(side_by_side(*results, "old"))
    for axis in "yz":
        row = rows["model_bias_error_change", axis, ""]
        assert row.value == pytest.approx(BY[axis] * UG)
        (own,) = [r for r in results[0].rows() if (r.quantity, r.axis, str(r.case)) == ("model_bias_error", axis, "")]
        assert number(row.u) < 0.1 * number(own.u)
    assert number(rows["other_model_bias_error", "y", ""].u) > 0.0


def test_the_other_way_round_changes_every_sign() -> None:
    old = simulate(PLAN, TRUTH, np.random.default_rng(6))
    new = moved(old, BY, np.random.default_rng(7))
    results = reduce(PLAN, new), reduce(PLAN, old)
    there, back = by_key(side_by_side(*results, "old")), by_key(side_by_side(*results[::-1], "new"))
    for name in ("model_bias_error_change", "model_bias_error_reduction"):
        for axis in "yz":
            row, other = there[name, axis, ""], back[name, axis, ""]
            assert row.value == pytest.approx(-number(other.value))
            assert row.u == pytest.approx(other.u)


def test_of_the_standards_only_the_scale_factor_acts_on_a_difference() -> None:
    stated = {
        "converter.zero": Influence(5.0 * UG, "m/s^2"),
        "sensor.scale_factor": Influence(0.01),
    }
    plan = replace(PLAN, standards=stated)
    old = simulate(PLAN, TRUTH, np.random.default_rng(8))
    rows = by_key(side_by_side(reduce(plan, moved(old, BY)), reduce(plan, old), "old"))
    assert rows["model_bias_error_change", "y", ""].u == pytest.approx(0.01 * 40.0 * UG, rel=1e-3)
    assert number(rows["other_model_bias_error", "y", ""].u) > 5.0 * UG


def test_errors_of_opposite_signs_are_reduced_by_their_sum() -> None:
    old = simulate(PLAN, replace(TRUTH, bias=np.array([0.0, 30.0, 30.0]) * UG), np.random.default_rng(9))
    rows = by_key(side_by_side(reduce(PLAN, moved(old, BY)), reduce(PLAN, old), "old"))
    error = number(rows["other_model_bias_error", "y", ""].value) / UG
    assert number(rows["model_bias_error_reduction", "y", ""].value) / UG == pytest.approx(2.0 * error - 40.0)
    # both errors carry the noise of the flip, and their sum twice of it
    assert rows["model_bias_error_reduction", "y", ""].u == pytest.approx(
        2.0 * number(rows["other_model_bias_error", "y", ""].u), rel=0.01
    )


def test_flips_without_a_dwell_in_common_are_taken_as_independent() -> None:
    old = simulate(PLAN, TRUTH, np.random.default_rng(10))
    other = replace(old, flip=np.array(["later"] * len(old)))
    results = reduce(PLAN, moved(old, BY)), reduce(PLAN, other)
    rows = by_key(side_by_side(*results, "old"))
    row = rows["model_bias_error_change", "y", ""]
    u = [number(r.u) for one in results for r in one.rows() if (r.quantity, r.axis) == ("model_bias_error", "y")]
    assert row.u == pytest.approx(math.hypot(*u))
    assert "taken as independent" in row.reason.text
    assert ("model_bias_error_reduction", "y", "") not in rows


def test_dwells_are_the_same_by_flip_position_and_order() -> None:
    one = Readings(np.array([0.0, math.pi, 0.0]), np.array(["1"] * 3), {})
    other = Readings(np.array([math.pi, 0.0, 0.0, 0.0]), np.array(["1", "2", "1", "1"]), {})
    here, there = same_dwells(one, other)
    assert (here.tolist(), there.tolist()) == ([0, 1, 2], [2, 0, 3])


def test_only_dwells_that_both_have_are_compared_and_it_is_said() -> None:
    two = {axis: {"2": times["2"]} for axis, times in OLD.items()}
    rows = side_by_side(reduce(PLAN, of_tables(NEW)), reduce(PLAN, of_tables(two)), "old")
    change = by_key(rows)["model_bias_error_change", "z", ""]
    assert number(change.value) / UG == pytest.approx(TABLE_14["z"]["2"] - TABLE_21["z"]["2"], abs=LAST)
    assert not any(str(row.case) for row in rows)


def test_what_cannot_be_set_side_by_side_is_refused() -> None:
    result = reduce(PLAN, of_tables(NEW))
    raw = reduce(Plan(), of_tables(NEW))
    with pytest.raises(PlanError, match="old has the bias in its readings: there is no model error"):
        side_by_side(result, raw, "old")
    with pytest.raises(PlanError, match="this test has the bias in its readings"):
        side_by_side(raw, result, "old")
    other = reduce(replace(PLAN, axis="y"), of_tables(NEW))
    with pytest.raises(PlanError, match="turned about x, old about y"):
        side_by_side(result, other, "old")


@pytest.mark.parametrize("n", [100, pytest.param(300, marks=pytest.mark.slow)])
def test_the_interval_of_the_change_holds_its_confidence(n: int) -> None:
    """Four flips, models that differ by 5 ug and a scatter from flip to flip; noise of the dwells is common to both."""
    hits = 0
    for seed in range(1, n + 1):
        rng, flips = np.random.default_rng(seed), [str(k) for k in range(4)]
        common = {f: 30.0 + rng.normal(0.0, 20.0, 2) for f in flips}
        apart = {f: rng.normal(5.0, 1.0) for f in flips}
        means = ({f: tuple(common[f] + s * apart[f]) for f in flips} for s in (1.0, 0.0))
        new, old = (of_tables({"y": one}) for one in means)
        rows = by_key(side_by_side(reduce(PLAN, new), reduce(PLAN, old), "old"))
        interval = rows["model_bias_error_change", "y", ""].interval
        assert interval is not None
        hits += number(interval.lo) <= 5.0 * UG <= number(interval.hi)
    band = stats.binomtest(hits, n).proportion_ci(0.999, "exact")
    assert band.low <= 0.97
    assert band.high >= 0.93
