"""Models that `positions` saves, handed out in every format: what is read back, or run, is the model."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal import load_model, read
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.__main__ import main
from inertialcal.core.estimate import Array
from inertialcal.files.models.formats import FORMATS
from inertialcal.rigs.hand_held.rig import Bench, build
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.sensor_model import SensorModel
from typed_commands import call, call_json

SMALL = Bench(positions=14, dwell=2.5, first=4.0, records=1)
SENSORS = {"acc": "accelerometer", "gyro": "gyro"}
CODE = ("c", "python")
PARTS = ("px4", "ardupilot", "ros")  # hold a part of a model: tests/files/models/test_autopilots.py
IMPORTED = tuple(name for name in FORMATS if name not in ("json", *CODE, "flight-c", *PARTS))
NO_BIAS, NO_FORCE = ("kalibr-model",), ("imu-tk", "realsense")
EXACT = 1e-9  # relative: through text, and a matrix parted in two
ACC, GYRO = (tuple(f"{sensor}_{axis}" for axis in "xyz") for sensor in SENSORS)


@dataclass(frozen=True)
class Saved:
    """The record, and the models that were saved of it, in one unit of the readings."""

    record: Path
    folder: Path

    def path(self, sensor: str) -> Path:
        return self.folder / f"model_{sensor}.json"

    def model(self, sensor: str) -> SensorModel:
        return load_model(self.path(sensor))


@pytest.fixture(scope="module", params=["SI", "count"])
def saved(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Saved:
    folder = tmp_path_factory.mktemp("saved")
    (recording,) = build(SMALL, 1).recordings.values()
    units, counts = {"acc": "m/s2", "gyro": "rad/s"}, {"acc": 1.0, "gyro": 1.0}
    if request.param == "count":
        units, counts = dict.fromkeys(units, "count"), {"acc": 400.0, "gyro": 2000.0}
    channels = tuple(replace(c, data=c.data * counts.get(c.name[:-2], 1.0)) for c in recording.channels)
    record = folder / "hand.csv"
    record.write_text(csv_text(replace(recording, channels=channels)), encoding="utf-8")
    words = [word for name, unit in units.items() for word in ("--unit", f"{name}={unit}")]
    models = ["-o", str(folder / "model.json"), "--quiet"]
    with pytest.raises(SystemExit) as left:
        main(["positions", str(record), *words, "--gravity", "9.807 m/s2", *models])
    assert not left.value.code
    return Saved(record, folder)


def same(own: SensorModel, theirs: SensorModel, to: str) -> None:
    """Assert that two models make the same output of an input, but for what a format cannot hold."""
    terms: Mapping[str, Array] = theirs.terms
    for name, values in own.terms.items():
        if name not in ("matrix", "bias", "g_sensitivity"):
            continue
        if (name == "bias" and to in NO_BIAS) or (name == "g_sensitivity" and to in NO_FORCE):
            assert not np.any(terms.get(name, 0.0))
            continue
        one, other = (
            value * scale if name == "bias" else value.reshape(-1, 3) * scale[:, None]
            for value, scale in ((values, _scale(own, to)), (terms[name], theirs.scale_factor))
        )
        np.testing.assert_allclose(other, one, rtol=EXACT, atol=EXACT * float(np.max(np.abs(one))))


def _scale(own: SensorModel, to: str) -> Array:
    return np.ones(3) if to == "kalibr-model" else own.scale_factor  # its readings are in SI


@pytest.mark.parametrize("sensor", SENSORS)
def test_json_is_the_model_to_the_byte(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, sensor: str
) -> None:
    refused = call_json(capsys, "export", str(saved.path(sensor)), "--to", "json", "-o", str(tmp_path / "out.json"))
    assert (refused["exit"], refused["errors"][0]["code"]) == (3, "unjudged")
    done = call(capsys, "export", str(saved.path(sensor)), "--to", "json", "-o", str(tmp_path / "o.json"), "--unjudged")
    assert done[0] == 0
    assert (tmp_path / "o.json").read_bytes() == saved.path(sensor).read_bytes()


@pytest.mark.parametrize("to", IMPORTED)
@pytest.mark.parametrize("sensor", SENSORS)
def test_a_format_of_others_reads_back_as_the_model(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, sensor: str, to: str
) -> None:
    target = tmp_path / f"{sensor}_out"
    content = call_json(capsys, "export", str(saved.path(sensor)), "--to", to, "-o", str(target), "--unjudged")
    assert content["exit"] == 0
    told = " ".join(one["what"] for one in content["remarks"])
    assert "cannot hold" in told
    assert ("cannot hold: bias" in told) is (to in NO_BIAS)
    assert ("cannot hold: g-sensitivity" in told) is (to in NO_FORCE and sensor == "gyro")
    same(saved.model(sensor), load_model(f"{target}#{SENSORS[sensor]}"), to)


@pytest.mark.parametrize("to", IMPORTED)
def test_both_sensors_in_one_file(capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, to: str) -> None:
    target = str(tmp_path / "both")
    words = (
        "export",
        str(saved.path("gyro")),
        "--with",
        str(saved.path("acc")),
        "--to",
        to,
        "-o",
        target,
        "--unjudged",
    )
    content = call_json(capsys, *words)
    if to == "imu-tk":
        assert (content["exit"], content["errors"][0]["code"]) == (2, "one_sensor")
        return
    assert "filled_in" not in {one["code"] for one in content["remarks"]}
    for sensor, kind in SENSORS.items():
        same(saved.model(sensor), load_model(f"{target}#{kind}"), to)


def compensated(model: SensorModel, saved: Saved) -> tuple[Array, Array, Array]:
    """Return the readings of some samples, specific force, and what `compensate` makes of them."""
    recording = read(saved.record)
    force = recording.array(list(ACC))[::97]
    output = recording.array(list(ACC if model.kind == "accelerometer" else GYRO))[::97]
    conditions: dict[str, Any] = {} if model.g_sensitivity is None else {"specific_force": force}
    return output, force, compensate(model, output / model.scale_factor, **conditions)


@pytest.mark.parametrize("sensor", SENSORS)
def test_python_that_is_handed_out_compensates(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, sensor: str
) -> None:
    target = tmp_path / "applied.py"
    assert call(capsys, "export", str(saved.path(sensor)), "--to", "python", "-o", str(target), "--unjudged")[0] == 0
    space: dict[str, Any] = {}
    exec(compile(target.read_bytes(), "applied.py", "exec"), space)
    model = saved.model(sensor)
    output, force, expected = compensated(model, saved)
    more = [{"specific_force": one} if model.g_sensitivity is not None else {} for one in force]
    found = np.array([space["compensate"](v, **one)[0] for v, one in zip(output, more, strict=True)])
    np.testing.assert_allclose(found, expected, rtol=EXACT, atol=EXACT)


@pytest.mark.parametrize("sensor", SENSORS)
def test_c_that_is_handed_out_compensates(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, sensor: str, need: Callable[[str], str]
) -> None:
    source, library = tmp_path / "applied.c", tmp_path / "applied.so"
    content = call_json(capsys, "export", str(saved.path(sensor)), "--to", "c", "-o", str(source), "--unjudged")
    assert [one["what"] for one in content["remarks"]] == [f"{SENSORS[sensor]}: code in c cannot hold: uncertainties"]
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC"]
    command = [need("cc"), *strict, str(source), "-o", str(library), "-lm"]
    assert subprocess.run(command, capture_output=True, text=True, check=False, timeout=60).stderr == ""
    function = ctypes.CDLL(str(library)).compensate
    model = saved.model(sensor)
    output, force, expected = compensated(model, saved)
    double = ctypes.POINTER(ctypes.c_double)
    found = np.empty(output.shape)
    for n, v in enumerate(output):
        given = [
            np.ascontiguousarray(v),
            *([np.ascontiguousarray(force[n])] if model.g_sensitivity is not None else []),
        ]
        x, holds = np.empty(3), np.empty(3, dtype=np.int32)
        passed = [*(one.ctypes.data_as(double) for one in given), x.ctypes.data_as(double)]
        function(*passed, holds.ctypes.data_as(ctypes.POINTER(ctypes.c_int)))
        found[n] = x
    np.testing.assert_allclose(found, expected, rtol=EXACT, atol=EXACT)


@pytest.mark.parametrize("to", CODE)
def test_code_holds_one_sensor(capsys: pytest.CaptureFixture[str], tmp_path: Path, saved: Saved, to: str) -> None:
    words = ("--with", str(saved.path("acc")), "--to", to, "-o", str(tmp_path / "both"), "--unjudged")
    content = call_json(capsys, "export", str(saved.path("gyro")), *words)
    assert (content["exit"], content["errors"][0]["code"]) == (2, "one_sensor")
    assert not (tmp_path / "both").exists()
