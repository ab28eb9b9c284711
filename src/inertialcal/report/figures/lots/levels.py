"""Means of the stations of a lot, or of another column, against what may be between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, flags, numbers, unit, words
from ..drawing.metrics import shortened
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title, with_unit

NAME = "lot_stations"
SHOWS = "Mean of the units of each station less that of the others, 95 %; bars: what standards and units allow, 95 %"
ROW, LEAST = 0.22, 0.9  # height of a station, of the panel at least [in]
HALF = 1.96
NAMES = 90.0  # width of a name [pt]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a figure."""
    return [_picture(one) for one in curves(results, NAME) if len(numbers(one, "offset"))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    test, axis, finding = (str(curve.get(name, "")) for name in ("test", "axis", "finding"))
    high = max(LEAST, ROW * len(numbers(curve, "offset")))
    return Picture(NAME, test, axis, plain(finding, 400), SHOWS, (high,), paint, data=[curve])


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the stations of a lot, the first on top.

    Parameters
    ----------
    ax : Axes
        To draw on.
    curve : mapping
        ``lot_stations``.
    title : str
        Above; empty for none.
    """
    offset, u, allowed, off = *(numbers(curve, name) for name in ("offset", "u", "allowed")), flags(curve, "off")
    y = np.arange(offset.size)
    ax.barh(y, 2 * HALF * allowed, 0.55, -HALF * allowed, color=COLOURS["grid"], label="allowed", zorder=1)
    for which, colour, mark, label in ((~off, "blue", "o", "mean"), (off, "vermilion", "s", "off")):
        if which.any():
            ax.errorbar(offset[which], y[which], xerr=HALF * u[which], fmt=mark, ms=4.0, lw=1.0,
                        color=COLOURS[colour], label=label, zorder=3)  # fmt: skip
    ax.axvline(0.0, color=COLOURS["quiet"], lw=0.8, zorder=2)
    ax.set_yticks(y, [shortened(plain(one), TEXT, NAMES) for one in words(curve, "level")])
    ax.invert_yaxis()
    set_title(ax, title)
    set_labels(ax, with_unit(f"{plain(curve.get('of', ''))}, less the others", unit(curve, "offset")))
    set_legend(ax)
