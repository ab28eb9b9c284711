"""Bad input of a flip, end to end: one message or remark, the exit status, no traceback; from files and campaigns."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.__main__ import main
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig, on_bench
from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import FAULTS, Bench, build
from pad_pairs_made import flip_records

SMALL = replace(Bench(), rate=5.0)
SHORT = replace(SMALL, duration=1800.0, turn_starts=(600.0, 1200.0), window=200.0, saved="g", said="g")
# What `run` leaves for each mistake of the rig: its exit status, and the words that name the mistake.
RUN = {
    "not_turned": (0, "y and z do not follow the stated angles"),
    "other_axis": (4, "the dwells follow a turn about z, not about x"),
    "gain_changed": (4, "level and scatter of y change by a factor of 0.1: y is not read"),
    "too_short": (3, "is no longer than the 20 s of settling"),
    "missing_position": (4, "missing position: x, y, z were read at 0 deg only"),
    "at_rails": (0, "at an end of the converter"),
    "magnitude": (4, "less than the bias of any head"),
    "robot_arm": (0, "Something else moved (robot arm, crew)"),
    "wrong_sign": (4, "the dwells follow the angles with y reversed: its sign is wrong"),
}


def call(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str]:
    """Return exit status and all that was said, on one line."""
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    assert "internal error" not in err
    return int(str(left.value.code or 0)), " ".join((out + err).split())


SMALL_FLIP = Rig("small_flip", "", on_bench(build, SMALL), FAULTS)


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setitem(RIGS, "small_flip", SMALL_FLIP)
    return "small_flip"


def test_every_mistake_of_the_rig_is_expected_here() -> None:
    assert set(RUN) <= set(FAULTS)


@pytest.mark.parametrize(
    "fault", [pytest.param(one, marks=pytest.mark.slow if i % 3 else []) for i, one in enumerate(RUN)]
)  # the others in procedures/flip/test_flip_inputs.py
def test_a_campaign_with_a_mistake(capsys: pytest.CaptureFixture[str], tmp_path: Path, rig: str, fault: str) -> None:
    folder = tmp_path / "with a mistake"
    status, said = call(capsys, "simulate", rig, "-o", folder, "--fault", fault)
    assert (status, f"Next: inertialcal run '{folder}'" in said) == (0, True)
    status, words = RUN[fault]
    found, said = call(capsys, "run", folder)
    assert words in said
    assert found == status
    found, said = call(capsys, "score", folder)
    assert found == 0  # what the entry of the fault says was seen
    assert (folder / "out").exists() == (status != 3)  # a refused campaign leaves no results


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clean") / "head.csv"
    path.write_text(csv_text(build(SHORT, 4).recordings[FILE]), encoding="utf-8")
    return path


def windows(*spans: str) -> list[str]:
    return [word for span in spans for word in ("--window", span)]


FIRST, SECOND = "1996/051/12:03:00..1996/051/12:09:00=0 deg", "1996/051/12:11:00..1996/051/12:19:00=180 deg"
THIRD = "1996/051/12:21:00..1996/051/12:29:00=0 deg"


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        ((), 2, "unit missing or of the wrong kind: 'x' (?)"),
        (("--unit", "count"), 2, "counts and volts need the chain of the sensor"),
        (("--unit", "ug"), 0, "less than the bias of any head. Check the unit of the readings (g, mg, ug)"),
        (("--unit", "g", "--settle", "500 s"), 3, "is no longer than the 500 s of settling"),
        (("--unit", "g", "--settle", "a while"), 2, "settle"),
        (("--unit", "g", "--angle", "180"), 2, "angle: '180' Write a number with its unit, like 180 deg"),
        (("--unit", "g", *windows("1996/051/12:03:00..1996/051/12:09:00=0")), 2, "'0' Write a number with its unit"),
        (("--unit", "g", "--axis", "z"), 4, "The head may have been turned about x"),
        (("--unit", "g", "--angle", "half"), 2, "angle: 'half' Write"),
        (("--unit", "g", *windows(FIRST)), 0, "missing position: x, y, z were read at 0 deg only"),
        (("--unit", "g", *windows("1996/051/12:09:00..1996/051/12:03:00=0 deg")), 2, "the end must be after the start"),
        (("--unit", "g", *windows(FIRST, FIRST.replace("=0", "=180"))), 3, "overlap"),
        (("--unit", "g", *windows(FIRST, "1996/052/12:11:00..1996/052/12:19:00=180 deg")), 2, "from 1996-02-20T12"),
        (("--unit", "g", "--column", "x=x", "--column", "y=x"), 2, "column 'x' is given for x and y"),
        (("--unit", "g", *windows("000/12:03..000/12:09=0 deg")), 2, "Add: --mission-start TIME"),
        (("--unit", "g", *windows("12:03..12:09=0 deg")), 2, "'12:03' is no time"),
        (("--unit", "g", *windows("yesterday")), 2, "write START..STOP=ANGLE"),
        (("--unit", "g", "--from", "1996/052/00:00"), 3, "The recording runs from 1996-02-20T12:00:00"),
        (("--unit", "g", "--to", "1996/051/12:05:00"), 2, "no turn of the head found"),
        (("--unit", "g", "--column", "w=x"), 2, "column 'w' There are: x, y, z"),
        (("--unit", "g", "--column", "x=nothing"), 3, "no column 'nothing'"),
        (("--unit", "g", "--frame", "sensor"), 2, "--frame given"),
    ],
)  # fmt: skip
def test_a_record_asked_for_wrongly(
    capsys: pytest.CaptureFixture[str], clean: Path, options: tuple[str, ...], status: int, words: str
) -> None:
    found, said = call(capsys, "flip", clean, *options)
    assert words in said
    assert found == status


def record_with(fault: str, path: Path) -> Path:
    bench = replace(FAULTS[fault].put_into(SMALL), saved="g", said="g")
    path.write_text(csv_text(build(bench, 1).recordings[FILE]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("fault", "status", "words"),
    [
        ("not_turned", *RUN["not_turned"]),
        ("other_axis", *RUN["other_axis"]),
        ("wrong_sign", 2, "not to and fro between two levels: 3 turns found"),  # quarter turns: windows are needed
    ],
)
def test_a_mistake_is_named_from_the_record_alone(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, fault: str, status: int, words: str
) -> None:
    path = record_with(fault, tmp_path / "head.csv")
    found, said = call(capsys, "flip", path, "--unit", "g")
    assert words in said
    assert found == status


def test_a_wrong_sign_is_named_where_windows_say_quarter_turns(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = record_with("wrong_sign", tmp_path / "head.csv")
    dwells = {"12:06:00..1996/051/12:14:00": 0, "12:19:00..1996/051/12:27:00": 90,
              "12:33:00..1996/051/12:41:00": 180, "12:46:30..1996/051/12:50:00": 0}  # fmt: skip
    given = windows(*(f"1996/051/{span}={angle} deg" for span, angle in dwells.items()))
    status, said = call(capsys, "flip", path, "--unit", "g", *given)
    assert RUN["wrong_sign"][1] in said
    assert status == RUN["wrong_sign"][0]


def table_of(path: Path) -> tuple[str, np.ndarray]:
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    return head, np.array([row.split(",") for row in rows], dtype=object)


def gain_changes(cells: np.ndarray) -> None:
    cells[4000:, 2] = [str(float(one) * 0.1) for one in cells[4000:, 2]]


def one_is_impossible(cells: np.ndarray) -> None:
    cells[1000, 1] = "1e20"


def time_goes_back(cells: np.ndarray) -> None:
    cells[1000, 0] = cells[900, 0]


def a_word(cells: np.ndarray) -> None:
    cells[1000, 1] = "lost"


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        (gain_changes, 0, "level and scatter of y change by a factor of 0.1"),
        (one_is_impossible, 0, "head.csv:1002: recording head, x: 1e+26 ug is impossible"),
        (time_goes_back, 3, "time goes back by 19.8 s"),
        (a_word, 3, "text 'lost' in number column 'x'"),
    ],
)
def test_a_record_that_is_damaged(
    capsys: pytest.CaptureFixture[str],
    clean: Path,
    tmp_path: Path,
    change: Callable[[np.ndarray], None],
    status: int,
    words: str,
) -> None:
    head, cells = table_of(clean)
    change(cells)
    path = tmp_path / "head.csv"
    path.write_text("\n".join([head, *(",".join(row) for row in cells), ""]), encoding="utf-8")
    found, said = call(capsys, "flip", path, "--unit", "g", *windows(FIRST, SECOND, THIRD))
    assert words in said
    assert found == status


def cut(data: Path) -> None:
    data.write_bytes(data.read_bytes()[:-7])


def cut_to_a_record(data: Path) -> None:
    data.write_bytes(data.read_bytes()[: 16 * 1000])


def another_sensor(data: Path) -> None:
    edit(data, "<SensorID>121f03", "<SensorID>121f05")


def another_start(data: Path) -> None:
    edit(data, "_36.000</TimeZero>", "_46.000</TimeZero>")


def another_rate(data: Path) -> None:
    edit(data, "<SampleRate>5", "<SampleRate>25")


def no_header(data: Path) -> None:
    data.with_name(data.name + ".header").unlink()


def edit(data: Path, old: str, new: str) -> None:
    path = data.with_name(data.name + ".header")
    text = path.read_text(encoding="ascii")
    assert old in text
    path.write_text(text.replace(old, new), encoding="ascii")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two records that make one flip, with a campaign file."""
    folder = flip_records(tmp_path_factory.mktemp("archive") / "records", files=2)
    with pytest.raises(SystemExit):
        main(["flip", str(folder), "--campaign", str(folder), "--quiet"])
    return folder


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (cut, "9 bytes more: truncated"),
        (cut_to_a_record, "records are missing a truncated file loses its end silently"),
        (another_sensor, "sensors: 121f03, 121f05"),
        (another_start, "start of the record: the name says"),
        (another_rate, "Hz"),
        (no_header, "its header is missing"),
    ],
)
def test_archive_records_that_are_damaged(
    capsys: pytest.CaptureFixture[str], archive: Path, tmp_path: Path, damage: Callable[[Path], None], words: str
) -> None:
    folder = tmp_path / "records"
    shutil.copytree(archive, folder)
    damage(sorted(folder.glob("*.121f03"))[0])
    for command in ("info", "flip", "run", "check"):
        status, said = call(capsys, command, folder)
        assert words in said, command
        assert status == 3


def test_a_folder_that_is_no_record(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status, said = call(capsys, "flip", tmp_path)
    assert (status, "this is a folder, not a file It is empty" in said) == (3, True)
    for name in "abcd":
        (tmp_path / f"{name}.csv").write_text("t,x\n0,1\n", encoding="utf-8")
    assert "Name one of its files: a.csv, b.csv, c.csv, ... (4 in all)" in call(capsys, "info", tmp_path)[1]
    (tmp_path / "campaign.toml").write_text("", encoding="utf-8")
    assert f"It holds a campaign: inertialcal run {tmp_path}" in call(capsys, "flip", tmp_path)[1]


@pytest.mark.parametrize(("unit", "per"), [("V", "V/g"), ("count", "count/g")])
def test_a_table_of_means_that_are_no_accelerations(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, unit: str, per: str
) -> None:
    """They are never taken for accelerations: the chain is asked for, whatever is said of their unit."""
    rows = [f"{axis},{k},{way},{2.5 + k}" for axis in "xyz" for k in (1, 2) for way in ("forward", "reverse")]
    (tmp_path / "means.csv").write_text("\n".join([f"axis,time,orientation,mean [{unit}]", *rows]))
    at = ("--position", "forward=0 deg", "--position", "reverse=180 deg")
    for said_unit in ((), ("--unit", "g")):
        status, said = call(capsys, "flip", tmp_path / "means.csv", *at, *said_unit)
        assert status == 2
        assert f'--scale-factor "NUMBER {per}"' in said
    assert f"is in {unit} by its header, not in g" in said
