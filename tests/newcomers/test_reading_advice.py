"""Messages of reading that say which option to add: obeyed on the file that caused them, the clock is right."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newcomer_boards import Board, board_at_rest
from obedience import next_command, options_of

from typed_commands import call

START = 1_710_234_900  # 2024-03-12 09:15:00 UTC
BOARD: Board = board_at_rest(seconds=15.0)


@dataclass(frozen=True)
class Advised:
    """A file that leaves something open: its first column, the code of the message, what its owner knows."""

    name: str
    head: str
    first: tuple[str, ...]
    code: str
    known: str = ""  # in place of UNIT
    start: float = 0.0  # [s]
    header: bool = True


def numbers(scale: float, start: float = 0.0, digits: int = 0) -> tuple[str, ...]:
    """Return stamps of 100 Hz."""
    return tuple(f"{(start + t) * scale:.{digits}f}" for t in BOARD.time)


CASES = (
    Advised("whole", "time", numbers(1e3), "time_unit_unknown", "ms"),
    Advised("blank_in_the_name", "stamp time", numbers(1e9), "time_unit_unknown", "ns"),
    Advised("fractions", "t", numbers(1e3, 0.0005, 1), "time_unit_assumed", start=0.0005),
    Advised("milliseconds_called_seconds", "time [s]", numbers(1e3, START), "epoch_digits", start=START),
    Advised("nanoseconds_called_seconds", "unix_s", numbers(1e9, START), "epoch_digits", start=START),
    Advised("no_header", "", numbers(1e3), "time_not_taken", "ms", header=False),
)


def text_of(case: Advised) -> str:
    """Return the file of a case."""
    names = [case.head] * bool(case.first) + [f"gyro_{axis} [rad/s]" for axis in "xyz"]
    rows = [",".join([*case.first[i : i + 1], *(f"{one:.6f}" for one in BOARD.gyro[i])])
            for i in range(len(BOARD.time))]  # fmt: skip
    return "\n".join([",".join(names)] * case.header + rows) + "\n"


def messages(content: Any) -> dict[str, str]:
    """Return code and advice of what ``info`` says, in errors and remarks."""
    found = [*content["errors"], *(one for result in content["results"] for one in result["remarks"])]
    return {one["code"]: one["do"] for one in found}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_advice_of_reading_gives_the_clock(
    case: Advised, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text_of(case))
    said = messages(json.loads(call(capsys, "info", str(path), "--json")[1]))
    options = [word for one in options_of(said[case.code]) for word in shlex.split(one.replace("UNIT", case.known))]
    assert options, said
    status, out, err = call(capsys, "info", str(path), *options, "--json")
    assert status == 0, err
    found = json.loads(out)["results"][0]
    assert not {one["code"] for one in found["remarks"]} & {one.code for one in CASES}
    assert found["time"]["sample_rate"] == pytest.approx(100.0, rel=1e-4)
    start = found["time"]["start"]
    if case.start > 1e9:
        assert start.startswith("2024-03-12T09:15:00.000000000")
    else:
        assert float(start.removesuffix(" s")) == pytest.approx(case.start, abs=1e-9)


def test_a_file_without_time_is_asked_for_its_sample_rate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text_of(Advised("no_time", "", (), "")))
    words = [word.replace("HZ", "100") for word in next_command(capsys, str(path), {})]
    assert words == ["info", str(path), "--sample-rate", "100"]
    words = next_command(capsys, str(path), {}, *words[2:])
    assert words == ["allan", str(path), "--sample-rate", "100.0"]
    assert call(capsys, *words)[0] == 0


def test_an_option_that_a_format_has_no_use_for_is_to_be_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import pandas as pd

    path = tmp_path / "log.parquet"
    pd.DataFrame({"t [s]": BOARD.time, "gyro_x [rad/s]": BOARD.gyro[:, 0]}).to_parquet(path)
    for option, value in (("--skip", "3"), ("--decimal", "comma"), ("--frame", "sensor")):
        status, _, err = call(capsys, "info", str(path), option, value)
        assert status != 0
        assert f"Leave {option} out" in err
    assert call(capsys, "info", str(path))[0] == 0


def test_units_are_asked_for_and_none_is_invented(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Messages of ROS are in units: those of the file are asked for, since deg/s of rad/s would be wrong."""
    path = tmp_path / "log.csv"
    path.write_text(text_of(Advised("no_units", "t", numbers(1.0, 0.0, 2), "")).replace(" [rad/s]", ""))
    target = tmp_path / "log.mcap"
    content = json.loads(call(capsys, "convert", str(path), str(target), "--json")[1])
    (error,) = content["errors"]
    options = options_of(error["do"])
    assert options == ["--unit gyro=UNIT", "--unit acc=UNIT"]
    status, _, err = call(capsys, "convert", str(path), str(target), "--unit", "gyro=rad/s")
    assert status == 0, err
    (found,) = json.loads(call(capsys, "info", str(target), "--json")[1])["results"]
    (gyro_x,) = [one for one in found["channels"] if one["name"] == "angular_velocity.x"]
    assert gyro_x["unit"] == "rad/s"
    assert gyro_x["mean"] == pytest.approx(float(np.mean(BOARD.gyro[:, 0])), abs=1e-6)
