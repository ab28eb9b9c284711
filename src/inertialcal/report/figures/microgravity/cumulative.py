"""Root mean square of all frequencies up to each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, distinct, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "microgravity_cumulative"
SHOWS = "Root mean square up to each frequency, which is logarithmic"
HEIGHT = 2.4  # of the panel [in]
LOOKS: Mapping[str, tuple[str, Any]] = {"x": ("blue", "-"), "y": ("orange", (0, (5, 1))), "z": ("green", (0, (2, 1))),
                                        "rss": ("ink", "-")}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    known = curves(results, NAME)
    return [_picture(test, [one for one in known if str(one.get("test", "")) == test])
            for test in distinct(str(one.get("test", "")) for one in known)]  # fmt: skip


def _picture(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, title)

    return Picture(NAME, test, "", finding(mine), SHOWS, (HEIGHT,), paint, data=mine)


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: below which frequency half of the power lies."""
    curve = mine[-1]
    rms, frequency = numbers(curve, "rms"), numbers(curve, "frequency")
    at = int(np.searchsorted(rms, rms[-1] / np.sqrt(2.0)))
    whole = f"{number(float(rms[-1]), 3)} {plain(unit(curve, 'rms'))}"
    half, top = (number(float(one), 3) for one in (frequency[at], frequency[-1]))
    return f"{whole} up to {top} Hz, half of its power below {half} Hz"


def draw(ax: Axes, mine: Sequence[Curve], title: str = "") -> None:
    """Draw a line an axis."""
    for curve in mine:
        axis = str(curve.get("axis", ""))
        colour, stroke = LOOKS.get(axis, ("purple", "-"))
        name = "all axes" if axis == "rss" else plain(axis)
        ax.plot(numbers(curve, "frequency"), numbers(curve, "rms"), color=COLOURS[colour], linestyle=stroke, label=name)
    log_axis(ax, "x", np.concatenate([numbers(one, "frequency") for one in mine]), 1.02)
    ax.set_ylim(bottom=0.0)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", "Hz"), with_unit("rms up to it", unit(mine[0], "rms")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
