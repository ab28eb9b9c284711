"""Files as people have them: heads in G, formats of recorders, recordings of others on a shaker."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat, wavfile

from independent.vibration.random_run import G, Run, simulate
from typed_commands import call_json

RUN = Run(nodes=((20.0, 0.01), (80.0, 0.04), (200.0, 0.04), (500.0, 0.01)), rate=1280.0, duration=12.0, error=0.3)
PROFILE = "frequency [Hz],density [G2/Hz]\n20,0.01\n80,0.04\n200,0.04\n500,0.01\n"
FLAT = "frequency [Hz],density [g2/Hz]\n20,0.001\n1000,0.001\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with one run in several formats, and its profile."""
    x = simulate(RUN, 1)[0][:, 0] / G
    t = np.arange(len(x)) / RUN.rate
    for name, head in (
        ("g.csv", "time_s,table [g]"),
        ("upper.csv", "time_s,table [G]"),
        ("rms.csv", "time_s,table (Grms)"),
    ):
        np.savetxt(tmp_path / name, np.column_stack([t, x]), "%.6f", ",", header=head, comments="")
    wavfile.write(tmp_path / "run.wav", round(RUN.rate), x.astype(np.float32))
    savemat(tmp_path / "run.mat", {"t": t, "table": x})
    (tmp_path / "profile.csv").write_text(PROFILE, encoding="utf-8")
    (tmp_path / "flat.csv").write_text(FLAT, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def level(said: dict[str, Any]) -> float:
    """Return the overall level of the control [g]."""
    found = next(one for one in said["results"] if one["quantity"] == "acceleration_rms" and one["axis"] == "control")
    return float(found["value"]) * (1.0 if found["unit"] == "g" else 1.0 / G)


def codes(said: dict[str, Any]) -> set[str]:
    return {one["code"] for one in said["remarks"]}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    "typed",
    [
        ("g.csv", "--control", "table"), ("upper.csv", "--control", "table"), ("rms.csv", "--control", "table"),
        ("run.wav", "--control", "channel_1", "--unit", "channel_1=g"),
        ("run.mat", "--control", "table", "--unit", "table=g"),
    ],
)  # fmt: skip
def test_one_run_is_the_same_in_every_format(typed: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    said = call_json(capsys, "vibration", *typed, "--profile", "profile.csv", "--tolerance", "3 dB")
    assert said["exit"] == 0
    assert level(said) == pytest.approx(3.54, abs=0.1)


@pytest.mark.usefixtures("folder")
def test_recordings_of_others_on_a_shaker_with_a_sine_are_no_random_run(
    shared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two recorders on a shaker at 100 Hz: the level over time is read, what it is is said, and no verdict given."""
    for name, rest, rms in (
        ("SSX70065.IDE", (), 7.2),
        ("DAQ12006_000005.IDE", ("--topic", "100g PE Acceleration"), 4.56),
    ):
        path = str(shared / "data" / "vibration" / "endaq_ide" / name)
        typed = ("vibration", path, "--control", "acc_Y", "--profile", "flat.csv", "--tolerance", "3 dB", *rest)
        said = call_json(capsys, *typed)
        assert said["exit"] == 4
        assert "not_random" in codes(said)
        assert level(said) == pytest.approx(rms, rel=0.02)
        asked = call_json(capsys, "vibration", path, "--profile", "flat.csv", *rest)
        assert asked["exit"] == 2
        assert "--control" in asked["errors"][0]["do"]


@pytest.mark.usefixtures("folder")
def test_a_random_run_of_others_is_read_with_what_it_does_not_hold(
    shared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A shaker sampled at 1.7 kHz: the profile goes beyond, and is another one."""
    path = str(shared / "data" / "vibration" / "hrshm_dataset7" / "amplitude__7_Impact_0.0_vibration_1.lvm")
    said = call_json(
        capsys, "vibration", path, "--topic", "excitation_composite", "--control", "accelerometer_base",
        "--response", "accelerometer_board", "--unit", "accelerometer_base=g", "--unit", "accelerometer_board=g",
        "--profile", "flat.csv",
    )  # fmt: skip
    assert said["exit"] == 4
    assert {"sample_rate", "band_off"} <= codes(said)
    assert level(said) == pytest.approx(0.224, rel=0.02)
