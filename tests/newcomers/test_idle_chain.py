"""A signal chain beside readings that are in units of input already: refused, for it would have no effect."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from newcomer_tables import FILES

import inertialcal as ic
from inertialcal.core.errors import PlanError
from typed_commands import call

CHAIN = ("--lsb", "5 V / 4095", "--scale-factor", "0.02 V/(deg/s)")
NOUNS = {"allan": "rest_units.csv", "psd": "rest_units.csv", "thermal": "chamber_units.csv",
         "rate-table": "turned_units.csv"}  # fmt: skip
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
    """Write a newcomer's file."""
    made = next(one for one in FILES if one.name == name)
    (folder / name).write_bytes(made.write(made.log()))
    return folder / name


@pytest.mark.parametrize("noun", NOUNS)
@pytest.mark.parametrize("said", [CHAIN, (*CHAIN, "--reference", "2.5 V"), ("--reference", "2.5 V", *CHAIN[2:]),
                                  ("--chain", '{ kind = "adc", lsb = "5 V / 4095", scale_factor = "0.02 V/(deg/s)" }')],
                         ids=["converter", "both", "reference", "chain"])  # fmt: skip
def test_a_command_refuses_it(
    noun: str, said: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, NOUNS[noun])
    axis = ("--axis", "x") if noun == "rate-table" else ()
    status, out, _ = call(capsys, noun, str(path), *axis, *said, "--json")
    assert status == 2
    (error,) = json.loads(out)["errors"]
    assert error["code"] == "option_without_effect"
    assert "is given, and the readings are in deg/s already" in error["what"]
    assert error["do"] == "Leave it out, or correct the unit"


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
