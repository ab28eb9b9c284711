"""Dwells of recordings of a turned head: windows, statistics, settling, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.core.remarks import Remark
from inertialcal.procedures.flip.dwells.quiet import Window
from inertialcal.procedures.flip.dwells.recordings import FlipRecording, half_widths, low_passed, readings_from
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.readings import Readings
from inertialcal.procedures.flip.reduction import reduce
from inertialcal.statistics.intervals import coverage_factor

INTERVAL = 0.04  # [s]
RECORD = 1500.0
STAMPS: Array = np.asarray(np.arange(round(RECORD / INTERVAL)) * INTERVAL, dtype=np.float64)
ORIGIN = 5 * SECOND
TURN = 750.0
G = {"x": 0.0, "y": -5.0, "z": 4.0}
B = {"x": 10.0, "y": 980.0, "z": -1250.0}
LONG = ((400.0, 740.0, 0.0), (760.0, 1100.0, math.pi))


def signal(axis: str, noise: float = 1.0) -> Array:
    sign = 1.0 if axis == "x" else np.where(STAMPS < TURN, 1.0, -1.0)
    level = B[axis] + G[axis] * sign
    spike = np.where(np.abs(STAMPS - TURN) < 5.0, 500.0, 0.0)
    return np.asarray(level + spike + noise * np.random.default_rng(ord(axis)).normal(size=len(STAMPS)))


def recording(**data: Array) -> Recording:
    channels = tuple(Channel(name, values, "m/s^2") for name, values in data.items())
    time = np.asarray(np.round(STAMPS * SECOND), dtype=np.int64) + ORIGIN
    return Recording(channels, time, INTERVAL, remarks=(Remark("at_rails", "warning", "12 counts at the rails"),))


def head(**changes: Array) -> Recording:
    return recording(**{axis: changes.get(axis, signal(axis)) for axis in "xyz"})


def placed(*given: tuple[float, float, float]) -> tuple[Window, ...]:
    return tuple(Window(ORIGIN + round(a * SECOND), ORIGIN + round(b * SECOND), angle) for a, b, angle in given)


def read(plan: Plan, *given: tuple[float, float, float], of: Recording | None = None) -> Readings:
    return readings_from(plan, [FlipRecording(of or head(), placed(*(given or LONG)), name="head")])


def samples(axis: str, start: float, stop: float) -> Array:
    first, last = np.searchsorted(STAMPS, (start - 0.01, stop - 0.01))
    return signal(axis)[first:last]


def test_means_and_medians_are_those_of_the_samples_after_settling() -> None:
    readings = read(Plan(settle=20.0))
    for i, (start, stop, _) in enumerate(LONG):
        own = samples("y", start + 20.0, stop)
        assert readings.outputs["y"][i] == pytest.approx(own.mean())
        assert readings.others["median"]["y"][i] == pytest.approx(np.median(own))
    told = [one for one in readings.remarks if one.code == "settling"]
    assert (told[0].count, told[0].what) == (2, "20 s left out at the start of each window")


def test_bias_and_ambient_acceleration_come_out_of_a_recording() -> None:
    result = reduce(Plan(), read(Plan()))
    assert result.estimate is not None
    for axis in "yz":
        for name, truth in (("bias", B), ("ambient_acceleration", G)):
            at = result.estimate.index(f"{name}_{axis}")
            assert abs(result.estimate.values[at] - truth[axis]) < 4.0 * result.estimate.u[at]
            white = math.sqrt(2.0 / (340.0 / INTERVAL)) / 2.0  # of the half difference of both windows
            assert white / 4.0 < result.estimate.u[at] < 4.0 * white  # 148 blocks tell it no better
    assert {str(row.case) for row in result.rows()} == {"", "median", "low_pass", "as_published"}
    assert {"at_rails", "short_record"} <= {one.code for one in result.remarks}
    assert [curve.name for curve in result.curves()] == ["flip_dwells"] * 3 + ["quiet"] * 3 + ["turns"]


def test_the_spike_of_the_turn_is_not_in_the_noise() -> None:
    quiet = read(Plan()).quiet[0]
    assert not np.any((quiet.times > 740.0) & (quiet.times < 760.0))
    assert max(np.abs(quiet.means["y"] - B["y"])) < 10.0
    assert np.all(quiet.angle == np.where(quiet.times < TURN, 0.0, math.pi))
    assert quiet.weights.sum(axis=1) == pytest.approx([1.0, 1.0])


def test_a_long_record_is_cut_to_the_blocks_about_its_windows() -> None:
    short = ((700.0, 740.0, 0.0), (760.0, 800.0, math.pi))
    times = readings_from(Plan(block=1.0), [FlipRecording(head(), placed(*short))]).quiet[0].times
    assert len(times) == 720
    assert (times < 700.0).sum() == pytest.approx((times > 800.0).sum(), abs=1)


def test_blocks_are_longer_where_windows_are_long_beside_what_is_kept() -> None:
    quiet = readings_from(Plan(block=1.0), [FlipRecording(head(), placed(*LONG))]).quiet[0]
    assert len(quiet.times) <= 720
    assert quiet.length == pytest.approx((1500.0 - 20.0) / 720.0, rel=0.01)
    assert (quiet.times.min(), quiet.times.max()) == pytest.approx((0.0, 1500.0), abs=5.0)  # nothing was cut


def test_the_low_pass_passes_what_is_slow_and_settles_first() -> None:
    long: Array = np.arange(0.02, 2000.0, INTERVAL, dtype=np.float64)
    kept = (long > 100.0) & (long < 1900.0)
    assert low_passed(long, np.full(len(long), 7.0), 0.01, INTERVAL) == pytest.approx((7.0, 200.0))
    for f, gain in ((0.001, 1.0 / (1.0 + 0.1**4)), (0.03, 1.0 / (1.0 + 3.0**4))):
        wave = np.sin(2.0 * math.pi * f * (long - 1000.0)) + np.cos(2.0 * math.pi * f * (long - 950.0))
        found = low_passed(long, wave, 0.01, INTERVAL)[0]
        assert found == pytest.approx(gain * wave[kept].mean(), abs=5e-3)


def test_a_missing_sample_changes_the_low_pass_little_and_a_short_window_is_refused() -> None:
    long = np.arange(0.02, 400.0, INTERVAL)
    ramp = long.copy()
    ramp[1000:1100] = np.nan
    assert low_passed(long, ramp, 0.01, INTERVAL)[0] == pytest.approx(200.0, abs=1.0)
    with pytest.raises(DataError, match="a window of 200 s is not longer than the 200 s in which the low-pass settles"):
        low_passed(long[:5000], ramp[:5000], 0.01, INTERVAL)


def test_a_window_too_short_for_the_low_pass_has_the_other_statistics() -> None:
    result = reduce(Plan(), read(Plan(), (600.0, 740.0, 0.0), (760.0, 900.0, math.pi)))
    rows = [row for row in result.rows() if str(row.case) == "low_pass"]
    assert rows
    assert all(row.status == "not_estimated" and "the low-pass settles" in row.reason.text for row in rows)
    assert [row.value for row in result.rows() if str(row.case) == "median" and row.quantity == "bias"]


def test_half_widths_are_t_intervals_of_ten_means_of_six_seconds() -> None:
    readings = read(Plan())
    means = samples("y", 400.0, 460.0).reshape(10, 150).mean(axis=1)
    scatter = means.std(ddof=1) / math.sqrt(10)
    for one, p in zip(readings.half_widths, (0.95, 0.99), strict=True):
        assert one.p == p
        assert one.values["y"][0] == pytest.approx(coverage_factor(9.0, p) * scatter)
    ratio = readings.half_widths[1].values["y"] / readings.half_widths[0].values["y"]
    assert ratio == pytest.approx(1.4366, abs=1e-4)  # errata.csv: ten subsets
    assert np.isnan(half_widths(STAMPS[:1000], signal("y")[:1000], 6.0, 10, INTERVAL)).all()


def test_a_window_at_the_rails_is_not_read_by_that_axis() -> None:
    y = signal("y")
    y[(STAMPS > 800.0) & (STAMPS < 900.0)] = np.nan
    plan = Plan(largest_bias=1e4, largest_ambient=1e4)
    readings = read(plan, of=head(y=y))
    assert np.isnan(readings.outputs["y"][1])
    assert np.isfinite(readings.outputs["z"]).all()
    result = reduce(plan, readings)
    codes = {one.code for one in result.remarks}
    assert {"dwell_incomplete", "missing_position", "blocks_incomplete"} <= codes
    row = next(one for one in result.rows() if one.quantity == "reading" and one.axis == "y")
    assert row.value == pytest.approx(B["y"] + G["y"], abs=0.1)
    assert row.u is not None
    assert result.estimate is not None
    whole = reduce(plan, read(plan)).estimate
    assert whole is not None
    for name in ("bias_z", "ambient_acceleration_z"):  # what y lacks takes no noise from z
        assert result.estimate.select([name]).u == pytest.approx(whole.select([name]).u, rel=1e-4)


def test_a_gain_that_changes_inside_a_window_is_found() -> None:
    whole = recording(y=signal("y"), z=signal("z"), gain_y=np.where(STAMPS < 800.0, 10.0, 100.0))
    readings = read(Plan(), of=whole)
    told = next(one for one in readings.remarks if one.code == "gain_changed")
    assert told.what == "the gain changes from 10 to 100 inside the window: y is not read"
    assert told.where == "head: 760 to 1100 s"
    assert np.isnan(readings.outputs["y"][1])
    assert np.isfinite(readings.outputs["z"]).all()


def test_temperatures_are_the_mean_of_each_window() -> None:
    whole = recording(y=signal("y"), z=signal("z"), temperature=STAMPS / 100.0, temperature_z=STAMPS / 50.0)
    readings = read(Plan(), of=whole)
    assert readings.temperature["y"] == pytest.approx([5.7, 9.3], abs=INTERVAL / 100.0)
    assert readings.temperature["z"] == pytest.approx([11.4, 18.6], abs=INTERVAL / 50.0)


def test_what_cannot_be_read_is_refused() -> None:
    short = (600.0, 610.0, 0.0)
    with pytest.raises(DataError, match="window 600 to 610 s is no longer than the 20 s of settling") as told:
        read(Plan(settle=20.0), short, (760.0, 900.0, math.pi))
    assert told.value.problems[0].code == "shorter_than_settling"
    with pytest.raises(DataError, match=r"window 2000 to 2100 s holds 0 sample\(s\).* runs from 0 to 1499"):
        read(Plan(), (2000.0, 2100.0, 0.0))
    with pytest.raises(DataError, match="no windows"):
        readings_from(Plan(), [FlipRecording(head())])
    with pytest.raises(DataError, match="no recordings"):
        readings_from(Plan(), [])
    with pytest.raises(DataError, match=r"no channel x, y or z.* The recording has: temperature"):
        read(Plan(), of=recording(temperature=STAMPS))
    with pytest.raises(DataError, match="no time: windows cannot be placed"):
        read(Plan(), of=replace(head(), time_ns=None))
    with pytest.raises(PlanError, match="ends before it starts"):
        read(Plan(), (700.0, 600.0, 0.0))
    with pytest.raises(PlanError, match="overlap"):
        read(Plan(), (500.0, 700.0, 0.0), (600.0, 800.0, math.pi))
    with pytest.raises(PlanError, match=r"plan.block is 0\. Need a number above 0"):
        read(Plan(block=0.0))
    with pytest.raises(PlanError, match=r"plan.settle is -1 s"):
        read(Plan(settle=-1.0))
