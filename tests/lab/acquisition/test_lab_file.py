"""LAB.toml: all that is wrong at once, each with its line and what to do."""

from __future__ import annotations

from pathlib import Path

import pytest
from lab_devices import REHEARSAL, lab_folder

from inertialcal.core.errors import PlanError
from inertialcal.lab.acquisition.lab_file import load_lab

TABLE = """schema = 1

[instruments.table]
link = "visa"
address = "GPIB0::1::INSTR"
dialect = "acutrol"
parameters = { axis = "1" }
limits = { rate = ["-100 deg/s", "100 deg/s"] }

[[steps]]
set = { "table.rate" = "0.5 rad/s" }
hold = "1 min"
"""

WRONG: list[tuple[str, str, str, int, str]] = [  # text, instead of, what is said, line, code
    ("schema = 2", "schema = 1", "schema", 1, "wrong_value"),
    ('link = "vissa"', 'link = "visa"', "no link 'vissa'", 4, "unknown_name"),
    (
        'adress = "GPIB0::1::INSTR"',
        'address = "GPIB0::1::INSTR"',
        "unknown key instruments.table.adress",
        5,
        "unknown_key",
    ),
    ('baud = 9600\naddress = "a"', 'address = "GPIB0::1::INSTR"', "link visa takes no baud", 5, "unknown_key"),
    ("", 'address = "GPIB0::1::INSTR"', "link visa needs address", 3, "missing_key"),
    ('dialect = "acutroll"', 'dialect = "acutrol"', "no dialect 'acutroll'", 6, "unknown_name"),
    ('dialect = "none.toml"', 'dialect = "acutrol"', "dialect none.toml: no such file", 6, "missing_file"),
    ("", 'dialect = "acutrol"', "a dialect is missing", 3, "missing_key"),
    ("", 'parameters = { axis = "1" }', "needs the parameter axis", 3, "missing_key"),
    ('"100 deg/s", "-100 deg/s"', '"-100 deg/s", "100 deg/s"', "is not below", 8, "wrong_value"),
    ('"-100 deg", "100 deg/s"', '"-100 deg/s", "100 deg/s"', "not in a unit like deg/s", 8, "wrong_value"),
    ("rat = [", "rate = [", "nothing of that name can be set", 8, "unknown_key"),
    ('"table.rat"', '"table.rate"', "nothing is called table.rat", 11, "unknown_name"),
    ('"1e9 deg/s"', '"0.5 rad/s"', "beyond the limits, -100 to 100 deg/s", 11, "beyond_limits"),
    ('"0.5 m"', '"0.5 rad/s"', "not in a unit like deg/s", 11, "wrong_value"),
    ("hold = 60", 'hold = "1 min"', "is not a quantity", 12, "wrong_value"),
    ("", 'limits = { rate = ["-100 deg/s", "100 deg/s"] }\n', "no limits for table.rate", 10, "missing_key"),
]


@pytest.mark.parametrize(("text", "instead", "what", "line", "code"), WRONG, ids=[one[2] for one in WRONG])
def test_what_is_wrong_is_said_with_its_line(
    tmp_path: Path, text: str, instead: str, what: str, line: int, code: str
) -> None:
    assert instead in TABLE
    path = lab_folder(tmp_path, TABLE.replace(instead, text))
    with pytest.raises(PlanError) as refused:
        load_lab(path)
    found = refused.value.problems
    one = next(one for one in found if what in one.what)
    assert one.where == f"LAB.toml:{line}"
    assert code in (one.code, "missing_file")


def test_all_problems_are_said_at_once(tmp_path: Path) -> None:
    text = TABLE.replace('"GPIB0::1::INSTR"', '""').replace("axis", "axes").replace("-100 deg/s", "x")
    with pytest.raises(PlanError) as refused:
        load_lab(lab_folder(tmp_path, text))
    assert len(refused.value.problems) >= 3


def test_a_dialect_in_a_file_is_refused_with_its_own_line(tmp_path: Path) -> None:
    text = TABLE.replace('"acutrol"', '"mine.toml"')
    with pytest.raises(PlanError) as refused:
        load_lab(lab_folder(tmp_path, text, mine='title = "x"\nterminater = "\\r"\n'))
    assert refused.value.problems[0].where == "mine.toml:2"
    assert refused.value.problems[0].do == "Did you mean terminator?"


def test_what_it_says_is_read(tmp_path: Path) -> None:
    lab = load_lab(lab_folder(tmp_path, TABLE))
    assert lab.limits == {"table": {"rate": (-100.0, 100.0)}}
    (step,) = lab.steps
    (value,) = step.values
    assert value[:2] == ("table", "rate")
    assert value[2] == pytest.approx(28.6478897565)
    assert step.hold == 60.0
    assert lab.clock().speed == 1


def test_only_what_keeps_to_the_clock_can_be_faster_than_time(tmp_path: Path) -> None:
    text = TABLE.replace("schema = 1\n", "schema = 1\n[lab]\nspeed = 100\n")
    with pytest.raises(PlanError) as refused:
        load_lab(lab_folder(tmp_path, text))
    assert refused.value.problems[0].where == "LAB.toml:3"
    assert load_lab(lab_folder(tmp_path, REHEARSAL.format(over="tcp", faults=""))).clock().speed == 1000


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('rig = "npsat1"', "no rig 'none'"),
        ('recording = "x_run1"', "has no recording 'none'"),
        ('over = "tcp"', "should be 'serial', 'tcp' or 'udp'"),
        ("faults = []", "should be a valid tuple"),
    ],
)
def test_a_rig_that_is_none_is_refused(tmp_path: Path, text: str, what: str) -> None:
    key = text.partition(" ")[0]
    whole = REHEARSAL.format(over="tcp", faults="").replace(text, f'{key} = "none"')
    with pytest.raises(PlanError, match=r"LAB\.toml:[0-9]+") as refused:
        load_lab(lab_folder(tmp_path, whole))
    assert what in refused.value.problems[0].what


def test_no_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(PlanError) as refused:
        load_lab(tmp_path / "LAB.toml")
    assert refused.value.problems[0].code == "missing_file"
