"""Forecast of a mass-attraction test: uncertainty of the scale factor over hours, by drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "mass_forecast"
SHOWS = "Standard uncertainty of the scale factor over the length of the test, both logarithmic, a line for each drive"
LOOKS = {"sine": ("vermilion", "-"), "square": ("orange", "--"), "abab": ("blue", "-.")}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    every = curves(results, NAME)
    tests = dict.fromkeys(str(one.get("test", "")) for one in every)
    by_test = {test: [one for one in every if one.get("test", "") == test] for test in tests}
    return [
        Picture(NAME, test, "", finding(mine), SHOWS, (2.6,), partial(draw, mine)) for test, mine in by_test.items()
    ]


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: the uncertainty at the end, with the first drive and the best one."""
    last = {plain(one.get("of", ""), 12): float(numbers(one, "u")[-1]) for one in mine}
    hours = float(numbers(mine[0], "time")[-1])
    best = min(last, key=lambda name: last[name])
    first = next(iter(last))
    reached = f"{last[first]:.2g} % with {first}, {last[best]:.2g} % with {best}"
    return f"after {hours:.3g} h the uncertainty of the scale factor is {reached}"


def draw(mine: Sequence[Curve], axes: Sequence[Axes], title: str) -> None:
    """Draw all drives."""
    (ax,) = axes
    for one in mine:
        name = plain(one.get("of", ""), 12)
        colour, line = LOOKS.get(name, ("green", "-"))
        ax.plot(numbers(one, "time"), numbers(one, "u"), line, color=COLOURS[colour], label=name, zorder=3)
    applied = numbers(mine[0], "u_applied")
    there = bool(np.any(applied > 0.0))
    if there:
        name = "uncertainty of what is applied"
        ax.plot(numbers(mine[0], "time"), applied, ":", color=COLOURS["quiet"], label=name, zorder=2)
    every = [numbers(one, "u") for one in mine] + ([applied] if there else [])
    log_axis(ax, "x", np.concatenate([numbers(one, "time") for one in mine]))
    log_axis(ax, "y", np.concatenate(every), 1.2)
    set_title(ax, title)
    set_labels(
        ax,
        with_unit("length of the test", unit(mine[0], "time")),
        with_unit("u of the scale factor", unit(mine[0], "u")),
    )
    set_legend(ax)
