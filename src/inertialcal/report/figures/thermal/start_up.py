"""Start-up: what the reading does after power-up, a panel an axis, with the transient and what is left out of the fit.

Means over the steady part after each power-up, less the settled level of their run. Hollow: left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number, with_uncertainty
from ..drawing.data import Curve, curves, distinct, finite, flags, numbers, thinned, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, WIDTH, plain, set_labels, set_legend, set_title, with_unit

NAME = "start_up"
SHOWS = "Reading after power-up less its settled level, a panel an axis, with the fitted transient; hollow: left out"
APART, TALL = 3.6, 2.0  # of the panel of one axis that stands alone [in]
HEIGHT = 1.2  # of a panel [in]
MOST = 400  # means drawn a panel


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    every = [one for one in curves(results, NAME) if len(finite(numbers(one, "residual")))]
    tests = dict.fromkeys(str(one.get("test", "")) for one in every)
    found = []
    for test in tests:
        mine = [one for one in every if one.get("test", "") == test]
        rows = [row for row in results.get("results", []) if row["test"] == test]
        found.append(_picture(test, mine, rows))
    return found


def _picture(test: str, mine: Sequence[Curve], rows: Sequence[Mapping[str, Any]], width: float = WIDTH) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, mine, title)

    alone = [([one], [row for row in rows if row["axis"] == one.get("axis")]) for one in mine]
    apart = tuple(_picture(test, *one, APART) for one in alone) if len(mine) > 1 else ()
    heights = (HEIGHT if width == WIDTH else TALL,) * len(mine)
    return Picture(NAME, test, "", finding(mine, rows), SHOWS, heights, paint, width=width, apart=apart)


def finding(mine: Sequence[Curve], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: by how much each axis moves after power-up, and the longest time left out."""
    parts = []
    for row in rows:
        if row["quantity"] == "warm_up_change" and row["value"] is not None:
            parts.append(f"{plain(row['axis'], 12)} {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}")
    cuts = [row["value"] for row in rows if row["quantity"] == "warm_up_time" and row["value"] is not None]
    if not parts:
        return "no start-up transient above the noise"
    runs = len(distinct(word for one in mine for word in words(one, "run")))
    cut = f"; the first {number(max(cuts), 3)} s are left out" if cuts and max(cuts) > 0.0 else ""
    return f"after {runs} power-up{'s' * (runs != 1)}: {', '.join(parts)}{cut}"


def draw(axes: Sequence[Axes], mine: Sequence[Curve], title: str = "") -> None:
    """Draw the start-up of all axes of a test."""
    for ax, curve in zip(axes, mine, strict=True):
        time, left, fitted = (numbers(curve, name) for name in ("time", "residual", "fitted"))
        used = flags(curve, "used")
        order = np.argsort(time, kind="stable")
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        for mask, label, look in (
            (used, "used", {"marker": "o", "color": COLOURS["blue"], "markersize": 2.6}),
            (~used, "left out", {"marker": "o", "markerfacecolor": "none", "markeredgecolor": COLOURS["orange"],
                                 "markersize": 3.2}),
        ):  # fmt: skip
            at = order[mask[order]]
            at = at[thinned(left[at], MOST)]
            if len(at):
                ax.plot(time[at], left[at], linestyle="none", label=label, zorder=2, **look)  # type: ignore[arg-type]
        ax.plot(time[order], fitted[order], color=COLOURS["ink"], linewidth=1.2, label="fitted transient", zorder=4)
        set_labels(ax, y=with_unit(f"{plain(curve.get('axis', ''), 12)}", unit(curve, "residual")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("time since power-up", unit(mine[-1], "time")))
    handles: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    set_legend(axes[-1], list(handles.values()))
