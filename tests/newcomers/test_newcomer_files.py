"""Files of fifteen formats: what ``info`` says to type next gives the truth, in two commands."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newcomer_boards import (
    ACC_BIASES,
    ACC_ERRORS,
    ACC_NOISE,
    GYRO_BIASES,
    GYRO_NOISE,
    Board,
    G,
    board_at_rest,
    six_faces,
)
from newcomer_files import KEPT, Kept
from obedience import filled, next_command, next_commands, obeyed, options_of

from typed_commands import call

SHEET: dict[str, str] = {}
WHITE = {
    "gyro": ("angle_random_walk", np.degrees(GYRO_NOISE) / np.sqrt(100.0) * 60.0),
    "accelerometer": ("velocity_random_walk", ACC_NOISE / np.sqrt(100.0) / G * 1e6),
}
FEW, NEAR = 5.0, 0.08  # standard uncertainties, and relative difference of white noise, that an estimate may be off
ROUND = 2e-4  # m/s^2, and rad/s a hundredth of it: of numbers with few digits

UNSAID = {"miniSEED": 1e6, "WAV": 1.0 / G}  # what the numbers of m/s^2 are multiplied with, where no unit is said


@cache
def recorded(noun: str) -> Board:
    return board_at_rest() if noun == "allan" else six_faces()


def check_white(rows: list[dict[str, Any]], kept: Kept) -> None:
    for sensor in kept.sensors:
        quantity, true = WHITE[sensor]
        if kept.kind in UNSAID:
            quantity, true = "random_walk", UNSAID[kept.kind] * ACC_NOISE / np.sqrt(100.0)
        found = [one for one in rows if one["quantity"] == quantity and one["value"] is not None]
        assert len(found) == 3, (sensor, [one["quantity"] for one in rows])
        for one in found:
            assert one["value"] == pytest.approx(true, rel=NEAR), one["axis"]


def check_positions(rows: list[dict[str, Any]], kept: Kept) -> None:
    for sensor, quantity, truth, scale in (
        ("accelerometer", "scale_factor_error", 100.0 * ACC_ERRORS, 1.0),
        ("accelerometer", "bias", ACC_BIASES, ROUND),
        ("gyro", "bias", GYRO_BIASES, 0.01 * ROUND),
        ("gyro", "scale_factor_error", np.zeros(3), 0.02),
    ):
        if sensor not in kept.sensors:
            continue
        for axis, true in zip("xyz", truth, strict=True):
            (one,) = [
                row for row in rows
                if (row["quantity"], row["axis"]) == (quantity, axis) and row["sensor"].startswith(sensor[:3])
                and row["u"] is not None
            ]  # fmt: skip
            wanted = np.degrees(true) if one["unit"] == "deg/s" else true
            assert abs(one["value"] - wanted) <= FEW * one["u"] + scale, (sensor, quantity, axis, one["value"], true)


@pytest.mark.parametrize("kept", KEPT, ids=lambda kept: kept.name)
def test_what_info_prints_is_run_as_printed_and_gives_the_truth(
    kept: Kept, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two commands from file to result: ``info FILE``, and one that it prints for each recording of the file."""
    path = tmp_path / kept.name
    kept.write(recorded(kept.noun), path)
    printed = next_commands(capsys, str(path))
    assert len(printed) == kept.recordings
    of_each = [(one,) for one in kept.sensors] if kept.recordings > 1 else [kept.sensors]
    for command, sensors in zip(printed, of_each, strict=True):
        program, noun, *words = shlex.split(command)
        assert (program, noun) == ("inertialcal", kept.noun)
        status, out, err = call(capsys, noun, *words, "--json")
        assert status == 0, err
        check = check_white if kept.noun == "allan" else check_positions
        check(json.loads(out)["results"], replace(kept, sensors=sensors))


@pytest.mark.parametrize("topic", ["sensor_gyro", "sensor_accel"])
def test_the_next_command_says_again_what_was_said_of_the_file(
    topic: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (kept,) = [one for one in KEPT if one.name == "sensors.ulg"]
    path = tmp_path / kept.name
    kept.write(recorded("allan"), path)
    words = next_command(capsys, str(path), SHEET, "--topic", topic)
    content, commands = obeyed(capsys, words, SHEET)
    assert commands == 1
    quantity, true = WHITE["gyro" if topic == "sensor_gyro" else "accelerometer"]
    found = [one["value"] for one in content["results"] if one["quantity"] == quantity]
    assert found == pytest.approx([true] * 3, rel=NEAR)


def test_the_unit_that_no_header_of_a_sound_has_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (kept,) = [one for one in KEPT if one.kind == "WAV"]
    path = tmp_path / kept.name
    kept.write(recorded("allan"), path)
    content = json.loads(call(capsys, "allan", str(path), "--json")[1])
    (warning,) = [one for one in content["remarks"] if one["code"] == "no_unit"]
    words = [one.replace("UNIT", "g") for one in filled(options_of(warning["do"].replace("UNIT (", "g (")), SHEET)]
    status, out, err = call(capsys, "allan", str(path), *words, "--json")
    assert status == 0, err
    check_white(json.loads(out)["results"], replace(kept, kind="WAV with its unit"))
