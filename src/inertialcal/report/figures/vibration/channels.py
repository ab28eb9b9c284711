"""Density of each channel of a run at full level, control channels and responses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "vibration_channels"
SHOWS = "Density over frequency, both logarithmic, a line a channel"
HEIGHT = 2.8  # of the panel [in]
LOOKS = (("blue", "-"), ("sky", (0, (4, 1))), ("green", (0, (1, 1))), ("orange", "-"), ("purple", (0, (4, 1))),
         ("vermilion", (0, (4, 1, 1, 1))), ("ink", (0, (1, 2))))  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run and unit."""
    known = curves(results, "vibration_channel")
    found = []
    for test, spoken in dict.fromkeys((str(one.get("test", "")), unit(one, "density")) for one in known):
        mine = [one for one in known if (one.get("test", ""), unit(one, "density")) == (test, spoken)]
        found.append(_picture(test, mine))
    return found


def _picture(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, title)

    return Picture(NAME, test, str(mine[0].get("axis", "")), finding(mine), SHOWS, (HEIGHT,), paint, data=mine)


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: where the highest density lies, and of which channel."""
    peaks = [(float(np.nanmax(numbers(one, "density"))), one) for one in mine]
    _, highest = max(peaks, key=lambda pair: pair[0])
    at = float(numbers(highest, "frequency")[int(np.nanargmax(numbers(highest, "density")))])
    return f"Highest density: {plain(highest.get('axis', ''))} at {number(at, 3)} Hz"


def draw(ax: Axes, mine: Sequence[Curve], title: str = "") -> None:
    """Draw the densities of channels."""
    for place, curve in enumerate(mine):
        colour, stroke = LOOKS[place % len(LOOKS)]
        density = numbers(curve, "density")
        ax.plot(numbers(curve, "frequency"), np.where(density > 0.0, density, np.nan), color=COLOURS[colour],
                linestyle=stroke, linewidth=0.9, label=plain(curve.get("axis", "")))  # fmt: skip
    log_axis(ax, "x", np.concatenate([numbers(one, "frequency") for one in mine]), 1.05)
    every = np.concatenate([finite(numbers(one, "density")) for one in mine])
    log_axis(ax, "y", every[every > 1e-7 * every.max()], 1.6)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", unit(mine[0], "frequency")), with_unit("density", unit(mine[0], "density")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
