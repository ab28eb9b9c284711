"""Bias on power-ups held out: raw, compensated for temperature, and for temperature and pressure; a panel an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, WIDTH, plain, set_labels, set_legend, set_title, with_unit

NAME = "overlay"
SHOWS = "Bias on power-ups held out over temperature: raw, and after compensation, a panel an axis"
APART, TALL = 3.6, 2.0  # of the panel of one axis that stands alone [in]
HEIGHT = 1.5  # of a panel [in]
DRAWN = {
    "raw": ("raw", "quiet", "."),
    "by_temperature": ("compensated for temperature", "vermilion", "x"),
    "by_temperature_and_pressure": ("for temperature and pressure", "blue", "+"),
}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a thermal test held out."""
    every = [one for one in curves(results, NAME) if len(finite(numbers(one, "raw")))]
    return [_picture(test, [one for one in every if one["test"] == test])
            for test in dict.fromkeys(one["test"] for one in every)]  # fmt: skip


def _picture(test: str, found: Sequence[Curve], width: float = WIDTH) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, found, title)

    apart = tuple(_picture(test, [one], APART) for one in found) if len(found) > 1 else ()
    heights = (HEIGHT if width == WIDTH else TALL,) * len(found)
    return Picture(NAME, test, "", finding(found), SHOWS, heights, paint, width=width, apart=apart)


def finding(found: Sequence[Curve]) -> str:
    """Return the finding: the largest bias before, and the largest left after."""
    last = [name for name in DRAWN if name in found[0]["columns"]][-1]
    raw, left = (max(_largest(one, name) for one in found) for name in ("raw", last))
    return f"compensation takes the largest bias from {raw:.2g} to {left:.2g} {plain(unit(found[0], 'raw'))}"


def _largest(curve: Curve, name: str) -> float:
    values = finite(numbers(curve, name))
    return float(np.max(np.abs(values))) if len(values) else 0.0


def draw(axes: Sequence[Axes], found: Sequence[Curve], title: str = "") -> None:
    """Draw the cells of all axes."""
    for ax, curve in zip(axes, found, strict=True):
        for name, (label, colour, mark) in DRAWN.items():
            if name in curve["columns"]:
                T, bias = numbers(curve, "temperature"), numbers(curve, name)
                ax.plot(T, bias, mark, color=COLOURS[colour], markersize=3.0, label=label, zorder=3)
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
        set_labels(ax, y=with_unit(f"{plain(curve.get('axis', ''), 12)} bias", unit(curve, "raw")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("temperature", unit(found[0], "temperature")))
    set_legend(axes[-1])
