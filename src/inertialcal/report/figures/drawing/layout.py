"""Places of panels, labels and legend on a figure of a page, reckoned from its texts before anything is drawn.

A page has dozens of figures. To find room by drawing, as layouts for any figure do, takes longer than the figure
itself; here all is known: the size of the font, the labels, the rows of the legend. Panels have the height that the
picture asks for, and the figure grows with what stands around them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .metrics import LEADING, folded, height, width
from .style import TEXT, WIDTH, legend_size
from .ticks import GAP, INCH, TICK, TICK_TEXT, draw_ticks, is_labelled, is_on_top, ticks_of

WHOLE = WIDTH * INCH
EDGE = 4.0  # free at every edge of the figure [pt]
BETWEEN = 12.0  # panels: half a tick label of each [pt]


@dataclass(frozen=True)
class Around:
    """What a panel needs above and below it [pt]: to the middle of the gap."""

    above: float
    below: float


def place(figure: Figure, axes: Sequence[Axes], heights: Sequence[float]) -> None:
    """Give a figure its height, and what stands on it its place.

    Parameters
    ----------
    figure : Figure
        Of the width of the house, without title.
    axes : sequence of Axes
        Its panels, drawn, from the top.
    heights : sequence of float
        Of the panels [in].
    """
    tall = [INCH * one for one in heights]
    for ax, high in zip(axes, tall, strict=True):
        ax.yaxis.label.set_text(folded(ax.get_ylabel(), TEXT, high + BETWEEN))
        ax.xaxis.label.set_text(folded(ax.get_xlabel(), TEXT, WHOLE * 0.7))
    legend = legend_size(axes[-1])
    around = [_around(ax) for ax in axes]
    gaps = [max(a.below + b.above, BETWEEN) for a, b in pairwise(around)]
    under = around[-1].below + (GAP + legend[1] if legend[1] else 0.0) + EDGE
    whole = around[0].above + EDGE + sum(tall) + sum(gaps) + under
    figure.set_size_inches(WIDTH, whole / INCH)
    bottoms = [under + sum(tall[i + 1 :]) + sum(gaps[i:]) for i in range(len(tall))]
    left = _across(axes, [(bottom / whole, high / whole) for bottom, high in zip(bottoms, tall, strict=True)])
    _put_legend(figure, axes[-1], min(left, WHOLE - EDGE - legend[0]), under - around[-1].below - GAP, whole)


def _around(ax: Axes) -> Around:
    label, title = height(ax.get_xlabel(), TEXT), height(ax.get_title(loc="left"), TICK_TEXT)
    ticks = TICK + LEADING * TICK_TEXT if is_labelled(ax.xaxis) else 0.0
    both = ticks + (GAP + label if label else 0.0)
    half = LEADING * TICK_TEXT / 2.0
    title += GAP if title else 0.0
    return Around(title + both, half) if is_on_top(ax.xaxis) else Around(max(title, half), max(both, half))


def _across(axes: Sequence[Axes], rows: Sequence[tuple[float, float]]) -> float:
    """Set the panels between their tick labels and the right edge; return where they begin [pt]."""
    for ax, (bottom, high) in zip(axes, rows, strict=True):
        ax.set_position((0.15, bottom, 0.8, high))
    upright = [ticks_of(ax.yaxis) for ax in axes]
    level = [ticks_of(ax.xaxis) for ax in axes]
    widest = max(width(label, TICK_TEXT) for _, labels in upright for label in (*labels, ""))
    label = max(height(ax.get_ylabel(), TEXT) for ax in axes)
    left = EDGE + label + GAP + widest + TICK
    right = max(2.0 * EDGE, *(width(label, TICK_TEXT) / 2.0 + 1.0 for _, labels in level for label in labels[-1:]), 0.0)
    for ax, (bottom, high), x, y in zip(axes, rows, level, upright, strict=True):
        ax.set_position((left / WHOLE, bottom, (WHOLE - left - right) / WHOLE, high))
        draw_ticks(ax.xaxis, x, LEADING * TICK_TEXT)
        draw_ticks(ax.yaxis, y, widest)
    return left


def _put_legend(figure: Figure, ax: Axes, left: float, top: float, whole: float) -> None:
    legend = ax.get_legend()
    if legend is not None:
        place = (max(left, EDGE) / WHOLE, top / whole)
        legend.set_bbox_to_anchor(place, transform=figure.transFigure)
