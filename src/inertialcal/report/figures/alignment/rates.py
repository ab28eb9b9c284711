"""Level rates of an alignment, position by position, on the circle of the rate of the earth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number, uncertainty
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "alignment_rates"
SHOWS = "Level rate that the gyros read in each position, along x and across it, and where the earth alone would put it"
HEIGHT = 4.0  # of the panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "forward")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    circle, u = float(numbers(curve, "circle")[0]), float(numbers(curve, "u")[0])
    shown = plain(unit(curve, "circle"))
    finding = f"{number(circle, 4)} {shown} of the earth in level; {uncertainty(u)} {shown} of it not known"
    return Picture(NAME, str(curve.get("test", "")), "", finding, SHOWS, (HEIGHT,), paint)


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the circle about the bias, and a point a position.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``alignment_rates``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    forward, right = numbers(curve, "forward"), numbers(curve, "right")
    middle = numbers(curve, "bias_right"), numbers(curve, "bias_forward")
    radius, angle = float(numbers(curve, "circle")[0]), np.linspace(0.0, 2.0 * np.pi, 121)
    x, y = float(np.mean(middle[0])), float(np.mean(middle[1]))
    ax.plot(x + radius * np.sin(angle), y + radius * np.cos(angle), color=COLOURS["quiet"], linewidth=1.0,
            label="rate of the earth about the bias")  # fmt: skip
    ax.plot([x], [y], linestyle="none", marker="+", markersize=9.0, color=COLOURS["vermilion"], label="bias")
    for one, other in zip(right, forward, strict=True):
        ax.plot([x, one], [y, other], color=COLOURS["blue"], linewidth=0.8, zorder=1)
    u = float(numbers(curve, "u")[0])
    ax.errorbar(right, forward, xerr=u, yerr=u, linestyle="none", marker="o", markersize=5.0, capsize=2.0,
                color=COLOURS["blue"], label="read, with u")  # fmt: skip
    for place, one, other in zip(numbers(curve, "position"), right, forward, strict=True):
        ax.annotate(f"{place:g}", (one, other), xytext=(6.0, 6.0), textcoords="offset points")
    ax.set_aspect("equal", adjustable="datalim")
    set_title(ax, title)
    shown = unit(curve, "forward")
    set_labels(ax, with_unit("about the level axis to the right", shown), with_unit("about level x", shown))
    set_legend(ax)
