"""Noise of a sensor at rest: truth found again, what is in the way is named, and nothing is dropped in silence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.core.recording import SECOND, Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Row
from inertialcal.procedures.static_noise import reduction as noise
from inertialcal.procedures.static_noise.planning.record_length import Reach, sentence
from inertialcal.sensors.noise.fitting.noise_fit import duration
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    RandomWalk,
    RateRandomWalk,
    Sinusoid,
    Term,
)
from inertialcal.statistics.intervals import contains, covers

GYRO = noise.Plan(kind="gyro")
WALK, FLICKER, RATE_WALK = 7e-5, 5e-5, 2e-5  # rad/sqrt(s), rad/s, rad/s/sqrt(s)
ROUNDING = 1e-9


def records(terms: Mapping[str, tuple[Term, ...]], seed: int = 1, samples: int = 20_000, **more: Any) -> noise.Readings:
    truth = noise.Truth(terms, samples, **({"interval": 0.02} | more))
    return noise.simulate(GYRO, truth, np.random.default_rng(seed))


def white(seed: int = 1, samples: int = 20_000) -> NDArray[np.float64]:
    return np.asarray(records({"x": (RandomWalk(WALK),)}, seed, samples).records[0].values["x"])


def recording(values: NDArray[Any], interval: float = 0.02, time_ns: NDArray[np.int64] | None = None) -> Recording:
    channels = (Channel("gx", values, "rad/s", "header", "x", "gyro"),)
    return Recording(channels, time_ns, interval, interval_from="column", time_column="t")


def stamps(n: int, interval: float = 0.02) -> NDArray[np.int64]:
    return np.asarray(np.rint(np.arange(n) * interval * SECOND), dtype=np.int64)


def reduced(values: NDArray[Any], plan: noise.Plan = GYRO, **more: Any) -> noise.Result:
    at_rest = noise.AtRest(recording(values, **more), {"x": "gx"}, name="r")
    return noise.reduce(plan, noise.readings_from(plan, [at_rest]))


def row_of(found: noise.Result, quantity: str, axis: str = "x", condition: str = "") -> Row:
    return next(r for r in found.rows() if (r.quantity, r.axis, str(r.case)) == (quantity, axis, condition))


def told(found: noise.Result, code: str) -> Remark:
    return next(one for one in found.remarks if one.code == code)


def codes(found: noise.Result) -> set[str]:
    return {one.code for one in found.remarks}


# Truth found again


def test_terms_of_averages_with_dead_time_are_found_in_their_intervals() -> None:
    terms: dict[str, tuple[Term, ...]] = {
        "x": (RandomWalk(WALK), BiasInstability(FLICKER)), "y": (RandomWalk(WALK), RateRandomWalk(RATE_WALK))
    }  # fmt: skip
    found = noise.reduce(GYRO, records(terms, seed=3, interval=2.0, averaging=1.0, samples=40_000))
    truth = {("angle_random_walk", "x"): WALK, ("angle_random_walk", "y"): WALK, ("bias_instability", "x"): FLICKER,
             ("rate_random_walk", "y"): RATE_WALK}  # fmt: skip
    named = {(r.quantity, r.axis) for r in found.rows() if r.status == "estimated"}
    assert set(truth) - named <= {("angle_random_walk", "y")}  # 2 s apart, the walk hides most of it
    for (quantity, axis), value in truth.items():
        interval = row_of(found, quantity, axis).interval
        assert interval is not None
        assert contains(interval, value), (quantity, axis, interval)
    assert "dead_time" in codes(found)


def test_read_as_contiguous_the_same_averages_seem_rougher_by_the_root_of_two() -> None:
    readings = records({"x": (RandomWalk(WALK),)}, interval=2.0, averaging=1.0)
    unsaid = replace(readings, records=(replace(readings.records[0], averaging=None),))
    right, wrong = (row_of(noise.reduce(GYRO, one), "angle_random_walk").value for one in (readings, unsaid))
    assert right is not None
    assert wrong is not None
    assert wrong / right == pytest.approx(np.sqrt(2.0), rel=1e-3)


def test_the_accelerometer_has_words_of_its_own() -> None:
    plan = noise.Plan(kind="accelerometer")
    found = noise.reduce(plan, records({"x": (RandomWalk(1e-3), RateRandomWalk(1e-4))}))
    assert {r.quantity for r in found.rows() if r.status == "estimated"} >= {
        "velocity_random_walk", "acceleration_random_walk",
    }  # fmt: skip


def test_terms_that_are_asked_for_are_fitted_and_no_others() -> None:
    plan = replace(GYRO, terms=["random_walk", "bias_instability"])
    found = noise.reduce(plan, records({"x": (RandomWalk(WALK), BiasInstability(FLICKER))}))
    assert [r.quantity for r in found.rows()] == ["angle_random_walk", "bias_instability"]


def test_whole_numbers_in_the_unit_of_the_file_are_summed_exactly() -> None:
    codes_of = np.rint(white() / 1e-6).astype(np.int16)
    plan = noise.Plan(kind=None, unit="count")
    found = noise.reduce(plan, noise.readings_from(plan, [noise.AtRest(recording(codes_of), {"x": "gx"}, name="r")]))
    assert found.readings.records[0].values["x"].dtype == np.int16
    floats = reduced(codes_of * 1e-6)
    walk = row_of(found, "random_walk").value
    assert walk is not None
    assert walk * 1e-6 == pytest.approx(row_of(floats, "angle_random_walk").value)


@pytest.mark.parametrize("quantity", ["increment", "angle"])
def test_increments_and_angles_are_the_same_rate(quantity: Any) -> None:
    rate = white()
    values = rate * 0.02 if quantity == "increment" else np.concatenate([[0.0], np.cumsum(rate * 0.02)])
    at_rest = noise.AtRest(recording(values), {"x": "gx"}, quantity=quantity, name="r")
    found = noise.reduce(GYRO, noise.readings_from(GYRO, [at_rest]))
    expected = row_of(reduced(rate), "angle_random_walk").value
    assert row_of(found, "angle_random_walk").value == pytest.approx(expected, rel=1e-6)


def test_unsigned_angles_may_step_back() -> None:
    angle = (100 + np.cumsum(np.rint(white() * 1e6))).astype(np.int64)
    angle -= angle.min()
    at_rest = [noise.AtRest(recording(angle.astype(kind)), {"x": "gx"}, "angle", "r") for kind in (np.int64, np.uint32)]
    one, other = (noise.reduce(GYRO, noise.readings_from(GYRO, [each])).rows() for each in at_rest)
    assert [r.value for r in one] == [r.value for r in other]


# What is in the way


def test_a_disturbance_is_left_out_counted_and_leaves_the_terms_as_they_were() -> None:
    clean = white()
    knocked = clean.copy()
    knocked[8000:8200] += 2e-2 * np.sin(np.arange(200) / 4.0)
    found = reduced(knocked)
    undisturbed = row_of(reduced(clean), "angle_random_walk")
    assert undisturbed.value is not None
    assert undisturbed.u is not None
    assert row_of(found, "angle_random_walk").value == pytest.approx(undisturbed.value, abs=undisturbed.u)
    remark = told(found, "disturbed")
    lost = found.axes[0].records[0].looked.left_out
    assert 190 <= lost <= 240
    assert f"excluded: {lost} of 20000 samples" in remark.what
    assert "x: disturbed at 160" in remark.what
    assert "gaps" not in codes(found)  # they are missing on purpose

    kept = reduced(knocked, replace(GYRO, disturbed="keep"))
    assert "kept in" in told(kept, "disturbed").what
    value = row_of(kept, "angle_random_walk").value
    assert value is None or value > 2.0 * undisturbed.value or "terms_do_not_explain" in codes(kept)


def test_a_warm_up_is_remarked_and_left_out_only_when_asked() -> None:
    warming = white() + 2e-3 * np.exp(-np.arange(20_000) / 3000.0)
    found = reduced(warming)
    remark = told(found, "warm_up")
    assert remark.what.startswith("x: drifts by -")
    assert "deg/h" in remark.what
    assert "warm-up" in remark.do
    cut = reduced(warming, replace(GYRO, warm_up=250.0))
    assert {"warm_up", "drift"}.isdisjoint(codes(cut))
    assert told(cut, "warm_up_left_out").what == "the first 250 s of 400 s left out as warm-up"
    assert len(cut.readings.records[0]) == 7_500


def test_a_line_is_named_takes_part_in_the_fit_and_has_its_figures_from_the_spectrum() -> None:
    line = Sinusoid(2e-3, 9.97)
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK), line)}))
    assert "9.97 Hz" in told(found, "lines").what
    row = row_of(found, "line_amplitude", condition="line at 9.97 Hz")
    assert row.value == pytest.approx(line.amplitude * np.sinc(9.97 * 0.02), rel=0.02)  # of averages over 20 ms
    assert row_of(found, "line_frequency", condition="line at 9.97 Hz").value == pytest.approx(9.97, abs=1e-3)
    assert row_of(found, "angle_random_walk").value == pytest.approx(WALK, rel=0.03)
    assert not any(r.quantity.startswith("sinusoid") for r in found.rows())
    ignored = noise.reduce(replace(GYRO, lines=False), records({"x": (RandomWalk(WALK), line)}))
    assert "lines" not in codes(ignored)
    assert "terms_do_not_explain" in codes(ignored)


def test_missing_samples_are_counted_whether_empty_or_between_the_stamps() -> None:
    values = white()
    gaps = np.sort(np.random.default_rng(2).choice(20_000, 18_000, replace=False))
    gaps = np.unique(np.concatenate([[0], gaps, [19_999]]))
    lost = 20_000 - len(gaps)
    empty = values.copy()
    empty[np.setdiff1d(np.arange(20_000), gaps)] = np.nan
    by_stamp = reduced(values[gaps], time_ns=stamps(20_000)[gaps])
    by_nan = reduced(empty, time_ns=stamps(20_000))
    for found in (by_stamp, by_nan):
        assert f"{lost} of 20000 samples are missing" in told(found, "gaps").what
    assert row_of(by_stamp, "angle_random_walk").value == pytest.approx(
        row_of(by_nan, "angle_random_walk").value, rel=ROUNDING
    )


def test_a_constant_axis_has_no_terms_and_the_others_have() -> None:
    readings = records({"x": (RandomWalk(WALK),), "y": (RandomWalk(WALK),)})
    run = readings.records[0]
    stuck = replace(run, values={"x": run.values["x"], "y": np.full(20_000, 0.25)})
    found = noise.reduce(GYRO, replace(readings, records=(stuck,)))
    assert row_of(found, "angle_random_walk").status == "estimated"
    missing = [r for r in found.rows() if r.axis == "y"]
    assert {r.status for r in missing} == {"not_estimated"}
    assert {r.quantity for r in missing} >= {"angle_random_walk", "bias_instability", "rate_random_walk"}
    assert all("zero throughout" in r.reason.text for r in missing)
    assert "y: all samples are equal" in told(found, "constant").what


STEP = 5e-5  # rad/s, of a converter


def test_a_stuck_stretch_is_left_out_with_its_time_row_and_unit() -> None:
    values = np.rint(white(samples=6_000) / STEP) * STEP
    whole = row_of(reduced(values), "angle_random_walk")
    values[2_000:3_000] = 7 * STEP
    file = replace(recording(values, time_ns=stamps(6_000)), first_row=2, source=Source("still.csv"))
    at_rest = noise.AtRest(file, {"x": "gx"}, name="r", shown="deg/s")
    for plan, fate in ((GYRO, "left out"), (replace(GYRO, disturbed="keep"), "kept in")):
        found = noise.reduce(plan, noise.readings_from(plan, [at_rest]))
        remark = told(found, "stuck")
        assert remark.what == f"x: stuck at 0.020054 deg/s for 20 s in all; {fate}"
        assert remark.where == "still.csv:2002"
        assert remark.what.endswith(fate)
        walk = row_of(found, "angle_random_walk")
        if fate == "left out":
            assert found.doubt("x") == walk.reason.text == ""
            assert walk.value == pytest.approx(whole.value, abs=3.0 * (whole.u or 0.0))
            assert "gaps" not in codes(found)  # they are missing on purpose
        else:
            assert walk.reason.code == "in_doubt"
            assert any("in doubt: stuck samples were kept in" in said for _, said in found.sentences())


def test_saturated_samples_are_left_out_and_counted() -> None:
    values = np.clip(np.rint(white(samples=6_000) / STEP) * STEP, -1e-3, 1.2e-3)
    channels = tuple(Channel(f"g{axis}", values, "rad/s", "header", axis, "gyro") for axis in "xy")
    file = Recording(channels, stamps(6_000), 0.02, interval_from="column", time_column="t")
    at_rest = noise.AtRest(file, {"x": "gx", "y": "gy"}, name="r")
    readings = noise.readings_from(GYRO, [at_rest])
    x, y = (one for one in readings.remarks if one.code == "saturated")
    count = sum(int(np.count_nonzero(values == end)) for end in (values.min(), values.max()))
    ends = "at the end of the range, -0.001 rad/s and 0.0012 rad/s; left out"
    assert (x.what, y.what) == tuple(f"{axis}: {count} of 6000 samples lie {ends}" for axis in "xy")
    run = readings.records[0]
    assert run.bad == {axis: {"saturated": count} for axis in "xy"}
    assert int(np.count_nonzero(~run.there("x"))) == count
    assert "cut at the end of the range" in noise.reduce(GYRO, readings).doubt("x")
    (kept,) = noise.readings_from(GYRO, [replace(at_rest, screening=False)]).records
    assert kept.there("x").all()


@pytest.mark.parametrize("off", [1.0, 1.0 + 1e-5, 1.0 - 1e-5, 1.0 + 1e-4, 1.0 - 1e-4])
def test_averages_that_fill_the_interval_by_another_clock_have_no_dead_time(off: float) -> None:
    values = white(samples=2_000)
    file = replace(recording(values, 0.02 * off, stamps(2_000, 0.02 * off)), averaging_time=0.02)
    (run,) = noise.readings_from(GYRO, [noise.AtRest(file, {"x": "gx"}, name="r")]).records
    assert run.averaging == run.interval == pytest.approx(0.02 * off, rel=1e-9)
    stated = replace(file, sample_interval=0.02, averaging_time=0.01)  # both by the clock of the sensor
    (run,) = noise.readings_from(GYRO, [noise.AtRest(stated, {"x": "gx"}, name="r")]).records
    assert run.averaging == pytest.approx(0.5 * run.interval, rel=1e-9)


def test_averages_that_overlap_are_refused_when_they_are_read() -> None:
    file = replace(recording(white(samples=2_000), 0.02, stamps(2_000)), averaging_time=0.03)
    with pytest.raises(DataError, match=r"an averaging time of 0.03 s every 0.02 s") as caught:
        noise.readings_from(GYRO, [noise.AtRest(file, {"x": "gx"}, name="r")])
    assert caught.value.problems[0].code == "averaging_time"


def test_times_of_messages_are_those_of_the_file() -> None:
    knocked = white(samples=6_000)
    knocked[5_000:5_050] += 2e-2 * np.sin(np.arange(50) / 4.0)
    warm = reduced(knocked, replace(GYRO, warm_up=50.0))
    assert "x: disturbed at 100" in told(warm, "disturbed").what  # 5000 samples of 0.02 s, warm-up included
    late = stamps(6_000, 0.025)
    said = replace(recording(knocked, 0.02, late), interval_from="flag")
    found = noise.reduce(GYRO, noise.readings_from(GYRO, [noise.AtRest(said, {"x": "gx"}, name="r")]))
    assert "x: disturbed at 125" in told(found, "disturbed").what


def test_a_fit_that_its_tests_reject_says_so_in_every_figure() -> None:
    one, other = (records({"x": (RandomWalk(w),)}, 1, 6_000).records[0] for w in (WALK, 1.3 * WALK))
    found = noise.reduce(GYRO, noise.Readings((one, replace(other, name="run 2"))))
    assert "the records do not agree" in found.doubt("x")
    assert row_of(found, "angle_random_walk").reason.text == f"in doubt: {found.doubt('x')}"
    assert all("known to" not in said for _, said in found.sentences())
    alone = row_of(found, "angle_random_walk", condition="run run 2 alone")
    assert alone.reason.text == ""


def test_a_record_without_terms_is_left_out_of_several_and_told() -> None:
    good, short = records({"x": (RandomWalk(WALK),)}, 1, 4_000).records[0], records({"x": (RandomWalk(WALK),)}, 2, 6)
    readings = noise.Readings((good, replace(short.records[0], name="short")))
    found = noise.reduce(GYRO, readings)
    assert told(found, "record_not_used").where == "short"
    assert len(found.axes[0].records) == 1
    noise.check(GYRO, readings)
    noise.check(GYRO, short)
    alone = noise.reduce(GYRO, short)
    assert {row.status for row in alone.rows()} == {"not_estimated"}
    assert [curve.name for curve in alone.curves()] == ["allan"]


def test_averaging_times_that_no_record_has_leave_the_terms_as_they_are() -> None:
    readings = records({"x": (RandomWalk(WALK),)}, 1, 2_000)
    found = noise.reduce(replace(GYRO, tau=[1e4]), readings)
    assert "octaves are shown" in told(found, "taus_not_shown").what
    assert found.rows() == noise.reduce(GYRO, readings).rows()


def test_missing_samples_are_told_once() -> None:
    values = white(samples=4_000)
    values[1_000:1_100] = np.nan
    found = reduced(values)
    assert sum("100 of 4000 samples are missing" in one.what for one in found.remarks) == 1


def test_three_seconds_give_wide_limits_and_no_wrong_number() -> None:
    found = reduced(white(samples=300), interval=0.01)
    for row in found.rows():
        numbers = [row.value, row.u, *((row.interval.lo, row.interval.hi) if row.interval else ())]
        assert all(number is None or np.isfinite(number) for number in numbers)
    assert row_of(found, "bias_instability").status == "upper_limit"


# Several records


def test_records_that_agree_are_fitted_together_and_each_stands_beside() -> None:
    together = noise.reduce(GYRO, records({"x": (RandomWalk(WALK),)}, runs=3))
    alone = noise.reduce(GYRO, records({"x": (RandomWalk(WALK),)}))
    assert row_of(together, "angle_random_walk").u == pytest.approx(
        (row_of(alone, "angle_random_walk").u or 0.0) / np.sqrt(3.0), rel=0.05
    )
    beside = [r for r in together.rows() if str(r.case)]
    assert {str(r.case) for r in beside} == {f"run run {k} alone" for k in (1, 2, 3)}
    assert all(r.case.beside and r.status == "estimated" for r in beside)
    assert any("the records agree" in one.what for one in together.remarks)


def test_records_that_differ_are_told() -> None:
    one, other = (records({"x": (RandomWalk(walk),)}, seed).records[0] for seed, walk in ((1, WALK), (2, 2 * WALK)))
    found = noise.reduce(GYRO, noise.Readings((one, replace(other, name="run 2"))))
    assert "do not agree" in told(found, "runs_disagree").what


# Uncertainty and record length


def test_the_scale_factor_adds_to_every_size_and_is_shared() -> None:
    readings = records({"x": (RandomWalk(WALK),), "y": (RandomWalk(WALK),)})
    plain = noise.reduce(GYRO, readings)
    standards = {"sensor.scale_factor": Influence(0.03, "1")}
    found = noise.reduce(replace(GYRO, standards=standards), readings)
    before, after = (row_of(one, "angle_random_walk") for one in (plain, found))
    assert after.u == pytest.approx(np.hypot(before.u or 0.0, 0.03 * (before.value or 0.0)))
    assert before.interval is not None
    assert after.interval is not None
    half = np.log((after.interval.hi or 1.0) / (after.value or 1.0))
    assert half == pytest.approx(
        np.hypot(1.96 * 0.03, np.log((before.interval.hi or 1) / (before.value or 1))), rel=1e-3
    )
    estimate = found.estimate
    assert estimate is not None
    i, j = (estimate.index(f"angle_random_walk_{axis}") for axis in "xy")
    correlation = estimate.covariance[i, j] / (estimate.u[i] * estimate.u[j])
    assert correlation == pytest.approx(1.0, abs=0.15)
    assert estimate.u[i] == pytest.approx(after.u)  # covariance and row are of one mind
    assert "relative_to_fixture" in codes(plain) - codes(found)


def test_an_upper_limit_says_which_record_would_show_the_term() -> None:
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK),)}))
    row = row_of(found, "rate_random_walk")
    (axis,) = found.axes
    assert axis.fit is not None
    term = next(one for one in axis.fit.found if "rate_random_walk" in one.words)
    assert term.record_needed is not None
    assert term.record_needed > term.record
    assert row.reason.text == f"record too short; {duration(term.record_needed)} would show it at this limit"


def test_the_averaging_time_of_a_recording_is_taken() -> None:
    values = white()
    one = recording(values, 2.0)
    rows = [
        row_of(
            noise.reduce(GYRO, noise.readings_from(GYRO, [noise.AtRest(own, {"x": "gx"})])), "angle_random_walk"
        ).value
        for own in (one, replace(one, averaging_time=1.0))
    ]
    assert rows[0] == pytest.approx((rows[1] or 0.0) * np.sqrt(2.0), rel=1e-3)  # half of the time is not seen


def test_a_one_sided_bound_lies_inside_the_interval() -> None:
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK), RateRandomWalk(RATE_WALK))}))
    row = row_of(found, "rate_random_walk")
    narrow = found.interval_at(row, 0.90)
    assert row.interval is not None
    assert narrow is not None
    assert (row.interval.lo or 0.0) < (narrow.lo or 0.0) < (row.value or 0.0)
    assert (row.value or 0.0) < (narrow.hi or 0.0) < (row.interval.hi or 0.0)
    assert found.interval_at(row, 0.95) == row.interval


def test_how_long_to_record_is_told_of_every_term() -> None:
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK), RateRandomWalk(RATE_WALK))}))
    (curve,) = (one for one in found.curves() if one.name == "record_length")
    reach = {reach.quantity: reach for reach in noise.reaches(GYRO, found.axes[0])}
    assert list(curve.columns["term"].values) == list(reach)
    known = reach["angle_random_walk"]
    assert known.relative_error is not None
    assert known.relative_error < 0.1
    assert known.needed == known.record == pytest.approx(400.0)
    walk = reach["rate_random_walk"]
    assert walk.relative_error is not None
    assert walk.needed is not None
    assert walk.needed > walk.record * (walk.relative_error / 0.1)  # at least as the number of independent spans
    assert reach["quantization"].relative_error is None
    assert any("record" in said for _, said in found.sentences())


@pytest.mark.parametrize(
    ("reach", "expected"),
    [
        (Reach("random_walk", "angle_random_walk", 0.021, 60.0, 60.0), "angle random walk: known to 2.1 %"),
        (Reach("rate_ramp", "rate_ramp", 0.3, 60.0, 7200.0), "rate ramp: known to 30 %; record 2 h for 10 %"),
        (
            Reach("rate_ramp", "rate_ramp", 0.3, 60.0, None),
            "rate ramp: known to 30 %; no practical record is long enough for 10 %",
        ),
        (
            Reach("rate_ramp", "rate_ramp", None, 60.0, 7200.0, "record too short"),
            "rate ramp: not found, record too short; 2 h would show it at its limit",
        ),
        (Reach("rate_ramp", "rate_ramp", None, 60.0, None, "why"), "rate ramp: not found, why"),
        (Reach("rate_ramp", "rate_ramp", 0.3, 60.0, 7200.0, doubt="it bends"), "rate ramp: in doubt: it bends"),
    ],
)
def test_sentences_say_how_well_and_how_long(reach: Reach, expected: str) -> None:
    assert sentence(reach, 0.1) == expected


# Curves


def test_curves_hold_what_was_measured_and_what_the_terms_give() -> None:
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK), BiasInstability(FLICKER))}))
    curves = {one.name: one for one in found.curves()}
    allan, terms, spectrum = (curves[name].columns for name in ("allan", "allan_terms", "spectrum"))
    tau = np.asarray(allan["tau"].values)
    expected = np.asarray(allan["expected"].values)
    parts = [np.asarray(terms[name].values) for name in ("angle_random_walk", "bias_instability")]
    assert np.allclose(np.hypot(*parts), terms["all"].values)
    assert np.allclose(np.interp(tau, np.asarray(terms["tau"].values), np.asarray(terms["all"].values)), expected,
                       rtol=0.01)  # fmt: skip
    inside = (np.asarray(allan["lo"].values) < expected) & (expected < np.asarray(allan["hi"].values))
    assert np.mean(inside) > 0.8
    assert allan["deviation"].unit == "rad/s"
    assert spectrum["density"].unit == "(rad/s)^2/Hz"
    ratio = np.asarray(spectrum["density"].values) / np.asarray(spectrum["all"].values)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("deviation", [
    "non_overlapping", "modified", "hadamard", "overlapping_hadamard", "total", "modified_total", "hadamard_total",
])  # fmt: skip
def test_other_deviations_are_shown_with_what_the_terms_give_of_them(deviation: Any) -> None:
    plan = replace(GYRO, deviation=deviation, taus="decade")
    readings = records({"x": (RandomWalk(WALK), GaussMarkov(2e-4, 5.0))})
    found = noise.reduce(plan, readings)
    curve = next(one for one in found.curves() if one.name == "allan")
    assert curve.of == deviation
    columns = {name: np.asarray(column.values, dtype=float) for name, column in curve.columns.items()}
    inside = (columns["lo"] < columns["expected"]) & (columns["expected"] < columns["hi"])
    assert np.mean(inside) > 0.75
    assert [r.value for r in found.rows()] == [r.value for r in noise.reduce(GYRO, readings).rows()]


def test_averaging_times_may_be_listed() -> None:
    found = noise.reduce(replace(GYRO, tau=[0.1, 1.0, 10.0]), records({"x": (RandomWalk(WALK),)}))
    curve = next(one for one in found.curves() if one.name == "allan")
    assert np.allclose(curve.columns["tau"].values, [0.1, 1.0, 10.0])


# Invariants


@given(scale=st.floats(1e-6, 1e6), offset=st.floats(-1e3, 1e3))
@settings(max_examples=8)
def test_terms_follow_the_scale_and_never_the_level(scale: float, offset: float) -> None:
    values = white(samples=3000)
    one = {r.quantity: r.value for r in reduced(values).rows() if not str(r.case)}
    other = {r.quantity: r.value for r in reduced(scale * (values + offset * 1e-4)).rows() if not str(r.case)}
    assert one.keys() == other.keys()
    for quantity, value in one.items():
        if value is not None and quantity != "gauss_markov_correlation_time":
            assert other[quantity] == pytest.approx(scale * value, rel=2e-3), quantity


def test_the_order_of_axes_changes_nothing() -> None:
    readings = records({"x": (RandomWalk(WALK),), "y": (RandomWalk(2 * WALK),)})
    run = readings.records[0]
    turned = replace(run, values={axis: run.values[axis] for axis in sorted(run.values, reverse=True)})
    one, other = (
        {(r.quantity, r.axis): r.value for r in noise.reduce(GYRO, noise.Readings((each,))).rows()}
        for each in (run, turned)
    )
    assert one == other


# Refused


@pytest.mark.parametrize(
    ("values", "more", "code", "words"),
    [
        (white(), {"interval": None}, "no_time", "sample interval not known"),
        (white(), {"time_ns": np.concatenate([stamps(10_000), stamps(10_000)])}, "time_backwards", "run backwards"),
        (white(), {"time_ns": np.maximum(stamps(20_000) - 20_000_000, 0)}, "time_repeated", "repeated"),
        (np.full(20_000, np.nan), {}, "all_missing", "no noise terms of x: no valid sample"),
        (np.full(20_000, 3.0), {}, "constant", "no noise terms of x: the Allan deviation is zero"),
        (white() * 1e70, {}, "wrong_value", "no sensor reads so much"),
        (np.array(["a", "b"]), {}, "wrong_column", "holds no numbers"),
    ],
)
def test_what_no_noise_can_be_told_from_is_refused(
    values: NDArray[Any], more: dict[str, Any], code: str, words: str
) -> None:
    with pytest.raises(DataError, match=words) as caught:
        reduced(values, **more)
    assert caught.value.problems[0].code == code


def test_a_stamp_that_is_wrong_is_named_by_its_row() -> None:
    wrong = stamps(20_000)
    wrong[5000] = wrong[4999] - 1
    file = replace(recording(white(), time_ns=wrong), first_row=2)
    with pytest.raises(DataError, match=":5002: 1 stamp"):
        noise.readings_from(GYRO, [noise.AtRest(file, {"x": "gx"}, name="r")])


def test_records_must_be_there_alike_and_longer_than_the_warm_up() -> None:
    with pytest.raises(DataError, match="no recordings"):
        noise.readings_from(GYRO, [])
    with pytest.raises(DataError, match="no record of a sensor"):
        noise.reduce(GYRO, noise.Readings(()))
    one = noise.AtRest(recording(white()), {"x": "gx"}, name="r")
    with pytest.raises(DataError, match="axes y, the first recording has x"):
        noise.readings_from(GYRO, [one, replace(one, channels={"y": "gx"})])
    with pytest.raises(DataError, match="a warm-up of 500 s, the record is 400 s long"):
        noise.readings_from(replace(GYRO, warm_up=500.0), [one])


def test_a_sample_rate_that_was_said_goes_before_stamps_and_what_they_show_is_told() -> None:
    wrong = stamps(20_000)
    wrong[5000:] -= 20_000_000
    said = replace(recording(white(), time_ns=wrong), interval_from="flag")
    found = noise.readings_from(GYRO, [noise.AtRest(said, {"x": "gx"}, name="r")])
    (remark,) = (one for one in found.remarks if one.code == "stamps_not_used")
    assert "1 repeated" in remark.what
    assert remark.severity == "warning"


def test_stamps_of_packets_are_not_taken_for_those_of_samples() -> None:
    bursts = np.repeat(stamps(2_500, 0.16), 8) + np.tile(np.arange(8) * 1000, 2_500)
    packed = replace(recording(white(), time_ns=bursts), sample_interval=0.02)
    found = noise.readings_from(GYRO, [noise.AtRest(packed, {"x": "gx"}, name="r")])
    assert len(found.records[0]) == 20_000
    assert "stamps_not_used" in {one.code for one in found.remarks}


def test_a_record_full_of_gaps_has_terms_and_no_spectrum() -> None:
    values = white()
    values[::20] = np.nan
    found = reduced(values)
    assert row_of(found, "angle_random_walk").value == pytest.approx(WALK, rel=0.05)
    assert "no_spectrum" in codes(found)


def test_results_print_and_name_what_was_not_found() -> None:
    found = noise.reduce(GYRO, records({"x": (RandomWalk(WALK),)}))
    assert "static noise: 1 record, 6.7 min in all" in str(found)
    assert "angle_random_walk" in found._repr_html_()


# Coverage


@pytest.mark.slow
def test_intervals_of_the_whole_procedure_hold_the_truth() -> None:
    rows = [
        row_of(noise.reduce(GYRO, records({"x": (RandomWalk(WALK),)}, seed, samples=2_000)), "angle_random_walk")
        for seed in range(1, 301)
    ]
    held = [contains(row.interval, WALK) for row in rows if row.interval is not None and row.status == "estimated"]
    assert len(held) > 295
    assert covers(sum(held), len(held))
