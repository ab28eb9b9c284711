"""Words that do not fit the header: a chain of readings in units is refused, another unit is remarked on."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from newcomer_tables import FILES
from newcomer_truths import at_rest, chamber, rate_table

import inertialcal as ic
from inertialcal.core.errors import PlanError
from typed_commands import call

CHAIN = ("--lsb", "5 V / 4095", "--scale-factor", "0.02 V/(deg/s)")
SHORT = {"allan": partial(at_rest, minutes=1.0), "thermal": partial(chamber, hours=0.2),
         "rate-table": partial(rate_table, dwell=5.0)}  # fmt: skip
TEXT = '{ kind = "adc", lsb = "5 V / 4095", scale_factor = "0.02 V/(deg/s)" }'
NOUNS = (
    ("allan", "rest_units.csv"), ("psd", "rest_units.csv"), ("thermal", "chamber_units.csv"),
    ("sensitivity", "chamber_units.csv", "--to", "temperature"), ("sine", "rest_units.csv", "--period", "60 s"),
    ("positions", "rest_units.csv"), ("rate-table", "turned_units.csv", "--axis", "x"),
    ("rate-table", "dwells_units.csv", "--axis", "x"),
)  # fmt: skip
CAMPAIGN = """schema = 2
[campaign]
id = "idle"
[sensors.suite]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
chain = CHAIN
[recordings.rest]
sensor = "suite"
file = "rest_units.csv"
channels = { x = { column = "gyro_x [deg/s]", unit = "deg/s" } }
[[tests]]
id = "noise"
procedure = "static_noise"
recordings = ["rest"]
"""


def written(folder: Path, name: str) -> Path:
    """Write a newcomer's file, but a short one."""
    made = next(one for one in FILES if one.name == name)
    (folder / name).write_bytes(made.write(SHORT[made.noun]()))
    return folder / name


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files in units, and two that are not."""
    found = tmp_path_factory.mktemp("files")
    for name in {one[1] for one in NOUNS} | {"dwells_counts.csv", "chamber_volts.csv"}:
        written(found, name)
    return found


def typed(capsys: pytest.CaptureFixture[str], folder: Path, words: tuple[str, ...], *said: str) -> tuple[int, Any]:
    """Type a noun with its file; return exit status and content."""
    status, out, _ = call(capsys, words[0], str(folder / words[1]), *words[2:], *said, "--json")
    return status, json.loads(out)


@pytest.mark.parametrize("words", NOUNS, ids=lambda words: f"{words[0]}-{words[1]}")
def test_a_chain_of_readings_in_units_is_refused(
    words: tuple[str, ...], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Whatever part of it is said, and alone too: it would have no effect."""
    parts = {"lsb": CHAIN, "scale_factor": CHAIN[2:], "chain": ("--chain", TEXT), "gain": ("--gain", "10"),
             "reference": ("--reference", "2.5 V", *CHAIN[2:]), "counts": ("--counts", "0, 4095")}  # fmt: skip
    if words[1] == "dwells_units.csv":  # there it is the nominal one: the result is in V/(deg/s) too
        del parts["scale_factor"]
    for name, said in parts.items():
        status, content = typed(capsys, folder, words, *said)
        assert status == 2, said
        (error,) = content["errors"]
        assert error["code"] == "option_without_effect"
        assert f"{name} is given, and the readings are in deg/s already" in error["what"]
        assert error["do"] == "Leave it out, or correct the unit"


@pytest.mark.parametrize(("said", "words"), [
    pytest.param("rad/s", NOUNS[0], marks=pytest.mark.slow),
    pytest.param("gyro=rad/s", NOUNS[2], marks=pytest.mark.slow),
    ("rad/s", NOUNS[6]), ("gyro=rad/s", NOUNS[7]),
])  # fmt: skip
def test_another_unit_than_that_of_the_header_is_remarked_on(
    said: str, words: tuple[str, ...], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The word of the caller holds for the readings; the rate of the table is no reading."""
    _, plain = typed(capsys, folder, words)
    _, content = typed(capsys, folder, words, "--unit", said)
    assert not [one for one in plain["remarks"] if one["code"] == "unit_overridden"]
    told = [one for one in content["remarks"] if one["code"] == "unit_overridden"]
    assert told
    assert all(one["do"] == "If the header is right, leave rad/s out" for one in told)
    assert not any("table_rate" in one["what"] for one in told)
    own = {(one["quantity"], one["axis"], one["method"]): one for one in plain["results"] if one["u"]}
    rows = [one for one in content["results"] if one["unit"] == "rad/s" and one["u"]]
    for one in rows:  # the same number, in the unit that was said
        before = own.get((one["quantity"], one["axis"], one["method"]))
        if before is not None and before["unit"] == "deg/s":
            assert one["value"] == pytest.approx(before["value"], rel=1e-6)


@pytest.mark.parametrize(("noun", "name"), [("rate-table", "dwells_counts.csv"), ("thermal", "chamber_volts.csv")])
@pytest.mark.parametrize("said", ["gyro=deg/s", "deg/s"])
def test_counts_and_volts_by_the_header_never_become_rates_by_a_word(
    noun: str, name: str, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    axis = ("--axis", "x") if noun == "rate-table" else ()
    status, content = typed(capsys, folder, (noun, name, *axis), "--unit", said)
    assert status == 2
    assert "--scale-factor" in content["errors"][0]["do"]


def test_a_table_of_two_units_keeps_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table turns in rad/s by its header, the gyro reads deg/s: the scale factor is that of deg/s for both."""
    made = next(one for one in FILES if one.name == "dwells_units.csv")
    head, *rows = made.write(made.log()).decode().splitlines()
    cells = [row.split(",") for row in rows]
    lines = [",".join([repr(math.radians(float(rate))), *rest]) for rate, *rest in cells]
    (tmp_path / "plain.csv").write_text("\n".join([head, *rows]) + "\n")
    (tmp_path / "two.csv").write_text("\n".join([head.replace("rate [deg/s]", "rate [rad/s]"), *lines]) + "\n")
    found = []
    for name in ("plain.csv", "two.csv"):
        status, content = typed(capsys, tmp_path, ("rate-table", name, "--axis", "x"))
        assert status == 0, content["errors"]
        found.append(next(one["value"] for one in content["results"] if one["quantity"] == "scale_factor_error"))
    assert found[1] == pytest.approx(found[0], abs=1e-9)


def test_init_goes_by_the_same_rule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(tmp_path, "chamber_units.csv")
    status, _, err = call(capsys, "init", str(tmp_path), "--yes", *CHAIN[2:])
    assert status == 2
    assert "scale_factor is given, and the readings are in deg/s already" in err
    status, out, _ = call(capsys, "init", str(tmp_path), "--yes", "--unit", "rad/s", "--json")
    assert status == 0
    assert [one["code"] for one in json.loads(out)["remarks"]] == ["unit_overridden"]  # once for the three


def test_init_says_why_a_file_in_volts_is_not_read_as_rates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(tmp_path, "chamber_volts.csv")
    status, _, err = call(capsys, "init", str(tmp_path), "--yes", "--unit", "gyro=deg/s")
    assert status == 3
    assert "is in V by its header" in err


@pytest.mark.parametrize("chain", [
    '{ kind = "adc", lsb = "5 V / 4095", reference = "2.5 V", scale_factor = "0.02 V/(deg/s)" }',
    '{ kind = "output", reference = "2.5 V", scale_factor = "0.02 V/(deg/s)" }',
    '{ kind = "none", reference = "2.5 V" }',
])  # fmt: skip
def test_a_campaign_names_it(chain: str, tmp_path: Path) -> None:
    written(tmp_path, "rest_units.csv")
    (tmp_path / "campaign.toml").write_text(CAMPAIGN.replace("CHAIN", chain))
    with pytest.raises(PlanError, match=r"deg/s|does not use reference"):
        ic.check(tmp_path)
