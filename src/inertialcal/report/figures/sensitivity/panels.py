"""Panels of a sensitivity test: its sensors one below the other, its power-ups marked alike in each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.estimate import Array
from ..drawing.data import Curve, curves
from ..drawing.style import COLOURS, plain

HEIGHT = 1.35  # of a panel [in]
MARKS = "osD^v<>ph*"
NAMED = 6  # power-ups that a legend names


def by_test(results: Mapping[str, Any], name: str) -> dict[str, list[Curve]]:
    """Return the curves of a name, by the test that they are of."""
    found: dict[str, list[Curve]] = {}
    for one in curves(results, name):
        found.setdefault(one["test"], []).append(one)
    return found


def plot_power_ups(ax: Axes, points: Mapping[str, Array], several: str) -> None:
    """Draw the points of each power-up with a mark of its own; a legend names them where they are few.

    Parameters
    ----------
    ax : Axes
        What is drawn on.
    points : mapping of str to ndarray, shape (2, n)
        Of each power-up, by its name.
    several : str
        What a legend says of all power-ups where they are many.
    """
    for i, (name, (x, y)) in enumerate(points.items()):
        label = plain(name, 16) if len(points) <= NAMED else several if i == 0 else None
        ax.plot(
            x, y, MARKS[i % len(MARKS)], color=COLOURS["vermilion"], markersize=3.5, markerfacecolor="none",
            label=label, zorder=3,
        )  # fmt: skip


def places(runs: Sequence[str], names: Iterable[str]) -> list[NDArray[np.intp]]:
    """Return the places of each power-up among the points."""
    every = np.array(runs, dtype=object)
    return [np.flatnonzero(every == name) for name in names]
