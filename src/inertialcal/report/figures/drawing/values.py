"""Values of the marks of a figure, to be shown where the pointer rests on one; what is drawn stays as it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ....core.estimate import Array
from ....core.show.rounding import number
from .layout import INCH
from .metrics import shortened

MOST = 60  # points of a figure that show their values: each takes room on the page
DIGITS = 4
SIZE = 8.0  # of the type [pt]
ABOVE = 7.0  # base line of the values below the top of the figure [pt]


@dataclass(frozen=True)
class Point:
    """Marks at one abscissa, and what they stand for."""

    places: tuple[tuple[float, float], ...]  # from the left and the top [pt]
    text: str  # ``"applied 0.1, reading 0.1004, residual 0.0004"``


@dataclass(frozen=True)
class Values:
    """Points of a figure, and where the text of one is to end: at the right edge of its panels [pt]."""

    points: tuple[Point, ...]
    end: float


@dataclass
class _Series:
    """Lines of marks over the same abscissae."""

    x: Array
    lines: list[tuple[Axes, Line2D]] = field(default_factory=list)


def values(figure: Figure) -> Values | None:
    """Return what the marks of a figure stand for; None for one without marks, or with too many.

    Parameters
    ----------
    figure : Figure
        Drawn, and laid out.
    """
    series: list[_Series] = []
    for ax in figure.axes:
        for line in ax.lines:
            if line.get_transform() is not ax.transData or line.get_marker() in {None, "", " ", "none", "None"}:
                continue
            x = np.asarray(line.get_xdata(orig=False), dtype=np.float64)
            known = next((one for one in series if np.array_equal(one.x, x, equal_nan=True)), None)
            if known is None:
                series.append(known := _Series(x))
            known.lines.append((ax, line))
    if not 0 < sum(len(one.x) for one in series) <= MOST:
        return None
    end = max(ax.get_position().x1 for ax in figure.axes) * figure.get_figwidth() * INCH
    points = tuple(point for one in series for point in _points(figure, one, end))
    return Values(points, end) if points else None


def _points(figure: Figure, series: _Series, room: float) -> Iterator[Point]:
    """Yield the points of lines that share their abscissae; marks without a value are not drawn."""
    names = [_name(ax, line, [other for on, other in series.lines if on is ax]) for ax, line in series.lines]
    across = _quantity(figure.axes[-1].get_xlabel() or series.lines[-1][0].get_xlabel())
    scale, high = INCH / figure.dpi, figure.get_figheight() * INCH
    drawn = [_drawn(ax, line) for ax, line in series.lines]
    heights = [np.asarray(line.get_ydata(orig=False), dtype=np.float64) for _, line in series.lines]
    for i, x in enumerate(series.x):
        seen = [k for k, one in enumerate(drawn) if np.all(np.isfinite(one[i]))]
        if seen:
            said = [f"{across} {number(float(x), DIGITS)}".strip()]
            said += [f"{names[k]} {number(float(heights[k][i]), DIGITS)}".strip() for k in seen]
            places = tuple((scale * float(drawn[k][i, 0]), high - scale * float(drawn[k][i, 1])) for k in seen)
            yield Point(places, shortened(", ".join(said), SIZE, room))


def _drawn(ax: Axes, line: Line2D) -> Array:
    """Return where the marks of a line are drawn, shape (n, 2) [px]; nan outside the panel."""
    found = np.asarray(ax.transData.transform(np.asarray(line.get_xydata(), dtype=np.float64)), dtype=np.float64)
    x, y, wide, high = ax.bbox.bounds
    inside = (found >= (x - 1.0, y - 1.0)) & (found <= (x + wide + 1.0, y + high + 1.0))
    return np.where(np.all(inside, axis=1, keepdims=True), found, np.nan)


def _name(ax: Axes, line: Line2D, together: Sequence[Line2D]) -> str:
    """Return the name of a line: that of its legend where several of its panel are at one place, else of its axis."""
    label = str(line.get_label())
    return label if len(together) > 1 and not label.startswith("_") else _quantity(ax.get_ylabel())


def _quantity(label: str) -> str:
    """Return the label of an axis without its unit, in one line."""
    return " ".join(label.partition(" [")[0].split())
