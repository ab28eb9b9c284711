"""Files of every release are read by this version: models compensate to what was put in, figures are those written."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from add_release import BIAS, ENDINGS, KEPT, MATRIX, READ, recording, schedule

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule
from inertialcal.sensors.model.terms import values

RELEASES = sorted(path.name for path in KEPT.iterdir() if path.is_dir() and path.name[0].isdigit())
INPUTS = np.array([[1.0, -2.0, 3.0], [0.5, 0.25, -0.125], [0.0, 0.0, 0.0]])  # rad/s, or m/s2
ROUNDING = 1e-12
STANDARD_GRAVITY = 9.80665  # m/s2
AUTOPILOTS = ("px4", "ardupilot")  # of gyros biases alone, of accelerometers scale factors too, to 8 digits
HOLDS_NO_BIAS, HOLDS_NO_MATRIX = ("kalibr-model",), ("ros", *AUTOPILOTS)

pytestmark = pytest.mark.parametrize("release", RELEASES)


def readings(condition: str = "", format_name: str = "") -> Array:
    """What the sensor of ``add_release.py`` reads at the inputs, without the terms that a format cannot hold."""
    matrix = np.eye(3) if format_name in HOLDS_NO_MATRIX else np.array(MATRIX)
    bias = np.zeros(3) if format_name in HOLDS_NO_BIAS else np.array(BIAS[condition or "air"])
    found: Array = INPUTS @ matrix.T + bias
    return found


def compensated(model: ic.SensorModel, read: Array) -> Array:
    axes = dict(zip("xyz", "xyz", strict=True))
    done = ic.compensate(model, read, axes, units=dict.fromkeys("xyz", model.output_unit), sample_rate=100.0)
    return done.array(["x", "y", "z"])


@pytest.mark.parametrize("name", ["gyro", "accelerometer"])
def test_a_model_compensates(release: str, name: str) -> None:
    model = ic.load_model(KEPT / release / f"{name}.json")
    assert (model.kind, model.axes, model.judged) == (name, ("x", "y", "z"), True)
    assert compensated(model, readings()) == pytest.approx(INPUTS, abs=ROUNDING)
    assert model.estimate is not None
    assert np.diag(model.estimate.covariance) == pytest.approx(1e-6)
    assert "maker part, serial 7" in str(model)


def test_models_by_condition_compensate(release: str) -> None:
    models = ic.load_models(KEPT / release / "gyro_by_condition.json")
    assert list(models) == ["air", "vacuum"]
    for condition, model in models.items():
        assert compensated(model, readings(condition)) == pytest.approx(INPUTS, abs=ROUNDING)


def test_the_published_model_from_counts_is_that_of_the_catalogue(release: str) -> None:
    kept, now = ic.load_model(KEPT / release / "from_counts.json"), ic.load_model("flight_unit")
    assert kept.chain is not None
    assert [one.name for one in kept.parameters] == [one.name for one in now.parameters]
    assert values(kept.parameters, kept.terms) == pytest.approx(values(now.parameters, now.terms), rel=ROUNDING)


@pytest.mark.parametrize("name", READ)
def test_models_in_formats_of_others_compensate(release: str, name: str) -> None:
    model = ic.load_model(f"{KEPT / release / f'exported.{name}'}#gyro")
    assert compensated(model, readings(format_name=name)) == pytest.approx(INPUTS, abs=1e-9)  # digits of the formats


@pytest.mark.parametrize("name", AUTOPILOTS)
def test_accelerometers_of_autopilots_compensate(release: str, name: str) -> None:
    model = ic.load_model(f"{KEPT / release / f'exported.{name}'}#accelerometer")
    read = INPUTS * np.diag(MATRIX) + np.array(BIAS["air"])
    assert compensated(model, read) == pytest.approx(INPUTS, abs=1e-7)


@pytest.mark.parametrize("ending", ENDINGS)
def test_recordings_are_read(release: str, ending: str) -> None:
    written, read = recording(), ic.read(KEPT / release / f"recording.{ending}")
    names = [one.name for one in written.channels]
    assert {one.unit for one in read.channels} == {"rad/s", "m/s^2"}
    assert len(read) == len(written)
    assert [(one.quantity, one.axis) for one in read.channels] == [tuple(name.split("_")) for name in names]
    assert np.array_equal(read.array(), written.array())
    assert read.time_ns is not None
    assert np.array_equal(np.asarray(read.time_ns), np.asarray(written.time_ns))


def test_a_schedule_is_read(release: str) -> None:
    written, read = schedule(), read_schedule(KEPT / release / "schedule.csv")
    assert (read.dwell, read.move, read.drive) == (written.dwell, written.move, written.drive)
    for name in ("start", "position", "applied"):
        assert getattr(read, name) == pytest.approx(getattr(written, name), rel=ROUNDING)


def test_models_are_compared(release: str) -> None:
    folder = KEPT / release
    found = ic.compare(folder / "gyro.json", folder / "gyro.json")
    assert len(found.differences) == 12  # a matrix of 3 by 3, and three biases
    assert all(one.row.value == 0.0 for one in found.differences)


def test_results_and_certificate_hold_the_same_figures(release: str) -> None:
    folder = KEPT / release
    assert ic.compare(folder / "results.json", folder / "results.json").differences
    rows = json.loads((folder / "results.json").read_text(encoding="utf-8"))["results"]
    written = {f"{row['value'] / STANDARD_GRAVITY / 1e6:.3f}" for row in rows if row["unit"] == "count/s/g"}
    printed = str(ic.read_certificate(folder / "certificate.xml"))
    assert "certificate 2026-014 of Inertial Laboratory" in printed
    stated = set(re.findall(r"scale_factor_x +\(([\d.]+) ± [\d.]+\)e\+06 .* count/s/\(m/s\^2\)", printed))
    assert stated
    assert stated <= written


def test_the_campaign_is_read(release: str, tmp_path: Path) -> None:
    for name in ("campaign.toml", "table4.csv"):
        shutil.copy(KEPT / release / name, tmp_path)
    assert not [one for one in ic.check(tmp_path).remarks if one.severity == "error"]


def test_the_files_are_small(release: str) -> None:
    assert sum(path.stat().st_size for path in (KEPT / release).iterdir()) < 300_000
