"""The thermal test as a whole: rows, Type B, one path, start-up, remarks, two conditions, published way."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import polynomial
from thermal_sweeps import KNOWN, LATITUDE, path, plan, readings, sweep

from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence, Occasion
from inertialcal.core.results import Row
from inertialcal.physics.earth import OMEGA, earth_rate, level_to_table
from inertialcal.procedures.thermal.against import offset_rows, quantity_of
from inertialcal.procedures.thermal.fit.quantities import earth_along
from inertialcal.procedures.thermal.reduction import (
    Attitude,
    Plan,
    Readings,
    Result,
    Thermometer,
    Truth,
    bias_at,
    reduce,
    simulate,
)
from inertialcal.procedures.thermal.rows import published_fit

CUBIC = (0.03, -3e-3, 1.6e-5, -2e-7)
AT = [-20.0, 0.0, 20.0, 60.0]
CHANNEL = Thermometer(0.0264, -0.5042, 25.7)  # Badescu, Table 2, x
VOLTS = 0.5  # [V] a unit of reading


def cubic(T: Array) -> Array:
    return np.asarray(polynomial.polyval(T - 20.0, CUBIC))


def rows_of(result: Result, quantity: str, condition: str | None = None) -> list[Row]:
    return [r for r in result.rows() if r.quantity == quantity and condition in (None, str(r.case))]


def row(result: Result, quantity: str, condition: str = "") -> Row:
    (found,) = rows_of(result, quantity, condition)
    return found


@pytest.fixture(scope="module")
def result() -> Result:
    given = readings(cubic, gap=0.004, noise=1e-3, offset=0.005)
    return reduce(plan(at=AT, thermometers={"x": CHANNEL}, scale_factor={"x": VOLTS}), given)


def test_every_row_has_an_uncertainty_or_a_reason(result: Result) -> None:
    for one in result.rows():
        if one.status == "estimated":
            assert one.u is not None
            assert one.interval is not None
        else:
            assert one.reason.text


def test_the_bias_at_a_temperature_is_that_of_its_coefficients(result: Result) -> None:
    powers = [row(result, "bias").value] + [row(result, f"bias_temperature_{j}").value for j in (1, 2, 3)]
    for T in AT:
        expected = polynomial.polyval(T - 20.0, np.array(powers, dtype=float))
        assert row(result, "bias", f"{T:g} degC").value == pytest.approx(expected, abs=1e-9)


def test_coefficients_over_volts_are_the_same_polynomial_exactly(result: Result) -> None:
    volts = np.array([row(result, f"bias_voltage_{j}").value for j in range(4)], dtype=float)
    for T in AT:
        v = CHANNEL.voltage + CHANNEL.slope * (T - CHANNEL.temperature)
        reading = polynomial.polyval(v, volts) / VOLTS
        earth = earth_along(result.plan)[0][0]
        assert row(result, "bias", f"{T:g} degC").value == pytest.approx(reading, abs=1e-9), earth
    assert [row(result, f"bias_voltage_{j}").unit for j in range(4)] == ["V", "1", "1/V", "1/V^2"]


def test_a_temperature_beyond_the_ramps_is_not_told() -> None:
    found = reduce(plan(at=[90.0]), readings(cubic, noise=1e-3))
    one = row(found, "bias", "90 degC")
    assert one.status == "not_estimated"
    assert one.reason.code == "outside"


# Type B


def test_earth_rate_is_taken_off_along_the_axes_of_the_body() -> None:
    expected = level_to_table(KNOWN.tilt, KNOWN.azimuth or 0.0) @ earth_rate(LATITUDE)
    known, unknown = earth_along(plan())
    assert known == pytest.approx(expected)
    assert not unknown
    given = readings(lambda T: cubic(T) + expected[0])
    assert row(reduce(plan(), given), "bias").value == pytest.approx(CUBIC[0], abs=1e-5)


def test_an_unknown_attitude_leaves_the_whole_earth_rate_unknown() -> None:
    known, unknown = earth_along(Plan())
    assert not known.any()
    (one,) = unknown.values()
    assert np.sum(one.patterns**2) == pytest.approx(OMEGA**2)
    bias = row(reduce(Plan(), readings(cubic, noise=1e-5)), "bias")
    assert bias.u == pytest.approx(OMEGA / np.sqrt(3.0), rel=0.2)


def test_an_unknown_azimuth_leaves_the_level_part_unknown() -> None:
    known, unknown = earth_along(plan(attitude=Attitude(0.0)))
    assert known == pytest.approx([0.0, 0.0, OMEGA * np.sin(LATITUDE) * 1.0], abs=1e-12)
    (one,) = unknown.values()
    u = np.sqrt(np.sum(one.patterns**2, axis=0))
    assert u == pytest.approx([OMEGA * np.cos(LATITUDE) / np.sqrt(2.0)] * 2 + [0.0], abs=1e-12)


def test_what_is_not_quite_known_of_the_attitude_turns_the_earth_rate_by_as_much() -> None:
    """A turn by a small angle moves a vector by the angle and its part across the axis of the turn."""
    lying = Attitude(0.3, 1e-3, 0.5, 2e-3)
    _, unknown = earth_along(plan(attitude=lying, standards={"site.latitude": Influence(3e-3, "rad")}))
    moved = {source: float(np.sqrt(np.sum(one.patterns**2))) for source, one in unknown.items()}
    assert moved["latitude"] == pytest.approx(3e-3 * OMEGA, rel=1e-6)
    assert moved["azimuth of the body"] == pytest.approx(2e-3 * OMEGA * np.cos(LATITUDE), rel=1e-6)
    assert 0.0 < moved["tilt of the body"] <= 1e-3 * OMEGA


@pytest.mark.parametrize(("standard", "source", "change"), [
    ("thermometer.temperature", "thermometer", lambda one, T: -one * (cubic(T + 1e-3) - cubic(T)) / 1e-3),
    ("converter.reference", "converter reference", lambda one, T: one * cubic(T)),
])  # fmt: skip
def test_a_standard_acts_as_its_error_does(standard: str, source: str, change: Any) -> None:
    """The component of a source is what an error of that size makes of each bias."""
    size = {"thermometer.temperature": 0.5, "converter.reference": 1e-3}[standard]
    stated = plan(at=AT, standards={standard: Influence(size)})
    given = readings(cubic, noise=1e-4)
    found = reduce(stated, given).estimate
    assert found is not None
    part = next(one for one in found.components if one.source == source)
    for T in AT:
        at = found.index(f"bias_x at {T:g} degC")
        assert part.u[at] == pytest.approx(abs(float(change(size, np.array(T)))), rel=0.05)


def test_an_error_of_the_thermometer_does_not_touch_the_coefficients_over_its_volts() -> None:
    stated = {"thermometer.temperature": Influence(0.5)}
    one = plan(thermometers={"x": CHANNEL}, scale_factor={"x": VOLTS}, standards=stated)
    found = reduce(one, readings(cubic, noise=1e-4)).estimate
    assert found is not None
    part = next(c for c in found.components if c.source == "thermometer")
    assert part.u[found.index("bias_voltage_0_x")] == 0.0
    assert part.u[found.index("bias_x")] > 0.0


# One path


@pytest.fixture(scope="module")
def cooling() -> Readings:
    return readings(cubic, points=(67.0, -30.0), gap=0.004, noise=1e-4)


def test_only_cooling_ramps_give_no_bias_midway_but_that_on_the_path(cooling: Readings) -> None:
    found = reduce(plan(at=AT), cooling)
    bias = row(found, "bias")
    assert bias.status == "not_estimated"
    assert bias.reason.code == "one_path"
    on_path = row(found, "bias", "cooling")
    assert on_path.value == pytest.approx(CUBIC[0] - 0.002, abs=2e-4)
    assert row(found, "bias_temperature_1").value == pytest.approx(CUBIC[1], rel=1e-2)  # the shape needs no other path
    assert row(found, "path_difference").status == "not_estimated"
    assert "one_path" in {remark.code for remark in found.remarks}
    assert row(found, "bias", "cooling, 0 degC").value == pytest.approx(float(cubic(np.array(0.0))) - 0.002, abs=3e-4)


def test_a_stated_hysteresis_gives_the_bias_midway_with_half_of_it_as_uncertainty(cooling: Readings) -> None:
    stated = Influence(0.004 / np.sqrt(3.0), "rad/s", distribution="rectangular")
    found = reduce(plan(standards={"sensor.hysteresis": stated}), cooling)
    bias = row(found, "bias")
    assert bias.status == "estimated"
    assert bias.u == pytest.approx(0.002 / np.sqrt(3.0), rel=0.05)
    assert bias.interval is not None
    assert (bias.interval.lo or 0.0) < CUBIC[0] < (bias.interval.hi or 0.0)


# Start-up


def with_start_up(change: float, hold: float, **settings: object) -> Result:
    rng = np.random.default_rng(2)
    sweeps = []
    for number in range(5):
        t, T = path(23.0, -30.0, 67.0, 23.0, hold=hold, interval=5.0)
        y = cubic(T) + change * np.exp(-t / 150.0) + rng.normal(0.0, 1e-3, T.size)
        sweeps.append(sweep(f"r{number}", t, T + rng.normal(0.0, 0.02, T.size), y))
    return reduce(plan(**settings), Readings(tuple(sweeps)))


def test_the_start_up_is_found_and_left_out_until_it_is_below_the_tolerance() -> None:
    found = with_start_up(0.02, 900.0, settled=4e-4)
    expected = 150.0 * np.log(0.02 / 4e-4)
    assert row(found, "warm_up_change").value == pytest.approx(0.02, abs=1e-3)
    assert row(found, "warm_up_time_constant").value == pytest.approx(150.0, rel=0.1)
    cut = row(found, "warm_up_time")
    assert cut.value == pytest.approx(expected, rel=0.1)
    assert found.sensors["x"].cells.left_out["warm_up"] == pytest.approx(5.0 * expected / 5.0, rel=0.1)
    assert "0.0004" in cut.reason.text
    spoken = row(with_start_up(0.02, 900.0, settled=4e-4, unit="deg/s"), "warm_up_time")
    assert spoken.reason.text.endswith("is below 0.0229 deg/s")


def test_a_tenth_of_the_scatter_is_the_tolerance_where_none_is_stated() -> None:
    assert with_start_up(0.02, 900.0).sensors["x"].start_up.settled == pytest.approx(1e-4, rel=0.05)


def test_without_a_hold_the_start_up_cannot_be_told_and_a_given_time_is_taken() -> None:
    found = with_start_up(0.02, 0.0)
    assert row(found, "warm_up_time").status == "not_estimated"
    assert "warm_up_unknown" in {remark.code for remark in found.remarks}
    given = with_start_up(0.02, 0.0, warm_up=600.0)
    assert row(given, "warm_up_time").value == 600.0
    assert given.sensors["x"].cells.left_out["warm_up"] == 5 * 120


def test_a_warm_up_that_is_too_short_is_remarked() -> None:
    found = with_start_up(0.02, 900.0, warm_up=60.0, settled=4e-4)
    assert "warm_up_short" in {remark.code for remark in found.remarks}


def test_nothing_is_left_out_where_there_is_no_start_up() -> None:
    found = with_start_up(0.0, 900.0)
    assert row(found, "warm_up_change").status == "not_estimated"
    assert row(found, "warm_up_time").value == 0.0


# Remarks


def test_few_runs_and_one_run_are_remarked() -> None:
    def codes(runs: int) -> set[str]:
        return {remark.code for remark in reduce(plan(), readings(cubic, runs, noise=1e-3)).remarks}

    assert "few_runs" in codes(3)
    assert "no_runs" in codes(1)
    assert not {"few_runs", "no_runs"} & codes(5)


def test_a_run_with_another_curve_is_named_and_the_rest_is_not() -> None:
    """Axes exchanged, or a sign turned, in one recording of five."""
    given = readings(cubic, noise=1e-3, offset=0.01)
    bad = given.sweeps[2]
    turned = replace(bad, outputs={"x": -bad.outputs["x"]})
    found = reduce(plan(), replace(given, sweeps=(*given.sweeps[:2], turned, *given.sweeps[3:])))
    named = [remark for remark in found.remarks if remark.severity == "error"]
    assert [(remark.code, remark.where) for remark in named] == [("sign_disagrees", "run3.csv")]
    assert not [remark for remark in reduce(plan(), given).remarks if remark.severity == "error"]


def test_a_recording_without_a_ramp_is_named_and_is_no_run() -> None:
    given = readings(cubic, 3, noise=1e-3)
    still = replace(given.sweeps[1], temperature={"x": np.full(len(given.sweeps[1]), 23.0)})
    found = reduce(plan(), replace(given, sweeps=(given.sweeps[0], still, given.sweeps[2])))
    assert [remark.where for remark in found.remarks if remark.code == "still_recording"] == ["run2.csv"]
    assert next(one.what for one in found.remarks if one.code == "few_runs").startswith("2 runs")


def test_relative_to_the_fixture_until_the_thermometer_is_stated() -> None:
    codes = [
        {remark.code for remark in reduce(plan(standards=one), readings(cubic, noise=1e-3)).remarks}
        for one in ({}, {"thermometer.temperature": Influence(0.1)})
    ]
    assert "relative_to_fixture" in codes[0]
    assert "relative_to_fixture" not in codes[1]


# Several sensors, reference voltages, accelerometers


def test_sensors_are_reduced_each_by_its_own_thermometer_and_one_may_fail() -> None:
    given = readings(cubic, noise=1e-3)
    sweeps = tuple(
        replace(
            one,
            outputs={**one.outputs, "y": 2.0 * one.outputs["x"], "z": one.outputs["x"]},
            temperature={**one.temperature, "y": one.temperature["x"] + 3.0, "z": np.full(len(one), 20.0)},
        )
        for one in given.sweeps
    )
    found = reduce(plan(), replace(given, sweeps=sweeps))
    assert set(found.sensors) == {"x", "y"}
    assert found.sensors["y"].law.domain[0] == pytest.approx(found.sensors["x"].law.domain[0] + 3.0, abs=0.1)
    assert "a range of 0" in str(found.reasons["z"])
    assert row_of_axis(found, "bias", "z").status == "not_estimated"


def row_of_axis(result: Result, quantity: str, axis: str) -> Row:
    return next(one for one in result.rows() if (one.quantity, one.axis, str(one.case)) == (quantity, axis, ""))


def test_reference_voltage_over_temperature() -> None:
    given = readings(cubic, noise=1e-3)
    sweeps = tuple(
        replace(one, references={"reference_voltage": {"x": 2.5 + 1e-4 * (one.temperature["x"] - 20.0)}})
        for one in given.sweeps
    )
    found = reduce(plan(standards={"converter.reference": Influence(1e-4)}), replace(given, sweeps=sweeps))
    level, slope = row(found, "reference_voltage"), row(found, "reference_voltage_temperature_1")
    assert level.value == pytest.approx(2.5, abs=1e-6)
    assert level.u == pytest.approx(2.5e-4, rel=0.01)
    assert slope.value == pytest.approx(1e-4, rel=1e-3)
    assert (level.unit, slope.unit) == ("V", "V/degC")


def test_of_an_accelerometer_the_constant_is_gravity_too() -> None:
    given = replace(readings(cubic, gap=0.004, noise=1e-3), unit="m/s^2")
    found = reduce(Plan(), given)
    assert row(found, "bias").status == "not_estimated"
    assert row(found, "bias").reason.code == "gravity"
    assert row(found, "bias_temperature_1").unit == "m/s^2/degC"
    assert row(found, "path_difference").value == pytest.approx(0.004, abs=3e-4)
    assert "attitude_unknown" not in {remark.code for remark in found.remarks}


# Two conditions


def offset(T: Array) -> Array:
    return np.asarray(0.05 + 1e-4 * (T - 20.0))


def test_the_offset_of_two_conditions_has_the_scatter_of_both() -> None:
    air = reduce(plan(at=AT, order=3), readings(cubic, noise=1e-3, offset=0.005, seed=1))
    named = replace(vacuum_readings(), sweeps=tuple(replace(s, run=f"v{s.run}") for s in vacuum_readings().sweeps))
    vacuum = reduce(plan(at=AT, order=3), named)
    found = {str(r.case): r for r in offset_rows(vacuum, air, "air", "vacuum_offset") if r.quantity == "vacuum_offset"}
    for T in AT:
        one = found[f"{T:g} degC"]
        first, second = (row(r, "bias", f"{T:g} degC").u or 0.0 for r in (air, vacuum))
        assert one.value == pytest.approx(float(offset(np.array(T))), abs=4.0 * (one.u or 0.0))
        assert one.u == pytest.approx(np.hypot(first, second), rel=1e-6)
        assert 4.0 < (one.dof or 0.0) <= 8.0
    scatter = next(r for r in offset_rows(vacuum, air, "air", "vacuum_offset") if r.quantity.endswith("run_to_run"))
    first, second = (row(r, "scatter_run").value or 0.0 for r in (air, vacuum))
    assert scatter.value == pytest.approx(np.hypot(first, second))


def test_earth_rate_of_two_attitudes_is_no_offset() -> None:
    """The same sensor, turned between the tests."""
    plans = (plan(), plan(attitude=replace(KNOWN, azimuth=2.5)))
    earth = [earth_along(one)[0][0] for one in plans]
    assert abs(earth[0] - earth[1]) > 1e-5

    def reduced(number: int) -> Result:
        return reduce(plans[number], readings(lambda T: cubic(T) + earth[number], noise=1e-9))

    turned, other = reduced(0), reduced(1)
    assert offset_rows(turned, other, "air", "bias_shift")[0].value == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(
    ("mountings", "cancels"), [(("laying 1", "laying 1"), True), (("laying 1", "laying 2"), False), (("", ""), False)]
)
def test_an_attitude_is_the_same_in_one_mounting_alone(mountings: tuple[str, str], cancels: bool) -> None:
    """How far the body stands from its attitude is one error in one mounting, and two where nobody says so."""
    stands = plan(attitude=replace(KNOWN, u=0.05, u_azimuth=0.0))
    air = reduce(stands, readings(cubic, noise=1e-9, seed=1))
    other = readings(cubic, noise=1e-9, seed=2)
    named = replace(other, sweeps=tuple(replace(one, run=f"v{one.run}") for one in other.sweeps))
    vacuum = reduce(stands, named)
    one, two = (Occasion(mounting=word) for word in mountings)
    found = offset_rows(vacuum, air, "air", "vacuum_offset", (one, two))[0]
    tilt = float(np.linalg.norm(earth_along(stands)[1]["tilt of the body"].patterns[:, 0]))
    assert tilt > 1e-7
    assert found.u is not None
    assert found.u == pytest.approx(0.0 if cancels else np.sqrt(2.0) * tilt, rel=0.02, abs=0.02 * tilt)


def vacuum_readings() -> Readings:
    return readings(lambda T: cubic(T) + offset(T), noise=1e-3, offset=0.005, seed=2)


def test_power_ups_that_are_in_both_tests_cancel() -> None:
    """The same runs, pumped down without a new power-up: their offsets are in both."""
    air = readings(cubic, noise=1e-4, offset=0.02, seed=3)
    both = replace(
        air,
        sweeps=tuple(
            replace(one, outputs={"x": one.outputs["x"] + offset(one.temperature["x"])}, name=f"v{one.name}")
            for one in air.sweeps
        ),
    )
    vacuum, plain = (reduce(plan(), one) for one in (both, air))
    found = offset_rows(vacuum, plain, "air", "vacuum_offset")[0]
    assert found.value == pytest.approx(0.05, abs=1e-4)
    assert (found.u or 1.0) < 0.02 * (row(vacuum, "bias").u or 0.0)


def test_the_word_for_an_offset() -> None:
    assert (quantity_of("vacuum"), quantity_of("after vibration")) == ("vacuum_offset", "bias_shift")


# As published


def test_the_published_way_is_one_unweighted_cubic_in_volts(result: Result) -> None:
    """Against polyfit of all samples, residual sum and adjusted R-square by their definitions."""
    one = result.sensors["x"]
    found = published_fit(result.plan, one.series, 0.0)
    assert found is not None
    T, y = one.series.temperature, one.series.reading * VOLTS
    v = CHANNEL.voltage + CHANNEL.slope * (T - CHANNEL.temperature)
    expected = polynomial.polyfit(v, y, 3)
    assert found.polynomial.monomials(0.0)[0] == pytest.approx(expected, rel=1e-6)
    rss = float(np.sum((y - polynomial.polyval(v, expected)) ** 2))
    assert found.residual_sum_of_squares == pytest.approx(rss, rel=1e-9)
    n = len(y)
    r2 = 1.0 - (rss / (n - 4)) / (float(np.sum((y - y.mean()) ** 2)) / (n - 1))
    assert found.adjusted_r_square == pytest.approx(r2, rel=1e-9)
    rows = {r.quantity: r for r in result.rows() if str(r.case) == "as_published"}
    assert rows["residual_sum_of_squares"].unit == "V^2"
    assert rows["bias_voltage_3"].value == pytest.approx(expected[3], rel=1e-6)


def test_published_standard_errors_are_far_too_small() -> None:
    """What repeats within a run does not repeat between power-ups."""
    found = reduce(plan(), simulate(plan(), Truth(), np.random.default_rng(1)))
    published = row(found, "bias", "as_published").u or 0.0
    assert (row(found, "bias").u or 0.0) > 10.0 * published


# Estimate and curves


def test_the_estimate_and_the_rows_agree(result: Result) -> None:
    estimate = result.estimate
    assert estimate is not None
    for one in result.rows():
        name = f"{one.quantity}_{one.axis}" + (f" at {one.case}" if str(one.case) else "")
        if name in estimate.names:
            i = estimate.index(name)
            assert (one.value, one.u) == (float(estimate.values[i]), float(estimate.u[i]))


def test_curves_are_what_the_rows_say(result: Result) -> None:
    curves = {curve.name: curve.columns for curve in result.curves()}
    law = curves["thermal_law"]
    at = np.asarray(law["temperature"].values)
    found = bias_at(result.plan, result.sensors["x"].law, "x", "rad/s", at)
    assert found is not None
    assert np.asarray(law["bias"].values) == pytest.approx(found.values)
    assert np.asarray(law["u"].values) == pytest.approx(found.u)
    assert sum(curves["thermal_order"]["chosen"].values) == 1
    cells = curves["thermal_cells"]
    gap = np.asarray(cells["residual"].values)[np.asarray(cells["path"].values) == "warming"].mean()
    assert gap == pytest.approx(0.002, abs=2e-4)


def test_the_result_prints_and_knows_its_runs(result: Result) -> None:
    shown = str(result)
    assert "thermal: 5 recording(s), 5 run(s)" in shown
    assert "path_difference" in shown
    assert "<table" in result._repr_html_()
