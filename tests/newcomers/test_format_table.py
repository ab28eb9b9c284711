"""Each cell of the manual's table of formats and commands: one content in every format, and the same result.

What the text file gives is the reference: a format differs from it by the roundings of its numbers.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import format_sheets
import numpy as np
import pytest
from format_sheets import SHEETS, Sheet
from newcomer_boards import Board, G
from newcomer_files import START

from independent.shaking.quadratic import Shaken, record
from independent.shaking.shaker import Mode, recorded
from independent.shaking.shaker import Run as Sweep
from independent.vibration.random_run import Run, simulate
from inertialcal.core.units import parse_quantity, si_unit
from inertialcal.files import apart
from typed_commands import call

pytestmark = pytest.mark.usefixtures("undrawn")
PAGE = Path(__file__).resolve().parents[2] / "docs/formats.md"
TABLE = PAGE.read_text(encoding="utf-8").split("## Which command takes what")[1].split("\n## ")[0]
HEAD, *CELLS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in TABLE.splitlines()
                if line.startswith("| ")]  # fmt: skip
WORDS = [one.strip("`") for one in HEAD[1:-1]]
QUICK = ("CSV", "npz", "WAV", "ULog `sensor_gyro`")  # the others are slow
GYRO = {axis: f"gyro_{axis}" for axis in "xyz"}
ACC = {axis: f"acc_{axis}" for axis in "xyz"}
UNSAID = ("WAV", "miniSEED")  # formats without units: figures in those of the file
FLAT = "frequency [Hz],density [g2/Hz]\n20,0.01\n200,0.01\n"
COMPARED = (
    "acceleration_rms",
    "bias",
    "scale_factor",
    "amplitude",
    "noise_density",
    "angle_random_walk",
    "velocity_random_walk",
)
NEAR = 1.0  # standard uncertainties that roundings of a format may move a figure


class Noun:
    """A command: the content it is shown, which column is what for it, and the options that it always needs."""

    def __init__(self, sheet: str, roles: Mapping[str, str], *options: str, always: bool = False) -> None:
        self.sheet, self.roles, self.options, self.always = sheet, roles, options, always


NOUNS = {
    "info": Noun("bench", {}),
    "convert": Noun("bench", {}, "OUT"),
    "allan": Noun("bench", GYRO, "--terms", "random_walk", "--no-lines"),
    "psd": Noun("bench", GYRO, "--terms", "random_walk"),
    "sine": Noun("bench", {"x": "gyro_x"}, "--period", "6 s", always=True),
    "thermal": Noun("bench", GYRO | {"temperature": "temperature"}, "--order", "1"),
    "sensitivity": Noun("bench", GYRO | {"supply": "supply"}, "--to", "supply", "--nominal", "supply=5 V"),
    "rate-table": Noun("turned", GYRO | {"applied": "table_rate"}, "--axis", "z"),
    "positions": Noun("faces", {name: name for name in (*ACC.values(), *GYRO.values())}),
    "flip": Noun("bench", ACC, "--largest-bias", "2 g", "--window", "FIRST=0 deg", "--window", "SECOND=180 deg"),
    "mass-attraction": Noun("moved", {"x": "acc_x"}, "--schedule", "SCHEDULE", always=True),
    "vibration": Noun(
        "shaken", {"x": "acc_x", "y": "acc_y"}, "--profile", "FLAT", "--sensor", "acc", "--control", "acc_z"
    ),
    "compensate": Noun("bench", GYRO | {"temperature": "temperature"}, "-o", "OUT"),
}
MESSAGES = {  # what messages with fixed fields call the axes
    "ROS": ("angular_velocity.{}", "linear_acceleration.{}"),
    "MCAP": ("angular_velocity.{}", "linear_acceleration.{}"),
    "ULog `sensor_combined`": ("gyro_rad.{}", "accelerometer_m_s2.{}"),
    "ULog `sensor_gyro`": ("{}", "{}"),
    "DataFlash": ("Gyr{}", "Acc{}"),
}
UTC = tuple(f"2024-03-12T09:15:{a}Z..2024-03-12T09:15:{b}Z" for a, b in (("00", "25"), ("30", "59")))
WINDOWS = {  # by the clock of a format
    "ROS": UTC, "MCAP": UTC, "miniSEED": UTC, "ULog": ("30..55", "60..90"), "DataFlash": ("5..30", "35..65"),
}  # fmt: skip


@cache
def content(name: str) -> Sheet:
    """Return one of the contents."""
    made: Sheet = getattr(format_sheets, name)()
    return made


def named(kind: str, column: str, sheet: Sheet) -> str:
    """Return what a format calls a column."""
    for start, (gyro, acc) in MESSAGES.items():
        if kind.startswith(start):
            axis = column[-1].upper() if kind.startswith("DataFlash") else column[-1]
            return (gyro if column.startswith("gyro") else acc).format(axis)
    number = list(sheet.columns).index(column) + 1
    if kind == "WAV":
        return f"channel_{number}"
    if kind == "miniSEED":
        return f"GR_{column.replace('_', '').upper()}__H_N_Z"
    if kind == "UFF 58":
        return f"{column[:-2]}_1_{column[-1]}" if column[-2] == "_" else f"channel_{column[:10]}_1"
    if kind == "MATLAB":
        return f"{column}_{ {'deg/s': 'deg_s', 'm/s^2': 'm_s2'}.get(unit := sheet.columns[column][1], unit) }"
    return column


@cache
def written(kind: str, name: str, folder: Path) -> Path:
    """Return the file of a content in a format."""
    ending, write = SHEETS[kind]
    path = folder / f"{name}{ending}"
    if not path.exists():
        write(content(name), path)
    return path


def typed(kind: str, word: str, cell: str, folder: Path) -> list[str]:
    """Return a command, with the options of a cell."""
    noun = NOUNS[word]
    sheet, path = content(noun.sheet), written(kind, noun.sheet, folder)
    out = str(folder / "out.csv")
    first, second = WINDOWS.get(kind.split(maxsplit=1)[0], ("0..25", "30..60"))
    stand = {"OUT": out, "SCHEDULE": str(folder / "schedule.csv"), "FIRST=0 deg": f"{first}=0 deg",
             "SECOND=180 deg": f"{second}=180 deg", "FLAT": str(folder / "flat.csv")}  # fmt: skip
    control = [b for a, b in pairwise(noun.options) if a == "--control"]
    stand |= {one: named(kind, one, sheet) for one in control}
    words = [word, *([str(folder / "model.json")] if word == "compensate" else []), str(path)]
    words += [stand.get(one, one) for one in noun.options]
    roles = {role: named(kind, column, sheet) for role, column in noun.roles.items()}
    if "--column" in cell or noun.always:
        words += [part for role, name in roles.items() for part in ("--column", f"{role}={name}")]
    if "--unit" in cell:
        columns = [*noun.roles.values(), *control]
        units = {named(kind, column, sheet): sheet.columns[column][1] for column in columns}
        words += [part for name, unit in units.items() for part in ("--unit", f"{name}={unit}")]
    if "--topic" in cell:
        words += [
            "--topic",
            "sensor_accel" if word in ("positions", "flip", "mass-attraction", "vibration") else "sensor_gyro",
        ]
    if "--schedule" in cell:
        words += ["--schedule", str(dwells(kind, folder))]
    if "--scale-factor" in cell:
        unit = sheet.columns[next(iter(noun.roles.values()))][1]
        words += ["--scale-factor", f"1e6 count/({unit})"]
    return words


def dwells(kind: str, folder: Path) -> Path:
    """Return a schedule of the dwells of the turned board, by the clock of a format."""
    board, rates = content("turned").board, content("turned").columns["table_rate"][0]
    edges = [0, *(i for i in range(1, len(rates)) if rates[i] != rates[i - 1]), len(rates)]
    zero = {"ULog": 30.0, "DataFlash": 5.0}.get(kind.split(maxsplit=1)[0], float(START))
    lines = ["start,stop,rate [deg/s]"]
    for first, stop in pairwise(edges):
        at = [zero + one / board.sample_rate for one in (first, stop)]
        named = [np.datetime_as_string(np.datetime64(round(1e3 * one), "ms")) + "Z" if zero == START else f"{one:.3f}"
                 for one in at]  # fmt: skip
        lines.append(f"{named[0]},{named[1]},{rates[first]}")
    path = folder / "dwells.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def names_unit(text: str | None) -> bool:
    """Whether a unit is one of physics, not that of an unknown file."""
    return text not in (None, "", "1") and "file unit" not in str(text)


def figures(text: str) -> dict[tuple[Any, ...], tuple[float, float]]:
    """Return figures that have an uncertainty, in SI units, by what they are."""
    found = {}
    for row in json.loads(text)["results"]:
        if row.get("u") and row["value"] is not None and row["quantity"].startswith(COMPARED):
            unit = row["unit"]
            scale = parse_quantity(f"1 {unit}").to(si_unit(unit)) if names_unit(unit) else 1.0
            key = (row["sensor"], row["quantity"], row["axis"], row["method"], json.dumps(row.get("power")))
            found[key] = (scale * row["value"], scale * row["u"])
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a model and a schedule."""
    made = tmp_path_factory.mktemp("formats")
    rows = [f"{1.5 * i},{1.5 * i + 1.1},{i % 2},{10 * (-1) ** i}\n" for i in range(40)]
    (made / "flat.csv").write_text(FLAT)
    (made / "schedule.csv").write_text("start [s],stop [s],position [m],applied [ug]\n" + "".join(rows))
    return made


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read with foreign libraries in this process: starting Python anew for each cell takes a second."""
    monkeypatch.setattr(apart, "is_possible", lambda: False)


@pytest.fixture
def reference(folder: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """Return the folder, with a model that the text file gave."""
    model = folder / "model.json"
    if not model.exists():
        words = typed("CSV", "thermal", "yes", folder)
        assert call(capsys, *words, "-o", str(model))[0] == 0
    return folder


RESULTS: dict[str, dict[tuple[Any, ...], tuple[float, float]]] = {}


def expected(word: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> dict[tuple[Any, ...], tuple[float, float]]:
    """Return the figures that the text file gives."""
    if word not in RESULTS:
        status, out, err = call(capsys, *typed("CSV", word, "yes", folder), "--json")
        assert status == 0, err
        RESULTS[word] = figures(out)
    return RESULTS[word]


def test_the_table_has_every_format_and_every_noun() -> None:
    assert [row[0] for row in CELLS] == list(SHEETS)
    assert set(WORDS) == set(NOUNS)


ROWS = [pytest.param(row, marks=[] if row[0] in QUICK else [pytest.mark.slow], id=row[0].replace("`", ""))
        for row in CELLS]  # fmt: skip


@pytest.mark.parametrize("row", ROWS)
def test_each_cell_is_true(row: list[str], reference: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kind, *cells, target = row
    folder = reference / kind.replace(" ", "_").replace("`", "")
    folder.mkdir(exist_ok=True)
    for name in ("model.json", "schedule.csv", "flat.csv"):
        (folder / name).write_bytes((reference / name).read_bytes())
    for word, cell in zip(WORDS, cells, strict=True):
        status, out, err = call(capsys, *typed(kind, word, cell, folder), "--json")
        if cell.startswith("no"):
            assert status in (2, 3), (word, out)
            assert json.loads(out)["errors"], word
            continue
        assert status == 0, (word, err, out[:500])
        if word in ("info", "convert", "compensate"):
            continue
        same, found = expected(word, reference, capsys), figures(out)
        per_count = "--scale-factor" in cell  # there the scale factor is in counts, its error in percent
        compared = [key for key in found if key in same and not (per_count and key[1] == "scale_factor")]
        has_units = kind not in UNSAID or "--unit" in cell or "--scale-factor" in cell
        assert compared or not has_units, (word, list(found), list(same))
        for key in compared if has_units else ():
            (value, u), (true, _) = found[key], same[key]
            assert abs(value - true) <= NEAR * u + 1e-4 * abs(true), (word, key, value, true, u)
    if target:
        made = folder / f"made{target.strip('`')}"
        assert call(capsys, "convert", str(written(kind, "bench", folder)), str(made))[0] == 0
        assert call(capsys, "info", str(made))[0] == 0


# ---- vibration: channels of a shaker in g, as laboratories save them ------------------------------------------------

LEVEL = "frequency [Hz],density [g2/Hz]\n20,0.01\n80,0.04\n500,0.04\n2000,0.01\n"
SHAKER = {  # command, the figure that is compared, what WAV does not say
    "run": (
        ["vibration", "FILE", "--profile", "LEVEL"],
        "acceleration_rms",
        "--control channel_1 --response channel_2 --unit channel_1=g --unit channel_2=g",
    ),
    "sweep": (
        ["vibration", "survey", "FILE"],
        "resonance_frequency",
        "--control channel_1 --unit channel_1=g --unit channel_2=g",
    ),
    "ride": (
        ["vibration", "effects", "FILE"],
        "vibration_rectification",
        "--column x=channel_2 --control channel_1 --unit channel_1=g --unit channel_2=deg/s",
    ),
}


@cache
def shaker(name: str) -> Sheet:
    """Return control and response of a shaker in g, of simulators that share nothing with the estimators."""
    if name == "run":
        control = simulate(Run(duration=4.0), 1)[0][:, 0] / G
        rate, columns = 5120.0, {"control": (control, "g"), "acc_x": (1.1 * control, "g")}
    elif name == "sweep":
        rate = 4000.0
        swept = Sweep(per_minute=60.0, sample_rate=rate)
        table, item = recorded((Mode(300.0, 20.0),), swept, np.random.default_rng(1), noise=(0.02, 0.02))
        columns = {"control": (table / G, "g"), "acc_x": (item / G, "g")}
    else:
        rate, made = 400.0, record(1, Shaken(seconds=8.0)).columns
        columns = {"control": (made["control [g]"], "g"),
                   "gyro_x": (np.degrees(made["gyro_x [rad/s]"]), "deg/s")}  # fmt: skip
    n = len(columns["control"][0])
    board = Board(np.arange(n) / rate, np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), rate)
    return Sheet(board.time, columns, board)


@pytest.mark.parametrize("kind", ["UFF 58", "WAV", "MATLAB", "TDMS", "LVM"])
@pytest.mark.parametrize("name", list(SHAKER))
def test_files_of_a_shaker_give_what_their_text_gives(
    kind: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words, quantity, unsaid = SHAKER[name]
    (tmp_path / "level.csv").write_text(LEVEL)
    found = []
    for one in ("CSV", kind):
        ending, write = SHEETS[one]
        path = tmp_path / f"{name}{ending}"
        write(shaker(name), path)
        stand = {"FILE": str(path), "LEVEL": str(tmp_path / "level.csv")}
        typed_words = [stand.get(word, word) for word in words] + (unsaid.split() if one == "WAV" else [])
        status, out, err = call(capsys, *typed_words, "--json")
        assert status == 0, err
        rows = [row for row in json.loads(out)["results"] if row["quantity"] == quantity and row["value"] is not None]
        found.append([(row["axis"], row["unit"], row["value"]) for row in rows])
    assert found[0]
    assert found[1] == [(axis, unit, pytest.approx(value, rel=1e-4)) for axis, unit, value in found[0]]
