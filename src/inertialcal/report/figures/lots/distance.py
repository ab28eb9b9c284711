"""How far each unit of a lot lies from the rest, on all parameters together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, flags, numbers
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title

NAME = "lot_distance"
SHOWS = "Distance of each unit from the rest in standard deviations of a normal population, and the limit"
HEIGHT = 1.7  # [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return one picture."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "distance")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(NAME, "", "", plain(curve.get("finding", ""), 400), SHOWS, (HEIGHT,), paint, data=[curve])


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw distances.

    Parameters
    ----------
    ax : Axes
        To draw on.
    curve : mapping
        ``lot_distance``.
    title : str
        Above; empty for none.
    """
    number, distance, limit, odd = (
        *(numbers(curve, name) for name in ("number", "distance", "limit")),
        flags(curve, "odd"),
    )
    ax.plot(number[~odd], distance[~odd], ".", color=COLOURS["blue"], ms=2.5, label="units")
    if odd.any():
        ax.plot(number[odd], distance[odd], "s", color=COLOURS["vermilion"], ms=4.5, label="of another kind")
    ax.axhline(float(limit[0]), color=COLOURS["vermilion"], ls="--", lw=1.0, label="limit")
    if odd.any():
        log_axis(ax, "y", distance)
    set_title(ax, title)
    set_labels(ax, "unit, in the order of the table", "standard deviations")
    set_legend(ax)
