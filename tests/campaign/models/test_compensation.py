"""A model applied to recordings: which column is which, what else is needed, what is lost is counted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.models.compensation import compensate, model_rows
from inertialcal.campaign.models.find import find_model, load_model
from inertialcal.campaign.models.inputs import taken
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.units import factor
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.compensate import compensate as inverse
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel
from inertialcal.sensors.model.uncertainty import compensated_uncertainty
from inertialcal.statistics.intervals import t_interval

DEG = factor("deg/s", "rad/s")
AXES = ("x", "y")


def model(**rest: Any) -> SensorModel:
    """Two gyros with cross terms and a covariance; bias in temperature if asked for."""
    names = ["bias_x", "bias_y", "scale_factor_error_x", "scale_factor_error_y", "misalignment_xy", "misalignment_yx"]
    values = [1e-3, -2e-3, 0.01, -0.02, 0.003, -0.004]
    units = ["rad/s"] * 2 + ["1"] * 2 + ["rad"] * 2
    covariance = np.diag(np.array([1e-5, 2e-5, 1e-3, 2e-3, 1e-4, 2e-4]) ** 2)
    if rest.pop("in_temperature", False):
        rest["reference_temperature"] = 25.0
        names, values, units = [*names, "bias_temperature_1_x"], [*values, 1e-4], [*units, "rad/s/degC"]
        covariance = np.diag([*np.diag(covariance), 1e-12])
    estimate = Estimate(tuple(names), np.array(values), tuple(units), (Component("scatter", "A", covariance, 7.0),))
    return model_from(estimate, "gyro", AXES, 0.5 / DEG, "V", item=Item(serial="7"), **rest)


def recording(unit: str | None = "deg/s", **rest: Any) -> Recording:
    x, y = np.array([0.0, 1.0, np.nan, -3.0]), np.array([4.0, -1.0, 2.0, 0.5])
    channels = (
        Channel("gyro_x", x, unit, "header", "x", "gyro"),
        Channel("gyro_y", y, unit, "header", "y", "gyro"),
        Channel("acc_x", x, "g", "header", "x", "acc"),
        Channel("temp", np.array([20.0, 25.0, 30.0, 35.0]), "degC", "header", "", "temperature"),
        Channel("n", np.arange(4)),
    )
    stamps = np.array([0, 1, 2, 9]) * 10**9
    return Recording(channels, stamps, source=Source("in.csv"), first_row=2, **rest)


def refused(code: str, words: str, **how: Any) -> None:
    given: dict[str, Any] = {"model": model(), "recording": recording()} | how
    with pytest.raises(DataError, match=words) as caught:
        compensate(**given)
    assert caught.value.problems[0].code == code


def test_true_inputs_stand_in_place_of_readings() -> None:
    raw = recording()
    done = compensate(model(), raw)
    expected = inverse(model(), raw.array(["gyro_x", "gyro_y"]) * DEG) / DEG
    np.testing.assert_allclose(done.array(["gyro_x", "gyro_y"]), expected, rtol=1e-14)
    assert done.names == raw.names
    for name in ("acc_x", "temp", "n"):
        assert done.channel(name) is raw.channel(name)
    assert done.time_ns is raw.time_ns
    assert done.channel("gyro_x").unit == "deg/s"


def test_readings_may_come_in_volts() -> None:
    raw = recording()
    volts = [Channel(f"gyro_{a}", raw.channel(f"gyro_{a}").data * 0.5, "V", "header", a, "gyro") for a in AXES]
    done = compensate(model(), Recording(tuple(volts)))
    in_degrees = compensate(model(), raw).array(["gyro_x", "gyro_y"])
    assert done.channel("gyro_x").unit == "rad/s"
    np.testing.assert_allclose(done.array() / DEG, in_degrees, rtol=1e-13)


def test_uncertainties_in_columns_of_their_own() -> None:
    raw = recording()
    done = compensate(model(), raw, uncertainty=True)
    assert done.names == (*raw.names, "u_gyro_x", "u_gyro_y")
    u = compensated_uncertainty(model(), raw.array(["gyro_x", "gyro_y"]) * DEG) / DEG
    np.testing.assert_allclose(done.array(["u_gyro_x", "u_gyro_y"]), u, rtol=1e-14)
    assert done.channel("u_gyro_x").unit == "deg/s"
    assert "noise_not_included" in {remark.code for remark in done.remarks}
    again = taken(model(), done)  # a column of uncertainties is never taken for an axis
    assert again.columns == {"x": "gyro_x", "y": "gyro_y"}


def test_what_counts_as_exact_is_named() -> None:
    in_temperature = model(in_temperature=True)
    done = compensate(in_temperature, recording(), temperature="temp", uncertainty=True)
    exact = next(remark for remark in done.remarks if remark.code == "counted_as_exact")
    assert exact.what.endswith("bias_temperature_1_y")
    assert exact.count == 1


def test_temperature_from_a_column_or_fixed() -> None:
    raw, cubic = recording(), model(in_temperature=True)
    warm = compensate(cubic, raw, temperature="temp").channel("gyro_y").data
    fixed = [compensate(cubic, raw, temperature=t).channel("gyro_y").data for t in ("25 degC", 25.0, "298.15 K")]
    assert warm[1] == pytest.approx(fixed[0][1], rel=1e-14)  # 25 degC in that row
    assert warm[0] != pytest.approx(fixed[0][0], rel=1e-9)
    for other in fixed[1:]:
        np.testing.assert_allclose(other, fixed[0], rtol=1e-12)


def test_temperature_of_each_sensor() -> None:
    cubic = model(in_temperature=True)
    raw = recording()
    other = Channel("t2", np.array([300.0, 301.0, 302.0, 303.0]), "K")
    both = Recording((*raw.channels, other), raw.time_ns)
    done = compensate(cubic, both, {"temperature_x": "temp", "temperature_y": "t2"})
    readings = raw.array(["gyro_x", "gyro_y"]) * DEG
    temperatures = np.column_stack([raw.channel("temp").data, other.data - 273.15])
    expected = inverse(cubic, readings, temperature=temperatures) / DEG
    np.testing.assert_allclose(done.array(["gyro_x", "gyro_y"]), expected, rtol=1e-12)


def test_other_conditions_come_from_named_columns() -> None:
    plain = model()
    fields: dict[str, Any] = {"kind": "gyro", "axes": AXES, "scale_factor": plain.scale_factor, "output_unit": "V"}
    full = SensorModel(
        **fields, matrix=plain.matrix, bias=plain.bias,
        bias_pressure=np.array([1e-8, 2e-8]), reference_pressure=1e5,
        bias_temperature_rate=np.array([0.1, 0.2]), g_sensitivity=np.full((2, 3), 1e-4),
    )  # fmt: skip
    raw = recording()
    beside = (
        Channel("p", np.array([1.0, 0.9, 1.1, 1.2]) * 1000.0, "hPa"),
        Channel("dt", np.array([1.0, 2.0, 3.0, 4.0]), "K/min"),
        *(Channel(f"f{a}", np.array([1.0, 2.0, 3.0, 4.0]) * i, "g") for i, a in enumerate("xyz")),
    )
    both = Recording((*raw.channels, *beside), raw.time_ns)
    columns = {"pressure": "p", "temperature_rate": "dt", "force_x": "fx", "force_y": "fy", "force_z": "fz"}
    done = compensate(full, both, columns)
    force = np.column_stack([beside[2 + i].data * 9.80665 for i in range(3)])
    expected = inverse(
        full, raw.array(["gyro_x", "gyro_y"]) * DEG, pressure=beside[0].data * 100.0,
        temperature_rate=beside[1].data / 60.0, specific_force=force,
    )  # fmt: skip
    np.testing.assert_allclose(done.array(["gyro_x", "gyro_y"]), expected / DEG, rtol=1e-12)
    refused("missing_condition", "the model needs specific force", model=full, columns={"pressure": "p",
            "temperature_rate": "dt"}, recording=both)  # fmt: skip


def test_what_is_lost_is_counted() -> None:
    done = compensate(model(), recording())
    counted = {remark.code: remark for remark in done.remarks}
    assert (counted["axis_missing"].count, counted["axis_missing"].where) == (1, "in.csv:4")
    assert np.isnan(done.channel("gyro_y").data).tolist() == [False, False, True, False]
    raw = recording()
    warm = Channel("temp", np.array([20.0, np.nan, np.nan, 20.0]), "degC", "header", "", "temperature")
    broken = Recording(tuple(warm if c.name == "temp" else c for c in raw.channels), raw.time_ns)
    lost = {r.code: r for r in compensate(model(in_temperature=True), broken, temperature="temp").remarks}
    assert (lost["condition_missing"].count, lost["condition_missing"].where) == (2, "sample 2")
    assert "axis_missing" not in lost


def test_a_model_that_was_not_judged_says_so_and_what_is_not_used() -> None:
    found = {r.code: r for r in compensate(model(), recording(), {"pressure": "n"}, temperature="temp").remarks}
    assert "unjudged_model" in found
    assert found["condition_not_used"].what.endswith("pressure, temperature")
    assert "unjudged_model" not in {r.code for r in compensate(model(judged=True), recording()).remarks}


def test_bad_input() -> None:
    refused("wrong_serial", "for serial '7', the data are from serial '8'", serial="8")
    refused("no_unit", "unit of column 'gyro_x' not given", recording=recording(None))
    refused("wrong_unit", "column 'gyro_x': the data are in 'g'", recording=recording("g"))
    refused("wrong_column", "no column 'w'", columns={"x": "w"})
    refused("wrong_column", "q=n: the model has no such input", columns={"q": "n"})
    warm, raw = model(in_temperature=True), recording()
    assert taken(warm, raw).columns["temperature"] == "temp"
    other = replace(raw.channel("temp"), name="room")
    for channels in ([one for one in raw.channels if one.name != "temp"], [*raw.channels, other]):
        given = replace(raw, channels=tuple(channels))
        refused("no_temperature", "needs the temperature of the sensor", model=warm, recording=given)
    refused("no_temperature", "'hot' is neither a column nor", model=model(in_temperature=True), temperature="hot")
    refused("no_unit", "unit of column 'n' not given", model=model(in_temperature=True), temperature="n")
    assert compensate(model(), recording(), serial="7").names


def test_a_column_that_could_be_two_things_is_not_taken() -> None:
    raw = recording()
    twice = Recording((*raw.channels, Channel("gyro2_x", np.zeros(4), "deg/s", "header", "x", "gyro")))
    refused("wrong_column", r"2 columns \(gyro_x, gyro2_x\) can be the x axis", recording=twice)
    assert taken(model(), twice, {"x": "gyro2_x"}).columns["x"] == "gyro2_x"
    refused("wrong_column", "no column is clearly the axes x, y of a gyro", recording=Recording(raw.channels[2:]))
    plain = Recording(
        (Channel("x", np.zeros(2), "deg/s", "flag", "x"), Channel("y", np.zeros(2), "rad/s", "flag", "y"))
    )
    assert taken(model(), plain).columns == {"x": "x", "y": "y"}


# The model itself


def test_rows_of_a_model_have_everything_that_results_have() -> None:
    origin = {"bias_x": Provenance("rate_x", ("rt_x",))}
    rows = {f"{row.quantity}_{row.axis}": row for row in model_rows(model(in_temperature=True, provenance=origin))}
    bias = rows["bias_x"]
    assert (bias.value, bias.test) == (1e-3, "rate_x")
    assert bias.u == pytest.approx(1e-5)
    assert bias.dof == pytest.approx(7.0)
    assert bias.interval == t_interval(1e-3, bias.u or 0.0, bias.dof or 0.0)
    missing = rows["bias_temperature_1_y"]
    assert (missing.status, missing.value, missing.u) == ("not_estimated", 0.0, None)
    assert missing.reason


def test_a_model_is_found_by_file_or_campaign(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with pytest.raises(DataError, match="no model here, and no results") as caught:
        load_model(tmp_path)
    assert "inertialcal run" in caught.value.problems[0].do
    (tmp_path / "out/results.json").write_text("{}")
    with pytest.raises(DataError, match="the last run of this campaign gave no model"):
        load_model(tmp_path)
    write_model(tmp_path / "out/model.json", model())
    assert load_model(tmp_path).item.serial == "7"
    assert find_model(tmp_path).data == (tmp_path / "out/model.json").read_bytes()
    assert load_model(tmp_path / "out").item.serial == "7"
    with pytest.raises(DataError, match="no such file"):
        load_model(tmp_path / "gone.json")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DataError, match="not UTF-8"):
        load_model(tmp_path / "bytes.json")
