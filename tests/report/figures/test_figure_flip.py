"""The figure of a flip draws the readings given, and the windows of the record with their ends named."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from inertialcal.report.figures import figures, on_new_figure
from inertialcal.report.figures.flip.flip import draw_record, spans


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": list(values)}


def quiet(axis: str) -> dict[str, Any]:
    time = [5.0, 15.0, 25.0, 35.0, 65.0, 75.0, 85.0, 95.0]
    used = [False, False, True, True, True, True, False, False]
    columns = {
        "time": column(time, "s"), "mean": column(np.arange(8.0), "ug"),
        "angle": column([0.0] * 4 + [np.pi] * 4, "rad"), "used": column(used),
    }  # fmt: skip
    return {"name": "quiet", "test": "t", "axis": axis, "recording": "r", "columns": columns}


def dwells(axis: str) -> dict[str, Any]:
    columns = {
        "flip": column(["1", "1", "2", "2"]), "angle": column([0.0, np.pi, np.pi, 0.0], "rad"),
        "reading": column([1.0, -1.0, -1.2, None], "ug"), "expected": column([1.0, -1.0, -1.2, None], "ug"),
    }  # fmt: skip
    return {"name": "flip_dwells", "test": "t", "axis": axis, "columns": columns}


def test_windows_are_the_stretches_that_dwells_were_read_from() -> None:
    assert spans(quiet("x")) == [(20.0, 40.0), (60.0, 80.0)]


def test_ends_carry_letters_and_positions_their_marks() -> None:
    figure = Figure()
    axes = [figure.add_subplot(2, 1, i + 1) for i in range(2)]
    draw_record(axes, [quiet("x"), quiet("y")])
    assert [text.get_text() for text in axes[0].texts] == ["A", "B", "C", "D"]
    still, turned = (np.asarray(line.get_ydata()).tolist() for line in axes[0].get_lines()[:2])
    assert (still, turned) == ([0.0, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0])


def test_a_line_marks_each_turn_that_the_record_shows() -> None:
    columns = {"start": column([45.0], "s"), "stop": column([55.0], "s")}
    turns = {"name": "turns", "test": "t", "axis": "x", "recording": "r", "columns": columns}
    picture = figures()["flip"].pictures({"curves": [dwells("x"), quiet("x"), quiet("y"), turns]})[1]
    for ax in on_new_figure(picture, titled=False).axes:
        (line,) = (one for one in ax.get_lines() if one.get_label() == "turn seen")
        assert np.asarray(line.get_xdata()).tolist() == [50.0, 50.0]


def test_readings_are_drawn_filled_at_zero_and_hollow_turned() -> None:
    results = {"curves": [dwells("x"), dwells("y"), quiet("x"), quiet("y")]}
    first, second = figures()["flip"].pictures(results)
    assert ([one["name"] for one in first.data], [one["name"] for one in second.data]) == (
        ["flip_dwells"] * 2,
        ["quiet"] * 2,
    )
    ax = on_new_figure(first, titled=False).axes[0]
    marked = [line for line in ax.get_lines() if line.get_label() in ("position 0", "turned")]
    assert np.asarray(marked[0].get_ydata())[0] == 1.0
    assert np.asarray(marked[1].get_ydata()).tolist() == [-1.0, -1.2]
    assert figures()["flip"].pictures({"curves": []}) == []
