"""What more time buys: every length is drawn, what is wanted is dashed, the chosen one is a dot."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inertialcal.report.figures import figures, on_new_figure


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, of: str, **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "plan", "axis": "", "of": of, "columns": columns}


def length(of: str, unit: str, u: list[float | None], **more: Any) -> dict[str, Any]:
    return curve("plan_time", of, time=column([1.0, 4.0, 16.0], "h"), u=column(u, unit),
                 chosen=column([False, True, False]), **more)  # fmt: skip


CURVES = [
    length("bias", "deg/s", [0.004, 0.002, 0.001], wanted=column([0.0025] * 3, "deg/s")),
    length("scale factor error", "ppm", [80.0, 40.0, 30.0]),
]


def test_each_figure_has_a_panel_with_all_lengths() -> None:
    (picture,) = figures()["plan_time"].pictures({"curves": CURVES, "results": []})
    assert picture.finding == "4 h give bias to 0.0020 deg/s"
    figure = on_new_figure(picture, True)
    above, below = figure.axes
    gives, wanted = (np.asarray(one.get_ydata()).tolist() for one in above.get_lines()[:2])
    assert (gives, wanted) == ([0.004, 0.002, 0.001], [0.0025] * 3)
    assert [one.get_text() for one in above.texts] == ["bias"]
    (dot,) = [one for one in below.get_lines() if one.get_label() == "chosen"]
    assert [float(x) for x in np.asarray(dot.get_xdata())] == [4.0]
    legend = below.get_legend()
    assert legend is not None
    assert [one.get_text() for one in legend.get_texts()] == ["what the test gives", "wanted", "chosen"]


@pytest.mark.parametrize("u", [[0.004], [None, None, None]])
def test_nothing_is_drawn_of_one_length(u: list[float | None]) -> None:
    n = len(u)
    one = curve("plan_time", "bias", time=column([1.0] * n, "h"), u=column(u, "deg/s"),
                chosen=column([True] * n))  # fmt: skip
    assert figures()["plan_time"].pictures({"curves": [one], "results": []}) == []
