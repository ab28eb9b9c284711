"""Curves of the rate table: residuals by hand, dwells left out, intervals, traces of recordings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from inertialcal.core.curve import Curve
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.procedures.rate_table.model.closed_loop import compensated_curves
from inertialcal.procedures.rate_table.plan import Attitude
from inertialcal.procedures.rate_table.recordings import RateTableRecording, readings_from
from inertialcal.procedures.rate_table.reduction import (
    Plan,
    Readings,
    Result,
    Truth,
    curves,
    rate_errors,
    reduce,
    simulate,
)
from inertialcal.statistics.intervals import coverage_factor

ROUNDING = 1e-14  # rad/s
MATRIX = np.eye(3) + np.array([[0.004, 0.013, -0.002], [0.0015, -0.005, 0.009], [-0.012, 0.003, 0.006]])
TRUTH = Truth(MATRIX, np.radians([0.02, -0.03, 0.015]), asymmetry=np.array([0.004, 0.0, -0.003]), runs=5)
DWELL, RATES = 20, (0.0, 0.05, -0.05, 0.02, -0.02, 0.0)  # samples; rad/s


def simulated(**changes: Any) -> Result:
    plan = Plan(**changes)
    return reduce(plan, simulate(plan, TRUTH, np.random.default_rng(2)))


def of(found: list[Curve], name: str, axis: str) -> Curve:
    return next(curve for curve in found if (curve.name, curve.axis) == (name, axis))


def column(curve: Curve, name: str) -> np.ndarray:
    return np.array(curve.columns[name].plain(), dtype=float)


def row(result: Result, quantity: str, axis: str) -> float:
    found = next(r for r in result.rows() if (r.quantity, r.axis, str(r.case)) == (quantity, axis, ""))
    assert found.value is not None
    return found.value


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_residual_is_reading_minus_the_line_of_the_rows(axis: str) -> None:
    result = simulated()
    curve = of(curves(result), "input_output", axis)
    x, reading = column(curve, "applied"), column(curve, "reading")
    gain = 1.0 + row(result, "scale_factor_error", axis)
    bend = 0.5 * row(result, "scale_factor_asymmetry", axis) * abs(gain)
    by_hand = reading - (row(result, "bias", axis) + gain * x + bend * np.abs(x))
    np.testing.assert_allclose(column(curve, "residual"), by_hand, atol=ROUNDING)
    assert np.ptp(column(curve, "residual")) < 0.01 * np.ptp(reading)


@pytest.mark.parametrize("plan", [{}, {"attitude": Attitude(0.3), "latitude": 0.6}, {"asymmetry": False}])
def test_residuals_of_used_dwells_are_those_of_the_fit(plan: dict[str, Any]) -> None:
    result = simulated(**plan)
    for axis, one in result.lines.items():
        curve = of(curves(result), "input_output", axis)
        mine = one.readings.axis == axis
        np.testing.assert_allclose(column(curve, "residual"), one.fit.residuals[mine], atol=1e-11)


def test_dwells_left_out_are_there_with_their_rule_and_the_counts_of_the_remarks() -> None:
    whole = simulate(Plan(axis="x"), replace(TRUTH, axes=("x",)), np.random.default_rng(2))
    largest = float(np.max(whole.applied))
    plan = Plan(axis="x", input_range=(-2.0 * largest, 1.0001 * largest))
    outputs = {"x": whole.outputs["x"].copy()}
    scatters = {"x": whole.scatters["x"].copy()}
    outputs["x"][3] = np.nan
    scatters["x"][7] *= 40.0
    readings = replace(whole, outputs=outputs, scatters=scatters)
    result = reduce(plan, readings)
    curve = of(curves(result), "input_output", "x")
    used, reasons = curve.columns["used"].plain(), curve.columns["reason"].plain()
    counts = {remark.code: remark.count for remark in result.remarks}
    assert len(used) == len(readings)
    assert [not reason for reason in reasons] == used
    for code in ("at_rail", "odd_scatter"):
        assert reasons.count(code) == counts[code] > 0
    assert reasons[3] == "not_read"
    assert reasons[7] == "odd_scatter"
    assert curve.columns["reading"].plain()[3] is None
    assert used.count(True) == len(result.lines["x"].readings)
    assert curve.columns["place"].plain() == list(readings.where)
    assert readings.run is not None
    assert curve.columns["run"].plain() == readings.run.tolist()
    assert set(curve.columns["group"].plain()) == {""}


def test_interval_of_a_rate_error_is_t_times_u() -> None:
    result = simulated()
    curve = of(curves(result), "rate_error", "y")
    errors = rate_errors(result.plan, result.readings, result.lines["y"], "dwell_mean")
    assert curve.of == "dwell_mean"
    assert curve.columns["rate"].plain() == [one.applied for one in errors]
    for i, one in enumerate(errors):
        assert one.error is not None
        assert one.u is not None
        half = coverage_factor(one.dof) * one.u
        assert column(curve, "lo")[i] == pytest.approx(one.error - half, rel=1e-12)
        assert column(curve, "hi")[i] == pytest.approx(one.error + half, rel=1e-12)
        assert column(curve, "lo")[i] < one.error < column(curve, "hi")[i]


def test_a_rate_whose_dwells_are_all_left_out_has_no_error() -> None:
    whole = simulate(Plan(axis="x"), replace(TRUTH, axes=("x",)), np.random.default_rng(2))
    largest = float(np.max(whole.applied))
    result = reduce(Plan(axis="x", input_range=(-2.0 * largest, 1.0001 * largest)), whole)
    curve = of(curves(result), "rate_error", "x")
    assert [curve.columns[name].plain()[-1] for name in ("error", "u", "lo", "hi", "dof")] == [None] * 5


def turned(run: int, axis: str = "x", name: str = "") -> RateTableRecording:
    """Recording with a long gap, an extreme sample, and the second dwell without a valid sample in half of it."""
    rng = np.random.default_rng(run)
    commanded = np.repeat(RATES, DWELL)
    n = len(commanded)
    data = {s: 0.001 * run + rng.normal(0.0, 1e-4, n) + (1.01 * commanded if s == axis else 0.0) for s in "xy"}
    data[axis][3 * DWELL] = -1.0  # first of its dwell: dropped there, and still in the picture
    data[axis][DWELL + 2 : DWELL + 12] = np.nan
    time_ns = np.arange(n) * SECOND
    time_ns[4 * DWELL :] += 50 * SECOND
    channels = [Channel(s, values, "rad/s") for s, values in data.items()]
    channels.append(Channel("applied", commanded, "rad/s"))
    channels.append(Channel("temperature", rng.normal(20.0, 1.0, n), "degC"))
    return RateTableRecording(Recording(tuple(channels), time_ns, 1.0), axis, str(run), name=name)


def recorded(zero_reference: bool = False) -> tuple[list[RateTableRecording], Readings, Result]:
    plan = Plan(zero_reference=zero_reference)
    all_turned = [turned(run, axis, f"{axis}_{run}") for run in (1, 2, 3) for axis in "xy"]
    readings = readings_from(plan, all_turned)
    return all_turned, readings, reduce(plan, readings)


def test_traces_have_the_extremes_of_the_channels_that_the_test_uses_and_their_gaps() -> None:
    all_turned, _, result = recorded()
    found = [curve for curve in curves(result) if curve.name == "trace"]
    assert [(c.recording, c.axis) for c in found] == [(one.name, s) for one in all_turned for s in "xy"]
    for curve, one in zip(found, [one for one in all_turned for _ in "xy"], strict=True):
        data = one.recording.channel(curve.axis).data
        lo, hi, time = (column(curve, name) for name in ("lo", "hi", "time"))
        assert len(time) == 6 * DWELL + 50
        assert np.nanmin(lo) == np.nanmin(data)
        assert np.nanmax(hi) == np.nanmax(data)
        assert np.isnan(lo[(time >= 4 * DWELL) & (time < 4 * DWELL + 50)]).all()


@pytest.mark.parametrize("zero_reference", [False, True])
def test_dwells_of_a_recording_with_what_became_of_them(zero_reference: bool) -> None:
    all_turned, readings, result = recorded(zero_reference)
    found = [curve for curve in curves(result) if curve.name == "dwells"]
    assert [(c.recording, c.axis) for c in found] == [(one.name, one.axis) for one in all_turned]
    for curve, one in zip(found, all_turned, strict=True):
        assert column(curve, "applied").tolist() == list(RATES)
        assert curve.columns["reason"].plain() == ["", "dwell_incomplete", "", "", "", ""]
        assert curve.columns["used"].plain() == [True, False, True, True, True, True]
        data, at = one.recording.channel(one.axis).data, one.recording.seconds
        assert at is not None
        starts, stops = column(curve, "start"), column(curve, "stop")
        assert np.all(starts[1:] > stops[:-1])
        for start, stop, level in zip(starts[2:], stops[2:], column(curve, "level")[2:], strict=True):
            assert level == pytest.approx(np.mean(data[(at >= start) & (at <= stop)]), abs=1e-12)
    for axis in "xy":
        reasons = of(curves(result), "input_output", axis).columns["reason"].plain()
        assert reasons.count("dwell_incomplete") == 3
    assert [remark.count for remark in result.remarks if remark.code == "dwell_incomplete"] == [6]
    assert len(readings) == 6 * (5 if not zero_reference else 4) + (0 if zero_reference else 6)


def test_a_dwell_left_out_by_rule_is_so_in_its_recording_too() -> None:
    _, readings, _ = recorded()
    scatters = {s: values.copy() for s, values in readings.scatters.items()}
    own = np.flatnonzero((readings.axis == "y") & (readings.applied == -0.05))
    scatters["y"][own[1]] *= 30.0
    result = reduce(Plan(), replace(readings, scatters=scatters))
    marked = [
        (curve.recording, rate)
        for curve in curves(result)
        if curve.name == "dwells"
        for rate, reason in zip(column(curve, "applied"), curve.columns["reason"].plain(), strict=True)
        if reason == "odd_scatter" and curve.axis == "y"
    ]
    assert ("y_2", -0.05) in marked
    assert ("y_1", -0.05) not in marked


def test_a_dwell_without_one_valid_sample_is_shown_without_level() -> None:
    one = turned(1)
    channels = {channel.name: channel for channel in one.recording.channels}
    data = channels["x"].data.copy()
    data[DWELL : 2 * DWELL] = np.nan
    channels["x"] = replace(channels["x"], data=data)
    gone = replace(one, recording=replace(one.recording, channels=tuple(channels.values())))
    trace = readings_from(Plan(), [gone]).traces[0]
    assert np.isnan(trace.dwells.level).tolist() == [False, True, False, False, False, False]
    assert trace.dwells.row.tolist() == [0, 5, 1, 2, 3, 4]
    assert trace.dwells.start[1] == pytest.approx(DWELL + 1)


def test_a_choice_of_dwells_leaves_the_traces_behind() -> None:
    _, readings, result = recorded()
    assert len(readings.traces) == 6
    assert readings.take(np.ones(len(readings), dtype=bool)).traces == ()
    assert all(one.readings.traces == () for one in result.lines.values())


def test_errors_held_out_have_the_sign_of_what_reads_too_much() -> None:
    result = simulated()
    found = compensated_curves(result.lines, result.readings, lambda r: {s: y - 0.001 for s, y in r.outputs.items()})
    assert [one.axis for one in found] == ["x", "y", "z"]
    for one in found:
        reading = result.readings.outputs[one.axis]
        columns = {name: np.asarray(column.values) for name, column in one.columns.items()}
        applied, raw, left = (columns[name] for name in ("applied", "raw_error", "compensated_error"))
        np.testing.assert_allclose(applied + raw, reading, rtol=1e-12, atol=ROUNDING)
        np.testing.assert_allclose(applied + left, reading - 0.001, rtol=1e-12, atol=ROUNDING)
        assert result.readings.run is not None
        assert list(columns["run"]) == list(result.readings.run)
