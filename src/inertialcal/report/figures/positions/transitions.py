"""Transitions: gravity as the gyros carry it through each rotation, against gravity as the accelerometers find it.

Filled: with what the gyros read of specific force taken off; hollow: without. Rotations left out have their own marks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, flags, numbers, scale_to, unit
from ..drawing.layout import count
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "transitions"
SHOWS = (
    "Angle between gravity as the gyros carry it through each rotation and gravity as the accelerometers find it after"
    " it; lines are root mean squares"
)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = [one for one in curves(results, NAME) if len(finite(numbers(one, "error")))]
    return [_picture(one) for one in found]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(NAME, str(curve.get("test", "")), "", finding(curve), SHOWS, (2.0,), paint)


def in_degrees(curve: Curve, column: str) -> Array:
    """Return a column of angles in deg; NaN throughout where it is not there."""
    if column not in curve["columns"]:
        return np.full(len(numbers(curve, "error")), np.nan)
    return np.asarray(numbers(curve, column) * scale_to("deg", unit(curve, column)))


def rms(values: Array) -> float:
    """Return the root mean square of the finite ones; NaN where there is none."""
    known = finite(values)
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def finding(curve: Curve) -> str:
    """Return the finding: the error of all rotations, and what it would be without g-sensitivity."""
    used = ~flags(curve, "left_out")
    with_g, without = in_degrees(curve, "error")[used], in_degrees(curve, "error_without")[used]
    said = f"{len(finite(with_g))} rotations, rms error {number(rms(with_g), 2)} deg"
    if len(finite(without)):
        said += f", {number(rms(without), 2)} deg without g-sensitivity"
    return said


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the errors of all rotations.

    Parameters
    ----------
    ax : Axes
        One.
    curve : mapping
        ``transitions`` of ``results.json``.
    title : str
        Above; empty for none.
    """
    at, left = numbers(curve, "rotation"), flags(curve, "left_out")
    error, without = in_degrees(curve, "error"), in_degrees(curve, "error_without")
    ax.vlines(at, error, without, color=COLOURS["grid"], linewidth=0.8, zorder=1)
    looks: tuple[tuple[str, Any, Array, dict[str, Any]], ...] = (
        ("without g-sensitivity", ~left, without,
         {"marker": "o", "markerfacecolor": "none", "markeredgecolor": COLOURS["vermilion"]}),
        ("with all terms", ~left, error, {"marker": "o", "color": COLOURS["blue"], "markersize": 4.5}),
        ("left out of the fit", left, error,
         {"marker": "D", "markerfacecolor": "none", "markeredgecolor": COLOURS["ink"]}),
    )  # fmt: skip
    for label, chosen, values, look in looks:
        mask = chosen & np.isfinite(values)
        if mask.any():
            ax.plot(at[mask], values[mask], linestyle="none", label=label, zorder=3, **look)
    for values, colour in ((without[~left], "vermilion"), (error[~left], "blue")):
        if len(finite(values)):
            ax.axhline(rms(values), color=COLOURS[colour], linewidth=1.0, linestyle="--", zorder=2)
    top = finite(np.concatenate([error, without]))
    ax.set_ylim(0.0, 1.08 * float(top.max()) if len(top) and top.max() > 0.0 else 1.0)
    set_title(ax, title)
    count(ax.xaxis)
    set_labels(ax, "rotation, in order of time", with_unit("error", "deg"))
    set_legend(ax)
