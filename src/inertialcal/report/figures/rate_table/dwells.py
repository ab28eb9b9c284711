"""Dwells found on the trace of a recording: what was used and what was left out, over what the channel read.

The trace is the least and the largest value per bin, drawn as one line that goes from one to the other; a gap in
the recording is a gap in the line.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from numpy.typing import NDArray

from ....core.estimate import Array
from ..drawing.data import Curve, curves, distinct, envelope, finite, flags, numbers, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "dwells"
OTHERS = " The other recordings of this test are in results.json."
SHOWS = "Trace of the channel over time; shaded are the dwells that were used, hatched those that were left out"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a recording whose dwells were found."""
    traces: dict[tuple[Any, ...], Curve] = {}
    for curve in curves(results, "trace"):
        if len(finite(numbers(curve, "lo"))):
            traces.setdefault(_place(curve), curve)
    every = curves(results, NAME)
    tests = Counter(curve.get("test", "") for curve in every)
    return [
        _picture(traces[_place(curve)], curve, tests[curve.get("test", "")] > 1)
        for curve in every
        if _place(curve) in traces
    ]


def _place(curve: Curve) -> tuple[Any, ...]:
    """Return what dwells have in common with the trace that they were found on."""
    return curve.get("test"), curve.get("recording"), curve.get("axis")


def _picture(trace: Curve, dwells: Curve, one_of_several: bool) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], trace, dwells, title)

    test, axis = str(dwells.get("test", "")), str(dwells.get("axis", ""))
    note = (OTHERS,) if one_of_several else ()
    return Picture(NAME, test, axis, finding(dwells), SHOWS, (2.0,), paint, data=(dwells, trace), note=note)


def finding(dwells: Curve) -> str:
    """Return the finding: how many dwells were found, and how many of them left out."""
    used = flags(dwells, "used")
    left = f", {np.sum(~used)} of them left out" if np.any(~used) else ""
    return f"{plain(dwells.get('recording', ''))}, {plain(dwells.get('axis', ''))}: {len(used)} dwells found{left}"


def draw(ax: Axes, trace: Curve, dwells: Curve, title: str = "") -> None:
    """Draw one recording."""
    time, lo, hi = (numbers(trace, name) for name in ("time", "lo", "hi"))
    ax.plot(*envelope(time, lo, hi), color=COLOURS["ink"], linewidth=0.9, solid_capstyle="projecting", zorder=3)
    patches = _spans(ax, dwells)
    set_title(ax, title)
    set_labels(ax, with_unit("time", unit(trace, "time")), with_unit(plain(trace.get("axis", "")), unit(trace, "lo")))
    set_legend(ax, patches)


def _spans(ax: Axes, dwells: Curve) -> list[Patch]:
    start, stop = numbers(dwells, "start"), numbers(dwells, "stop")
    used, reasons = flags(dwells, "used"), np.array(words(dwells, "reason"))
    shaded: dict[str, Any] = {"facecolor": COLOURS["green"], "alpha": 0.28, "linewidth": 0.0}
    hatched: dict[str, Any] = {
        "facecolor": "none", "edgecolor": COLOURS["vermilion"], "hatch": "////", "linewidth": 0.6
    }  # fmt: skip
    found = []
    if np.any(used):
        _bars(ax, start[used], stop[used], shaded)
        found.append(Patch(label=f"dwells used ({np.sum(used)})", **shaded))
    for reason in distinct(reasons[~used]):
        mine = ~used & (reasons == reason)
        _bars(ax, start[mine], stop[mine], hatched)
        word = plain(reason or "no rule named").replace("_", " ")
        found.append(Patch(label=f"left out, {word} ({np.sum(mine)})", **hatched))
    return found


def _bars(ax: Axes, start: Array, stop: Array, look: Mapping[str, Any]) -> None:
    known: NDArray[np.bool_] = np.isfinite(start) & np.isfinite(stop)
    widths = (stop - start)[known]
    ax.broken_barh(
        list(zip(start[known].tolist(), widths.tolist(), strict=True)), (0.0, 1.0),
        transform=ax.get_xaxis_transform(), zorder=1, **look,
    )  # fmt: skip
