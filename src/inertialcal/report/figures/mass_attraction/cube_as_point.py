"""Error of taking a cube as a point, over its distance in edges (Reinel's Figure 3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "cube_as_point"
SHOWS = "Error of taking a cube as a point over the distance of its middle in edges, both logarithmic, by direction"
LOOKS = {"face": ("blue", "-"), "edge": ("orange", "--"), "corner": ("green", "-.")}
CLAIM = 0.1  # % that Reinel takes as small enough, at twice the edge
AT = 2.0


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [
        Picture(NAME, str(one.get("test", "")), "", finding(one), SHOWS, (2.6,), partial(draw, one))
        for one in curves(results, NAME)
    ]


def finding(curve: Curve) -> str:
    """Return the finding: the error at twice the edge, and from where it is below a thousandth."""
    ratio, face = numbers(curve, "ratio"), np.abs(numbers(curve, "face"))
    at = float(np.exp(np.interp(np.log(AT), np.log(ratio), np.log(face))))
    enough = float(ratio[face > CLAIM].max(initial=0.0))
    return f"a cube differs from a point by {at:.2g} % two edges off its face, by less than 0.1 % from {enough:.2g} on"


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw the size of the error, a line a direction."""
    (ax,) = axes
    ratio = numbers(curve, "ratio")
    every = []
    for name, (colour, line) in LOOKS.items():
        error = numbers(curve, name)
        sign = "stronger" if np.nanmedian(error) > 0.0 else "weaker"
        ax.plot(ratio, np.abs(error), line, color=COLOURS[colour], label=f"toward {name} ({sign})", zorder=3)
        every.append(np.abs(error))
    log_axis(ax, "x", ratio)
    log_axis(ax, "y", np.concatenate(every))
    ax.axhline(CLAIM, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.annotate(
        "0.1 %", (float(ratio[-1]), CLAIM), xytext=(0.0, 3.0), textcoords="offset points", ha="right", fontsize=9.0
    )
    set_title(ax, title)
    set_labels(ax, "distance over edge, R/k", with_unit("error of a point", unit(curve, "face")))
    set_legend(ax)
