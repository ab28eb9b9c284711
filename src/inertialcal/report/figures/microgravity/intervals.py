"""Least, largest and mean value of intervals of time, a panel an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, distinct, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .clock import scaled

NAME = "microgravity_intervals"
SHOWS = "Least, largest and mean value of intervals over time, a panel an axis"
HEIGHT = 1.3  # of a panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    known = curves(results, NAME)
    return [_picture(test, [one for one in known if str(one.get("test", "")) == test])
            for test in distinct(str(one.get("test", "")) for one in known)]  # fmt: skip


def _picture(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, mine, title)

    return Picture(NAME, test, "", finding(mine), SHOWS, (HEIGHT,) * len(mine), paint, data=mine)


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: how far the widest interval goes, and when."""
    spans = [numbers(one, "largest") - numbers(one, "least") for one in mine]
    which = int(np.argmax([np.nanmax(one) for one in spans]))
    at = int(np.nanargmax(spans[which]))
    time, word = scaled(numbers(mine[which], "time"))
    size = f"{number(float(spans[which][at]), 3)} {plain(unit(mine[which], 'least'))}"
    axis, when = plain(mine[which].get("axis", "")), number(float(time[at]), 3)
    return f"Widest: {axis}, {size} from least to largest at {when} {word}"


def _apart(values: Array, gap: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> Array:
    """Return values with a NaN before each gap, so that no line goes across."""
    return np.insert(values, np.flatnonzero(gap), np.nan)


def draw(axes: Sequence[Axes], mine: Sequence[Curve], title: str = "") -> None:
    """Draw a panel an axis."""
    for ax, curve in zip(axes, mine, strict=True):
        time, word = scaled(numbers(curve, "time"))
        gap = flags(curve, "after_gap")
        at, low, high, mean = (_apart(one, gap) for one in (time, *(numbers(curve, name)
                               for name in ("least", "largest", "mean"))))  # fmt: skip
        ax.fill_between(at, low, high, step="mid", color=COLOURS["sky"], alpha=0.6, linewidth=0.4,
                        label="least to largest")  # fmt: skip
        ax.plot(at, mean, color=COLOURS["ink"], linewidth=0.9, label="mean")
        set_labels(ax, with_unit("time", word), with_unit(plain(curve.get("axis", "")), unit(curve, "least")))
    set_title(axes[0], title)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    set_legend(axes[-1])


__all__ = ["NAME", "draw", "finding", "pictures"]
