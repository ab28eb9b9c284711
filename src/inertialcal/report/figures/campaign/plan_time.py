"""What more time buys: uncertainty of each figure of a planned test by its length, what is wanted, what is chosen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ....core.show.rounding import number, uncertainty
from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.metrics import shortened
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title

NAME = "plan_time"
SHOWS = (
    "Standard uncertainty of each figure by the length of the test in hours; dashed: what is wanted; dot: the test that"
    " is chosen"
)
MOST = 4  # panels
LONGEST = 200.0  # width of the name in a panel [pt]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the picture of a plan."""
    found = [one for one in curves(results, NAME) if len(finite(numbers(one, "u"))) > 1][:MOST]
    if not found:
        return []
    test = str(found[0].get("test", ""))
    heights = tuple(1.25 for _ in found)
    return [Picture(NAME, test, "", finding(found), SHOWS, heights, partial(draw, found), data=found)]


def finding(found: Sequence[Curve]) -> str:
    """Return the finding: the length that is chosen, and what it gives of the figure that was wanted."""
    one = next((one for one in found if "wanted" in one["columns"]), found[0])
    at = np.flatnonzero(flags(one, "chosen"))
    if not len(at):
        return "Uncertainty by the length of the test"
    time, u = numbers(one, "time")[at[0]], numbers(one, "u")[at[0]]
    return f"{number(time, 3)} h give {plain(one.get('of', ''))} to {uncertainty(u)} {plain(unit(one, 'u'))}"


def draw(found: Sequence[Curve], axes: Sequence[Axes], title: str) -> None:
    """Draw a panel a figure."""
    handles: dict[str, Line2D] = {}
    for k, (one, ax) in enumerate(zip(found, axes, strict=True)):
        time, u, chosen = numbers(one, "time"), numbers(one, "u"), flags(one, "chosen")
        name = shortened(plain(one.get("of", "")), TEXT - 1.0, LONGEST)
        ax.plot(time, u, color=COLOURS["blue"], label=name, zorder=2)
        shown = u
        if "wanted" in one["columns"]:
            wanted = numbers(one, "wanted")
            (handles["wanted"],) = ax.plot(time, wanted, "--", color=COLOURS["vermilion"], label="wanted", zorder=1)
            shown = np.append(u, wanted)
        (handles["chosen"],) = ax.plot(time[chosen], u[chosen], "o", linestyle="none", color=COLOURS["blue"],
                                       markersize=6.0, label="chosen", zorder=3)  # fmt: skip
        log_axis(ax, "y", shown, 1.6)
        log_axis(ax, "x", time, 1.1)
        set_labels(ax, "length of the test [h]" if ax is axes[-1] else "", f"u [{plain(unit(one, 'u'))}]")
        ax.text(0.99, 0.95, name, transform=ax.transAxes, ha="right", va="top", fontsize="small")
        if k == 0:
            set_title(ax, title)
    line = Line2D([], [], color=COLOURS["blue"], label="what the test gives")
    set_legend(axes[-1], [line, *handles.values()])


__all__ = ["draw", "finding", "pictures"]
