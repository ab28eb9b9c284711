"""Recordings of others through `allan`: plausible terms, and what stands in their way is remarked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.cli.__main__ import main
from inertialcal.core.show.rows import case_name

MPU = "data/sunsided_mpu6050_static"
STILL = "set-2__unmoved-with-x-pointing-forward-10min"
KNOCKED = "set-1__unmoved-x-pointing-up"
# Data sheet of the MPU-6050 (PS-MPU-6000A, 3.4): 0.005 deg/s/sqrt(Hz) and 400 ug/sqrt(Hz), typical
GYRO, ACC = 0.005 * 60.0, 400.0  # deg/sqrt(h), ug/sqrt(Hz)
LIKE = 4.0  # factor that a sensor may be off its data sheet by


def allan(capsys: pytest.CaptureFixture[str], path: Path, *words: str) -> dict[str, Any]:
    with pytest.raises(SystemExit) as left:
        main(["allan", str(path), *words, "--json"])
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    content: dict[str, Any] = json.loads(out)
    assert content["exit"] == left.value.code == 0
    return content


def values(content: dict[str, Any], quantity: str) -> list[float]:
    rows = [row for row in content["results"] if row["quantity"] == quantity and row["status"] == "estimated"]
    return [row["value"] for row in rows if not case_name(row)]


def remarks(content: dict[str, Any], code: str) -> list[str]:
    return [one["what"] for one in content["remarks"] if one["code"] == code]


def test_a_gyro_and_an_accelerometer_are_as_their_data_sheet_has_them(
    capsys: pytest.CaptureFixture[str], shared: Path
) -> None:
    folder = shared / MPU / STILL
    walks = values(allan(capsys, folder / "mpu6050_gyroscope.mat", "--unit", "gyro=deg/s"), "angle_random_walk")
    assert len(walks) == 3
    assert all(GYRO / LIKE < walk < GYRO * LIKE for walk in walks)
    falls = values(allan(capsys, folder / "mpu6050_accelerometer.mat", "--unit", "acc=g"), "velocity_random_walk")
    assert len(falls) == 3
    assert all(ACC / LIKE < fall < ACC * LIKE for fall in falls)


def test_a_disturbance_is_remarked_and_left_out(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    path = shared / MPU / KNOCKED / "mpu6050_gyroscope.mat"
    content = allan(capsys, path, "--unit", "gyro=deg/s")
    told = remarks(content, "disturbed")
    assert len(told) == 3
    assert all("excluded" in what for what in told)
    left_out = values(content, "angle_random_walk")
    kept = allan(capsys, path, "--unit", "gyro=deg/s", "--disturbed", "keep")
    assert all("kept in" in what for what in remarks(kept, "disturbed"))
    assert np.mean(values(kept, "angle_random_walk")) != pytest.approx(np.mean(left_out))


def test_a_warm_up_is_remarked_until_it_is_left_out(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    path = shared / "data/noise/l3g_gyro_x/gyro2_x.txt"
    words = ("--sample-rate", "100", "--unit", "column_1=deg/s")  # nobody said the rate: 100 Hz for the sake of it
    content = allan(capsys, path, *words)
    (told,) = remarks(content, "warm_up")
    assert "drifts by -14" in told  # from 0.98 to 0.64 deg/s, as the origin says: over 1,000 deg/h
    assert values(content, "rate_random_walk")
    cut = allan(capsys, path, *words, "--warm-up", "30 min")
    assert not remarks(cut, "warm_up")
    (slow,), (rest,) = values(content, "rate_random_walk"), values(cut, "rate_random_walk") or [0.0]
    assert rest < slow


def test_a_recording_without_unit_works_in_that_of_the_file_with_the_hint(
    capsys: pytest.CaptureFixture[str], shared: Path
) -> None:
    content = allan(capsys, shared / "data/noise/l3g_gyro_x/gyro2_x.txt", "--sample-rate", "100")
    assert {row["unit"] for row in content["results"] if row["quantity"] == "bias_instability"} == {"file unit"}
    (remark,) = (one for one in content["remarks"] if one["code"] == "no_unit")
    assert "0.00875, as ST" in remark["do"]


def test_the_first_minute_of_a_hand_held_record_in_counts(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    path = shared / "data/imu_tk_xsens_mti/xsens_gyro.mat"
    content = allan(
        capsys, path, "--to", "45", *(word for k in (2, 3, 4) for word in ("--column", f"column_{k}")),
        *(word for k in (2, 3, 4) for word in ("--scale-factor", f"column_{k}=4778 count/(rad/s)")),
    )  # fmt: skip
    walks = values(content, "angle_random_walk")
    assert len(walks) == 3
    assert all(0.3 < walk < 6.0 for walk in walks)  # Xsens MTi: 0.05 deg/s/sqrt(Hz), 3 deg/sqrt(h)


def test_a_filtered_record_of_vibration_has_terms_inside_its_band(
    capsys: pytest.CaptureFixture[str], shared: Path
) -> None:
    """Above the averaging times of the filter the terms explain the curve.

    Ambient vibration of x and z falls from 2 Hz on, which is no filter: the cut-off of the header stands.
    """
    (path,) = (shared / "data/pims_pad").glob("*.121f03006")
    content = allan(capsys, path)
    assert not any(row["quantity"] == "line_amplitude" for row in content["results"])  # those of the stop band are none
    assert ["cut-off stated at 6 Hz" in one for one in remarks(content, "low_pass")] == [True, True, True]
    assert not remarks(content, "cut_off_disagrees")
    assert not remarks(content, "terms_do_not_explain")


def test_a_sensor_turned_by_hand_has_no_limit_next_to_a_ramp_alone(
    capsys: pytest.CaptureFixture[str], shared: Path
) -> None:
    """Nothing but a ramp is left at the limit, and a ramp does not scatter."""
    path = shared / MPU / "set-1__rotate-360ccw-around-z-pointing-up/mpu6050_gyroscope.mat"
    content = allan(capsys, path, "--unit", "gyro=deg/s")
    ramp = [one["status"] for one in content["results"] if (one["quantity"], one["axis"]) == ("rate_ramp", "z")]
    assert set(ramp) == {"not_estimated"}
