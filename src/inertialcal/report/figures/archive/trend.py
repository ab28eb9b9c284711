"""Control chart of a quantity over units or lots: figures with their limits, and the spread below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "archive_trend"
SHOWS = (
    "Figures in order of time with mean and limits of three standard deviations; below, the moving range, or the"
    " standard deviation in each lot, with its limits"
)
HEIGHTS = (2.2, 1.1)  # [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a chart."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "value")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    test, axis, finding = (str(curve.get(name, "")) for name in ("test", "axis", "finding"))
    return Picture(NAME, test, axis, plain(finding, 400), SHOWS, HEIGHTS, paint, data=[curve])


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw a control chart.

    Parameters
    ----------
    axes : sequence of Axes, length 2
        To draw on: figures, spread.
    curve : mapping
        ``archive_trend``; its column of names, ``unit`` or ``lot``, says what a point is.
    title : str
        Above; empty for none.
    """
    top, below = axes
    by = "lot" if "lot" in curve["columns"] else "unit"
    values, spread, most, least = (numbers(curve, name) for name in ("value", "spread", "spread_upper", "spread_lower"))
    x = np.arange(1, values.size + 1)
    limits: dict[str, Any] = {"color": COLOURS["vermilion"], "ls": "--", "lw": 1.0, "where": "mid"}
    top.plot(x, values, ".-", color=COLOURS["blue"], lw=0.6, ms=4.0, label=f"a {by}")
    top.plot(x, numbers(curve, "mean"), color=COLOURS["quiet"], lw=1.0, label="mean")
    top.step(x, numbers(curve, "lower"), label="limits", **limits)
    top.step(x, numbers(curve, "upper"), **limits)
    at = flags(curve, "signal")
    top.plot(x[at], values[at], "s", color=COLOURS["vermilion"], ms=5.0, label="signal")
    set_title(top, title)
    set_labels(top, "", with_unit(plain(curve.get("of", "")), unit(curve, "value")))
    below.plot(x, spread, ".-", color=COLOURS["blue"], lw=0.6, ms=4.0)
    known = np.isfinite(spread)  # the first unit has no range
    below.step(x[known], most[known], **limits)
    if (least > 0.0).any():
        below.step(x[known], least[known], **limits)
    below.xaxis.set_major_locator(MaxNLocator(integer=True))
    what = "range" if by == "unit" else "std"  # moving, in a lot: the panel is low
    set_labels(below, f"{by}, in order of time", with_unit(what, unit(curve, "value")))
    set_legend(below, top.get_legend_handles_labels()[0])
