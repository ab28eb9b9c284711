"""What the magnitude of the field leaves: mean and standard deviation of each arc."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "magnetometer_residuals"
SHOWS = "Magnitude of the field as read, bias taken off, less that of the model: mean of each arc"
HEIGHT = 2.6  # of the panel [in]
NANO = 1e9


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "mean"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    spread = float(np.sqrt(np.mean(numbers(curve, "mean") ** 2))) * _factor(curve)
    finding = f"Means of arcs lie {number(spread, 2)} nT (rms) from the model"
    return Picture(NAME, str(curve.get("test", "")), "", finding, SHOWS, (HEIGHT,), paint)


def _factor(curve: Curve) -> float:
    return NANO if curve["columns"]["mean"]["unit"] == "T" else 1.0


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the means with the standard deviation of the readings of each arc.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``magnetometer_residuals``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    minutes, factor = numbers(curve, "time") / 60.0, _factor(curve)
    mean, deviation = numbers(curve, "mean") * factor, numbers(curve, "deviation") * factor
    ax.axhline(0.0, color=COLOURS["ink"], linewidth=0.8, zorder=1)
    ax.errorbar(minutes, mean, deviation, linestyle="none", marker="o", markersize=4.0, linewidth=1.0,
                color=COLOURS["blue"], label="mean of an arc; bar: standard deviation of its readings")  # fmt: skip
    set_title(ax, title)
    set_labels(ax, with_unit("time", "min"), with_unit("as read less model", "nT"))
    set_legend(ax)
