"""Slow acceleration over time: means of blocks, means of orbits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit
from .clock import scaled

NAME = "microgravity_slow"
SHOWS = "Mean of each block over time, a panel an axis"
HEIGHT = 1.3  # of a panel [in]
FACTOR = 1.96


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    orbits = {str(one.get("test", "")): one for one in curves(results, "microgravity_orbits")}
    return [_picture(one, orbits.get(str(one.get("test", "")))) for one in curves(results, NAME)]


def _axes(curve: Curve) -> list[str]:
    return [name for name in ("x", "y", "z") if name in curve["columns"]]


def _picture(curve: Curve, orbits: Curve | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, orbits, title)

    data = [curve] if orbits is None else [curve, orbits]
    panels = (HEIGHT,) * len(_axes(curve))
    return Picture(NAME, str(curve.get("test", "")), "", finding(curve), SHOWS, panels, paint, data=data)


def finding(curve: Curve) -> str:
    """Return the finding: which axis moves most, and by how much."""
    spans = {axis: float(np.nanmax(numbers(curve, axis)) - np.nanmin(numbers(curve, axis))) for axis in _axes(curve)}
    most = max(spans, key=lambda axis: spans[axis])
    return f"Slow acceleration: {most} moves most, by {number(spans[most], 3)} {plain(unit(curve, most))}"


def draw(axes: Sequence[Axes], curve: Curve, orbits: Curve | None, title: str = "") -> None:
    """Draw a panel an axis."""
    time, word = scaled(numbers(curve, "time"))
    times = numbers(curve, "time")
    share = float(time[-1] / times[-1]) if times[-1] else 1.0
    for ax, axis in zip(axes, _axes(curve), strict=True):
        ax.errorbar(time, numbers(curve, axis), FACTOR * numbers(curve, f"u_{axis}"), color=COLOURS["blue"],
                    elinewidth=0.7, linestyle="none", marker=".", markersize=3.0,
                    label="block, 95 % without the bias")  # fmt: skip
        if orbits is not None:
            ax.plot(numbers(orbits, "time") * share, numbers(orbits, axis), color=COLOURS["vermilion"], marker="D",
                    markersize=3.6, linewidth=1.0, label="mean of an orbit")  # fmt: skip
        set_labels(ax, with_unit("time", word), with_unit(axis, unit(curve, axis)))
    set_title(axes[0], title)
    for ax in axes[:-1]:
        ax.set_xlabel("")
    set_legend(axes[-1])


__all__ = ["NAME", "draw", "finding", "pictures"]
