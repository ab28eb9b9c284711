"""Figures of a turned mass: titles with numbers of the results, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, recording: str = "", of: str = "", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "turned", "axis": "x", "recording": recording, "of": of, "columns": columns}


def runs() -> dict[str, Any]:
    return curve(
        "turned_runs", run=column(["1", "2", "3"]), rate=column([0.1, -0.1, 0.06], "deg/s"),
        period=column([1.0, 1.0, 1.6], "h"), recoil_rate=column([1.0e-5, 3.0e-6, 7.0e-6], "1/s^2"),
        used=column([True, True, False]), cosine=column([-0.0017, 0.0046, 0.02], "count/s"),
        u=column([0.0002] * 3, "count/s"), lo=column([-0.0021, 0.0042, 0.0196], "count/s"),
        hi=column([-0.0013, 0.005, 0.0204], "count/s"), sine=column([0.0001, 0.0, 0.01], "count/s"),
        fitted_cosine=column([-0.0018, 0.0045, None], "count/s"), fitted_sine=column([0.0, 0.0, None], "count/s"),
    )  # fmt: skip


def turn() -> dict[str, Any]:
    return curve(
        "turned_turn", "run1", "+1 h", angle=column([15.0, 195.0, 105.0], "deg"),
        reading=column([-0.002, 0.0021, 0.0], "count/s"), u=column([0.0005] * 3, "count/s"),
        line=column([-0.0017, 0.0017, 0.0004], "count/s"), count=column([30.0, 31.0, 29.0], "1"),
    )  # fmt: skip


def null(of: str) -> dict[str, Any]:
    sign = 1.0 if of == "with" else -1.0
    return curve("turned_null", "", of, period=column([0.5, 1.0, 8.0], "h"),
                 response=column([-2.0 * sign, -0.25 * sign, 0.5], "1"))  # fmt: skip


def planned() -> dict[str, Any]:
    return curve(
        "turned_planned", run=column(["run1", "run2"]), period=column([1.0, 1.6], "h"), ahead=column([True, False]),
        response=column([-0.25, 0.66], "1"), u=column([0.02, None], "1"),
    )  # fmt: skip


CURVES = [runs(), turn(), null("with"), null("against"), planned()]


def row(quantity: str, value: float, u: float | None, unit: str, **more: Any) -> dict[str, Any]:
    made = {"quantity": quantity, "axis": "x", "test": "turned", "value": value, "u": u, "unit": unit, "interval": None}
    return fields() | made | more


ROWS = [row("scale_factor", 10.13, 0.21, "count/s/ug"), row("recoil_arm", 0.797, 0.01, "mm")]


def axes_of(name: str, rows: list[dict[str, Any]]) -> list[Axes]:
    figure = on_new_figure(figures()[name].pictures({"curves": CURVES, "results": rows})[0], titled=False)
    figure.draw_without_rendering()
    return list(figure.axes)


@pytest.mark.parametrize(
    ("name", "rows", "title"),
    [
        ("turned_runs", ROWS, "3 runs: scale factor 10.13 ± 0.21 count/s/ug, recoil arm 0.797 ± 0.010 mm"),
        ("turned_runs", [], "3 runs: the response cannot be told from noise"),
        ("turned_turn", [], "run1, a turn in +1 h: the readings swing by 0.0017 count/s"),
        (
            "turned_forecast",
            [row("scale_factor_uncertainty", 0.021, None, "1", axis="")],
            "scale factor to 2.1 %",
        ),
    ],
)
def test_titles_have_the_numbers_of_the_results(name: str, rows: list[dict[str, Any]], title: str) -> None:
    found = figures()[name].pictures({"curves": CURVES, "results": rows})[0]
    assert found.finding == title


def test_the_sense_of_a_run_and_what_is_not_used_are_seen() -> None:
    (ax,) = axes_of("turned_runs", ROWS)
    labels = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(labels["with the orbit"].get_xdata()).tolist() == [10.0]
    assert np.asarray(labels["against the orbit"].get_xdata()).tolist() == [3.0]
    assert np.asarray(labels["meets the orbit, not used"].get_ydata()).tolist() == [0.02]
    x, y = (np.asarray(one, dtype=float) for one in labels["attraction less recoil"].get_data())
    assert np.interp(10.0, x, y) == pytest.approx(-0.0018)  # the line goes through what was fitted


def test_a_turn_is_drawn_in_the_order_of_its_angle() -> None:
    (ax,) = axes_of("turned_turn", [])
    line = next(one for one in ax.get_lines() if one.get_label() == "fitted")
    assert np.asarray(line.get_xdata()).tolist() == [15.0, 105.0, 195.0]


def test_both_senses_and_the_planned_runs_are_drawn() -> None:
    (ax,) = axes_of("turned_forecast", [])
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["with the orbit", "against the orbit"]
