"""What the fit of a sensitivity leaves of each level, power-up by power-up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, distinct, finite, numbers, unit, words
from ..drawing.metrics import width
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_title, with_unit
from .panels import HEIGHT, places

NAME = "sensitivity_residuals"
SHOWS = "Residuals of the levels in the order of time, power-ups apart"
ROOM = 290.0  # for the names of all power-ups [pt]
GAP = 6.0  # between two of them [pt]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test, with a panel a sensor."""
    found: dict[str, list[Curve]] = {}
    for one in curves(results, NAME):
        if len(finite(numbers(one, "residual"))):
            found.setdefault(one["test"], []).append(one)
    return [_picture(test, own) for test, own in found.items()]


def _picture(test: str, own: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, own, title)

    return Picture(NAME, test, "", finding(own), SHOWS, (HEIGHT,) * len(own), paint, data=tuple(own))


def finding(own: Sequence[Curve]) -> str:
    """Return the finding: how much is left of each sensor."""
    left = [
        f"{plain(one['axis'], 12)} {float(np.sqrt(np.mean(finite(numbers(one, 'residual')) ** 2))):.2g}" for one in own
    ]
    count = len(distinct(run for one in own for run in words(one, "run")))
    ups = f"{count} power-up{'s' if count != 1 else ''}"
    return f"Levels of {ups} scatter about the fit by {', '.join(left)} {plain(unit(own[0], 'residual'))}"


def draw(axes: Sequence[Axes], own: Sequence[Curve], title: str = "") -> None:
    """Draw residuals over the number of the level; a power-up has the same stretch in each panel."""
    runs = distinct(run for one in own for run in words(one, "run"))
    every = [places(words(one, "run"), runs) for one in own]
    sizes = [max(len(mine[i]) for mine in every) for i in range(len(runs))]
    starts = np.concatenate([[0], np.cumsum(np.array(sizes) + 1)])[:-1]
    for ax, one, mine in zip(axes, own, every, strict=True):
        left = numbers(one, "residual")
        for i, at in enumerate(mine):
            colour = COLOURS["blue" if i % 2 == 0 else "vermilion"]
            ax.plot(starts[i] + np.arange(len(at)), left[at], "o-", color=colour, markersize=3.0, linewidth=0.7)
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.6, zorder=1)
        set_labels(ax, y=with_unit(plain(one["axis"], 12), unit(one, "residual")))
    middle = starts + (np.array(sizes) - 1) / 2.0
    set_title(axes[0], title)
    _name_power_ups(axes[-1], middle, runs)


def _name_power_ups(ax: Axes, middle: np.ndarray[Any, Any], runs: Sequence[str]) -> None:
    """Name power-ups under their levels; number them where there is no room for names, and not all if they are many."""
    names = [plain(run, 40) for run in runs]
    widths = np.array([width(name, TEXT - 1.0) for name in names]) + GAP
    widest = float(widths.max())
    apart = np.diff(middle) * ROOM / np.ptp(ax.get_xlim())
    named = widest * len(names) <= ROOM and bool(np.all(apart >= 0.5 * (widths[1:] + widths[:-1])))
    if not named:
        names = [f"{i}" for i in range(1, len(runs) + 1)]
        widest = width(names[-1], TEXT - 1.0) + GAP
    every = max(1, int(np.ceil(widest * len(names) / ROOM)))
    ax.set_xticks(middle[::every], names[::every], parse_math=False)
    set_labels(ax, "levels of power-up" if named else "levels of power-up, numbered as they come")
