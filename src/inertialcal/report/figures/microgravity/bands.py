"""Level of each third of an octave, with the requirement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "microgravity_bands"
SHOWS = "Root mean square of each third of an octave over frequency, both logarithmic"
HEIGHT = 2.8  # of the panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis, that of all together first."""
    known = curves(results, NAME)
    return [_picture(one) for one in sorted(known, key=lambda one: one.get("axis") != "rss")]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    return Picture(
        NAME, str(curve.get("test", "")), str(curve.get("axis", "")), finding(curve), SHOWS, (HEIGHT,), paint
    )


def _limit(curve: Curve) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return numbers(curve, "limit") if "limit" in curve["columns"] else np.full(len(numbers(curve, "rms")), np.nan)


def finding(curve: Curve) -> str:
    """Return the finding: the band that comes nearest to the curve, or the highest."""
    rms, limit, frequency = numbers(curve, "rms"), _limit(curve), numbers(curve, "frequency")
    of = "All axes" if curve.get("axis") == "rss" else plain(curve.get("axis", ""))
    if np.isfinite(limit).any():
        at = int(np.nanargmax(rms / limit))
        return f"{of}: {number(float(rms[at] / limit[at]), 3)} of the curve at {number(float(frequency[at]), 3)} Hz"
    at = int(np.nanargmax(rms))
    level = f"{number(float(rms[at]), 3)} {plain(unit(curve, 'rms'))}"
    return f"{of}: highest at {number(float(frequency[at]), 3)} Hz, {level}"


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw levels of bands, and between which levels blocks lie."""
    low, high, middle = (numbers(curve, name) for name in ("low", "high", "frequency"))
    rms, below, above = (numbers(curve, name) for name in ("rms", "interval_low", "interval_high"))
    least, largest, limit = numbers(curve, "block_least"), numbers(curve, "block_largest"), _limit(curve)
    edges = np.append(low, high[-1])
    ax.fill_between(np.repeat(edges, 2)[1:-1], np.repeat(least, 2), np.repeat(largest, 2), color=COLOURS["sky"],
                    alpha=0.35, linewidth=0.0, label="least to largest of blocks")  # fmt: skip
    ax.stairs(rms, edges, color=COLOURS["blue"], linewidth=1.0, baseline=None)
    ax.errorbar(middle, rms, np.vstack([rms - below, above - rms]), color=COLOURS["blue"], linestyle="none", marker="o",
                markersize=2.8, elinewidth=0.9, capsize=1.5, label="record, 95 %")  # fmt: skip
    shown = [rms, least, largest]
    if np.isfinite(limit).any():
        ax.stairs(limit, edges, color=COLOURS["vermilion"], linewidth=1.4, baseline=None, label="requirement")
        shown.append(limit)
    if "own_noise" in curve["columns"]:
        ax.stairs(numbers(curve, "own_noise"), edges, color=COLOURS["quiet"], linewidth=1.0, linestyle=(0, (3, 2)),
                  baseline=None, label="own noise of the sensor")  # fmt: skip
    log_axis(ax, "x", edges, 1.05)
    log_axis(ax, "y", finite(np.concatenate(shown)), 1.4)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", "Hz"), with_unit("rms", unit(curve, "rms")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
