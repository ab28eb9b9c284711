"""Figures of heads on one body: titles with numbers of the curves, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure


def column(values: list[float], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "third", "axis": "", "recording": "", "of": "tsh3", "columns": columns}


CURVES = [
    curve(
        "heads_gap", time=column([0.0, 60.0, 120.0], "s"),
        **{axis: column([5.0, 5.3, 4.7], "ug") for axis in "xyz"},
        **{f"fitted_{axis}": column([5.0] * 3, "ug") for axis in "xyz"},
    ),
    curve(
        "heads_places", along=column([0.0, 0.5, 1.0, 2.0]), u=column([0.14, 0.12, 0.14, 0.24], "ug"),
        head=column([0.5] * 4), cost=column([0.05] * 4, "ug"),
    ),
]  # fmt: skip


def axes_of(name: str) -> tuple[str, Axes]:
    (picture,) = figures()[name].pictures({"curves": CURVES, "results": []})
    figure = on_new_figure(picture, titled=False)
    figure.draw_without_rendering()
    return picture.finding, figure.axes[0]


def test_what_the_fit_leaves_is_drawn_over_minutes() -> None:
    finding, ax = axes_of("heads_gap")
    assert finding == "Means of tsh3 lie 0.24 ug (rms) from the fit"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(drawn["y"].get_xdata()).tolist() == [0.0, 1.0, 2.0]
    assert np.asarray(drawn["y"].get_ydata()).tolist() == pytest.approx([0.0, 0.3, -0.3])


def test_the_head_lies_on_the_line_of_its_place() -> None:
    finding, ax = axes_of("heads_places")
    assert finding == "Least halfway: 0.12 ug; 2 times that at 2"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(drawn["tsh3"].get_xdata()).tolist() == [0.5]
    assert np.asarray(drawn["tsh3"].get_ydata()).tolist() == pytest.approx([0.13])
