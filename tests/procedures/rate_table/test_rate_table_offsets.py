"""Rate table: offsets of power-ups bend nothing; second- and third-order terms; unequal dwells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.procedures.rate_table.fit.linearity import deviations, largest_deviation
from inertialcal.procedures.rate_table.fit.regression import line
from inertialcal.procedures.rate_table.plan import Plan
from inertialcal.procedures.rate_table.readings import Readings
from inertialcal.procedures.rate_table.reduction import Result, reduce

RATES = np.array([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0])
M, K1, K2, K3 = 1.004, 2e-3, 3e-3, -2e-3
ROUNDING = 1e-9  # relative, of exact readings


def turned(
    offsets: Sequence[float], labels: bool = True, noise: float = 0.0, bent: bool = False, seed: int = 1
) -> Readings:
    """Dwells of the x sensor: recordings about x, y, z in turn, each with an offset of its own."""
    rng = np.random.default_rng(seed)
    axis = np.repeat([*"xyz"], len(RATES) * len(offsets) // 3)
    applied = np.tile(RATES, len(offsets))
    u = np.where(axis == "x", M, 2e-3) * applied
    y = 0.01 + np.repeat(offsets, len(RATES)) + u + 0.5 * K1 * np.abs(u) * (axis == "x")
    if bent:
        y = y + (K2 * u**2 + K3 * u**3) * (axis == "x")
    y = y + noise * rng.standard_normal(len(y))
    run = np.repeat([f"power-up {i}" for i in range(len(offsets))], len(RATES))
    readings = Readings(applied, axis, {"x": y}, sensors=("x",), earth=np.zeros((len(y), 3)))
    return replace(readings, run=run) if labels else readings


def value(result: Result, name: str) -> float:
    assert result.estimate is not None
    return result.estimate.value(name)


@pytest.mark.parametrize("labels", [True, False], ids=["labelled", "not labelled"])
def test_offsets_of_power_ups_are_no_asymmetry_and_no_deviation_from_the_line(labels: bool) -> None:
    result = reduce(Plan(nonlinearity="none"), turned((0.05, -0.02, 0.01), labels))
    assert value(result, "scale_factor_asymmetry_x") == pytest.approx(K1, rel=ROUNDING)
    assert value(result, "scale_factor_error_x") == pytest.approx(M - 1.0, rel=1e-6)
    assert value(result, "bias_x") == pytest.approx(0.01 + 0.04 / 3.0, rel=1e-6)
    plain = largest_deviation(line(Plan(), turned((0.05, -0.02, 0.01), labels), "x", asymmetry=False))
    still = largest_deviation(line(Plan(), turned((0.0, 0.0, 0.0), labels), "x", asymmetry=False))
    assert plain is not None
    assert still is not None
    assert plain.size == pytest.approx(still.size, rel=1e-6)


def test_the_bias_of_three_power_ups_scatters_as_their_intercepts() -> None:
    """Intercepts far apart weigh alike: their standard deviation over the root of three, two degrees of freedom."""
    offsets = (0.05, -0.02, 0.01)
    found = reduce(Plan(nonlinearity="none"), turned(offsets, noise=1e-6)).estimate
    assert found is not None
    at = found.index("bias_x")
    scatter = next(one for one in found.components if one.kind == "A")
    assert scatter.u[at] == pytest.approx(np.std(offsets, ddof=1) / np.sqrt(3.0), rel=1e-3)
    assert np.asarray(scatter.dof)[at] == 2.0


def test_scale_factors_that_differ_from_run_to_run_are_their_own_scatter() -> None:
    """The slope is the mean of the runs' slopes, with their standard deviation over the root of their number."""
    slopes = np.array([1.0, 1.003, 0.999, 1.002])
    applied, run = np.tile(RATES, 4), np.repeat(["a", "b", "c", "d"], len(RATES))
    y = np.repeat(slopes, len(RATES)) * applied + np.repeat([0.1, -0.2, 0.0, 0.3], len(RATES))
    one = line(Plan(), Readings(applied, np.full(len(y), "x"), {"x": y}, run=run, sensors=("x",)), "x", True)
    assert one.level == "run"
    assert one.covariance is not None
    assert one.coefficient("M_xx") == pytest.approx(slopes.mean(), rel=ROUNDING)
    assert np.sqrt(one.covariance[1, 1]) == pytest.approx(np.std(slopes, ddof=1) / 2.0, rel=ROUNDING)
    assert one.dof[1] == pytest.approx(3.0, rel=ROUNDING)


def test_an_axis_turned_in_one_run_has_the_scatter_of_dwells_and_the_others_that_of_runs() -> None:
    whole = turned((0.01, -0.01, 0.02, 0.0, 0.01, -0.02), noise=1e-4)
    assert whole.run is not None
    kept = whole.take(~np.isin(whole.run, ["power-up 5"]))
    one = line(Plan(), kept, "x", asymmetry=True)
    assert one.dof[one.names.index("M_xx")] == pytest.approx(1.0)
    assert one.dof[one.names.index("M_xz")] == one.fit.dof
    assert one.level == "dwell"


def test_coefficients_are_the_combinations_of_the_readings_that_the_line_states() -> None:
    for readings in (turned((0.01, -0.01, 0.02), noise=1e-3), turned((0.01,) * 3, noise=1e-3)):
        one = line(Plan(), readings, "x", asymmetry=True)
        np.testing.assert_allclose(one.fit.solve @ readings.outputs["x"], one.fit.coefficients, rtol=1e-9)


def test_pairs_of_rates_share_an_intercept() -> None:
    """A recording of +r and -r cannot tell its offset from an asymmetry."""
    applied = np.repeat([0.2, 0.5, 0.7, 1.0, 0.3, 0.9], 2) * np.tile([1.0, -1.0], 6)
    rng = np.random.default_rng(3)
    y = applied + 1e-4 * rng.standard_normal(12)
    readings = Readings(applied, np.full(12, "x"), {"x": y}, run=np.repeat([*"abcdef"], 2), sensors=("x",))
    one = line(Plan(), readings, "x", asymmetry=True)
    assert not one.fit.own
    assert np.all(one.dof > 0.0)


@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_second_and_third_order_terms_are_seen_and_go_into_the_line(noise: float) -> None:
    result = reduce(Plan(), turned((0.05, -0.02, 0.01, 0.03, 0.0, 0.02), noise=noise, bent=True))
    assert result.lines["x"].curvature == ("K2", "K3")
    truths = {
        "scale_factor_error_x": M - 1.0,
        "scale_factor_asymmetry_x": K1,
        "second_order_x": K2,
        "third_order_x": K3,
    }
    for name, truth in truths.items():
        assert value(result, name) == pytest.approx(truth, abs=max(1e-9, 50.0 * noise))


def test_a_straight_sensor_keeps_its_line_and_says_how_curved_it_may_be() -> None:
    result = reduce(Plan(), turned((0.05, -0.02, 0.01, 0.03, 0.0, 0.02), noise=1e-4))
    assert result.lines["x"].curvature == ()
    rows = {str(row.key): row for row in result.rows() if row.case.plain}
    for name in ("second_order_x", "third_order_x"):
        interval = rows[name].interval
        assert interval is not None
        assert interval.lo is not None
        assert interval.hi is not None
        assert interval.lo < 0.0 < interval.hi


def test_a_term_that_is_hinted_at_is_an_uncertainty_of_what_it_looks_like() -> None:
    """A K2 of twice its u, seen by its own test alone: the line stays straight, its asymmetry is far less certain."""
    readings = turned((0.01, -0.02, 0.01), noise=1e-4, seed=5)
    curve = np.where(readings.axis == "x", 1.5e-3 * readings.applied**2, 0.0)
    readings = replace(readings, outputs={"x": readings.outputs["x"] + curve})
    auto, none = (reduce(Plan(nonlinearity=how), readings) for how in ("auto", "none"))
    assert auto.lines["x"].curvature == ()
    assert [one.name for one in auto.lines["x"].unresolved if one.size] == ["K2"]
    assert auto.estimate is not None
    assert none.estimate is not None
    name = "scale_factor_asymmetry_x"
    assert value(auto, name) == pytest.approx(value(none, name), rel=1e-9)
    term, other = (auto.estimate.curvature(name)[f"{one}_order_x"] for one in ("second", "third"))
    assert math.hypot(none.estimate.u[none.estimate.index(name)], term.share) == pytest.approx(
        auto.estimate.u[auto.estimate.index(name)]
    )
    assert other.size == 0.0
    assert auto.estimate.u[auto.estimate.index(name)] > 3.0 * none.estimate.u[none.estimate.index(name)]


@pytest.mark.filterwarnings("error")
def test_a_reading_far_off_gives_terms_without_a_warning() -> None:
    readings = turned((0.01, -0.02, 0.01), noise=1e-4)
    readings.outputs["x"][4] = 100.0
    assert reduce(Plan(), readings).estimate is not None


@pytest.mark.parametrize(
    ("plan", "rates", "code"),
    [(Plan(nonlinearity="none"), RATES, "by_plan"), (Plan(), np.array([-1.0, -0.5, 0.5, 1.0]), "few_rates")],
    ids=["by plan", "two sizes of rate"],
)
def test_a_term_that_is_not_estimated_says_why(plan: Plan, rates: np.ndarray, code: str) -> None:
    rng = np.random.default_rng(2)
    applied, run = np.tile(rates, 4), np.repeat([*"abcd"], len(rates))
    y = applied + 1e-4 * rng.standard_normal(len(applied))
    result = reduce(plan, Readings(applied, np.full(len(y), "x"), {"x": y}, run=run, sensors=("x",)))
    row = next(row for row in result.rows() if str(row.key) == "second_order_x" and row.case.plain)
    assert row.status == "not_estimated"
    assert row.reason.code == code


@pytest.mark.parametrize(
    ("labelled", "offset"), [(True, 2e-3), (False, 2e-3), (False, 0.0)], ids=["labelled", "not labelled", "no offsets"]
)
def test_deviations_scatter_as_stated_where_each_recording_has_rates_of_its_own(labelled: bool, offset: float) -> None:
    """A recording at small rates alone: its offset is part of its deviations, and of their uncertainty."""
    sets = ([-1.0, -0.5, -0.2, 0.2, 0.5, 1.0], [-0.9, -0.4, 0.4, 0.9], [-0.3, 0.3], [-0.3, 0.3], [-0.01, 0.01])
    applied, label = np.concatenate(sets), np.repeat([*"abcde"], [len(one) for one in sets])
    rng, found = np.random.default_rng(1), []
    for _ in range(80):
        y = applied + rng.normal(0.0, offset, 5)[np.unique(label, return_inverse=True)[1]] + rng.normal(0.0, 1e-3, 16)
        readings = Readings(applied, np.full(16, "x"), {"x": y}, sensors=("x",), recording=label)
        one = deviations(line(Plan(), replace(readings, run=label) if labelled else readings, "x", asymmetry=False))
        assert one is not None
        found.append(one[1:3])
    means, sigmas = np.array(found).transpose(1, 0, 2)
    ratio = np.sqrt(np.mean(sigmas**2, axis=0)) / np.std(means, axis=0)
    assert ratio.min() > 0.75
    assert 0.9 < np.median(ratio) < 1.15


def test_short_dwells_weigh_less() -> None:
    """The long ones lie on the line; a short one that is off moves it by its share of the samples."""
    applied = np.array([-1.0, -0.5, 0.5, 1.0, 1.0])
    y = applied + np.array([1e-6, -1e-6, 1e-6, -1e-6, 3e-4])
    readings = Readings(
        applied,
        np.full(5, "x"),
        {"x": y},
        {"x": np.full(5, 1e-3)},
        np.array([1e4, 1e4, 1e4, 1e4, 10.0]),
        sensors=("x",),
    )
    weighed = line(Plan(), readings, "x", asymmetry=False).coefficient("M_xx")
    alike = line(Plan(), replace(readings, samples=None), "x", asymmetry=False).coefficient("M_xx")
    assert abs(weighed - 1.0) < 0.01 * abs(alike - 1.0)
