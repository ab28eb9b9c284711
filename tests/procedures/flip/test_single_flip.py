"""A flip without a campaign file: the published table, recordings whose windows are found or given, real recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import inertialcal as ic
from inertialcal.campaign.calls.call import Reduced
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.results import Row
from inertialcal.rigs.sams_tsh.campaign import FILE, instant, windows
from inertialcal.rigs.sams_tsh.rig import Bench, build

# NASA TM-106980, Table 3, time 2 [ug], and Tables 4 to 6 of it.
TABLE_3 = """\
axis,orientation,mean [ug]
x,forward,-1264.74
x,reverse,-1264.98
y,forward,973.77
y,reverse,984.33
z,forward,-1249.69
z,reverse,-1258.82
"""
POSITIONS = {"forward": "0 deg", "reverse": "180 deg"}
FLIP_2 = {
    ("ambient_acceleration", "y"): -5.282, ("ambient_acceleration", "z"): 4.568, ("control_error", "x"): 0.116,
    ("bias", "y"): 979.049, ("bias", "z"): -1254.253,
}  # fmt: skip
ROUNDING = 0.005  # ug
BENCH = replace(Bench(), rate=5.0, saved="g", said="g")


def table(folder: Path, text: str = TABLE_3) -> Path:
    path = folder / "table03.csv"
    path.write_text(text, encoding="utf-8")
    return path


def by_name(found: Reduced) -> dict[tuple[str, str], Row]:
    return {(row.quantity, row.axis): row for row in found.rows if str(row.case) == ""}


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("record") / "head.csv"
    path.write_text(csv_text(build(BENCH, 4).recordings[FILE]), encoding="utf-8")
    return path


def test_the_published_figures_come_out_of_the_table(tmp_path: Path) -> None:
    found = ic.flip(table(tmp_path), positions=POSITIONS)
    rows = by_name(found)
    for name, printed in FLIP_2.items():
        assert rows[name].value == pytest.approx(printed, abs=ROUNDING)
        assert (rows[name].unit, rows[name].u) == ("ug", None)
    assert "no_noise_model" in {remark.code for remark in found.remarks}
    assert found.to_frame()["quantity"].tolist()[0] == "ambient_acceleration"
    assert "flip" in str(found)


def test_a_corrected_flip_gives_what_the_model_leaves_of_the_bias(tmp_path: Path) -> None:
    rows = by_name(ic.flip(table(tmp_path), positions=POSITIONS, corrected=True))
    assert rows["model_bias_error", "y"].value == pytest.approx(FLIP_2["bias", "y"], abs=ROUNDING)
    assert ("bias", "y") not in rows


@pytest.mark.parametrize(
    ("text", "said", "words"),
    [
        (TABLE_3, {}, "position 'forward' has no angle"),
        (TABLE_3.replace(" [ug]", ""), {"positions": POSITIONS}, "unit of 'mean' not given"),
        (TABLE_3, {"positions": POSITIONS, "axis": "w"}, "'w'"),
        (TABLE_3.replace("mean [ug]", "value [ug]"), {"positions": POSITIONS}, "cannot tell which column is the mean"),
    ],
)
def test_what_a_table_does_not_say_is_asked_for(tmp_path: Path, text: str, said: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        ic.flip(table(tmp_path, text), **said)


def test_a_row_of_no_axis_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="axis 'q'"):
        ic.flip(table(tmp_path, TABLE_3.replace("z,", "q,")), positions=POSITIONS)


def test_windows_found_and_given_agree_within_the_uncertainty(record: Path) -> None:
    found = ic.flip(record, units={"g": "g"})
    stated = [f"{instant(a + BENCH.settle)}..{instant(b)}={angle:g} deg" for a, b, angle in windows(BENCH)]
    given = ic.flip(record, units={"g": "g"}, windows=stated)
    assert "turns_found" in {remark.code for remark in found.remarks}
    assert "turns_found" not in {remark.code for remark in given.remarks}
    one, other = by_name(found), by_name(given)
    compared = [name for name, row in other.items() if row.u is not None]
    assert len(compared) == 8
    for name in compared:
        value, reference, u, other_u = one[name].value, other[name].value, one[name].u, other[name].u
        assert value is not None
        assert reference is not None
        assert u is not None
        assert other_u is not None
        assert abs(value - reference) < other_u
        assert 0.5 < u / other_u < 2.0


def test_settling_and_a_part_of_the_record(record: Path) -> None:
    part = ic.flip(record, units={"g": "g"}, settle="5 s", stop="1996-02-20T12:38:00Z")
    assert "settling" in {remark.code for remark in part.remarks}
    assert len(part.result.readings) == 2  # of the first turn


def test_several_recordings_are_several_flips(record: Path, tmp_path: Path) -> None:
    second = tmp_path / "second.csv"
    second.write_text(csv_text(build(BENCH, 5).recordings[FILE]), encoding="utf-8")
    found = ic.flip([record, second], units={"g": "g"})
    assert found.result.readings.flips == ("1", "2")
    assert {str(row.case) for row in found.rows} >= {"", "flip 1", "flip 2"}
    assert len(found.inputs) == 2


def test_a_real_record_that_was_never_turned_is_refused_in_one_message(shared: Path) -> None:
    files = [path for path in (shared / "data" / "pims_pad").glob("2014*") if path.suffix != ".header"]
    with pytest.raises(UsageError, match=r"no turn of the head found in 59 s") as caught:
        ic.flip(files[0])
    assert len(caught.value.problems) == 1
    assert "windows=" in caught.value.problems[0].do


def test_a_real_record_with_windows_inside_gives_no_false_certainty(shared: Path) -> None:
    """59 s hold two windows, but not the noise between them: values stay, without an uncertainty or a warned one."""
    files = [path for path in (shared / "data" / "pims_pad").glob("2014*") if path.suffix != ".header"]
    said = ["2014/295/09:36:40..2014/295/09:37:00=0 deg", "2014/295/09:37:05..2014/295/09:37:30=180 deg"]
    found = ic.flip(files[0], windows=said)
    assert {"short_record"} <= {remark.code for remark in found.remarks}


def test_a_file_that_is_given_twice_does_not_count_twice(tmp_path: Path, record: Path) -> None:
    with pytest.raises(UsageError, match="given twice"):
        ic.flip([record, record.parent / "." / record.name])
    with pytest.raises(DataError, match=r"reduced means .* and recordings in one test"):
        ic.flip([table(tmp_path), record], positions=POSITIONS, units={"g": "g"})
