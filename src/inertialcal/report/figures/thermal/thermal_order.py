"""Order of the polynomial: error on what was held out, order by order, a line an axis; the chosen one is filled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import LARGEST, decades
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "thermal_order"
SHOWS = "Root mean square error of prediction on what was held out, over the order of the polynomial"
LOOKS = (("blue", "o"), ("vermilion", "s"), ("green", "^"))


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    every = [one for one in curves(results, NAME) if len(finite(numbers(one, "error")))]
    tests = dict.fromkeys(str(one.get("test", "")) for one in every)
    return [_picture(test, [one for one in every if one.get("test", "") == test]) for test in tests]


def _picture(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, title)

    return Picture(NAME, test, "", finding(mine), SHOWS, (1.8,), paint)


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: which order each axis has, and by what it was chosen."""
    parts = []
    for one in mine:
        chosen = numbers(one, "order")[flags(one, "chosen")]
        parts += [f"order {chosen[0]:.0f} for {plain(one.get('axis', ''), 12)}"] if len(chosen) else []
    given = all(one.get("of") == "given" for one in mine)
    by = "as the plan says" if given else f"by {plain(mine[0].get('of', ''))} held out"
    return f"{', '.join(parts)}, {by}"


def draw(ax: Axes, mine: Sequence[Curve], title: str = "") -> None:
    """Draw the errors of all axes of a test."""
    for curve, (colour, shape) in zip(mine, LOOKS, strict=False):
        order, error, chosen = numbers(curve, "order"), numbers(curve, "error"), flags(curve, "chosen")
        name = plain(curve.get("axis", ""), 12)
        look: dict[str, Any] = {
            "marker": shape,
            "markersize": 5.0,
            "markeredgecolor": COLOURS[colour],
            "linewidth": 0.9,
        }
        ax.plot(order, error, color=COLOURS[colour], markerfacecolor="none", label=name, zorder=3, **look)
        ax.plot(order[chosen], error[chosen], shape, color=COLOURS[colour], markersize=6.5, zorder=4)
    every = np.concatenate([finite(numbers(one, "error")) for one in mine])
    if np.all(every > 0.0) and every.max() < LARGEST * every.min():
        decades(ax, every)
    ax.set_xticks(numbers(mine[0], "order"))
    set_title(ax, title)
    set_labels(ax, "order (filled: chosen)", with_unit("error held out", unit(mine[0], "error")))
    set_legend(ax)
