"""Plan of a turned mass: response over attraction by the time of a turn, for both senses, and the planned runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import uncertainty
from ..drawing.data import Curve, curves, finite, flags, numbers
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title

NAME = "turned_forecast"
SHOWS = (
    "Response over the attraction by the time of a turn, with the orbit (solid) and against it (dashed); where a line"
    " crosses zero, recoil and attraction cancel; dots: the planned runs, with their 95 % intervals"
)
LOOKS = {"with": ("blue", "-", "with the orbit"), "against": ("vermilion", "--", "against the orbit")}
TWO_SIDED = 1.96  # standard uncertainties of 95 %
LOWEST = -1.5  # of the responses that are drawn: faster turns are all recoil


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the picture of a plan."""
    lines = [one for one in curves(results, "turned_null") if len(finite(numbers(one, "response")))]
    runs = [one for one in curves(results, "turned_planned") if len(finite(numbers(one, "response")))]
    if not lines or not runs:
        return []
    test = str(runs[0].get("test", ""))
    return [Picture(NAME, test, "", finding(results), SHOWS, (2.8,), partial(draw, lines, runs[0]), data=(runs[0],))]


def finding(results: Mapping[str, Any]) -> str:
    """Return the finding: the uncertainty of the scale factor, and the nulls of recoil."""
    rows = results.get("results", [])
    u = [row["value"] for row in rows if row["quantity"] == "scale_factor_uncertainty" and not row["member"]]
    nulls = [
        f"{row['value']:.0f} s {plain(row['member']['label'])}" for row in rows if row["quantity"] == "null_period"
    ]
    said = f"scale factor to {uncertainty(100.0 * u[0])} %" if u else "scale factor not known"
    return f"{said}; recoil cancels at {' and '.join(nulls)}" if nulls else said


def draw(lines: Sequence[Curve], runs: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw lines and runs."""
    (ax,) = axes
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    for one in lines:
        of = str(one.get("of", ""))
        colour, style, label = LOOKS.get(of, ("green", "-.", plain(of)))
        ax.plot(numbers(one, "period"), numbers(one, "response"), style, color=COLOURS[colour], label=label, zorder=2)
    period, response, u = (numbers(runs, name) for name in ("period", "response", "u"))
    ahead = flags(runs, "ahead")
    for mask, colour in ((ahead, "blue"), (~ahead, "vermilion")):
        half = TWO_SIDED * np.nan_to_num(u[mask])
        ax.vlines(
            period[mask], response[mask] - half, response[mask] + half, color=COLOURS[colour], linewidth=1.3, zorder=3
        )
        ax.plot(
            period[mask], response[mask], linestyle="none", marker="o", markersize=5.0, color=COLOURS[colour], zorder=4
        )
    low = min(LOWEST, float(finite(response).min()) - 0.1)
    ax.set_xlim(0.0, max(float(numbers(lines[0], "period")[-1]), 1.1 * float(period.max())))
    ax.set_ylim(low, 1.3)
    set_title(ax, title)
    set_labels(ax, "time of a turn [h]", "response / attraction")
    set_legend(ax)
