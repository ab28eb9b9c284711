"""What a person may say or do wrong to `positions`: each has one clear message and the right exit status."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.twins.twin import csv_text
from inertialcal.core.show.rows import case_name
from inertialcal.rigs.hand_held.rig import Bench, build
from positions_truths import protocol
from typed_commands import call, call_json

ONCE = Bench(variant="ferraris", rounds=1, records=1, dwell=2.0, first=2.0)
SI = ("--unit", "acc=m/s2", "--unit", "gyro=rad/s")
G = ("--gravity", "9.807 m/s2")
Sections = dict[str, Any]


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of six faces and three turns."""
    path = tmp_path_factory.mktemp("mistakes") / "hand.csv"
    (recording,) = build(ONCE, 1).recordings.values()
    path.write_text(csv_text(recording), encoding="utf-8")
    return path


def exchanged(one: str, other: str) -> Sections:
    sections: Sections = dict(protocol(ONCE))
    return sections | {one: sections[other], other: sections[one]}


def without(*labels: str) -> Sections:
    return {label: ends for label, ends in protocol(ONCE).items() if label not in labels}


def said(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str]:
    left, _, err = call(capsys, "positions", *words)
    return left, " ".join(err.split())


@pytest.mark.parametrize(
    ("sections", "text"),
    [
        ({}, "no section in the file"),
        (exchanged("x_p", "x_a"), "2 of 6 positions are misnamed"),
        (exchanged("x_a", "y_p"), "is named y+ but reads x-"),
        (without("x_p", "x_a", "y_p", "y_a", "z_p", "z_a"), "no section is a position"),
        (without("x_a") | {"x_a": {"start": 100, "end": 10**6}}, "the protocol belongs to another recording"),
        (without("x_a") | {"x_a": {"start": 10, "end": 60}}, "overlap"),
        (without("x_a") | {"": {"start": 10, "end": 60}}, "section '' is no position"),
        (without("x_a") | {"x_a": {"start": 60, "end": 10}}, "Give the end after the start"),
    ],
)
def test_wrong_sections_are_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path, sections: Sections, text: str
) -> None:
    (tmp_path / "p.json").write_text(json.dumps(sections), encoding="utf-8")
    status, message = said(capsys, str(record), *SI, *G, "--sections", str(tmp_path / "p.json"))
    assert (status, text in message) == (3, True), message


def test_signs_that_are_all_turned_are_told_as_such(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path
) -> None:
    turned = {label[:2] + ("a" if label[2] == "p" else "p"): ends for label, ends in protocol(ONCE).items()
              if not label.endswith("rot")}  # fmt: skip
    (tmp_path / "p.json").write_text(json.dumps(turned), encoding="utf-8")
    status, message = said(capsys, str(record), *SI, *G, "--sections", str(tmp_path / "p.json"))
    assert status == 3
    assert "All read the opposite: change the signs of the accelerometers" in message


def test_a_face_that_is_missing_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(without("y_p")), encoding="utf-8")
    content = call_json(capsys, "positions", str(record), *SI, *G, "--sections", str(tmp_path / "p.json"))
    remarks = {one["code"]: one["what"] for one in content["remarks"]}
    assert "5 of the six faces, y+ missing" in remarks["face_missing"]
    assert not [row for row in content["results"] if case_name(row) == "as_published"]


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (("--latitude", "500 deg"), 3, "latitude of 500 deg: need -90 to 90 deg"),
        (("--gravity", "-9.8 m/s2"), 3, "gravity of -9.8 m/s2: need more than 0"),
        (("--gravity", "0 m/s2"), 3, "need more than 0"),
        (("--shortest", "-1 s"), 3, "shortest rest of -1 s"),
        (("--shortest", "60 s"), 3, "never lies still for 60 s"),
        (("--column", "acc_x=ax"), 2, "no channel 'ax'"),
        (("--unit", "acc=mss"), 2, "'acc' stands twice"),
        (("--orientations", "up.csv"), 2, "no file 'up.csv'"),
    ],
)
def test_wrong_words_are_told(
    capsys: pytest.CaptureFixture[str], record: Path, words: tuple[str, ...], status: int, text: str
) -> None:
    left, message = said(capsys, str(record), *SI, *words)
    assert (left, text in message) == (status, True), message


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("empty", "the file is empty"),
        ("header", "a header, but no rows"),
        ("one", "one.csv: 1 sample(s)"),
        ("no_value", "literal 'NaN' in required column 'acc_z'"),
        ("back", "back.csv:302: time goes back"),
    ],
)
def test_files_that_hold_nothing_are_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, record: Path, change: str, text: str
) -> None:
    lines = record.read_text(encoding="utf-8").splitlines()
    made = {
        "empty": [],
        "header": lines[:1],
        "one": lines[:2],
        "no_value": lines[:1] + [",".join([*one.split(",")[:3], "nan", *one.split(",")[4:]]) for one in lines[1:]],
        "back": lines[:301] + lines[101:],
    }
    path = tmp_path / f"{change}.csv"
    path.write_text("\n".join(made[change]), encoding="utf-8")
    status, message = said(capsys, str(path), *SI, *G)
    assert (status, text in message) == (3, True), message


def test_channels_named_for_one_sensor_leave_the_other_as_it_is(
    capsys: pytest.CaptureFixture[str], record: Path
) -> None:
    named = [word for axis in "xyz" for word in ("--column", f"acc_{axis}=acc_{axis}")]
    content = call_json(capsys, "positions", str(record), *SI, *G, *named)
    assert content["columns"]["gyro_z"] == "gyro_z"
    alone = call_json(capsys, "positions", f"acc={record}", "--unit", "acc=m/s2", *G)
    assert set(alone["columns"]) == {"acc_x", "acc_y", "acc_z"}


def test_annotated_session_of_imucal_by_the_closed_form(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    folder = shared / "data" / "imucal_ferraris"
    content = call_json(
        capsys, "positions", str(folder / "annotated_session.csv"), "--sample-rate", "204.8", "--unit", "acc=count",
        "--unit", "gyro=count", "--sections", "part", "--turn", "-360 deg", "--gravity", "9.81 m/s2",
    )  # fmt: skip
    expected = json.loads((folder / "expected_snapshot_example_cal.json").read_text(encoding="utf-8"))
    theirs_per = {"count/(rad/s)": np.pi / 180.0, "count/g": 1.0 / 9.80665}  # theirs is per deg/s, and per m/s2
    names = {
        ("accelerometer", "scale_factor"): "K_a", ("accelerometer", "direction_cosine"): "R_a",
        ("accelerometer", "bias"): "b_a", ("gyro", "scale_factor"): "K_g", ("gyro", "direction_cosine"): "R_g",
        ("gyro", "bias"): "b_g", ("gyro", "g_sensitivity"): "K_ga",
    }  # fmt: skip
    for (sensor, quantity), name in names.items():
        rows = [
            row["value"] * theirs_per.get(row["unit"], 1.0)
            for row in content["results"]
            if (row["sensor"], row["quantity"], case_name(row)) == (sensor, quantity, "as_published")
        ]
        theirs = np.array(expected[name])
        wanted = np.diag(theirs) if quantity == "scale_factor" else theirs.ravel()
        knock = name in ("K_g", "R_g")  # two samples of the turn about y are left out, and bridged by a straight line
        assert rows == pytest.approx(wanted, rel=1e-6, abs=3e-4 * np.max(np.abs(wanted)) if knock else 0.0), name


def test_orientations_beside_a_table_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """They were passed over in silence: the result was that of unknown orientations."""
    rows = np.vstack([np.eye(3), -np.eye(3)]) * 9.81 + [0.1, 0.0, -0.1]
    path = tmp_path / "faces.csv"
    np.savetxt(path, rows, delimiter=",", header="acc_x,acc_y,acc_z", comments="")
    status, message = said(capsys, str(path), "--unit", "acc=m/s2", *G, "--orientations", "x+,y+,z+,x-,y-,z-")
    assert status == 2
    assert "in a column: position, or x, y and z" in message
