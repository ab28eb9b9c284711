"""Errors of hold-out dwells, raw and compensated, against the applied input: one panel per axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, thinned, unit
from ..drawing.picture import Picture
from ..drawing.scales import signed_log
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "compensated"
SHOWS = "Error of each hold-out dwell against the applied input, raw and compensated, one panel per axis"
OTHERS_TURNED = " Points at zero: dwells while another axis turned."
STILL = 0.01  # of the largest input: counts as zero
MOST = 800  # dwells drawn per panel; of more, the smallest and largest of each bin
SERIES: dict[str, dict[str, Any]] = {
    "raw_error": {
        "marker": "D", "markerfacecolor": "none", "markeredgecolor": COLOURS["vermilion"], "markersize": 4.5,
        "label": "raw",
    },
    "compensated_error": {"marker": "o", "color": COLOURS["blue"], "markersize": 3.6, "label": "compensated"},
}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the one picture of the closed loop, if it was run."""
    found = [curve for curve in curves(results, NAME) if len(finite(numbers(curve, "raw_error")))]
    if not found:
        return []

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, found, title)

    loop = results.get("closed_loop", {}).get("axes", [])
    test = str(found[0].get("test", ""))
    note = (OTHERS_TURNED,) if others_turned(found) else ()
    return [Picture(NAME, test, "", finding(found, loop), SHOWS, (1.35,) * len(found), paint, note=note)]


def others_turned(found: Sequence[Curve]) -> bool:
    """Return whether most dwells of an axis have zero input because other axes turned."""
    for one in found:
        sizes = np.abs(finite(numbers(one, "applied")))
        if len(sizes) and np.sum(sizes < STILL * np.max(sizes)) > len(sizes) / 2:
            return True
    return False


def finding(found: Sequence[Curve], loop: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: the error of each axis before and after."""
    parts = [
        f"{plain(one['axis'])} {number(one['raw_rms'], 2)} → {number(one['compensated_rms'], 2)}"
        for one in loop
        if one["raw_rms"] is not None and one["compensated_rms"] is not None
    ]
    if parts:
        return f"rms error on hold-out dwells: {', '.join(parts)} {plain(loop[0]['unit'])}"
    dwells = sum(len(finite(numbers(curve, "raw_error"))) for curve in found)
    return f"{dwells} hold-out dwells, raw and compensated"


def draw(axes: Sequence[Axes], found: Sequence[Curve], title: str = "") -> None:
    """Draw each axis on a panel of its own."""
    everything = np.concatenate([numbers(curve, "applied") for curve in found])
    for ax, curve in zip(axes, found, strict=True):
        signed_log(ax, "x", everything)
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        applied = numbers(curve, "applied")
        for name, look in SERIES.items():
            values = numbers(curve, name)
            at = thinned(values, MOST)
            ax.plot(applied[at], values[at], linestyle="none", zorder=3, **look)
        set_labels(ax, y=with_unit(f"{plain(curve.get('axis', ''), 12)} error", unit(curve, "raw_error")))
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("applied", unit(found[0], "applied")))
    set_legend(axes[-1])
