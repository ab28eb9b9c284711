"""Control chart of a quantity over units or lots: figures with their limits, and the spread below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from ....core.estimate import Array
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "trend"
SHOWS = (
    "Figures in order of time with mean and limits of three standard deviations; below, the moving range, or the"
    " standard deviation in each lot, with its limits"
)
HEIGHTS = (2.2, 1.1)  # [in]


@dataclass(frozen=True, eq=False)
class Drawn:
    """What is drawn; all columns are equally long, by point."""

    what: str  # Figure, in words
    unit: str
    finding: str
    of: str  # What a point is: ``"unit"``, ``"lot"``
    values: Array
    centre: float
    lower: Array
    upper: Array
    signal: NDArray[np.bool_]
    spread: Array
    spread_lower: Array
    spread_upper: Array


def picture(drawn: Drawn) -> Picture:
    """Return the picture of one chart."""
    x = np.arange(1, drawn.values.size + 1)

    def paint(axes: Sequence[Axes], title: str) -> None:
        top, below = axes
        limits: dict[str, Any] = {"color": COLOURS["vermilion"], "ls": "--", "lw": 1.0, "where": "mid"}
        top.plot(x, drawn.values, ".-", color=COLOURS["blue"], lw=0.6, ms=4.0, label=f"a {drawn.of}")
        top.axhline(drawn.centre, color=COLOURS["quiet"], lw=1.0, label="mean")
        top.step(x, drawn.lower, label="limits", **limits)
        top.step(x, drawn.upper, **limits)
        at = drawn.signal
        top.plot(x[at], drawn.values[at], "s", color=COLOURS["vermilion"], ms=5.0, label="signal")
        set_title(top, title)
        set_labels(top, "", with_unit(plain(drawn.what), drawn.unit))
        below.plot(x, drawn.spread, ".-", color=COLOURS["blue"], lw=0.6, ms=4.0)
        known = np.isfinite(drawn.spread)  # the first unit has no range
        below.step(x[known], drawn.spread_upper[known], **limits)
        if (drawn.spread_lower > 0.0).any():
            below.step(x[known], drawn.spread_lower[known], **limits)
        below.xaxis.set_major_locator(MaxNLocator(integer=True))
        spread = "range" if drawn.of == "unit" else "std"  # moving, in a lot: the panel is low
        set_labels(below, f"{drawn.of}, in order of time", with_unit(spread, drawn.unit))
        set_legend(below, top.get_legend_handles_labels()[0])

    return Picture(NAME, "", "", drawn.finding, SHOWS, HEIGHTS, paint)
