"""From a folder of archive records to a report: info, flip --campaign, run; and what stands in the campaign file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.campaign.calls.call import Reduced
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.campaign.start.starter import start
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, PlanError, UsageError
from inertialcal.core.results import Row
from inertialcal.core.show.rows import case_name
from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import build
from pad_pairs_made import BENCH, flip_records

MEANS = """\
axis,orientation,mean [ug],half_width_95 [ug]
y,forward,973.77,0.2
y,reverse,984.33,0.2
z,forward,-1249.69,
z,reverse,-1258.82,
"""
ROUNDING = 1e-4  # ug, of 1000
POSITIONS = {"forward": "0 deg", "reverse": "180 deg"}


def call(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return int(str(left.value.code)), out, err


def campaign_of(found: Reduced, folder: Path) -> Path:
    return found.write_campaign(folder).parent


def same_figures(found: Reduced, folder: Path) -> None:
    """`run` must give what the files alone gave, to the last bit; its model is its own."""
    rows = [row for row in run(folder, write=False).results["results"] if row["test"] != "model"]
    assert json.loads(json.dumps(rows)) == [json.loads(json.dumps(row.to_dict())) for row in found.rows]


def test_three_commands_lead_from_records_to_a_report(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = flip_records(tmp_path / "my records")
    status, out, _ = call(capsys, "info", folder)
    assert status == 0
    assert out.endswith(f"next: inertialcal flip '{folder}'\n")
    status, out, _ = call(capsys, "flip", folder, "--axis", "y", "--campaign", folder)  # x of the file
    assert status == 0
    assert out.endswith(f"written: {folder}/campaign.toml\n")
    assert call(capsys, "run", folder)[0] == 0
    page = (folder / "out/report.html").read_text(encoding="utf-8")
    assert "2014_10_22_09_36_36.000" in page
    status, _, err = call(capsys, "flip", folder, "--campaign", folder)
    assert (status, "campaign.toml exists" in err) == (3, True)  # never written over
    assert call(capsys, "flip", folder, "--axis", "y", "--quiet") == (0, "", "")  # out/ is none of the records
    assert call(capsys, "info", folder)[1].endswith(f"next: inertialcal run '{folder}'\n")


def test_the_campaign_gives_the_figures_of_the_files(tmp_path: Path) -> None:
    found = ic.flip(flip_records(tmp_path))
    assert found.unit == "ug"  # the records are in g
    folder = campaign_of(found, tmp_path)
    same_figures(found, folder)
    (entry,) = load(folder).file.recordings.values()
    assert (entry.file, entry.frame, len(vars(entry)["positions"])) == (".", "sensor", 4)


def test_options_of_the_command_stand_in_the_campaign(tmp_path: Path) -> None:
    text = csv_text(build(BENCH, 4).recordings[FILE]).replace("unix_s,x,", "unix_s,first,", 1)
    (tmp_path / "head.csv").write_text(text, encoding="utf-8")
    windows = ["1996/051/12:03:00..1996-02-20T12:09:00Z=0 deg", "000/12:11..000/12:19=180 deg"]
    found = ic.flip(
        tmp_path / "head.csv", units={"first": "g", "y": "g", "z": "g"}, columns={"x": "first", "y": "y", "z": "z"},
        windows=windows, mission_start="1996-02-20T00:00:00Z", settle="20 s", corrected=True,
    )  # fmt: skip
    folder = campaign_of(found, tmp_path)
    same_figures(found, folder)
    assert load(folder).file.tests[0].plan == {"settle": "20 s", "corrected": True}


def test_a_table_of_means_becomes_a_campaign(tmp_path: Path) -> None:
    (tmp_path / "means.csv").write_text(MEANS, encoding="utf-8")
    found = ic.flip(tmp_path / "means.csv", positions=POSITIONS)
    same_figures(found, campaign_of(found, tmp_path))


def test_several_records_are_several_flips_of_one_campaign(tmp_path: Path) -> None:
    paths = []
    for seed in (4, 5):
        paths.append(tmp_path / f"head{seed}.csv")
        paths[-1].write_text(csv_text(build(BENCH, seed).recordings[FILE]), encoding="utf-8")
    found = ic.flip(paths, units={"g": "g"})
    assert found.result.readings.flips == ("1", "2")
    same_figures(found, campaign_of(found, tmp_path / "campaign"))


def test_a_part_of_the_files_becomes_a_campaign(tmp_path: Path) -> None:
    found = ic.flip(flip_records(tmp_path / "records"), start="2014-10-22T09:40:00Z")
    same_figures(found, campaign_of(found, tmp_path / "campaign"))


def test_a_figure_of_the_flip(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = flip_records(tmp_path / "records")
    status, out, _ = call(capsys, "flip", folder, "--axis", "y", "-o", tmp_path / "flip.svg", "--json")
    assert (status, json.loads(out)["written"][0].startswith(str(tmp_path / "flip.svg"))) == (0, True)
    assert "reading [ug]" in (tmp_path / "flip.svg").read_text(encoding="utf-8")
    status, _, err = call(capsys, "flip", folder, "-o", tmp_path / "flip.doc")
    assert (status, ".png, .svg, .pdf" in err) == (2, True)


def test_init_fills_in_what_the_records_show(tmp_path: Path) -> None:
    folder = flip_records(tmp_path)
    path, marked, _ = start(folder)
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    assert [lines[number - 1].partition(" ")[0] for number in marked] == ["maker", "part", "serial", "plan"]
    path.write_text(text.replace("# FILL IN", ""), encoding="utf-8")
    rows = {(r["quantity"], r["axis"]): r for r in run(folder, write=False).results["results"] if not case_name(r)}
    expected: dict[tuple[str, str], Row] = {(r.quantity, r.axis): r for r in ic.flip(folder).rows if r.case.plain}
    assert rows["bias", "z"]["value"] * 1e6 == pytest.approx(expected["bias", "z"].value, abs=ROUNDING)  # g


def test_init_takes_the_sensors_of_a_folder_one_by_one(tmp_path: Path) -> None:
    for sensor in ("121f03", "121f05"):
        flip_records(tmp_path / sensor, sensor=sensor)
    (tmp_path / "means.csv").write_text(MEANS, encoding="utf-8")
    path, marked, remarks = start(tmp_path)
    assert not [one for one in remarks if one.code == "not_read"]
    text = path.read_text(encoding="utf-8")
    assert [line for line in text.splitlines() if line.startswith("file = ")] == [
        'file = "121f03"', 'file = "121f05"', 'file = "means.csv"'
    ]  # fmt: skip
    assert 'angles = { forward = "? deg", reverse = "? deg" }  # FILL IN' in text
    assert len(marked) == 3 + 3 + 1  # item, plans, angles


def test_init_of_a_folder_of_several_sensors_says_so(tmp_path: Path) -> None:
    for sensor in ("121f03", "121f05"):
        flip_records(tmp_path, sensor=sensor)
    with pytest.raises(PlanError, match="No recording or table"):
        start(tmp_path)


def test_a_record_without_a_turn_is_one_of_the_environment(tmp_path: Path) -> None:
    folder = flip_records(tmp_path, files=1)
    data = next(folder.glob("*.121f03"))
    whole = data.read_bytes()
    stop = "2014_10_22_09_38_16.000"
    short = data.with_name(f"{data.name.partition('-2014')[0]}-{stop}.121f03")
    short.write_bytes(whole[: 501 * 16])
    data.with_name(data.name + ".header").rename(short.with_name(short.name + ".header"))
    data.unlink()
    path, marked, remarks = start(folder)
    assert not remarks
    assert 'procedure = "microgravity"' in path.read_text(encoding="utf-8")
    assert len(marked) == 3  # maker, part and serial number


def test_a_frame_is_for_archive_records_alone(tmp_path: Path) -> None:
    found = ic.flip(flip_records(tmp_path))
    folder = campaign_of(found, tmp_path)
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('frame = "sensor"\n', ""), encoding="utf-8")
    data = run(folder, write=False).results["results"]  # in the axes of the data: another y
    assert next(r["value"] for r in data if r["quantity"] == "bias") != found.rows[0].value
    (tmp_path / "means.csv").write_text(MEANS, encoding="utf-8")
    path.write_text(text.replace('file = "."', 'file = "means.csv"'), encoding="utf-8")
    with pytest.raises((DataError, UsageError), match="--frame given"):
        run(folder, write=False)


def test_a_folder_without_records_is_no_file(tmp_path: Path) -> None:
    folder = campaign_of(ic.flip(flip_records(tmp_path)), tmp_path)
    (folder / "empty").mkdir()
    path = folder / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('file = "."', 'file = "empty"'), encoding="utf-8")
    with pytest.raises(PlanError, match="file 'empty' does not exist"):
        load(folder)
