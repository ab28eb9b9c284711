"""``init`` on a terminal asks only for what the files do not say; what it writes runs, and gives the truth.

A pseudo-terminal stands for the user. The same as options, and with ``--yes``, gives the same file.
"""

from __future__ import annotations

import json
import math
import os
import select
import signal
import sqlite3
import sys
import time
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newcomer_boards import ACC_BIASES, GYRO_BIASES, board_at_rest, six_faces
from newcomer_files import Writer, dataflash_raw, ulog_sensors
from newcomer_tables import FILES
from newcomer_texts import FORMS
from newcomer_truths import BIASES, ERRORS, chamber

from inertialcal.campaign.start.folder import ENDINGS
from inertialcal.files.registry import READERS
from typed_commands import call

if sys.platform == "win32":
    pytest.skip("no pseudo-terminals", allow_module_level=True)
pty = pytest.importorskip("pty")

Capsys = pytest.CaptureFixture[str]
LONGEST = 120.0  # s: of a busy machine
ENTER = ""
CHAIN = ("--lsb", "5 V / 4095", "--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)")


def on_terminal(words: Sequence[str], answers: Sequence[str]) -> tuple[str, int]:
    """Run a command on a terminal, an answer for each prompt; return what it showed, and how it ended."""
    child, terminal = pty.fork()
    if child == 0:  # pragma: no cover - another process
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a runner in the background ignores it
        os.environ["COLUMNS"] = "200"
        os.execv(sys.executable, [sys.executable, "-m", "inertialcal", *words])
    shown, left, end = "", list(answers), time.monotonic() + LONGEST
    asked = 0
    while time.monotonic() < end:
        if not select.select([terminal], [], [], 0.2)[0]:
            continue
        try:
            part = os.read(terminal, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part.decode(errors="replace")
        last = shown.rsplit("\n", 1)[-1]
        if last.startswith("  ") and last.endswith((") ", "? ", "] ")) and len(shown) > asked and left:
            asked = len(shown)
            os.write(terminal, f"{left.pop(0)}\n".encode())
    else:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(terminal)
    assert not left, f"never asked for: {left}\n{shown}"
    return shown, os.waitstatus_to_exitcode(status)


def put(folder: Path, name: str) -> Path:
    """Write one of the newcomers' files into a folder."""
    made = next(one for one in FILES if one.name == name)
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(made.write(made.log()))
    return folder


def campaign(folder: Path) -> dict[str, object]:
    """Return what was written, without its name."""
    found = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    return {name: value for name, value in found.items() if name != "campaign"}


def bias(capsys: pytest.CaptureFixture[str], folder: Path, axis: str) -> tuple[float, float]:
    """Run a campaign; return the bias of an axis."""
    status, _, err = call(capsys, "run", str(folder), "-q")
    assert status == 0, err
    rows = json.loads((folder / "out/results.json").read_text())["results"]
    own = next(one for one in rows if (one["quantity"], one["axis"], one["method"]) == ("bias", axis, "result"))
    return own["value"], own["u"]


def test_it_asks_only_for_what_the_file_does_not_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = put(tmp_path / "asked", "turned_counts.csv")
    answers = [ENTER, "5 V / 4095", "2.5 V", "nonsense", "0.02 V/(deg/s)", ENTER, "ACME", "G-100", ENTER]
    shown, status = on_terminal(["init", str(folder)], answers)
    assert status == 0, shown
    assert "gyro_x, gyro_y, gyro_z without a unit: whole numbers up to" in shown
    assert "[count]" in shown
    assert "x follows the rate of the table" in shown
    assert "nonsense: " in shown
    assert "complete. Next: inertialcal run" in shown
    text = (folder / "campaign.toml").read_text()
    assert "# A reading is (lsb * count - reference) / scale_factor" in text
    value, u = bias(capsys, folder, "x")
    assert value == pytest.approx(BIASES["x"], abs=5 * u)
    same = put(tmp_path / "options", "turned_counts.csv")
    words = ["init", str(same), "--unit", "gyro=count", *CHAIN, "--axis", "x", "--maker", "ACME", "--part", "G-100"]
    assert call(capsys, *words, "--serial", "")[0] == 0
    assert campaign(same) == campaign(folder)


def test_each_axis_may_have_a_chain_of_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, same = (put(tmp_path / name, "turned_volts.csv") for name in ("asked", "options"))
    volts = {"x": "2.5 V", "y": "2.4 V", "z": "2.6 V"}
    factors = {"x": "0.02 V/(deg/s)", "y": "0.018 V/(deg/s)", "z": "0.025 V/(deg/s)"}
    typed = [", ".join(f"{axis}={text}" for axis, text in own.items()) for own in (volts, factors)]
    shown, status = on_terminal(["init", str(folder)], ["x=2.5 V, y=nonsense", *typed, ENTER, ENTER, ENTER, "7"])
    assert status == 0, shown
    words = [word for axis in "xyz" for word in ("--reference", f"{axis}={volts[axis]}", "--scale-factor",
                                                 f"{axis}={factors[axis]}")]  # fmt: skip
    assert call(capsys, "init", str(same), "--yes", *words, "--serial", "7")[0] == 0
    found = campaign(folder)
    assert found["sensors"]["suite"]["chain"]["zero"] == volts  # type: ignore[index]
    assert found == campaign(same)


def test_a_file_that_says_all_is_asked_for_the_sensor_alone(tmp_path: Path) -> None:
    folder = put(tmp_path / "all", "chamber_units.csv")
    shown, status = on_terminal(["init", str(folder)], [ENTER, ENTER, "7"])
    assert status == 0, shown
    assert "Unit?" not in shown
    assert "Axis" not in shown
    assert campaign(folder)["item"] == {"maker": "", "part": "", "serial": "7"}


def test_yes_takes_every_suggestion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = put(tmp_path / "yes", "chamber_counts.csv")
    status, out, err = call(capsys, "init", str(folder), "--yes", *CHAIN)
    assert status == 0, err
    assert "complete. Next: inertialcal run" in out
    value, u = bias(capsys, folder, "z")
    assert value == pytest.approx((1.0 + ERRORS["z"]) * BIASES["z"], abs=5 * u)


def test_a_question_without_a_suggestion_is_asked_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Which axis was turned is nowhere in a table of dwells of one: it is left to be filled in."""
    folder = put(tmp_path / "dwells", "dwells_units.csv")
    status, out, err = call(capsys, "init", str(folder), "--yes")
    assert status == 0, err
    assert "FILL IN" in out
    assert "FILL IN" in (folder / "campaign.toml").read_text()


def test_a_unit_that_nothing_gives_away_is_left_open(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Gravity shows in the three axes together, what a gyro reads in nothing."""
    rows = ["time_s,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z"]
    for n in range(1200):
        way = [(6.0, 6.0, 4.9), (-6.0, 4.9, 6.0), (4.9, -6.0, 6.0), (6.0, -4.9, -6.0)][n // 300]
        rows.append(",".join(f"{v + 0.003 * math.sin(n * k):.5f}" for k, v in enumerate((n / 100, *way, 0, 0, 0))))
    (tmp_path / "hand.csv").write_text("\n".join(rows), encoding="utf-8")
    status, out, err = call(capsys, "init", str(tmp_path), "--yes")
    assert status == 0, err
    assert "FILL IN" in out
    text = (tmp_path / "campaign.toml").read_text()
    assert 'unit = "m/s^2"' in text
    assert 'x = { column = "gyro_x", unit = "?" }  # FILL IN' in text


def test_no_number_of_the_data_sheet_is_invented(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = put(tmp_path / "open", "turned_volts.csv")
    assert call(capsys, "init", str(folder), "--yes")[0] == 0
    text = (folder / "campaign.toml").read_text()
    assert 'chain = { kind = "output", reference = "? V", scale_factor = "? V/(deg/s)" }  # FILL IN' in text
    assert call(capsys, "check", str(folder))[0] != 0


def test_dates_are_asked_for_where_they_can_be_read_in_two_ways(tmp_path: Path) -> None:
    form = next(one for one in FORMS if one.name == "ambiguous_dates")
    folder = tmp_path / "dates"
    folder.mkdir()
    (folder / "log.csv").write_bytes(form.write(chamber(hours=1.0)))
    shown, status = on_terminal(["init", str(folder)], ["sideways", "month-first", ENTER, ENTER, ENTER])
    assert status == 0, shown
    assert "sideways: one of: day-first, month-first" in shown
    assert 'text = { dates = "month-first" }' in (folder / "campaign.toml").read_text()


def test_interrupted_it_writes_nothing(tmp_path: Path) -> None:
    folder = put(tmp_path / "left", "turned_counts.csv")
    _, status = on_terminal(["init", str(folder)], ["\x03"])
    assert status == 130
    assert not (folder / "campaign.toml").exists()


@pytest.mark.parametrize("made", FILES, ids=lambda made: made.name)
def test_init_goes_by_what_info_suggests(made: object, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = made.name  # type: ignore[attr-defined]
    folder = put(tmp_path / "folder", name)
    _, out, _ = call(capsys, "info", str(folder / name), "--json")
    word = json.loads(out)["results"][0]["next"].split()[1]
    assert call(capsys, "init", str(folder), "-q")[0] == 0
    tests = tomllib.loads((folder / "campaign.toml").read_text())["tests"]
    procedure = {"rate-table": "rate_table", "thermal": "thermal", "allan": "static_noise", "info": "static_noise"}
    assert {one["procedure"] for one in tests} == {procedure[word]}


def test_an_answer_holds_only_where_a_header_says_no_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One answer for the gyros of a folder leaves those of other files in the unit of their header; an option wins."""
    heads = {"bare.csv": "time_s,gyro_x,gyro_y,gyro_z", "said.csv": "time_s,gyro_x [rad/s],gyro_y [rad/s],gyro_z"}
    for folder in ("asked", "options"):
        (tmp_path / folder).mkdir()
        for number, (name, head) in enumerate(heads.items()):
            rows = [f"{n / 50},{0.1 + 0.01 * math.sin(n * (n + number))},0.{n % 7},0.{n % 5}" for n in range(1200)]
            (tmp_path / folder / name).write_text("\n".join([head, *rows]), encoding="utf-8")
    shown, status = on_terminal(["init", str(tmp_path / "asked")], ["deg/s", ENTER, ENTER, ENTER])
    assert status == 0, shown
    assert "the option wins" not in shown
    units = {}
    for one in campaign(tmp_path / "asked")["recordings"].values():  # type: ignore[attr-defined]
        units[one["file"]] = [one["channels"][axis]["unit"] for axis in "xyz"]
    assert units == {"bare.csv": ["deg/s"] * 3, "said.csv": ["rad/s", "rad/s", "deg/s"]}
    status, out, _ = call(capsys, "init", str(tmp_path / "options"), "--unit", "gyro=deg/s", "--json")
    assert status == 0
    assert [one["code"] for one in json.loads(out)["remarks"]] == ["unit_overridden"]  # once for both


@pytest.mark.parametrize(
    ("unit", "answers"), [("V", ()), pytest.param("count", ("5 V / 65535",), marks=pytest.mark.slow)]
)
def test_a_table_of_faces_is_asked_for_its_chain(
    unit: str, answers: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Six faces, thrice, of an analogue accelerometer: bias -0.03 m/s^2 along y, with 2 mm/s^2 of scatter."""
    faces = {"x up": 0, "y up": 1, "z up": 2, "x down": 3, "y down": 4, "z down": 5}
    rng = np.random.default_rng(5)
    rows = [f"position,acc_x [{unit}],acc_y [{unit}],acc_z [{unit}]"]
    for face, k in (*faces.items(),) * 3:
        force = 9.80665 * (1.0 - 2.0 * (k > 2)) * np.eye(3)[k % 3]
        volts = 2.5 + 0.2 * (1.003 * force + [0.05, -0.03, 0.02] + rng.normal(0.0, 0.002, 3))
        cells = volts if unit == "V" else np.rint(volts * 65535 / 5.0)
        rows.append(",".join([face, *(f"{one:.6f}" for one in cells)]))
    folder = tmp_path / "faces"
    folder.mkdir()
    (folder / "faces.csv").write_text("\n".join(rows) + "\n")
    shown, status = on_terminal(["init", str(folder)], [*answers, "2.5 V", "0.2 V/(m/s2)", *[ENTER] * 4])
    assert status == 0, shown
    assert f"faces.csv: readings in {unit}" in shown
    assert "complete. Next: inertialcal run" in shown
    value, u = bias(capsys, folder, "y")
    assert value == pytest.approx(-0.03, abs=5 * u)


def test_a_recording_of_every_reader_is_looked_at() -> None:
    """Only what has no ending of its own, a file without time, and a JSON file of any kind are passed over."""
    passed = {"", ".asc", ".prn", ".tab", ".npy", ".cards", ".json"}
    for reader in READERS.values():
        assert set(reader.endings) - passed <= set(ENDINGS), reader.name


@pytest.mark.parametrize("write", [ulog_sensors, dataflash_raw])
def test_topics_of_a_file_are_recordings_of_one_test(write: Writer, tmp_path: Path, capsys: Capsys) -> None:
    """A logger writes gyro and accelerometer as topics: both are taken, and nothing is asked."""
    folder = tmp_path / "board"
    folder.mkdir()
    write(six_faces(dwell=2.0), folder / "board.log")
    shown, status = on_terminal(["init", str(folder)], [ENTER] * 4)
    assert (status, "Which" in shown) == (0, False), shown
    found: Any = campaign(folder)
    assert [one["recordings"] for one in found["tests"]] == [["acc_hand1", "gyro_hand1"]]
    assert call(capsys, "run", str(folder), "-q")[0] == 0
    rows = json.loads((folder / "out/results.json").read_text())["results"]
    for quantity, unit, true in (("bias", "m/s^2", ACC_BIASES[2]), ("bias", "rad/s", GYRO_BIASES[2])):
        own = next(one for one in rows if (one["quantity"], one["axis"], one["unit"]) == (quantity, "z", unit))
        assert own["value"] == pytest.approx(true, abs=5 * own["u"])


def test_of_two_sensors_of_a_kind_one_is_asked_for(tmp_path: Path, capsys: Capsys) -> None:
    folder = tmp_path / "two"
    folder.mkdir()
    board = board_at_rest(seconds=12.0)
    with sqlite3.connect(folder / "imu.db") as connection:
        for name, shift in (("front gyro", 0.0), ("back gyro", 0.25)):
            connection.execute(f'CREATE TABLE "{name}" ("t_s" REAL, "x_dps" REAL, "y_dps" REAL, "z_dps" REAL)')
            rows = [(float(t), *(float(one) + shift for one in row))
                    for t, row in zip(board.time, np.degrees(board.gyro), strict=True)]  # fmt: skip
            connection.executemany(f'INSERT INTO "{name}" VALUES (?, ?, ?, ?)', rows)
        connection.execute("CREATE TABLE log (at REAL, battery REAL)")
        connection.executemany("INSERT INTO log VALUES (?, ?)", [(float(t), 12.1) for t in board.time[::100]])
    status, _, err = call(capsys, "init", str(folder))
    assert status == 3
    assert "front gyro; back gyro" in err
    assert "--topic 'front gyro'" in err
    assert "log" not in err
    shown, status = on_terminal(["init", str(folder)], ["'no gyro'", "'back gyro'", ENTER, ENTER, ENTER])
    assert status == 0, shown
    assert "no topic 'no gyro'" in shown
    (entry,) = campaign(folder)["recordings"].values()  # type: ignore[attr-defined]
    assert (entry["file"], entry["topics"]) == ("imu.db", ["back gyro"])
    (folder / "campaign.toml").unlink()
    status, out, err = call(capsys, "init", str(folder), "--yes")
    assert (status, "Taken: 'front gyro'" in " ".join(out.split())) == (0, True), out + err


def test_accelerometers_that_move_as_in_no_test_are_told_as_they_are(tmp_path: Path, capsys: Capsys) -> None:
    rng, time = np.random.default_rng(4), np.arange(8_000) / 500.0
    acc = 0.02 * rng.standard_normal((len(time), 3)) + [0.0, 0.0, 1.0]
    acc[:, 0] += np.exp(-(((time - 8.0) / 2.0) ** 2)) * np.sin(2.0 * np.pi * 31.0 * time)
    rows = [",".join(f"{one:.5f}" for one in row) for row in np.column_stack([time, acc])]
    (tmp_path / "burst.csv").write_text("\n".join(["t [s],acc_x [g],acc_y [g],acc_z [g]", *rows]) + "\n")
    _, out, _ = call(capsys, "info", str(tmp_path / "burst.csv"))
    assert "next:" not in out
    status, _, err = call(capsys, "init", str(tmp_path))
    assert status == 3
    assert "burst.csv: accelerometers that move (acc_x [g], acc_y [g], acc_z [g])" in " ".join(err.split())
