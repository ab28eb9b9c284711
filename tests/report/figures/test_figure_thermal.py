"""Figures of a test over temperature draw the cells, laws and start-up given, and say in the title what they show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields

T = [10.0, 20.0, 30.0]
TESTS = ("vacuum", "air")


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": list(values)}


def curve(name: str, test: str = "vacuum", axis: str = "x", of: str = "", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": test, "axis": axis, "of": of, "columns": columns}


def cells(test: str = "vacuum") -> dict[str, Any]:
    return curve(
        "thermal_cells", test,
        temperature=column(T + T, "degC"), reading=column([1.0, 2.0, 3.0, 1.4, 2.4, 3.4], "deg/h"),
        residual=column([-0.2, -0.2, -0.2, 0.2, 0.2, None], "deg/h"), path=column(["warming"] * 3 + ["cooling"] * 3),
        run=column(["1"] * 3 + ["2"] * 3),
    )  # fmt: skip


def law(test: str = "vacuum", offset: float = 0.0) -> dict[str, Any]:
    bias = offset + np.array([1.2, 2.2, 3.2])
    return curve(
        "thermal_law", test, temperature=column(T, "degC"), bias=column(bias, "deg/h"), u=column([0.05] * 3, "deg/h"),
        dof=column([60.0] * 3), lo=column(bias - 0.1, "deg/h"), hi=column(bias + 0.1, "deg/h"),
        path_difference=column([-0.4] * 3, "deg/h"), path_lo=column([-0.5] * 3, "deg/h"),
        path_hi=column([-0.3] * 3, "deg/h"),
    )  # fmt: skip


def order(axis: str = "x") -> dict[str, Any]:
    columns: dict[str, Any] = {
        "order": column([0, 1, 2]), "error": column([30.0, 0.5, 0.51], "deg/h"), "chosen": column([False, True, False])
    }  # fmt: skip
    return curve("thermal_order", axis=axis, of="runs", **columns)


def start_up(axis: str = "x") -> dict[str, Any]:
    columns: dict[str, Any] = {
        "time": column([0.0, 60.0, 120.0], "s"), "residual": column([3.0, 1.1, 0.1], "deg/h"),
        "fitted": column([3.0, 1.0, 0.3], "deg/h"), "run": column(["1", "1", "2"]), "used": column([False, True, True]),
    }  # fmt: skip
    return curve("start_up", axis=axis, **columns)


def reference(of: str) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "temperature": column(T, "degC"), "voltage": column([2.5, 2.51, 2.52], "V"),
        "fitted": column([2.5, 2.51, 2.52], "V"),
    }  # fmt: skip
    return curve("reference_voltage", of=of, **columns)


def row(quantity: str, value: float, u: float, unit: str = "deg/h") -> dict[str, Any]:
    return {
        "quantity": quantity, "axis": "x", "test": "vacuum", **fields("20 degC"), "value": value, "u": u,
        "unit": unit, "status": "estimated",
    }  # fmt: skip


def overlay(axis: str = "x", vacuum: bool = True) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "temperature": column(T, "degC"), "raw": column([30.0, 20.0, -10.0], "deg/h"),
        "by_temperature": column([5.0, 4.0, None], "deg/h"), "run": column(["6", "6", "7"]),
    }  # fmt: skip
    if vacuum:
        columns["by_temperature_and_pressure"] = column([0.5, -0.4, None], "deg/h")
    return curve("overlay", axis=axis, **columns)


CURVES = [
    overlay(), overlay("y"),
    cells(), law(), law("air", -4.0), order(), order("y"), start_up(), start_up("y"), reference("reference_voltage"),
    reference("temperature_reference_voltage"),
]  # fmt: skip
ROWS = [
    row("path_difference", -0.4, 0.05), row("vacuum_offset", 4.0, 0.08), row("warm_up_change", 3.0, 0.2),
    row("warm_up_time", 60.0, 2.0, "s"),
]  # fmt: skip
SEQUENCE = [{"test": "vacuum", "against": "air"}]
RESULTS: dict[str, Any] = {"curves": CURVES, "results": ROWS, "sequence": SEQUENCE}


def axes_of(name: str) -> list[Axes]:
    figure = on_new_figure(figures()[name].pictures(RESULTS)[0], titled=False)
    figure.draw_without_rendering()
    return figure.axes


def points(ax: Axes, label: str) -> tuple[list[float], list[float]]:
    line = next(one for one in ax.get_lines() if str(one.get_label()).startswith(label))
    return np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist()


def heights(ax: Axes) -> list[tuple[float, float]]:
    """Least and largest of each band."""
    bands = [one for one in ax.collections if isinstance(one, PolyCollection)]
    corners = [np.asarray(path.vertices)[:, 1] for band in bands for path in band.get_paths()]
    return [(round(float(y.min()), 9), round(float(y.max()), 9)) for y in corners]


@pytest.mark.parametrize(
    ("name", "finding"),
    [
        ("thermal", "x: 10 to 30 degC, 2 runs, bias within ±0.1 deg/h; warming minus cooling -0.400 ± 0.050 deg/h"),
        ("thermal_order", "order 1 for x, order 1 for y, by runs held out"),
        ("start_up", "after 2 power-ups: x 3.00 ± 0.20 deg/h; the first 60 s are left out"),
        ("reference_voltage", "reference changes by 0.02 V and temperature reference changes by 0.02 V at most"),
        ("conditions", "against air: x 4.000 ± 0.080 deg/h"),
        ("overlay", "compensation takes the largest bias from 30 to 0.5 deg/h"),
    ],
)
def test_titles_say_the_finding(name: str, finding: str) -> None:
    assert figures()[name].pictures(RESULTS)[0].finding == finding


def test_cells_are_drawn_filled_where_it_warmed_and_hollow_where_it_cooled() -> None:
    above, below = axes_of("thermal")
    assert points(above, "warming") == (T, [1.0, 2.0, 3.0])
    assert points(above, "cooling") == (T, [1.4, 2.4, 3.4])
    assert points(below, "cooling") == (T[:2], [0.2, 0.2])  # one has no residual
    assert points(above, "polynomial") == (T, [1.2, 2.2, 3.2])
    fills = [line.get_markerfacecolor() for line in above.get_lines()[:2]]
    assert fills[1] == "none" != fills[0]
    assert heights(above) == [(1.1, 3.3)]


def test_paths_stand_half_their_difference_apart_from_the_middle() -> None:
    _, below = axes_of("thermal")
    lines = [np.asarray(line.get_ydata()).tolist() for line in below.get_lines() if line.get_zorder() == 5]
    assert lines == [[-0.2] * 3, [0.2] * 3]
    assert heights(below) == [(-0.25, -0.15), (0.15, 0.25)]


def test_cells_without_a_law_of_their_own_are_no_picture() -> None:
    assert figures()["thermal"].pictures({"curves": [cells("vacuum"), law("air")]}) == []


def test_the_order_chosen_is_filled_and_errors_over_decades_are_drawn_over_decades() -> None:
    (ax,) = axes_of("thermal_order")
    assert points(ax, "x") == ([0.0, 1.0, 2.0], [30.0, 0.5, 0.51])
    marked = [line for line in ax.get_lines() if line.get_marker() in ("o", "s")]
    filled = [line for line in marked if line.get_markerfacecolor() != "none"]
    assert [np.asarray(line.get_xdata()).tolist() for line in filled] == [[1.0], [1.0]]
    assert ax.get_yscale() == "log"
    assert ax.get_xticks().tolist() == [0.0, 1.0, 2.0]


def test_an_order_that_the_plan_gives_is_said_to_be_given() -> None:
    given = {"curves": [order() | {"of": "given"}]}
    assert figures()["thermal_order"].pictures(given)[0].finding == "order 1 for x, as the plan says"


def test_start_up_has_a_panel_an_axis_and_shows_what_is_left_out() -> None:
    first, second = axes_of("start_up")
    assert points(first, "left out") == ([0.0], [3.0])
    assert points(second, "used") == ([60.0, 120.0], [1.1, 0.1])
    assert points(second, "fitted") == ([0.0, 60.0, 120.0], [3.0, 1.0, 0.3])


def test_start_up_without_a_transient_says_so() -> None:
    quiet = {"curves": [start_up()], "results": []}
    assert figures()["start_up"].pictures(quiet)[0].finding == "no start-up transient above the noise"


def test_reference_voltages_are_drawn_less_their_mean() -> None:
    first, second = axes_of("reference_voltage")
    np.testing.assert_allclose(points(first, "x")[1], [-0.01, 0.0, 0.01], atol=1e-12)
    assert first.get_ylabel() == "reference [V]"
    assert second.get_ylabel().split() == ["temperature", "reference", "[V]"]


def test_both_conditions_are_drawn_with_their_bands() -> None:
    (ax,) = axes_of("conditions")
    assert points(ax, "vacuum")[1] == [1.2, 2.2, 3.2]
    np.testing.assert_allclose(points(ax, "air")[1], [-2.8, -1.8, -0.8])
    assert heights(ax) == [(1.1, 3.3), (-2.9, -0.7)]


def test_a_test_beside_none_or_beside_another_sensor_has_no_picture_of_conditions() -> None:
    alone = {"curves": CURVES, "sequence": [{"test": "vacuum", "against": None}]}
    assert figures()["conditions"].pictures(alone) == []
    other = {"curves": [law(), law("air") | {"axis": "z"}], "sequence": SEQUENCE}
    assert figures()["conditions"].pictures(other) == []


def test_the_overlay_shows_what_each_step_leaves_and_in_air_there_is_one_step() -> None:
    first, second = axes_of("overlay")
    assert points(first, "raw") == (T, [30.0, 20.0, -10.0])
    assert points(first, "for temperature and pressure")[1][:2] == [0.5, -0.4]
    assert second.get_legend() is not None
    air = figures()["overlay"].pictures({"curves": [overlay(vacuum=False)]})[0]
    assert air.finding == "compensation takes the largest bias from 30 to 5 deg/h"
