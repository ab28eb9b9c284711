"""What the fit of a sensitivity leaves of each level, power-up by power-up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, distinct, numbers, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_title, with_unit

NAME = "sensitivity_residuals"
SHOWS = "Residuals of the levels in the order of time, power-ups apart"
HEIGHT = 1.7  # of a panel [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a sensor."""
    return [_picture(one) for one in curves(results, NAME)]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    return Picture(NAME, curve["test"], curve["axis"], finding(curve), SHOWS, (HEIGHT,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: how much is left."""
    left = numbers(curve, "residual")
    rms = float(np.sqrt(np.nanmean(left**2)))
    count = len(distinct(words(curve, "run")))
    return (
        f"{plain(curve['axis'], 12)}: levels of {count} power-ups scatter by {rms:.2g} {plain(unit(curve, 'residual'))}"
    )


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw residuals over the number of the level; power-ups stand apart."""
    (ax,) = axes
    left, runs = numbers(curve, "residual"), words(curve, "run")
    start, ticks, names = 0, [], []
    for i, run in enumerate(distinct(runs)):
        mine = left[[one == run for one in runs]]
        at = start + np.arange(len(mine))
        ax.plot(at, mine, "o-", color=COLOURS["blue" if i % 2 == 0 else "vermilion"], markersize=3.0, linewidth=0.7)
        ticks.append(float(at.mean()))
        names.append(plain(run, 12))
        start += len(mine) + 1
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
    ax.set_xticks(ticks, names)
    set_title(ax, title)
    set_labels(ax, "levels of power-up", with_unit(f"{plain(curve['axis'], 12)} residual", unit(curve, "residual")))
