"""`sine`: a command, Python and a campaign give the same rows of the same file, to the last bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.units import factor
from inertialcal.physics.motion.schedule import repeated
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from typed_commands import same_rows

APPLIED = 2e-6  # [m/s^2]


def recording(path: Path, head: str, size: float = 1.0, axes: int = 1) -> Path:
    """Write a drive of 480 s in drift and noise, a reading every 120 s."""
    rng = np.random.default_rng(1)
    time = 120.0 * np.arange(100)
    wave = np.tile([0.0, 1.0, 0.0, -1.0], 25)
    columns = [size * (wave + 0.01 * time / 480.0 + 0.05 * rng.standard_normal(100)) for _ in range(axes)]
    np.savetxt(path, np.column_stack([time, *columns]), "%.9g", ",", header=f"time [s],{head}", comments="")
    return path


def schedule(path: Path) -> Path:
    """Write the dwells of the drive."""
    applied = [0.0, APPLIED, 0.0, -APPLIED]
    order = [0.3, 0.1, 0.3, 0.4]
    write_schedule(path, repeated(order, applied, cycles=25, dwell=100.0, move=20.0, drive="sine", u_applied=0.01))
    return path


def test_a_triad(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = recording(tmp_path / "triad.csv", "acc_x [ug],acc_y [ug],acc_z [ug]", axes=3)
    found = same_rows(capsys, "sine", [file], tmp_path / "campaign", period="480 s", phase="0 deg", averaging="20 s")
    assert {row.axis for row in found.rows} == {"x", "y", "z"}
    assert found.rows[0].unit == "ug"


def test_a_column_without_a_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = recording(tmp_path / "pulses.csv", "rate,other", axes=2)
    found = same_rows(capsys, "sine", [file], tmp_path / "campaign", columns={"rate": "rate"}, period="480 s")
    assert found.rows[0].unit == "file unit"


def test_a_schedule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = recording(tmp_path / "output.csv", "output [V]", 1e-3)
    order = str(schedule(tmp_path / "order.csv"))
    found = same_rows(capsys, "sine", [file], tmp_path / "campaign", schedule=order)
    scale = next(row for row in found.rows if row.quantity == "scale_factor")
    assert scale.unit == "V/(m/s^2)"
    assert scale.value == pytest.approx(1e-3 / APPLIED, rel=0.05)


def test_the_scale_factor_of_an_accelerometer(tmp_path: Path) -> None:
    file = recording(tmp_path / "ug.csv", "acc_x [ug]", APPLIED * factor("m/s^2", "ug"))
    found = ic.sine(file, schedule=str(schedule(tmp_path / "order.csv")))
    scale = next(row for row in found.rows if row.quantity == "scale_factor")
    value = scale.value or 0.0
    assert value * {"ug/(m/s^2)": factor("ug", "m/s^2"), "1": 1.0}[scale.unit] == pytest.approx(1.0, rel=0.05)


def test_like_a_campaign(tmp_path: Path) -> None:
    file = recording(tmp_path / "triad.csv", "acc_x [ug],acc_y [ug],acc_z [ug]", axes=3)
    first = ic.sine(file, period="480 s", phase="0 deg")
    folder = first.write_campaign(tmp_path / "campaign").parent
    again = ic.sine(file, like=folder)
    assert [row.to_dict() for row in again.rows] == [row.to_dict() for row in first.rows]
