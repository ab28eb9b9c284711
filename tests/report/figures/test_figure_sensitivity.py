"""Figures of a sensitivity test draw the levels, laws and power-ups given, and say in the title what they show."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure
from written_rows import fields

SUPPLY = [4.8, 5.0, 5.2]
RUNS = ["1", "1", "1", "2", "2", "2"]


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": list(values)}


def curve(name: str, of: str = "", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "steps", "axis": "x", "of": of, "columns": columns}


def law(of: str = "supply", unit: str = "V") -> dict[str, Any]:
    bias = np.array([-0.2, 0.0, 0.2])
    return curve(
        "sensitivity", of, condition=column(SUPPLY, unit), bias=column(bias, "deg/s"),
        lo=column(bias - 0.05, "deg/s"), hi=column(bias + 0.05, "deg/s"),
    )  # fmt: skip


def levels(of: str = "supply", unit: str = "V", runs: list[str] = RUNS) -> dict[str, Any]:
    return curve(
        "sensitivity_levels", of, condition=column(SUPPLY * 2, unit), run=column(runs),
        reading=column([-0.21, 0.01, 0.2, -0.19, 0.0, None], "deg/s"),
    )  # fmt: skip


def residuals() -> dict[str, Any]:
    return curve(
        "sensitivity_residuals", level=column(range(1, 7)), time=column([0.0, 60.0, 120.0] * 2, "s"),
        residual=column([0.03, -0.04, 0.0, 0.0, 0.0, None], "deg/s"), run=column(RUNS),
    )  # fmt: skip


def power_up(run: str) -> dict[str, Any]:
    return curve(
        "warm_up_joint", run, time=column([0.0, 60.0, 120.0], "s"), reading=column([0.3, None, 0.1], "deg/s"),
        model=column([0.3, 0.2, 0.1], "deg/s"),
    )  # fmt: skip


def row(quantity: str, value: float, u: float | None, unit: str, power: int = 0, **more: Any) -> dict[str, Any]:
    return {
        "quantity": quantity, "axis": "x", "test": "steps", **fields(), "power": power, "value": value, "u": u,
        "unit": unit, "status": "estimated",
    } | more  # fmt: skip


def by_pressure() -> dict[str, Any]:
    return curve(
        "pressure_levels", pressure=column([0.1, 10.0, 1e5], "Pa"), change=column([0.0, 0.02, 0.3], "deg/s"),
        lo=column([0.0, 0.01, 0.2], "deg/s"), hi=column([0.0, 0.03, 0.4], "deg/s"),
    )  # fmt: skip


CURVES = [law(), levels(), residuals(), power_up("1"), power_up("2"), by_pressure()]
ROWS = [
    row("bias_supply", 1.0, 0.1, "deg/s/V"), row("bias_warm_up", 0.3, 0.02, "deg/s", 1),
    row("warm_up_time", 120.0, 7.0, "s", 1, axis=""),
    row("bias_change", 0.02, 0.005, "deg/s"), row("bias_change", 0.3, 0.05, "deg/s"),
]  # fmt: skip
RESULTS: dict[str, Any] = {"curves": CURVES, "results": ROWS}


def drawn(name: str, results: dict[str, Any] = RESULTS) -> list[Axes]:
    figure = on_new_figure(figures()[name].pictures(results)[0], titled=True)
    figure.draw_without_rendering()
    return figure.axes


def finding(name: str, results: dict[str, Any] = RESULTS) -> str:
    return figures()[name].pictures(results)[0].finding


def points(ax: Axes, label: str) -> tuple[list[float], list[float]]:
    (line,) = [one for one in ax.get_lines() if one.get_label() == label]
    return np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist()


def test_levels_and_fit_are_those_given() -> None:
    (ax,) = drawn("sensitivity")
    assert points(ax, "fit, 95 % band") == (SUPPLY, [-0.2, 0.0, 0.2])
    assert points(ax, "1") == (SUPPLY, [-0.21, 0.01, 0.2])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("supply [V]", "x bias [deg/s]")
    (band,) = ax.collections
    assert np.ptp(np.asarray(band.get_paths()[0].vertices)[:, 1]) == pytest.approx(0.5)


def of(one: dict[str, Any], axis: str) -> dict[str, Any]:
    return one | {"axis": axis}


def test_a_condition_has_a_picture_and_each_sensor_a_panel() -> None:
    laws = [of(one, axis) for axis in "xy" for one in (law(), levels(), law("pressure", "Pa"), levels("pressure"))]
    first, second = figures()["sensitivity"].pictures({"curves": laws})
    assert (len(first.heights), len(second.heights), first.note, second.note) == (2, 2, ("supply",), ("pressure",))
    assert (first.axis, second.axis, len(first.data)) == ("supply", "pressure", 4)
    warm_ups = [of(power_up(run), axis) for axis in "xy" for run in "12"]
    assert [ax.get_ylabel() for ax in drawn("sensitivity_warm_up", {"curves": warm_ups})] == ["x [deg/s]", "y [deg/s]"]
    assert len(drawn("sensitivity_residuals", {"curves": [of(residuals(), axis) for axis in "xyz"]})) == 3


def test_many_power_ups_have_one_entry_of_the_legend() -> None:
    many = levels()
    for one in many["columns"].values():
        one["values"] = one["values"] * 2
    many["columns"]["run"]["values"] = [f"{i}" for i in range(12)]
    (ax,) = drawn("sensitivity", {"curves": [law(), many]})
    legend = ax.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["fit, 95 % band", "levels of a power-up"]


def test_a_law_without_its_levels_is_not_drawn() -> None:
    assert figures()["sensitivity"].pictures({"curves": [law(), levels("pressure")]}) == []


def test_titles_say_what_was_found_or_not_seen() -> None:
    assert finding("sensitivity") == "Bias by supply: x 1.00 ± 0.10 deg/s/V"
    assert finding("sensitivity_warm_up") == "Bias at power-up: 0.300 ± 0.020 deg/s on x; time constant 120.0 ± 7.0 s"
    assert finding("sensitivity_residuals") == "Levels of 2 power-ups scatter about the fit by x 0.022 deg/s"
    less = [one | {"status": "upper_limit", "u": None} for one in ROWS]
    assert finding("sensitivity", RESULTS | {"results": less}) == "Bias by supply: x below 1 deg/s/V"
    assert finding("sensitivity_warm_up", RESULTS | {"results": less}) == "No warm-up seen: below 0.3 deg/s on x"
    assert finding("sensitivity_pressure") == "Largest change from the lowest pressure: x 0.300 ± 0.050 deg/s"
    assert finding("sensitivity_pressure", RESULTS | {"results": []}) == "x: bias by level of pressure"
    assert finding("sensitivity", RESULTS | {"results": []}) == "x: bias against supply"
    assert finding("sensitivity_warm_up", RESULTS | {"results": []}) == "x: warm-up not estimated"


def test_levels_of_pressure_are_drawn_over_decades_with_their_intervals() -> None:
    (ax,) = drawn("sensitivity_pressure")
    assert ax.get_xscale() == "log"
    (drawn_at,) = ax.containers
    assert np.asarray(drawn_at.lines[0].get_ydata()).tolist() == [0.0, 0.02, 0.3]  # type: ignore[attr-defined]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("pressure [Pa]", "x change [deg/s]")


def test_power_ups_are_drawn_with_their_fit() -> None:
    (ax,) = drawn("sensitivity_warm_up")
    assert points(ax, "1")[0] == [0.0, 60.0, 120.0]
    assert points(ax, "joint fit") == ([0.0, 60.0, 120.0], [0.3, 0.2, 0.1])


def test_residuals_stand_apart_by_power_up() -> None:
    (ax,) = drawn("sensitivity_residuals")
    assert [label.get_text() for label in ax.get_xticklabels()] == ["1", "2"]
    first, second = ax.get_lines()[:2]
    assert np.asarray(first.get_xdata()).tolist() == [0, 1, 2]
    assert np.asarray(second.get_xdata()).tolist() == [4, 5, 6]


@pytest.mark.parametrize(("count", "named"), [(3, False), (60, False), (2, True)])
def test_power_ups_without_room_for_their_names_are_numbered(count: int, named: bool) -> None:
    one = residuals()
    runs = [f"power-up {i}, of six hours" for i in range(count)] if count > 2 else ["cold", "warm"]
    one["columns"]["run"]["values"] = [run for run in runs for _ in range(6)]
    for name in ("level", "time", "residual"):
        one["columns"][name]["values"] = one["columns"][name]["values"] * count
    (ax,) = drawn("sensitivity_residuals", {"curves": [one]})
    shown = [label.get_text() for label in ax.get_xticklabels()]
    assert shown[0] == ("cold" if named else "1")
    assert len(shown) <= 20
    assert "numbered" in ax.get_xlabel() or named
