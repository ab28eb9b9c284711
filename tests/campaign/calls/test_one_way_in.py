"""Nouns: a command, Python and a campaign give the same rows of one file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import inertialcal
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.rigs.hand_held.rig import Bench, build
from typed_commands import same_rows

pytestmark = pytest.mark.usefixtures("undrawn")

RATE = """rate [deg/s],x [deg/s],std [deg/s],run
-4,-4.021,0.002,1
-2,-2.013,0.002,1
0,-0.004,0.002,1
2,2.003,0.002,1
4,4.012,0.002,1
-4,-4.020,0.002,2
-2,-2.012,0.002,2
0,-0.005,0.002,2
2,2.004,0.002,2
4,4.011,0.002,2
"""


def warm_recording(path: Path, seed: int, rows: int = 4000) -> Path:
    """Write a gyro whose bias follows its temperature."""
    rng = np.random.default_rng(seed)
    time = np.arange(rows) * 2.0
    temperature = 20.0 + 30.0 * np.sin(2 * np.pi * time / time[-1]) + 0.01 * rng.standard_normal(rows)
    reading = 0.05 - 0.003 * (temperature - 20.0) + 0.003 * rng.standard_normal(rows)
    table = np.column_stack([time, reading, temperature])
    np.savetxt(path, table, fmt="%.9f", delimiter=",", header="time [s],gyro_x [deg/s],temperature [degC]", comments="")
    return path


def test_rate_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "table.csv"
    file.write_text(RATE)
    settings = {"axis": "x", "standards": {"rate_table.rate": "0.05 %"}, "latitude": "36.6 deg"}
    found = same_rows(capsys, "rate-table", [file], tmp_path / "campaign", **settings)
    assert found.plan.latitude == pytest.approx(np.radians(36.6))


def test_thermal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [warm_recording(tmp_path / f"warm_{seed}.csv", seed) for seed in (1, 2)]
    same_rows(capsys, "thermal", files, tmp_path / "campaign", at=["-5 degC"], standards={"converter.reference": "1 %"})


def laid_by_hand(folder: Path, variant: Literal["tumble", "ferraris"], records: int = 1) -> list[Path]:
    """Write records of a unit laid by hand."""
    bench = Bench(variant=variant, positions=14, rounds=1, records=records, dwell=2.5, first=4.0)
    paths = []
    for number, recording in enumerate(build(bench, 1).recordings.values(), 1):
        paths.append(folder / f"hand{number}.csv")
        paths[-1].write_text(csv_text(recording), encoding="utf-8")
    return paths


STATED: dict[str, Any] = {
    "units": {"acc": "m/s2", "gyro": "rad/s"}, "gravity": "9.807 m/s2", "latitude": "45.8 deg", "height": "300 m",
    "standards": {"gravity.value": "0.0003 m/s2", "clock.rate": "20 ppm"},
}  # fmt: skip


def test_positions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = laid_by_hand(tmp_path, "tumble", 2)
    found = same_rows(capsys, "positions", files, tmp_path / "campaign", **STATED)
    assert {row.key.sensor for row in found.rows} == {"accelerometer", "gyro"}
    assert (found.plan.gravity, found.plan.latitude) == (9.807, pytest.approx(np.radians(45.8)))


def test_positions_like_a_campaign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = laid_by_hand(tmp_path, "tumble", 2)
    same_rows(capsys, "positions", files[:1], tmp_path / "campaign", **STATED)
    settings = {"like": str(tmp_path / "campaign"), "g_sensitivity": False}
    found = same_rows(capsys, "positions", files, tmp_path / "another", **settings)
    assert found.plan.gravity == 9.807
    assert {row.unit for row in found.rows if row.quantity == "bias"} == {"m/s^2", "rad/s"}
    assert len(found.inputs) == 2


@pytest.mark.slow
def test_positions_like_a_rig_give_the_rows_of_its_campaign(tmp_path: Path) -> None:
    inertialcal.simulate("hand_held", tmp_path / "twin", seed=1)
    records = [tmp_path / "twin" / "recordings" / f"hand{number}.csv" for number in (1, 2)]
    found = inertialcal.positions(records[0], hold_out=[records[1]], like=tmp_path / "twin")
    outcome = run(tmp_path / "twin", write=False)
    for test, own in (("imu", "positions"), ("imu_held_out", "positions_held_out")):
        theirs = [figure(row) for row in outcome.results["results"] if row["test"] == test]
        assert [figure(row.to_dict()) for row in found.rows if row.test == own] == theirs
    assert found.results["closed_loop"]["axes"] == outcome.results["closed_loop"]["axes"]


def test_positions_of_known_orientation_and_of_one_sensor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (file,) = laid_by_hand(tmp_path, "ferraris")
    settings = STATED | {"orientations": "faces", "sensor": "acc", "units": {"acc": "m/s2"}}
    settings["standards"] = {"gravity.value": "0.0003 m/s2", "fixture.orientation": "0.1 deg"}
    found = same_rows(capsys, "positions", [file], tmp_path / "campaign", **settings)
    assert {row.key.sensor for row in found.rows} == {"accelerometer"}
    assert found.result.acc.known


def test_positions_of_a_table_in_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng, file = np.random.default_rng(1), tmp_path / "table.csv"
    lines = ["x,y,z,acc_x,acc_y,acc_z,acc_x_std,acc_y_std,acc_z_std,samples"]
    for up in np.repeat([*np.eye(3), *-np.eye(3)], 2, axis=0):
        mean = 32768.0 + 400.0 * 9.8 * up + rng.normal(0.0, 0.5, 3)
        lines.append(",".join([*(f"{one:g}" for one in up), *(f"{one:.3f}" for one in mean), "4", "4", "4", "100"]))
    file.write_text("\n".join(lines) + "\n")
    found = same_rows(
        capsys, "positions", [file], tmp_path / "campaign", units={"acc": "count"}, gravity="9.8 m/s2",
        acc_zero={"x": "32768", "y": "32768", "z": "32768"},
    )  # fmt: skip
    scale = {row.axis: row.value for row in found.rows if row.quantity == "scale_factor" and row.u is not None}
    assert scale == {axis: pytest.approx(400.0, rel=1e-3) for axis in "xyz"}


@pytest.mark.slow
def test_like_a_campaign(tmp_path: Path) -> None:
    inertialcal.simulate("npsat1", tmp_path / "twin", seed=1)
    files = [tmp_path / "twin" / "recordings" / f"ambient_{number}.csv" for number in range(1, 6)]
    found = inertialcal.thermal(files, like=tmp_path / "twin")
    outcome = run(tmp_path / "twin", write=False)
    own = {figure(row) for row in outcome.results["results"] if row["test"] == "thermal_ambient"}
    assert {figure(row.to_dict()) for row in found.rows} <= own
    assert len(found.rows) > 80


def figure(row: dict[str, Any]) -> tuple[object, ...]:
    """Return what a row is of, and its numbers."""
    return row["quantity"], row["axis"], row["value"], row["u"], row["dof"], str(row["interval"])


def test_arrays_and_recordings(tmp_path: Path) -> None:
    file = warm_recording(tmp_path / "warm.csv", 3)
    of_file = inertialcal.thermal(file)
    of_recording = inertialcal.thermal(inertialcal.read(file))
    assert [row.to_dict() for row in of_file.rows] == [row.to_dict() for row in of_recording.rows]
