"""Files of figures: three formats, the same bytes, an input never replaced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError, StoreError, UsageError
from inertialcal.core.recording import Channel, Recording
from inertialcal.report.figure_file import FORMATS, check_ending, write_figure
from inertialcal.report.figures.drawing.picture import Picture
from inertialcal.report.plot import pictures

MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def picture(name: str = "a") -> Picture:
    return pictures(Recording((Channel(name, np.array([1.0, 3.0, 2.0])),)))[0]


@pytest.mark.parametrize("ending", FORMATS)
def test_the_ending_says_the_format_and_the_bytes_do_not_change(ending: str, tmp_path: Path) -> None:
    one, other = tmp_path / f"one{ending}", tmp_path / f"other{ending.upper()}"
    for path in (one, other):
        write_figure(path, [picture()])
    assert one.read_bytes().startswith(MAGIC[ending])
    assert one.read_bytes() == other.read_bytes()
    assert sorted(tmp_path.iterdir()) == [one, other]


@pytest.mark.parametrize("name", ["a.gif", "a", ".png", "a.png.exe"])
def test_other_endings_are_refused_with_those_there_are(name: str) -> None:
    with pytest.raises(UsageError, match=r"End the name with one of: \.png, \.svg, \.pdf"):
        check_ending(name)


def test_an_input_is_never_replaced(tmp_path: Path) -> None:
    data = tmp_path / "data.png"
    data.write_bytes(b"recorded")
    with pytest.raises(DataError, match="overwrite the input"):
        write_figure(data, [picture()], [data])
    assert data.read_bytes() == b"recorded"
    with pytest.raises(StoreError, match="there is no folder"):
        write_figure(tmp_path / "no" / "a.png", [picture()])


def test_several_pictures_stand_side_by_side(tmp_path: Path) -> None:
    one, three = tmp_path / "1.svg", tmp_path / "3.svg"
    write_figure(one, [picture()])
    write_figure(three, [picture(), picture(), picture()])
    sizes = [
        [float(path.read_text().split(f'{side}="')[1].split("pt")[0]) for side in ("width", "height")]
        for path in (one, three)
    ]
    assert sizes[1][0] > 2.0 * sizes[0][0]
    assert sizes[1][1] < 1.5 * sizes[0][1]


def test_a_name_in_another_script_is_no_warning(tmp_path: Path) -> None:
    write_figure(tmp_path / "a.png", [picture("漢字 $ \x00")])
    assert (tmp_path / "a.png").is_file()
