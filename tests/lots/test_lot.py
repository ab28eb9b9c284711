"""Lots: what comes out of each unit, of bad ones, of a second time, and by how many processes."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from small_lot import CAMPAIGN, csv, digests, folder_lot, rates, rows, shared_lot

import inertialcal as ic
from inertialcal.campaign.engine import engine
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, StoreError, UsageError
from inertialcal.core.results import COLUMNS, flat
from inertialcal.lots import block as block_module
from inertialcal.lots import page, publish, workers
from inertialcal.lots.ledger import Ledger
from inertialcal.procedures import procedure_of
from inertialcal.procedures.protocol import Procedure


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A lot of twelve units as folders, and what comes out of it in this process."""
    root = tmp_path_factory.mktemp("made")
    lot = folder_lot(root / "lot", 12)
    assert ic.lot(lot, root / "out", workers=0).exit_status == 1
    return lot, root / "out"


def copied(made: tuple[Path, Path], to: Path) -> tuple[Path, Path]:
    lot, out = (Path(shutil.copytree(one, to / one.name)) for one in made)
    return lot, out


def test_a_unit_has_the_figures_verdicts_and_model_of_its_campaign(made: tuple[Path, Path], tmp_path: Path) -> None:
    lot, out = made
    alone = tmp_path / "alone"
    shutil.copytree(lot / "u004", alone)
    text = CAMPAIGN.replace('part = "G1"', 'part = "G1"\nserial = "u004"')
    (alone / "campaign.toml").write_text(text, encoding="utf-8")
    found = ic.run(alone)
    row = rows(out)[4]
    assert (row["serial"], row["status"], row["verdict"]) == ("u004", "done", found.verdict) == ("u004", "done", "FAIL")
    results: Any = row["results"]
    own = [{name: cell for name, cell in one.items() if name != "common"} for one in results]
    assert own == [flat(one) for one in found.results["results"]]
    assert [tuple(one) for one in results[:1]] == [(*COLUMNS, "common")]
    verdicts: Any = row["verdicts"]
    expected = [one | (one["interval"] or {}) for one in found.results["verdicts"]]
    assert verdicts == [{name: one[name] for name in verdicts[0]} for one in expected]
    assert row["model"] == [{"name": "model.json", "json": (alone / "out" / "model.json").read_text(encoding="utf-8")}]
    assert row["inputs"] == [{"path": "u004/rates.csv", "sha256": found.inputs["rates.csv"]}]
    said = {(one["code"], one["what"]) for one in found.results["remarks"]}
    remarks: Any = row["remarks"]
    assert {(one["code"], one["what"]) for one in remarks} == said
    assert {one["test"] for one in remarks} <= {"rate", "closed loop"}


def test_verdicts_are_those_of_the_truth(made: tuple[Path, Path]) -> None:
    verdicts = [str(one["verdict"]) for one in rows(made[1])]
    assert verdicts == ["FAIL" if number % 5 == 4 else "PASS" for number in range(12)]


def test_the_bytes_are_the_same_by_two_processes(made: tuple[Path, Path], tmp_path: Path) -> None:
    ic.lot(made[0], tmp_path / "out", workers=2)
    assert digests(tmp_path / "out") == digests(made[1])


@pytest.mark.parametrize("csv_file", [False, True])
def test_a_file_of_many_units_gives_what_files_of_their_own_give(
    made: tuple[Path, Path], tmp_path: Path, csv_file: bool
) -> None:
    lot = shared_lot(tmp_path / "lot", 12, csv_file)
    (tmp_path / "lot" / "campaign.toml").write_text(CAMPAIGN.replace("rates.csv", "rates.x"), encoding="utf-8")
    outcome = ic.lot(lot, tmp_path / "out", workers=0)
    assert outcome.counts["quarantined"] == 0
    for one, other in zip(rows(tmp_path / "out"), rows(made[1]), strict=True):
        assert one["results"] == other["results"]
        assert one["verdict"] == other["verdict"]
    table = pq.read_table(tmp_path / "out" / "units" / "part-00000.parquet")
    assert table["station"].to_pylist()[:4] == ["S0", "S1", "S2", "S0"]
    assert table["chamber_position"].to_pylist()[:3] == [0, 1, 2]
    assert table["unit_status"].to_pylist()[0] == "new"  # a column of the table of units that has a name of ours
    assert outcome.to_frame()["station"].tolist()[1] == "S1"


def test_a_bad_unit_is_quarantined_with_its_reason_and_the_others_go_on(tmp_path: Path) -> None:
    lot = folder_lot(tmp_path / "lot", 8)
    (lot / "u001" / "rates.csv").unlink()
    (lot / "u001" / "note.txt").write_text("x", encoding="utf-8")
    (lot / "u002" / "rates.csv").write_text("run,rate,x\nr0,1,none\n", encoding="utf-8")
    (lot / "u003" / "rates.csv").write_bytes(b"PAR1 rubbish PAR1")
    # Without any file of the campaign it is no unit, which is told
    outcome = ic.lot(lot, tmp_path / "out", workers=2)
    assert outcome.remarks[0].code == "no_unit"
    found = {str(one["serial"]): one for one in rows(tmp_path / "out")}
    assert "u001" not in found
    assert [str(one["status"]) for one in found.values()].count("quarantined") == 2
    for serial in ("u002", "u003"):
        row: Any = found[serial]
        assert row["reason"]
        assert row["reason_code"] == row["problems"][0]["code"]
        assert not row["results"]
        assert f"{serial}/rates.csv" in str(row["problems"])
        assert str(tmp_path) not in str(row)
    assert outcome.exit_status == 3
    assert outcome.counts == {"units": 7, "done": 5, "quarantined": 2, "PASS": 4, "FAIL": 1, "INCONCLUSIVE": 0}
    assert "in quarantine" in str(outcome)
    assert "<table" in outcome._repr_html_()


def test_a_fault_of_the_program_ends_its_unit_alone_and_leaves_a_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lot = folder_lot(tmp_path / "lot", 4)
    kind = type(procedure_of("rate_table"))
    before, one = kind.reduce, engine.preparing
    marked: dict[int, str] = {}

    def preparing(campaign: Any, *rest: Any, **more: Any) -> Any:
        found = yield from one(campaign, *rest, **more)
        marked[id(found.readings)] = campaign.file.item.serial
        return found

    def faulty(self: Any, plan: Any, readings: Any) -> Any:
        if marked.get(id(readings)) == "u002":
            raise KeyError("no such thing")
        return before(self, plan, readings)

    monkeypatch.setattr(block_module, "preparing", preparing)
    monkeypatch.setattr(kind, "reduce", faulty)
    monkeypatch.setattr(kind, "reduce_many", Procedure.reduce_many)
    outcome = ic.lot(lot, tmp_path / "out", workers=0)
    found = rows(tmp_path / "out")
    assert [one["status"] for one in found] == ["done", "done", "quarantined", "done"]
    assert found[2]["reason_code"] == "internal"
    assert "KeyError" in (tmp_path / "out" / "logs" / "unit-00002.txt").read_text(encoding="utf-8")
    assert outcome.exit_status == 3


def test_resume_redoes_what_changed_alone(made: tuple[Path, Path], tmp_path: Path) -> None:
    lot, out = copied(made, tmp_path)
    again = ic.lot(lot, out, resume=True, workers=0)
    # A copy has other times of change: what is known by size and time alone is done again
    assert digests(out) == digests(made[1])
    again = ic.lot(lot, out, resume=True, workers=0)
    assert (again.redone, again.kept) == (0, 12)
    assert digests(out) == digests(made[1])
    (lot / "u003" / "rates.csv").write_text(csv(rates(3, 0.03)), encoding="utf-8", newline="\n")
    (lot / "u007" / "rates.csv").unlink()
    (lot / "u007" / "rates.csv").mkdir()
    (lot / "u999").mkdir()
    (lot / "u999" / "rates.csv").write_text(csv(rates(999)), encoding="utf-8", newline="\n")
    again = ic.lot(lot, out, resume=True, workers=0)
    assert (again.redone, again.kept) == (3, 10)
    found = rows(out)
    assert [one["serial"] for one in found if one["status"] == "quarantined"] == ["u007"]
    assert found[3]["verdict"] == "FAIL"
    assert [one["number"] for one in found] == list(range(13))
    shutil.rmtree(lot / "u007" / "rates.csv")
    shutil.copyfile(made[0] / "u007" / "rates.csv", lot / "u007" / "rates.csv")
    shutil.rmtree(lot / "u999")
    shutil.copyfile(made[0] / "u003" / "rates.csv", lot / "u003" / "rates.csv")
    again = ic.lot(lot, out, resume=True, workers=0)
    assert (again.redone, again.kept) == (2, 10)
    assert digests(out) == digests(made[1])


def test_recordings_that_were_put_away_throw_nothing_away(tmp_path: Path) -> None:
    lot, out = shared_lot(tmp_path / "lot", 4), tmp_path / "out"
    ic.lot(lot, out, workers=0)
    before, recordings = digests(out), lot.with_name("rates.parquet")
    recordings.rename(tmp_path / "away.parquet")
    with pytest.raises(DataError) as error:
        ic.lot(lot, out, resume=True, workers=0)
    assert error.value.problems[0].code == "missing_file"
    assert digests(out) == before
    (tmp_path / "away.parquet").rename(recordings)
    assert ic.lot(lot, out, resume=True, workers=0).kept == 4


def test_resume_redoes_all_where_the_campaign_or_the_version_changed(
    made: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lot = folder_lot(tmp_path / "lot", 4)
    out = tmp_path / "out"
    ic.lot(lot, out, workers=0)
    text = CAMPAIGN.replace('limit = "1 %"', 'limit = "3 %"')
    (lot / "campaign.toml").write_text(text, encoding="utf-8", newline="\n")
    again = ic.lot(lot, out, resume=True, workers=0)
    assert (again.redone, again.kept) == (4, 0)
    monkeypatch.setattr("inertialcal.lots.lot.code_digest", lambda: "another")
    again = ic.lot(lot, out, resume=True, workers=0)
    assert (again.redone, again.kept) == (4, 0)


def test_a_column_of_the_table_alone_redoes_nothing(tmp_path: Path) -> None:
    lot = shared_lot(tmp_path / "lot", 4)
    ic.lot(lot, tmp_path / "out", workers=0)
    table = lot.parent / "units.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("S1", "S9"), encoding="utf-8")
    again = ic.lot(lot, tmp_path / "out", resume=True, workers=0)
    assert (again.redone, again.kept) == (0, 4)
    assert rows(tmp_path / "out")[1]["station"] == "S9"


def test_a_second_process_on_one_lot_is_refused(made: tuple[Path, Path], tmp_path: Path) -> None:
    lot, out = copied(made, tmp_path)
    held = Ledger(out)
    with pytest.raises(StoreError) as error:
        ic.lot(lot, out, resume=True, workers=0)
    assert error.value.problems[0].code == "locked"
    held.close()
    ic.lot(lot, out, resume=True, workers=0)


def test_folders_that_are_not_this_lot_are_refused(tmp_path: Path) -> None:
    lot = folder_lot(tmp_path / "lot", 2)
    full = tmp_path / "full"
    full.mkdir()
    (full / "mine.txt").write_text("mine", encoding="utf-8")
    for resume in (False, True):
        with pytest.raises(UsageError) as error:
            ic.lot(lot, full, resume=resume)
        assert error.value.problems[0].code == "not_empty"
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises((StoreError, UsageError)):
        ic.lot(lot, tmp_path / "file")
    with pytest.raises(UsageError):
        ic.lot(lot, tmp_path / "out", workers=-1)


def test_a_part_holds_a_fixed_number_of_units(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publish, "PART", 5)
    monkeypatch.setattr(publish, "GROUP", 2)
    monkeypatch.setattr(publish, "MANY", 1)  # figures: what is in memory at a time
    ic.lot(folder_lot(tmp_path / "lot", 12), tmp_path / "out", workers=0)
    content = json.loads((tmp_path / "out" / "lot.json").read_text(encoding="utf-8"))
    assert [one["units"] for one in content["parts"]] == [5, 5, 2]
    assert [one["number"] for one in rows(tmp_path / "out")] == list(range(12))
    part = pq.read_metadata(tmp_path / "out" / content["parts"][0]["file"])
    assert [part.row_group(at).num_rows for at in range(part.num_row_groups)] == [2, 2, 1]


@pytest.mark.parametrize("what", ["statistics", "report"])
def test_rows_of_units_stand_whatever_becomes_of_the_rest(
    made: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    lot, (_, out) = made[0], copied(made, tmp_path)

    def broken(*given: object) -> None:
        raise ZeroDivisionError("of a test")

    with monkeypatch.context() as patch:
        patch.setattr(*((publish, "study") if what == "statistics" else (page, "lot_page")), broken)
        outcome = ic.lot(lot, out, resume=True, workers=0)
    assert (outcome.exit_status, outcome.redone, outcome.counts["done"]) == (3, 0, 12)
    assert "ZeroDivisionError" in (out / "logs" / f"{what}.txt").read_text(encoding="utf-8")
    content = json.loads((out / "lot.json").read_text(encoding="utf-8"))
    assert [one["code"] for one in content["remarks"]] == [f"no_{what}"]
    assert (content["statistics"] is None) is (what == "statistics")
    assert not (out / "report.html").exists()
    assert "internal error (ZeroDivisionError: of a test)" in outcome.remarks[0].what
    assert rows(out) == rows(made[1])
    assert ic.lot(lot, out, resume=True, workers=0).exit_status == 1
    assert digests(out) == digests(made[1])


def test_what_is_read_back_is_what_was_written(made: tuple[Path, Path], tmp_path: Path) -> None:
    lot, out = copied(made, tmp_path)
    outcome = ic.lot(lot, out, resume=True, workers=0)
    (out / "units" / "part-00000.parquet").unlink()
    with pytest.raises(DataError):
        outcome.to_frame()


def ended(*words: str) -> int:
    with pytest.raises(SystemExit) as status:
        main([*words])
    return int(status.value.code or 0)


def test_the_command(made: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lot = str(made[0])
    out = str(tmp_path / "out")
    assert ended("lot", lot, "-o", out, "--workers", "0") == 1
    said = capsys.readouterr()
    assert "12 reduced now, 0 kept" in said.out
    assert "12/12" in said.err
    assert ended("lot", lot, "-o", out, "--workers", "0", "--resume", "--json") == 1
    content = json.loads(capsys.readouterr().out)
    assert (content["exit"], content["redone"], content["counts"]["FAIL"]) == (1, 0, 2)
    assert ended("lot", lot) == 2
    assert "after -o" in capsys.readouterr().err
    assert ended("lot", lot, "-o", out) == 2
    assert "resume the lot" in capsys.readouterr().err


def test_new_processes_do_what_doubles_do(
    made: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where doubling is not safe they are started one by one, as blocks come: all of them have to be ended."""
    monkeypatch.setattr(workers, "can_fork", lambda: False)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    ic.lot(made[0], tmp_path / "out", workers=2)
    assert digests(tmp_path / "out") == digests(made[1])
    assert not multiprocessing.active_children()
