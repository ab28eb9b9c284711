"""The command ``filter``: models, noise at rest and vibration from files; budgets, settings, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import AXES, Key, Kind, Origin
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import INPUT_UNIT
from typed_commands import call, call_json

N, K = 1e-4, 1e-6


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """A folder with models of both sensors, and terms of their noise as ``allan -o`` writes them."""
    kinds: tuple[Kind, ...] = ("gyro", "accelerometer")
    for kind in kinds:
        unit = INPUT_UNIT[kind]
        keys = (*(Key("scale_factor_error", a) for a in AXES), *(Key("bias", a) for a in AXES),
                *(Key("bias_temperature", a, power=1) for a in AXES))  # fmt: skip
        units = ("1",) * 3 + (unit,) * 3 + (f"{unit}/degC",) * 3
        parts = (Component(Origin("scatter"), "A", np.diag([1e-3] * 3 + [1e-4] * 3 + [1e-5] * 3) ** 2),)
        own = Estimate(keys, np.zeros(9), units, parts)
        model = model_from(own, kind, AXES, reference_temperature=np.full(3, 25.0), temperature_range=(0.0, 50.0),
                           bias_run_to_run=np.full(3, 1e-3))  # fmt: skip
        write_model(tmp_path / f"{kind}.json", model)
    sensors = [
        {"sensor": kind, "kind": kind, "unit": INPUT_UNIT[kind], "sample_interval": 0.005, "averaging": 0.005,
         "axes": [{"axis": a, "terms": [{"term": "random_walk", "coefficient": N},
                                        {"term": "rate_random_walk", "coefficient": K}]} for a in AXES]}
        for kind in kinds
    ]  # fmt: skip
    (tmp_path / "terms.json").write_text(json.dumps({"inputs": [], "sensors": sensors, "results": []}))
    return tmp_path


USE = ("--temperature-span", "20 K", "--temperature-time", "10 min", "--motion", "30 deg/s", "--motion-time", "0.5 s",
       "--force", "2 m/s2")  # fmt: skip


def test_both_sensors_of_an_imu(capsys: pytest.CaptureFixture[str], files: Path) -> None:
    given = ("filter", str(files / "gyro.json"), str(files / "terms.json"), "--with", str(files / "accelerometer.json"))
    content = call_json(capsys, *given, *USE, "--for", "kalibr", "--for", "ros", "--for", "openvins")
    assert [one["sensor"] for one in content["budgets"]] == ["gyro", "accelerometer"]
    gyro, accelerometer = content["budgets"]
    white = np.sqrt(N**2 + (1e-3 * np.radians(30.0)) ** 2 * 2 * 0.5)
    assert gyro["white"] == pytest.approx([white] * 3)
    assert gyro["inflation"]["white"] == pytest.approx([white / N] * 3)
    assert accelerometer["white"] == pytest.approx([np.sqrt(N**2 + 2e-3**2)] * 3)
    settings = yaml.safe_load(content["filters"]["kalibr"]["text"])
    assert settings["gyroscope_noise_density"] == pytest.approx(white, rel=1e-5)
    assert settings["update_rate"] == 200
    assert yaml.safe_load(content["filters"]["openvins"]["text"].split("\n", 1)[1])["imu0"] == settings
    message = yaml.safe_load(content["filters"]["ros"]["text"])
    assert len(message["angular_velocity_covariance"]) == 9
    space = gyro["state_space"][0]
    assert space["dt"] == pytest.approx(0.005)
    assert space["states"] == ["integral", "rate_random_walk", "gauss_markov"]
    assert np.shape(space["Qd"]) == (3, 3)
    assert len(content["inputs"]) == 3
    status, out, _ = call(capsys, *given, *USE, "--for", "px4")
    assert status == 0
    for words in (
        "scale factor",
        "turn-on",
        "over the figure at rest",
        "not counted: gyro: g-sensitivity",
        "EKF2_GYR_NOISE",
    ):
        assert words in out
    assert call(capsys, *given, "--quiet")[:2] == (0, "")


def test_a_recording_at_rest_gives_the_noise(capsys: pytest.CaptureFixture[str], files: Path) -> None:
    rng = np.random.default_rng(1)
    rest = rng.normal(0.0, 0.01, (6000, 3))
    np.savetxt(files / "rest.csv", np.column_stack([np.arange(6000) * 0.01, rest]), "%.9g", ",",
               header="time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", comments="")  # fmt: skip
    content = call_json(capsys, "filter", str(files / "gyro.json"), str(files / "rest.csv"))
    (budget,) = content["budgets"]
    assert np.degrees(budget["white"]) == pytest.approx([0.01 * np.sqrt(0.01)] * 3, rel=0.1)


def test_vibration_from_a_recording(capsys: pytest.CaptureFixture[str], files: Path) -> None:
    t = np.arange(20_000) / 1000.0
    table = np.column_stack([t, *(4.0 * np.sin(2 * np.pi * 140.0 * t + k) for k in range(3))])
    head = "time [s],acc_x [m/s2],acc_y [m/s2],acc_z [m/s2]"
    np.savetxt(files / "shaken.csv", table, "%.9g", ",", header=head, comments="")
    given = (
        "filter",
        str(files / "accelerometer.json"),
        str(files / "terms.json"),
        "--vibration",
        str(files / "shaken.csv"),
    )
    content = call_json(capsys, *given, "--filter-rate", "200 Hz", "--rectification", "10 ug/g^2")
    lines = {one["source"]: one["size"] for one in content["budgets"][0]["lines"]}
    assert lines["vibration folded back"] == pytest.approx([np.sqrt(8.0 / 200.0)] * 3, rel=0.01)
    assert lines["rectified vibration"] == pytest.approx([10e-6 * 9.80665 * 8.0 / 9.80665**2] * 3, rel=0.01)
    slow = call_json(capsys, *given, "--filter-rate", "2 kHz")
    assert "vibration_too_slow" in {one["code"] for one in slow["remarks"]}


def test_lines_in_a_record_are_named_and_left_out(capsys: pytest.CaptureFixture[str], files: Path) -> None:
    """As `allan --for` does it: no filter holds a line; in a recording, and in the terms that `allan` writes."""
    rng, t = np.random.default_rng(3), np.arange(60_000) * 0.01
    lines = 0.02 * np.sin(2 * np.pi * 3.3 * t) + 0.02 * np.sin(2 * np.pi * 11.7 * t)
    rest = rng.normal(0.0, 0.01, (60_000, 3)) + lines[:, np.newaxis]
    np.savetxt(files / "lines.csv", np.column_stack([t, rest]), "%.9g", ",",
               header="time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", comments="")  # fmt: skip
    given = ("filter", str(files / "gyro.json"))
    content = call_json(capsys, *given, str(files / "lines.csv"), "--for", "kalibr")
    (said,) = [one["what"] for one in content["remarks"] if one["code"] == "lines_left_out"]
    assert "3.3, 11.7 Hz" in said
    assert np.degrees(content["budgets"][0]["white"]) == pytest.approx([0.01 * np.sqrt(0.01)] * 3, rel=0.1)
    written = json.loads((files / "terms.json").read_text())
    both = [{"term": "sinusoid", "amplitude": 1e-3, "frequency": f} for f in (50.0, 75.0)]
    written["sensors"][0]["axes"][0]["terms"] += both
    (files / "lines.json").write_text(json.dumps(written))
    content = call_json(capsys, *given, str(files / "lines.json"))
    assert "gyro: lines in the record: x 50, 75 Hz" in "".join(one["what"] for one in content["remarks"])


def test_what_a_record_cannot_separate_is_taken_as_allan_takes_it(
    capsys: pytest.CaptureFixture[str], files: Path
) -> None:
    """Both commands give one setting for one record, and both let the user take another term."""
    rng, n = np.random.default_rng(2), 20_000
    walk = np.cumsum(rng.normal(0.0, 2e-5, (n, 3)), axis=0)
    np.savetxt(files / "walk.csv", np.column_stack([np.arange(n) * 0.1, walk + rng.normal(0.0, 0.003, (n, 3))]),
               "%.9g", ",", header="time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]", comments="")  # fmt: skip
    for take in ((), ("--take", "gauss_markov"), ("--take", "upper_limit")):
        own = call_json(capsys, "allan", str(files / "walk.csv"), "--for", "kalibr", *take)
        other = call_json(capsys, "filter", str(files / "gyro.json"), str(files / "walk.csv"), "--for", "kalibr", *take)
        wanted, found = (one["filters"]["kalibr"]["text"] for one in (own, other))
        walks = [[line for line in text.splitlines() if "gyroscope_random_walk" in line] for text in (wanted, found)]
        values = [float(one[0].split(":")[1].split("#")[0]) for one in walks]
        assert values[0] == pytest.approx(values[1], rel=1e-4)
        taken = [one for one in wanted.splitlines() if "taken" in one]
        assert len(taken) == len([one for one in other["remarks"] if one["code"] == "terms_taken"
                                  and "taken" in one["what"]])  # fmt: skip


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        ((), 3, "no noise of every axis"),
        (("terms.json", "--temperature-span", "20 K"), 2, "temperature span without temperature time"),
        (("terms.json", "--motion", "20 deg/s", "--motion-time", "0 s"), 2, "motion time of 0"),
        (("terms.json", "--motion", "20 deg"), 2, "--motion '20 deg'"),
        (("terms.json", "--turn-on", "1 g"), 2, "--turn-on '1 g'"),
        (("terms.json", "--without", "all"), 2, "There are: bias, temperature"),
        (("terms.json", "--for", "rocket"), 2, "There are: kalibr"),
        (("terms.json", "--vibration", "gone.csv"), 3, "gone.csv"),
        (("gyro.json",), 3, "no terms of noise"),
        (("terms.json", "--with", "gyro.json"), 2, "two models of a gyro"),
    ],
)
def test_what_is_refused_says_why(
    capsys: pytest.CaptureFixture[str], files: Path, words: tuple[str, ...], status: int, said: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(files)
    found, _, err = call(capsys, "filter", "gyro.json", *words)
    assert (found, said in err) == (status, True), err
