"""Figures and the page of an archive: what is drawn is what was archived, and texts of others stay texts."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest
from archive_curves import HISTORY, LINE, TREND
from made_records import add, content, figure, yearly

from inertialcal.archive import open_archive
from inertialcal.archive.archive import Archive
from inertialcal.archive.page import history_page
from inertialcal.cli.__main__ import main
from inertialcal.report.figures import figures, on_new_figure

EVIL = "<script>alert(1)</script>"


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    return open_archive(tmp_path / "lab.db")


def status(*words: str) -> object:
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    return ended.value.code


def test_limits_begin_with_the_last_test_and_the_line_goes_on() -> None:
    (picture,) = figures()["archive_history"].pictures({"curves": [HISTORY, LINE]})
    (ax,) = on_new_figure(picture, titled=True).axes
    found = {str(line.get_label()): np.asarray(line.get_xydata()) for line in ax.lines}
    np.testing.assert_allclose(found["line through the tests"], [[2020.5, 0.1], [2024.5, 0.18]])
    np.testing.assert_allclose(found["limit since the last test"], [[2022.5, 0.04], [2024.5, 0.04]])
    (alone,) = figures()["archive_history"].pictures({"curves": [HISTORY]})
    assert picture.note
    assert not alone.note


def test_the_line_of_another_condition_is_not_taken() -> None:
    (picture,) = figures()["archive_history"].pictures({"curves": [HISTORY, LINE | {"condition": "hot"}]})
    assert picture.data == [HISTORY]


def test_signals_of_a_chart_are_marked() -> None:
    (picture,) = figures()["archive_trend"].pictures({"curves": [TREND]})
    top, _ = on_new_figure(picture, titled=True).axes
    marked = next(line for line in top.lines if line.get_label() == "signal")
    np.testing.assert_allclose(np.asarray(marked.get_xydata()), [[4.0, 2.0]])


def test_tests_in_other_units_are_drawn_in_that_of_the_last(archive: Archive) -> None:
    for year, (value, unit) in enumerate([(1000.0, "ppm"), (0.12, "%"), (0.14, "%")]):
        add(archive, content("A", float(year), [figure(value, value / 10.0, unit=unit)], influences={}))
    curve = archive.history("A").content()["curves"][0]
    assert curve["columns"]["value"] == {"unit": "%", "values": pytest.approx([0.1, 0.12, 0.14])}


def test_the_page_of_a_unit_holds_its_tests_and_runs_nothing_of_others(archive: Archive) -> None:
    add(archive, *yearly(EVIL, [0.1012, 0.1213, 0.1391, 0.1602, 0.1811]))
    add(archive, *yearly("other", [0.777]))
    page = history_page(archive, archive.history(EVIL, limits=["0.1 %"]))
    assert "alert(1)</script>" not in page
    assert html.escape(EVIL) in page
    assert re.search(r"Calibrate again by</span> <span class=\"word\">20\d\d-", page)
    assert page.count("<svg") == 1
    assert "default-src &#39;none&#39;" in page
    assert not re.search(r"(src|href)=\"(?!#)", page)
    assert "2017-" in page
    assert "0.777" not in page


def test_the_page_of_a_unit_without_days_says_why_it_is_empty(archive: Archive) -> None:
    made = content("A", 0.0, [figure(0.1, 0.01)])
    for step in made["sequence"]:
        step["time"] = None
    add(archive, made)
    page = history_page(archive, archive.history("A"))
    assert "Nothing to draw: see the remarks" in page
    assert "whose day is not known" in page


def test_commands_write_the_page_and_draw_in_text(
    tmp_path: Path, archive: Archive, capsys: pytest.CaptureFixture[str]
) -> None:
    add(archive, *yearly("A", [0.1, 0.12, 0.14]), *yearly("B", [0.11]), *yearly("C", [0.13]))
    where = ["--archive", str(tmp_path / "lab.db")]
    assert status("archive", "history", "A", *where, "-o", str(tmp_path / "A.html"), "--plot") == 0
    said = capsys.readouterr().out
    assert "A.html" in said
    assert "scale factor error x [%]" in said
    assert (tmp_path / "A.html").read_text().startswith("<!DOCTYPE html>")
    assert status("archive", "trend", "scale_factor_error", *where, "--plot", "-o", str(tmp_path / "t.svg")) == 0
    assert "range [%]" in capsys.readouterr().out
    assert status("archive", "trend", "scale_factor_error", *where, "-o", str(tmp_path / "t.html")) == 2
