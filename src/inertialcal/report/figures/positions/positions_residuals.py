"""What each position leaves: its residual with it in the fit, and without it, in ug, in the order of time.

Filled: in the fit; hollow: from the fit without it. The band is twice the scatter between positions that was found.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.show.rounding import number
from ....core.show.wording import listed
from ..drawing.data import Curve, curves, finite, flags, numbers, scale_to, unit
from ..drawing.layout import count
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "positions_residuals"
SHOWS = (
    "Residual of each position in the order of time, filled with it in the fit, hollow from the fit without it;"
    " the band is twice the scatter between positions"
)
FAR, NORMAL = 3.5, 1.4826  # times the scatter; scatter of a normal distribution over the median size
MOST_NAMED = 4  # positions in a title
MILLI = 1e3  # [ug], above which mg are shown
ACROSS = (("residual_across_1", "across, 1"), ("residual_across_2", "across, 2"))


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = [one for one in curves(results, "positions") if len(finite(numbers(one, "residual")))]
    return [_picture(one) for one in found]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(NAME, str(curve.get("test", "")), "", finding(curve), SHOWS, (2.1,), paint)


def in_ug(curve: Curve, column: str) -> Array:
    """Return a column of accelerations in ug."""
    return np.asarray(numbers(curve, column) * scale_to("ug", unit(curve, column)))


def shown_unit(*values: Array) -> tuple[str, float]:
    """Return the unit that residuals are shown in, and by what ug are divided for it."""
    largest = max((float(np.max(np.abs(one))) for one in map(finite, values) if len(one)), default=0.0)
    return ("mg", 1000.0) if largest >= MILLI else ("ug", 1.0)


def finding(curve: Curve) -> str:
    """Return the finding: the rms of all, with each in the fit and without it, and which is largest."""
    inside, without = in_ug(curve, "residual"), in_ug(curve, "deletion")
    used = ~flags(curve, "left_out")
    name, scale = shown_unit(inside[used], without[used])
    rms = [
        float(np.sqrt(np.mean(finite(one[used]) ** 2))) / scale for one in (inside, without) if len(finite(one[used]))
    ]
    said = f"residuals rms {number(rms[0], 3)} {name}"
    said += f", from the fit without it {number(rms[1], 3)} {name}" if len(rms) > 1 else ""
    named = stand_out(without if len(finite(without[used])) else inside, used)
    if named:
        who = f"positions {listed(list(map(str, named)))} stand" if len(named) > 1 else f"position {named[0]} stands"
        return f"{said}; {who} out"
    worst = np.where(used, np.abs(inside), -1.0)
    place = f"; largest in position {int(np.nanargmax(worst)) + 1}" if len(finite(inside[used])) else ""
    return said + place


def stand_out(values: Array, used: NDArray[np.bool_]) -> list[int]:
    """Return the positions, from 1, whose residuals are far beyond those of the others, the largest first.

    Far: more than `FAR` times the scatter that the median size of all tells (of a normal distribution) [1]_.

    References
    ----------
    .. [1] B. Iglewicz and D. C. Hoaglin, "How to Detect and Handle Outliers", ASQC 1993: modified z-score over 3.5.
    """
    sizes = np.where(used & np.isfinite(values), np.abs(values), 0.0)
    known = np.abs(finite(values[used]))
    if not len(known):
        return []
    far = np.flatnonzero(sizes > FAR * NORMAL * float(np.median(known)))
    return [int(one) + 1 for one in far[np.argsort(-sizes[far], kind="stable")]][:MOST_NAMED]


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the residuals.

    Parameters
    ----------
    ax : Axes
        One.
    curve : mapping
        ``positions`` of ``results.json``.
    title : str
        Above; empty for none.
    """
    inside, without, left = in_ug(curve, "residual"), in_ug(curve, "deletion"), flags(curve, "left_out")
    name, scale = shown_unit(inside, without)
    at = numbers(curve, "position")
    between = finite(in_ug(curve, "between")) if "between" in curve["columns"] else np.empty(0)
    if len(between):
        wide = 2.0 * float(between[0]) / scale
        ax.axhspan(-wide, wide, color=COLOURS["sky"], alpha=0.3, linewidth=0.0, zorder=0,
                   label="±2 scatter of positions")  # fmt: skip
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.vlines(at, inside / scale, without / scale, color=COLOURS["quiet"], linewidth=0.7, zorder=2)
    looks: tuple[tuple[str, Any, Array, dict[str, Any]], ...] = (
        (
            "fitted without it",
            ~left,
            without,
            {"marker": "o", "markerfacecolor": "none", "markeredgecolor": COLOURS["blue"]},
        ),
        ("in the fit", ~left, inside, {"marker": "o", "color": COLOURS["blue"], "markersize": 4.0}),
        ("left out", left, inside, {"marker": "D", "markerfacecolor": "none", "markeredgecolor": COLOURS["vermilion"]}),
    )
    for label, chosen, values, look in looks:
        mask = chosen & np.isfinite(values)
        if mask.any():
            ax.plot(at[mask], values[mask] / scale, linestyle="none", label=label, zorder=3, **look)
    _across(ax, curve, scale)
    set_title(ax, title)
    count(ax.xaxis)
    set_labels(ax, "position, in order of time", with_unit("residual", name))
    set_legend(ax)


def _across(ax: Axes, curve: Curve, scale: float) -> None:
    """Draw what known orientations leave across gravity."""
    at, used = numbers(curve, "position"), ~flags(curve, "left_out")
    for (column, label), (colour, shape) in zip(ACROSS, (("orange", "^"), ("green", "v")), strict=True):
        if column in curve["columns"] and len(finite(numbers(curve, column))):
            ax.plot(at[used], in_ug(curve, column)[used] / scale, shape, color=COLOURS[colour], markersize=4.0,
                    linestyle="none", label=label, zorder=3)  # fmt: skip
