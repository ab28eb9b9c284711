"""Attraction over mass: touching sphere, best body of any shape, and this body (Reinel's Figure 4)."""

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

NAME = "mass_growth"
SHOWS = "Attraction over mass, both logarithmic: best body behind the plane at the stand-off, and sphere touching it"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [
        Picture(NAME, str(one.get("test", "")), "", finding(one), SHOWS, (2.6,), partial(draw, one))
        for one in curves(results, NAME)
    ]


def finding(curve: Curve) -> str:
    """Return the finding: gain of the best shape, and of ten times the mass."""
    mass, best, sphere, own = (numbers(curve, name) for name in ("mass", "best", "sphere", "body"))
    at = int(np.flatnonzero(np.isfinite(own))[0]) if np.isfinite(own).any() else len(mass) - 1
    gain = 100.0 * (best[at] / sphere[at] - 1.0)
    more = float(np.interp(np.log(10.0 * mass[at]), np.log(mass), best)) / best[at]
    return (
        f"the best shape attracts {gain:.0f} % more than a sphere; ten times the mass attracts {more:.1f} times as much"
    )


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw both, and the body."""
    (ax,) = axes
    mass, best, sphere, own = (numbers(curve, name) for name in ("mass", "best", "sphere", "body"))
    ax.plot(mass, best, color=COLOURS["blue"], label="best body of any shape", zorder=3)
    ax.plot(mass, sphere, "--", color=COLOURS["orange"], label="touching sphere", zorder=3)
    ax.plot(mass, own, "o", color=COLOURS["vermilion"], markersize=6.0, label="this body", zorder=4)
    log_axis(ax, "x", mass)
    log_axis(ax, "y", np.concatenate([best, sphere]), 1.2)
    set_title(ax, title)
    set_labels(ax, with_unit("mass", unit(curve, "mass")), with_unit("attraction", unit(curve, "best")))
    set_legend(ax)
