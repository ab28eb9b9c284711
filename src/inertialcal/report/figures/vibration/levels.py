"""Level of the control over time against full level; shaded is what chance does to a window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, flags, numbers
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, set_labels, set_legend, set_title

NAME = "vibration_levels"
SHOWS = "Level of each window over time, in decibels against full level; shaded is what chance does at full level"
HEIGHT = 2.2  # of the panel [in]
LOWEST = -24.0  # that is shown [dB]
TWO = 2.0  # standard deviations


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [_picture(one) for one in curves(results, "vibration_levels")]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve), SHOWS, (HEIGHT,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: how long full level was held."""
    time, full = numbers(curve, "time"), flags(curve, "full")
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    return f"{number(step * int(full.sum()), 4)} s at full level"


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the level over time."""
    time, level, full = numbers(curve, "time"), numbers(curve, "level"), flags(curve, "full")
    chance = TWO * float(np.nanmedian(numbers(curve, "chance")))
    ax.axhspan(-chance, chance, color=COLOURS["sky"], alpha=0.35, linewidth=0.0, zorder=1, label="chance, two sigma")
    shown = np.maximum(level, LOWEST)
    ax.plot(time, np.where(full, np.nan, shown), color=COLOURS["orange"], marker=".", markersize=3.0, linewidth=0.7,
            zorder=2, label="not used")  # fmt: skip
    ax.plot(time, np.where(full, shown, np.nan), color=COLOURS["blue"], linewidth=0.8, zorder=3, label="full level")
    low = min(float(finite(shown).min()), -3.0)
    ax.set_ylim(1.1 * low, max(1.5, 1.2 * float(finite(shown).max())))
    set_title(ax, title)
    set_labels(ax, "time [s]", "level [dB]")
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
