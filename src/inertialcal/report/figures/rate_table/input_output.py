"""Reading over applied rate, and below it what the fitted line leaves over.

Dwells that were left out are hollow, one shape a rule. The lower panel is scaled to the dwells that were used: what
lies outside of it is drawn at its edge and counted in the legend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, distinct, finite, flags, numbers, thinned, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "input_output"
MOST = 1200  # dwells drawn; of more, the least and largest residual of each bin
MANY_RUNS = 8  # more lines than that say nothing
SHAPES = ("s", "D", "^", "v", "P")
SHOWS = "Above, reading over applied input with the fitted line; below, the residuals"
ROOM = 1.35  # of the residuals used, height of the lower panel
Mask = NDArray[np.bool_]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and sensor that reads its own axis."""
    return [_picture(curve) for curve in curves(results, NAME) if len(finite(numbers(curve, "reading")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve), SHOWS, (2.1, 1.5), paint)


def finding(curve: Curve) -> str:
    """Return the finding: how far the dwells lie from the line, and how many were left out."""
    used = flags(curve, "used")
    residual = np.abs(finite(numbers(curve, "residual")[used]))
    who = f"{plain(curve.get('axis', ''))}: "
    left = f", {np.sum(~used)} left out" if np.any(~used) else ""
    if not len(residual):
        return f"{who}no dwell was used{left}"
    furthest = number(float(np.max(residual)), 2)
    return f"{who}{len(residual)} dwells within {furthest} {plain(unit(curve, 'residual'))} of the line{left}"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw readings on the first axes and residuals on the second."""
    above, below = axes
    applied, reading, residual = (numbers(curve, name) for name in ("applied", "reading", "residual"))
    used = flags(curve, "used")
    places = thinned(residual, MOST)
    known = np.zeros(len(applied), dtype=np.bool_)
    known[places] = True
    known &= np.isfinite(applied) & np.isfinite(reading)
    _line(above, applied[used], (reading - residual)[used])
    below.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    _runs(below, curve, used & known)
    label = f"dwells used ({np.sum(used)})" + (f", {np.sum(used & known)} drawn" if len(places) < len(used) else "")
    for ax, values in ((above, reading), (below, residual)):
        seen = used & known & np.isfinite(values)
        ax.plot(applied[seen], values[seen], "o", color=COLOURS["blue"], markersize=3.6, label=label, zorder=3)
    _scale(below, residual[used])
    _left_out(above, below, curve, known)
    set_title(above, title)
    set_labels(above, y=with_unit("reading", unit(curve, "reading")))
    set_labels(below, with_unit("applied", unit(curve, "applied")), with_unit("residual", unit(curve, "residual")))
    above.tick_params(labelbottom=False)
    handles = [*above.get_legend_handles_labels()[0], *_only_below(below)]
    set_legend(below, handles)


def _only_below(ax: Axes) -> list[Any]:
    handles, labels = ax.get_legend_handles_labels()
    return [handle for handle, label in zip(handles, labels, strict=True) if label.startswith(("one line", "outside"))]


def _line(ax: Axes, applied: Array, fitted: Array) -> None:
    known = np.isfinite(applied) & np.isfinite(fitted)
    order = np.argsort(applied[known], kind="stable")
    ax.plot(applied[known][order], fitted[known][order], color=COLOURS["ink"], linewidth=0.9, label="fitted line")


def _runs(ax: Axes, curve: Curve, used: Mask) -> None:
    """Join the dwells of each run, where there are few runs: an error that changes from run to run then shows."""
    runs = np.array(words(curve, "run"))
    names = distinct(runs[used])
    if not 1 < len(names) <= MANY_RUNS or int(np.sum(used)) < 3 * len(names):
        return
    applied, residual = numbers(curve, "applied"), numbers(curve, "residual")
    for count, name in enumerate(names):
        mine = np.flatnonzero(used & (runs == name))
        mine = mine[np.argsort(applied[mine], kind="stable")]
        label = f"one line a run ({len(names)})" if count == 0 else "_nolegend_"
        ax.plot(applied[mine], residual[mine], color=COLOURS["sky"], linewidth=0.8, label=label, zorder=2)


def _scale(ax: Axes, residual: Array) -> None:
    """Scale the residuals to the dwells used."""
    known = finite(residual)
    size = float(np.max(np.abs(known))) if len(known) else 0.0
    if size > 0.0:
        ax.set_ylim(-ROOM * size, ROOM * size)


def _left_out(above: Axes, below: Axes, curve: Curve, known: Mask) -> None:
    applied, reading, residual = (numbers(curve, name) for name in ("applied", "reading", "residual"))
    used, reasons = flags(curve, "used"), np.array(words(curve, "reason"))
    low, high = below.get_ylim()
    for count, reason in enumerate(distinct(reasons[~used])):
        mine = ~used & (reasons == reason)
        drawn = mine & known
        look: dict[str, Any] = {
            "marker": SHAPES[count % len(SHAPES)], "linestyle": "none", "markerfacecolor": "none",
            "markeredgecolor": COLOURS["vermilion"], "markersize": 5.0, "zorder": 4,
        }  # fmt: skip
        word = plain(reason or "no rule named").replace("_", " ")
        missing = int(np.sum(mine & ~np.isfinite(reading)))
        label = (
            f"left out, {word} ({np.sum(mine)}{f', {missing} without reading' if 0 < missing < np.sum(mine) else ''})"
        )
        above.plot(applied[drawn], reading[drawn], label=label, **look)
        inside = drawn & (residual >= low) & (residual <= high)
        below.plot(applied[inside], residual[inside], **look)
    _outside(below, applied[~used & known], residual[~used & known], (low, high))


def _outside(ax: Axes, applied: Array, residual: Array, ends: tuple[float, float]) -> None:
    """Mark what lies outside the lower panel at its edge."""
    below, above = residual < ends[0], residual > ends[1]
    count = int(np.sum(below | above))
    for mask, end, shape in ((below, ends[0], 7), (above, ends[1], 6)):
        label = f"outside the lower panel ({count})" if mask is above or not np.any(above) else "_nolegend_"
        if np.any(mask):
            ax.plot(
                applied[mask], np.full(int(np.sum(mask)), end), marker=shape, linestyle="none", clip_on=False,
                color=COLOURS["vermilion"], markersize=6.0, label=label, zorder=5,
            )  # fmt: skip
