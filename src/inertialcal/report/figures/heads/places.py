"""What the place of a head costs along the line of two calibrated ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "heads_places"
SHOWS = (
    "Standard uncertainty of the bias by the white noise of this record, along the line of two calibrated heads at 0"
    " and 1"
)
HEIGHT = 2.4  # of the panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a head."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "u"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    u, along = numbers(curve, "u"), numbers(curve, "along")
    least, end = float(np.min(u)), float(np.interp(2.0, along, u))
    finding = f"Least halfway: {number(least, 2)} {plain(unit(curve, 'u'))}; {number(end / least, 2)} times that at 2"
    return Picture(NAME, str(curve.get("test", "")), str(curve.get("of", "")), finding, SHOWS, (HEIGHT,), paint)


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the line, with what the head's distance from it costs.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``heads_places``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    along, u, cost = numbers(curve, "along"), numbers(curve, "u"), float(numbers(curve, "cost")[0])
    ax.plot(along, u, color=COLOURS["blue"], label="on the line")
    if cost > 0.0:
        ax.plot(along, np.hypot(u, cost), color=COLOURS["vermilion"], linestyle="--",
                label="as far off the line as this head")  # fmt: skip
    at = float(numbers(curve, "head")[0])
    if np.isfinite(at):
        ax.plot([at], [np.hypot(np.interp(at, along, u), cost)], linestyle="none", marker="o", markersize=5.0,
                color=COLOURS["ink"], label=plain(curve.get("of", "")))  # fmt: skip
    ax.plot([0.0, 1.0], [0.0, 0.0], linestyle="none", marker="^", markersize=5.0, color=COLOURS["green"],
            label="calibrated", clip_on=False)  # fmt: skip
    ax.set_ylim(0.0, None)
    set_title(ax, title)
    set_labels(ax, "place along the line, 0 and 1 at the calibrated heads", with_unit("u(bias)", unit(curve, "u")))
    set_legend(ax)
