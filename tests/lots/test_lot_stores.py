"""Lots whose recordings lie in an S3 store, and units that go into an archive."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from s3_server import KEY, served
from small_lot import CAMPAIGN, digests, folder_lot, rows, shared_lot

import inertialcal as ic
from inertialcal.campaign.file.recordings import RecordingEntry
from inertialcal.core.errors import InertialcalError
from inertialcal.lots import stores
from inertialcal.lots.stores import Delivery, Place, Shared, UnitStore

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


def delivered(folder: Path, table: pa.Table, rows_of_a_group: int) -> dict[int, tuple[str, list[str]]]:
    """Return digest and readings of two of three units out of a file of many."""
    folder.mkdir()
    pq.write_table(table, folder / "all.parquet", row_group_size=rows_of_a_group)
    shared = Shared("all.parquet", "serial", (("again", "again"),))
    found = {}
    with Delivery(Place(str(folder)), {"still": shared}) as delivery:
        cells = {0: {"serial": "b", "again": "1"}, 1: {"serial": "a", "again": ""}, 2: {"serial": "z", "again": "1"}}
        refused = delivery.load_shared(cells)
        assert [(number, one.problems[0].code) for number, one in refused.items()] == [(2, "no_rows")]
        for number in (0, 1):
            handed = delivery.handed.get(number, {})
            store = UnitStore(folder, Counter(["all.parquet"]), root=delivery.root(number), handed=handed)
            one = store.recording(RecordingEntry(sensor="gyro", file="all.parquet", channels={}), [])
            assert store.has("all.parquet")
            assert len(store.table("all.parquet")) == len(one)
            found[number] = one.source.sha256, [repr(channel.data.tolist()) for channel in one.channels]
    return found


def test_a_store_that_cannot_be_reached_is_refused_soon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stores, "PATIENCE", 1)
    (tmp_path / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (tmp_path / "units.csv").write_text("serial\n1\n2\n", encoding="utf-8")
    told = {"hdfs://nowhere/x": "wrong_value", "nfs://nowhere/x": "wrong_value"}
    told["gs://anonymous@nowhere/x?scheme=http&endpoint_override=127.0.0.1%3A9"] = "unreachable"
    for store, code in told.items():
        text = f'schema = 1\nid = "lot"\nunits = "units.csv"\nfolder = "{{serial}}"\nstore = "{store}"\n'
        (tmp_path / "LOT.toml").write_text(text, encoding="utf-8")
        with pytest.raises(InertialcalError) as error:
            ic.lot(tmp_path, tmp_path / "out", workers=0, resume=(tmp_path / "out" / "ledger.sqlite").is_file())
        assert [one.code for one in error.value.problems] == [code]


def test_rows_of_a_unit_are_the_same_wherever_they_stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    serial = np.repeat(["a", "b", "c"], 40)
    again = [None if one == "a" else int(k % 2) for k, one in enumerate(serial)]
    table = pa.table(
        {
            "serial": serial,
            "again": pa.array(again, pa.int64()),
            "t": np.arange(120.0),
            "on": rng.random(120) < 0.5,
            "x": rng.normal(size=120),
        }
    )
    whole = delivered(tmp_path / "whole", table, 120)
    assert whole[0][1][-1] == repr(table["x"].to_pylist()[41:80:2])
    assert whole[1][1][-1] == repr(table["x"].to_pylist()[:40])
    mixed = table.take(pa.array(np.argsort(np.arange(120) % 40, kind="stable")))
    assert delivered(tmp_path / "mixed", mixed, 7) == whole
    assert delivered(tmp_path / "groups", table, 7) == whole
    coded = table.set_column(0, "serial", table["serial"].dictionary_encode())
    assert delivered(tmp_path / "coded", coded, 50) == whole
    monkeypatch.setattr("inertialcal.lots.stores.HELD", 0)  # too much for memory: through a file
    on_disk = delivered(tmp_path / "disk", mixed, 7)
    assert [one[1] for one in on_disk.values()] == [one[1] for one in whole.values()]


def test_groups_of_rows_are_found_by_what_the_footer_says_now(tmp_path: Path) -> None:
    serials = np.repeat([f"u{k:02d}" for k in range(8)], 4)
    shared = {"still": Shared("all.parquet", "serial")}

    def read(wanted: str) -> list[float] | None:
        with Delivery(Place(str(tmp_path)), shared) as delivery:
            delivery.load_shared({0: {"serial": wanted}})
            handed = delivery.handed.get(0)
            return None if handed is None else list(handed["all.parquet"][0].columns[0].values.tolist())

    for texts in (pa.array(serials), pa.array(serials).dictionary_encode(), pa.array(np.repeat(np.arange(8), 4))):
        for statistics in (True, False):
            table = pa.table({"serial": texts, "x": pa.array(np.arange(32.0))})
            path = tmp_path / "all.parquet"
            pq.write_table(table, path, row_group_size=6, write_statistics=statistics)
            name = str(texts[20].as_py())
            assert read(name) == [20.0, 21.0, 22.0, 23.0]
            assert read("none") is None
            pq.write_table(table.slice(4), path, row_group_size=12)  # while another process has read its footer
            assert read(name) == [20.0, 21.0, 22.0, 23.0]


def test_the_digest_of_rows_is_that_of_what_arrow_streams() -> None:
    rng, n = np.random.default_rng(3), 40
    table = pa.table(
        {
            "x": rng.random(n),
            "short": rng.integers(0, 9, n).astype("i2"),
            "gone": pa.array([None if one < 0.2 else one for one in rng.random(n)]),
            "yes": pa.array(rng.random(n) < 0.5),
            "word": pa.array([f"w{k % 3}" for k in range(n)]).dictionary_encode(),
        }
    )
    parts = [range(11), range(11, 22), range(22, n), range(11, 22)]
    plain = stores.plain_rows(table)
    alone = [stores.digests_of(stores.plain_rows(table.slice(one.start, len(one))), [range(len(one))]) for one in parts]
    assert [[one] for one in stores.digests_of(plain, parts)] == alone
    copied = stores.plain_rows(pa.concat_tables([table.slice(0, 5), table.slice(5)]))  # in two pieces
    assert stores.digests_of(copied, parts) == stores.digests_of(plain, parts)


@pytest.mark.parametrize("kind", [pa.dictionary(pa.int32(), pa.string()), pa.string(), pa.int64(), pa.float64()])
@pytest.mark.parametrize("cells", [[], ["3", "3", "1", "3", "3", "2"], ["3", None, None, "1", "3"]])
def test_rows_by_what_tells_units_apart_are_those_that_have_it(kind: pa.DataType, cells: list[str | None]) -> None:
    plain = pa.array(cells, pa.string())
    one = plain.dictionary_encode() if pa.types.is_dictionary(kind) else plain.cast(kind)
    other = pa.array([i // 2 for i in range(len(cells))], pa.int64())
    found = stores._rows_by_key(pa.table({"serial": one, "again": other}), ("serial", "again"))
    texts = ["" if cell is None else str(cell) for cell in one.cast(pa.string()).to_pylist()]
    expected: dict[tuple[str, ...], list[int]] = {}
    for row, key in enumerate(zip(texts, map(str, other.to_pylist()), strict=True)):
        expected.setdefault(key, []).append(row)
    assert {key: [int(row) for row in own] for key, own in found.items()} == expected
