"""Lots whose recordings lie in an S3 store, and units that go into an archive."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from s3_server import KEY, served
from small_lot import digests, folder_lot, rows, shared_lot

import inertialcal as ic
from inertialcal.core.errors import InertialcalError

SECRET = "never-written-anywhere"


@pytest.fixture
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {
        "AWS_ACCESS_KEY_ID": KEY,
        "AWS_SECRET_ACCESS_KEY": SECRET,
        "AWS_EC2_METADATA_DISABLED": "true",
        "AWS_REGION": "us-east-1",
    }.items():
        monkeypatch.setenv(name, value)


def remote(root: Path, address: str, more: str) -> Path:
    path = root / "LOT.toml"
    text = f'schema = 1\nid = "lot"\nunits = "units.csv"\nstore = "s3://bucket/lot"\nendpoint = "{address}"\n{more}'
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def test_files_of_a_store_give_what_files_of_a_folder_give(keys: None, tmp_path: Path) -> None:
    local = folder_lot(tmp_path / "s3" / "bucket" / "lot", 4)
    ic.lot(local, tmp_path / "here", workers=0)
    (tmp_path / "job").mkdir()
    shutil.copyfile(local / "campaign.toml", tmp_path / "job" / "campaign.toml")
    (tmp_path / "job" / "units.csv").write_text("serial\nu000\nu001\nu002\nu003\nu404\n", encoding="utf-8")
    with served(tmp_path / "s3") as (address, asked):
        lot = remote(tmp_path / "job", address, 'folder = "{serial}"\n')
        outcome = ic.lot(lot, tmp_path / "out", workers=0)
        found = rows(tmp_path / "out")
        assert [one["results"] for one in found[:4]] == [one["results"] for one in rows(tmp_path / "here")]
        assert [one["inputs"] for one in found[:4]] == [one["inputs"] for one in rows(tmp_path / "here")]
        assert (found[4]["reason_code"], outcome.counts["quarantined"]) == ("missing_file", 1)
        assert "inertialcal-lot" not in str(found)  # no folder for the time of a block
        again = ic.lot(lot, tmp_path / "out", resume=True, workers=0)
        assert (again.redone, again.kept) == (0, 5)
        assert asked
    for path in tmp_path.joinpath("out").rglob("*"):
        assert not path.is_file() or SECRET.encode() not in path.read_bytes()
    with pytest.raises(InertialcalError):  # nobody answers any more
        ic.lot(lot, tmp_path / "out", resume=True, workers=0)


def test_a_file_of_many_units_in_a_store(keys: None, tmp_path: Path) -> None:
    made = shared_lot(tmp_path / "s3" / "bucket" / "lot", 3).parent
    ic.lot(made / "LOT.toml", tmp_path / "here", workers=0)
    (tmp_path / "job").mkdir()
    for name in ("campaign.toml", "units.csv"):
        shutil.copyfile(made / name, tmp_path / "job" / name)
    with served(tmp_path / "s3") as (address, _):
        lot = remote(tmp_path / "job", address, '[files]\nrates = { file = "rates.parquet", serial = "unit" }\n')
        ic.lot(lot, tmp_path / "out", workers=0)
    assert rows(tmp_path / "out") == rows(tmp_path / "here")


def test_an_archive_has_each_unit_once_also_after_resume(tmp_path: Path) -> None:
    lot = folder_lot(tmp_path / "lot", 6)
    (lot / "u001" / "rates.csv").write_text("run,rate,x\nr0,1,none\n", encoding="utf-8")
    where = str(tmp_path / "lab.db")
    ic.lot(lot, tmp_path / "out", workers=0)
    plain = digests(tmp_path / "out")
    outcome = ic.lot(lot, tmp_path / "out", resume=True, workers=0, archive=where)
    assert (outcome.archived, outcome.redone) == (5, 5)
    again = ic.lot(lot, tmp_path / "out", resume=True, workers=0, archive=where)
    assert (again.archived, again.redone) == (0, 0)
    assert digests(tmp_path / "out") == plain
    ic.lot(lot, tmp_path / "other", workers=0, archive=where)  # the same results are no second campaign
    archive = ic.open_archive(where)
    listed = archive.list().campaigns
    assert [one.serial for one in listed] == ["u000", "u002", "u003", "u004", "u005"]
    assert archive.verify().problems == ()
    assert archive.compare(1, 2)
