"""Figures of a shifted ground model: titles with numbers of the results, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "shifted", "axis": "y", "recording": "", "of": "", "columns": columns}


def row(quantity: str, value: float, u: float, unit: str) -> dict[str, Any]:
    return {**fields(), "test": "shifted", "quantity": quantity, "axis": "y", "value": value, "u": u, "unit": unit}


CURVES = [
    curve(
        "shifted_flights", flight=column(["1", "2", "3"]), age=column([0.0, 1.0, 2.0], "year"),
        temperature=column([18.0, 21.0, 20.0], "degC"), used=column([True, True, False]),
        shift=column([20.0, 24.0, 28.0], "ug"), left=column([-1.0, 1.0, 4.0], "ug"), u=column([0.5, 0.5, 0.5], "ug"),
        lo=column([19.0, 23.0, 27.0], "ug"), hi=column([21.0, 25.0, 29.0], "ug"),
    ),
    curve(
        "shifted_trend", age=column([0.0, 1.0, 2.0], "year"), shift=column([21.0, 23.0, 25.0], "ug"),
        lo=column([11.0, 12.0, 9.0], "ug"), hi=column([31.0, 34.0, 41.0], "ug"),
    ),
    curve(
        "shifted_temperature", temperature=column([5.0, 20.0, 40.0], "degC"), shift=column([22.0, 24.0, 26.0], "ug"),
        lo=column([2.0, 14.0, 0.0], "ug"), hi=column([42.0, 34.0, 52.0], "ug"),
    ),
]  # fmt: skip


def axes_of(name: str, rows: list[Any]) -> tuple[str, Axes]:
    (picture,) = figures()[name].pictures({"curves": CURVES, "results": rows})
    figure = on_new_figure(picture, titled=False)
    figure.draw_without_rendering()
    return picture.finding, figure.axes[0]


def test_flights_are_drawn_over_the_years() -> None:
    rows = [
        row("bias_shift", 24.3, 1.25, "ug"),
        row("bias_drift", 2.02, 0.41, "ug/year"),
    ]
    finding, ax = axes_of("shifted_flights", rows)
    assert finding == "y: shift 24.3 ± 1.2 ug, drift 2.02 ± 0.41 ug/year"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(drawn["flips"].get_ydata()).tolist() == [20.0, 24.0]
    assert np.asarray(drawn["left out"].get_xdata()).tolist() == [2.0]
    assert np.asarray(drawn["new model"].get_ydata()).tolist() == [21.0, 23.0, 25.0]


def test_the_band_over_temperature_says_how_well_a_flight_is_known() -> None:
    finding, ax = axes_of("shifted_temperature", [])
    assert finding == "y: a flight to come is known to 10 to 26 ug, at 95 %"
    drawn = {str(line.get_label()): line for line in ax.get_lines()}
    assert np.asarray(drawn["flips"].get_xdata(), dtype=float).tolist() == pytest.approx([18.0, 21.0])
