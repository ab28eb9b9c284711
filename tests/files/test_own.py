"""Files and folders of our own, given where a recording or a campaign is meant: what they are, what to type."""

from __future__ import annotations

from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.campaign.start.starter import start
from inertialcal.core.errors import InertialcalError, Problem

CAMPAIGN = """schema = 2
[campaign]
id = "c"
[item]
part = "p"
[sensors.gyro]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
[recordings.rates]
sensor = "gyro"
file = "rates.csv"
rows = { applied = "rate", reading = "x", run = "run", unit = "deg/s" }
[[tests]]
id = "rate"
procedure = "rate_table"
recordings = ["rates"]
plan = { axis = "x" }
"""


RATES = (-50.0, 0.0, 50.0) * 6


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A lot by LOT.toml, one by folders of units, what a lot gave, and a campaign without its recording."""
    monkeypatch.chdir(tmp_path)
    for name in ("written", "folders", "alone"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8", newline="\n")
    (tmp_path / "written" / "LOT.toml").write_text("schema = 1\n", encoding="utf-8", newline="\n")
    (tmp_path / "folders" / "u1").mkdir()
    (tmp_path / "folders" / "u1" / "rates.csv").write_text("run,rate,x\n", encoding="utf-8", newline="\n")
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "lot.json").write_text("{}\n", encoding="utf-8", newline="\n")
    return tmp_path


def refusal(call: object, path: str) -> Problem:
    with pytest.raises(InertialcalError) as error:
        call(path)  # type: ignore[operator]
    assert error.value.exit_status == 3
    return error.value.problems[0]


@pytest.mark.parametrize("call", [ic.info, ic.run, ic.check, start])
@pytest.mark.parametrize("path", ["written", "written/LOT.toml"])
def test_a_lot_leads_to_lot(folders: Path, call: object, path: str) -> None:
    found = refusal(call, path)
    assert "lot of units" in f"{found.what} {found.why} {found.do}"
    assert f"inertialcal lot {path} -o written-out" in found.do


@pytest.mark.parametrize("call", [ic.run, ic.check])
def test_a_template_whose_units_lie_in_folders_leads_to_lot(folders: Path, call: object) -> None:
    assert "inertialcal lot folders -o folders-out" in refusal(call, "folders").do
    assert refusal(call, "alone").what == "recordings.rates: file 'rates.csv' does not exist"


@pytest.mark.parametrize("call", [ic.info, ic.run, ic.check, start])
@pytest.mark.parametrize("path", ["made", "made/lot.json"])
def test_what_a_lot_gave_is_told_so(folders: Path, call: object, path: str) -> None:
    found = refusal(call, path)
    assert "what a lot gave" in f"{found.what} {found.do}"
    assert str(Path("made") / "report.html") in found.do


@pytest.mark.parametrize("call", [ic.info, ic.run, ic.check])
def test_the_file_of_a_campaign_leads_to_its_folder(folders: Path, call: object) -> None:
    assert refusal(call, "alone/campaign.toml").do.endswith("inertialcal run alone")


def test_a_recording_in_the_folder_of_a_unit_leads_to_lot(folders: Path) -> None:
    rows = "run,rate [deg/s],x [deg/s]\n" + "".join(f"{n % 3},{rate},{rate * 1.001}\n" for n, rate in enumerate(RATES))
    for path in ("folders/u1/rates.csv", "written/rates.csv", "alone/rates.csv", "alone/data/rates.csv"):
        (folders / path).parent.mkdir(exist_ok=True)
        (folders / path).write_text(rows, encoding="utf-8", newline="\n")
    names, commands = ("folders/u1", "written", "alone", "alone/data"), ("info", "run", "lot")
    said = {name: str(ic.info(f"{name}/rates.csv", commands=commands).next) for name in names}
    assert said["folders/u1"] == "inertialcal lot folders -o folders-out"
    assert said["written"] == "inertialcal lot written -o written-out"
    assert said["alone"] == said["alone/data"] == "inertialcal run alone"
