"""Warm-up over power-ups: means less the settled level of each, with the joint fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME, CURVE = "sensitivity_warm_up", "warm_up_joint"
SHOWS = "Readings after power-up less the settled level of each power-up, with the joint fit"
HEIGHT = 2.4  # [in]
MARKS = "osD^v<>ph*"
NAMED = 6  # power-ups that a legend names
SHOWN = 40  # points of a power-up


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a sensor."""
    every = list(curves(results, CURVE))
    found = []
    for test, axis in dict.fromkeys((one["test"], one["axis"]) for one in every):
        own = [one for one in every if (one["test"], one["axis"]) == (test, axis)]
        found.append(_picture(own, test, axis, results.get("results", [])))
    return found


def _picture(own: Sequence[Curve], test: str, axis: str, rows: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, own, title)

    return Picture(NAME, test, axis, finding(test, axis, rows), SHOWS, (HEIGHT,), paint, data=tuple(own))


def finding(test: str, axis: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: amplitudes and times, or that there is no warm-up."""
    mine = [row for row in rows if row["test"] == test and row["value"] is not None]
    amplitudes = [row for row in mine if row["quantity"] == "bias_warm_up" and row["axis"] == axis]
    times = {row["power"]: row for row in mine if row["quantity"] == "warm_up_time"}
    name = plain(axis, 12)
    said = []
    for row in amplitudes:
        if row["status"] == "upper_limit":
            return f"{name}: no warm-up seen; below {row['value']:.2g} {plain(row['unit'])}"
        tau = times.get(row["power"])
        of = f", time constant {with_uncertainty(tau['value'], tau['u'])} s" if tau is not None and tau["u"] else ""
        said.append(f"{with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}{of}")
    return f"{name} starts off by {' and '.join(said)}" if said else f"{name}: warm-up not estimated"


def draw(axes: Sequence[Axes], own: Sequence[Curve], title: str = "") -> None:
    """Draw power-ups, thinned out, and the fit."""
    (ax,) = axes
    for i, one in enumerate(own):
        time, reading, model = (numbers(one, name) for name in ("time", "reading", "model"))
        order = np.argsort(time)
        at = order[np.linspace(0, len(order) - 1, min(SHOWN, len(order))).round().astype(int)]
        label = plain(one.get("of", ""), 16) if len(own) <= NAMED else ("power-ups" if i == 0 else None)
        ax.plot(time[at], reading[at], MARKS[i % len(MARKS)], color=COLOURS["vermilion"], markersize=3.0,
                markerfacecolor="none", label=label, zorder=2)  # fmt: skip
        label = "joint fit" if i == len(own) - 1 else None
        ax.plot(time[order], model[order], color=COLOURS["blue"], linewidth=1.2, label=label, zorder=3)
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
    set_title(ax, title)
    set_labels(ax, with_unit("time since power-up", unit(own[0], "time")),
               with_unit(f"{plain(own[0]['axis'], 12)} less settled", unit(own[0], "reading")))  # fmt: skip
    set_legend(ax)
