"""Files of fifteen formats: what ``info`` says to type next gives the truth, in two commands."""

from __future__ import annotations

import json
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
from obedience import filled, next_command, obeyed, options_of

from typed_commands import call

SHEET: dict[str, str] = {}
WHITE = {
    "gyro": ("angle_random_walk", np.degrees(GYRO_NOISE) / np.sqrt(100.0) * 60.0),
    "accelerometer": ("velocity_random_walk", ACC_NOISE / np.sqrt(100.0) / G * 1e6),
}
FEW, NEAR = 5.0, 0.08  # standard uncertainties, and relative difference of white noise, that an estimate may be off
ROUND = 2e-4  # m/s^2, and rad/s a hundredth of it: of numbers with few digits

COUNTS = ("random_walk", 1e6 * ACC_NOISE / np.sqrt(100.0))


@cache
def recorded(noun: str) -> Board:
    return board_at_rest() if noun == "allan" else six_faces()


def check_white(rows: list[dict[str, Any]], kept: Kept) -> None:
    for sensor in kept.sensors:
        quantity, true = COUNTS if kept.kind == "miniSEED" else WHITE[sensor]
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


@pytest.mark.parametrize("kept", [one for one in KEPT if one.kind != "WAV"], ids=lambda kept: kept.name)
def test_what_info_says_to_type_gives_the_truth(kept: Kept, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / kept.name
    kept.write(recorded(kept.noun), path)
    words = [kept.noun, str(path)] if kept.choice else next_command(capsys, str(path), SHEET)
    assert words[0] == kept.noun
    content, commands = obeyed(capsys, words, SHEET)
    assert commands == (2 if kept.choice else 1)
    (check_white if kept.noun == "allan" else check_positions)(content["results"], kept)


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
    check_white(json.loads(out)["results"], kept)


TABLE = (Path(__file__).resolve().parents[2] / "docs/formats.md").read_text().split("## Which command takes what")[1]
CELLS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in TABLE.split("\n## ")[0].splitlines()
         if line.startswith("| ")]  # fmt: skip
OPTIONS = {
    ("WAV", "allan"): [word for i in (1, 2, 3) for word in ("--unit", f"channel_{i}=g")],
    ("WAV", "positions"): [word for i, axis in enumerate("xyz", 1)
                           for word in ("--column", f"acc_{axis}=channel_{i}", "--unit", f"channel_{i}=g")],
    ("miniSEED", "positions"): [word for axis, one in zip("xyz", "ENZ", strict=True)
                                for word in ("--column", f"acc_{axis}=GR_BOARD__H_N_{one}")] + ["--unit", "acc=count"],
}  # fmt: skip
OPTIONS["WAV", "psd"] = OPTIONS["WAV", "allan"]


def test_the_table_of_the_manual_has_every_format() -> None:
    assert [row[0] for row in CELLS[1:]] == list(dict.fromkeys(kept.kind for kept in KEPT))


@pytest.mark.parametrize("row", CELLS[1:], ids=lambda row: row[0])
def test_the_table_of_the_manual_is_true(row: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kind, *cells, written = row
    kept = next(one for one in KEPT if one.kind == kind)
    made = {noun: tmp_path / f"{noun}{Path(kept.name).suffix}" for noun in ("allan", "positions")}
    kept.write(board_at_rest(seconds=15.0), made["allan"])
    kept.write(recorded("positions"), made["positions"])
    for word, cell in zip(("info", "allan", "psd", "positions", "convert"), cells, strict=True):
        path = made.get(word, made["allan"])
        words = [word, str(path), *([str(tmp_path / "out.csv")] if word == "convert" else [])]
        if cell != "yes":
            content = json.loads(call(capsys, *words, "--json")[1])
            said = " ".join(one["do"] for one in [*content["errors"], *content.get("remarks", [])])
            assert cell.split("`")[1] in said
            words += OPTIONS[kind, word]
        status, _, err = call(capsys, *words)
        assert status == 0, (word, err)
    if written:
        target = tmp_path / f"made{written.strip('`')}"
        status, _, err = call(capsys, "convert", str(made["allan"]), str(target))
        assert status == 0, err
        assert call(capsys, "info", str(target))[0] == 0
