"""Deviation from the best straight line over rate, with what asymmetry and curvature explain (IEEE 1431, 12.9)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "linearity"
SHOWS = "Mean deviation from the best straight line at each rate, with 95 % intervals for all rates together"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and axis."""
    return [_picture(curve) for curve in curves(results, NAME) if len(finite(numbers(curve, "deviation")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve), SHOWS, (2.4,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: at how many rates a deviation stands out, and the largest."""
    deviation, lo, hi, rate = (numbers(curve, name) for name in ("deviation", "lo", "hi", "rate"))
    at = int(np.nanargmax(np.abs(deviation)))
    out = int(np.sum((lo > 0.0) | (hi < 0.0)))
    largest = f"{number(float(deviation[at]), 2)} {plain(unit(curve, 'deviation'))}"
    where = f"at {number(float(rate[at]), 3)} {plain(unit(curve, 'rate'))}"
    stands = f"{out} of {len(rate)} rates off the straight line" if out else f"straight at all {len(rate)} rates"
    return f"{plain(curve.get('axis', ''))}: {stands}; largest deviation {largest}, {where}"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw the deviations of one test and axis."""
    (ax,) = axes
    rate, deviation, lo, hi, fitted = (numbers(curve, name) for name in ("rate", "deviation", "lo", "hi", "fitted"))
    known = np.isfinite(rate) & np.isfinite(deviation)
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    if np.any(np.abs(fitted[known]) > 0.0):
        ax.plot(
            rate[known],
            fitted[known],
            color=COLOURS["orange"],
            linewidth=1.2,
            label="asymmetry and curvature",
            zorder=2,
        )
    ax.vlines(
        rate[known], lo[known], hi[known], color=COLOURS["quiet"], linewidth=1.2, label="95 % for all rates together"
    )
    ax.plot(rate[known], deviation[known], "o", color=COLOURS["blue"], markersize=4.0, label="mean of a rate", zorder=3)
    set_title(ax, title)
    set_labels(ax, with_unit("rate", unit(curve, "rate")), with_unit("deviation", unit(curve, "deviation")))
    set_legend(ax, ax.get_legend_handles_labels()[0])
