"""Models in the formats of others: their equations, there and back, what cannot be held, what is refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import Key, Kind
from inertialcal.files.models import imu_tk, imucal, kalibr, realsense
from inertialcal.files.models.formats import FORMATS as ALL
from inertialcal.files.models.formats import read_models
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_format import ImportedModels, ModelText
from inertialcal.files.models.model_json import write_model
from inertialcal.files.models.yaml_text import parse_yaml
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.equation import predict
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import INPUT_UNIT, SensorModel, to_output, to_readings

EXACT = 1e-12  # relative

FORMATS = {name: ALL[name] for name in ("imucal", "kalibr-model", "imu-tk", "realsense")}


def imported(text: str, where: str, kind: Kind | None = None) -> ImportedModels:
    """Models of a text."""
    return read_models(ModelText(text, where, kind))[1]


def equal(own: Array, theirs: Array) -> None:
    np.testing.assert_allclose(own, theirs, rtol=1e-12, atol=1e-13)


def sensor(kind: Kind, seed: int = 1, si: bool = False) -> SensorModel:
    """A sensor with errors of some per cent in all entries; SI readings, or counts with some of them turned."""
    rng = np.random.default_rng(seed)
    scale = np.ones(3) if si else rng.uniform(300.0, 500.0, 3) * ([1.0, 1.0, 1.0] if kind == "gyro" else [1, -1, 1])
    force = rng.normal(0.0, 1e-4, (3, 3)) if kind == "gyro" else None
    return SensorModel(
        kind=kind,
        axes=("x", "y", "z"),
        scale_factor=scale,
        output_unit=INPUT_UNIT[kind] if si else "count",
        matrix=np.eye(3) + rng.normal(0.0, 0.02, (3, 3)),
        bias=rng.normal(0.0, 0.1, 3),
        g_sensitivity=force,
    )


def outputs(model: SensorModel, x: Array, force: Array) -> Array:
    """What the sensor puts out, by our equation."""
    conditions: dict[str, Any] = {} if model.g_sensitivity is None else {"specific_force": force}
    return to_output(model, predict(model, x, **conditions))


def same_sensor(one: SensorModel, other: SensorModel, bias: bool = True, force: bool = True) -> None:
    """Assert that both put out the same, entry by entry."""
    for name in ("matrix", "bias", "g_sensitivity"):
        own, theirs = (model.terms.get(name, np.zeros((3, 3))) for model in (one, other))
        own, theirs = own.reshape(-1, 3) if name != "bias" else own, theirs.reshape(-1, 3) if name != "bias" else theirs
        own, theirs = ((m.T * s.scale_factor).T for m, s in ((own, one), (theirs, other)))
        if (name != "bias" or bias) and (name != "g_sensitivity" or force):
            np.testing.assert_allclose(theirs, own, rtol=EXACT, atol=EXACT * float(np.max(np.abs(own))))


def inputs() -> tuple[Array, Array]:
    rng = np.random.default_rng(9)
    return rng.normal(0.0, 2.0, (50, 3)), rng.normal(0.0, 9.8, (50, 3))


@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize("name", FORMATS)
def test_there_and_back_is_the_same_sensor(name: str, seed: int) -> None:
    si = name == "kalibr-model"
    models: dict[Kind, SensorModel] = {kind: sensor(kind, seed, si) for kind in ("accelerometer", "gyro")}
    lots = [{kind: model} for kind, model in models.items()] if name == "imu-tk" else [models]
    for lot in lots:
        kind = next(iter(lot))
        again = imported(FORMATS[name].dump(lot), "file", kind)
        for one, model in lot.items():
            same_sensor(model, again.models[one], bias=not si, force=name in {"imucal", "kalibr-model"})


@pytest.mark.parametrize("name", FORMATS)
def test_their_text_read_and_written_says_the_same(name: str) -> None:
    """theirs -> ours -> theirs: the second text is the first to rounding."""
    models: dict[Kind, SensorModel] = {"gyro": sensor("gyro", 3, si=True)}
    module = FORMATS[name]
    text = module.dump(models)
    first = imported(text, "gyro", "gyro")
    kept = {kind: model for kind, model in first.models.items() if name != "imu-tk" or kind == "gyro"}
    texts = (
        re.sub(r"^# Bias.*$", "", one, flags=re.MULTILINE) for one in (text, module.dump(kept))
    )  # Kalibr: to people
    words, again = (re.sub(r"[][,]", " ", one).split() for one in texts)
    assert len(words) == len(again)
    for one, other in zip(words, again, strict=True):
        assert one == other or float(other) == pytest.approx(float(one), rel=1e-11, abs=1e-15)


# Each format by its own equation, written out here once more.


def test_imucal_by_its_equation() -> None:
    a, b = sensor("accelerometer"), sensor("gyro")
    content = json.loads(imucal.dump({"accelerometer": a, "gyro": b}))
    m = {key: np.array(value) for key, value in content.items() if key[0] in "KRb"}
    rate, force = inputs()
    acc = (m["K_a"] @ m["R_a"] @ force.T).T + m["b_a"]
    gyr = (m["K_g"] @ m["R_g"] @ np.degrees(rate).T + m["K_ga"] @ force.T).T + m["b_g"]
    equal(acc, outputs(a, force, force))
    equal(gyr, outputs(b, rate, force))
    np.testing.assert_allclose(np.linalg.norm(m["R_g"], axis=1), 1.0, atol=1e-15)
    assert (content["acc_unit"], content["gyr_unit"], content["from_acc_unit"]) == ("m/s^2", "deg/s", "count")


def test_kalibr_by_its_equation() -> None:
    a, b = sensor("accelerometer", si=True), sensor("gyro", si=True)
    content = yaml.safe_load(kalibr.dump({"accelerometer": a, "gyro": b}))["imu0"]
    m_a, m_g = (np.array(content[key]["M"]) for key in ("accelerometers", "gyroscopes"))
    to_imu = np.array(content["T_i_b"])[:3, :3]
    to_gyro = np.array(content["gyroscopes"]["C_gyro_i"]) @ to_imu
    rate, force = inputs()
    acc = (m_a @ to_imu @ force.T).T + a.bias
    gyr = (m_g @ to_gyro @ rate.T + np.array(content["gyroscopes"]["A"]) @ to_gyro @ force.T).T + b.bias
    equal(acc, outputs(a, force, force))
    equal(gyr, outputs(b, rate, force))
    for m, c in ((m_a, to_imu), (m_g, to_gyro)):
        assert not np.any(np.triu(m, 1))
        np.testing.assert_allclose(c @ c.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(c) > 0.0


def test_imu_tk_by_its_equation() -> None:
    a = sensor("accelerometer")
    values = np.array(imu_tk.dump({"accelerometer": a}).split(), float)
    t, k, b = values[:9].reshape(3, 3), values[9:18].reshape(3, 3), values[18:]
    _, force = inputs()
    np.testing.assert_allclose((t @ k @ (outputs(a, force, force) - b).T).T, force, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.diag(t), 1.0, atol=1e-15)
    upper = replace(a, matrix=np.triu(a.matrix[0]))
    assert not np.any(np.tril(np.array(imu_tk.dump({"accelerometer": upper}).split()[:9], float).reshape(3, 3), -1))


def test_realsense_by_the_equation_of_its_script() -> None:
    a, b = sensor("accelerometer"), sensor("gyro")
    unit = json.loads(realsense.dump({"accelerometer": a, "gyro": replace(b, g_sensitivity=None)}))["imus"][0]
    rate, force = inputs()
    for key, model, x in (("accelerometer", a, force), ("gyroscope", replace(b, g_sensitivity=None), rate)):
        four = np.vstack([np.reshape(unit[key]["scale_and_alignment"], (3, 3)), unit[key]["bias"]])
        rows = np.column_stack([outputs(model, x, force), -np.ones(len(x))])
        np.testing.assert_allclose(rows @ four, x, rtol=1e-10, atol=1e-10)


def test_published_snapshot_reads_as_a_model_and_back(shared: Path) -> None:
    path = shared / "data" / "imucal_ferraris" / "expected_snapshot_example_cal.json"
    theirs = json.loads(path.read_text())
    acc, gyro = (load_model_file(f"{path}#{kind}").model for kind in ("accelerometer", "gyro"))
    m = {key: np.array(value) for key, value in theirs.items() if key[0] in "KRb"}
    raw = np.array([[100.0, -80.0, 2000.0], [2100.0, 15.0, -30.0]])
    force = (np.linalg.inv(m["R_a"]) @ np.linalg.inv(m["K_a"]) @ (raw - m["b_a"]).T).T
    np.testing.assert_allclose(compensate(acc, to_readings(acc, raw)), force, rtol=EXACT)
    shifted = (raw - m["b_g"]).T - m["K_ga"] @ force.T
    rate = np.radians(np.linalg.inv(m["R_g"]) @ np.linalg.inv(m["K_g"]) @ shifted).T
    np.testing.assert_allclose(compensate(gyro, to_readings(gyro, raw), specific_force=force), rate, rtol=EXACT)
    assert np.all(gyro.scale_factor < 0.0), "all three sensors are mounted against their axes"
    assert np.all(np.abs(np.diag(gyro.matrix[0]) - 1.0) < 0.01)
    again = json.loads(imucal.dump({"accelerometer": acc, "gyro": gyro}))
    for key, value in m.items():
        np.testing.assert_allclose(again[key], value, rtol=1e-11, atol=1e-14)
    reasons = set(gyro.not_estimated.values())
    assert reasons == {"imucal holds no uncertainty"}
    assert gyro.estimate is None


def test_what_a_format_cannot_hold_is_told_thing_by_thing() -> None:
    full = replace(
        sensor("gyro", si=True),
        bias_temperature=np.full((1, 3), 1e-4),
        third_order=np.full(3, 1e-3),
        reference_temperature=np.full(3, 20.0),
        input_range=np.array([[-1.0, 1.0]] * 3),
        second_order=np.zeros(3),
    )
    told = {name: [r.what for r in module.cannot_hold({"gyro": full})] for name, module in FORMATS.items()}
    for lines in told.values():
        text = " ".join(lines)
        assert "bias over temperature" in text
        assert "third-order term" in text
        assert "second-order" not in text, "a term of zeros is nothing to lose"
        assert "ranges" in text

    def without(words: str) -> list[str]:
        return [name for name, lines in told.items() if any(line.endswith(words) for line in lines)]

    assert without("cannot hold: g-sensitivity") == ["imu-tk", "realsense"]
    assert without("cannot hold: bias") == ["kalibr-model"]
    assert without("so an ideal one is written") == ["imucal", "kalibr-model", "realsense"]


@pytest.mark.parametrize("name", ["imucal", "kalibr-model", "realsense"])
def test_a_sensor_that_nobody_gave_is_ideal(name: str) -> None:
    again = imported(FORMATS[name].dump({"gyro": sensor("gyro", si=True)}), "x")
    model = again.models["accelerometer"]
    np.testing.assert_allclose(model.scale_factor[:, None] * model.matrix[0], np.eye(3), atol=1e-12)
    gyro = again.models["gyro"]
    same_sensor(sensor("gyro", si=True), gyro, bias=name != "kalibr-model", force=name != "realsense")


def test_kalibr_says_that_it_holds_no_bias() -> None:
    again = imported(kalibr.dump({"gyro": sensor("gyro", si=True)}), "x")
    assert [remark.code for remark in again.remarks] == ["no_bias"]
    assert "no bias" in again.models["gyro"].not_estimated["bias_x"]


KALIBR = """\
imu0:
  T_i_b:
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 1.0, 0.0,
    0.0]
  - - 0.0
    - 0.0
    - 1.0
    - 0.0
  - [0, 0, 0, 1]
  accelerometer_noise_density: 1.0e-3
  accelerometers:
    M:
    - [1.01, 0.0, 0.0]   # the tool writes lower triangular ones
    - [0.001, 0.99, 0.0]
    - [-0.002, 0.003, 1.02]
    rx_i: [0.0, 0.0, 0.0]
  gyroscopes:
    A:
    - [1e-05, 0.0, 0.0]
    - [0.0, 0.0, 0.0]
    - [0.0, 0.0, 0.0]
    C_gyro_i:
    - [0.0, 1.0, 0.0]
    - [-1.0, 0.0, 0.0]
    - [0.0, 0.0, 1.0]
    M:
    - [1.0, 0.0, 0.0]
    - [0.0, 2.0, 0.0]
    - [0.0, 0.0, 1.0]
  model: scale-misalignment-size-effect
  rostopic: /imu0
  time_offset: 0.012
  update_rate: 200.0
"""


def test_a_file_as_kalibr_lays_it_out() -> None:
    found = imported(KALIBR, "imu.yaml")
    acc, gyro = found.models["accelerometer"], found.models["gyro"]
    np.testing.assert_allclose(acc.matrix[0], [[1.01, 0, 0], [0.001, 0.99, 0], [-0.002, 0.003, 1.02]])
    np.testing.assert_allclose(gyro.matrix[0], [[0, 1, 0], [-2, 0, 0], [0, 0, 1]])
    assert gyro.g_sensitivity is not None
    np.testing.assert_allclose(np.asarray(gyro.g_sensitivity), np.array([[0, 1e-5, 0], [0, 0, 0], [0, 0, 0]]))
    texts = " ".join(remark.what for remark in found.remarks)
    assert "size effect" in texts
    assert "time_offset 0.012" in texts


def noisy(kind: Kind, white: tuple[float, ...], walk: float, *more: tuple[str, float, str]) -> SensorModel:
    """A sensor with its noise, an axis each; the walk in the units of a data sheet."""
    unit, words = {"gyro": ("rad/s", ("angle", "rate")), "accelerometer": ("m/s^2", ("velocity", "acceleration"))}[kind]
    figures = [
        (Key(f"{words[0]}_random_walk", axis), n, f"{unit}/sqrt(Hz)") for axis, n in zip("xyz", white, strict=True)
    ]
    figures += [(Key(f"{words[1]}_random_walk", axis), walk, f"{unit}/sqrt(h)") for axis in "xyz"]
    figures += [(Key(word, "x"), value, unit) for word, value, unit in more]
    keys, values, units = zip(*figures, strict=True)
    part = Component("scatter", "A", np.diag(np.array(values) * 0.1) ** 2, 5.0)
    return replace(sensor(kind), noise=Estimate(keys, np.array(values), units, (part,)))


def test_kalibr_gets_the_noise_of_the_models_that_have_it() -> None:
    """The largest of the axes, as densities: K of 0.06 (rad/s)/sqrt(h) is 1e-3 (rad/s)/sqrt(s)."""
    gyro = noisy("gyro", (1e-3, 3e-3, 2e-3), 0.06, ("bias_instability", 1e-4, "rad/s"))
    content = parse_yaml(FORMATS["kalibr-model"].dump({"gyro": gyro}))
    assert isinstance(content, dict)
    found = {key: value for key, value in content["imu0"].items() if "noise" in key or "walk" in key}
    assert found == {"gyroscope_noise_density": 3e-3, "gyroscope_random_walk": pytest.approx(1e-3, rel=1e-14)}
    said = [one.what for one in FORMATS["kalibr-model"].cannot_hold({"gyro": gyro})]
    assert "noise, gyro: bias instability" in said
    assert "noise, gyro: differences between axes: the largest value is written" in said
    both = FORMATS["kalibr-model"].dump({"gyro": gyro, "accelerometer": noisy("accelerometer", (0.01,) * 3, 0.6)})
    assert "accelerometer_noise_density: 0.01" in both
    assert "inertialcal allan" not in both


def test_white_noise_of_two_axes_is_no_density() -> None:
    gyro = noisy("gyro", (1e-3, 3e-3, 2e-3), 0.06)
    assert gyro.noise is not None
    some = replace(gyro, noise=gyro.noise.select(gyro.noise.keys[1:]))
    assert "gyroscope_noise_density" not in FORMATS["kalibr-model"].dump({"gyro": some})
    said = [one.what for one in FORMATS["kalibr-model"].cannot_hold({"gyro": some})]
    assert "noise, gyro: no white noise of every axis: not written" in said


def test_channels_that_formats_of_others_cannot_hold_are_said() -> None:
    supply = Sensitivity("supply", "V", 5.0, np.full(3, 0.1), None, np.full(3, 0.01))
    model = replace(sensor("gyro"), sensitivities=(supply,), condition="vacuum")
    for one in FORMATS.values():
        said = " ".join(remark.what for remark in one.cannot_hold({"gyro": model}))
        assert "change of the bias with supply" in said
        assert "change of the scale factor with supply" in said
        assert "condition that the model is for" in said


SNAP = imucal.dump({"accelerometer": sensor("accelerometer"), "gyro": sensor("gyro")})


@pytest.mark.parametrize(
    ("text", "code", "match"),
    [
        (SNAP.replace('"2.0"', '"1.0"'), "schema_version", "version 1.0"),
        (SNAP.replace('"K_ga"', '"K_gx"'), "missing_key", "no K_ga"),
        (SNAP.replace('"deg/s"', '"m"', 1), "unknown_unit", "gyr_unit is 'm'"),
        ('{"imus": []}', "missing_key", "imus is empty"),
        ('{"imus": [{"accelerometer": {"scale_and_alignment": [1, 2], "bias": [0, 0, 0]}}]}', "schema", "not 9 finite"),
        (
            '{"imus": [{"accelerometer": {"scale_and_alignment": [0,0,0,0,0,0,0,0,0], "bias": [0,0,0]}}]}',
            "not_invertible",
            "no inverse",
        ),
        (" ".join(["1"] * 21), "schema", "diagonal K"),
        (KALIBR.replace("- [1.01, 0.0, 0.0]", "- [1.01, 0.1, 0.0]"), "schema", "not lower triangular"),
        (KALIBR.replace("- [0.0, 1.0, 0.0]\n", "- [0.0, 1.1, 0.0]\n"), "not_a_rotation", "C_gyro_i"),
        (KALIBR.replace("[1.01, 0.0, 0.0]", "[1.01, .nan, 0.0]"), "schema", "3 x 3 finite"),
        ("imu0:\n  accelerometer_noise_density: 1.0\n  model: calibrated\n", "no_model", "holds noise"),
        ("accelerometers: &a\n  M: *a\n", "not_yaml", "anchors, aliases and tags"),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, code: str, match: str) -> None:
    with pytest.raises(DataError, match=match) as caught:
        imported(text, "gyro.txt")
    assert caught.value.problems[0].code == code


def test_left_handed_axes_are_no_model_of_kalibr() -> None:
    with pytest.raises(DataError, match="left-handed"):
        kalibr.dump({"gyro": replace(sensor("gyro", si=True), matrix=np.diag([1.0, -1.0, 1.0]))})


def test_two_axes_are_no_model_of_others() -> None:
    two = SensorModel("gyro", ("x", "y"), np.ones(2), "rad/s", np.eye(2), np.zeros(2))
    for module in FORMATS.values():
        with pytest.raises(DataError, match="axes x, y"):
            module.dump({"gyro": two})


def test_export_from_their_format_to_another(tmp_path: Path) -> None:
    acc, gyro = sensor("accelerometer", si=True), sensor("gyro", si=True)
    (tmp_path / "cal.json").write_text(imucal.dump({"accelerometer": acc, "gyro": gyro}))
    both = [load_model_file(tmp_path / f"cal.json#{kind}") for kind in ("gyro", "accelerometer")]
    exported = export(both[0], "kalibr-model", tmp_path / "imu.yaml", unjudged=True, others=both[1:])
    assert any("no_bias" in r.code or "bias" in r.what for r in exported.remarks)
    back = load_model_file(f"{tmp_path / 'imu.yaml'}#gyro").model
    same_sensor(replace(gyro, bias=np.zeros(3)), back)
    export(both[0], "json", tmp_path / "model.json", unjudged=True)
    same_sensor(gyro, load_model_file(tmp_path / "model.json").model)
    with pytest.raises(DataError, match="holds models of: accelerometer, gyro") as caught:
        load_model_file(tmp_path / "cal.json")
    assert caught.value.problems[0].code == "which_sensor"
    with pytest.raises(DataError, match="have not confirmed"):
        export(both[0], "imucal", tmp_path / "x.json")
    with pytest.raises(UsageError, match="two models of a gyro"):
        export(both[0], "imucal", tmp_path / "x.json", unjudged=True, others=both[:1])
    for name in ("json", "imu-tk"):
        with pytest.raises(UsageError, match="one sensor a file"):
            export(both[0], name, tmp_path / "x.json", unjudged=True, others=both[1:])
    with pytest.raises(DataError, match="input"):
        export(both[0], "imucal", tmp_path / "cal.json", unjudged=True)


def test_imu_tk_needs_to_be_told_its_sensor(tmp_path: Path) -> None:
    model = sensor("accelerometer")
    for name in ("cal.txt", "test_acc.calib"):
        (tmp_path / name).write_text(imu_tk.dump({"accelerometer": model}))
    same_sensor(model, load_model_file(tmp_path / "test_acc.calib").model)
    same_sensor(model, load_model_file(f"{tmp_path / 'cal.txt'}#accelerometer").model)
    with pytest.raises(DataError, match="does not name its sensor"):
        load_model_file(tmp_path / "cal.txt")


def test_our_own_model_still_reads(tmp_path: Path) -> None:
    write_model(tmp_path / "model.json", sensor("gyro"))
    assert load_model_file(tmp_path / "model.json").format == "inertialcal"


# YAML

VALUES = st.recursive(
    st.floats(-1e30, 1e30, allow_nan=False) | st.integers(-1000, 1000) | st.sampled_from(["a", "/imu0", "x_y"]),
    lambda inner: (
        st.lists(inner, min_size=1, max_size=3) | st.dictionaries(st.sampled_from("abc"), inner, min_size=1, max_size=3)
    ),
    max_leaves=12,
)


@settings(max_examples=60, deadline=None)
@given(st.dictionaries(st.sampled_from(["imu0", "M", "T_i_b"]), VALUES, min_size=1), st.booleans())
def test_yaml_reads_as_it_was_written(content: dict[str, Any], flow: bool) -> None:
    assert parse_yaml(yaml.safe_dump(content, default_flow_style=None if flow else False, width=40)) == content


def test_numbers_without_a_point_are_numbers() -> None:
    assert parse_yaml("M: [1e-5, -2E3, '1e-5', 1.5]") == {"M": [1e-5, -2000.0, "1e-5", 1.5]}


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("a: 1\na: 2", "line 2: key 'a' appears twice"),
        ("a: [1, 2", "line 1: not YAML"),
        ("a: [1] 2", "not YAML"),
        ("a:\n\t- 1", "line 2: not YAML"),
        ("a: 1\n  b: 2", "line 2: not YAML"),
        ("a: \x00", "not YAML"),
        ("a: 2001-99-99", "not YAML"),
        ("a: &x 1", "line 1: YAML anchors, aliases and tags"),
        ("a: 1\nb: *x", "line 2: YAML anchors, aliases and tags"),
        ("a: !!python/object:os.system x", "anchors, aliases and tags"),
        ("a: 1\n---\nb: 2", "not YAML"),
        ("a: " + "[" * 40 + "]" * 40, "more than 12"),
        ("- " * 4000 + "1", "more than 12"),
    ],
)
def test_other_yaml_is_refused_with_its_line(text: str, match: str) -> None:
    with pytest.raises(DataError, match=match):
        parse_yaml(text)
