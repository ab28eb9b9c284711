"""Chance of a PASS over the duration of a run, a line a resolution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, numbers
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title

NAME = "vibration_plan"
SHOWS = "Chance of a PASS over the duration at full level, for several resolutions"
HEIGHT = 2.6  # of the panel [in]
LOOKS = (("blue", "-"), ("orange", (0, (4, 1))), ("green", (0, (1, 1))), ("purple", (0, (4, 1, 1, 1))))


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the picture of a plan."""
    known = curves(results, NAME)
    return [_picture(results, known)] if known else []


def _picture(results: Mapping[str, Any], known: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], known, title)

    return Picture(NAME, str(known[0].get("test", "")), "", finding(results), SHOWS, (HEIGHT,), paint, data=known)


def finding(results: Mapping[str, Any]) -> str:
    """Return the finding: the shortest run that has the wanted chance."""
    rows = [one for one in results.get("results", []) if one["quantity"] == "duration_needed"
            and one["value"] is not None]  # fmt: skip
    if not rows:
        return "No duration gives the wanted chance"
    best = min(rows, key=lambda row: float(row["value"]))
    return f"{number(best['value'], 3)} s are enough at {number(best['at']['value'], 3)} Hz resolution"


def draw(ax: Axes, known: Sequence[Curve], title: str = "") -> None:
    """Draw the chances."""
    duration = numbers(known[0], "duration")
    for place, curve in enumerate(known):
        colour, stroke = LOOKS[place % len(LOOKS)]
        ax.plot(duration, 100.0 * numbers(curve, "chance"), color=COLOURS[colour], linestyle=stroke,
                label=plain(curve.get("of", "")))  # fmt: skip
    ax.axhline(100.0 * float(np.nanmedian(numbers(known[0], "wanted"))), color=COLOURS["ink"], linewidth=0.9,
               linestyle=(0, (2, 2)), label="wanted")  # fmt: skip
    log_axis(ax, "x", duration, 1.05)
    ax.set_ylim(0.0, 104.0)
    set_title(ax, title)
    set_labels(ax, "duration at full level [s]", "chance of PASS [%]")
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
