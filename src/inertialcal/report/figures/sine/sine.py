"""A known drive in drift: readings with their drift, what is left without it, and its line among those beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.results import case_of
from ....core.show.rounding import number, with_uncertainty
from ....core.units import factor
from ..drawing.data import Curve, curves, finite, numbers, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "sine"
SHOWS = (
    "Above, readings over time with the drift that was fitted; in the middle, the readings without it and the line;"
    " below, amplitude over frequency: the line of the drive and its neighbours"
)
HEIGHTS = (2.2, 2.2, 2.2)  # of the panels [in]
HOURS, MINUTES = 7200.0, 300.0  # [s] from which time is shown in them
POINTS = 400  # readings from which they are joined
ROLES: dict[str, tuple[str, dict[str, Any]]] = {
    "other": ("other lines", {"color": COLOURS["quiet"], "marker": ".", "markersize": 4.0}),
    "side_band": ("neighbours", {"color": COLOURS["orange"], "marker": "s", "markersize": 3.6}),
    "drive": ("the drive", {"color": COLOURS["vermilion"], "marker": "o", "markersize": 5.0}),
}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis."""
    lines = {(one.get("test", ""), one.get("axis", "")): one for one in curves(results, "sine_lines")}
    found = []
    for series in curves(results, "sine_series"):
        key = (series.get("test", ""), series.get("axis", ""))
        if key in lines and len(finite(numbers(series, "reading"))) and len(finite(numbers(lines[key], "amplitude"))):
            found.append(_picture(results, series, lines[key]))
    return found


def _picture(results: Mapping[str, Any], series: Curve, lines: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, series, lines, title)

    test, axis = str(series.get("test", "")), str(series.get("axis", ""))
    return Picture(NAME, test, axis, finding(results, test, axis), SHOWS, HEIGHTS, paint, share_x=False)


def finding(results: Mapping[str, Any], test: str, axis: str) -> str:
    """Return the finding: the amplitude with its uncertainty, or its upper limit."""
    row = next((one for one in results.get("results", []) if one["quantity"] == "amplitude"
                and one["axis"] == axis and one["test"] == test and case_of(one).plain), None)  # fmt: skip
    if row is None or row["value"] is None:
        return f"{plain(axis)}: no amplitude"
    if row["status"] == "upper_limit":
        return f"{plain(axis)}: no line found, amplitude below {number(row['value'], 2)} {plain(row['unit'])}"
    return f"{plain(axis)}: amplitude {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}"


def draw(axes: Sequence[Axes], series: Curve, lines: Curve, title: str = "") -> None:
    """Draw series and lines.

    Parameters
    ----------
    axes : sequence of Axes, length 3
        The first two over time.
    series, lines : mapping
        ``sine_series``, its time in seconds, and ``sine_lines``, its frequency in hertz.
    title : str
        Above the first; empty for none.
    """
    above, middle, below = axes
    seconds = numbers(series, "time")
    word = "h" if seconds[-1] > HOURS else "min" if seconds[-1] > MINUTES else "s"
    time = seconds * factor("s", word)
    joined = len(time) > POINTS
    look: dict[str, Any] = {"linewidth": 0.5} if joined else {"linestyle": "none", "marker": "o", "markersize": 2.6}
    above.plot(time, numbers(series, "reading"), color=COLOURS["blue"], label="readings", **look)
    above.plot(time, numbers(series, "drift"), color=COLOURS["ink"], linewidth=1.2, label="drift")
    middle.plot(time, numbers(series, "without_drift"), color=COLOURS["blue"], label="without drift", **look)
    if not joined:
        middle.plot(time, numbers(series, "line"), color=COLOURS["vermilion"], linewidth=0.9, label="line", zorder=1)
    _draw_lines(below, lines)
    set_title(above, title)
    set_labels(above, f"time [{word}]", with_unit("reading", unit(series, "reading")))
    set_labels(middle, f"time [{word}]", with_unit("without drift", unit(series, "reading")))
    for axis in axes:
        set_legend(axis)


def _draw_lines(ax: Axes, lines: Curve) -> None:
    scale, shown = (1e3, "mHz") if float(np.nanmax(numbers(lines, "frequency"))) < 1.0 else (1.0, "Hz")
    frequency, amplitude = numbers(lines, "frequency") * scale, numbers(lines, "amplitude")
    role = np.array(words(lines, "role"))
    for name, (label, look) in ROLES.items():
        mine = role == name
        if mine.any():
            ax.vlines(frequency[mine], 0.0, amplitude[mine], color=look["color"], linewidth=1.0, zorder=2)
            ax.plot(frequency[mine], amplitude[mine], linestyle="none", label=label, zorder=3, **look)
    ax.set_ylim(bottom=0.0)
    set_labels(ax, f"frequency [{shown}]", with_unit("amplitude", unit(lines, "amplitude")))


__all__ = ["NAME", "draw", "finding", "pictures"]
