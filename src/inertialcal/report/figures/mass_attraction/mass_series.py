"""One run with a moved mass, before and after reduction: readings with their drift, and the line that is left.

Above, mean of each dwell and what is taken as drift. Below, without the drift (and the tilt), with the line of the
drive: dots are dwells, filled where the mass attracts more than in the middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "mass_series"
SHOWS = (
    "Above, mean of each dwell over time with the drift; below, what is left of it with the line of the drive; filled"
    " where the mass attracts more than in the middle of its travel"
)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "reduced"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve), SHOWS, (1.7, 1.7), paint, data=(curve,))


def finding(curve: Curve) -> str:
    """Return the finding: how far the readings drift, and how large the line is."""
    reading, line = finite(numbers(curve, "reading")), finite(numbers(curve, "line"))
    of = plain(unit(curve, "reading"))
    swing = number(float(0.5 * np.ptp(line)), 2) if len(line) else "no"
    spread = number(float(np.ptp(reading)), 2) if len(reading) else "no"
    return f"{plain(curve.get('recording', ''))}: a line of {swing} {of} in readings that range over {spread} {of}"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw a run.

    Parameters
    ----------
    axes : sequence of Axes, length 2
        With one x axis.
    curve : mapping
        ``mass_series`` of ``results.json``.
    title : str
        Above the first; empty for none.
    """
    above, below = axes
    time = numbers(curve, "time")
    reading, drift, reduced, line = (numbers(curve, name) for name in ("reading", "drift", "reduced", "line"))
    above.plot(time, reading, linestyle="none", marker="o", markersize=2.6, color=COLOURS["blue"], label="dwells")
    above.plot(time, drift, color=COLOURS["ink"], linewidth=1.2, label="drift")
    below.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    below.plot(time, line, color=COLOURS["vermilion"], linewidth=0.9, label="line of the drive", zorder=2)
    nearer = numbers(curve, "shape") > 0.0
    for mask, look, label in (
        (nearer, {"color": COLOURS["blue"]}, "more attracted"),
        (~nearer, {"markerfacecolor": "none", "markeredgecolor": COLOURS["blue"]}, "not more attracted"),
    ):
        if np.isfinite(reduced[mask]).any():
            below.plot(time[mask], reduced[mask], linestyle="none", marker="o", markersize=2.8, label=label, zorder=3,
                       **look)  # type: ignore[arg-type]  # fmt: skip
    set_title(above, title)
    set_labels(above, y=with_unit("reading", unit(curve, "reading")))
    set_labels(below, with_unit("time", unit(curve, "time")), with_unit("reduced", unit(curve, "reduced")))
    seen = dict(zip(*reversed(above.get_legend_handles_labels()), strict=True))
    seen |= dict(zip(*reversed(below.get_legend_handles_labels()), strict=True))
    set_legend(below, list(seen.values()))
