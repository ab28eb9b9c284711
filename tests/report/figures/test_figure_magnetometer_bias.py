"""Figures of a gyro against a magnetometer: titles with numbers of the curves, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure


def column(values: list[float], unit: str) -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "in_orbit", "axis": "", "recording": "", "of": "", "columns": columns}


CURVES = [
    curve(
        "magnetometer_bias_known", time=column([300.0, 600.0, 900.0], "s"), u_x=column([3e-3, 1e-3, 5e-4], "deg/s"),
        u_y=column([2e-3, 1e-3, 7e-4], "deg/s"), u_z=column([4e-3, 9e-4, 4e-4], "deg/s"),
    ),
    curve(
        "magnetometer_residuals", time=column([150.0, 450.0, 750.0], "s"), mean=column([3e-9, -4e-9, 0.0], "T"),
        deviation=column([5e-8] * 3, "T"), field=column([3e-5] * 3, "T"),
    ),
]  # fmt: skip


def axes_of(name: str) -> tuple[str, Axes]:
    (picture,) = figures()[name].pictures({"curves": CURVES, "results": []})
    figure = on_new_figure(picture, titled=False)
    figure.draw_without_rendering()
    return picture.finding, figure.axes[0]


def test_how_well_the_bias_is_known_is_drawn_over_minutes() -> None:
    finding, ax = axes_of("magnetometer_bias_known")
    assert finding == "y is known least: 0.00070 deg/s at the end"
    labels = {str(line.get_label()): line for line in ax.get_lines()}
    assert [name for name in labels if name] == ["x", "y", "z"]
    assert np.asarray(labels["z"].get_xdata()).tolist() == [5.0, 10.0, 15.0]
    assert np.asarray(labels["z"].get_ydata()).tolist() == [4e-3, 9e-4, 4e-4]


def test_residuals_are_drawn_in_nanotesla() -> None:
    finding, ax = axes_of("magnetometer_residuals")
    assert finding == "Means of arcs lie 2.9 nT (rms) from the model"
    drawn = next(line for line in ax.get_lines() if len(np.asarray(line.get_xdata())) == 3)
    assert np.asarray(drawn.get_ydata(), dtype=float).tolist() == pytest.approx([3.0, -4.0, 0.0])
