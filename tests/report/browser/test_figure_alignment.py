"""Figures of an alignment: titles with numbers of the curves, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure


def column(values: list[float], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "aligned", "axis": "", "recording": "", "of": "", "columns": columns}


CURVES = [
    curve(
        "alignment_rates", position=column([1.0, 2.0]), forward=column([10.0, -8.0], "deg/h"),
        right=column([-9.0, 5.0], "deg/h"), bias_forward=column([1.0, 1.0], "deg/h"),
        bias_right=column([-2.0, -2.0], "deg/h"), circle=column([12.0, 12.0], "deg/h"), u=column([0.05, 0.05], "deg/h"),
    ),
    curve(
        "alignment_forming", time=column([60.0, 120.0, 600.0], "s"), heading=column([40.2, 39.9, 40.0], "deg"),
        lo=column([39.5] * 3, "deg"), hi=column([40.5] * 3, "deg"),
    ),
]  # fmt: skip


def axes_of(name: str) -> tuple[str, Axes]:
    (picture,) = figures()[name].pictures({"curves": CURVES, "results": []})
    figure = on_new_figure(picture, titled=False)
    figure.draw_without_rendering()
    return picture.finding, figure.axes[0]


def test_the_circle_stands_about_the_bias() -> None:
    finding, ax = axes_of("alignment_rates")
    assert finding == "12 deg/h of the earth in level; 0.050 deg/h of it not known"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    circle = drawn["rate of the earth about the bias"]
    x, y = (np.asarray(one, dtype=float) for one in (circle.get_xdata(), circle.get_ydata()))
    assert np.hypot(x + 2.0, y - 1.0) == pytest.approx(12.0)
    assert [text.get_text() for text in ax.texts][:2] == ["1", "2"]


def test_the_heading_forms_over_minutes() -> None:
    finding, ax = axes_of("alignment_forming")
    assert finding == "40 deg in the end, 95 % within 0.5 deg of it"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(drawn["heading so far"].get_xdata()).tolist() == [1.0, 2.0, 10.0]
