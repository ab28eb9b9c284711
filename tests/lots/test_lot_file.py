"""LOT.toml and the table of units: all that is wrong with them, by its place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from small_lot import CAMPAIGN, csv, folder_lot, rates, rows, shared_lot

import inertialcal as ic
from inertialcal.campaign.start.info import info
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.lots.lot_file import LotFile, SharedFile, load_lot
from inertialcal.lots.rows import OWN

DOCS = Path(__file__).resolve().parents[2] / "docs" / "commands" / "lot.md"


def test_every_key_stands_on_the_page() -> None:
    page = DOCS.read_text(encoding="utf-8")
    for model in (LotFile, SharedFile):
        for name, field in model.model_fields.items():
            assert f"| `{field.alias or name}` |" in page


def test_every_column_stands_on_the_page() -> None:
    page = DOCS.read_text(encoding="utf-8")
    assert [name for name in OWN if f"`{name}`" not in page] == []


def lot_of(root: Path, text: str, units: str = "serial,batch\n1,a\n2,b\n") -> Path:
    root.mkdir(exist_ok=True)
    (root / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (root / "units.csv").write_text(units, encoding="utf-8")
    path = root / "LOT.toml"
    path.write_text('schema = 1\nid = "lot"\nunits = "units.csv"\n' + text, encoding="utf-8")
    return path


def codes(path: Path) -> Sequence[tuple[str, str]]:
    with pytest.raises(InertialcalError) as error:
        load_lot(path)
    return [(one.code, one.where) for one in error.value.problems]


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("folder = 3\n", "wrong_value", 4),
        ("fodler = 'x'\n", "unknown_key", 4),
        ("folder = '../{serial}'\n", "outside", 4),
        ("folder = '/data/{serial}'\n", "outside", 4),
        ("folder = 'C:\\{serial}'\n", "outside", 4),
        ("folder = '{unit}'\n", "unknown_column", 4),
        ("folder = 'all'\n", "same_file", None),
        ("folder = '{serial}'\n[files]\nrate = 'x'\n", "unknown_name", 6),
        ("[files]\nrates = 'a/../../{serial}.csv'\n", "outside", 5),
        ("[files]\nrates = { file = 'x.csv' }\n", "missing_key", 5),
        ("[files]\nrates = { file = 'x.csv', serial = 's', match = { lot = 'lot' } }\n", "unknown_column", 5),
        ("folder = '{serial}'\n[options]\n'sensors.acc.unit' = 'batch'\n", "unknown_key", 6),
        ("folder = '{serial}'\n[options]\n'sensors.gyro.unit' = 'unit'\n", "unknown_column", 6),
        ("folder = '{serial}'\n[options]\n'tests.none.plan.axis' = 'batch'\n", "unknown_key", 6),
        ("folder = '{serial}'\nstore = 'nowhere'\n", "missing_file", 5),
        ("folder = '{serial}'\nstore = 's3://key:secret@host/bucket'\n", "wrong_value", 5),
        ("folder = '{serial}'\nendpoint = 'localhost'\n", "wrong_value", 5),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, code: str, line: int | None) -> None:
    found = codes(lot_of(tmp_path / "lot", text))
    assert code in [one for one, _ in found]
    if line is not None:
        assert (code, f"LOT.toml:{line}") in found


@pytest.mark.parametrize(
    ("units", "code"),
    [
        ("unit\n1\n", "unknown_column"),
        ("serial\n", "no_units"),
        ("serial,a\n1,2\n,3\n", "empty_serial"),
        ("serial,a\n1,2\n1\n", "damaged_file"),
        ("serial,serial\n1,2\n", "duplicate_column"),
        ("", "empty_file"),
    ],
)
def test_a_table_of_units_that_is_none_is_refused(tmp_path: Path, units: str, code: str) -> None:
    path = lot_of(tmp_path / "lot", "folder = '{serial}'\n", units)
    assert codes(path)[0][0] in {code, "damaged_file"}


def test_the_heading_of_serial_numbers_is_called_serial(tmp_path: Path) -> None:
    path = lot_of(tmp_path / "lot", "serial = 'Nr'\nfolder = '{Nr}'\n", "Nr\n1\n")
    with pytest.raises(InertialcalError, match="called 'serial' from there on"):
        load_lot(path)


def test_serial_numbers_stay_text_and_other_columns_keep_their_types(tmp_path: Path) -> None:
    path = lot_of(tmp_path / "lot", "folder = '{serial}'\n", "serial,when,n\n0012,2026-01-02T03:04:05,3\n0013,,4\n")
    units = load_lot(path).units
    assert units.serials == ["0012", "0013"]
    assert units.table["n"].to_pylist() == [3, 4]
    assert pa.types.is_timestamp(units.table.schema.field("when").type)
    pq.write_table(pa.table({"serial": [12, 13], "lists": [[1], [2]]}), tmp_path / "lot" / "units.csv")
    assert codes(path)[0][0] == "wrong_type"


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_a_table_of_units_as_a_german_program_writes_it(tmp_path: Path, encoding: str) -> None:
    """Semicolons, decimal commas, a heading of its own for the serial number; what names a folder stays as it is."""
    root = folder_lot(tmp_path / "lot", 1)
    (root / "u000").rename(root / "007-Ä1")
    cells = (
        "Seriennummer;Los;Prüfplatz;Temperatur;Geprüft am\r\nÄ1;007;P1;21,5;12.03.2026 08:30\r\nÄ2;008;P2;;heute\r\n"
    )
    text = "serial = 'Seriennummer'\nfolder = '{Los}-{serial}'\n[line]\nstation = 'Prüfplatz'\nplace = 'Geprüft am'\n"
    path = lot_of(root, text)
    (root / "units.csv").write_bytes(cells.encode(encoding))
    outcome = ic.lot(path, tmp_path / "out", workers=0, report=False)
    found = rows(tmp_path / "out")
    assert [one["serial"] for one in found] == ["Ä1", "Ä2"]
    assert [one["reason_code"] for one in found] == ["", "missing_file"]
    assert [one["Temperatur"] for one in found] == [21.5, None]
    assert ("not_utf8" in {one.code for one in outcome.remarks}) is (encoding == "cp1252")
    (root / "units.csv").write_bytes(cells.replace("Seriennummer", "Nummer").encode(encoding))
    with pytest.raises(InertialcalError, match="It has: Nummer, Los, Prüfplatz"):
        load_lot(path)


def test_files_that_say_whose_they_are_by_a_pattern(tmp_path: Path) -> None:
    """A file a day with semicolons and decimal commas, and one with the readings of another unit."""
    root = folder_lot(tmp_path / "lot", 4)
    for day, units in (("1", (0, 1)), ("2", (2, 0))):
        said = [f"Nr;{line}" if not k else f"u{unit:03d};{line}" for unit in units
                for k, line in enumerate((root / f"u{unit:03d}" / "rates.csv").read_text(encoding="utf-8").splitlines())
                if k or unit == units[0]]  # fmt: skip
        (root / f"{day}.csv").write_text("\n".join(said).replace(",", ";").replace(".", ",") + "\n", encoding="utf-8")
    text = "[files]\nrates = { file = '{day}.csv', serial = 'Nr' }\n"
    path = lot_of(root, text, "serial,day\nu000,1\nu001,1\nu002,2\nu003,2\nu004,3\n")
    ic.lot(path, tmp_path / "out", workers=0, report=False)
    found = rows(tmp_path / "out")
    assert [one["reason_code"] for one in found] == ["", "", "", "no_rows", "missing_file"]
    alone = lot_of(root, "folder = '{serial}'\n", "serial\nu000\nu001\nu002\n")
    ic.lot(alone, tmp_path / "alone", workers=0, report=False)
    assert [one["results"] for one in found[:3]] == [one["results"] for one in rows(tmp_path / "alone")]


def test_a_unit_that_stands_in_the_table_twice_is_refused(tmp_path: Path) -> None:
    lot = shared_lot(tmp_path / "lot", 3)
    table = tmp_path / "lot" / "units.csv"
    table.write_text(table.read_text(encoding="utf-8") + "u001,S2,1,new\n", encoding="utf-8")
    with pytest.raises(InertialcalError) as error:
        ic.lot(lot, tmp_path / "out", workers=0)
    assert error.value.problems[0].code == "duplicate_unit"


def test_a_unit_tested_twice_has_files_of_each_time(tmp_path: Path) -> None:
    root = tmp_path / "lot"
    path = lot_of(root, "[files]\nrates = '{serial}-{batch}.csv'\n", "serial,batch\n7,a\n7,b\n")
    for seed, batch in enumerate("ab"):
        (root / f"7-{batch}.csv").write_text(csv(rates(seed)), encoding="utf-8")
    outcome = ic.lot(path, tmp_path / "out", workers=0)
    assert outcome.counts["done"] == 2
    assert [one["serial"] for one in rows(tmp_path / "out")] == ["7", "7"]


@pytest.mark.parametrize("cell", ["..", "../u000", "a/b", "a\\b", ""])
def test_a_cell_leads_nowhere_else(tmp_path: Path, cell: str) -> None:
    root = folder_lot(tmp_path / "lot", 2)
    path = lot_of(root, "folder = '{place}'\n", f"serial,place\nu000,u000\nu001,{cell}\n")
    ic.lot(path, tmp_path / "out", workers=0)
    found = rows(tmp_path / "out")
    assert [one["status"] for one in found] == ["done", "quarantined"]
    assert found[1]["reason_code"] == "bad_path"


def test_a_link_out_of_the_store_is_refused(tmp_path: Path) -> None:
    root = folder_lot(tmp_path / "lot", 2)
    (tmp_path / "secret").mkdir()
    (root / "u001" / "rates.csv").rename(tmp_path / "secret" / "rates.csv")
    (root / "u001" / "rates.csv").symlink_to(tmp_path / "secret" / "rates.csv")
    ic.lot(root, tmp_path / "out", workers=0)
    assert [one["reason_code"] for one in rows(tmp_path / "out")] == ["", "outside"]


def test_options_stand_in_place_of_what_the_campaign_says(tmp_path: Path) -> None:
    root = folder_lot(tmp_path / "lot", 3)
    text = "folder = '{serial}'\n[options]\n'item.owner' = 'owner'\n'requirements.R1.limit' = 'limit'\n"
    units = "serial,owner,limit\nu000,us,0.1 %\nu001,,\nu002,them,1 furlong\n"
    outcome = ic.lot(lot_of(root, text, units), tmp_path / "out", workers=0)
    found = rows(tmp_path / "out")
    assert [one["verdict"] for one in found] == ["FAIL", "PASS", ""]
    assert found[2]["status"] == "quarantined"
    assert "furlong" in str(found[2]["reason"])
    assert outcome.counts["FAIL"] == 1


def test_a_template_lies_in_a_folder_of_its_own(tmp_path: Path) -> None:
    root = folder_lot(tmp_path / "data", 2)
    (root / "campaign.toml").rename(tmp_path / "campaign.toml")
    (tmp_path / "units.csv").write_text("serial\nu000\nu001\n", encoding="utf-8")
    text = 'schema = 1\nid = "lot"\nunits = "units.csv"\nstore = "data"\nfolder = "{serial}"\n'
    (tmp_path / "LOT.toml").write_text(text, encoding="utf-8")
    assert ic.lot(tmp_path / "LOT.toml", tmp_path / "out", workers=0).counts["done"] == 2


def test_a_folder_without_campaign_or_units_is_refused(tmp_path: Path) -> None:
    assert codes(tmp_path)[0][0] == "no_campaign"
    (tmp_path / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    assert codes(tmp_path)[0][0] == "no_units"
    folder_lot(tmp_path / "lot", 2)
    (tmp_path / "lot" / "u000" / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    assert [one.code for one in load_lot(tmp_path / "lot").remarks] == ["own_campaign"]


def test_a_lot_whose_template_is_not_there_is_told_where_it_was_sought(tmp_path: Path) -> None:
    path = lot_of(tmp_path, 'campaign = "templates"\nfolder = "{serial}"\n', "serial\nu000\n")
    assert codes(path) == [("no_campaign", "LOT.toml:4")]


def test_a_name_is_told_what_it_may_hold(tmp_path: Path) -> None:
    path = lot_of(folder_lot(tmp_path / "lot", 2), "[files]\n'a b' = '{serial}'\n", "serial\nu000\n")
    with pytest.raises(InertialcalError) as error:
        load_lot(path)
    assert "letters" in error.value.problems[0].what


@pytest.mark.parametrize("pattern", ["{serial}/{batch", "{serial}}/rates.csv", "{{serial}/rates.csv"])
def test_a_brace_without_the_other_is_told(tmp_path: Path, pattern: str) -> None:
    path = lot_of(folder_lot(tmp_path / "lot", 2), f"[files]\nrates = '{pattern}'\n", "serial\nu000\nu001\n")
    assert codes(path) == [("wrong_value", "LOT.toml:5")]


def test_a_recording_that_no_unit_has_refuses_the_lot_and_not_every_unit(tmp_path: Path) -> None:
    root = folder_lot(tmp_path / "lot", 3)
    path = lot_of(root, "[files]\nrates = '{serial}/rate.csv'\n", "serial\nu000\nu001\nu002\n")
    with pytest.raises(DataError) as error:
        ic.lot(path, tmp_path / "out", workers=0)
    (problem,) = error.value.problems
    assert problem.code == "missing_file"
    assert "{serial}/rate.csv" in problem.what
    for one in ("u001", "u002"):
        (root / one / "rates.csv").rename(root / one / "rate.csv")
    outcome = ic.lot(path, tmp_path / "out", workers=0)  # the folder still takes a lot
    assert (outcome.counts["done"], outcome.counts["quarantined"]) == (2, 1)


def test_a_file_of_a_lot_leads_to_the_lot(tmp_path: Path) -> None:
    path = lot_of(folder_lot(tmp_path / "lot", 2), "folder = '{serial}'\n", "serial\nu000\nu001\n")
    found = info(path.parent / "u000" / "rates.csv", commands=("run", "init", "lot"))
    assert (found.next or "").startswith("inertialcal lot ")
