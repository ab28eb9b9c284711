"""Every command that reads recordings has the options that say how a file is read, the same in all of them."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.cli.commands import Root
from inertialcal.core.settings import settings_of
from inertialcal.files import read
from inertialcal.procedures.given import READING, Said
from typed_commands import call, call_json

COMMANDS = Root()
READ_NONE = {"check", "run", "demo", "certificate", "show", "export", "budget", "compare", "simulate", "score", "plan",
             "vibration profile", "acquire", "archive", "live", "sequence", "guide", "lot"}  # fmt: skip
OWN = {("sensitivity", "--to"): "stop"}  # an option of its test has the word; the setting is called as its field
RNG = np.random.default_rng(5)
BIAS = (0.3, -0.2, 0.1)


def options(word: str) -> dict[str, tuple[str, bool, object]]:
    """Help, whether it may be repeated, and type of the options of a command, by name."""
    made: Any = COMMANDS.get_command(None, word)
    return {
        name: (getattr(one, "help", ""), bool(getattr(one, "multiple", False)), str(one.type_descriptor.annotation))
        for one in made.params
        if one.param_type_name == "option"
        for name in one.opts
    }


def test_commands_that_read_recordings_have_the_same_reading_options() -> None:
    names = {one.name: f"--{one.option}" for one in settings_of(Said) if one.name in READING}
    assert set(names) == set(READING)
    like = options("info")
    for word in set(COMMANDS.names()) - READ_NONE:
        found = options(word)
        for name, option in names.items():
            typed = f"--{OWN[word, option]}" if (word, option) in OWN else option
            assert found[typed] == like[option], f"{word} {typed} ({name})"


def test_commands_of_models_and_campaigns_read_no_recording() -> None:
    for word in READ_NONE - {"archive", "plan"}:
        assert not {"--time-column", "--skip", "--topic"} & set(options(word)), word


@pytest.fixture
def nameless(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    rows = np.column_stack([np.arange(2000) / 50.0, RNG.normal(BIAS, 0.02, (2000, 3)), RNG.normal(0, 1, 2000)])
    np.savetxt("nameless.csv", rows, "%.6f", ",", header="t [s],a,b,c,d", comments="")
    return tmp_path


NAMED = ("--column", "x=a", "--column", "y=b", "--column", "z=c")


@pytest.mark.parametrize("unit", ["deg/s", "gyro=deg/s", "a=deg/s"])
def test_info_takes_a_column_for_what_it_is_named(
    nameless: Path, capsys: pytest.CaptureFixture[str], unit: str
) -> None:
    (found,) = call_json(capsys, "info", "nameless.csv", *NAMED, "--unit", unit)["results"]
    assert [one["name"] for one in found["channels"]] == ["a", "b", "c"]
    assert [one["axis"] for one in found["channels"]] == ["x", "y", "z"]
    assert found["channels"][0]["unit"] == "deg/s"


@pytest.mark.parametrize("ending", ["csv", "h5", "npz"])
def test_convert_writes_columns_under_the_names_that_were_said(
    nameless: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    assert call(capsys, "convert", "nameless.csv", f"named.{ending}", *NAMED, "--unit", "deg/s")[0] == 0
    found = read(f"named.{ending}")
    assert [(one.quantity, one.axis, one.unit) for one in found.channels] == [
        ("gyro", axis, "deg/s") for axis in ("x", "y", "z")
    ]
    assert found.array() == pytest.approx(read("nameless.csv").array(["a", "b", "c"]))
    assert found.sample_rate == pytest.approx(50.0)


def test_init_takes_a_column_for_what_it_is_named(nameless: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(capsys, "init", ".", "--yes", *NAMED, "--unit", "gyro=deg/s", "--to", "30")[0] == 0
    written = Path("campaign.toml").read_text(encoding="utf-8")
    assert 'x = { column = "a", unit = "deg/s" }' in written
    assert 'stop = "30"' in written


def test_a_column_that_is_not_there_or_named_twice_is_refused(
    nameless: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = call_json(capsys, "info", "nameless.csv", "--column", "x=wx")
    assert gone["errors"][0]["do"] == "The file has: a, b, c, d"
    twice = call_json(capsys, "info", "nameless.csv", "--column", "x=a", "--column", "y=a")
    assert "'a' is given for x and y" in twice["errors"][0]["what"]


def test_a_table_of_a_database_is_chosen_by_command_and_in_a_campaign(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with sqlite3.connect(tmp_path / "dwells.db") as connection:
        for name, bias in (("first", 0.3), ("second", -0.5)):
            connection.execute(f'CREATE TABLE {name} ("rate [deg/s]" REAL, "reading [deg/s]" REAL)')
            rows = [(rate, 1.01 * rate + bias + 0.01 * RNG.standard_normal()) for rate in 3 * [*range(-60, 61, 10)]]
            connection.executemany(f"INSERT INTO {name} VALUES (?, ?)", rows)
    connection.close()
    typed = ("rate-table", str(tmp_path / "dwells.db"), "--axis", "x", "--topic", "second")
    found = call_json(capsys, *typed, "--campaign", str(tmp_path / "campaign"))
    ran = call_json(capsys, "run", str(tmp_path / "campaign"))
    for content in (found, ran):
        biases = [one for one in content["results"] if (one["quantity"], one["axis"]) == ("bias", "x") and one["u"]]
        assert biases
        assert all(abs(one["value"] + 0.5) < 5.0 * one["u"] for one in biases)
