"""One run over the angle of its mass: means of the readings without drift, and the harmonics that were fitted."""

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

NAME = "turned_turn"
SHOWS = (
    "Means of the readings of one run without drift over the angle of its mass, with 95 % intervals; line: as fitted"
)
TWO_SIDED = 1.96  # standard uncertainties of 95 %


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [
        Picture(NAME, str(one.get("test", "")), str(one.get("axis", "")), finding(one), SHOWS, (2.3,),
                partial(draw, one), data=(one,))
        for one in curves(results, NAME)
        if len(finite(numbers(one, "reading"))) > 1
    ]  # fmt: skip


def finding(curve: Curve) -> str:
    """Return the finding: the swing of the line and the turn."""
    swing = number(float(0.5 * np.ptp(numbers(curve, "line"))), 2)
    name, turn = plain(curve.get("recording", "")), plain(curve.get("of", ""))
    return f"{name}, a turn in {turn}: the readings swing by {swing} {plain(unit(curve, 'reading'))}"


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw a run."""
    (ax,) = axes
    angle, value, u, line = (numbers(curve, name) for name in ("angle", "reading", "u", "line"))
    order = np.argsort(angle)
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.vlines(angle, value - TWO_SIDED * u, value + TWO_SIDED * u, color=COLOURS["blue"], linewidth=1.2, zorder=2)
    ax.plot(
        angle, value, linestyle="none", marker="o", markersize=4.0, color=COLOURS["blue"], label="readings", zorder=3
    )
    ax.plot(angle[order], line[order], color=COLOURS["vermilion"], linewidth=1.2, label="fitted", zorder=4)
    if unit(curve, "angle") == "deg":
        ax.set_xlim(0.0, 360.0)
        ax.set_xticks(np.arange(0.0, 361.0, 60.0))
    set_title(ax, title)
    set_labels(ax, with_unit("angle of the mass", unit(curve, "angle")), with_unit("reading", unit(curve, "reading")))
    set_legend(ax)
