"""Noise of files and arrays without a campaign: what is a sensor's, in which unit, and what nobody said."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.campaign.calls.call import Reduced
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.results import Row
from inertialcal.core.units import factor
from inertialcal.procedures import procedure_of
from inertialcal.procedures.static_noise.filters import filter_block
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import RandomWalk, RateRandomWalk

N, INTERVAL = 4_000, 0.01
WALK = 0.24  # deg/sqrt(h)
FALL = 100.0  # ug/sqrt(Hz)


def white(seed: int = 1, n: int = N) -> NDArray[np.float64]:
    size = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    return simulate(RandomWalk(size), n, INTERVAL, np.random.default_rng(seed))


def channel(name: str, data: NDArray[Any], unit: str | None = None, quantity: str = "", axis: str = "") -> Channel:
    return Channel(name, data, unit, "header" if unit else "", axis, quantity)


def recorded(*channels: Channel) -> Recording:
    return Recording(channels, sample_interval=INTERVAL, interval_from="header")


def imu() -> Recording:
    acc = simulate(RandomWalk(FALL * factor("ug/sqrt(Hz)", "m/s/sqrt(s)")), N, INTERVAL, np.random.default_rng(9))
    return recorded(
        *(channel(f"gyro_{a}", np.degrees(white(i)), "deg/s", "gyro", a) for i, a in enumerate("xyz", 1)),
        *(channel(f"acc_{a}", acc + (9.8 if a == "z" else 0.0), "m/s^2", "acc", a) for a in "xyz"),
        channel("temp", np.linspace(20.0, 25.0, N), "degC", "temperature"),
    )


def row_of(found: Reduced, quantity: str, axis: str, test: str) -> Row:
    return next(r for r in found.rows if (r.quantity, r.axis, r.test, str(r.case)) == (quantity, axis, test, ""))


# What is a sensor's


def test_an_imu_is_a_gyro_and_an_accelerometer_in_units_of_data_sheets() -> None:
    found = ic.allan(imu())
    assert [one.id for one in found.tested] == ["gyro", "accelerometer"]
    walk = row_of(found, "angle_random_walk", "x", "gyro")
    assert walk.unit == "deg/sqrt(h)"
    assert walk.value == pytest.approx(WALK, rel=0.05)
    fall = row_of(found, "velocity_random_walk", "z", "accelerometer")
    assert fall.unit == "ug/sqrt(Hz)"
    assert fall.value == pytest.approx(FALL, rel=0.05)
    assert not any("temp" in row.axis for row in found.rows)


def test_channels_are_taken_by_name_and_what_is_left_out_is_said() -> None:
    found = ic.allan(imu(), columns=["gyro_y"])
    assert {row.axis for row in found.rows} == {"y"}
    other = recorded(channel("gyro_x", white(), "rad/s", "gyro", "x"), channel("level", white(2)))
    assert any(one.code == "not_taken" and "level" in one.what for one in ic.allan(other).remarks)
    with pytest.raises(DataError, match="no column 'nobody'"):
        ic.allan(imu(), columns=["nobody"])
    with pytest.raises(DataError, match="no channel can be a gyro's"):
        ic.allan(recorded(channel("temp", white(), "degC", "temperature")))


def test_channels_without_axes_are_x_y_z_in_their_order() -> None:
    found = ic.allan(recorded(channel("a_1", white(), "g", "acc"), channel("a_2", white(), "g", "acc")))
    assert found.columns == {"x": "a_1", "y": "a_2"}
    four = ic.allan(np.stack([white(i) for i in range(4)], axis=1), sample_rate=100.0, units="deg/s")
    assert {(row.test, row.axis) for row in four.rows} == {("gyro", "x"), ("gyro", "y"), ("gyro", "z"), ("gyro_2", "x")}


# Units


def test_without_a_unit_all_is_in_that_of_the_file_with_a_hint() -> None:
    counts = np.rint(white() / white().std() * 20.0 + 600.0).astype(np.int16)
    found = ic.allan(recorded(channel("gyro_x", counts, None, "gyro", "x")))
    walk = row_of(found, "random_walk", "x", "gyro")
    assert walk.unit == "file unit*sqrt(s)"
    assert walk.value == pytest.approx(20.0 * np.sqrt(INTERVAL), rel=0.05)
    assert row_of(found, "bias_instability", "x", "gyro").unit == "file unit"
    assert row_of(found, "rate_ramp", "x", "gyro").unit == "file unit/s"
    remark = next(one for one in found.remarks if one.code == "no_unit")
    assert "(whole numbers up to " in remark.do
    assert remark.do.count("unit") == 1
    assert any(one.code == "taken_as_rate" for one in found.remarks)
    with pytest.raises(DataError, match="no sensor with a known unit"):
        filter_block(found, "kalibr")


def test_counts_are_counts_and_a_scale_factor_makes_rates_of_them() -> None:
    codes = np.rint(np.degrees(white()) * 131.0 * 10.0).astype(np.int32)
    raw = recorded(channel("gyro_x", codes, "count", "gyro", "x"))
    in_counts = ic.allan(raw, quantity="rate")
    assert row_of(in_counts, "random_walk", "x", "gyro").unit == "count*sqrt(s)"
    assert not any(one.code == "taken_as_rate" for one in in_counts.remarks)
    scaled = ic.allan(raw, scale_factor={"gyro": "1310 count/(deg/s)"})
    assert row_of(scaled, "angle_random_walk", "x", "gyro").value == pytest.approx(WALK, rel=0.05)
    by_channel = ic.allan(raw, scale_factor={"gyro": "1 count/(deg/s)", "gyro_x": "1310 count/(deg/s)"})
    assert by_channel.rows == scaled.rows


@pytest.mark.parametrize("quantity", ["increment", "angle"])
def test_what_adds_up_to_a_rate_is_asked_for(quantity: Any) -> None:
    rate = np.degrees(white())
    values = rate * INTERVAL if quantity == "increment" else np.cumsum(rate * INTERVAL)
    file = recorded(channel("angle_x", values, "deg", "gyro", "x"))
    with pytest.raises(UsageError, match="is a sample an increment, or the integral") as caught:
        ic.allan(file)
    assert caught.value.problems[0].code == "no_quantity"
    found = ic.allan(file, quantity=quantity)
    assert row_of(found, "angle_random_walk", "x", "gyro").value == pytest.approx(WALK, rel=0.05)
    assert found.results["curves"][0]["columns"]["deviation"]["unit"] == "deg/s"


@pytest.mark.parametrize(
    ("settings", "error", "words"),
    [
        ({"quantity": "increment"}, UsageError, "is in deg/s: a rate, not an increment"),
        ({"quantity": "phase"}, UsageError, "quantity"),
        (
            {"scale_factor": {"gyro": "2 V/g"}},
            UsageError,
            "scale_factor is given, and the readings are in deg/s already",
        ),
        ({"scale_factor": {"mag": "2 count/(deg/s)"}}, UsageError, "no channel or group"),
        ({"deviation": "theo1"}, UsageError, "deviation"),
        ({"taus": "every"}, UsageError, "taus"),
        ({"terms": ["pink"]}, UsageError, "terms"),
        ({"warm_up": "3"}, UsageError, "warm_up"),
        ({"relative_error": 0.0}, UsageError, "relative_error"),
        ({"averaging": "much"}, UsageError, "averaging"),
        ({"averaging": "1 s"}, DataError, "averaging over 1 s, but samples are 0.01 s apart"),
        ({"warm_up": "1 h"}, DataError, "a warm-up of 3600 s"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_way_out(settings: dict[str, Any], error: Any, words: str) -> None:
    with pytest.raises(error, match=words):
        ic.allan(recorded(channel("gyro_x", np.degrees(white()), "deg/s", "gyro", "x")), **settings)


# Arrays and several records


def test_an_array_has_the_rate_and_unit_that_are_said() -> None:
    values = np.stack([white(1), white(2)], axis=1)
    found = ic.allan(values, sample_rate=1.0 / INTERVAL, units="rad/s")
    assert {row.axis for row in found.rows} == {"x", "y"}
    assert row_of(found, "angle_random_walk", "y", "gyro").value == pytest.approx(WALK, rel=0.05)
    with pytest.raises(DataError, match="an array has no time"):
        ic.allan(values)
    with pytest.raises(DataError, match="array of shape"):
        ic.allan(np.zeros((2, 2, 2)), sample_rate=100.0)


def test_several_recordings_are_fitted_together_and_must_be_alike() -> None:
    one, other = (recorded(channel("gyro_x", white(seed), "rad/s", "gyro", "x")) for seed in (1, 2))
    together = row_of(ic.allan([one, other]), "angle_random_walk", "x", "gyro")
    alone = row_of(ic.allan(one), "angle_random_walk", "x", "gyro")
    assert together.u is not None
    assert alone.u is not None
    assert together.u == pytest.approx(alone.u / np.sqrt(2.0), rel=0.1)
    strange = recorded(channel("gyro_y", white(3), "rad/s", "gyro", "y"))
    with pytest.raises(DataError, match="axes y, the first recording has x"):
        ic.allan([one, strange])
    with pytest.raises(UsageError, match="no file"):
        ic.allan([])


def test_one_sensor_without_terms_leaves_the_other_its_own() -> None:
    file = recorded(channel("gyro_x", white(), "rad/s", "gyro", "x"), channel("acc_x", np.ones(N), "g", "acc", "x"))
    found = ic.allan(file)
    assert [one.id for one in found.tested] == ["gyro"]
    assert any(one.code == "no_result" and one.severity == "error" for one in found.remarks)


# Filters, spectra, files


def test_settings_of_filters_hold_the_terms() -> None:
    size = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    drive = 2e-4
    axes = [
        simulate((RandomWalk(size), RateRandomWalk(drive)), 20_000, INTERVAL, np.random.default_rng(k))
        for k in (1, 2, 3)
    ]
    found = ic.allan(recorded(*(channel(f"gyro_{a}", x, "rad/s", "gyro", a) for a, x in zip("xyz", axes, strict=True))))
    kalibr = {one.key: one.values for one in filter_block(found, "kalibr").settings}
    assert kalibr["gyroscope_noise_density"][0] == pytest.approx(size, rel=0.05)
    assert kalibr["gyroscope_random_walk"][0] == pytest.approx(drive, rel=0.5)
    assert "update_rate: 100" in filter_block(found, "kalibr").text
    assert "MakeSharedU(9.80665)" in filter_block(found, "gtsam").text
    assert "EKF2_GYR_NOISE" in filter_block(found, "px4").text
    assert "arw:" in filter_block(found, "kf-gins").text
    with pytest.raises(UsageError, match="There are: kalibr, px4, gtsam, kf-gins"):
        filter_block(found, "rocket")
    two = ic.allan(recorded(*(channel(f"gyro_{a}", white(), "rad/s", "gyro", a) for a in "xy")))
    with pytest.raises(DataError, match="2 axes of the gyro"):
        filter_block(two, "kalibr")


def test_a_spectrum_has_bands_lines_and_the_check_against_the_allan_deviation() -> None:
    humming = np.degrees(white()) + 0.02 * np.sin(2.0 * np.pi * 20.0 * INTERVAL * np.arange(N))
    found = ic.psd(recorded(channel("gyro_x", humming, "deg/s", "gyro", "x")))
    level = 2.0 * (WALK * factor("deg/sqrt(h)", "deg/sqrt(s)")) ** 2
    (curve,) = (one for one in found.results["curves"] if one["name"] == "spectrum")
    assert curve["columns"]["density"]["unit"] == "(deg/s)^2/Hz"
    assert np.median(curve["columns"]["density"]["values"]) == pytest.approx(level, rel=0.2)
    line = next(row for row in found.rows if row.quantity == "line_amplitude")
    assert line.value == pytest.approx(0.02, rel=0.1)
    tapers = ic.psd(recorded(channel("gyro_x", humming, "deg/s", "gyro", "x")), spectrum="multitaper", segment="5 s")
    assert tapers.plan.segment == 5.0


def test_a_folder_takes_curves_terms_and_settings() -> None:
    found = ic.allan(imu(), for_filter=["kalibr"])
    texts = procedure_of("static_noise").files(found)
    assert set(texts) == {"curves.csv", "terms.json", "imu.yaml"}
    gyro = json.loads(texts["terms.json"])["sensors"][0]
    assert gyro["axes"][0]["terms"][0]["term"] == "random_walk"
    size = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    assert gyro["axes"][0]["terms"][0]["coefficient"] == pytest.approx(size, rel=0.05)
    lines = csv.DictReader(texts["curves.csv"].splitlines())
    points = [one for one in lines if (one["curve"], one["axis"], one["column"]) == ("allan", "x", "deviation")]
    assert points[0]["unit"] == "deg/s"
    assert float(points[0]["at"]) == pytest.approx(INTERVAL)
    assert float(points[0]["value"]) == pytest.approx(float(np.degrees(white(1)).std()), rel=0.1)


def test_figures_of_noise_are_plotted_by_name() -> None:
    found = ic.allan(imu())
    assert "Allan deviation" in ic.plot(found).get_ylabel()
    assert "density" in ic.plot(found, figure="spectrum", test="accelerometer", axis="y").get_ylabel()


def test_the_deviation_and_the_averaging_times_that_are_shown_are_chosen() -> None:
    found = ic.allan(imu(), deviation="hadamard", tau=["0.1 s", "1 s"])
    shown = next(one for one in found.results["curves"] if one["name"] == "allan")
    assert shown["of"] == "hadamard"
    assert shown["columns"]["tau"]["values"] == pytest.approx([0.1, 1.0])


def test_sensors_with_a_stamp_column_each_have_their_own_interval(tmp_path: Path) -> None:
    """Noise is that of each sensor by itself: nothing is joined, nothing interpolated."""
    seconds = np.arange(N) * INTERVAL
    columns = {"acc_time [s]": seconds, "acc_x [m/s2]": white(1), "gyro_time [s]": 1.5 * seconds + 0.003,
               "gyro_x [rad/s]": white(2)}  # fmt: skip
    path = tmp_path / "phone.csv"
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.9f", delimiter=",", header=",".join(columns), comments="")
    walk = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    found = {row.quantity: row for row in ic.allan(path).rows if row.value is not None}
    for quantity, size, unit in (
        ("velocity_random_walk", walk, "m/s^1.5"),
        ("angle_random_walk", walk * np.sqrt(1.5), "rad/sqrt(s)"),
    ):
        row = found[quantity]
        assert row.value == pytest.approx(size / factor(row.unit, unit), rel=0.1)
