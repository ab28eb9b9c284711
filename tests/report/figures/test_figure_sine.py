"""The figure of a known drive draws what is given, and says the amplitude or its limit."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from inertialcal.report.figures import figures
from inertialcal.report.figures.sine.sine import draw
from written_rows import fields

TIME = 120.0 * np.arange(12)
LINE = np.tile([0.0, 0.2, 0.0, -0.2], 3)


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": list(values)}


def curves_of(axis: str = "x", test: str = "t") -> list[dict[str, Any]]:
    rates = {"reading": LINE + 1.0, "drift": np.ones(12), "without_drift": LINE, "line": LINE}
    series = {"time": column(TIME, "s"), **{name: column(values, "1/s") for name, values in rates.items()}}
    lines = {
        "frequency": column([0.001, 0.002, 0.003, 0.004], "Hz"), "amplitude": column([0.01, 0.2, 0.03, 0.04], "1/s"),
        "role": column(["side_band", "drive", "side_band", "other"]),
    }  # fmt: skip
    head = {"test": test, "axis": axis}
    return [{"name": "sine_series", **head, "columns": series}, {"name": "sine_lines", **head, "columns": lines}]


def row(status: str = "estimated") -> dict[str, Any]:
    found = {"quantity": "amplitude", "axis": "x", "test": "t", **fields(), "unit": "1/s", "status": status}
    return found | ({"value": 0.05, "u": None} if status == "upper_limit" else {"value": 0.2, "u": 0.02})


def test_panels_show_what_is_given() -> None:
    axes = list(Figure().subplots(3))
    series, lines = curves_of()
    draw(axes, series, lines)
    above, middle, below = ([np.asarray(one.get_ydata()).tolist() for one in ax.get_lines()] for ax in axes)
    assert above == [(LINE + 1.0).tolist(), [1.0] * 12]
    assert middle == [LINE.tolist(), LINE.tolist()]
    assert below == [[0.04], [0.01, 0.03], [0.2]]
    assert np.asarray(axes[2].get_lines()[2].get_xdata()).tolist() == [2.0]
    assert [ax.get_xlabel() for ax in axes] == ["time [min]", "time [min]", "frequency [mHz]"]


def test_finding_is_the_amplitude_or_its_limit() -> None:
    found = [figures()["sine"].pictures({"curves": curves_of(), "results": rows})[0].finding
             for rows in ([row()], [row("upper_limit")], [])]  # fmt: skip
    assert found == ["x: amplitude 0.200 ± 0.020 1/s", "x: no line found, amplitude below 0.05 1/s", "x: no amplitude"]
