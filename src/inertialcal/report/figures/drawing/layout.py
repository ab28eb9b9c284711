"""Places of panels, labels and legend on a figure of a page, reckoned from its texts before anything is drawn.

A page has dozens of figures. To find room by drawing, as layouts for any figure do, takes longer than the figure
itself; here all is known: the size of the font, the labels, the rows of the legend. Panels have the height that the
picture asks for, and the figure grows with what stands around them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from .metrics import LEADING, folded, height, shortened, width
from .style import COLOURS, TEXT, legend_size

INCH = 72.0  # [pt]
MARK, PAD = 3.5, 3.5  # length of a tick, and the gap to its label [pt]
EDGE = 4.0  # free at every edge of the figure [pt]
BETWEEN = 12.0  # panels: half a tick label of each [pt]
TICK = MARK + PAD
GAP = 4.0  # between tick labels, label and legend [pt]
TICK_TEXT = TEXT - 1.0
MOST_TICKS = 6  # but one, of a linear axis
LONGEST = 200.0  # width of a label [pt]
BEHIND = 0.5  # order of drawing: under the data
Ticks = tuple[Sequence[float], Sequence[str]]


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
        Of the width that it is to have, without title.
    axes : sequence of Axes
        Its panels, drawn, from the top.
    heights : sequence of float
        Of the panels [in].
    """
    tall = [INCH * one for one in heights]
    broad = figure.get_figwidth() * INCH
    for ax, high in zip(axes, tall, strict=True):
        ax.yaxis.label.set_text(folded(ax.get_ylabel(), TEXT, high + BETWEEN))
        ax.xaxis.label.set_text(folded(ax.get_xlabel(), TEXT, broad * 0.7))
    legend = legend_size(axes[-1])
    around = [_around(ax) for ax in axes]
    gaps = [max(a.below + b.above, BETWEEN) for a, b in pairwise(around)]
    under = around[-1].below + (GAP + legend[1] if legend[1] else 0.0) + EDGE
    whole = around[0].above + EDGE + sum(tall) + sum(gaps) + under
    figure.set_size_inches(broad / INCH, whole / INCH)
    bottoms = [under + sum(tall[i + 1 :]) + sum(gaps[i:]) for i in range(len(tall))]
    left = _across(axes, broad, [(bottom / whole, high / whole) for bottom, high in zip(bottoms, tall, strict=True)])
    _put_legend(figure, axes[-1], min(left, broad - EDGE - legend[0]), under - around[-1].below - GAP, whole)


def _around(ax: Axes) -> Around:
    label, title = height(ax.get_xlabel(), TEXT), height(ax.get_title(loc="left"), TICK_TEXT)
    ticks = TICK + LEADING * TICK_TEXT if is_labelled(ax.xaxis) else 0.0
    both = ticks + (GAP + label if label else 0.0)
    half = LEADING * TICK_TEXT / 2.0
    title += GAP if title else 0.0
    return Around(title + both, half) if is_on_top(ax.xaxis) else Around(max(title, half), max(both, half))


def _across(axes: Sequence[Axes], broad: float, rows: Sequence[tuple[float, float]]) -> float:
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
        ax.set_position((left / broad, bottom, (broad - left - right) / broad, high))
        draw_ticks(ax.xaxis, _legible(ax, x, broad) if ax.get_xscale() == "symlog" else x, LEADING * TICK_TEXT)
        draw_ticks(ax.yaxis, y, widest)
    return left


def _legible(ax: Axes, ticks: Ticks, broad: float) -> Ticks:
    """Return ticks over decades of both signs; of labels that would touch, the one nearer to zero is left out."""
    places, labels = list(ticks[0]), list(ticks[1])
    if not places:
        return ticks
    shares = ax.transAxes.inverted().transform(ax.get_xaxis_transform().transform([(one, 0.0) for one in places]))[:, 0]
    at = shares * ax.get_position().width * broad
    first = sorted(range(len(places)), key=lambda i: (places[i] != 0.0, -abs(places[i])))  # zero, then the largest
    kept: list[int] = []
    for i in first:
        if all(
            abs(at[i] - at[k]) >= (width(labels[i], TICK_TEXT) + width(labels[k], TICK_TEXT)) / 2.0 + GAP for k in kept
        ):
            kept.append(i)
    return places, [label if i in kept else "" for i, label in enumerate(labels)]


def _put_legend(figure: Figure, ax: Axes, left: float, top: float, whole: float) -> None:
    legend = ax.get_legend()
    if legend is not None:
        place = (max(left, EDGE) / (figure.get_figwidth() * INCH), top / whole)
        legend.set_bbox_to_anchor(place, transform=figure.transFigure)


@dataclass(frozen=True)
class Side:
    """Where an axis has its labels, in shares of its panel, and which way is out."""

    x: float
    y: float
    out: tuple[float, float]
    ha: str
    va: str
    mark: Literal[0, 2, 3]
    turned: float


BOTTOM = Side(0.5, 0.0, (0.0, -1.0), "center", "top", 3, 0.0)  # marks: TICKDOWN, TICKLEFT of matplotlib


TOP = Side(0.5, 1.0, (0.0, 1.0), "center", "bottom", 2, 0.0)


LEFT = Side(0.0, 0.5, (-1.0, 0.0), "right", "center_baseline", 0, 90.0)


def is_on_top(axis: Axis) -> bool:
    """Return whether the labels of an axis stand above its panel."""
    return axis.get_label_position() == "top"


def is_labelled(axis: Axis) -> bool:
    """Return whether an axis shows the labels of its ticks."""
    shown = axis.get_tick_params()
    return bool(shown.get("labelbottom", True) or shown.get("labeltop", False))


def count(axis: Axis) -> None:
    """Tick an axis of numbers in order at whole numbers."""
    axis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))


def ticks_of(axis: Axis) -> Ticks:
    """Return the places of the ticks that are seen, and their labels; none where an axis shows none."""
    if not is_labelled(axis):
        return (), ()
    if isinstance(locator := axis.get_major_locator(), MaxNLocator):
        locator.set_params(nbins=MOST_TICKS)
    low, high = sorted(axis.get_view_interval())
    places = axis.get_majorticklocs().tolist()
    labels = axis.get_major_formatter().format_ticks(places)
    seen = [
        (place, shortened(label, TICK_TEXT, LONGEST))
        for place, label in zip(places, labels, strict=True)
        if low <= place <= high
    ]
    return [place for place, _ in seen], [label for _, label in seen]


def draw_ticks(axis: Axis, ticks: Ticks, room: float) -> None:
    """Draw ticks, their labels and the label of the axis, instead of the axis itself.

    Parameters
    ----------
    axis : Axis
        Whose; it is hidden.
    ticks : tuple
        Places and labels.
    room : float
        From the panel outwards, what the labels of ticks take. [pt]
    """
    axis.set_visible(False)
    ax = axis.axes
    side = LEFT if axis is ax.yaxis else TOP if is_on_top(axis) else BOTTOM
    _marks(ax, axis, ticks[0], side)
    along = ax.get_yaxis_transform() if side is LEFT else ax.get_xaxis_transform()
    size = axis.get_tick_params().get("labelsize", TICK_TEXT)
    for place, label in zip(*ticks, strict=True):
        x, y = (side.x, place) if side is LEFT else (place, side.y)
        ax.text(
            x, y, label, transform=along + _away(ax, side, TICK), ha=side.ha, va=side.va, size=size,
            parse_math=False, zorder=BEHIND, clip_on=False,
        )  # fmt: skip
    beyond = TICK + room + GAP if ticks[0] else GAP
    if axis.label.get_text():
        ax.text(
            side.x, side.y, axis.label.get_text(), transform=ax.transAxes + _away(ax, side, beyond), ha="center",
            va="bottom" if side is LEFT else side.va, rotation=side.turned, rotation_mode="anchor",
            size=TEXT, parse_math=False, zorder=BEHIND, clip_on=False,
        )  # fmt: skip


def _marks(ax: Axes, axis: Axis, places: Sequence[float], side: Side) -> None:
    """Draw the marks of all ticks as one line of markers, unless they have no length."""
    if not places or not axis.get_tick_params().get("length", MARK):
        return
    across = [side.x if side is LEFT else side.y] * len(places)
    along = ax.get_yaxis_transform() if side is LEFT else ax.get_xaxis_transform()
    x, y = (across, places) if side is LEFT else (places, across)
    ax.add_artist(
        Line2D(
            x,
            y,
            transform=along,
            linestyle="none",
            marker=side.mark,
            markersize=MARK,
            markeredgewidth=0.8,
            color=COLOURS["quiet"],
            zorder=BEHIND,
            clip_on=False,
        )
    )


def _away(ax: Axes, side: Side, points: float) -> ScaledTranslation:
    x, y = side.out
    scale = ax.figure.dpi_scale_trans
    return ScaledTranslation(points / INCH * x, points / INCH * y, scale)
