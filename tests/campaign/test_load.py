"""campaign.toml: everything that is wrong, at once, each with its line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from inertialcal.campaign.file.example import build
from inertialcal.campaign.file.load import load
from inertialcal.core.errors import PlanError, Problem, UsageError

Write = Callable[..., Path]


def problems(folder: Path) -> list[Problem]:
    with pytest.raises(PlanError) as caught:
        load(folder)
    return list(caught.value.problems)


def test_a_good_campaign_is_read_in_si(campaign: Write) -> None:
    read = load(campaign())
    assert read.standards["rate_table.rate"].u == pytest.approx(5e-4)
    assert read.standards["rate_table.rate"].certificate == "C-1"
    assert read.file.sensors["suite"].unit == "deg/s"
    assert read.at("tests", 0, "plan", "axis") == "campaign.toml:22"


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('unit = "deg/s"\nrange', 'unti = "deg/s"\nrange', 11, "Did you mean unit?"),
        ('range = ["-10 deg/s"', 'rnage = ["-10 deg/s"', 12, "Did you mean range?"),
        ('plan = { axis = "x"', 'plan = { axes = "x"', 22, "Did you mean axis?"),
        ('unit = "deg/s"\nrange', 'unit = "furlong/s"\nrange', 11, "furlong"),
        ('kind = "gyro"', 'kind = "gyroscope"', 9, "'gyro', 'accelerometer' or 'other'"),
        ("schema = 2", "schema = 1", 1, "Set schema = 2"),
        ('u = "0.05 %"', 'u = "0.05"', None, ""),
        ('u = "0.05 %"', 'u = "0.05 deg"', 7, "deg"),
        ('u = "0.05 %"', 'v = "0.05 %"', 7, "unknown key"),
        ("[standards.rate_table]\nrate", "[standards.rate_table]\nrtae", 7, "rate_table.rate"),
        ('file = "one.csv"', 'file = "two.csv"', 16, "file 'two.csv' does not exist"),
        ('file = "one.csv"', 'file = "../one.csv"', 16, "lies outside the campaign folder"),
        ('file = "one.csv"', 'file = "/etc/passwd"', 16, "lies outside the campaign folder"),
        ('recordings = ["one"]', 'recordings = ["won"]', 21, "no recording 'won'"),
        ('procedure = "rate_table"', 'procedure = "ratetable"', 20, "no procedure 'ratetable'"),
        ('axis = "x"', 'axis = "q"', 22, "plan.axis = 'q'"),
        ('limit = "5 %"', 'limit = "5 lightyears"', 26, "lightyears"),
        ('abs(rate) >= 0.5 deg/s"', 'abs(rate) => 0.5"', 27, "is no comparison"),
        ("counts = [0, 4095]", "counts = [4095, 0]", 13, "the first must be the smaller"),
        ('sensor = "suite"', 'sensor = "sweet"', 15, "no sensor 'sweet'"),
        ('id = "small"', 'id = "../small"', 3, "campaign.id"),
        ('id = "R1"\n', 'id = "R1"\nof = "mean"\n', 25, "requirements.0.of"),
        ("zero_reference = true", 'zero_reference = "yes"', 22, "plan.zero_reference"),
        ("zero_reference = true", "zero_reference = true, scatter_ratio = 0.5", 22, "greater than 1"),
    ],
)
def test_each_fault_is_told_with_its_line(campaign: Write, old: str, new: str, line: int | None, words: str) -> None:
    folder = campaign((old, new))
    if line is None:  # "0.05" is a plain relative number: accepted
        assert load(folder).standards["rate_table.rate"].u == pytest.approx(0.05)
        return
    found = problems(folder)
    assert any(p.where == f"campaign.toml:{line}" and words in f"{p.what} {p.do}" for p in found), found


def test_all_faults_are_told_at_once(campaign: Write) -> None:
    found = problems(
        campaign(('kind = "gyro"', 'kind = "giro"'), ('id = "R1"', 'id = ""'), ('file = "one.csv"', "file = 3"))
    )
    assert [p.where for p in found] == ["campaign.toml:9", "campaign.toml:16", "campaign.toml:24"]


def test_duplicate_ids_are_told(campaign: Write) -> None:
    again = '[[tests]]\nid = "first"\nprocedure = "rate_table"\nrecordings = ["one"]\nplan = { axis = "x" }\n'
    found = problems(campaign(("[[requirements]]", again + "[[requirements]]")))
    assert found[0].code == "duplicate_id"
    assert found[0].where == "campaign.toml:24"


def test_the_name_of_the_model_is_no_name_of_a_test(campaign: Write) -> None:
    again = '[[tests]]\nid = "model"\nprocedure = "rate_table"\nrecordings = ["one"]\nplan = { axis = "x" }\n'
    found = problems(campaign(("[[requirements]]", again + "[[requirements]]")))
    assert any("results have the rows of the model of the sensor under this name" in one.what for one in found)


def test_a_duplicate_key_is_told_with_its_line(campaign: Write) -> None:
    found = problems(campaign(('unit = "deg/s"\nrange', 'unit = "deg/s"\nunit = "deg/s"\nrange')))
    assert found[0].code == "not_toml"
    assert found[0].where == "campaign.toml:12"


WINDOWS = 'windows = [["2010-04-28T15:00:00Z", "2010-04-28T16:00:00Z"]'


def test_windows_that_overlap_are_refused(campaign: Write) -> None:
    plan = 'recordings = ["one"]\n'
    overlap = plan + WINDOWS + ', ["2010-04-28T15:30:00Z", "2010-04-28T17:00:00Z"]]\n'
    found = problems(campaign((plan, overlap)))
    assert "two windows overlap" in found[0].what
    digits = plan + "windows = [[12833581390, 12833645430]]\n"
    found = problems(campaign((plan, digits)))
    assert "11 digits: neither s nor ms" in found[0].what
    assert found[0].where == "campaign.toml:22"


@pytest.mark.parametrize(
    ("fitted", "held", "refused"),
    [
        ("", "", True),
        ('groups = ["1"]\n', 'groups = ["2"]\n', False),
        ('groups = ["1"]\n', 'groups = ["1", "2"]\n', True),
        (WINDOWS + "]\n", 'windows = [["2010-04-28T15:59:00Z", "2010-04-28T18:00:00Z"]]\n', True),
        (WINDOWS + "]\n", 'windows = [["2010-04-28T16:00:00Z", "2010-04-28T18:00:00Z"]]\n', False),
    ],
)
def test_readings_held_out_must_not_be_fitted(campaign: Write, fitted: str, held: str, refused: bool) -> None:
    plan = 'recordings = ["one"]\n'
    other = (
        f'[[tests]]\nid = "judge"\nuse = "hold_out"\nprocedure = "rate_table"\n{plan}{held}plan = {{ axis = "x" }}\n'
    )
    folder = campaign((plan, plan + fitted), ("[[requirements]]", other + "[[requirements]]"))
    if refused:
        assert problems(folder)[0].code == "overlap"
    else:
        load(folder)


def test_no_campaign_says_what_to_do(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nothing"):
        found = problems(folder)[0]
        assert found.what.startswith("No campaign here")
        assert found.do == "Try: inertialcal demo"
    (tmp_path / "gyro.csv").write_text("x\n1\n")
    assert problems(tmp_path)[0].do.startswith(f"Make one of the files there: inertialcal init {tmp_path}.")


def test_an_example_is_made_once_and_another_one_does_not_take_its_place(tmp_path: Path) -> None:
    """Rigs of one family write campaigns of one id: what was simulated tells them apart."""
    for name, others in (("sams_tsh_model", ("sams_tsh", "sams1996")), ("sams1996", ("sams_tsh", "reinel1969"))):
        folder = build(name, tmp_path / name)
        text = (folder / "campaign.toml").read_bytes()
        assert build(name, folder) == folder
        for other in others:
            with pytest.raises(UsageError, match="holds another campaign"):
                build(other, folder)
        assert (folder / "campaign.toml").read_bytes() == text


def test_text_that_is_not_utf8_is_told_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_bytes(b"schema = 1\n# \xff\n")
    assert problems(tmp_path)[0].where == "campaign.toml:2"


def test_a_link_out_of_the_folder_is_refused(campaign: Write, tmp_path: Path) -> None:
    folder = campaign()
    (folder / "one.csv").unlink()
    (folder / "one.csv").symlink_to("/etc/hostname")
    assert problems(folder)[0].code == "outside"


@pytest.mark.parametrize("text", ["a = " + "[" * 3000, "a" * 2_000_000, "schema = 1" + "0" * 5000, "\x00", ""])
def test_hostile_text_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "campaign.toml").write_text(text)
    assert problems(tmp_path)


SAME = 'recordings = ["one"]\n'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (SAME, 'recordings = ["one", "one"]\n', "a recording appears twice"),
        (SAME, SAME + 'groups = ["1"]\n', ""),
        ('limit = "5 %"', 'limit = "-5 %"', "must be above zero"),
        ('limit = "5 %"', 'limit = "5 V"', "rate_error cannot be compared with '5 V'"),
        ('quantity = "rate_error"', 'quantity = "rate_eror"', "Did you mean rate_error"),
        ("[[requirements]]", '[model]\nterms = { scale_factor = ["frist"] }\n[[requirements]]', "'frist' is no test"),
        ("zero_reference = true", 'zero_reference = true, attitude = { tilt = "1 deg" }', "needs site.latitude"),
        ('unit = "deg/s"\nrange', 'unit = "deg/s"\nmounting = [[1,0,0],[0,1,0],[0,0,1]]\nrange', "mounting"),
        ('kind = "gyro"', 'kind = "accelerometer"', "no unit of acceleration"),
    ],
)
def test_what_does_not_fit_together_is_refused(campaign: Write, old: str, new: str, words: str) -> None:
    folder = campaign((old, new))
    if not words:
        load(folder)
        return
    assert any(words in f"{p.what} {p.do}" for p in problems(folder))


def test_the_same_file_under_two_names_is_no_data_held_out(campaign: Write) -> None:
    other = '[[tests]]\nid = "judge"\nuse = "hold_out"\nprocedure = "rate_table"\nrecordings = ["two"]\n'
    other += 'plan = { axis = "x" }\n'
    entry = '[recordings.two]\nsensor = "suite"\nfile = "one.csv"\n'
    entry += 'rows = { applied = "rate", reading = "x", unit = "deg/s" }\n'
    folder = campaign(("[[tests]]", entry + "[[tests]]"), ("[[requirements]]", other + "[[requirements]]"))
    assert problems(folder)[0].code == "overlap"


def test_a_line_marked_by_init_must_be_filled_in(campaign: Write) -> None:
    found = problems(campaign(('serial = "7"', 'serial = "7"  # FILL IN')))
    assert (found[0].code, found[0].where) == ("fill_in", "campaign.toml:5")


@pytest.mark.parametrize(
    ("unit", "words"), [("", "channel x without a unit"), (', unit = "V/s"', "channel x in 'V/s'")]
)
def test_a_channel_without_a_unit_is_told_so(campaign: Write, unit: str, words: str) -> None:
    entry = f'[recordings.two]\nsensor = "suite"\nfile = "one.csv"\nchannels = {{ x = {{ column = "x"{unit} }} }}\n'
    found = problems(campaign(("[[tests]]", entry + "[[tests]]")))
    assert any(f"recordings.two: {words}, need a unit of " in one.what for one in found), found
