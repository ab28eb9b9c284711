"""Values of an estimate with their 95 % intervals: one row per value, one panel per unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ....core.errors import DataError
from ....core.estimate import Estimate
from ....core.show.rounding import with_uncertainty
from ....statistics.intervals import t_interval
from ..drawing.data import distinct
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_title, with_unit

NAME = "estimate"
ROW, LEAST = 0.28, 0.35  # height of a row, and of what a panel needs beside [in]
FEW_TICKS = 4  # their labels are long
SHOWS = "Each value with its 95 % interval, one panel per unit"


def picture(estimate: Estimate) -> Picture:
    """Return the picture of an estimate.

    Raises
    ------
    DataError
        ``nothing_to_draw``, if it has no value.
    """
    if not estimate.names:
        raise DataError("The estimate has no values to plot", code="nothing_to_draw")
    units = distinct(estimate.units)

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, estimate, title)

    heights = tuple(LEAST + ROW * estimate.units.count(unit) for unit in units)
    return Picture(NAME, "", "", finding(estimate), SHOWS, heights, paint, share_x=False)


def finding(estimate: Estimate) -> str:
    """Return the finding: a single value, or how many intervals exclude zero."""
    if len(estimate.names) == 1:
        unit = "" if estimate.units[0] == "1" else f" {estimate.units[0]}"
        return f"{plain(estimate.names[0])} = {with_uncertainty(float(estimate.values[0]), float(estimate.u[0]))}{unit}"
    apart = sum(not lo <= 0.0 <= hi for lo, hi in _intervals(estimate))
    return f"{apart} of {len(estimate.names)} values differ from zero by more than their 95 % interval"


def draw(axes: Sequence[Axes], estimate: Estimate, title: str = "") -> None:
    """Draw the values."""
    intervals = np.array(_intervals(estimate))
    for ax, unit in zip(axes, distinct(estimate.units), strict=True):
        mine = [i for i, own in enumerate(estimate.units) if own == unit]
        rows = np.arange(len(mine))
        ax.axvline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        ax.hlines(rows, intervals[mine, 0], intervals[mine, 1], color=COLOURS["quiet"], linewidth=1.8)
        ax.plot(estimate.values[mine], rows, "o", color=COLOURS["blue"], zorder=3)
        labels = [plain(estimate.names[i]).replace("_", " ") for i in mine]
        ax.set_yticks(rows, labels=labels, parse_math=False)
        ax.set_ylim(len(mine) - 0.5, -0.5)
        ax.xaxis.set_major_locator(MaxNLocator(FEW_TICKS))
        set_labels(ax, with_unit("value, 95 % interval", unit))
    set_title(axes[0], title)


def _intervals(estimate: Estimate) -> list[tuple[float, float]]:
    found = []
    for value, u, dof in zip(estimate.values, estimate.u, estimate.dof, strict=True):
        interval = t_interval(float(value), float(u), float(dof))
        lo, hi = (float(value) if end is None else float(end) for end in (interval.lo, interval.hi))
        found.append((lo, hi))
    return found
