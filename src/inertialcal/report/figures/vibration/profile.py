"""A profile on logarithmic axes: its nodes, the slope of each segment, where a stated slope would lead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "vibration_profile"
SHOWS = "Density over frequency, both logarithmic: nodes, and the slope of each segment in decibels an octave"
HEIGHT = 2.8  # of the panel [in]
LABELLED = 8  # segments, up to which each has its slope written at it


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the picture of a profile."""
    return [_picture(results, one) for one in curves(results, NAME)]


def _picture(results: Mapping[str, Any], curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(NAME, str(curve.get("test", "")), "", finding(results, curve), SHOWS, (HEIGHT,), paint)


def finding(results: Mapping[str, Any], curve: Curve) -> str:
    """Return the finding: the overall level, and whether slopes and levels agree."""
    row = next((one for one in results.get("results", []) if one["quantity"] == "acceleration_rms"), None)
    overall = "" if row is None else f"{number(row['value'], 4)} {row['unit']} overall"
    wrong = "; a stated slope does not fit the levels" if "by_slopes" in curve["columns"] else ""
    return f"{overall or 'Profile'}{wrong}"


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw a profile."""
    frequency, density = numbers(curve, "frequency"), numbers(curve, "density")
    ax.plot(frequency, density, color=COLOURS["blue"], marker="o", markersize=4.0, label="by its levels")
    every = frequency
    if "by_slopes" in curve["columns"]:
        moved = numbers(curve, "by_slopes")
        ax.plot(moved, density, color=COLOURS["vermilion"], linestyle=(0, (4, 2)), marker="s", markersize=3.0,
                linewidth=1.0, label="by the stated slope")  # fmt: skip
        every = np.concatenate([frequency, moved])
    if len(frequency) - 1 <= LABELLED:
        for (a, b), (s, t) in zip(pairwise(frequency.tolist()), pairwise(density.tolist()), strict=True):
            if b > a:
                slope = 10.0 * np.log10(t / s) / np.log2(b / a)
                ax.annotate(f"{slope:+.2f}", (np.sqrt(a * b), np.sqrt(s * t)), xytext=(0, 7), ha="center",
                            textcoords="offset points", fontsize=9, color=COLOURS["quiet"],
                            bbox={"facecolor": COLOURS["paper"], "edgecolor": "none", "pad": 1.0})  # fmt: skip
    log_axis(ax, "x", every, 1.1)
    log_axis(ax, "y", density, 1.6)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", "Hz"), with_unit("density", unit(curve, "density")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
