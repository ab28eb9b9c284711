"""PX4, ArduPilot and ROS: their equations evaluated by a program that shares nothing, losses with their size, troubles
of their users.

The two firmwares are written out here once more from their equations, number by number in float32, and read the file
with a reader of their own.
"""

from __future__ import annotations

import itertools
import math
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import AXES, Key, Kind, Origin
from inertialcal.files.models.autopilots.offsets import losses, offsets
from inertialcal.files.models.formats import FORMATS, read_models
from inertialcal.files.models.losses import other_losses, words
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_format import ImportedModels, ModelText
from inertialcal.files.models.model_json import dump_model, write_model
from inertialcal.sensors.catalogue import CATALOGUE
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.equation import predict
from inertialcal.sensors.model.sensor_model import INPUT_UNIT, SensorModel

DEG = math.pi / 180.0
AGREEMENT = 1e-6  # deg/s: of a map with the equations of the firmware
POINTS = 2_000


# The firmwares, from their equations


def f32(value: float) -> float:
    """The float32 nearest to a number."""
    return float(struct.unpack("f", struct.pack("f", value))[0])


def parameters(text: str) -> dict[str, float]:
    """Parameters of a file, as the firmware keeps them."""
    found = {}
    for line in text.splitlines():
        if line and not line.startswith("#"):
            cells = line.split("\t")[2:4] if "\t" in line else line.split(",")
            found[cells[0]] = f32(float(cells[1]))
    return found


def clipped(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value


def px4(p: dict[str, float], reading: float, temperature: float, axis: int, letter: str = "G") -> float:
    """x = (r - TC - OFF) SCALE, R being one."""
    word, name = {"G": "GYRO", "A": "ACC"}[letter], f"TC_{letter}0"
    offset = 0.0
    if p.get(f"TC_{letter}_ENABLE"):
        d = f32(clipped(f32(temperature), p[f"{name}_TMIN"], p[f"{name}_TMAX"]) - p[f"{name}_TREF"])
        power = 1.0
        for k in range(4):
            offset = f32(offset + f32(p[f"{name}_X{k}_{axis}"] * power))
            power = f32(power * d)
    off = p.get(f"CAL_{word}0_{'XYZ'[axis]}OFF", 0.0)
    return f32(f32(f32(f32(reading) - offset) - off) * p.get(f"CAL_{word}0_{'XYZ'[axis]}SCALE", 1.0))


def ardupilot(p: dict[str, float], reading: float, temperature: float, axis: int, word: str = "GYR") -> float:
    """x = SCAL (r - [p(T - 35) - p(CALTEMP - 35)] - OFFS)."""
    name = "XYZ"[axis]

    def polynomial(at: float) -> float:
        d = f32(clipped(f32(at), p["INS_TCAL1_TMIN"], p["INS_TCAL1_TMAX"]) - 35.0)
        c1, c2, c3 = (p[f"INS_TCAL1_{word}{k}_{name}"] for k in (1, 2, 3))
        return f32(f32(f32(f32(f32(c3 * d) + c2) * d + c1) * d) * f32(1e-6))

    value = f32(reading)
    if p["INS_TCAL1_ENABLE"]:
        value = f32(value - f32(polynomial(temperature) - polynomial(p[f"INS_{word}1_CALTEMP"])))
    return f32(f32(value - p.get(f"INS_{word}OFFS_{name}", 0.0)) * p.get(f"INS_{word}SCAL_{name}", 1.0))


FIRMWARE = {"px4": px4, "ardupilot": ardupilot}
LETTER = {"px4": {"gyro": "G", "accelerometer": "A"}, "ardupilot": {"gyro": "GYR", "accelerometer": "ACC"}}


def sensor(seed: int = 1, kind: Kind = "gyro", orders: int = 3, low: float = -20.0, high: float = 60.0) -> SensorModel:
    """Sensors that an autopilot can hold whole: no cross terms; gyros of scale factor one; all in SI."""
    rng = np.random.default_rng(seed)
    size = 0.05 * DEG if kind == "gyro" else 0.02
    scale = np.eye(3) if kind == "gyro" else np.diag(1.0 + rng.normal(0.0, 0.02, 3))
    return SensorModel(
        kind, AXES, np.ones(3), INPUT_UNIT[kind], scale, rng.normal(0.0, size, 3),
        bias_temperature=rng.normal(0.0, size, (orders, 3)) / 40.0 ** np.arange(1, orders + 1)[:, np.newaxis],
        reference_temperature=rng.uniform(10.0, 30.0, 3), temperature_range=(low, high),
    )  # fmt: skip


def bias(model: SensorModel, temperature: Array) -> Array:
    """K0 of each sensor at temperatures, shape (n, 3), term by term."""
    assert model.bias_temperature is not None
    assert model.reference_temperature is not None
    away = np.asarray(temperature)[:, np.newaxis] - model.reference_temperature
    total: Array = np.tile(model.bias, (len(away), 1))
    for k, row in enumerate(model.bias_temperature):
        total += row * away ** (k + 1)
    return total


def imported(text: str, where: str = "file.params") -> ImportedModels:
    return read_models(ModelText(text, where))[1]


def points(seed: int, model: SensorModel, largest: float) -> tuple[Array, Array]:
    """True inputs and temperatures, some beyond the range."""
    rng = np.random.default_rng(seed)
    assert model.temperature_range is not None
    low, high = model.temperature_range
    return rng.uniform(-largest, largest, (POINTS, 3)), rng.uniform(low - 5.0, high + 5.0, POINTS)


# Maps against the equations


@pytest.mark.parametrize("seed", range(1, 4))
@pytest.mark.parametrize("name", FIRMWARE)
def test_gyros_agree_with_the_equations_of_the_firmware(name: str, seed: int) -> None:
    model = sensor(seed)
    kept = parameters(FORMATS[name].dump({"gyro": model}))
    x, temperature = points(seed, model, 4.6 * DEG)
    assert model.temperature_range is not None
    readings = x + bias(model, np.clip(temperature, *model.temperature_range))
    found = np.array([[FIRMWARE[name](kept, r, t, i) for i, r in enumerate(row)]
                      for row, t in zip(readings.tolist(), temperature.tolist(), strict=True)])  # fmt: skip
    assert np.max(np.abs(found - x)) / DEG < AGREEMENT


@pytest.mark.parametrize("name", FIRMWARE)
def test_published_model_agrees_apart_from_its_matrix(name: str) -> None:
    whole = CATALOGUE["flight_unit"]().models["corrected"]
    model = replace(whole, matrix=np.eye(3), scale_factor=np.ones(3), output_unit="rad/s")
    kept = parameters(FORMATS[name].dump({"gyro": whole}))
    x, temperature = points(7, model, 4.6 * DEG)
    temperature = np.clip(temperature, *whole.temperature_range)  # type: ignore[misc]
    readings = predict(model, x, temperature=temperature)
    found = np.array([[FIRMWARE[name](kept, r, t, i) for i, r in enumerate(row)]
                      for row, t in zip(readings.tolist(), temperature.tolist(), strict=True)])  # fmt: skip
    assert np.max(np.abs(found - x)) / DEG < AGREEMENT


@pytest.mark.parametrize("name", FIRMWARE)
def test_accelerometers_agree_with_the_equations_of_the_firmware(name: str) -> None:
    model = sensor(4, "accelerometer")
    kept = parameters(FORMATS[name].dump({"accelerometer": model}))
    x, temperature = points(4, model, 20.0)
    readings = predict(model, x, temperature=np.clip(temperature, *model.temperature_range))  # type: ignore[misc]
    word = LETTER[name]["accelerometer"]
    found = np.array([[FIRMWARE[name](kept, r, t, i, word) for i, r in enumerate(row)]
                      for row, t in zip(readings.tolist(), temperature.tolist(), strict=True)])  # fmt: skip
    assert np.max(np.abs(found - x)) < 20.0 * 6e-8 * 4.0  # four roundings of float32


@pytest.mark.parametrize("name", FIRMWARE)
def test_a_bias_that_does_not_change_is_an_offset_and_nothing_thermal(name: str) -> None:
    model = replace(sensor(2), bias_temperature=None, reference_temperature=None)
    kept = parameters(FORMATS[name].dump({"gyro": model}))
    assert not any(value for key, value in kept.items() if key.startswith(("TC_", "INS_TCAL")))
    # the switch of ArduPilot is for both sensors: one alone writes zeros beside it, and the range of the vehicle stays
    assert ("INS_TCAL1_ENABLE" in kept) is False
    kept |= {"INS_TCAL1_ENABLE": 1.0, "INS_TCAL1_TMIN": 0.0, "INS_TCAL1_TMAX": 70.0, "INS_GYR1_CALTEMP": 25.0}
    assert [FIRMWARE[name](kept, 0.01, 90.0, i) for i in range(3)] == pytest.approx(0.01 - model.bias, rel=1e-6)


def test_one_sensor_alone_does_not_switch_off_the_other_nor_move_its_range_in_silence() -> None:
    """ArduPilot has one switch and one range for both sensors."""
    both: dict[Kind, SensorModel] = {
        "gyro": sensor(1), "accelerometer": replace(sensor(2, "accelerometer"), bias_temperature=None)
    }  # fmt: skip
    assert parameters(FORMATS["ardupilot"].dump(both))["INS_TCAL1_ENABLE"] == 1.0
    cold = {kind: replace(one, bias_temperature=None) for kind, one in both.items()}
    assert parameters(FORMATS["ardupilot"].dump(cold))["INS_TCAL1_ENABLE"] == 0.0
    alone = FORMATS["ardupilot"].dump({"gyro": sensor(1)})
    said = "INS_TCAL1_TMIN and INS_TCAL1_TMAX hold for the accelerometers of the vehicle too"
    assert f"# {said}" in alone
    assert said in [one.what for one in FORMATS["ardupilot"].cannot_hold({"gyro": sensor(1)})]
    assert said not in FORMATS["ardupilot"].dump(both)


# There and back


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), orders=st.integers(1, 3), both=st.booleans())
@pytest.mark.parametrize("name", FIRMWARE)
def test_there_and_back_is_the_same_sensor(name: str, seed: int, orders: int, both: bool) -> None:
    models: dict[Kind, SensorModel] = {"gyro": sensor(seed, "gyro", orders)}
    if both:
        models["accelerometer"] = sensor(seed + 1, "accelerometer", orders)
    again = imported(FORMATS[name].dump(models))
    assert not again.remarks
    assert set(again.models) == set(models)
    for kind, model in models.items():
        other, temperature = again.models[kind], np.linspace(-20.0, 60.0, 50)
        x = np.random.default_rng(seed).normal(0.0, 1.0, (50, 3))
        own, theirs = (predict(one, x, temperature=temperature) for one in (model, other))
        np.testing.assert_allclose(theirs, own, atol=4e-7 * float(np.max(np.abs(own))))
        assert other.temperature_range == (-20.0, 60.0)


@pytest.mark.parametrize("name", ["px4", "ardupilot", "ros"])
def test_their_text_read_and_written_says_the_same(name: str) -> None:
    models: dict[Kind, SensorModel] = {"gyro": sensor(3), "accelerometer": sensor(3, "accelerometer")}
    text = FORMATS[name].dump(models)
    again = FORMATS[name].dump(imported(text).models)

    def lines(one: str) -> list[str]:
        return [line for line in one.splitlines() if line and not line.lstrip().startswith("#")]

    if name == "ros":
        first, second = (yaml.safe_load(one)["/**"]["ros__parameters"] for one in (text, again))
        assert first.keys() == second.keys()
        for key, value in first.items():
            np.testing.assert_allclose(second[key], value, rtol=1e-12)
        return
    one, other = parameters(text), parameters(again)
    moved = {key for key in one if "CALTEMP" in key or "OFFS" in key}  # the reference becomes the 35 degC of the file
    assert one.keys() == other.keys()
    for key in one.keys() - moved:
        assert other[key] == pytest.approx(one[key], rel=2e-6, abs=1e-12), key


def test_ros_by_its_equation_and_that_of_imu_calib() -> None:
    rng = np.random.default_rng(2)
    plain = replace(sensor(2, "accelerometer"), bias_temperature=None, reference_temperature=None)
    acc = replace(plain, matrix=np.eye(3) + rng.normal(0.0, 0.02, (3, 3)))
    gyro = replace(sensor(2), bias_temperature=None, reference_temperature=None)
    text = FORMATS["ros"].dump({"accelerometer": acc, "gyro": gyro})
    held = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert held["imu/calibration"] is False, "with it, the node averages at the start and drops these"
    x = rng.normal(0.0, 9.0, (50, 3))
    sm = np.reshape(held["imu/intrinsics/accel/sm"], (3, 3))
    corrected = predict(acc, x) @ sm.T - held["imu/intrinsics/accel/bias"]
    np.testing.assert_allclose(corrected, x, atol=1e-12)
    np.testing.assert_allclose(predict(gyro, x) - held["imu/intrinsics/gyro/bias"], x, atol=1e-12)
    commented = "\n".join(line[2:] for line in text.splitlines() if line.startswith(("# SM:", "# bias:")))
    calib = yaml.safe_load(commented)
    assert (len(calib["SM"]), len(calib["bias"])) == (9, 3)
    (kind, model), *others = imported(commented, "imu_calib.yaml").models.items()
    assert (kind, others) == ("accelerometer", [])
    np.testing.assert_allclose(predict(model, x), predict(acc, x), atol=1e-11)


# What is lost, with its size


def test_order_above_three_is_fitted_anew_and_its_residual_is_the_least_there_is() -> None:
    """A quartic of leading coefficient a, half range h: the least largest error of a cubic is |a| h^4 / 8."""
    model = sensor(5, orders=4)
    held = offsets(model, "PX4")
    assert model.bias_temperature is not None
    np.testing.assert_allclose(held.residual, np.abs(model.bias_temperature[3]) * 40.0**4 / 8.0, rtol=1e-3)


@pytest.mark.parametrize("name", FIRMWARE)
@pytest.mark.parametrize("orders", [4, 5, 7])
def test_the_stated_residual_is_what_the_firmware_leaves(name: str, orders: int) -> None:
    """ArduPilot 27294: a cubic does not follow every sensor, and nothing says by how much."""
    model = sensor(6, orders=orders)
    kept = parameters(FORMATS[name].dump({"gyro": model}))
    temperature = np.linspace(-20.0, 60.0, 4001)
    truth = bias(model, temperature)
    left = np.array([[FIRMWARE[name](kept, truth[n, i], t, i) for i in range(3)]
                     for n, t in enumerate(temperature.tolist())])  # fmt: skip
    stated = offsets(model, name).residual
    np.testing.assert_allclose(np.max(np.abs(left), axis=0), stated, rtol=2e-3, atol=AGREEMENT * DEG)
    text = " ".join(one.what for one in FORMATS[name].cannot_hold({"gyro": model}))
    assert f"beyond order 3 (the model has {orders}; fitted anew)" in text
    shown = words(model, next(one for one in losses(model, name) if "beyond order" in one.what))
    assert shown in text
    assert f"# Not held: {shown}" in FORMATS[name].dump({"gyro": model})
    assert model.bias_temperature is not None
    cut = bias(replace(model, bias_temperature=model.bias_temperature[:3]), temperature)
    assert np.all(np.max(np.abs(truth - cut), axis=0) > 3.0 * stated), "cutting the powers off is worse"


def test_sizes_of_what_is_lost_bound_the_error_at_every_corner() -> None:
    """Each term alone, over all corners of the input: the largest change of a reading is what is stated."""
    rng = np.random.default_rng(8)
    ends = np.array([3.0, 2.0, 1.0])
    terms: dict[str, Any] = {
        "scale_factor_asymmetry": rng.normal(0.0, 1e-3, 3),
        "second_order": rng.normal(0.0, 1e-3, 3),
        "third_order": rng.normal(0.0, 1e-3, 3),
        "g_sensitivity": rng.normal(0.0, 1e-4, (3, 3)),
    }
    bare = SensorModel("gyro", AXES, np.ones(3), "rad/s", np.eye(3), np.zeros(3),
                       input_range=np.column_stack([-ends, ends]))  # fmt: skip
    corners = np.array(list(itertools.product(*([-e, e] for e in ends))))
    for name, value in terms.items():
        (loss,) = other_losses(replace(bare, **{name: value}))
        if name == "g_sensitivity":
            force = np.eye(3) * 9.80665
            largest = np.linalg.norm(
                predict(replace(bare, g_sensitivity=value), np.zeros((3, 3)), specific_force=force), axis=0
            )
        else:
            largest = np.max(np.abs(predict(replace(bare, **{name: value}), corners) - corners), axis=0)
        assert loss.sizes == pytest.approx(largest, rel=1e-12), name
    skewed = replace(bare, matrix=np.eye(3) + rng.normal(0.0, 0.02, (3, 3)))
    told = [one.what for one in FORMATS["px4"].cannot_hold({"gyro": skewed})]
    error = np.degrees(np.max(np.abs(predict(skewed, corners) - corners), axis=0))
    each = ", ".join(f"{axis} {size:.3g}" for axis, size in zip("xyz", error, strict=True))
    assert f"gyro: PX4 cannot hold: scale factor errors and cross terms: up to {each} deg/s at full input" in told[0]


@pytest.mark.parametrize("name", ["px4", "ardupilot", "ros"])
def test_without_a_range_it_says_so_instead_of_a_size(name: str) -> None:
    model = replace(sensor(1), matrix=np.eye(3) + 0.01, third_order=np.full(3, 1e-3))
    told = " ".join(one.what for one in FORMATS[name].cannot_hold({"gyro": model}))
    assert "scale factor errors and cross terms (no range of the input is known)" in told
    assert "third-order term K3 (no range of the input is known)" in told


def test_a_condition_is_named_as_the_only_one_that_it_is_right_for() -> None:
    text = FORMATS["px4"].dump({"gyro": replace(sensor(1), condition="vacuum")})
    assert "# Not held: condition vacuum: right for it alone, and no notion of pressure" in text


def test_texts_of_a_model_cannot_leave_their_comment() -> None:
    from inertialcal.sensors.model.sensor_model import Item

    bad = replace(sensor(1), item=Item("a\n1\t1\tTC_G0_X0_0\t9\t9", "", "s"), condition="b\r\nCAL_GYRO0_XOFF 1")
    for name in ("px4", "ardupilot"):
        assert parameters(FORMATS[name].dump({"gyro": bad})) == parameters(FORMATS[name].dump({"gyro": sensor(1)}))
    assert yaml.safe_load(FORMATS["ros"].dump({"gyro": bad}))


# Troubles of their users


def test_px4_takes_nothing_off_twice() -> None:
    """PX4 14717: thermal compensation and offsets that both hold the constant."""
    model, temperature = sensor(9), 45.0
    kept = parameters(FORMATS["px4"].dump({"gyro": model}))
    assert [kept[f"CAL_GYRO0_{axis}OFF"] for axis in "XYZ"] == [0.0, 0.0, 0.0]
    reading = bias(model, np.array([temperature]))[0]
    assert [px4(kept, r, temperature, i) for i, r in enumerate(reading)] == pytest.approx([0.0] * 3, abs=1e-8)
    offset = float(model.bias[0])
    both = FORMATS["px4"].dump({"gyro": model}).replace("CAL_GYRO0_XOFF\t0.0", f"CAL_GYRO0_XOFF\t{offset}")
    assert px4(parameters(both), reading[0], temperature, 0) == pytest.approx(-offset, rel=1e-4)
    again = imported(both)
    assert [one.code for one in again.remarks] == ["two_offsets"]
    taken = predict(again.models["gyro"], np.zeros((1, 3)), temperature=temperature)[0]
    assert taken[0] == pytest.approx(reading[0] + offset, rel=1e-5), "it is read as PX4 applies it"


def typed(*words: str) -> int:
    """Type a command; return its exit status."""
    with pytest.raises(SystemExit) as left:
        main(words)
    assert isinstance(left.value.code, int)
    return left.value.code


def soak(path: Path, seed: int = 3) -> tuple[Array, Array]:
    """Write a soak that lingers at its hot end, with a bias that no cubic follows; return that bias."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 10_000.0, 2.0)
    temperature = 60.0 - 80.0 * np.exp(-t / 1200.0)  # half of the samples within 2 degC of the end
    s = (temperature - 20.0) / 40.0
    curve = 0.1 * s**2 - 0.05 * s**3 + 0.04 * s**4
    readings = curve[:, np.newaxis] + rng.normal(0.0, 0.001, (len(t), 3))
    head = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],temperature [degC]"
    np.savetxt(path, np.column_stack([t, readings, temperature]), "%.9g", ",", header=head, comments="")
    at = np.linspace(-18.0, 60.0, 400)
    z = (at - 20.0) / 40.0
    return at, 0.1 * z**2 - 0.05 * z**3 + 0.04 * z**4


@pytest.mark.parametrize("name", FIRMWARE)
def test_a_soak_that_lingers_at_one_temperature_does_not_weigh_it_more(tmp_path: Path, name: str) -> None:
    """PX4 14091: a fit by sample follows the slow end, and misses the fast one."""
    at, truth = soak(tmp_path / "soak.csv")
    out = tmp_path / "gyro.params"
    command = ["thermal", str(tmp_path / "soak.csv"), "--for", name, "-o", str(out), "--quiet", "--order", "3",
               "--warm-up", "0 s", "--turn-over", "1 K"]  # fmt: skip
    assert typed(*command) == 0
    kept = parameters(out.read_text())
    left = np.array(
        [FIRMWARE[name](kept, b * DEG, t, 0) / DEG for t, b in zip(at.tolist(), truth.tolist(), strict=True)]
    )
    data = np.loadtxt(tmp_path / "soak.csv", delimiter=",", skiprows=1)
    by_sample = np.polyval(np.polyfit(data[:, 4], data[:, 1], 3), at)
    alike = np.polyval(np.polyfit(at, truth, 3), at)  # of all temperatures with the same weight
    ours, theirs = (float(np.max(np.abs(one - alike))) for one in (truth - left, by_sample))
    assert ours < 0.001
    assert theirs > 3.0 * ours


def test_one_command_from_a_soak_is_the_export_of_its_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    soak(tmp_path / "soak.csv")
    given = ["thermal", str(tmp_path / "soak.csv"), "--warm-up", "0 s"]
    assert typed(*given, "-o", str(tmp_path / "model.json"), "--quiet") == 0
    assert typed(*given, "--for", "px4", "-o", str(tmp_path / "a.params")) == 0
    assert "a.params (not judged)" in capsys.readouterr().out
    export(load_model_file(tmp_path / "model.json"), "px4", tmp_path / "b.params", unjudged=True)
    assert (tmp_path / "a.params").read_bytes() == (tmp_path / "b.params").read_bytes()
    assert typed(*given, "--for", "px4") == 0
    printed = capsys.readouterr().out
    assert (tmp_path / "a.params").read_text().strip() in printed
    assert "PX4 cannot hold" in printed
    assert typed(*given, "--for", "px5") == 2
    assert "Formats: " in capsys.readouterr().err


def test_an_input_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    soak(tmp_path / "soak.csv")
    before = (tmp_path / "soak.csv").read_bytes()
    path = str(tmp_path / "soak.csv")
    assert typed("thermal", path, "--warm-up", "0 s", "--for", "px4", "-o", path) == 3
    assert (tmp_path / "soak.csv").read_bytes() == before
    assert "soak.csv" in capsys.readouterr().err


# What is not known stays with the vehicle


def warmed(kind: Kind) -> SensorModel:
    """The model of a thermal test: change with temperature, of accelerometers no constant; no scale factor."""
    names = [Key("bias", axis) for axis in AXES] if kind == "gyro" else []
    keys = (*names, *(Key("bias_temperature", axis, power=1) for axis in AXES))
    unit = INPUT_UNIT[kind]
    units = (*(unit for _ in names), *(f"{unit}/degC" for _ in AXES))
    values = np.full(len(keys), 1e-4)
    parts = (Component(Origin("noise"), "A", 1e-12 * np.eye(len(keys))),)
    return model_from(Estimate(keys, values, units, parts), kind, AXES, reference_temperature=20.0,
                      temperature_range=(-10.0, 50.0))  # fmt: skip


@pytest.mark.parametrize("name", FIRMWARE)
def test_a_constant_and_a_scale_factor_that_nobody_estimated_are_not_written(tmp_path: Path, name: str) -> None:
    write_model(tmp_path / "acc.json", warmed("accelerometer"))
    done = export(load_model_file(tmp_path / "acc.json"), name, tmp_path / "out", unjudged=True)
    kept = parameters((tmp_path / "out").read_text())
    assert not any("OFF" in key or "SCAL" in key or "CALTEMP" in key for key in kept)
    assert [one.code for one in done.remarks].count("left_to_vehicle") == 2
    comments = [line for line in (tmp_path / "out").read_text().splitlines() if line.startswith("#")]
    assert any(
        "constant of the bias is not known" in line and "Calibrate the sensor level" in line for line in comments
    )
    write_model(tmp_path / "gyro.json", warmed("gyro"))
    done = export(load_model_file(tmp_path / "gyro.json"), name, tmp_path / "out", unjudged=True)
    assert "left_to_vehicle" not in [one.code for one in done.remarks]
    assert any("OFF" in key for key in parameters((tmp_path / "out").read_text()))


def test_ros_refuses_a_scale_factor_of_accelerometers_that_nobody_estimated(tmp_path: Path) -> None:
    kinds: tuple[Kind, ...] = ("gyro", "accelerometer")
    for kind in kinds:
        write_model(tmp_path / f"{kind}.json", warmed(kind))
    export(load_model_file(tmp_path / "gyro.json"), "ros", tmp_path / "out", unjudged=True)
    with pytest.raises(DataError, match="not estimated"):
        export(load_model_file(tmp_path / "accelerometer.json"), "ros", tmp_path / "out", unjudged=True)


# Kalibr


def test_kalibr_says_the_bias_in_its_file_and_in_a_remark() -> None:
    model = sensor(1)
    text = FORMATS["kalibr-model"].dump({"gyro": model})
    (line,) = [one for one in text.splitlines() if one.startswith("# Bias of the gyro")]
    for axis, value in zip("xyz", model.bias, strict=True):
        assert f"{axis} {value:.9g}" in line
    assert "subtract it first" in line
    (remark,) = [one for one in FORMATS["kalibr-model"].cannot_hold({"gyro": model}) if one.what.endswith("hold: bias")]
    assert line[2:] in remark.do
    assert "gyro" in imported(text, "imu.yaml").models, "a comment is no trouble to a reader"


# Refused


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("1\t1\tTC_G0_X0_0\tzero\t9\n", "schema"),
        ("TC_G0_X0_0 1\nTC_G0_X0_0 2\n", "schema"),
        ("TC_G0_X0_0 nan\n", "schema"),
        ("TC_G0_X0_0 1e99\n", "impossible_value"),
        ("TC_G_ENABLE 1\nTC_G0_X0_0 1\n", "missing_key"),
        ("TC_G1_X0_0 1\n", "missing_key"),
        ("CAL_ACC0_XSCALE 0\nCAL_ACC0_YSCALE 1\n", "schema"),
        ("INS_TCAL1_GYR1_X 5\n", "missing_key"),
        ("INS_TCAL1_TMIN 0\nINS_TCAL1_TMAX 40\nINS_TCAL1_GYR1_X 5\nINS_GYROFFS_X 0.1\n", "missing_key"),
        ("INS_TCAL2_GYR1_X 5\n", "missing_key"),
        ("INS_ACCSCAL_X 0\n", "schema"),
        ("imu/intrinsics/accel/sm: [1, 2]\n", "schema"),
        ("SM: [1, 0, 0, 0, 1, 0, 0, 0, 0]\nbias: [0, 0, 0]\n", "not_invertible"),
        ("imu/intrinsics/gyro: 1\n", "missing_key"),
        ("SM: [1]\nbias: [0, 0, 0]\n", "schema"),
        ("imu/intrinsics/accel/sm: [1\n", "not_yaml"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_refused_by_code(text: str, code: str) -> None:
    with pytest.raises(DataError) as caught:
        imported(text)
    assert caught.value.problems[0].code == code


def test_a_second_unit_is_named() -> None:
    text = "CAL_GYRO0_XOFF 0.1\nCAL_GYRO1_XOFF 0.2\n"
    assert [one.code for one in imported(text).remarks] == ["left_out"]


@pytest.mark.parametrize("name", FIRMWARE)
def test_a_model_that_an_autopilot_cannot_use_is_refused(name: str) -> None:
    with pytest.raises(DataError, match="no range of temperature") as caught:
        FORMATS[name].dump({"gyro": replace(sensor(1), temperature_range=None)})
    assert caught.value.problems[0].code == "no_temperature_range"
    single = SensorModel("gyro", ("x",), np.ones(1), "rad/s", np.eye(1), np.zeros(1))
    with pytest.raises(DataError, match="axes x"):
        FORMATS[name].dump({"gyro": single})
    if name == "ardupilot":
        two: dict[Kind, SensorModel] = {"gyro": sensor(1), "accelerometer": sensor(1, "accelerometer", high=50.0)}
        with pytest.raises(DataError, match="one range for both"):
            FORMATS[name].dump(two)


@settings(max_examples=200)
@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(text: str) -> None:
    for head in ("TC_G0_X0_0 ", "INS_TCAL1_GYR1_X,", "SM: "):
        try:
            imported(head + text)
        except (DataError, UsageError):
            continue


def test_a_model_json_is_none_of_them() -> None:
    text = ModelText(dump_model(sensor(1)), "model.json")
    assert [FORMATS[name].read(text) for name in ("px4", "ardupilot", "ros")] == [None] * 3  # type: ignore[misc]
