"""Allan deviation over averaging time: each record with its interval, the fitted terms, and all of them together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, distinct, finite, numbers, thinned, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .noise_terms import DOTS, draw_terms, finding, mark

NAME = "allan"
TERMS, LINE = "allan_terms", "allan_line"
SHOWS = "Deviation over averaging time, both logarithmic; shaded is the 95 % interval, lines are the fitted terms"
HEIGHT = 2.9  # of the panel [in]
MOST = 400  # averaging times drawn of a record
ROOM = 1.35  # factor left free above and below the data
NAMES = {
    "overlapping": "Allan deviation", "non_overlapping": "Allan deviation, without overlap",
    "modified": "modified Allan deviation", "hadamard": "Hadamard deviation, without overlap",
    "overlapping_hadamard": "Hadamard deviation", "total": "total deviation",
    "modified_total": "modified total deviation", "hadamard_total": "Hadamard total deviation",
}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and axis."""
    known = [one for one in curves(results, NAME) if np.any(numbers(one, "deviation") > 0.0)]
    terms = [*curves(results, TERMS), *curves(results, LINE)]
    found = []
    for test, axis in dict.fromkeys((str(one.get("test", "")), str(one.get("axis", ""))) for one in known):
        mine, lines = (
            [one for one in every if (one.get("test", ""), one.get("axis", "")) == (test, axis)]
            for every in (known, terms)
        )
        found.append(_picture(results, test, axis, mine, lines))
    return found


def _picture(
    results: Mapping[str, Any], test: str, axis: str, mine: Sequence[Curve], lines: Sequence[Curve]
) -> Picture:  # fmt: skip
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, lines, title)

    return Picture(NAME, test, axis, finding(results, test, axis, "no noise terms"), SHOWS, (HEIGHT,), paint)


def draw(ax: Axes, mine: Sequence[Curve], lines: Sequence[Curve], title: str = "") -> None:
    """Draw the deviations of all records of an axis, and the terms."""
    for number, curve in enumerate(mine):
        tau, deviation = numbers(curve, "tau"), numbers(curve, "deviation")
        lo, hi = numbers(curve, "lo"), numbers(curve, "hi")
        band = np.isfinite(lo) & np.isfinite(hi) & (lo > 0.0)
        label = "95 % interval" if number == 0 else None
        if band.any():
            ax.fill_between(tau, lo, hi, where=band.tolist(), color=COLOURS["sky"], alpha=0.35, linewidth=0.0, zorder=1,
                            label=label)  # fmt: skip
        at = thinned(deviation, MOST)
        name = plain(curve.get("recording", "")) if len(mine) > 1 else "measured"
        ax.plot(tau[at], deviation[at], linestyle="none", zorder=5, label=name, **DOTS[number % len(DOTS)])
    for curve in (one for one in lines if one["name"] == TERMS):
        compared = numbers(mine[0], "tau"), numbers(mine[0], "expected")
        draw_terms(ax, numbers(curve, "tau"), curve, [one for one in lines if one["name"] == LINE], compared)
    mark(ax, mine[0], "fitted_from", "shortest averaging time fitted (low pass)")
    shown = np.concatenate([finite(numbers(one, name)) for one in mine for name in ("deviation", "lo", "hi")])
    log_axis(ax, "x", np.concatenate([numbers(one, "tau") for one in mine]), 1.15)
    log_axis(ax, "y", shown, ROOM)
    way = NAMES.get(distinct(str(one.get("of", "")) for one in mine)[0], "Allan deviation")
    set_title(ax, title)
    set_labels(ax, with_unit("averaging time", unit(mine[0], "tau")), with_unit(way, unit(mine[0], "deviation")))
    set_legend(ax)


__all__ = ["NAME", "draw", "pictures"]
