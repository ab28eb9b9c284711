"""One run with a moved mass: readings with their drift, and the reduced readings with the line.

Above, mean of each dwell and drift. Below, without drift and tilt, with the line of the drive; filled dots: dwells in
which the mass attracts more than in the middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "mass_series"
SHOWS = (
    "Above, mean of each dwell over time with the drift; below, without drift, with the line of the drive; filled:"
    " the mass attracts more than in the middle of its travel"
)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [
        Picture(NAME, str(one.get("test", "")), str(one.get("axis", "")), finding(one), SHOWS, (1.7, 1.7),
                partial(draw, one), data=(one,))
        for one in curves(results, NAME)
        if len(finite(numbers(one, "reduced"))) > 1
    ]  # fmt: skip


def finding(curve: Curve) -> str:
    """Return the finding: amplitude of the line, and range of the readings."""
    reading, line = finite(numbers(curve, "reading")), finite(numbers(curve, "line"))
    of = plain(unit(curve, "reading"))
    swing = number(float(0.5 * np.ptp(line)), 2) if len(line) else "no"
    spread = number(float(np.ptp(reading)), 2) if len(reading) else "no"
    return f"{plain(curve.get('recording', ''))}: a line of {swing} {of} in readings that range over {spread} {of}"


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw a run."""
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
