"""Two figures: the means, and how they change from one recording to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from matplotlib.axes import Axes

from inertialcal.report.figures.drawing.data import curves, numbers, unit
from inertialcal.report.figures.drawing.picture import Picture
from inertialcal.report.figures.drawing.style import set_labels, set_title, with_unit

COLUMN = {"means": ("mean_readings", "mean"), "mean_steps": ("mean_steps", "step")}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return both pictures of each axis."""
    found = []
    for name, (curve, column) in COLUMN.items():
        for one in curves(results, curve):
            values = numbers(one, column)
            title = f"{one['axis']}: {len(values)} {column}s"
            paint = partial(draw, one, column)
            found.append(Picture(name, one["test"], one["axis"], title, f"{column} by recording", (2.0,), paint))
    return found


def draw(curve: Mapping[str, Any], column: str, axes: Sequence[Axes], title: str) -> None:
    """Draw a column over the number of the recording."""
    axes[0].plot(numbers(curve, "recording"), numbers(curve, column), marker="o")
    set_title(axes[0], title)
    set_labels(axes[0], "recording", with_unit(column, unit(curve, column)))
