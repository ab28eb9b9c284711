"""Labelled parts of a recording, as a JSON or a table says them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.labelled import LabelledPart, labelled_csv
from inertialcal.core.recording import Recording
from inertialcal.procedures.positions.inputs import section_of
from inertialcal.procedures.positions.orientations import sections_of

TURN = "x_rot"


def said(folder: Path, name: str, text: str) -> tuple[LabelledPart, ...]:
    (folder / name).write_text(text, encoding="utf-8")
    return sections_of(folder / name)


def test_a_label_may_stand_twice_and_a_turn_has_its_own_angle(tmp_path: Path) -> None:
    json_text = """{"z_p": {"start": 0, "end": 9}, "z_p": [20, 29],
        "x_rot": {"start": "3 s", "end": "4 s"}, "x_rot": {"start": "5 s", "end": "6 s", "angle": "-360 deg"}}"""
    found = said(tmp_path, "s.json", json_text)
    assert [(one.label, one.start, one.stop, one.seconds) for one in found] == [
        ("z_p", 0, 9, False), ("z_p", 20, 29, False), (TURN, 3, 4, True), (TURN, 5, 6, True),
    ]  # fmt: skip
    assert [one.angle for one in found[:3]] == [None] * 3
    assert found[3].angle == pytest.approx(-2.0 * np.pi, rel=1e-15)


def test_a_table_of_sections_comes_back_as_it_was_written(tmp_path: Path) -> None:
    sections = (LabelledPart("z+", 0, 9), LabelledPart(TURN, 20, 29, angle=-np.pi / 3.0), LabelledPart(TURN, 40, 49))
    found = said(tmp_path, "s.csv", labelled_csv(sections))
    assert [(one.label, one.start, one.stop) for one in found] == [("z+", 0, 9), (TURN, 20, 29), (TURN, 40, 49)]
    assert [found[0].angle, found[2].angle] == [None, None]
    assert found[1].angle == pytest.approx(-np.pi / 3.0, rel=1e-14)


def test_an_angle_of_its_own_goes_before_that_of_all(tmp_path: Path) -> None:
    recording = Recording((), sample_interval=0.1)
    one, other = said(tmp_path, "s.csv", "section,start,end,turn [deg]\nx_rot,0,9,-180\nx_rot,10,19,\n")
    assert section_of(one, recording, 7.0).angle == pytest.approx(-np.pi)
    assert section_of(other, recording, 7.0).angle == 7.0


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("s.csv", "section,start,end,angle\nx_rot,0,9,360\n", "column 'angle' has no unit"),
        ("s.csv", "section,start,end,angle [s]\nx_rot,0,9,360\n", "angle"),
        ("s.csv", "section,start,end,angle [deg]\nx_p,0,9,360\n", "'x_p' is a position, and has an angle"),
        ("s.csv", "section,start,end,angle [deg]\nx_rot,0,9,0\n", "s.csv:2: section 'x_rot': a turn by 0 deg"),
        ("s.csv", "section,start,end\nx_rot,9,0\n", "s.csv:2: section 'x_rot': from 9 to 0"),
        ("s.json", '{"x_rot": {"start": 0, "end": 9, "angle": 360}}', "360 is no angle"),
        ("s.json", '{"x_rot": {"start": 0, "end": 9, "angle": "360"}}', "'360' is no angle"),
        ("s.json", '{"x_rot": {"start": 0, "end": 9, "angle": "9 s"}}', "'9 s' is no angle"),
        ("s.json", '{"x_rot": {"start": 0, "end": 9, "angle": {"a": 1}}}', "is no angle"),
        ("s.json", '{"x_rot": {"start": 0, "angle": "9 deg"}}', "no start and end"),
        ("s.json", '[1, 2]', "the file holds no object"),
    ],
)  # fmt: skip
def test_wrong_sections_are_told(tmp_path: Path, name: str, text: str, message: str) -> None:
    with pytest.raises(DataError) as caught:
        said(tmp_path, name, text)
    assert message in str(caught.value)
