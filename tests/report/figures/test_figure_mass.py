"""Figures of a moved mass: titles with numbers of the results, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields

TIME = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
SHAPE = [0.0, 1.0, 0.0, -1.0, 0.0, 1.0]


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, recording: str = "", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "moved", "axis": "x", "recording": recording, "columns": columns}


def series(recording: str = "run1") -> dict[str, Any]:
    return curve(
        "mass_series", recording, time=column(TIME, "h"), reading=column([1.0, 1.3, 1.2, None, 1.4, 1.9], "count/s"),
        drift=column([1.0, 1.1, 1.2, None, 1.4, 1.6], "count/s"),
        reduced=column([0.0, 0.2, 0.0, None, 0.0, 0.3], "count/s"),
        line=column([0.0, 0.23, 0.0, None, 0.0, 0.23], "count/s"), shape=column(SHAPE),
    )  # fmt: skip


def spectrum(recording: str = "run1") -> dict[str, Any]:
    return curve(
        "mass_spectrum", recording, frequency=column([0.001, 0.0015, 0.002, 0.0025, 0.003], "Hz"),
        amplitude=column([0.01, 0.02, 0.24, 0.04, 0.01], "count/s"), role=column(["", "beside", "drive", "beside", ""]),
    )  # fmt: skip


def correlation(recording: str = "run1") -> dict[str, Any]:
    return curve(
        "mass_correlation", recording, lag=column([0.0, 0.1, 0.2], "h"), reduced=column([100.0, 0.0, -80.0], "%"),
        noise=column([30.0, 0.0, 1.0], "%"),
    )  # fmt: skip


def runs() -> dict[str, Any]:
    return curve(
        "mass_runs", run=column(["1", "2", "null"]), moved=column([True, True, False]),
        applied=column([0.023] * 3, "ug"), response=column([0.24, 0.23, 0.01], "count/s"),
        u=column([0.02] * 3, "count/s"), scale_factor=column([10.4, 10.0, 0.4], "count/s/ug"),
        lo=column([8.7, 8.3, -1.3], "count/s/ug"), hi=column([12.1, 11.7, 2.1], "count/s/ug"),
        tilt=column([None] * 3, "rad"), published_fourier=column([0.24, 0.23, 0.01], "count/s"),
        published_fourier_noise=column([0.03, 0.03, 0.03], "count/s"),
        published_spectrum=column([None] * 3, "count/s"), published_spectrum_noise=column([None] * 3, "count/s"),
        published_scatter=column([None] * 3, "count/s"),
    )  # fmt: skip


CURVES = [runs(), series(), series("run2"), spectrum(), correlation(), spectrum("run2"), correlation("run2")]
ROWS: list[dict[str, Any]] = [
    {
        "quantity": "scale_factor", "test": "moved", "axis": "x", **fields(), "value": 10.2, "u": 0.5,
        "unit": "count/s/ug", "interval": {"lo": 9.2, "hi": 11.2, "p": 0.95}, "status": "estimated", "dof": None,
    }
]  # fmt: skip
RESULTS: dict[str, Any] = {"curves": CURVES, "results": ROWS}


def axes_of(name: str) -> list[Axes]:
    figure = on_new_figure(figures()[name].pictures(RESULTS)[0], titled=False)
    figure.draw_without_rendering()
    return figure.axes


@pytest.mark.parametrize(
    ("name", "finding"),
    [
        ("mass_runs", "2 runs with the mass moved: 10.20 ± 0.50 count/s/ug"),
        ("mass_series", "run1: a line of 0.12 count/s in readings that range over 0.9 count/s"),
        ("mass_line", "run1: the line of the drive is 8 times those next to it"),
    ],
)
def test_titles_say_the_finding(name: str, finding: str) -> None:
    assert figures()[name].pictures(RESULTS)[0].finding == finding


def test_a_test_without_a_scale_factor_says_so() -> None:
    found = figures()["mass_runs"].pictures({"curves": [runs()], "results": []})
    assert found[0].finding == "2 runs: scale factor cannot be told from noise"


def test_dwells_with_more_attraction_are_filled_and_gaps_have_no_dot() -> None:
    _, below = axes_of("mass_series")
    filled = next(one for one in below.get_lines() if one.get_label() == "more attracted")
    assert np.asarray(filled.get_ydata()).tolist() == [0.2, 0.3]
    assert np.asarray(filled.get_xdata()).tolist() == [0.2, 0.6]


def test_the_line_and_those_beside_it_are_told_apart() -> None:
    above, below = axes_of("mass_line")
    drawn = {str(one.get_label()): np.asarray(one.get_ydata()).tolist() for one in above.get_lines()}
    assert drawn["the drive"] == [0.24]
    assert drawn["next to it: noise"] == [0.02, 0.04]
    left = next(one for one in below.get_lines() if one.get_label() == "without the line")
    assert np.asarray(left.get_ydata()).tolist() == [30.0, 0.0, 1.0]


def test_what_the_published_way_makes_of_a_run_stands_lower() -> None:
    (ax,) = axes_of("mass_runs")
    crosses = next(one for one in ax.get_lines() if str(one.get_label()).startswith("noise subtracted"))
    assert np.asarray(crosses.get_ydata()).tolist() == pytest.approx([0.21 * 10.4 / 0.24, 0.2 * 10.0 / 0.23, -0.8])


def test_a_spectrum_without_its_correlation_is_no_figure() -> None:
    assert figures()["mass_line"].pictures({"curves": [spectrum()]}) == []
