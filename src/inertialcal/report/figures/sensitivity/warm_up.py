"""Warm-up over power-ups: means less the settled level of each, with the joint fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, distinct, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .panels import HEIGHT, by_test, plot_power_ups

NAME, CURVE = "sensitivity_warm_up", "warm_up_joint"
SHOWS = "Readings after power-up less the settled level of each power-up, with the joint fit"
SHOWN = 40  # points of a power-up


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test, with a panel a sensor."""
    return [_picture(test, own, results.get("results", [])) for test, own in by_test(results, CURVE).items()]


def _picture(test: str, own: Sequence[Curve], rows: Sequence[Mapping[str, Any]]) -> Picture:
    axes = distinct(one["axis"] for one in own)

    def paint(panels: Sequence[Axes], title: str) -> None:
        draw(panels, own, title)

    return Picture(
        NAME, test, "", finding(test, axes, rows), SHOWS, (HEIGHT,) * len(axes), paint, data=tuple(own)
    )  # fmt: skip


def finding(test: str, axes: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: largest amplitude and times, or that there is no warm-up."""
    mine = [row for row in rows if row["test"] == test and row["value"] is not None]
    amplitudes = [row for row in mine if row["quantity"] == "bias_warm_up" and row["axis"] in axes]
    times = [row for row in mine if row["quantity"] == "warm_up_time" and row["u"]]
    if not amplitudes:
        return f"{', '.join(plain(axis, 12) for axis in axes)}: warm-up not estimated"
    largest = max(amplitudes, key=lambda row: (row["status"] != "upper_limit", abs(row["value"])))
    axis, of = plain(largest["axis"], 12), plain(largest["unit"])
    if largest["status"] == "upper_limit":
        return f"No warm-up seen: below {largest['value']:.2g} {of} on {axis}"
    after = " and ".join(f"{with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}" for row in times)
    size = with_uncertainty(largest["value"], largest["u"])
    return f"Bias at power-up: {size} {of} on {axis}" + (f"; time constant {after}" if after else "")


def draw(axes: Sequence[Axes], own: Sequence[Curve], title: str = "") -> None:
    """Draw power-ups, thinned out, and the fit, each sensor on a panel of its own."""
    runs = distinct(str(one.get("of", "")) for one in own)
    for ax, axis in zip(axes, distinct(one["axis"] for one in own), strict=True):
        mine = [one for one in own if one["axis"] == axis]
        points: dict[str, list[Array]] = {run: [] for run in runs}
        for one in mine:
            time, reading, model = (numbers(one, name) for name in ("time", "reading", "model"))
            order = np.argsort(time)
            at = order[np.linspace(0, len(order) - 1, min(SHOWN, len(order))).round().astype(int)]
            points[str(one.get("of", ""))].append(np.stack([time[at], reading[at]]))
            label = "joint fit" if one is mine[0] else None
            ax.plot(time[order], model[order], color=COLOURS["blue"], linewidth=1.2, label=label, zorder=4)
        plot_power_ups(ax, {run: np.hstack([np.empty((2, 0)), *points[run]]) for run in runs}, "power-ups")
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
        set_labels(ax, y=with_unit(plain(axis, 12), unit(mine[0], "reading")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("time since power-up", unit(own[0], "time")))
    set_legend(axes[-1])
