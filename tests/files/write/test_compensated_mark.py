"""The mark of a compensated recording: kept by every format, by convert, by pandas; refused a second time."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.sensor_model import Item, SensorModel

Typed = Callable[..., tuple[int, dict[str, Any]]]
FORMATS = ("csv", "parquet", "npz")
CAMPAIGN = """\
schema = 2
[campaign]
id = "marked"
[sensors.gyro]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
[recordings.still]
sensor = "gyro"
file = "FILE"
channels = { x = { column = "gyro_x", unit = "deg/s" } }
[[tests]]
id = "still"
procedure = "static_noise"
recordings = ["still"]
use = "USE"
"""


@pytest.fixture
def model(tmp_path: Path) -> SensorModel:
    one = np.ones(1)
    made = SensorModel("gyro", ("x",), one, "rad/s", np.full((1, 1, 1), 1.1), 0.01 * one, Item(serial="7"))
    write_model(tmp_path / "model.json", made)
    return made


@pytest.fixture
def mark(model: SensorModel, tmp_path: Path) -> str:
    """Return the mark: the first digits of the checksum in the file of the model."""
    return str(json.loads((tmp_path / "model.json").read_text())["checksum"]).removeprefix("sha256:")[:12]


@pytest.fixture
def typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Typed:
    monkeypatch.chdir(tmp_path)
    noise = np.random.default_rng(1).normal(0.0, 0.1, 400)
    rows = "".join(f"{i / 10},{value!r},{25 + i % 3}\n" for i, value in enumerate(noise.tolist()))
    (tmp_path / "raw.csv").write_text("t_s,gyro_x [deg/s],temp_degC\n" + rows)

    def call(*words: Any) -> tuple[int, dict[str, Any]]:
        with pytest.raises(SystemExit) as left:
            main([*map(str, words), "--json"])
        content: dict[str, Any] = json.loads(capsys.readouterr().out)
        return int(left.value.code or 0), content

    return call


@pytest.fixture
def done(typed: Typed, mark: str, tmp_path: Path) -> Path:
    """Return the folder with the recording compensated, in each format."""
    for ending in FORMATS:
        status, content = typed("compensate", "model.json", "raw.csv", "-o", f"done.{ending}")
        assert (status, content["compensated_by"]) == (0, mark)
    return tmp_path


def refused(typed: Typed, file: Path, mark: str) -> None:
    status, content = typed("compensate", "model.json", file, "-o", "twice.csv")
    assert (status, content["errors"][0]["code"]) == (3, "already_compensated")
    assert mark in content["errors"][0]["what"]
    assert content["errors"][0]["where"] == str(file)
    assert not Path("twice.csv").exists()


@pytest.mark.parametrize("ending", FORMATS)
def test_a_second_compensation_is_refused(done: Path, typed: Typed, mark: str, ending: str) -> None:
    file = done / f"done.{ending}"
    refused(typed, file, mark)
    refused(typed, file.rename(done / "another_name.dat"), mark)


@pytest.mark.parametrize("second", FORMATS)
@pytest.mark.parametrize("first", FORMATS)
def test_convert_keeps_the_mark(done: Path, typed: Typed, mark: str, first: str, second: str) -> None:
    assert typed("convert", f"done.{first}", f"again.{second}")[0] == 0
    found = ic.read(done / f"again.{second}")
    assert (found.compensated_by, found.names) == (mark, ("gyro_x [deg/s]", "temp_degC"))
    refused(typed, done / f"again.{second}", mark)


@pytest.mark.parametrize("options", [{"index": False}, {}, {"index": False, "sep": ";"}])
def test_pandas_keeps_the_mark(done: Path, typed: Typed, mark: str, options: dict[str, Any]) -> None:
    table = pd.read_csv(done / "done.csv")
    table.iloc[::-1].iloc[::-1].assign(more=2.5).to_csv(done / "pandas.csv", **options)
    assert ic.read(done / "pandas.csv").compensated_by == mark
    refused(typed, done / "pandas.csv", mark)
    pd.concat([table, pd.read_csv(done / "raw.csv")]).to_csv(done / "both.csv", index=False)
    refused(typed, done / "both.csv", mark)
    pd.read_parquet(done / "done.parquet").to_parquet(done / "pandas.parquet")
    refused(typed, done / "pandas.parquet", mark)


def test_info_says_so_and_shows_no_channel(done: Path, typed: Typed, mark: str) -> None:
    one = typed("info", "done.csv")[1]["results"][0]
    assert one["compensated_by"] == mark
    assert [channel["name"] for channel in one["channels"]] == ["gyro_x [deg/s]", "temp_degC"]
    said = [remark for remark in one["remarks"] if remark["code"] == "compensated"]
    assert [(remark["severity"], mark in remark["what"]) for remark in said] == [("info", True)]
    assert typed("info", "raw.csv")[1]["results"][0]["compensated_by"] == ""
    assert f"compensated by model {mark}" in str(ic.read(done / "done.csv"))


def test_a_noun_takes_it_and_says_so(done: Path, typed: Typed) -> None:
    status, content = typed("allan", "done.csv")
    assert status == 0
    assert [one["severity"] for one in content["remarks"] if one["code"] == "compensated"] == ["info"]


@pytest.mark.parametrize(
    ("use", "file", "expected"),
    [("fit", "done.csv", ["warning"]), ("report_only", "done.csv", ["info"]), ("fit", "raw.csv", [])],
)
def test_a_campaign_warns_of_a_fit_to_it(done: Path, use: str, file: str, expected: list[str]) -> None:
    folder = done / "campaign"
    folder.mkdir()
    shutil.copyfile(done / file, folder / file)
    name = "gyro_x [deg/s]"
    text = CAMPAIGN.replace("FILE", file).replace("USE", use).replace('column = "gyro_x"', f'column = "{name}"')
    (folder / "campaign.toml").write_text(text)
    remarks = [one for one in ic.run(folder, write=False).remarks if one.code == "compensated"]
    assert [one.severity for one in remarks] == expected
    assert all(one.where.endswith(file) for one in remarks)


def test_python_sets_and_checks_it(done: Path, model: SensorModel, mark: str) -> None:
    once = ic.compensate(model, ic.read(done / "raw.csv"))
    assert once.compensated_by == mark
    with pytest.raises(DataError, match=f"already compensated by model {mark}") as caught:
        ic.compensate(model, once)
    assert caught.value.problems[0].code == "already_compensated"
    ic.write(done / "python.npz", once)
    assert ic.read(done / "python.npz").compensated_by == mark


def test_the_same_model_has_the_same_mark_however_it_is_laid_out(done: Path, typed: Typed, mark: str) -> None:
    content = json.loads((done / "model.json").read_text())
    (done / "anew.json").write_text(json.dumps(dict(sorted(content.items())), indent=3))
    assert typed("compensate", "anew.json", "raw.csv", "-o", "anew.csv")[1]["compensated_by"] == mark
