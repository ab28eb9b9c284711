"""How the heading of an alignment forms over the time that each position lasts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "alignment_forming"
SHOWS = "Heading of the first position by the first part of each, over the length of this part; band: 95 % at the end"
HEIGHT = 2.6  # of the panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "heading"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    half = 0.5 * float(numbers(curve, "hi")[-1] - numbers(curve, "lo")[-1])
    end, shown = float(numbers(curve, "heading")[-1]), plain(unit(curve, "heading"))
    finding = f"{number(end, 5)} {shown} in the end, 95 % within {number(half, 2)} {shown} of it"
    return Picture(NAME, str(curve.get("test", "")), "", finding, SHOWS, (HEIGHT,), paint)


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the heading over time, and the interval of the end.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``alignment_forming``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    minutes = numbers(curve, "time") / 60.0
    low, high = numbers(curve, "lo"), numbers(curve, "hi")
    ax.fill_between(minutes, low, high, color=COLOURS["sky"], alpha=0.35, linewidth=0.0,
                    label="95 % at the end")  # fmt: skip
    ax.plot(minutes, numbers(curve, "heading"), color=COLOURS["blue"], label="heading so far")
    set_title(ax, title)
    set_labels(ax, with_unit("time in each position", "min"), with_unit("heading", unit(curve, "heading")))
    set_legend(ax)
