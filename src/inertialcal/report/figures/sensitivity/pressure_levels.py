"""Change of the bias at levels of pressure that lie decades apart, with the interval of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, distinct, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_title, with_unit
from .panels import HEIGHT, by_test

NAME, CURVE = "sensitivity_pressure", "pressure_levels"
ROOM = 2.0  # factor that is left free on both sides of the pressures
SHOWS = "Change of the bias at each level of pressure from the lowest, with its 95 % interval"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test, with a panel a sensor."""
    return [_picture(test, own, results.get("results", [])) for test, own in by_test(results, CURVE).items()]


def _picture(test: str, own: Sequence[Curve], rows: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, own, title)

    axes = distinct(one["axis"] for one in own)
    return Picture(NAME, test, "", finding(test, axes, rows), SHOWS, (HEIGHT,) * len(own), paint, data=tuple(own))


def finding(test: str, axes: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: the largest change of each sensor."""
    mine = [
        row for row in rows if row["test"] == test and row["quantity"] == "bias_change" and row["value"] is not None
    ]
    said = []
    for axis in axes:
        if own := [row for row in mine if row["axis"] == axis]:
            largest = max(own, key=lambda row: abs(row["value"]))
            said.append(f"{plain(axis, 12)} {with_uncertainty(largest['value'], largest['u'])}")
    if not said:
        return f"{', '.join(plain(axis, 12) for axis in axes)}: bias by level of pressure"
    return f"Largest change from the lowest pressure: {', '.join(said)} {plain(mine[0]['unit'])}"


def draw(axes: Sequence[Axes], own: Sequence[Curve], title: str = "") -> None:
    """Draw each sensor on a panel of its own, over the logarithm of the pressure."""
    for ax, one in zip(axes, own, strict=True):
        pressure, change, lo, hi = (numbers(one, name) for name in ("pressure", "change", "lo", "hi"))
        bars = np.maximum(np.stack([change - lo, hi - change]), 0.0)
        ax.errorbar(pressure, change, bars, fmt="o", color=COLOURS["blue"], markersize=3.5, capsize=2.5, linewidth=1.0)
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
        log_axis(ax, "x", pressure, ROOM)
        set_labels(ax, y=with_unit(f"{plain(one['axis'], 12)} change", unit(one, "change")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("pressure", unit(own[0], "pressure")))
