"""Figures of the environment in orbit: titles with numbers of the curves, what is drawn where."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from inertialcal.report.figures import figures, on_new_figure
from inertialcal.report.figures.microgravity import spectrogram


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, axis: str = "rss", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": "station", "axis": axis, "recording": "", "of": "", "columns": columns}


def bands(axis: str, **more: Any) -> dict[str, Any]:
    ug = {"rms": [5.0, 20.0, 9.0], "u": [0.5, 1.0, 0.4], "interval_low": [4.1, 18.1, 8.3],
          "interval_high": [6.2, 22.3, 9.9],
          "block_least": [2.0, 12.0, 7.0], "block_median": [5.0, 19.0, 9.0], "block_95": [8.0, 27.0, 11.0],
          "block_largest": [9.0, 30.0, 12.0], "own_noise": [0.2, 0.3, 0.4]}  # fmt: skip
    return curve(
        "microgravity_bands", axis, frequency=column([1.0, 1.25, 1.6], "Hz"), low=column([0.891, 1.122, 1.413], "Hz"),
        high=column([1.122, 1.413, 1.778], "Hz"), dof=column([90.0, 200.0, 250.0]),
        **{name: column(values, "ug") for name, values in ug.items()}, **more,
    )  # fmt: skip


CURVES = [
    bands("x"),
    bands("rss", limit=column([16.0, 20.0, None], "ug")),
    *(
        curve("microgravity_intervals", axis, time=column([5.0, 15.0, 75.0, 85.0], "s"),
              least=column([-9.0, -8.0, -20.0, -8.0], "ug"), largest=column([9.0, 8.0, 31.0, 8.0], "ug"),
              mean=column([0.1, -0.2, 0.4, 0.0], "ug"), rms=column([3.0, 3.0, 5.0, 3.0], "ug"),
              after_gap=column([False, False, True, False]))
        for axis in "xyz"
    ),
    curve("microgravity_cumulative", frequency=column([1.0, 2.0, 4.0, 8.0], "Hz"),
          rms=column([0.0, 3.0, 4.0, 5.0], "ug")),
    curve("microgravity_spectrogram", time=column([50.0] * 3 + [100.0] * 3, "s"),
          frequency=column([1.0, 3.0, 5.0] * 2, "Hz"), density=column([1.0, 50.0, 2.0, 2.0, 900.0, None], "ug^2/Hz")),
    curve("microgravity_slow", "", time=column([50.0, 150.0, 250.0], "s"),
          **{name: column(values, "ug") for axis in "xyz"
             for name, values in ((axis, [0.1, 0.4, -0.2]), (f"u_{axis}", [0.1] * 3))}),
    curve("microgravity_orbits", "", time=column([100.0, 200.0], "s"),
          **{axis: column([0.2, 0.1], "ug") for axis in "xyz"}),
]  # fmt: skip


def drawn(name: str, which: int = 0) -> tuple[str, list[Axes]]:
    picture = figures()[name].pictures({"curves": CURVES, "results": []})[which]
    figure = on_new_figure(picture, titled=False)
    figure.draw_without_rendering()
    return picture.finding, list(figure.axes)


def test_bands_of_all_axes_come_first_with_the_requirement() -> None:
    finding, (ax,) = drawn("microgravity_bands")
    assert finding == "All axes: 1 of the curve at 1.25 Hz"
    legend = ax.get_legend()
    labels = [] if legend is None else [text.get_text() for text in legend.get_texts()]
    assert "requirement" in labels
    finding, (ax,) = drawn("microgravity_bands", 1)
    assert finding == "x: highest at 1.25 Hz, 20 ug"


def test_no_line_goes_across_a_gap_of_the_display() -> None:
    finding, axes = drawn("microgravity_intervals")
    assert finding == "Widest: x, 51 ug from least to largest at 75 s"
    assert len(axes) == 3
    mean = np.asarray(axes[0].get_lines()[0].get_ydata(), dtype=float)
    assert np.isnan(mean[2])
    assert mean[3] == 0.4


def test_the_cumulative_level_says_where_half_of_its_power_lies() -> None:
    finding, (ax,) = drawn("microgravity_cumulative")
    assert finding == "5 ug up to 8 Hz, half of its power below 4 Hz"
    assert np.asarray(ax.get_lines()[0].get_ydata()).tolist() == [0.0, 3.0, 4.0, 5.0]


def test_cells_of_the_spectrogram_stand_where_they_belong() -> None:
    (given,) = (one for one in CURVES if one["name"] == "microgravity_spectrogram")
    time, frequency, density = spectrogram.grid(given)
    assert (time.tolist(), frequency.tolist(), density.shape) == ([50.0, 100.0], [1.0, 3.0, 5.0], (2, 3))
    finding, (ax,) = drawn("microgravity_spectrogram")
    assert finding == "Highest density at 3 Hz; shades in ug^2/Hz"
    darkest = max(ax.patches, key=lambda one: float(one.get_alpha() or 0.0))
    assert darkest.get_path().get_extents().bounds == (75.0, 2.0, 50.0, 2.0)


def test_blocks_and_orbits_of_the_slow_acceleration() -> None:
    finding, axes = drawn("microgravity_slow")
    assert finding == "Slow acceleration: x moves most, by 0.6 ug"
    assert len(axes) == 3
