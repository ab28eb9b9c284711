"""Figures of a test of positions: what they say, and that they are drawn of what there is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inertialcal.report.figures.drawing.layout import ticks_of
from inertialcal.report.figures.drawing.picture import on_new_figure
from inertialcal.report.figures.positions import positions_residuals, positions_sphere, transitions

G = 9.80665
FACES = np.vstack([np.eye(3), -np.eye(3)])


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"values": list(values), "unit": unit}


def positions_curve(up: Any, residual_ug: Any, left_out: Any = ()) -> dict[str, Any]:
    residual = np.asarray(residual_ug) * 1e-6 * G
    m = len(residual)
    columns = {"position": column(range(1, m + 1)), "between": column([1e-4 * G] * m, "m/s^2")}
    columns |= {f"up_{axis}": column(np.asarray(up)[:, i].tolist()) for i, axis in enumerate("xyz")}
    columns |= {"residual": column(residual.tolist(), "m/s^2"), "deletion": column((2 * residual).tolist(), "m/s^2")}
    columns["left_out"] = column([k in left_out for k in range(m)])
    return {"name": "positions", "test": "acc", "axis": "", "columns": columns}


def transitions_curve(error: Any, without: Any) -> dict[str, Any]:
    columns = {"rotation": column(range(1, len(error) + 1)), "left_out": column([False] * len(error))}
    columns |= {name: column(np.radians(one).tolist(), "rad") for name, one in
                (("error", error), ("error_without", without))}  # fmt: skip
    return {"name": "transitions", "test": "gyro", "axis": "", "columns": columns}


CURVES = (  # of all three figures
    positions_curve(FACES, [10.0, -20.0, 30.0, -40.0, 50.0, 20.0]),
    transitions_curve([0.1, 0.1, 0.3], [0.5, 0.5, 0.6]),
)


def test_largest_gap_of_six_faces_is_a_corner_of_the_cube() -> None:
    direction, gap = positions_sphere.largest_gap(FACES)
    assert gap == pytest.approx(np.degrees(np.arccos(1.0 / np.sqrt(3.0))), abs=2.0)  # 54.7 deg
    assert np.abs(direction) == pytest.approx(np.full(3, 1.0 / np.sqrt(3.0)), abs=0.05)


def test_map_keeps_areas_and_the_places_of_the_axes() -> None:
    x, y = positions_sphere.on_map(FACES)
    assert (x[0], y[0]) == (0.0, 0.0)  # +x in the middle
    assert (x[1] > 0.0, x[2], y[2]) == (True, pytest.approx(0.0, abs=1e-12), pytest.approx(np.sqrt(2.0)))
    assert x[4] == pytest.approx(-x[1])  # -y as far to the left as +y to the right
    tilt, turn, step = np.radians(50.0), np.radians(100.0), 1e-4
    at = np.array([[tilt, turn], [tilt + step, turn], [tilt, turn + step]])
    up = np.column_stack([np.cos(at[:, 0]) * np.cos(at[:, 1]), np.cos(at[:, 0]) * np.sin(at[:, 1]), np.sin(at[:, 0])])
    px, py = positions_sphere.on_map(up)
    area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0])
    assert abs(area) / step**2 == pytest.approx(np.cos(tilt), rel=1e-3)  # of the sphere


def test_residuals_are_told_in_ug_and_a_position_left_out_is_none_of_them() -> None:
    curve = positions_curve(FACES, [10.0, -20.0, 30.0, -40.0, 50.0, 5000.0], left_out=(5,))
    (picture,) = positions_residuals.pictures({"curves": [curve]})
    rms = np.sqrt(np.mean(np.square([10, 20, 30, 40, 50])))
    said = f"residuals rms {rms:.3g} ug, from the fit without it {2 * rms:.3g} ug; largest in position 5"
    assert picture.finding == said
    (sphere,) = positions_sphere.pictures({"curves": [curve]})
    assert sphere.finding.startswith("6 positions, 1 left out; no direction is farther than 55 deg")


def test_transitions_give_the_rms_with_and_without_g_sensitivity() -> None:
    curve = transitions_curve([0.3, 0.4], [0.6, 0.8])
    (picture,) = transitions.pictures({"curves": [curve]})
    assert picture.finding == "2 rotations, rms error 0.35 deg, 0.71 deg without g-sensitivity"
    without = transitions_curve([0.3, 0.4], [np.nan, np.nan])
    assert transitions.pictures({"curves": [without]})[0].finding == "2 rotations, rms error 0.35 deg"


def test_positions_and_rotations_are_counted_in_whole_numbers() -> None:
    twice = np.vstack([FACES, FACES])
    results = {"curves": [positions_curve(twice, [10.0] * 12), transitions_curve([0.1] * 12, [0.3] * 12)]}
    for module in (positions_residuals, transitions):
        (ax,) = on_new_figure(module.pictures(results)[0], titled=False).axes
        places = ticks_of(ax.xaxis)[0]
        assert len(places) >= 2
        assert all(float(place).is_integer() for place in places)


def test_every_figure_is_drawn_and_none_without_data() -> None:
    results = {
        "curves": [
            positions_curve(FACES, [1e5] * 6),
            transitions_curve([0.1, 0.2], [0.3, 0.4]),
        ]
    }
    for module in (positions_sphere, positions_residuals, transitions):
        (picture,) = module.pictures(results)
        figure = on_new_figure(picture, titled=False)
        (ax,) = figure.axes
        assert ax.lines or ax.collections
        assert module.pictures({"curves": []}) == []
    assert positions_residuals.shown_unit(np.array([2e4])) == ("mg", 1000.0)
