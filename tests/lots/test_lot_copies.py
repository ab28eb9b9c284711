"""A recording that two units have in common: of what it was tested, nobody knows."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from small_lot import CAMPAIGN, folder_lot, rows

import inertialcal as ic

OF_FOLDERS = """schema = 1
id = "line"
units = "units.csv"
folder = "{folder}"
"""
COLUMNS = """[options]
"recordings.still.channels.x.column" = "column"
"""
STILL = (
    CAMPAIGN[: CAMPAIGN.index("[recordings")]
    + """[recordings.still]
sensor = "gyro"
file = "still.csv"
clock = { sample_rate = "10 Hz" }
channels = { x = { column = "x", unit = "deg/s" } }
[recordings.log]
sensor = "gyro"
file = "log.csv"
clock = { sample_rate = "10 Hz" }
channels = { temperature = { column = "probe", unit = "degC" } }
[[tests]]
id = "noise"
procedure = "static_noise"
recordings = ["still"]
"""
)


def codes(out: Path) -> list[str]:
    return [str(one["reason_code"]) for one in rows(out)]


def lot_of(root: Path, table: str, more: str = "") -> Path:
    """Write LOT.toml and its table, of the columns serial, folder and column."""
    (root / "LOT.toml").write_text(OF_FOLDERS + more, encoding="utf-8", newline="\n")
    (root / "units.csv").write_text(f"serial,folder,column\n{table}", encoding="utf-8", newline="\n")
    return root


def still_lot(root: Path, seeds: dict[str, int]) -> Path:
    """Write a lot of gyros at rest, each beside the log of the one chamber; alike where their seeds are."""
    root.mkdir()
    (root / "campaign.toml").write_text(STILL, encoding="utf-8", newline="\n")
    for unit, seed in seeds.items():
        cells = np.random.default_rng(seed).standard_normal((2000, 2)) * 0.01
        (root / unit).mkdir()
        text = "x,y\n" + "".join(f"{x:.6f},{y:.6f}\n" for x, y in cells)
        (root / unit / "still.csv").write_text(text, encoding="utf-8", newline="\n")
        (root / unit / "log.csv").write_text("probe\n" + "21.5\n" * 2000, encoding="utf-8", newline="\n")
    return root


def test_units_with_one_recording_go_to_quarantine_until_they_are_tested_again(tmp_path: Path) -> None:
    lot, out = folder_lot(tmp_path / "lot", 4), tmp_path / "out"
    own = (lot / "u002" / "rates.csv").read_text(encoding="utf-8")
    shutil.copy(lot / "u001" / "rates.csv", lot / "u002")
    for one in lot.glob("u*"):
        (one / "sections.csv").write_text("the same for all", encoding="utf-8")
    outcome = ic.lot(lot, out, workers=0, report=False)
    (said,) = [one for one in outcome.remarks if one.code == "same_recording"]
    assert "u001 and u002" in said.what
    assert (said.count, outcome.exit_status, outcome.counts["quarantined"], outcome.counts["PASS"]) == (1, 3, 2, 2)
    assert outcome.content["quarantined"] == {"same_recording": 2}
    found = rows(out)
    assert [one["reason_code"] for one in found] == ["", "same_recording", "same_recording", ""]
    assert [one["number"] for one in found] == [0, 1, 2, 3]
    assert "u001/rates.csv: it is that of u002" in str(found[1]["reason"])
    assert "that of u001" in str(found[2]["reason"])
    assert not found[1]["results"]
    assert not found[1]["verdict"]
    (lot / "u002" / "rates.csv").write_text(own, encoding="utf-8", newline="\n")
    again = ic.lot(lot, out, resume=True, workers=0, report=False)
    assert (again.redone, again.counts["PASS"], again.exit_status) == (1, 4, 0)
    assert not [one for one in again.remarks if one.code == "same_recording"]


def test_of_two_tests_of_a_unit_with_one_recording_the_first_holds(tmp_path: Path) -> None:
    lot = lot_of(folder_lot(tmp_path / "lot", 2), "A,u000,\nB,u001,\nA,u002,\n")
    shutil.copytree(lot / "u000", lot / "u002")
    outcome = ic.lot(lot, tmp_path / "out", workers=0, report=False)
    assert codes(tmp_path / "out") == ["", "", "same_recording"]
    assert "two tests of A" in outcome.remarks[0].what


def test_a_file_that_the_table_gives_to_two_units_is_no_copy(tmp_path: Path) -> None:
    lot = lot_of(folder_lot(tmp_path / "lot", 1), "A,u000,\nB,u000,\n")
    ic.lot(lot, tmp_path / "out", workers=0, report=False)
    assert codes(tmp_path / "out") == ["", ""]


@pytest.mark.parametrize(
    ("seeds", "more", "expected"),
    [
        ({"u1": 1, "u2": 2}, "", ["", ""]),  # the log of the chamber alone is alike
        ({"u1": 1, "u2": 1}, "", ["same_recording"] * 2),
        ({"u1": 1, "u2": 1}, COLUMNS, ["", ""]),  # one file of both, in the folder of each
    ],
)
def test_readings_of_the_unit_alone_count(
    tmp_path: Path, seeds: dict[str, int], more: str, expected: list[str]
) -> None:
    lot = lot_of(still_lot(tmp_path / "lot", seeds), "A,u1,x\nB,u2,y\n", more)
    ic.lot(lot, tmp_path / "out", workers=0, report=False)
    assert codes(tmp_path / "out") == expected


def test_two_files_of_one_unit_that_are_alike_are_no_copy_of_another_unit(tmp_path: Path) -> None:
    lot = still_lot(tmp_path / "lot", {"u1": 1, "u2": 2})
    head, tests = STILL.split("[recordings.log]")
    again = head[head.index("[recordings.still]") :].replace("still", "again")
    text = f"{head}{again}[recordings.log]{tests}"
    text += '[[tests]]\nid = "more"\nprocedure = "static_noise"\nuse = "report_only"\nrecordings = ["again"]\n'
    (lot / "campaign.toml").write_text(text, encoding="utf-8", newline="\n")
    for unit in ("u1", "u2"):
        shutil.copy(lot / unit / "still.csv", lot / unit / "again.csv")
    ic.lot(lot, tmp_path / "out", workers=0, report=False)
    assert codes(tmp_path / "out") == ["", ""]
